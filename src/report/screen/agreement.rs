//! Sentences say whether the model agrees with its tests, and by which errors, MAC and pairs.

use crate::correlate::{Basis, ComparisonTable, Row, Status, TestCell};
use crate::printable::{counted, listed};
use crate::report::Cell;

use super::MAC_DECIMALS;

/// Maximum frequency error of a mode on which model and test agree, percent: customary in modal
/// correlation of spacecraft, where secondary sources attribute it to NASA-STD-5002. Larger, at 20:
/// every pair agrees, since farther modes are no pair. Smaller, at 1: models that a paper calls
/// validated do not agree. Test `each_test_is_said_to_agree_to_differ_or_to_show_nothing`.
const MAX_ERROR_PERCENT: f64 = 5.0;
/// Minimum MAC of such a mode, a customary limit of modal correlation. Larger, at 0.99: noise of a
/// good test is disagreement. Smaller, at 0.7: shapes of other modes agree. The same test.
pub(super) const MIN_MAC: f64 = 0.9;

/// What a test says of its model.
#[derive(Clone, Copy, PartialEq)]
enum Answer {
    /// Every mode that the test could show agrees in frequency and shape.
    Agrees,
    /// Not every mode agrees.
    Differs,
    /// No pair rests on its shape.
    NotShown,
}

/// The modes of one or more tests with one answer.
struct Group<'t> {
    tests: Vec<&'t str>,
    /// Modes that the tests could show.
    modes: usize,
    agreeing: usize,
    cells: Vec<(&'t Row, &'t TestCell)>,
}

/// A sentence for the tests from which the model differs, for those that show neither, and for
/// those with which it agrees; none for tests without a pair.
pub(super) fn agreement(table: &ComparisonTable) -> Vec<String> {
    let answers = [Answer::Differs, Answer::NotShown, Answer::Agrees];
    let mut groups = answers.map(|answer| (answer, None::<Group>));
    for summary in &table.summary {
        let cells = || {
            let rows = table.rows.iter();
            let all = rows.flat_map(|row| row.tests.iter().map(move |cell| (row, cell)));
            all.filter(|(_, cell)| cell.test == summary.test)
        };
        let pairs: Vec<_> = cells()
            .filter(|(_, cell)| cell.error_percent.is_some())
            .collect();
        if pairs.is_empty() {
            continue;
        }
        // Whether the test could show the others is unknown.
        let modes = summary.paired + summary.ambiguous + summary.missed - summary.not_judged;
        let agreeing = cells().filter(|(_, cell)| agrees(cell)).count();
        let by_shape = |(_, cell): &(&Row, &TestCell)| cell.basis == Some(Basis::Shape);
        let answer = match (pairs.iter().any(by_shape), agreeing == modes) {
            (false, _) => Answer::NotShown,
            (true, true) if summary.extra == 0 => Answer::Agrees,
            (true, _) => Answer::Differs,
        };
        let slot = groups.iter_mut().find(|(of_group, _)| *of_group == answer);
        let Some((_, slot)) = slot else { continue };
        let group = slot.get_or_insert_with(|| Group {
            tests: Vec::new(),
            modes: 0,
            agreeing: 0,
            cells: Vec::new(),
        });
        group.tests.push(&summary.test);
        group.modes += modes;
        group.agreeing += agreeing;
        group.cells.extend(pairs);
    }
    let several = table.summary.len() > 1;
    let sentence =
        |(answer, group): (Answer, Option<Group>)| Some(group?.sentence(answer, several));
    groups.into_iter().filter_map(sentence).collect()
}

/// Whether model and test agree on a mode.
fn agrees(cell: &TestCell) -> bool {
    cell.status == Status::Paired
        && has_high_mac(cell)
        && cell
            .error_percent
            .is_some_and(|error| error.abs() <= MAX_ERROR_PERCENT)
}

/// Whether a pair rests on a shape on which model and test agree.
pub(super) fn has_high_mac(cell: &TestCell) -> bool {
    cell.basis == Some(Basis::Shape) && cell.mac.is_some_and(|mac| mac >= MIN_MAC)
}

