//! The sensor set is the fewest sensors at which the modes of a band have a diagonal AutoMAC.

use num_complex::Complex64;

use crate::axis::Band;
use crate::dof::Dof;
use crate::modal::ModalModel;

use super::measures::ModeName;
use super::model_roots::elastic_roots;
use super::observability::NODE_FRACTION_OF_LARGEST;

/// Minimum mean square of a mode at the sensors, over that at all candidates. Larger, at 0.5:
/// sensors for local modes only. Smaller, at 0: sensors at the nodes of a mode, whose readings are
/// noise. Test `sensors_at_nodes_of_a_mode_are_no_set`.
const MIN_MOTION_OVER_MEAN: f64 = 0.1;

/// Maximum number of candidates that are also removed one by one from all, and exchanged.
const MAX_CANDIDATES_OF_REMOVAL: usize = 300;

/// Maximum number of smaller sets that are all tried.
const MAX_TRIED_SETS: f64 = 20_000.0;

/// Sensors whose AutoMAC is below a limit outside its diagonal.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorSet {
    /// The sensors, ascending; all candidates where no set meets the limit.
    pub sensors: Vec<Dof>,
    /// The elastic modes of the band.
    pub modes: Vec<ModeName>,
    /// Their AutoMAC at the sensors.
    pub auto_mac: Vec<Vec<f64>>,
    /// Largest value between modes of different roots.
    pub largest: f64,
    /// Indices in `modes` of the two with the largest value.
    pub largest_at: [usize; 2],
    /// Limit of the largest value.
    pub limit: f64,
    /// Number of candidates.
    pub candidates: usize,
    /// Modes of the band that move no candidate; they are not compared.
    pub at_nodes: Vec<ModeName>,
}

impl SensorSet {
    /// Whether the largest value is within the limit.
    pub fn is_met(&self) -> bool {
        self.largest <= self.limit
    }
}

/// The fewest of the candidates at which no two modes of different roots in the band have a MAC
/// above `limit`, and each mode has at least a tenth of its mean square at all candidates.
///
/// Candidates are added one by one, each time the one that lowers the sum of the squared excesses
/// of MAC over the limit most, then those that are not needed are removed. With up to 300
/// candidates they are also removed one by one from all, and single sensors of smaller sets are
/// exchanged. Where few sets are smaller, all are tried; else the smallest set found is the result.
/// Rotations are no candidates beside translations. Modes that move no candidate are left out, and
/// modes of one root are not compared with each other. `None` for fewer than two roots, and without
/// a candidate at which all modes have values.
///
/// # Reference
/// Carne and Dohrmann (1995), A modal test design strategy for model correlation, IMAC 13 (MAC
/// outside the diagonal as the criterion); Allemang and Brown (1982), IMAC 1.
pub fn fewest_sensors(
    theory: &ModalModel,
    band: Option<Band>,
    candidates: &[Dof],
    limit: f64,
) -> Option<SensorSet> {
    let roots = elastic_roots(theory).into_iter();
    let roots: Vec<_> = roots
        .filter(|root| band.is_none_or(|band| band.contains(root.hz)))
        .collect();
    let modes = (roots.iter().enumerate())
        .flat_map(|(number, root)| root.modes.iter().map(move |mode| (*mode, number)));
    let (modes, root_of): (Vec<usize>, Vec<usize>) = modes.unzip();
    let has_translations = candidates.iter().any(|dof| !dof.axis().is_rotation());
    let row = |dof: &Dof| -> Option<(Dof, Vec<Complex64>)> {
        let shapes = modes.iter().map(|&mode| &theory.modes[mode].shape);
        let values: Option<Vec<Complex64>> =
            shapes.map(|shape| shape.along_positive(dof)).collect();
        Some((dof.clone(), values?))
    };
    let of_kind = |dof: &&Dof| !(has_translations && dof.axis().is_rotation());
    let known = candidates.iter().filter(of_kind).filter_map(row);
    let (dofs, rows): (Vec<Dof>, Vec<Vec<Complex64>>) = known.unzip();
    if dofs.is_empty() {
        return None;
    }
    let largest = |column: usize| {
        let values = rows.iter().map(|row| row[column].norm());
        values.fold(0.0, f64::max)
    };
    let of_all = (0..modes.len()).map(largest).fold(0.0, f64::max);
    let moves = |column: &usize| largest(*column) > NODE_FRACTION_OF_LARGEST * of_all;
    let (moving, still): (Vec<usize>, Vec<usize>) = (0..modes.len()).partition(moves);
    let named = |column: &usize| ModeName {
        mode: modes[*column] + 1,
        hz: theory.modes[modes[*column]].frequency_hz,
    };
    let names: Vec<ModeName> = moving.iter().map(named).collect();
    let at_nodes = still.iter().map(named).collect();
    let root_of: Vec<usize> = moving.iter().map(|&column| root_of[column]).collect();
    if root_of.first() == root_of.last() {
        return None;
    }
    let kept = |row: &Vec<Complex64>| moving.iter().map(|&column| row[column]).collect();
    let search = Search::new(rows.iter().map(kept).collect(), root_of, limit);
    let chosen = search.fewest();
    let sums = search.sums(&chosen);
    let (largest, largest_at) = search.largest(&sums);
    let count = names.len();
    let auto_mac = (0..count).map(|i| (0..count).map(|j| sums.mac(i, j)).collect());
    Some(SensorSet {
        sensors: chosen.iter().map(|&at| dofs[at].clone()).collect(),
        modes: names,
        auto_mac: auto_mac.collect(),
        largest,
        largest_at,
        limit,
        candidates: dofs.len(),
        at_nodes,
    })
}

