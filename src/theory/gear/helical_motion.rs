//! The motion of the helical planetary gear over time: large rotations, parametric mesh stiffness,
//! and pressure angles that follow the centres of the gears, in the detail that is asked for.
//!
//! State: `xc, yc, psi_c, xs, ys, psi_s`, then `xi, eta, psi` of each planet, then their rates.
//! `xi` and `eta` are displacements of a planet's centre against its pin along and across the
//! turning radius; `psi` are the rotations less those of the ideal motion, `theta_c = W t + psi_c`,
//! `theta_s = (1 + Zr/Zs) W t + psi_s`, `theta_i = (Rr/Rp) W t + psi_i`, in which planets are
//! counted against the carrier: `theta_c - theta_i` is a planet's absolute rotation.
//!
//! With `u` and `v` the centre of a planet seen from that of the sun along and across its radius,
//! β = atan2(v, u) and `cos α = Rb / sqrt(u^2 + v^2)`, `Rb` the sum or difference of the base
//! radii, a mesh is compressed by `g(u, v) + Rs (psi_s - psi_c) - Rp psi_i` (sun, σ = 1) or `g(u,
//! v) + Rp psi_i - Rr psi_c` (ring, σ = -1; `u`, `v` from the ring's centre), where `g` is
//!
//! - constant angle: `-σ (u - Rc) sin α0 - v cos α0`;
//! - as printed (equations 8 to 11): the same with α - σβ for α0, which counts the term of second
//!   order twice;
//! - exact (involutes): `-Rb (β + σ (inv α - inv α0))`, whose gradient is the actual line of
//!   action.
//!
//! The planets' equations are solved for their accelerations, which leaves the carrier its
//! mass and moment of inertia: the system is explicit.
//!
//! # Reference
//! Zhang, Liao and Huang (2013), equations 1 to 27, derived again; the exact compression from the
//! involute.

use crate::theory::integrate::Equations;
use crate::theory::{TheoreticalModel, TheoryError};

use super::HelicalPlanetary;
use super::helical_mesh::{Approach, Detail, MeshGeometry, MeshState, Wave};
use super::helical_parameters::{PLANETS, RING_TEETH, SUN_TEETH};
use super::helical_planetary::planet_angle;

/// Coordinates; the state has twice as many entries.
pub(super) const COORDINATES: usize = 6 + 3 * PLANETS;

/// The machine as its equations of motion need it.
#[derive(Clone, Debug)]
pub(super) struct Motion {
    pub detail: Detail,
    mass: [f64; 3],
    inertia: [f64; 3],
    /// Bearings of carrier, sun and planets, N/m.
    bearing: [f64; 3],
    /// Bearings and meshes have a damper of this times their stiffness, s.
    pub damping_s: f64,
    /// A mesh's damper, N s/m.
    mesh_damper: f64,
    ring_teeth: f64,
    radius_s: f64,
    radius_p: f64,
    radius_r: f64,
    pins: f64,
    meshes: [MeshGeometry; 2],
    waves: [Wave; 2],
    lead: f64,
    mesh_mean: f64,
    load_nm: f64,
    /// Angular speed of the carrier, rad/s.
    pub speed_rad_s: f64,
    places: [(f64, f64); PLANETS],
}

impl Motion {
    /// The motion of a model with these values. Bearings of a torsional model are rigid whatever
    /// the detail.
    ///
    /// # Errors
    /// As [`TheoreticalModel::assemble`].
    pub fn new(
        model: &HelicalPlanetary,
        values: &[f64],
        detail: Detail,
    ) -> Result<Self, TheoryError> {
        model.assemble(values)?;
        let parameters = model.values(values, None);
        let get = |name: &str| parameters.get(name).value;
        let (radius_s, radius_p) = (get("base_radius_s"), get("base_radius_p"));
        let rest_angle = get("pressure_angle");
        let base = radius_s + radius_p;
        let pins = base / rest_angle.cos();
        let mesh = |side| MeshGeometry::new(side, base, rest_angle, pins);
        let wave = |share: &str| Wave {
            least: get("mesh_min"),
            most: get("mesh_max"),
            edge: get("mesh_edge"),
            share: get(share),
        };
        let torsional = model.is_torsional();
        let speed_rad_s = get("speed") * std::f64::consts::TAU / 60.0;
        let mesh_mean = 0.5 * (get("k_sp") + get("k_rp"));
        Ok(Self {
            detail: if torsional { Detail::Torsional } else { detail },
            mass: ["m_c", "m_s", "m_p"].map(get),
            inertia: ["j_c", "j_s", "j_p"].map(get),
            bearing: ["k_c", "k_s", "k_p"].map(|name| if torsional { 0.0 } else { get(name) }),
            damping_s: get("stiffness_damping"),
            mesh_damper: get("stiffness_damping") * mesh_mean,
            ring_teeth: RING_TEETH,
            radius_s,
            radius_p,
            radius_r: radius_s * RING_TEETH / SUN_TEETH,
            pins,
            meshes: [mesh(1.0), mesh(-1.0)],
            waves: [wave("mesh_share_sp"), wave("mesh_share_rp")],
            lead: get("mesh_lead_rp"),
            mesh_mean,
            load_nm: get("load"),
            speed_rad_s,
            places: std::array::from_fn(|planet| planet_angle(planet).sin_cos()),
        })
    }

