//! The next step that a screen advises: values of an example, shapes that agree at other
//! frequencies, comparisons without pairs or shapes, updates that do not fit.

use std::path::Path;

use crate::bad_input::recorded_scene;
use crate::command::write;
use crate::first_steps::{POINTS, beam_modes, read, said, stated_values};

/// A scene `bar` with five points, drafted with a beam.
fn drafted(folder: &Path, modes: &str) {
    write(folder, &[("modes.csv", modes), ("points.csv", POINTS)]);
    let (_, error, code) = said(
        folder,
        "new bar modes.csv --model beam --points points.csv --band 20:2000",
    );
    assert_eq!(code, Some(0), "{error}");
}

/// The text without the ends of its lines.
fn unwrapped(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The first three bending modes of a free beam of 1 m at eleven points, with points.csv; the
/// frequencies are those of the draft times a factor.
fn long_beam(factor: f64) -> [String; 2] {
    let (mut heads, mut points) = (String::new(), "point,x,y,z\n".to_owned());
    let at = |number: u32| f64::from(number) / 10.0;
    for number in 0..=10 {
        heads += &format!(",{}:+X", number + 1);
        points += &format!("{},0,0,{}\n", number + 1, at(number));
    }
    let mut modes = format!("frequency_hz,damping_ratio{heads}\n");
    // cos(k) cosh(k) = 1.
    for (hz, k) in [
        (53.17_f64, 4.730_041_f64),
        (146.5, 7.853_205),
        (287.3, 10.995_608),
    ] {
        let sigma = (k.cosh() - k.cos()) / (k.sinh() - k.sin());
        let shape = |x: f64| x.cosh() + x.cos() - sigma * (x.sinh() + x.sin());
        modes += &format!("{},0.004", factor * hz);
        for number in 0..=10 {
            modes += &format!(",{}", shape(k * at(number)));
        }
        modes.push('\n');
    }
    [modes, points]
}

#[test]
fn values_of_an_example_are_named_until_they_are_stated() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    drafted(folder, &beam_modes("X"));
    for line in [
        "run bar",
        "theory bar",
        "theory bar/model.toml",
        "correlate --test modes.csv --theory bar",
        "update bar",
    ] {
        let (screen, findings, _) = said(folder, line);
        assert!(findings.contains("[example-values]"), "{line}: {findings}");
        if line.starts_with("run") {
            let verdict = "Warning: The model has the values of an example";
            assert!(screen.contains(verdict), "{screen}");
            let next = screen.lines().find(|line| line.starts_with("Next"));
            let values = "Next, before anything else: the values of the structure in model.toml";
            assert!(next.unwrap().starts_with(values), "{screen}");
            assert!(!screen.contains("modalign update"), "{screen}");
        }
    }
    let model = read(folder, "bar/model.toml");
    for stated in [
        stated_values(&model),
        model.replace("example_values = true", "example_values = false"),
    ] {
        write(folder, &[("bar/model.toml", &stated)]);
        for line in ["run bar", "theory bar"] {
            let (screen, findings, _) = said(folder, line);
            assert!(!findings.contains("example-values"), "{findings}");
            assert!(!screen.contains("of an example"), "{screen}");
        }
    }
    let faulty = model.replace("example_values = true", "example_values = 1");
    write(folder, &[("bar/model.toml", &faulty)]);
    let (_, error, code) = said(folder, "theory bar/model.toml");
    assert_eq!(code, Some(2));
    assert!(
        error.contains("bar/model.toml:7:18: got the number 1, expected true or false"),
        "{error}"
    );
}

