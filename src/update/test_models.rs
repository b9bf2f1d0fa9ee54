//! Models with answers that are known, for the tests of updating.

use crate::geometry::Sensor;
use crate::modal::{ModalModel, Mode, ModeShape, Scaling};
use crate::theory::{
    LumpedFile, LumpedModel, ModeOptions, TheoreticalModel, coordinate_sensors, modes,
};

use super::{ParameterChoice, UpdateProblem};

/// A chain of masses of 1 kg on springs `k1`, `k2`, ..., fixed at the first: `stiffness` of each,
/// N/m, and a spring named `extra` of 0 mean effect where it is asked for.
pub fn chain(stiffness: &[f64]) -> LumpedModel {
    chain_of(&vec![1.0; stiffness.len()], stiffness)
}

/// The same chain with other masses, kg, some of which may be 0.
pub fn chain_of(masses: &[f64], stiffness: &[f64]) -> LumpedModel {
    let mut text = "schema = \"modalign-model/1\"\n".to_owned();
    for (i, (k, kg)) in stiffness.iter().zip(masses).enumerate() {
        let n = i + 1;
        text += &format!(
            "[[parameter]]\nname = \"k{n}\"\nunit = \"N/m\"\nnominal = {k:?}\nlower = 0.0\nupper = {:?}\nstatus = \"assumed\"\n",
            100.0 * k
        );
        text += &format!(
            "[[body]]\nname = \"m{n}\"\nat_m = [{n}.0, 0.0, 0.0]\nmass_kg = {kg:?}\nfree = [\"x\"]\n"
        );
        text += &format!("[[point]]\nname = \"p{n}\"\nbody = \"m{n}\"\nat_m = [{n}.0, 0.0, 0.0]\n");
        let to = if i == 0 {
            "ground".to_owned()
        } else {
            format!("p{i}")
        };
        text += &format!(
            "[[spring]]\nname = \"s{n}\"\nfrom = \"p{n}\"\nto = \"{to}\"\ndirection = [1.0, 0.0, 0.0]\nparameter = \"k{n}\"\n"
        );
    }
    LumpedModel::new(toml::from_str::<LumpedFile>(&text).unwrap()).unwrap()
}

/// Two masses of 1 kg between two walls on springs `k1` to `k3`, N/m.
pub fn between_walls(stiffness: &[f64; 3]) -> LumpedModel {
    let mut text = "schema = \"modalign-model/1\"\n".to_owned();
    for n in 1..=2 {
        text += &format!(
            "[[body]]\nname = \"m{n}\"\nat_m = [{n}.0, 0.0, 0.0]\nmass_kg = 1.0\nfree = [\"x\"]\n[[point]]\nname = \"p{n}\"\nbody = \"m{n}\"\nat_m = [{n}.0, 0.0, 0.0]\n"
        );
    }
    let ends = [("p1", "ground"), ("p2", "p1"), ("p2", "ground")];
    for ((n, k), (from, to)) in (1..).zip(stiffness).zip(ends) {
        text += &format!(
            "[[parameter]]\nname = \"k{n}\"\nunit = \"N/m\"\nnominal = {k:?}\nlower = 0.0\nupper = {:?}\nstatus = \"assumed\"\n[[spring]]\nname = \"s{n}\"\nfrom = \"{from}\"\nto = \"{to}\"\ndirection = [1.0, 0.0, 0.0]\nparameter = \"k{n}\"\n",
            100.0 * k
        );
    }
    LumpedModel::new(toml::from_str::<LumpedFile>(&text).unwrap()).unwrap()
}

/// A mass of 1 kg on a spring in x and one in y, N/m.
pub fn two_directions(stiffness: [f64; 2]) -> LumpedModel {
    let mut text = "schema = \"modalign-model/1\"\n[[body]]\nname = \"m\"\nat_m = [0.0, 0.0, 0.0]\nmass_kg = 1.0\nfree = [\"x\", \"y\"]\n[[point]]\nname = \"p\"\nbody = \"m\"\nat_m = [0.0, 0.0, 0.0]\n".to_owned();
    for ((name, along), k) in [("kx", "1.0, 0.0"), ("ky", "0.0, 1.0")]
        .iter()
        .zip(stiffness)
    {
        text += &format!(
            "[[parameter]]\nname = \"{name}\"\nunit = \"N/m\"\nnominal = {k:?}\nlower = 0.0\nupper = {:?}\nstatus = \"assumed\"\n[[spring]]\nname = \"{name}\"\nfrom = \"p\"\nto = \"ground\"\ndirection = [{along}, 0.0]\nparameter = \"{name}\"\n",
            100.0 * k
        );
    }
    LumpedModel::new(toml::from_str::<LumpedFile>(&text).unwrap()).unwrap()
}

/// A sensor on every coordinate.
pub fn sensors(model: &dyn TheoreticalModel, values: &[f64]) -> Vec<Sensor> {
    coordinate_sensors(&model.assemble(values).unwrap().coordinates)
}

/// The elastic modes of a model as a test that measured them, each frequency with a relative
/// deviation; `shapes`: at all sensors or at none.
pub fn measured(
    model: &dyn TheoreticalModel,
    values: &[f64],
    relative_std: f64,
    shapes: bool,
) -> ModalModel {
    let sensors = sensors(model, values);
    let solved = modes(model, values, &sensors, &ModeOptions::default()).unwrap();
    let of = |mode: &Mode| Mode {
        frequency_std_hz: Some(relative_std * mode.frequency_hz),
        ..Mode::new(
            mode.frequency_hz,
            None,
            if shapes {
                mode.shape.clone()
            } else {
                ModeShape::default()
            },
            Scaling::Unknown,
        )
    };
    ModalModel {
        modes: solved.model.modes[solved.rigid..].iter().map(of).collect(),
        ..ModalModel::default()
    }
}

/// Parameters freed by name with default priors.
pub fn free(names: &[&str]) -> Vec<ParameterChoice> {
    let choice = |name: &&str| ParameterChoice {
        name: (*name).to_owned(),
        ..ParameterChoice::default()
    };
    names.iter().map(choice).collect()
}

/// Largest distance of the derivatives from central differences, as a part of the column's largest
/// entry.
pub fn against_differences(problem: &UpdateProblem<'_>, z: &[f64]) -> f64 {
    let at = problem.start(z).unwrap();
    let jacobian = problem.jacobian(&at).unwrap();
    let mut worst = 0.0f64;
    for j in 0..z.len() {
        let h = 1e-4;
        let moved = |h: f64| {
            let mut z = z.to_vec();
            z[j] += h;
            problem.follow(&z, &at).unwrap().unwrap().residual
        };
        let (up, down) = (moved(h), moved(-h));
        let (up2, down2) = (moved(2.0 * h), moved(-2.0 * h));
        // Differences at h and 2 h, extrapolated: the error is of order h^4 and rounding.
        let slope = |i: usize| (8.0 * (up[i] - down[i]) - (up2[i] - down2[i])) / (12.0 * h);
        let scale = (0..up.len()).map(|i| slope(i).abs()).fold(1.0, f64::max);
        for i in 0..up.len() {
            worst = worst.max((slope(i) - jacobian[(i, j)]).abs() / scale);
        }
    }
    worst
}