/// Inner products of all modes at some sensors.
#[derive(Clone)]
struct Sums {
    products: Vec<Vec<Complex64>>,
    sensors: usize,
}

impl Sums {
    fn add(&mut self, row: &[Complex64], sign: f64) {
        for (products, a) in self.products.iter_mut().zip(row) {
            for (product, b) in products.iter_mut().zip(row) {
                *product += sign * a.conj() * b;
            }
        }
        self.sensors = match sign > 0.0 {
            true => self.sensors + 1,
            false => self.sensors - 1,
        };
    }

    /// MAC of two modes; 1 where one has no motion.
    fn mac(&self, i: usize, j: usize) -> f64 {
        let squares = self.products[i][i].re * self.products[j][j].re;
        match squares > 0.0 {
            true => (self.products[i][j].norm_sqr() / squares).min(1.0),
            false => 1.0,
        }
    }
}

/// Number of sets of some size among candidates.
fn binomial(count: usize, size: usize) -> f64 {
    (0..size).fold(1.0, |product, at| {
        product * (count - at) as f64 / (at + 1) as f64
    })
}

struct Search {
    /// Values of the modes at each candidate, each mode over its root mean square at all.
    rows: Vec<Vec<Complex64>>,
    /// Number of the root of each mode.
    root_of: Vec<usize>,
    limit: f64,
}

impl Search {
    fn new(mut rows: Vec<Vec<Complex64>>, root_of: Vec<usize>, limit: f64) -> Self {
        for mode in 0..root_of.len() {
            let squares: f64 = rows.iter().map(|row| row[mode].norm_sqr()).sum();
            let mean = (squares / rows.len() as f64).sqrt().max(f64::MIN_POSITIVE);
            rows.iter_mut().for_each(|row| row[mode] /= mean);
        }
        Self {
            rows,
            root_of,
            limit,
        }
    }

    fn sums(&self, chosen: &[usize]) -> Sums {
        let count = self.root_of.len();
        let mut sums = Sums {
            products: vec![vec![Complex64::ZERO; count]; count],
            sensors: 0,
        };
        chosen.iter().for_each(|&at| sums.add(&self.rows[at], 1.0));
        sums
    }

