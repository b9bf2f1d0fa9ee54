//! Symmetric pairs (K, M) that solvers fail on: slender, graded, clustered, repeated and zero
//! eigenvalues.

use modalign::linalg::{RealMatrix, real_matrix};

/// A pair with the number of its rigid-body modes.
pub struct Specimen {
    pub name: String,
    pub stiffness: RealMatrix,
    pub mass: RealMatrix,
    pub rigid: usize,
}

impl Specimen {
    fn new(name: String, (stiffness, mass): (RealMatrix, RealMatrix), rigid: usize) -> Self {
        Self {
            name,
            stiffness,
            mass,
            rigid,
        }
    }

    pub fn size(&self) -> usize {
        self.mass.nrows()
    }
}

/// How the ends of a beam are held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ends {
    Free,
    Clamped,
    Pinned,
    /// Clamped at one end, free at the other.
    Cantilever,
    /// Free on two equal springs at its ends that give this frequency with the mass of the beam,
    /// Hz.
    Suspended(f64),
}

/// Numbers without a pattern from -1 to 1.
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^= z >> 31;
        (z >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

const LENGTH_M: f64 = 0.6;
const BENDING_N_M2: f64 = 2.1e11 * 2.5e-9;
const MASS_KG_PER_M: f64 = 7850.0 * 3.0e-4;

/// The specimens of at most this many coordinates.
pub fn zoo(largest: usize) -> Vec<Specimen> {
    let mut all = Vec::new();
    for elements in [1, 2, 10, 40, 65, 80, 100, 150, 250, 500, 999] {
        add(&mut all, largest, 2 * elements + 2, || {
            Specimen::new(
                format!("free beam, {elements} elements"),
                beam(elements, Ends::Free),
                2,
            )
        });
    }
    for (elements, ends, size) in [
        (2, Ends::Clamped, 2),
        (66, Ends::Clamped, 130),
        (300, Ends::Clamped, 598),
        (100, Ends::Pinned, 200),
        (70, Ends::Cantilever, 140),
        (400, Ends::Cantilever, 800),
        (1000, Ends::Cantilever, 2000),
        (20, Ends::Suspended(0.1), 42),
        (100, Ends::Suspended(0.1), 202),
        (200, Ends::Suspended(2.0), 402),
        (500, Ends::Suspended(0.1), 1002),
    ] {
        add(&mut all, largest, size, || {
            let name = format!("beam {ends:?}, {elements} elements");
            Specimen::new(name, beam(elements, ends), 0)
        });
    }
    for (bays, storeys, parts) in [(1, 1, 3), (2, 3, 4), (3, 5, 6), (4, 10, 6)] {
        for held in [true, false] {
            let size = frame_size(bays, storeys, parts, held);
            add(&mut all, largest, size, || {
                let name = format!("frame {bays} x {storeys}, {parts} elements, held {held}");
                let rigid = if held { 0 } else { 3 };
                Specimen::new(name, frame(bays, storeys, parts, held), rigid)
            });
        }
    }
    for (nx, ny, aspect, ends) in [
        (3, 3, 1.0, Ends::Free),
        (6, 6, 1.0, Ends::Free),
        (10, 10, 1.0, Ends::Free),
        (15, 14, 1.0, Ends::Free),
        (6, 6, 1.0, Ends::Clamped),
        (16, 16, 1.0, Ends::Clamped),
        (60, 2, 20.0, Ends::Free),
        (80, 2, 20.0, Ends::Cantilever),
    ] {
        let (x, y) = (beam_size(nx, ends), beam_size(ny, ends));
        add(&mut all, largest, x * y, || {
            let name = format!("plate {ends:?}, {nx} x {ny}, aspect {aspect}");
            // 1, x and y have no strain.
            let rigid = if ends == Ends::Free { 3 } else { 0 };
            Specimen::new(name, plate(nx, ny, aspect, ends), rigid)
        });
    }
    for (cells, held) in [
        ([2, 2, 2], false),
        ([3, 3, 3], false),
        ([5, 5, 5], true),
        ([20, 1, 1], false),
        ([60, 1, 1], true),
        ([40, 2, 2], false),
        ([7, 7, 7], false),
    ] {
        let nodes = (cells[0] + usize::from(!held)) * (cells[1] + 1) * (cells[2] + 1);
        add(&mut all, largest, 3 * nodes, || {
            let name = format!("solid {cells:?}, held {held}");
            Specimen::new(name, solid(cells, held), if held { 0 } else { 6 })
        });
    }
    for (masses, spread, closed) in [
        (2, 1.0, false),
        (3, 1.0, true),
        (50, 1.0, false),
        (129, 1.0, true),
        (300, 1e8, false),
        (700, 1.0, true),
        (2000, 1.0, false),
    ] {
        add(&mut all, largest, masses, || {
            let name =
                format!("free chain of {masses}, stiffnesses over {spread:e}, closed {closed}");
            Specimen::new(name, chain(masses, spread, closed), 1)
        });
    }
    for (planets, size) in [(3, 5), (5, 7), (40, 42), (200, 202)] {
        add(&mut all, largest, size, || {
            let name = format!("torsional planetary gear, {planets} planets");
            Specimen::new(name, planetary(planets), 1)
        });
    }
    for (size, decades) in [
        (20, 12.0),
        (129, 12.0),
        (300, 12.0),
        (700, 12.0),
        (1000, 6.0),
    ] {
        add(&mut all, largest, size, || {
            let name = format!("graded over {decades} decades, {size}");
            Specimen::new(name, graded(size, decades), 0)
        });
    }
    for (size, spread) in [(40, 1e-10), (150, 1e-12), (400, 1e-8)] {
        add(&mut all, largest, size, || {
            Specimen::new(
                format!("clusters of {spread:e}, {size}"),
                clusters(size, spread),
                0,
            )
        });
    }
    for (copies, size) in [(1, 21), (1, 201), (7, 147), (40, 840)] {
        add(&mut all, largest, size, || {
            let name = format!("Wilkinson, {copies} glued, {size}");
            Specimen::new(name, wilkinson(size / copies, copies), 0)
        });
    }
    for size in [8, 136] {
        add(&mut all, largest, size, || {
            Specimen::new(
                format!("stiff and soft springs side by side, {size}"),
                kabe(size / 8),
                0,
            )
        });
    }
    for size in [10, 128, 129, 250, 500] {
        add(&mut all, largest, size, || {
            Specimen::new(format!("random, {size}"), random(size), 0)
        });
    }
    for factor in [1e-150, 1e-15, 1e9, 1e15, 1e150] {
        add(&mut all, largest, 200, || {
            let (k, m) = random(200);
            let k = real_matrix(200, 200, |i, j| k[(i, j)] * factor);
            Specimen::new(format!("random, 200, entries of {factor:e}"), (k, m), 0)
        });
    }
    all
}

fn add(all: &mut Vec<Specimen>, largest: usize, size: usize, build: impl FnOnce() -> Specimen) {
    if size <= largest {
        let specimen = build();
        assert_eq!(specimen.size(), size, "{}", specimen.name);
        all.push(specimen);
    }
}

fn zeros(n: usize) -> RealMatrix {
    real_matrix(n, n, |_, _| 0.0)
}

/// Element matrices of bending (Hermite, consistent mass): stiffness per EI, mass per rho A.
fn bending_element(h: f64) -> ([[f64; 4]; 4], [[f64; 4]; 4]) {
    let stiffness = [
        [12.0, 6.0 * h, -12.0, 6.0 * h],
        [6.0 * h, 4.0 * h * h, -6.0 * h, 2.0 * h * h],
        [-12.0, -6.0 * h, 12.0, -6.0 * h],
        [6.0 * h, 2.0 * h * h, -6.0 * h, 4.0 * h * h],
    ];
    let mass = [
        [156.0, 22.0 * h, 54.0, -13.0 * h],
        [22.0 * h, 4.0 * h * h, 13.0 * h, -3.0 * h * h],
        [54.0, 13.0 * h, 156.0, -22.0 * h],
        [-13.0 * h, -3.0 * h * h, -22.0 * h, 4.0 * h * h],
    ];
    let scaled = |of: [[f64; 4]; 4], by: f64| of.map(|row| row.map(|value| value * by));
    (scaled(stiffness, 1.0 / h.powi(3)), scaled(mass, h / 420.0))
}

fn beam_size(elements: usize, ends: Ends) -> usize {
    match ends {
        Ends::Free | Ends::Suspended(_) => 2 * elements + 2,
        Ends::Clamped => 2 * elements - 2,
        Ends::Pinned | Ends::Cantilever => 2 * elements,
    }
}

/// Steel bar of 600 mm x 30 mm x 10 mm in bending.
pub fn beam(elements: usize, ends: Ends) -> (RealMatrix, RealMatrix) {
    let (stiffness, mass) = bending_element(LENGTH_M / elements as f64);
    let n = 2 * elements + 2;
    let (mut k, mut m) = (zeros(n), zeros(n));
    for e in 0..elements {
        for i in 0..4 {
            for j in 0..4 {
                k[(2 * e + i, 2 * e + j)] += BENDING_N_M2 * stiffness[i][j];
                m[(2 * e + i, 2 * e + j)] += MASS_KG_PER_M * mass[i][j];
            }
        }
    }
    let kept: Vec<usize> = match ends {
        Ends::Free => (0..n).collect(),
        Ends::Suspended(hz) => {
            let omega = std::f64::consts::TAU * hz;
            let spring = 0.5 * MASS_KG_PER_M * LENGTH_M * omega * omega;
            k[(0, 0)] += spring;
            k[(n - 2, n - 2)] += spring;
            (0..n).collect()
        }
        Ends::Clamped => (2..n - 2).collect(),
        Ends::Pinned => (1..n).filter(|&i| i != n - 2).collect(),
        Ends::Cantilever => (2..n).collect(),
    };
    (chosen(&k, &kept), chosen(&m, &kept))
}

fn chosen(a: &RealMatrix, kept: &[usize]) -> RealMatrix {
    real_matrix(kept.len(), kept.len(), |i, j| a[(kept[i], kept[j])])
}

fn frame_size(bays: usize, storeys: usize, parts: usize, held: bool) -> usize {
    let joints = (bays + 1) * (storeys + 1);
    let members = (bays + 1) * storeys + bays * storeys;
    let held = if held { bays + 1 } else { 0 };
    3 * (joints + members * (parts - 1) - held)
}

/// Plane frame of columns and girders, each of so many elements in bending and extension.
fn frame(bays: usize, storeys: usize, parts: usize, held: bool) -> (RealMatrix, RealMatrix) {
    let joint = |x: usize, y: usize| y * (bays + 1) + x;
    let mut nodes = (bays + 1) * (storeys + 1);
    let mut members = Vec::new();
    for y in 0..storeys {
        members.extend((0..=bays).map(|x| (joint(x, y), joint(x, y + 1), false)));
        members.extend((0..bays).map(|x| (joint(x, y + 1), joint(x + 1, y + 1), true)));
    }
    let mut elements = Vec::new();
    for &(from, to, level) in &members {
        let mut last = from;
        for part in 1..=parts {
            let next = if part == parts {
                to
            } else {
                nodes += 1;
                nodes - 1
            };
            elements.push((last, next, level));
            last = next;
        }
    }
    let (mut k, mut m) = (zeros(3 * nodes), zeros(3 * nodes));
    for &(from, to, level) in &elements {
        add_frame_element(&mut k, &mut m, [from, to], (3.0 / parts as f64, level));
    }
    let first = if held { bays + 1 } else { 0 };
    let kept: Vec<usize> = (3 * first..3 * nodes).collect();
    (chosen(&k, &kept), chosen(&m, &kept))
}

fn add_frame_element(
    k: &mut RealMatrix,
    m: &mut RealMatrix,
    ends: [usize; 2],
    (h, level): (f64, bool),
) {
    let (bending, inertia) = bending_element(h);
    let (ei, ea, mass) = (4.2e6, 8.4e8, 31.4);
    // Translations across and along the member, and the sense of the rotation.
    let (across, along, turn) = if level { (1, 0, 1.0) } else { (0, 1, -1.0) };
    let places = [
        (3 * ends[0] + across, 1.0),
        (3 * ends[0] + 2, turn),
        (3 * ends[1] + across, 1.0),
        (3 * ends[1] + 2, turn),
    ];
    for (i, &(row, a)) in places.iter().enumerate() {
        for (j, &(column, b)) in places.iter().enumerate() {
            k[(row, column)] += a * b * ei * bending[i][j];
            m[(row, column)] += a * b * mass * inertia[i][j];
        }
    }
    for i in 0..2 {
        for j in 0..2 {
            let (row, column) = (3 * ends[i] + along, 3 * ends[j] + along);
            let same = i == j;
            k[(row, column)] += if same { ea / h } else { -ea / h };
            m[(row, column)] += mass * h / if same { 3.0 } else { 6.0 };
        }
    }
}

/// `int w'' w''`, `int w' w'` and `int w w` of a unit beam of Hermite elements.
fn hermite(elements: usize, length: f64, ends: Ends) -> [RealMatrix; 3] {
    let h = length / elements as f64;
    let (bending, mass) = bending_element(h);
    let slope = [
        [36.0, 3.0 * h, -36.0, 3.0 * h],
        [3.0 * h, 4.0 * h * h, -3.0 * h, -h * h],
        [-36.0, -3.0 * h, 36.0, -3.0 * h],
        [3.0 * h, -h * h, -3.0 * h, 4.0 * h * h],
    ]
    .map(|row| row.map(|value| value / (30.0 * h)));
    let n = 2 * elements + 2;
    let kept: Vec<usize> = match ends {
        Ends::Clamped => (2..n - 2).collect(),
        Ends::Cantilever => (2..n).collect(),
        _ => (0..n).collect(),
    };
    [bending, slope, mass].map(|element| {
        let mut whole = zeros(n);
        for e in 0..elements {
            for i in 0..4 {
                for j in 0..4 {
                    whole[(2 * e + i, 2 * e + j)] += element[i][j];
                }
            }
        }
        chosen(&whole, &kept)
    })
}

/// Thin rectangular plate of Bogner, Fox and Schmit elements without Poisson's ratio:
/// `w_xx^2 + 2 w_xy^2 + w_yy^2`.
fn plate(nx: usize, ny: usize, aspect: f64, ends: Ends) -> (RealMatrix, RealMatrix) {
    let [bx, sx, mx] = hermite(nx, aspect, ends);
    let [by, sy, my] = hermite(ny, 1.0, ends);
    let size = my.nrows();
    let n = mx.nrows() * size;
    let product = |a: &RealMatrix, b: &RealMatrix, i: usize, j: usize| {
        a[(i / size, j / size)] * b[(i % size, j % size)]
    };
    let k = real_matrix(n, n, |i, j| {
        product(&bx, &my, i, j) + 2.0 * product(&sx, &sy, i, j) + product(&mx, &by, i, j)
    });
    (k, real_matrix(n, n, |i, j| product(&mx, &my, i, j)))
}

/// Block of trilinear elements, of unit cells, Poisson's ratio 0.3; held at one end.
fn solid(cells: [usize; 3], held: bool) -> (RealMatrix, RealMatrix) {
    let (stiffness, mass) = brick();
    let node = |x: usize, y: usize, z: usize| (x * (cells[1] + 1) + y) * (cells[2] + 1) + z;
    let n = 3 * node(cells[0], cells[1], cells[2]) + 3;
    let (mut k, mut m) = (zeros(n), zeros(n));
    for x in 0..cells[0] {
        for y in 0..cells[1] {
            for z in 0..cells[2] {
                let corner = |c: usize| node(x + (c & 1), y + (c >> 1 & 1), z + (c >> 2));
                let place = |i: usize| 3 * corner(i / 3) + i % 3;
                for i in 0..24 {
                    for j in 0..24 {
                        k[(place(i), place(j))] += stiffness[i][j];
                        m[(place(i), place(j))] += mass[i][j];
                    }
                }
            }
        }
    }
    let first = if held {
        3 * (cells[1] + 1) * (cells[2] + 1)
    } else {
        0
    };
    let kept: Vec<usize> = (first..n).collect();
    (chosen(&k, &kept), chosen(&m, &kept))
}

/// Stiffness and mass of a unit cube by two Gauss points to each side, `E = 2.1e11`, `rho = 7850`.
fn brick() -> ([[f64; 24]; 24], [[f64; 24]; 24]) {
    let (e, nu, rho) = (2.1e11, 0.3, 7850.0);
    let (lambda, mu) = (
        e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)),
        e / (2.0 * (1.0 + nu)),
    );
    let (mut k, mut m) = ([[0.0; 24]; 24], [[0.0; 24]; 24]);
    let gauss = [0.5 - 0.5 / 3f64.sqrt(), 0.5 + 0.5 / 3f64.sqrt()];
    for point in 0..8 {
        let at = [gauss[point & 1], gauss[point >> 1 & 1], gauss[point >> 2]];
        let shape = |c: usize| -> f64 {
            (0..3)
                .map(|d| if c >> d & 1 == 1 { at[d] } else { 1.0 - at[d] })
                .product()
        };
        let slope = |c: usize, along: usize| -> f64 {
            let factor = |d: usize| match (d == along, c >> d & 1 == 1) {
                (true, true) => 1.0,
                (true, false) => -1.0,
                (false, true) => at[d],
                (false, false) => 1.0 - at[d],
            };
            (0..3).map(factor).product()
        };
        for i in 0..24 {
            for j in 0..24 {
                let (a, b, r, s) = (i / 3, j / 3, i % 3, j % 3);
                let mut density =
                    lambda * slope(a, r) * slope(b, s) + mu * slope(a, s) * slope(b, r);
                if r == s {
                    density += mu * (0..3).map(|d| slope(a, d) * slope(b, d)).sum::<f64>();
                    m[i][j] += rho * shape(a) * shape(b) / 8.0;
                }
                k[i][j] += density / 8.0;
            }
        }
    }
    // Symmetric to the last bit.
    let symmetric = std::array::from_fn(|i| std::array::from_fn(|j| k[i.min(j)][i.max(j)]));
    (symmetric, m)
}

