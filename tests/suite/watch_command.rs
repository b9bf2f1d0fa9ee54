//! `frf --watch` keeps the list of points to hit again current while recordings arrive in a folder.

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use modalign::io::{WriteOptions, hit_source, write_path};
use modalign::record::{Hit, Samples};
use modalign::scene::{hammer_test, load_synth};
use modalign::synth::SecondContact;
use serde_json::Value;

use crate::command::{interruptible, modalign, write};
use crate::screen::assert_fits;

const SPEC: &str = r#"schema = "modalign-synth/1"
title = "three masses"
seed = 5
averages = 5
truth = { modes = "truth.json" }
record = { sampling_rate_hz = 2048, samples = 8192, pretrigger_s = 0.1, response = "acceleration" }
pulse = { duration_s = 2e-3, peak_n = 100, peak_spread = 0.1 }
noise = { force_snr_db = 70, response_snr_db = 60 }
[[hit]]
dofs = ["1:+Z", "2:+Z", "3:+Z"]
responses = ["1:+Z", "2:+Z"]
"#;
const TRUTH: &str = r#"{"schema": "modalign-modes/1", "modes": [
{"frequency_hz": 60.0, "damping_ratio": 0.01, "modal_mass_kg": 2.0, "shape": {"1:+Z": [1, 0], "2:+Z": [0.7, 0], "3:+Z": [0.5, 0]}},
{"frequency_hz": 210.0, "damping_ratio": 0.01, "modal_mass_kg": 2.0, "shape": {"1:+Z": [0.8, 0], "2:+Z": [-1, 0], "3:+Z": [0.6, 0]}}]}"#;

/// Five hits at each of three points, those at one point one after the other.
fn three_points(double: bool) -> Vec<Hit> {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), &[("truth.json", TRUTH), ("spec.toml", SPEC)]);
    let path = folder.path().join("spec.toml");
    let mut test = hammer_test(&load_synth(&path).unwrap(), &path).unwrap();
    test.faults.second_contact = double.then(|| SecondContact {
        delay_s: 0.02,
        ratio: 0.4,
        hits: (0..15).collect(),
    });
    test.generate().unwrap()
}

fn change(samples: &mut Samples, of: impl Fn(f64) -> f64) {
    let changed = samples.iter().map(of).collect();
    *samples = Samples::F64(changed);
}

/// The hit with a fifth of the force, 14 dB below.
fn weak(mut hit: Hit) -> Hit {
    let responses = hit.responses.iter_mut();
    for channel in responses.chain([&mut hit.force]) {
        change(&mut channel.samples, |value| 0.2 * value);
    }
    hit
}

/// The hit with its force clipped at half of its peak.
fn clipped(mut hit: Hit) -> Hit {
    let peak = hit.force.samples.iter().fold(0.0, f64::max);
    change(&mut hit.force.samples, |value| value.min(0.5 * peak));
    hit
}

fn write_hits(path: &Path, hits: &[Hit]) {
    let mut source = hit_source(hits, "hits");
    write_path(path, &mut source, WriteOptions::default()).unwrap();
}

/// `frf --watch` on a folder, ended with the test.
struct Watch {
    child: Child,
    lines: Receiver<String>,
}

impl Watch {
    fn start(folder: &Path, options: &[&str]) -> Self {
        let mut child = interruptible()
            .arg("frf")
            .arg("--watch")
            .arg(folder)
            .args(options)
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let out = BufReader::new(child.stdout.take().unwrap());
        let (sender, lines) = channel();
        std::thread::spawn(move || {
            for line in out.lines().map_while(Result::ok) {
                if sender.send(line).is_err() {
                    break;
                }
            }
        });
        Self { child, lines }
    }

    fn line(&self) -> String {
        let line = self.lines.recv_timeout(Duration::from_secs(60));
        line.expect("the watch prints the list")
    }