#[test]
fn shapes_that_agree_without_a_pair_are_the_next_step_and_nothing_compared_is_no_success() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let [modes, points] = long_beam(2.5);
    write(folder, &[("modes.csv", &modes), ("points.csv", &points)]);
    said(
        folder,
        "new bar modes.csv --model beam --points points.csv --band 20:2000",
    );
    let model = stated_values(&read(folder, "bar/model.toml"));
    write(folder, &[("bar/model.toml", &model)]);
    let (screen, findings, code) = said(folder, "run bar");
    assert_eq!(code, Some(1), "{findings}");
    let text = unwrapped(&screen);
    assert!(
        text.contains("nothing is compared: exit code 1"),
        "{screen}"
    );
    for part in [
        "Next, as no mode is paired: by shape alone, test 132.93 Hz is f1 (MAC 1.000)",
        "366.25 Hz is f2 (MAC 1.000), 718.25 Hz is f3 (MAC 1.000).",
        "Frequencies of the test are 2.5 times those of the model: check its dimensions",
    ] {
        assert!(text.contains(part), "{part}: {screen}");
    }
    let line = "correlate --test modes.csv --theory bar";
    let (screen, findings, code) = said(folder, line);
    assert_eq!(code, Some(1), "{findings}");
    assert!(
        unwrapped(&screen).contains("nothing is compared: exit code 1"),
        "{screen}"
    );
    assert!(findings.contains("[shapes-agree]"), "{findings}");
    // Without agreement in shape the general text stands.
    let mut rows = modes.lines();
    let mut other = rows.next().unwrap().to_owned();
    for (row, sign) in rows.zip([1.0, -0.5, 0.2]) {
        let (start, _) = row.split_once(",0.004,").unwrap();
        other += &format!("\n{start},0.004,1,0.3,-2,{sign},0.1,-1,0,1,-0.6,0.4,2");
    }
    write(folder, &[("modes.csv", &other)]);
    let (screen, findings, _) = said(folder, "run bar");
    assert!(!findings.contains("[shapes-agree]"), "{findings}");
    assert!(
        unwrapped(&screen).contains("Next, as no mode is paired: ends and length of beam"),
        "{screen}"
    );
    let stated = model.replace("ends_status = \"assumed\"", "ends_status = \"printed\"");
    write(folder, &[("bar/model.toml", &stated)]);
    let (screen, ..) = said(folder, "run bar");
    assert!(
        screen.contains("Next, as no mode is paired: model, its support"),
        "{screen}"
    );
}

#[test]
fn pairs_by_frequency_alone_ask_for_shapes() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    drafted(folder, &beam_modes("X"));
    let model = stated_values(&read(folder, "bar/model.toml"));
    write(folder, &[("bar/model.toml", &model)]);
    // All sensors but one stand at one position: two different DOFs are no shape.
    let at = |z: &str| format!("at_m = [0.0, 0.0, {z}]");
    let mut scene = read(folder, "bar/scene.toml");
    let (whole, _, _) = said(folder, "run bar");
    assert!(whole.contains("3 by shape, 0 by frequency"), "{whole}");
    for z in ["0.25", "0.5", "0.75"] {
        assert!(scene.contains(&at(z)), "{scene}");
        scene = scene.replace(&at(z), &at("0.0"));
    }
    write(folder, &[("bar/scene.toml", &scene)]);
    let (screen, findings, code) = said(folder, "run bar --full");
    assert_eq!(code, Some(0), "{findings}");
    assert!(findings.contains("[few-dofs]"), "{findings}");
    assert!(
        findings.contains("of 5 in common several move alike in every mode of the model"),
        "{findings}"
    );
    assert!(!screen.contains("paired by shape"), "{screen}");
    assert!(
        screen.contains("fewer than 3 different DOFs in common"),
        "{screen}"
    );
    // The same of a list of frequencies.
    let list = "frequency_hz\n53.1\n146.3\n286.9\n";
    write(folder, &[("modes.csv", list)]);
    let (screen, _, code) = said(folder, "run bar");
    assert_eq!(code, Some(0), "{screen}");
    assert!(!screen.contains("--explain sensors-at-one"), "{screen}");
    let text = unwrapped(&screen);
    let next = "Next, as all pairs are by frequency alone: mode shapes at more points";
    assert!(text.contains(next), "{screen}");
    assert!(text.contains("modalign update bar"), "{screen}");
}