/// Unit masses on springs that grow over a spread; closed to a ring.
fn chain(masses: usize, spread: f64, closed: bool) -> (RealMatrix, RealMatrix) {
    let mut k = zeros(masses);
    let springs = if closed && masses > 2 {
        masses
    } else {
        masses - 1
    };
    for s in 0..springs {
        let (i, j) = (s, (s + 1) % masses);
        let stiffness = spread.powf(s as f64 / springs as f64);
        k[(i, i)] += stiffness;
        k[(j, j)] += stiffness;
        k[(i, j)] -= stiffness;
        k[(j, i)] -= stiffness;
    }
    (
        k,
        real_matrix(masses, masses, |i, j| f64::from(u8::from(i == j))),
    )
}

/// Sun, carrier and equal planets, ring held: rotations, in kg and N/m at the base circles. Free to
/// run.
fn planetary(planets: usize) -> (RealMatrix, RealMatrix) {
    let n = planets + 2;
    let (sun_mesh, ring_mesh) = (2.1e8, 2.6e8);
    let mut k = zeros(n);
    for p in 2..n {
        // Sun mesh: sun + planet - 2 carrier; ring mesh: planet - ring with the carrier.
        for (signs, mesh) in [
            ([(0, 1.0), (p, 1.0), (1, -1.0)], sun_mesh),
            ([(p, 1.0), (1, 1.0), (1, 0.0)], ring_mesh),
        ] {
            for (i, a) in signs {
                for (j, b) in signs {
                    k[(i, j)] += a * b * mesh;
                }
            }
        }
    }
    let mass = |i: usize| [0.4, 5.4][..].get(i).copied().unwrap_or(0.6);
    (
        k,
        real_matrix(n, n, |i, j| if i == j { mass(i) } else { 0.0 }),
    )
}

