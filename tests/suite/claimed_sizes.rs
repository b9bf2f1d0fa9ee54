//! Numbers of an input that memory and time grow with: what is too large is an error at once,
//! before the memory is taken.

use std::io::Write;
use std::path::Path;

use hdf5_pure::FileBuilder;

use crate::command::{modalign_in, root, write};

/// Values of an array of 80 MB.
const VALUES: usize = 10_000_000;

/// Runs a line in a folder; the message of its error.
fn refused(folder: &Path, line: &str) -> String {
    let ran = modalign_in(folder, line.split(' '));
    let message = String::from_utf8_lossy(&ran.stderr).into_owned();
    assert_eq!(ran.status.code(), Some(2), "{line}: {message}");
    message
}

/// A scene of a table whose array is of zeros.
fn scene_of_array(folder: &Path, file: &str) {
    let channel = |role: &str, dof: &str, unit: &str| {
        format!(
            "[[test.channel]]\ncolumn = \"a\"\nrole = \"{role}\"\ndof = \"{dof}\"\nunit = \"{unit}\"\n"
        )
    };
    let scene = format!(
        "schema = \"modalign-scene/1\"\ntitle = \"x\"\n[[test]]\nname = \"t\"\nfiles = [\"{file}\"]\nhits = \"files\"\nsampling_rate_hz = 1000.0\n{}{}",
        channel("force", "1:+Z", "N"),
        channel("response", "2:+Z", "m/s2")
    );
    write(folder, &[("scene.toml", &scene)]);
}

#[test]
fn arrays_beyond_the_memory_are_named_before_they_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let mut builder = FileBuilder::new();
    let zeros = vec![0.0; VALUES];
    builder
        .create_dataset("a")
        .with_f64_data(&zeros)
        .with_shape(&[1, VALUES as u64])
        .with_chunks(&[1, 1 << 16])
        .with_deflate(6);
    std::fs::write(path("a.h5"), builder.finish().unwrap()).unwrap();
    // An array of numpy in an archive.
    let head = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({VALUES},), }}");
    let padded = format!("{head:<117}\n");
    let mut archive = zip::ZipWriter::new(std::fs::File::create(path("a.npz")).unwrap());
    archive
        .start_file("a.npy", zip::write::SimpleFileOptions::default())
        .unwrap();
    archive.write_all(b"\x93NUMPY\x01\x00\x76\x00").unwrap();
    archive.write_all(padded.as_bytes()).unwrap();
    archive.write_all(&vec![0; 8 * VALUES]).unwrap();
    archive.finish().unwrap();
    for name in ["a.h5", "a.npz"] {
        assert!(std::fs::metadata(path(name)).unwrap().len() < 1_000_000);
        scene_of_array(folder.path(), name);
        let message = refused(folder.path(), "run . --max-memory 64M");
        assert!(
            message.contains(name) && message.contains("\"a\": got 0.1 GB"),
            "{message}"
        );
        assert!(message.contains("--max-memory"), "{message}");
    }
    // With memory enough the values are read, and are no hits.
    let message = refused(folder.path(), "run . --max-memory 2G");
    assert!(!message.contains("--max-memory"), "{message}");
    let message = refused(folder.path(), "inspect a.h5 --max-memory lots");
    assert!(message.contains("such as 500M or 4G"), "{message}");
}