    /// The same with another number of teeth in the ring on the same pins. Where angles vary, its
    /// mesh starts from that at which base circles at this distance are in mesh; where not, it
    /// keeps that of the sun's.
    pub fn with_ring_teeth(mut self, teeth: f64) -> Self {
        self.ring_teeth = teeth;
        self.radius_r = self.radius_s * teeth / SUN_TEETH;
        let ring = &mut self.meshes[1];
        ring.base = self.radius_r - self.radius_p;
        if matches!(self.detail, Detail::PrintedAngle | Detail::ExactAngle) {
            ring.set_rest_angle((ring.base / ring.pins).acos());
        }
        self
    }

    /// The same without damping.
    pub fn undamped(mut self) -> Self {
        (self.damping_s, self.mesh_damper) = (0.0, 0.0);
        self
    }

    /// The same with mesh stiffnesses that stay at the mean.
    pub fn with_steady_meshes(mut self) -> Self {
        for wave in &mut self.waves {
            (wave.least, wave.most) = (self.mesh_mean, self.mesh_mean);
        }
        self
    }

    /// The same without damping, with steady mesh stiffnesses, and without torques: what conserves
    /// energy.
    pub fn conservative(mut self) -> Self {
        self.load_nm = 0.0;
        self.with_steady_meshes().undamped()
    }

    /// Pressure angles at rest of the meshes of sun and ring, rad.
    pub fn rest_angles(&self) -> [f64; 2] {
        self.meshes.map(|mesh| mesh.rest_angle())
    }

    /// Rotations of the sun in one of the carrier.
    fn ratio(&self) -> f64 {
        1.0 + self.ring_teeth / SUN_TEETH
    }

    /// The torque that balances the load.
    fn drive_nm(&self) -> f64 {
        self.load_nm / self.ratio()
    }

    /// The period of the meshes, s: ring teeth that pass in one turn of the carrier.
    pub fn mesh_period_s(&self) -> f64 {
        std::f64::consts::TAU / (self.ring_teeth * self.speed_rad_s)
    }

    /// The state of steady rotation under the mean mesh stiffness, by the constant angle.
    pub fn equilibrium(&self) -> Vec<f64> {
        let force = self.drive_nm() / (PLANETS as f64 * self.radius_s);
        let [(sin_s, cos_s), (sin_r, cos_r)] = self.rest_angles().map(f64::sin_cos);
        // The centrifugal force grows with the radius that it stretches.
        let turning = self.speed_rad_s * self.speed_rad_s * self.mass[2];
        let [xi, eta] = match self.detail {
            Detail::Torsional => [0.0, 0.0],
            _ => [
                (turning * self.pins + force * (sin_s - sin_r)) / (self.bearing[2] - turning),
                force * (cos_s + cos_r) / (self.bearing[2] - turning),
            ],
        };
        let deflection = force / self.mesh_mean;
        let psi = (deflection - xi * sin_r + eta * cos_r) / self.radius_p;
        let mut state = vec![0.0; 2 * COORDINATES];
        state[5] = (deflection + xi * sin_s + eta * cos_s + self.radius_p * psi) / self.radius_s;
        for planet in 0..PLANETS {
            state[6 + 3 * planet..][..3].copy_from_slice(&[xi, eta, psi]);
        }
        state
    }

    /// The two meshes of a planet at a time.
    pub fn meshes(&self, time_s: f64, state: &[f64], planet: usize) -> [MeshState; 2] {
        let frame = self.frame(time_s, state);
        let place = self.configuration(&frame, state, planet);
        [0, 1].map(|kind| MeshState {
            compression_m: place.meshes[kind].compression,
            stiffness_n_per_m: self.stiffness(time_s, kind, planet),
            angle_rad: place.meshes[kind].angle,
        })
    }

    fn stiffness(&self, time_s: f64, kind: usize, planet: usize) -> f64 {
        let periods = time_s / self.mesh_period_s();
        let passed = planet as f64 / PLANETS as f64;
        self.waves[kind].at(match kind {
            0 => periods - SUN_TEETH * passed,
            _ => periods + self.ring_teeth * passed + self.lead,
        })
    }