/// `D R D` of a well-conditioned R and a D that spans half the decades.
pub fn graded(size: usize, decades: f64) -> (RealMatrix, RealMatrix) {
    let mut random = Random(size as u64);
    let d: Vec<f64> = (0..size)
        .map(|i| 10f64.powf(-0.5 * decades * i as f64 / (size - 1) as f64))
        .collect();
    let mut k = zeros(size);
    for i in 0..size {
        for j in 0..i {
            let value = 0.4 / (1.0 + (i - j) as f64).powi(2) * random.next() * d[i] * d[j];
            k[(i, j)] = value;
            k[(j, i)] = value;
        }
        k[(i, i)] = d[i] * d[i];
    }
    (
        k,
        real_matrix(size, size, |i, j| f64::from(u8::from(i == j))),
    )
}

/// Ten clusters, each spread over a part of its eigenvalue.
fn clusters(size: usize, spread: f64) -> (RealMatrix, RealMatrix) {
    let value = |i: usize| (1.0 + (i % 10) as f64).powi(3) * (1.0 + spread * (i / 10) as f64);
    let values: Vec<f64> = (0..size).map(value).collect();
    (
        turned(&values, 7 + size as u64),
        real_matrix(size, size, |i, j| f64::from(u8::from(i == j))),
    )
}

