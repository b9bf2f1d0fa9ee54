//! The export in `measurements/testlab-bar` is what its specification gives, and leads from
//! `inspect` to an updated model.

use std::path::Path;

use crate::command::{json, root, succeed};

/// Largest relative difference of a value of the export that is made again: values have 32 bits,
/// and identified modes six digits.
const MAX_DIFFERENCE: f64 = 1e-5;

fn sample(name: &str) -> String {
    let path = root().join("measurements/testlab-bar").join(name);
    path.to_str().unwrap().to_owned()
}

/// The values of 32 bits of each function of a universal file.
fn functions(bytes: &[u8]) -> Vec<Vec<f32>> {
    let starts = bytes.windows(9).enumerate();
    let starts = starts.filter(|(_, window)| *window == b"\n    58b ");
    let values = |(start, _): (usize, &[u8])| {
        let head = &bytes[start + 1..];
        let line = std::str::from_utf8(&head[..80]).unwrap();
        let count: usize = line[31..43].trim().parse().unwrap();
        let after_head = head.iter().enumerate().filter(|(_, byte)| **byte == b'\n');
        let first = after_head.map(|(place, _)| place + 1).nth(11).unwrap();
        let values = head[first..first + count].chunks_exact(4);
        values
            .map(|four| f32::from_le_bytes(four.try_into().unwrap()))
            .collect()
    };
    starts.map(values).collect()
}

/// The numbers of the modes of a universal file: of each line of dataset 55.
fn mode_numbers(bytes: &[u8]) -> Vec<f64> {
    let text = String::from_utf8_lossy(bytes);
    let blocks = text.split("\n    -1\n    -1\n    55\n").skip(1);
    let numbers = blocks.flat_map(|block| {
        let block = block.split("\n    -1\n").next().unwrap();
        let words: Vec<f64> = block
            .split_whitespace()
            .filter_map(|word| word.parse().ok())
            .collect();
        words
    });
    numbers.collect()
}

#[test]
fn the_export_is_what_its_specification_gives() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let [hits, frfs, modes, export] = ["hits.uff", "frfs.uff", "modes.json", "bar.unv"].map(path);
    succeed(["synth", &sample("synth.toml"), "-o", &hits]);
    succeed(["frf", &hits, "-o", &frfs]);
    succeed(["identify", &frfs, "-o", &modes]);
    let geometry = sample("geometry.unv");
    succeed([
        "convert", &geometry, &hits, &frfs, &modes, "-o", &export, "--single",
    ]);
    let [made, kept] = [export, sample("bar.unv")].map(|path| std::fs::read(path).unwrap());
    assert!(kept.len() < 500_000, "{} bytes", kept.len());
    let (of_made, of_kept) = (functions(&made), functions(&kept));
    assert_eq!(of_kept.len(), 49);
    assert_eq!(of_made.len(), of_kept.len());
    for (made, kept) in of_made.iter().zip(&of_kept) {
        assert_eq!(made.len(), kept.len());
        let largest = kept.iter().fold(0.0_f32, |max, value| max.max(value.abs()));
        for (made, kept) in made.iter().zip(kept) {
            assert!(f64::from((made - kept).abs()) <= MAX_DIFFERENCE * f64::from(largest));
        }
    }
    let (of_made, of_kept) = (mode_numbers(&made), mode_numbers(&kept));
    assert!(of_kept.len() > 3 * 6 * 6, "{}", of_kept.len());
    assert_eq!(of_made.len(), of_kept.len());
    let largest = of_kept
        .iter()
        .fold(0.0_f64, |max, value| max.max(value.abs()));
    for (made, kept) in of_made.iter().zip(&of_kept) {
        // Six digits are written; imaginary parts of shapes, up to 0.01, are noise.
        let scale = kept.abs().max(1e-9 * largest);
        assert!(
            (made - kept).abs() <= 10.0 * MAX_DIFFERENCE * scale.max(0.1),
            "{made} {kept}"
        );
    }
}

#[test]
fn the_export_leads_to_the_modulus_of_its_recording() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("bar");
    let scene = scene.to_str().unwrap();
    let inspected = succeed(["inspect", &sample("bar.unv")]);
    for part in ["6 nodes", "3 modes", "6 points, +Z", "m/s2", "2048"] {
        assert!(inspected.contains(part), "{part}: {inspected}");
    }
    let model = sample("model.toml");
    let drafted = succeed(["new", scene, &sample("bar.unv"), "--model", &model]);
    assert!(drafted.contains("nothing is left to fill in"), "{drafted}");
    let screen = succeed(["run", scene]);
    assert!(
        screen.contains("Within 5 % and MAC 0.9: 3 of 3 modes"),
        "{screen}"
    );
    let out = folder.path().join("out");
    succeed(["update", scene, "-o", out.to_str().unwrap()]);
    let update = json(Path::new(&out.join("update.json")));
    let modulus = &update["parameters"][0];
    assert_eq!(modulus["verdict"], "identified");
    let [low, high] = [0, 1].map(|end| modulus["interval_95"][end].as_f64().unwrap());
    assert!(low < 2.02e11 && 2.02e11 < high, "{low} {high}");
}