#[test]
fn an_update_that_does_not_fit_says_what_to_check() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    drafted(folder, &beam_modes("X").replace("146.3", "131.0"));
    let model = stated_values(&read(folder, "bar/model.toml"));
    write(folder, &[("bar/model.toml", &model)]);
    let (screen, findings, _) = said(folder, "update bar");
    let misfit = findings
        .lines()
        .find(|line| line.contains("[misfit-remains]"));
    let misfit = misfit.unwrap_or_else(|| panic!("{findings}"));
    let text = unwrapped(&screen);
    // The chi-square of the finding is that of the screen.
    let value = misfit
        .split('(')
        .nth(1)
        .and_then(|rest| rest.split(',').next());
    let value = value.unwrap_or_else(|| panic!("{misfit}"));
    assert!(
        text.contains(&format!("Chi-square per degree of freedom {value} ("))
            || text.contains(&format!(", of frequencies {value} ("))
            || text.contains(&format!(", of shapes {value} (")),
        "{misfit}\n{screen}"
    );
    let next =
        "Next, as the updated model does not fit: support, positions and directions of sensors";
    assert!(text.contains(next), "{screen}");
    // One parameter has no single changes.
    assert!(
        text.contains("a further [[parameter]], such as a mass"),
        "{screen}"
    );
    let second = "density_kg_per_m3 = \"density\"\n";
    let density = "\n[[parameter]]\nname = \"density\"\nunit = \"kg/m3\"\nnominal = 7850.0\n\
                   lower = 7000.0\nupper = 8500.0\nstatus = \"printed\"\n";
    let two = model.replace("density_kg_per_m3 = 7850.0\n", second) + density;
    let freed = "\n[update]\nparameters = [\"youngs_modulus\", \"density\"]\n";
    let scene = read(folder, "bar/scene.toml");
    write(
        folder,
        &[
            ("bar/model.toml", &two),
            ("bar/scene.toml", &(scene.clone() + freed)),
        ],
    );
    let (screen, findings, _) = said(folder, "update bar");
    let text = unwrapped(&screen);
    assert!(
        text.contains("explain = true in [update]"),
        "{screen}{findings}"
    );
    // A parameter of the model that the scene leaves out is the first to try.
    let one = freed.replace(", \"density\"", "");
    write(folder, &[("bar/scene.toml", &(scene.clone() + &one))]);
    let (screen, findings, _) = said(folder, "update bar");
    let text = unwrapped(&screen);
    assert!(
        text.contains("parameters that the update does not free: density"),
        "{screen}{findings}"
    );
    write(
        folder,
        &[("bar/model.toml", &model), ("bar/scene.toml", &scene)],
    );
    // A fit that determines its parameter has no such line.
    let good = beam_modes("X")
        .replace("53.1,", "53.158,")
        .replace("146.3,", "146.535,")
        .replace("286.9,", "287.27,");
    write(folder, &[("modes.csv", &good)]);
    let (screen, findings, _) = said(folder, "update bar");
    assert!(!screen.contains("Next"), "{screen}{findings}");
    assert!(screen.contains("\nFitted: modes.\n"), "{screen}");
    // Without limits a check would be an error: they come first.
    let (screen, findings, _) = said(folder, "update bar -o first");
    let text = unwrapped(&screen);
    let step = "[limits] in bar/scene.toml; then modalign check first/comparison-after.json --against bar.";
    assert!(text.contains(step), "{screen}{findings}");
    // With limits the next step is the command that judges the updated model by them.
    let limited = read(folder, "bar/scene.toml") + "\n[limits]\nmin_mac = 0.9\n";
    write(folder, &[("bar/scene.toml", &limited)]);
    let (screen, findings, _) = said(folder, "update bar -o out");
    let text = unwrapped(&screen);
    let (_, check) = text
        .split_once("meets the limits: modalign ")
        .unwrap_or_else(|| panic!("{screen}{findings}"));
    let check = check.split(". ").next().unwrap();
    assert_eq!(check, "check out/comparison-after.json --against bar");
    let (screen, findings, code) = said(folder, check);
    assert_eq!(code, Some(0), "{screen}{findings}");
}

#[test]
fn theory_and_correlate_say_that_the_stated_support_contradicts_the_model() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    drafted(folder, &beam_modes("X"));
    let model = stated_values(&read(folder, "bar/model.toml"));
    let contradicted = "[model-support-contradicted]";
    for (support, is_contradicted) in [("suspended", false), ("fixed", true)] {
        let stated = model.replace("\"suspended\"", &format!("\"{support}\""));
        write(folder, &[("bar/model.toml", &stated)]);
        for line in [
            "theory bar/model.toml",
            "theory bar",
            "correlate --test modes.csv --theory bar",
            "run bar",
        ] {
            let (_, findings, _) = said(folder, line);
            let count = findings.matches(contradicted).count();
            assert_eq!(count, usize::from(is_contradicted), "{line}: {findings}");
        }
    }
    // Weak springs may be those of a suspension, which a test alone shows.
    let spring = "\n[[spring]]\nname = \"sling\"\nbeam = \"beam\"\nat_m = [0.0, 0.0, 0.5]\n\
                  stiffness_n_per_m = 100.0\n";
    write(folder, &[("bar/model.toml", &(model.clone() + spring))]);
    let (_, findings, _) = said(folder, "theory bar");
    assert!(!findings.contains(contradicted), "{findings}");
    let held = model.replace("start = \"free\"", "start = \"clamped\"");
    write(folder, &[("bar/model.toml", &held)]);
    let (_, findings, _) = said(folder, "theory bar");
    assert!(findings.contains(contradicted), "{findings}");
}

