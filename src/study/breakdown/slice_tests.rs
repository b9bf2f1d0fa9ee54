//! Slices give the same cells however they are drawn, kept, split and merged; they show known
//! failures of methods.

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;

use crate::scene::parse;

use super::*;

fn plan(text: &str) -> Plan {
    let table: BreakdownTable = parse(text, "study.toml").unwrap();
    table.plan().unwrap()
}

/// Two small slices of cheap methods, and the numerical part.
const SMALL: &str = r#"
seed = 3
draws = 6
refine = 1
methods = ["circle", "line"]
stability = { highest_order = 4 }
case = { lines = 120 }
[[slice]]
x = { factor = "separation", lo = 0.5, hi = 8.0, count = 3, scale = "log" }
y = { factor = "noise", lo = 20.0, hi = 60.0, count = 2 }
[[slice]]
x = { factor = "hits", lo = 1, hi = 3, count = 3 }
y = { factor = "force_noise", lo = 20.0, hi = 60.0, count = 2 }
"#;

#[derive(Default)]
struct Memory {
    kept: RefCell<BTreeMap<String, String>>,
    /// Texts that it still takes; all without it.
    room: Cell<Option<usize>>,
}

impl CellStore for Memory {
    fn load(&self, name: &str) -> Result<Option<String>, String> {
        Ok(self.kept.borrow().get(name).cloned())
    }

    fn save(&self, name: &str, text: &str) -> Result<(), String> {
        match self.room.get() {
            Some(0) => return Err("no room".to_owned()),
            left => self.room.set(left.map(|room| room - 1)),
        }
        let mut kept = self.kept.borrow_mut();
        kept.insert(name.to_owned(), text.to_owned());
        Ok(())
    }
}

fn run(plan: &Plan, part: Part, store: &Memory) -> Result<BreakdownResults, BreakdownError> {
    compute(plan, part, store, &(), &())
}

fn in_threads(count: usize, work: impl FnOnce() -> BreakdownResults + Send) -> BreakdownResults {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build();
    pool.unwrap().install(work)
}

/// What a study came to, as text.
fn bytes(finished: &BreakdownResults) -> String {
    serde_json::to_string(&(&finished.slices, &finished.stability)).unwrap()
}

#[test]
fn threads_halves_and_parts_give_the_same_cells() {
    let plan = plan(SMALL);
    let whole = |count| {
        let finished = in_threads(count, || {
            run(&plan, Part::WHOLE, &Memory::default()).unwrap()
        });
        bytes(&finished)
    };
    let expected = whole(1);
    assert_eq!(whole(2), expected);
    // Times and cells of the first slice are kept, then the disk is full.
    let halved = Memory::default();
    halved.room.set(Some(2));
    assert!(matches!(
        run(&plan, Part::WHOLE, &halved),
        Err(BreakdownError::Store { .. })
    ));
    halved.room.set(None);
    let resumed = run(&plan, Part::WHOLE, &halved).unwrap();
    assert_eq!(resumed.reused, [plan.slices[0].name.clone()]);
    assert_eq!(bytes(&resumed), expected);
    // Batch jobs.
    let parts = [1, 2].map(|number| {
        let store = Memory::default();
        run(&plan, Part { number, count: 2 }, &store).unwrap();
        store
    });
    let stores: Vec<&dyn CellStore> = parts.iter().map(|store| store as &dyn CellStore).collect();
    let merged = merge(&plan, &stores, &Memory::default()).unwrap();
    assert_eq!(bytes(&merged), expected);
    let missing = merge(&plan, &stores[..1], &Memory::default());
    assert!(matches!(missing, Err(BreakdownError::Unfinished { .. })));
}

#[test]
fn cells_of_another_spec_are_refused_or_computed_again() {
    let plan = plan(SMALL);
    let other = self::plan(&SMALL.replace("seed = 3", "seed = 4"));
    let store = Memory::default();
    run(&plan, Part::WHOLE, &store).unwrap();
    let refused = merge(&other, &[&store], &Memory::default());
    assert!(matches!(refused, Err(BreakdownError::OtherSpec { .. })));
    let again = run(&other, Part::WHOLE, &store).unwrap();
    // The numerical part has no seed.
    assert_eq!(again.outdated.len(), 2);
    assert_eq!(again.reused, ["stability"]);
    let fresh = run(&other, Part::WHOLE, &Memory::default()).unwrap();
    assert_eq!(bytes(&again), bytes(&fresh));
}