/// A matrix of these eigenvalues: their diagonal turned by three Householder reflections.
pub fn turned(values: &[f64], seed: u64) -> RealMatrix {
    let (size, mut random) = (values.len(), Random(seed));
    let mut k = real_matrix(size, size, |i, j| if i == j { values[i] } else { 0.0 });
    for _ in 0..3 {
        let v: Vec<f64> = (0..size).map(|_| random.next()).collect();
        let norm: f64 = v.iter().map(|x| x * x).sum();
        // H K H with H = I - 2 v v^T / (v^T v).
        let p: Vec<f64> = (0..size)
            .map(|i| 2.0 / norm * (0..size).map(|j| k[(i, j)] * v[j]).sum::<f64>())
            .collect();
        let c = (0..size).map(|i| v[i] * p[i]).sum::<f64>() / norm;
        let w: Vec<f64> = (0..size).map(|i| p[i] - c * v[i]).collect();
        for i in 0..size {
            for j in 0..=i {
                k[(i, j)] -= v[i] * w[j] + w[i] * v[j];
                k[(j, i)] = k[(i, j)];
            }
        }
    }
    k
}

/// Wilkinson's W+ of odd size, moved by 2 to be positive definite; copies joined by 1e-8.
fn wilkinson(size: usize, copies: usize) -> (RealMatrix, RealMatrix) {
    let n = size * copies;
    let k = real_matrix(n, n, |i, j| match i.abs_diff(j) {
        0 => ((i % size) as f64 - (size / 2) as f64).abs() + 2.0,
        1 if i / size == j / size => 1.0,
        1 => 1e-8,
        _ => 0.0,
    });
    (k, real_matrix(n, n, |i, j| f64::from(u8::from(i == j))))
}