#[test]
fn a_wrong_unit_of_the_model_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    drafted(folder, &beam_modes("X"));
    let model = stated_values(&read(folder, "bar/model.toml"));
    let (density, area) = (
        "density_kg_per_m3 = 7850.0",
        ["area_m2 = 3.0e-4", "second_moment_m4 = 2.5e-9"],
    );
    let in_mm = model
        .replace(area[0], "area_m2 = 1000.0")
        .replace(area[1], "second_moment_m4 = 90000.0");
    for (wrong, said_of_it) in [
        (in_mm, "The model has no mode in the band of a test"),
        (
            model.replace(density, "density_kg_per_m3 = 7.85"),
            "The model is far from the test",
        ),
    ] {
        assert_ne!(wrong, model);
        write(folder, &[("bar/model.toml", &wrong)]);
        let (screen, findings, code) = said(folder, "run bar");
        assert_eq!(code, Some(1), "{findings}");
        let text = unwrapped(&screen);
        for part in [
            said_of_it,
            "times that of the test: a unit of the model may be wrong.",
        ] {
            assert!(text.contains(part), "{part}: {screen}");
        }
        let next = screen.lines().filter(|line| line.starts_with("Next"));
        assert_eq!(next.count(), 1, "{screen}");
    }
}

#[test]
fn a_model_without_sensors_names_the_scene_as_theory() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    drafted(folder, &beam_modes("X"));
    let line = "correlate --test modes.csv --theory bar/model.toml";
    let (screen, findings, _) = said(folder, line);
    assert!(findings.contains("[model-without-sensors]"), "{findings}");
    let next =
        "Next, as bar/model.toml states no sensors and pairs are by frequency alone: --theory";
    assert!(unwrapped(&screen).contains(next), "{screen}");
}

#[test]
fn the_next_step_is_the_same_on_screen_in_report_and_json() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    drafted(folder, &beam_modes("X"));
    let model = stated_values(&read(folder, "bar/model.toml"));
    write(folder, &[("bar/model.toml", &model)]);
    let (screen, findings, code) = said(folder, "run bar -o out");
    assert_eq!(code, Some(0), "{findings}");
    let next = "Next, the parameters that bring the model to the test: modalign update bar.";
    assert!(screen.contains(next), "{screen}");
    for file in ["out/comparison.json", "out/report.json", "out/report.html"] {
        assert!(read(folder, file).contains(next), "{file}");
    }
    let scene = read(folder, "bar/scene.toml");
    let model = scene.find("[model]").unwrap();
    write(folder, &[("bar/scene.toml", &scene[..model])]);
    let (screen, findings, code) = said(folder, "run bar");
    assert_eq!(code, Some(0), "{findings}");
    let next = "Next, a model to compare with: [model] in bar/scene.toml";
    assert!(screen.contains(next), "{screen}");
}

#[test]
fn an_update_repeats_the_warnings_of_the_comparison_on_supports_and_sensors() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let points = POINTS.replace("0,0,0.5", "0,0,0.25");
    write(
        folder,
        &[("modes.csv", &beam_modes("X")), ("points.csv", &points)],
    );
    said(
        folder,
        "new bar modes.csv --model beam --points points.csv --band 20:400",
    );
    let model = stated_values(&read(folder, "bar/model.toml"));
    let scene = read(folder, "bar/scene.toml");
    let held = scene.replacen(
        "\n[model]\n",
        "[test.state]\nsupport = \"fixed\"\n\n[model]\n",
        1,
    );
    assert_ne!(held, scene);
    write(
        folder,
        &[("bar/model.toml", &model), ("bar/scene.toml", &held)],
    );
    for verb in ["run", "update"] {
        let (_, findings, _) = said(folder, &format!("{verb} bar"));
        for code in ["[support-differs]", "[sensors-at-one-position]"] {
            assert!(findings.contains(code), "{verb}: {code}: {findings}");
        }
    }
}