#[test]
fn orders_sweeps_starts_and_draws_have_limits() {
    let folder = tempfile::tempdir().unwrap();
    let beam = root().join("measurements/free-free-beam");
    let text = |name: &str| std::fs::read_to_string(beam.join(name)).unwrap();
    let scene =
        |starts: &str| text("scene.toml").replace("[update]\n", &format!("[update]\n{starts}\n"));
    write(
        folder.path(),
        &[
            ("scene.toml", &scene("")),
            ("model.toml", &text("model.toml")),
            ("synth.toml", &text("synth.toml")),
            (
                "study.toml",
                "schema = \"modalign-study/1\"\n[speed_accuracy]\norders = [1000000000]\n",
            ),
        ],
    );
    let many = "1000000000";
    for (line, expected) in [
        (
            format!("theory model.toml --sweep youngs_modulus=1.9e11:2.2e11:{many}"),
            "2 to 10000 values",
        ),
        (
            "theory model.toml --sweep youngs_modulus=1.9e11:2.2e11:9999".to_owned(),
            "2 to 60",
        ),
        (
            format!("study speed-accuracy model.toml --draws {many}"),
            "expected",
        ),
        (
            "study speed-accuracy study.toml".to_owned(),
            "orders of 4 to 500",
        ),
        (
            format!("study speed-accuracy scene.toml --draws {many}"),
            "1 to 100000",
        ),
    ] {
        let message = refused(folder.path(), &line);
        assert!(message.contains(expected), "{line}: {message}");
    }
    for method in ["lscf", "rfp", "lsce", "ml"] {
        let identify = format!("[identify]\norder = {many}\nmethod = \"{method}\"");
        let circle = "[identify]\nmethod = \"circle\"";
        write(
            folder.path(),
            &[("scene.toml", &scene("").replace(circle, &identify))],
        );
        let message = refused(folder.path(), "run .");
        assert!(message.contains("4 to 500"), "{method}: {message}");
    }
    for (key, expected) in [("starts", "1 to 10000"), ("max_iterations", "1 to 100000")] {
        write(
            folder.path(),
            &[("scene.toml", &scene(&format!("{key} = {many}")))],
        );
        let message = refused(folder.path(), "update .");
        assert!(message.contains(expected), "{key}: {message}");
    }
}

#[test]
fn models_of_too_many_coordinates_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let bodies = |count: usize, free: &str| {
        let body = |i: usize| {
            format!(
                "[[body]]\nname = \"b{i}\"\nat_m = [0.0, 0.0, 0.0]\nmass_kg = 1.0\ninertia_kg_m2 = [1.0, 1.0, 1.0]\nfree = [{free}]\n"
            )
        };
        let bodies: String = (0..count).map(body).collect();
        format!("schema = \"modalign-model/1\"\ntitle = \"x\"\n{bodies}")
    };
    let all = "\"x\", \"y\", \"z\", \"rx\", \"ry\", \"rz\"";
    for (count, free) in [(20_000, "\"x\""), (1_000, all)] {
        write(folder.path(), &[("m.toml", &bodies(count, free))]);
        let message = refused(folder.path(), "theory m.toml");
        assert!(message.contains("fewer than 4000"), "{message}");
    }
    // Free bodies without springs share one root of that multiplicity.
    write(folder.path(), &[("m.toml", &bodies(300, "\"x\""))]);
    let ran = modalign_in(folder.path(), ["theory", "m.toml"]);
    assert!(ran.status.success());
    let beam = |name: &str, elements: usize| {
        format!(
            "[[beam]]\nname = \"{name}\"\nfrom_m = [0.0, 0.0, 0.0]\nto_m = [1.0, 0.0, 0.0]\ndeflection = [0.0, 0.0, 1.0]\nelements = {elements}\nstart = \"free\"\nend = \"free\"\nyoungs_modulus_pa = 2e11\ndensity_kg_per_m3 = 7850.0\narea_m2 = 1e-4\nsecond_moment_m4 = 1e-9\n"
        )
    };
    for beams in [
        vec![("a", 1_500), ("b", 1_500)],
        vec![("a", usize::MAX >> 1), ("b", 1)],
    ] {
        let beams: String = beams
            .iter()
            .map(|(name, count)| beam(name, *count))
            .collect();
        let model =
            format!("schema = \"modalign-model/1\"\nkind = \"beam\"\ntitle = \"x\"\n{beams}");
        write(folder.path(), &[("m.toml", &model)]);
        let message = refused(folder.path(), "theory m.toml");
        assert!(message.contains("at most 2000"), "{message}");
    }
}

#[cfg(unix)]
#[test]
fn a_text_without_an_end_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let scene = "schema = \"modalign-scene/1\"\ntitle = \"x\"\n[model]\nfile = \"m.toml\"\n";
    write(folder.path(), &[("scene.toml", scene)]);
    let model = folder.path().join("m.toml");
    std::os::unix::fs::symlink("/dev/zero", &model).unwrap();
    let message = refused(folder.path(), "run .");
    assert!(message.contains("it is a device"), "{message}");
    std::fs::remove_file(&model).unwrap();
    // Zeros that take no room on the disk.
    let file = std::fs::File::create(&model).unwrap();
    file.set_len(300 << 20).unwrap();
    let message = refused(folder.path(), "run .");
    assert!(message.contains("at most 256 MiB"), "{message}");
}