#[test]
fn a_cell_has_the_same_draws_in_every_slice() {
    let plan = plan(SMALL);
    let wide = self::plan(&SMALL.replace("refine = 1", "refine = 0"));
    let cells = |plan: &Plan| {
        run(plan, Part::WHOLE, &Memory::default()).unwrap().slices[0]
            .cells
            .clone()
    };
    let refined = cells(&plan);
    for cell in cells(&wide) {
        let same = |other: &&super::Cell| (other.x, other.y) == (cell.x, cell.y);
        assert_eq!(refined.iter().find(same).unwrap().counts, cell.counts);
    }
    assert!(refined.len() > 6);
}

/// One cell at each end of a factor, with the share of a method in both.
fn ends(factor: &str, (lo, hi): (f64, f64), method: &str, case: &str) -> [f64; 2] {
    let (other, values) = match factor {
        "noise" => ("damping", (0.01, 0.011)),
        _ => ("noise", (60.0, 61.0)),
    };
    let text = format!(
        "draws = 16\nrefine = 0\nmethods = [{method:?}]\nstability = {{ highest_order = 0 }}\ncase = {{ {case} }}\n\
         [[slice]]\nx = {{ factor = {factor:?}, lo = {lo}, hi = {hi}, count = 2 }}\n\
         y = {{ factor = {other:?}, lo = {}, hi = {}, count = 2 }}\n",
        values.0, values.1
    );
    let finished = run(&plan(&text), Part::WHOLE, &Memory::default()).unwrap();
    let field = finished.slices[0].field(0, SuccessRate::Counted);
    [field.values[0][0], field.values[1][0]]
}

/// A method that does nearly always is good in 14 of 16 draws or more, one that fails in half of
/// them or fewer: a share of 98 % or of 30 % falls beyond that in less than 0.5 and 3 % of all
/// seeds.
fn fails_and_does([failing, doing]: [f64; 2]) {
    assert!(failing <= 0.5 && doing >= 14.0 / 16.0, "{failing} {doing}");
}

#[test]
fn peak_picking_fails_at_one_width_and_does_at_eight() {
    fails_and_does(ends("separation", (1.0, 8.0), "peak", "separation = 8"));
    let [close, _] = ends("separation", (1.0, 8.0), "lscf", "separation = 8");
    assert!(close >= 14.0 / 16.0, "{close}");
}

#[test]
fn one_reference_does_not_tell_a_repeated_root() {
    let share = |method| ends("references", (1.0, 2.0), method, "separation = 0.001");
    fails_and_does(share("ml"));
}

#[test]
fn force_noise_biases_h1_whatever_the_method() {
    let share = |method| ends("force_noise", (10.0, 70.0), method, "hits = 3");
    fails_and_does(share("circle"));
}

#[test]
fn user_modes_have_positions_and_margins_in_a_slice() {
    let plan = plan(SMALL);
    let finished = run(&plan, Part::WHOLE, &Memory::default()).unwrap();
    let mode = |noise: f64| UserMode {
        test: String::new(),
        number: 4,
        frequency_hz: 412.34,
        values: [(Factor::Separation, 7.0), (Factor::Noise, noise)].into(),
    };
    let slice = &finished.slices[0];
    let points = slice.locate_modes(&[mode(90.0), mode(59.0)]);
    assert!(points[0].is_inside() && !points[1].is_inside());
    assert_eq!(
        points[1].sentence(),
        "mode 4 (412.3 Hz) lies outside this slice."
    );
    let margins = &points[0].margins;
    assert!(margins.iter().all(|margin| margin.inside), "{margins:?}");
    let near = points[0].sentence();
    assert!(near.contains("decades of separation from where"), "{near}");
    // The contour lies between 1 and 7 widths.
    for margin in margins {
        let distance = margin.distance.unwrap();
        assert_eq!(distance.axis.factor, Factor::Separation);
        let decades = distance.value();
        assert!(decades > 0.0 && decades < 0.85, "{decades}");
    }
}