    fn frame(&self, time_s: f64, state: &[f64]) -> (f64, f64) {
        (self.speed_rad_s * time_s + state[2]).sin_cos()
    }

    fn configuration(
        &self,
        &(sin, cos): &(f64, f64),
        state: &[f64],
        planet: usize,
    ) -> PlanetConfiguration {
        let (sin_0, cos_0) = self.places[planet];
        let (sin, cos) = (sin * cos_0 + cos * sin_0, cos * cos_0 - sin * sin_0);
        let turned = |x: f64, y: f64| [x * cos + y * sin, y * cos - x * sin];
        let at = 6 + 3 * planet;
        let [xi, eta, psi] = [state[at], state[at + 1], state[at + 2]];
        let planet_centre = [self.pins + xi, eta];
        let carrier = turned(state[0], state[1]);
        // From the sun's centre, and from the ring's.
        let sun = turned(state[0] - state[3], state[1] - state[4]);
        let mut meshes = [
            self.meshes[0].approach(
                self.detail,
                planet_centre[0] + sun[0],
                planet_centre[1] + sun[1],
            ),
            self.meshes[1].approach(
                self.detail,
                planet_centre[0] + carrier[0],
                planet_centre[1] + carrier[1],
            ),
        ];
        meshes[0].compression += self.radius_s * (state[5] - state[2]) - self.radius_p * psi;
        meshes[1].compression += self.radius_p * psi - self.radius_r * state[2];
        PlanetConfiguration {
            sin,
            cos,
            planet_centre,
            offsets: [sun, carrier],
            meshes,
        }
    }

    /// Derivatives of both compressions of a planet by xc, yc, psi_c, xs, ys, psi_s, xi, eta, psi.
    fn gradients(&self, place: &PlanetConfiguration) -> [[f64; 9]; 2] {
        let of_mesh = |kind: usize| {
            let mesh = &place.meshes[kind];
            let [along, across] = place.offsets[kind];
            let by_x = mesh.by_u * place.cos - mesh.by_v * place.sin;
            let by_y = mesh.by_u * place.sin + mesh.by_v * place.cos;
            // The frame turns with the carrier: du = v dtheta of the offset, dv = -u dtheta.
            let by_turn = mesh.by_u * across - mesh.by_v * along;
            ([by_x, by_y, by_turn], [mesh.by_u, mesh.by_v])
        };
        let ([sx, sy, st], [su, sv]) = of_mesh(0);
        let ([rx, ry, rt], [ru, rv]) = of_mesh(1);
        let (r_s, r_p) = (self.radius_s, self.radius_p);
        [
            [sx, sy, st - r_s, -sx, -sy, r_s, su, sv, -r_p],
            [rx, ry, rt - self.radius_r, 0.0, 0.0, 0.0, ru, rv, r_p],
        ]
    }

    /// Kinetic energy of the motion and energy in bearings and meshes, J, with the mesh stiffness
    /// of this time.
    pub fn energy(&self, time_s: f64, state: &[f64]) -> [f64; 2] {
        let rate = &state[COORDINATES..];
        let turning = self.speed_rad_s + rate[2];
        let sun = self.ratio() * self.speed_rad_s + rate[5];
        let squares = |x: f64, y: f64| x * x + y * y;
        let mut kinetic = self.mass[0] * squares(rate[0], rate[1])
            + self.inertia[0] * turning * turning
            + self.mass[1] * squares(rate[3], rate[4])
            + self.inertia[1] * sun * sun;
        let mut strain = self.bearing[0] * squares(state[0], state[1])
            + self.bearing[1] * squares(state[3], state[4]);
        let frame = self.frame(time_s, state);
        for planet in 0..PLANETS {
            let place = self.configuration(&frame, state, planet);
            let at = 6 + 3 * planet;
            let moving =
                |x: f64, y: f64| [x * place.cos + y * place.sin, y * place.cos - x * place.sin];
            let [along, across] = moving(rate[0], rate[1]);
            let radial = along + rate[at] - place.planet_centre[1] * turning;
            let tangential = across + rate[at + 1] + place.planet_centre[0] * turning;
            let spin = turning - self.radius_r / self.radius_p * self.speed_rad_s - rate[at + 2];
            kinetic += self.mass[2] * squares(radial, tangential) + self.inertia[2] * spin * spin;
            strain += self.bearing[2] * squares(state[at], state[at + 1]);
            for mesh in self.meshes(time_s, state, planet) {
                strain += mesh.stiffness_n_per_m * mesh.compression_m * mesh.compression_m;
            }
        }
        [0.5 * kinetic, 0.5 * strain]
    }
}

/// Instantaneous configuration of a planet: its frame, its centre in it, the offsets of the carrier
/// from sun and ring, and both meshes.
struct PlanetConfiguration {
    sin: f64,
    cos: f64,
    planet_centre: [f64; 2],
    offsets: [[f64; 2]; 2],
    meshes: [Approach; 2],
}