/// Eight masses of 0.001 to 1 on springs of 1.5 to 1000, in the manner of Kabe (1985), Stiffness
/// matrix adjustment using mode data, AIAA J. 23; blocks joined by soft springs.
fn kabe(blocks: usize) -> (RealMatrix, RealMatrix) {
    let n = 8 * blocks;
    let mut k = zeros(n);
    let mut spring = |i: usize, j: Option<usize>, value: f64| {
        k[(i, i)] += value;
        if let Some(j) = j {
            k[(j, j)] += value;
            k[(i, j)] -= value;
            k[(j, i)] -= value;
        }
    };
    for b in (0..n).step_by(8) {
        for (i, j, value) in [
            (0, 1, 1.5),
            (1, 2, 10.0),
            (1, 4, 1000.0),
            (2, 4, 100.0),
            (2, 5, 1000.0),
            (3, 4, 100.0),
            (3, 6, 1000.0),
            (5, 6, 100.0),
            (6, 7, 2.0),
        ] {
            spring(b + i, Some(b + j), value);
        }
        spring(b + 4, None, 900.0);
        if b > 0 {
            spring(b, Some(b - 1), 1e-3);
        }
    }
    let mass = [0.001, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.002];
    (
        k,
        real_matrix(n, n, |i, j| if i == j { mass[i % 8] } else { 0.0 }),
    )
}

/// Dense and positive definite, with a mass matrix of the same kind.
pub fn random(size: usize) -> (RealMatrix, RealMatrix) {
    let mut random = Random(3 + size as u64);
    let mut definite = |weight: f64| {
        let mut a = zeros(size);
        for i in 0..size {
            for j in 0..i {
                let value = random.next() / (size as f64).sqrt();
                a[(i, j)] = value;
                a[(j, i)] = value;
            }
            a[(i, i)] = weight;
        }
        a
    };
    (definite(1.3), definite(3.0))
}
