//! Figures of a report hold their data: curves thinned to the resolution of a screen, fits, poles
//! and shapes.
//!
//! The report ([`crate::report`]) draws them and computes nothing. All data are plain numbers in a
//! JSON file, rounded to the resolution of a figure; the results are in the other files of a run.

mod bodies;
mod circles;
mod curves;
mod overview;
mod poles;
mod provenance;
mod rounding;
mod shapes;
#[cfg(test)]
mod shapes_tests;

use serde::{Deserialize, Serialize};

use crate::axis::Band;
use crate::frf::FrfSet;
use crate::theory::ModelRoot;

use super::SceneError;
use super::plan::Scene;
use super::result::SceneResult;
use super::test_result::TestResult;

use curves::single_set;
use rounding::rounded;

pub use bodies::{BodyNode, TheoryMotion};
pub use circles::CircleFigure;
pub use curves::{Curve, FrfFigure};
pub use overview::{
    CommonError, ErrorRange, ErrorTrend, OneSidedModes, Overview, OverviewCell, OverviewRow,
    common_error,
};
pub use poles::{CmifCurve, StabilizationFigure};
pub use provenance::{Provenance, SourceFile};
pub use shapes::{MacFigure, Partner, Reading, ShapeFigure, ShapePoint, ShapeValues};

/// Maximum number of points of all FRF curves of a report: with six numbers each, about 2 MB.
const MAX_CURVE_POINTS: usize = 36_000;

/// Figures of a report.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Figures {
    /// Deviations between test and model; `None` without a comparison.
    pub overview: Option<Overview>,
    /// Of every test.
    pub tests: Vec<TestFigures>,
    /// The motion of the model's bodies; `None` for finished modes, and without a model.
    pub theory: Option<TheoryMotion>,
    /// Energies of the model's roots.
    pub energies: Vec<EnergyBar>,
}

/// The figures of one test.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct TestFigures {
    /// Its name.
    pub name: String,
    /// Whether it was computed from a model instead of measured.
    #[serde(default)]
    pub synthetic: bool,
    /// Its file of FRFs in the folder of the run; `None` for a test of finished modes.
    pub frf_file: Option<String>,
    /// Its modes.
    pub modes: Vec<ModeMark>,
    /// Bode and Nyquist diagrams.
    pub frfs: Option<FrfFigure>,
    /// Poles of all orders over the CMIF.
    pub stabilization: Option<StabilizationFigure>,
    /// A circle fit of each mode.
    pub circles: Vec<CircleFigure>,
    /// MAC with the theory.
    pub mac: Option<MacFigure>,
    /// Shapes on the test's points.
    pub shapes: Option<ShapeFigure>,
}

/// A mode as figures mark it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModeMark {
    /// Natural frequency, Hz.
    pub hz: f64,
    /// Its standard deviation, Hz.
    pub hz_std: Option<f64>,
    /// Damping ratio, a fraction.
    pub damping_ratio: Option<f64>,
    /// Its standard deviation.
    pub damping_std: Option<f64>,
    /// Modal phase collinearity.
    pub mpc: Option<f64>,
}

/// Energy distribution of a root of the model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EnergyBar {
    /// Frequency, Hz.
    pub hz: f64,
    /// Number of modes that share it.
    pub multiplicity: usize,
    /// Kind of motion in the model's words.
    pub class: Option<String>,
    /// Shares of the kinetic energy by kind of body, largest first.
    pub kinetic: Vec<(String, f64)>,
    /// Shares of the strain energy by spring or part.
    pub strain: Vec<(String, f64)>,
}

/// The figures of a scene, with the provenance of its results.
///
/// `frf_files` are the names under which the FRFs of the tests are written, in their order.
///
/// # Errors
/// [`SceneError`] of the model, and of files that can no longer be read.
pub fn figures(
    scene: &Scene,
    result: &SceneResult,
    frf_files: &[Option<String>],
) -> Result<(Figures, Provenance), SceneError> {
    let counts = result.tests.iter().map(|test| functions_shown(&test.frfs));
    let functions = counts.sum::<usize>().max(1);
    let model = match &scene.model {
        Some(table) => super::table_model(table, &scene.folder, &scene.path)?,
        None => None,
    };
    let sensors = match &model {
        Some(model) => model.sensors_with(&scene.sensors),
        None => scene.sensors.clone(),
    };
    let band = super::run::theory_band(scene, &result.tests);
    let motion = match &model {
        Some(model) => bodies::theory_motion(model, band)?,
        None => None,
    };
    let mut tests = Vec::with_capacity(result.tests.len());
    for (index, test) in result.tests.iter().enumerate() {
        let shown = shapes::ShapeInputs {
            test,
            theory: &result.theory,
            pairing: result.pairings.get(index),
            sensors: &sensors,
            motion: motion.as_ref(),
        };
        tests.push(TestFigures {
            name: test.name.clone(),
            synthetic: test.is_synthetic(),
            frf_file: frf_files.get(index).cloned().flatten(),
            modes: marks(test),
            frfs: single_set(&test.frfs)
                .and_then(|set| curves::frf_figure(set, &test.modes, MAX_CURVE_POINTS / functions)),
            stabilization: poles::stabilization_figure(scene, test),
            circles: circles::circle_figures(test),
            mac: shapes::mac_figure(&shown),
            shapes: shapes::shape_figure(&shown),
        });
    }
    let figures = Figures {
        overview: (result.table.as_ref()).map(overview::overview),
        tests,
        theory: motion,
        energies: energy_bars(&result.theory.roots, band),
    };
    Ok((figures, provenance::provenance(scene, result)?))
}

fn marks(test: &TestResult) -> Vec<ModeMark> {
    let modes = test.modes.modes.iter();
    let mark = modes.map(|mode| ModeMark {
        hz: mode.frequency_hz,
        hz_std: mode.frequency_std_hz,
        damping_ratio: mode.damping_ratio,
        damping_std: mode.damping_std,
        mpc: mode.mpc,
    });
    mark.collect()
}

/// Energy by body and by spring of the roots of a model in a band.
pub fn energy_bars(roots: &[ModelRoot], band: Option<Band>) -> Vec<EnergyBar> {
    let hz = |omega: f64| omega / std::f64::consts::TAU;
    let inside = roots
        .iter()
        .filter(|root| band.is_none_or(|band| band.contains(hz(root.omega_rad_s))));
    let shares = |parts: &[(String, f64)]| -> Vec<(String, f64)> {
        let visible = parts.iter().filter(|(_, share)| *share >= 5e-4);
        visible
            .map(|(name, share)| (name.clone(), rounded(*share, 4)))
            .collect()
    };
    let bar = inside.map(|root| EnergyBar {
        hz: rounded(hz(root.omega_rad_s), 9),
        multiplicity: root.modes.len(),
        class: root.class.clone(),
        kinetic: shares(&root.energy_by_kind()),
        strain: shares(&root.strain_energy),
    });
    bar.collect()
}

fn functions_shown(sets: &[FrfSet]) -> usize {
    single_set(sets).map_or(0, |set| set.len().min(curves::MAX_FUNCTIONS))
}