impl Equations for Motion {
    fn len(&self) -> usize {
        2 * COORDINATES
    }

    fn rate(&self, time_s: f64, state: &[f64], rate: &mut [f64]) {
        let (now, acceleration) = rate.split_at_mut(COORDINATES);
        now.copy_from_slice(&state[COORDINATES..]);
        // The geometry turns with the whole rotation, though `now` has that of psi alone.
        let turning = self.speed_rad_s + now[2];
        let frame = self.frame(time_s, state);
        let support = |kind: usize, x: f64, v: f64| -self.bearing[kind] * (x + self.damping_s * v);
        let central = |i: usize, kind| support(kind, state[i], now[i]);
        let mut force = [
            central(0, 0),
            central(1, 0),
            -self.load_nm,
            central(3, 1),
            central(4, 1),
            self.drive_nm(),
        ];
        let mut carried_inertia = 0.0;
        let places: [PlanetConfiguration; PLANETS] =
            std::array::from_fn(|planet| self.configuration(&frame, state, planet));
        for (planet, place) in places.iter().enumerate() {
            let at = 6 + 3 * planet;
            let mut planet_force = [
                support(2, state[at], now[at]),
                support(2, state[at + 1], now[at + 1]),
                0.0,
            ];
            for (kind, by) in self.gradients(place).iter().enumerate() {
                let mut closing = self.speed_rad_s * self.turn_of_frame(place, kind);
                for i in 0..6 {
                    closing += by[i] * now[i];
                }
                for i in 0..3 {
                    closing += by[6 + i] * now[at + i];
                }
                let pressed = self.stiffness(time_s, kind, planet) * place.meshes[kind].compression
                    + self.mesh_damper * closing;
                (0..6).for_each(|i| force[i] -= pressed * by[i]);
                (0..3).for_each(|i| planet_force[i] -= pressed * by[6 + i]);
            }
            self.add_planet(place, planet_force, &mut force, &mut carried_inertia);
            acceleration[at..at + 3].copy_from_slice(&planet_force);
        }
        self.central_accelerations(&force, carried_inertia, acceleration);
        for (planet, place) in places.iter().enumerate() {
            let at = 6 + 3 * planet;
            let planet_force = [acceleration[at], acceleration[at + 1], acceleration[at + 2]];
            let [x, y, turn] = [acceleration[0], acceleration[1], acceleration[2]];
            let [u, v] = place.planet_centre;
            let (du, dv) = (now[at], now[at + 1]);
            acceleration[at + 2] = planet_force[2] / self.inertia[2] + turn;
            if self.detail == Detail::Torsional {
                (acceleration[at], acceleration[at + 1]) = (0.0, 0.0);
                continue;
            }
            acceleration[at] =
                planet_force[0] / self.mass[2] + u * turning * turning + 2.0 * dv * turning
                    - (x * place.cos + y * place.sin - v * turn);
            acceleration[at + 1] = planet_force[1] / self.mass[2] + v * turning * turning
                - 2.0 * du * turning
                - (y * place.cos - x * place.sin + u * turn);
        }
    }
}

impl Motion {
    /// Derivative of a compression by the ideal rotation of the frame, which `psi` does not count.
    fn turn_of_frame(&self, place: &PlanetConfiguration, kind: usize) -> f64 {
        let mesh = &place.meshes[kind];
        let [along, across] = place.offsets[kind];
        mesh.by_u * across - mesh.by_v * along
    }

    /// What the planets' bearings and rotations hand on to the carrier.
    fn add_planet(
        &self,
        place: &PlanetConfiguration,
        planet_force: [f64; 3],
        force: &mut [f64; 6],
        inertia: &mut f64,
    ) {
        let [along, across, turn] = planet_force;
        force[2] += turn;
        if self.detail == Detail::Torsional {
            *inertia += self.mass[2] * self.pins * self.pins;
            return;
        }
        let [u, v] = place.planet_centre;
        force[0] -= along * place.cos - across * place.sin;
        force[1] -= along * place.sin + across * place.cos;
        force[2] -= -along * v + across * u;
    }

    fn central_accelerations(&self, force: &[f64; 6], carried: f64, acceleration: &mut [f64]) {
        let inertia = [
            self.mass[0],
            self.mass[0],
            self.inertia[0] + carried,
            self.mass[1],
            self.mass[1],
            self.inertia[1],
        ];
        for i in 0..6 {
            acceleration[i] = force[i] / inertia[i];
        }
        if self.detail == Detail::Torsional {
            [0, 1, 3, 4].into_iter().for_each(|i| acceleration[i] = 0.0);
        }
    }
}