impl Group<'_> {
    fn sentence(&self, answer: Answer, several: bool) -> String {
        let tests = match several {
            true => listed(&self.tests),
            false => "the test".to_owned(),
        };
        let (agreeing, numbers) = (self.agreeing, self.numbers(several));
        let modes = counted(self.modes, "mode");
        let criterion = format!("Within {MAX_ERROR_PERCENT} % and MAC {MIN_MAC}");
        match answer {
            Answer::Agrees => format!(
                "{criterion}: {agreeing} of {modes}. The model agrees with {tests}: {numbers}."
            ),
            Answer::Differs => format!(
                "{criterion}: {agreeing} of {modes}. The model differs from {tests}: {numbers}."
            ),
            Answer::NotShown => format!(
                "Agreement is not shown for {tests}: all pairs are by frequency alone; {numbers}."
            ),
        }
    }

    /// The errors, and the smallest MAC where there is one.
    fn numbers(&self, several: bool) -> String {
        let errors = self.cells.iter();
        let errors: Vec<f64> = errors.filter_map(|(_, cell)| cell.error_percent).collect();
        let squares: f64 = errors.iter().map(|error| error * error).sum();
        let rms = (squares / errors.len() as f64).sqrt();
        let size = |cell: &TestCell| cell.error_percent.map_or(0.0, f64::abs);
        let worst = self.cells.iter();
        let worst = worst.max_by(|(_, a), (_, b)| size(a).total_cmp(&size(b)));
        let largest = worst.map_or_else(String::new, |(row, cell)| {
            let error = Cell::signed(cell.error_percent, 3).display();
            let test = match several {
                true => format!(" ({})", cell.test),
                false => String::new(),
            };
            format!(", largest {error} % at {}{test}", row.label)
        });
        // Of a pair by frequency alone the MAC is no evidence.
        let by_shape = self.cells.iter();
        let by_shape = by_shape.filter(|(_, cell)| cell.basis == Some(Basis::Shape));
        let macs = by_shape.filter_map(|(_, cell)| cell.mac);
        let mac = macs.reduce(f64::min).map_or_else(String::new, |mac| {
            format!(
                ", smallest MAC {}",
                Cell::mac(Some(mac), MAC_DECIMALS).display()
            )
        });
        format!("rms error {rms:.3} %{largest}{mac}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correlate::{ErrorReference, SummedCell, TheoryCell, summary_of_cells};

    /// A test with pairs of these errors (percent) and MAC, by shape or by frequency.
    fn cells(test: &str, pairs: &[(f64, f64)], basis: Basis) -> Vec<TestCell> {
        let cell = |(error, mac): &(f64, f64)| TestCell {
            test: test.to_owned(),
            modes: vec![1],
            hz: Some(100.0 + error),
            hz_std: None,
            error_percent: Some(*error),
            error_hz: Some(*error),
            normalised_error: None,
            damping_ratio: None,
            damping_std: None,
            mac: Some(*mac),
            basis: Some(basis),
            chance_level: None,
            uncorrelated: false,
            angles_deg: None,
            status: Status::Paired,
            doubts: Vec::new(),
            reasons: Vec::new(),
            observability: None,
        };
        pairs.iter().map(cell).collect()
    }

    fn table(tests: &[Vec<TestCell>]) -> ComparisonTable {
        let rows = (0..tests[0].len()).map(|index| Row {
            label: format!("f{}", index + 1),
            theory: Some(TheoryCell {
                modes: vec![index + 1],
                hz: 100.0,
            }),
            tests: tests.iter().map(|cells| cells[index].clone()).collect(),
        });
        let summary = |cells: &Vec<TestCell>| {
            let summed: Vec<SummedCell> = cells.iter().map(SummedCell::from).collect();
            summary_of_cells(&cells[0].test, 6, &summed)
        };
        ComparisonTable {
            error_reference: ErrorReference::Theory,
            rows: rows.collect(),
            summary: tests.iter().map(summary).collect(),
            dofs_used: 6,
            footnotes: Vec::new(),
        }
    }

    #[test]
    fn each_test_is_said_to_agree_to_differ_or_to_show_nothing() {
        let pairs = [(-3.0, 0.95), (4.0, 0.99)];
        let of_one = |cells: Vec<TestCell>| agreement(&table(&[cells]));
        assert_eq!(
            of_one(cells("bar", &pairs, Basis::Shape)),
            [
                "Within 5 % and MAC 0.9: 2 of 2 modes. The model agrees with the test: rms error 3.536 %, \
              largest +4.000 % at f2, smallest MAC 0.950."
            ]
        );
        for other in [[(-3.0, 0.95), (6.0, 0.99)], [(-3.0, 0.85), (4.0, 0.99)]] {
            let said = of_one(cells("bar", &other, Basis::Shape));
            assert!(
                said[0].starts_with("Within 5 % and MAC 0.9: 1 of 2 modes. The model differs"),
                "{said:?}"
            );
        }
        let all = table(&[
            cells("bar", &pairs, Basis::Frequency),
            cells("rod", &pairs, Basis::Shape),
        ]);
        let said = agreement(&all);
        assert!(said[1].contains("The model agrees with rod: "), "{said:?}");
        assert_eq!(
            said[0],
            "Agreement is not shown for bar: all pairs are by frequency alone; rms error 3.536 %, \
             largest +4.000 % at f2 (bar)."
        );
    }

    #[test]
    fn modes_that_the_points_do_not_see_are_named_with_their_tests() {
        use crate::report::screen::sentences::unseen_modes;
        let pairs = [(-3.0, 0.95), (4.0, 0.99), (1.0, 0.99), (2.0, 0.99)];
        assert_eq!(
            unseen_modes("Model modes", &table(&[cells("bar", &pairs, Basis::Shape)])),
            None
        );
        let mut bar = cells("bar", &pairs, Basis::Shape);
        bar[1].status = Status::NotObservable;
        bar[3].status = Status::MissedUnexpected;
        assert_eq!(
            unseen_modes("Model modes", &table(&[bar.clone()])).unwrap(),
            "Model modes without partner: not observable at the points: f2; unmatched, observability unknown: f4."
        );
        let mut rod = cells("rod", &pairs, Basis::Shape);
        rod[1].status = Status::NotObservable;
        let both = unseen_modes("Model modes", &table(&[bar, rod])).unwrap();
        assert!(both.contains("points: f2 (bar, rod); "), "{both}");
    }
}