    fn json(&self) -> Value {
        serde_json::from_str(&self.line()).unwrap()
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The points to hit again with the names of their reasons.
fn listed(list: &Value) -> BTreeMap<String, Vec<String>> {
    let text = |value: &Value| value.as_str().unwrap().to_owned();
    let items = list["before_you_leave"].as_array();
    let points = items.map_or(&[][..], |items| {
        items[0]["points"].as_array().unwrap().as_slice()
    });
    let listed = points.iter().filter(|point| point["hit_again"] == true);
    listed
        .map(|point| {
            let reasons = point["reasons"].as_array().unwrap().iter();
            let reasons = reasons.map(|reason| text(&reason["reason"])).collect();
            (text(&point["reference"]), reasons)
        })
        .collect()
}

/// A folder that is watched, and the times from files to lists.
struct Rig {
    folder: tempfile::TempDir,
    watch: Watch,
    delays: Vec<Duration>,
}

impl Rig {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let watch = Watch::start(folder.path(), &["--json"]);
        Self {
            folder,
            watch,
            delays: Vec::new(),
        }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// The list after these bytes have been copied to a file.
    fn copy(&mut self, name: &str, bytes: &[u8]) -> Value {
        std::fs::write(self.path(name), bytes).unwrap();
        let begin = Instant::now();
        let list = self.watch.json();
        self.delays.push(begin.elapsed());
        assert_eq!(list["changed"], serde_json::json!([name]), "{list}");
        list
    }

    /// Asserts the points to hit again, with their reasons, after a hit has arrived.
    fn hit(&mut self, name: &str, hit: Hit, expected: &[(&str, &[&str])]) {
        let elsewhere = tempfile::tempdir().unwrap();
        let path = elsewhere.path().join(name);
        write_hits(&path, &[hit]);
        let list = self.copy(name, &std::fs::read(path).unwrap());
        self.assert_listed(&list, expected);
    }

    fn assert_listed(&self, list: &Value, expected: &[(&str, &[&str])]) {
        let expected = expected.iter().map(|(point, reasons)| {
            let reasons = reasons.iter().map(ToString::to_string).collect();
            ((*point).to_owned(), reasons)
        });
        assert_eq!(listed(list), expected.collect(), "{list}");
    }
}

#[test]
fn the_points_to_hit_again_are_right_after_each_file_that_arrives() {
    let (hits, double) = (three_points(false), three_points(true));
    let mut rig = Rig::new();
    assert_eq!(rig.watch.json()["used"], serde_json::json!([]));
    // Three good hits at the first point.
    let few: &[(&str, &[&str])] = &[("1:+Z", &["few-hits"])];
    rig.hit("hit01.uff", hits[0].clone(), few);
    rig.hit("hit02.uff", hits[1].clone(), few);
    rig.hit("hit03.uff", hits[2].clone(), &[]);
    // Bad hits at the second one: the list keeps them until good ones replace them.
    let second: &[&str] = &["double-hit", "overload", "few-hits"];
    rig.hit("hit04.uff", hits[5].clone(), &[("2:+Z", &["few-hits"])]);
    rig.hit(
        "hit05.uff",
        double[6].clone(),
        &[("2:+Z", &["double-hit", "few-hits"])],
    );
    rig.hit("hit06.uff", clipped(hits[7].clone()), &[("2:+Z", second)]);
    rig.hit("hit07.uff", hits[8].clone(), &[("2:+Z", second)]);
    rig.hit("hit08.uff", hits[9].clone(), &[]);
    // A weak hit at the third one.
    let third: &[&str] = &["weak-force", "few-hits"];
    rig.hit("hit09.uff", weak(hits[10].clone()), &[("3:+Z", third)]);
    // Files that are no recordings, or not whole ones, end nothing and are named.
    let list = rig.copy("notes.txt", b"rain from noon on\n");
    rig.assert_listed(&list, &[("3:+Z", third)]);
    let elsewhere = tempfile::tempdir().unwrap();
    let whole = elsewhere.path().join("whole.uff");
    write_hits(&whole, &hits[11..13]);
    let whole = std::fs::read(whole).unwrap();
    let list = rig.copy("hit10.uff", &whole[..2 * whole.len() / 3]);
    rig.assert_listed(&list, &[("3:+Z", third)]);
    let refused = list["not_used"].as_array().unwrap();
    let names: Vec<&str> = refused.iter().filter_map(|r| r["file"].as_str()).collect();
    assert_eq!(names, ["hit10.uff", "notes.txt"]);
    assert!(
        refused
            .iter()
            .all(|r| r["reason"].as_str().unwrap().len() > 20)
    );
    // The file is complete: two hits, and a third one ends the list.
    let list = rig.copy("hit10.uff", &whole);
    assert_eq!(list["not_used"].as_array().unwrap().len(), 1);
    rig.assert_listed(&list, &[("3:+Z", third)]);
    rig.hit("hit11.uff", hits[13].clone(), &[]);
    // The first point again at the end.
    let path = rig.path("hit12.uff");
    write_hits(&path, &hits[3..5]);
    let list = rig.watch.json();
    let drift = list["before_you_leave"].as_array().unwrap().last().unwrap();
    assert_eq!(drift["item"], "drift");
    assert_eq!(drift["first_hits"], serde_json::json!([1, 2, 3]));
    assert_eq!(drift["last_hits"], serde_json::json!([13, 14]));
    assert_eq!(drift["tested"], true);
    for resonance in drift["resonances"].as_array().unwrap() {
        for change in ["frequency", "residue"].map(|name| &resonance[name]) {
            let value = |key: &str| change[key].as_f64().unwrap();
            assert!(value("change").abs() < value("limit"), "{drift}");
        }
    }
    // A file that is taken away, too.
    std::fs::remove_file(rig.path("hit01.uff")).unwrap();
    std::fs::remove_file(rig.path("hit12.uff")).unwrap();
    rig.assert_listed(&rig.watch.json(), few);
    rig.delays.sort();
    let median = rig.delays[rig.delays.len() / 2];
    println!("median delay {median:?}, largest {:?}", rig.delays.last());
}

#[test]
fn hits_are_numbered_in_the_order_in_which_they_arrive() {
    let hits = three_points(false);
    let mut rig = Rig::new();
    rig.watch.json();
    // By name hit10 and hit11 would be the first hits at their point, and the drift that between
    // the hits in the middle and the last ones.
    let arriving = [("hit8", 0), ("hit9", 1), ("hit10", 5), ("hit11", 2)];
    let elsewhere = tempfile::tempdir().unwrap();
    let mut used = Vec::new();
    for (name, hit) in arriving {
        let name = format!("{name}.uff");
        let path = elsewhere.path().join(&name);
        write_hits(&path, &[hits[hit].clone()]);
        let list = rig.copy(&name, &std::fs::read(path).unwrap());
        used.push(name);
        assert_eq!(list["used"], serde_json::json!(used));
        if hit == 2 {
            let drift = list["before_you_leave"].as_array().unwrap().last().unwrap();
            assert_eq!(drift["first_hits"], serde_json::json!([1, 2]), "{drift}");
            assert_eq!(drift["last_hits"], serde_json::json!([4]), "{drift}");
        }
    }
}

#[test]
fn a_watch_prints_the_section_and_an_interrupt_ends_it_well() {
    let folder = tempfile::tempdir().unwrap();
    write_hits(&folder.path().join("hits.uff"), &three_points(false)[..7]);
    let mut watch = Watch::start(folder.path(), &[]);
    let mut text = String::new();
    while !text.contains("Drift:") {
        text += &(watch.line() + "\n");
    }
    for expected in [
        "hits.uff: 1 file with 7 hits.",
        "Before you leave: hit again 1 of 2 points.",
        "- 2:+Z: 2 good hits of 3; best hits ",
        "Linearity: not tested; ",
        "Reciprocity: 1 pair within the limit; ",
        "Driving points: 2 FRFs with the right sign.",
    ] {
        assert!(text.contains(expected), "{expected}\n{text}");
    }
    assert_fits(&text, 20, 100, "watch");
    #[cfg(unix)]
    {
        let id = watch.child.id().to_string();
        let sent = Command::new("kill").args(["-INT", &id]).status().unwrap();
        assert!(sent.success());
        assert_eq!(watch.child.wait().unwrap().code(), Some(0));
    }
}

#[test]
fn a_folder_that_is_not_there_is_an_error() {
    let output = modalign(["frf", "--watch", "no-such-folder"]);
    assert_eq!(output.status.code(), Some(2));
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(
        error.contains("--watch") && error.contains("no-such-folder"),
        "{error}"
    );
    let output = modalign(["frf", "hits.uff", "--watch", "."]);
    assert_eq!(output.status.code(), Some(2));
}