    /// Pairs of modes of different roots.
    fn pairs(&self) -> impl Iterator<Item = [usize; 2]> + '_ {
        let count = self.root_of.len();
        let pairs = (0..count).flat_map(move |i| (i + 1..count).map(move |j| [i, j]));
        pairs.filter(|[i, j]| self.root_of[*i] != self.root_of[*j])
    }

    /// The largest MAC between modes of different roots, with these.
    fn largest(&self, sums: &Sums) -> (f64, [usize; 2]) {
        let all = self.pairs().map(|[i, j]| (sums.mac(i, j), [i, j]));
        let largest = all.reduce(|a, b| if b.0 > a.0 { b } else { a });
        largest.unwrap_or((0.0, [0, 0]))
    }

    /// Mean square of a mode over that at all candidates.
    fn motion(&self, sums: &Sums, mode: usize) -> f64 {
        sums.products[mode][mode].re / sums.sensors.max(1) as f64
    }

    fn is_met(&self, sums: &Sums) -> bool {
        let moves = |mode: usize| self.motion(sums, mode) >= MIN_MOTION_OVER_MEAN;
        (0..self.root_of.len()).all(moves) && self.largest(sums).0 <= self.limit
    }

    /// Sum of the squared excesses of MAC over the limit, and of the squared lacks of motion.
    fn cost(&self, sums: &Sums) -> f64 {
        let excess = |[i, j]: [usize; 2]| (sums.mac(i, j) - self.limit).max(0.0).powi(2);
        let lack = |mode: usize| 1.0 - self.motion(sums, mode) / MIN_MOTION_OVER_MEAN;
        let lacks = (0..self.root_of.len()).map(|mode| lack(mode).max(0.0).powi(2));
        self.pairs().map(excess).sum::<f64>() + lacks.sum::<f64>()
    }

    /// The candidate whose addition or removal makes the cost smallest; the first of equal ones.
    fn best(&self, sums: &Sums, among: &[usize], sign: f64) -> Option<usize> {
        use rayon::prelude::*;
        let cost = |&at: &usize| {
            let mut with = sums.clone();
            with.add(&self.rows[at], sign);
            (self.cost(&with), at)
        };
        let costs: Vec<(f64, usize)> = among.par_iter().map(cost).collect();
        let best = costs.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
        best.map(|(_, at)| at)
    }

    /// The smallest set where few sets are smaller than that of the selection, else that one.
    fn fewest(&self) -> Vec<usize> {
        let selected = self.selected();
        let smaller = 1..selected.len();
        let mut sets = 0.0;
        for size in smaller.clone() {
            sets += binomial(self.rows.len(), size);
        }
        let tried = || smaller.clone().find_map(|size| self.smallest_of(size));
        match sets <= MAX_TRIED_SETS {
            true => tried().unwrap_or(selected),
            false => selected,
        }
    }

    /// The first set of a size that meets the limit, of all.
    fn smallest_of(&self, size: usize) -> Option<Vec<usize>> {
        let count = self.rows.len();
        let mut chosen: Vec<usize> = (0..size).collect();
        loop {
            if self.is_met(&self.sums(&chosen)) {
                return Some(chosen);
            }
            // The next set in lexical order.
            let place = (0..size).rev().find(|&at| chosen[at] < count - size + at)?;
            chosen[place] += 1;
            for at in place + 1..size {
                chosen[at] = chosen[at - 1] + 1;
            }
        }
    }

    /// All candidates where these do not meet the limit.
    fn selected(&self) -> Vec<usize> {
        let all: Vec<usize> = (0..self.rows.len()).collect();
        let mut sets = vec![self.added()];
        if all.len() <= MAX_CANDIDATES_OF_REMOVAL {
            sets.push(Some(all.clone()).filter(|all| self.is_met(&self.sums(all))));
        }
        let sets = sets.into_iter().flatten().map(|set| self.reduced(set));
        let fewest = sets.min_by_key(Vec::len).unwrap_or_else(|| all.clone());
        // Where all candidates fail, a smaller set hardly ever meets the limit, and trying all
        // sizes takes the fifth power of their number.
        match all.len() <= MAX_CANDIDATES_OF_REMOVAL && fewest.len() < all.len() {
            true => self.exchanged(&fewest).unwrap_or(fewest),
            false => fewest,
        }
    }

    /// The smallest set that meets the limit, from exchanges of single sensors of two sets: the
    /// first that were added, and the last that removal keeps.
    fn exchanged(&self, set: &[usize]) -> Option<Vec<usize>> {
        let (mut added, mut sums) = (Vec::new(), self.sums(&[]));
        let all: Vec<usize> = (0..self.rows.len()).collect();
        for _ in set {
            let free: Vec<usize> = (all.iter().copied())
                .filter(|at| !added.contains(at))
                .collect();
            added.extend(self.best(&sums, &free, 1.0));
            sums = self.sums(&added);
        }
        let mut kept = set.to_vec();
        let mut starts = Vec::new();
        while kept.len() > 1 {
            let out = self.best(&self.sums(&kept), &kept, -1.0)?;
            kept.retain(|at| *at != out);
            starts.push([kept.clone(), added[..kept.len()].to_vec()]);
        }
        let starts = starts.into_iter().rev().flatten();
        starts.filter_map(|start| self.improved(start)).next()
    }

    /// A set with single sensors exchanged, each time the exchange that lowers the cost most;
    /// `None` where it never meets the limit. Ascending.
    fn improved(&self, mut chosen: Vec<usize>) -> Option<Vec<usize>> {
        let mut cost = self.cost(&self.sums(&chosen));
        while !self.is_met(&self.sums(&chosen)) {
            let swapped = |place: usize| {
                let mut without = self.sums(&chosen);
                without.add(&self.rows[chosen[place]], -1.0);
                let free: Vec<usize> = (0..self.rows.len())
                    .filter(|at| !chosen.contains(at))
                    .collect();
                let next = self.best(&without, &free, 1.0)?;
                without.add(&self.rows[next], 1.0);
                Some((self.cost(&without), place, next))
            };
            let swaps = (0..chosen.len()).filter_map(swapped);
            let (least, place, next) = swaps.min_by(|a, b| a.0.total_cmp(&b.0))?;
            if least >= cost {
                return None;
            }
            (cost, chosen[place]) = (least, next);
        }
        chosen.sort_unstable();
        Some(chosen)
    }

    /// Candidates added one by one until the limit is met; `None` where it never is.
    fn added(&self) -> Option<Vec<usize>> {
        let mut free: Vec<usize> = (0..self.rows.len()).collect();
        let (mut chosen, mut sums) = (Vec::new(), self.sums(&[]));
        while let Some(next) = self.best(&sums, &free, 1.0) {
            free.retain(|at| *at != next);
            chosen.push(next);
            sums.add(&self.rows[next], 1.0);
            if self.is_met(&sums) {
                return Some(chosen);
            }
        }
        None
    }

    /// A set without the sensors that it does not need, the least useful first; ascending.
    fn reduced(&self, mut chosen: Vec<usize>) -> Vec<usize> {
        let mut needed: Vec<usize> = Vec::new();
        loop {
            let free: Vec<usize> = (chosen.iter().copied())
                .filter(|at| !needed.contains(at))
                .collect();
            let mut sums = self.sums(&chosen);
            let Some(next) = self.best(&sums, &free, -1.0) else {
                break;
            };
            sums.add(&self.rows[next], -1.0);
            match chosen.len() > 1 && self.is_met(&sums) {
                true => chosen.retain(|at| *at != next),
                false => needed.push(next),
            }
        }
        chosen.sort_unstable();
        chosen
    }
}