#[test]
fn pairs_in_doubt_ask_for_points_and_frames_before_an_update() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let [modes, points] = long_beam(0.98);
    write(folder, &[("modes.csv", &modes), ("points.csv", &points)]);
    said(
        folder,
        "new bar modes.csv --model beam --points points.csv --band 20:400",
    );
    let model = stated_values(&read(folder, "bar/model.toml"));
    write(folder, &[("bar/model.toml", &model)]);
    let (screen, _, _) = said(folder, "run bar");
    assert!(screen.contains("modalign update bar"), "{screen}");
    // Shapes with half of their values at one end.
    let mut rows = modes.lines();
    let mut disturbed = rows.next().unwrap().to_owned() + "\n";
    for row in rows {
        let mut cells: Vec<String> = row.split(',').map(str::to_owned).collect();
        for cell in &mut cells[2..5] {
            *cell = (0.3 * cell.parse::<f64>().unwrap()).to_string();
        }
        disturbed += &(cells.join(",") + "\n");
    }
    write(folder, &[("modes.csv", &disturbed)]);
    let (screen, findings, _) = said(folder, "run bar");
    let text = unwrapped(&screen);
    assert!(
        text.contains("without a MAC of 0.9: the frame"),
        "{screen}{findings}"
    );
    assert!(!text.contains("modalign update bar"), "{screen}");
}

#[test]
fn full_output_ends_with_the_next_step() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    drafted(folder, &beam_modes("X").replace("146.3", "131.0"));
    let model = stated_values(&read(folder, "bar/model.toml"));
    write(folder, &[("bar/model.toml", &model)]);
    for line in [
        "run bar",
        "update bar",
        "correlate --test modes.csv --theory bar/model.toml",
        "inspect modes.csv",
    ] {
        let (screen, findings, _) = said(folder, line);
        let next = screen
            .lines()
            .find(|line| line.starts_with("Next"))
            .unwrap();
        let (full, ..) = said(folder, &format!("{line} --full"));
        let (_, last) = full.trim_end().rsplit_once("\n\n").unwrap();
        assert!(last.starts_with(next), "{line}: {last}: {screen}{findings}");
        assert!(!last.contains("--full"), "{last}");
    }
}

#[test]
fn an_update_of_example_values_without_a_pair_names_them() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let [modes, points] = long_beam(2.5);
    write(folder, &[("modes.csv", &modes), ("points.csv", &points)]);
    said(
        folder,
        "new bar modes.csv --model beam --points points.csv --band 20:2000",
    );
    let (_, error, code) = said(folder, "update bar");
    assert_eq!(code, Some(2));
    for part in [
        "model.toml",
        "example_values: got true: the values are those of an example",
        "none of 3 test modes",
    ] {
        assert!(error.contains(part), "{error}");
    }
    let model = stated_values(&read(folder, "bar/model.toml"));
    write(folder, &[("bar/model.toml", &model)]);
    let (_, error, _) = said(folder, "update bar");
    assert!(!error.contains("example_values"), "{error}");
}

#[test]
fn an_update_counts_its_pairs_and_names_the_test_modes_without_one() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let extra = "200.0,0.004,2.0,1.9,-2.0,1.8,0.1\n";
    let modes = beam_modes("X").replace("286.9,", &format!("{extra}286.9,"));
    drafted(folder, &modes);
    let model = stated_values(&read(folder, "bar/model.toml"));
    write(folder, &[("bar/model.toml", &model)]);
    let (screen, findings, _) = said(folder, "update bar");
    let text = unwrapped(&screen);
    // The third mode of the test is no third mode of the model.
    assert!(
        text.contains("#3 (200.00 Hz) has no partner in the model"),
        "{screen}{findings}"
    );
    assert!(
        text.contains("Left out: 1 test mode without partner."),
        "{screen}"
    );
    assert!(!text.contains("The comparison has"), "{screen}");
    let scene = read(folder, "bar/scene.toml") + "\n[update]\nband_hz = [20.0, 160.0]\n";
    write(folder, &[("bar/scene.toml", &scene)]);
    let (screen, findings, _) = said(folder, "update bar");
    let text = unwrapped(&screen);
    assert!(
        text.contains("Before: 2 of 2 modes paired"),
        "{screen}{findings}"
    );
    assert!(
        text.contains("The comparison has 3 pairs: modes outside band_hz"),
        "{screen}"
    );
    let (run, _, _) = said(folder, "run bar");
    assert!(run.contains("Pairs: 3 of"), "{run}");
}

#[test]
fn the_next_steps_lead_from_hits_to_a_comparison() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    recorded_scene(folder);
    let step = |command: &str| {
        let (screen, error, code) = said(folder, command);
        assert_eq!(code, Some(0), "{command}: {error}");
        let mut lines = screen.lines();
        let next = lines.find_map(|line| line.strip_prefix("Next: modalign "));
        next.unwrap_or_default().trim_end_matches('.').to_owned()
    };
    let identify = step("frf hits.uff -o frfs.h5");
    let correlate = step(&format!("{identify} -o modes.json"));
    step(&correlate.replace("MODEL", "model.toml"));
}
