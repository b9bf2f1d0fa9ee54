//! H1 of a clean synthetic test is within the truncation bound that the tool itself computes.

use std::path::Path;

use modalign::frf::FrfSet;
use modalign::io::{Hints, HitFile, frf_sets, modes_from_json, open_path};
use modalign::modal::ModalModel;
use num_complex::Complex64;

use crate::command::{json, modalign, succeed, write};

const DAMPING: f64 = 0.01;
const SLOWEST_HZ: f64 = 100.0;

/// Three modes, the lowest the slowest; one reference, two responses.
fn truth() -> String {
    let mode = |hz: f64, shape: [f64; 2]| {
        format!(
            "{{\"frequency_hz\": {hz}, \"damping_ratio\": {DAMPING}, \"modal_mass_kg\": 1.0, \"shape\": {{\"1:+Z\": [{}, 0], \"2:+Z\": [{}, 0]}}}}",
            shape[0], shape[1]
        )
    };
    let modes = [
        mode(SLOWEST_HZ, [1.0, 0.7]),
        mode(310.0, [0.8, -0.9]),
        mode(760.0, [0.6, 0.5]),
    ];
    format!(
        "{{\"schema\": \"modalign-modes/1\", \"modes\": [{}]}}",
        modes.join(", ")
    )
}

/// A clean test whose record holds this many time constants of the slowest mode after the hit.
fn spec(time_constants: f64) -> String {
    let rate = 4096.0;
    let decay = std::f64::consts::TAU * SLOWEST_HZ * DAMPING;
    let samples = ((time_constants / decay + 0.01) * rate).round();
    format!(
        "schema = \"modalign-synth/1\"\ntitle = \"clean\"\nseed = 3\naverages = 2\n\
         truth = {{ modes = \"truth.json\" }}\n\
         record = {{ sampling_rate_hz = {rate}, samples = {samples}, pretrigger_s = 0.01, response = \"acceleration\", precision = \"double\" }}\n\
         pulse = {{ duration_s = 6e-4, peak_n = 80.0, peak_spread = 0.2 }}\n\
         [[hit]]\ndofs = [\"1:+Z\"]\nresponses = [\"1:+Z\", \"2:+Z\"]\n"
    )
}

fn read(path: &Path) -> FrfSet {
    let hints = Hints {
        path: path.display().to_string(),
        table: None,
    };
    let source = open_path(path, &hints, None).unwrap();
    frf_sets(&mut [HitFile::new(source)]).unwrap().remove(0)
}

/// H and the sum of the magnitudes of its modal terms at one line, accelerance.
fn true_line(truth: &ModalModel, set: &FrfSet, index: usize, k: usize) -> (Complex64, f64) {
    let function = &set.functions()[index];
    let pair = (function.response.clone(), function.reference.clone());
    let s = Complex64::I * set.axis().rad_s(k);
    let (mut h, mut envelope) = (Complex64::ZERO, 0.0);
    for mode in &truth.modes {
        let (lambda, a) = (mode.pole().unwrap().lambda, mode.residues[&pair]);
        h += s * s * (a / (s - lambda) + a.conj() / (s - lambda.conj()));
        envelope += (lambda * lambda * a / (s - lambda)).norm();
    }
    (h, envelope)
}

#[test]
fn h1_of_a_clean_test_is_within_the_bound_that_the_tool_states() {
    for (time_constants, limit) in [(6.0, 3e-3), (9.5, 1e-4)] {
        let folder = tempfile::tempdir().unwrap();
        write(
            folder.path(),
            &[
                ("truth.json", &truth()),
                ("spec.toml", &spec(time_constants)),
            ],
        );
        let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
        succeed(["synth", &path("spec.toml"), "-o", &path("hits.uff")]);
        let output = modalign(["frf", &path("hits.uff"), "--json", "-o", &path("frf.uff")]);
        let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        let findings = summary["findings"].as_array().unwrap();
        let bound = findings
            .iter()
            .find(|finding| finding["code"] == "truncated")
            .expect("the bound is stated");
        let bound = bound["value"].as_f64().unwrap();
        assert!(
            bound < limit,
            "{time_constants} time constants: bound {bound}"
        );
        assert!(
            bound > 0.8 * (-time_constants).exp(),
            "the bound is honest: {bound}"
        );
        let truth = modes_from_json(
            &std::fs::read_to_string(folder.path().join("hits.modes.json")).unwrap(),
            "truth",
        )
        .unwrap();
        let set = read(&folder.path().join("frf.uff"));
        let usable = summary["usable_band_hz"][1].as_f64().unwrap();
        let mut worst = (0.0, 0.0);
        for index in 0..set.len() {
            for k in 1..set.axis().nearest(usable).unwrap() {
                let (h, envelope) = true_line(&truth, &set, index, k);
                let error = (set.values(index)[k] - h).norm() / envelope;
                worst = if error > worst.0 {
                    (error, set.axis().hz(k))
                } else {
                    worst
                };
            }
        }
        assert!(
            worst.0 < limit,
            "{time_constants} time constants: {} at {} Hz",
            worst.0,
            worst.1
        );
        // The bound from the energies of quarters is exact to 4 zeta for one mode (a ripple of the
        // energy at twice the frequency), and the tails of the other two modes are e^(-3n) and
        // less.
        assert!(
            worst.0 < (1.0 + 4.0 * DAMPING) * bound,
            "{} is not within the stated {bound}",
            worst.0
        );
        assert!(usable > 900.0 && usable <= 0.4 * 4096.0, "{usable}");
        assert_eq!(
            json(&folder.path().join("hits.modes.json"))["synthetic"]["filter"]["order"],
            16
        );
    }
}