#[cfg(test)]
mod tests {
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::modal::{Mode, ModeShape, Scaling};

    fn dof(number: usize) -> Dof {
        format!("{number}:+Z").parse().unwrap()
    }

    /// Modes with values at sensors 1, 2, ...
    fn model(shapes: &[Vec<f64>]) -> ModalModel {
        let mode = |(number, values): (usize, &Vec<f64>)| {
            let values = (1..)
                .zip(values)
                .map(|(at, value)| (dof(at), (*value).into()));
            let hz = 100.0 * (number + 1) as f64;
            Mode::new(hz, None, ModeShape::new(values), Scaling::UnitModalMass)
        };
        ModalModel {
            modes: shapes.iter().enumerate().map(mode).collect(),
            ..ModalModel::default()
        }
    }

    fn candidates(count: usize) -> Vec<Dof> {
        (1..=count).map(dof).collect()
    }

    /// The size of the smallest set, by trying all.
    fn smallest(search: &Search) -> Option<usize> {
        let count = search.rows.len();
        let sets = (1usize..1 << count).filter_map(|bits| {
            let chosen: Vec<usize> = (0..count).filter(|at| bits >> at & 1 == 1).collect();
            search.is_met(&search.sums(&chosen)).then_some(chosen.len())
        });
        sets.min()
    }

    #[test]
    fn sensors_of_a_beam_are_few_and_their_auto_mac_is_below_the_limit() {
        let sine =
            |k: usize| (1..40).map(move |x| (std::f64::consts::PI * (k * x) as f64 / 40.0).sin());
        let theory = model(&(1..6).map(|k| sine(k).collect()).collect::<Vec<_>>());
        let set = fewest_sensors(&theory, None, &candidates(39), 0.1).unwrap();
        // Five modes need at least five sensors to be independent.
        assert!(
            set.is_met() && (5..=6).contains(&set.sensors.len()),
            "{set:?}"
        );
        let outside = set.auto_mac[set.largest_at[0]][set.largest_at[1]];
        assert!((outside - set.largest).abs() < 1e-15 && set.largest <= 0.1);
        // The table is the AutoMAC of the shapes at these sensors.
        let values = |k: usize| -> Vec<f64> {
            let shape = &theory.modes[k].shape;
            set.sensors
                .iter()
                .map(|dof| shape.get(dof).unwrap().re)
                .collect()
        };
        let inner = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        let (a, b) = (values(0), values(2));
        let mac = inner(&a, &b).powi(2) / inner(&a, &a) / inner(&b, &b);
        assert!((set.auto_mac[0][2] - mac).abs() < 1e-12);
        // A smaller band needs fewer.
        let band = Some(Band::new(50.0, 250.0).unwrap());
        let fewer = fewest_sensors(&theory, band, &candidates(39), 0.1).unwrap();
        assert!(
            fewer.modes.len() == 2 && fewer.sensors.len() == 2,
            "{fewer:?}"
        );
    }

    #[test]
    fn sets_of_few_candidates_are_the_smallest_and_those_of_many_nearly() {
        let (mut larger, mut met) = (0, 0);
        for seed in 0..60 {
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            let modes = random.random_range(2..5);
            let mut number = || random.random_range(-1.0..1.0);
            let shapes: Vec<Vec<f64>> = (0..modes)
                .map(|_| (0..11).map(|_| number()).collect())
                .collect();
            let set = fewest_sensors(&model(&shapes), None, &candidates(11), 0.1).unwrap();
            let rows = (0..11).map(|at| shapes.iter().map(|shape| shape[at].into()).collect());
            let search = Search::new(rows.collect(), (0..modes).collect(), 0.1);
            let smallest = smallest(&search);
            if !search.is_met(&search.sums(&search.selected())) {
                // Not even all candidates meet the limit.
                continue;
            }
            assert_eq!(Some(set.sensors.len()), smallest, "{seed}: {set:?}");
            met += 1;
            larger += search.selected().len() - set.sensors.len();
        }
        // The selection alone, which many candidates have.
        assert!(met > 40 && 2 * larger < met, "{larger} of {met}");
    }

    #[test]
    fn sensors_at_nodes_of_a_mode_are_no_set() {
        // Sensors 1 and 2 make both modes orthogonal, but the second hardly moves there.
        let theory = model(&[vec![1.0, 1.0, 1.0, 0.3], vec![1e-3, -1e-3, 1.0, -1.0]]);
        let set = fewest_sensors(&theory, None, &candidates(4), 0.1).unwrap();
        let has_motion = set.sensors.iter().any(|at| *at == dof(3) || *at == dof(4));
        assert!(has_motion, "{set:?}");
    }

    #[test]
    fn modes_that_no_sensors_separate_have_the_auto_mac_of_all() {
        let theory = model(&[vec![1.0, 2.0, 3.0], vec![1.0, 2.0, 3.1]]);
        let set = fewest_sensors(&theory, None, &candidates(3), 0.1).unwrap();
        assert!(!set.is_met() && set.largest > 0.99 && set.sensors.len() == 3);
        // A mode that moves no candidate is left out.
        let theory_of_three = model(&[vec![1.0, 1.0], vec![0.0, 1e-18], vec![1.0, -1.0]]);
        let set = fewest_sensors(&theory_of_three, None, &candidates(2), 0.1).unwrap();
        assert_eq!((set.at_nodes.len(), set.at_nodes[0].mode), (1, 2));
        assert!(set.is_met() && set.modes.len() == 2, "{set:?}");
        // One repeated root has no pair of roots.
        let mut repeated = theory;
        repeated
            .modes
            .iter_mut()
            .for_each(|mode| mode.group = Some(1));
        assert_eq!(fewest_sensors(&repeated, None, &candidates(3), 0.1), None);
    }
}
