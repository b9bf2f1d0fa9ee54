//! The section *Before you leave* lists what to repeat or to add while the structure is there:
//! points to hit again with their reasons, linearity, reciprocity, driving points, drift, mass line
//! and support.

use crate::dof::Dof;
use crate::finding::Location;
use crate::frf::rigid_body::{MassComparison, NoMass, Repair, RigidBody, SensorFault};
use crate::frf::{
    BeforeYouLeave, Cause, CheckItem, Drift, DrivingPoints, HitAgain, Linearity, MIN_GOOD_HITS,
    MassLineCheck, PairFigures, PointCheck, Reason, ResonanceDrift, SupportCheck,
};
use crate::printable::counted;
use crate::signal::Rule;

use super::table::significant;
use super::{Block, Cell, Column, Table};

/// Points to hit again that the screen has a line for.
const MAX_LISTED_POINTS: usize = 3;
/// Points that a line names.
const MAX_NAMED_POINTS: usize = 6;
/// Best hits that a line names.
const MAX_NAMED_HITS: usize = 3;

/// The section as a screen shows it: a line for each item, and one for each of the first points.
pub fn before_you_leave_screen(list: &BeforeYouLeave) -> Block {
    let mut lines = vec![headline(list)];
    if let Some(points) = points(list) {
        lines.extend(point_lines(points));
    }
    lines.extend(item_lines(list));
    Block::Text(lines.join("\n"))
}

/// The whole section: every excitation point with its hits, and every item.
pub fn before_you_leave_blocks(list: &BeforeYouLeave) -> Vec<Block> {
    let mut blocks = vec![Block::Text(headline(list))];
    blocks.extend(points(list).map(points_table));
    let mut lines = item_lines(list);
    for item in &list.items {
        match item {
            CheckItem::Linearity(linearity) => lines.extend(dependence_lines(linearity)),
            CheckItem::Drift(Some(drift)) => lines.extend(drift.resonances.iter().map(drift_line)),
            _ => (),
        }
    }
    blocks.push(Block::Text(lines.join("\n")));
    blocks
}

/// One line for a test of a scene.
pub fn before_you_leave_line(test: &str, list: &BeforeYouLeave) -> String {
    let listed = points(list).map(|points| match points.listed().next() {
        None => "enough good hits at every point".to_owned(),
        Some(_) => format!("hit again {}", points_with_reason(points)),
    });
    let with = |state: State, words: &str| {
        let names = list.items.iter().filter(|item| item_state(item) == state);
        let names: Vec<&str> = names.filter_map(item_name).collect();
        (!names.is_empty()).then(|| format!("{words}{}", names.join(", ")))
    };
    let parts = [
        listed,
        with(State::Wrong, "beyond the limit: "),
        with(State::NotTested, "not tested: "),
    ];
    let parts: Vec<String> = parts.into_iter().flatten().collect();
    let text = match parts.is_empty() {
        true => "nothing to repeat".to_owned(),
        false => parts.join("; "),
    };
    format!("Before you leave, {test}: {text}.")
}

/// The points to hit again with the first reason of each; points with one reason together, of many
/// the first.
fn points_with_reason(points: &HitAgain) -> String {
    let mut groups: Vec<(String, Vec<&Dof>)> = Vec::new();
    for point in points.listed() {
        let reason = point.reasons.first().map(reason_text).unwrap_or_default();
        match groups.iter_mut().find(|(other, _)| *other == reason) {
            Some((_, names)) => names.push(&point.reference),
            None => groups.push((reason, vec![&point.reference])),
        }
    }
    let (shown, further) = groups.split_at(groups.len().min(MAX_LISTED_POINTS));
    let text = |(reason, names): &(String, Vec<&Dof>)| format!("{}: {reason}", named(names));
    let further: Vec<&Dof> = further
        .iter()
        .flat_map(|(_, names)| names)
        .copied()
        .collect();
    let further = (!further.is_empty()).then(|| format!("{} (--full)", named(&further)));
    let texts: Vec<String> = shown.iter().map(text).chain(further).collect();
    texts.join(", ")
}

fn points(list: &BeforeYouLeave) -> Option<&HitAgain> {
    list.items.iter().find_map(|item| match item {
        CheckItem::HitAgain(points) => Some(points),
        _ => None,
    })
}

fn headline(list: &BeforeYouLeave) -> String {
    let Some(points) = points(list) else {
        return "Before you leave: excitation by a shaker, no hits to repeat.".to_owned();
    };
    let all = points.points.len();
    match points.listed().count() {
        0 => format!(
            "Before you leave: enough good hits at {}.",
            match all {
                1 => "the only point".to_owned(),
                all => format!("all {all} points"),
            }
        ),
        listed => format!(
            "Before you leave: hit again {listed} of {}.",
            counted(all, "point")
        ),
    }
}

/// A line for each of the first points to hit again; points of the same reasons share one.
fn point_lines(points: &HitAgain) -> Vec<String> {
    let mut groups: Vec<(String, Vec<&PointCheck>)> = Vec::new();
    for point in points.listed() {
        let text = reasons_text(&point.reasons);
        match groups.iter_mut().find(|(other, _)| *other == text) {
            Some((_, points)) => points.push(point),
            None => groups.push((text, vec![point])),
        }
    }
    let line = |(reasons, points): &(String, Vec<&PointCheck>)| match points.as_slice() {
        [only] => format!(
            "- {}: {reasons}{}.",
            only.reference,
            best_and_deviation(only)
        ),
        several => {
            let names: Vec<&Dof> = several.iter().map(|point| &point.reference).collect();
            format!("- {}: {reasons}.", named(&names))
        }
    };
    let mut lines: Vec<String> = groups.iter().take(MAX_LISTED_POINTS).map(line).collect();
    let further = groups.iter().skip(MAX_LISTED_POINTS);
    let further: Vec<&Dof> = further
        .flat_map(|(_, points)| points.iter().map(|point| &point.reference))
        .collect();
    if !further.is_empty() {
        let names = named(&further);
        lines.push(format!("- {names}: for other reasons, see --full."));
    }
    lines
}

/// Names of points, the first of many.
fn named(names: &[&Dof]) -> String {
    let first: Vec<String> = names
        .iter()
        .take(MAX_NAMED_POINTS)
        .map(ToString::to_string)
        .collect();
    match names.len().saturating_sub(MAX_NAMED_POINTS) {
        0 => first.join(", "),
        more => format!("{} and {more} more", first.join(", ")),
    }
}

fn best_and_deviation(point: &PointCheck) -> String {
    let best = match point.best.is_empty() {
        true => String::new(),
        false => format!("; best hits {}", best_hits(point)),
    };
    let deviation = point.deviation.as_ref().map(|deviation| {
        // Where no hit is missing, as many again.
        let more = match point.missing_hits() {
            0 => MIN_GOOD_HITS,
            missing => missing,
        };
        format!(
            "; std of the FRF at {} Hz {} %, with {more} more {} %",
            significant(deviation.hz, 4),
            percent(deviation.relative_std),
            percent(deviation.with_more(more))
        )
    });
    best + &deviation.unwrap_or_default()
}

fn best_hits(point: &PointCheck) -> String {
    let numbers = point.best.iter().take(MAX_NAMED_HITS);
    let numbers: Vec<String> = numbers.map(ToString::to_string).collect();
    numbers.join(", ")
}

fn percent(fraction: f64) -> String {
    significant(100.0 * fraction, 2)
}

/// A change with its sign, %.
fn signed_percent(fraction: f64) -> String {
    let sign = if fraction < 0.0 { "" } else { "+" };
    format!("{sign}{}", percent(fraction))
}

fn reasons_text(reasons: &[Reason]) -> String {
    let texts: Vec<String> = reasons.iter().map(reason_text).collect();
    texts.join(", ")
}

fn reason_text(reason: &Reason) -> String {
    let number = |value: Option<f64>| value.map(|value| significant(value, 2));
    let value = number(reason.value).unwrap_or_else(|| "-".to_owned());
    let limit = number(reason.limit).unwrap_or_else(|| "-".to_owned());
    let at = reason.response.as_ref();
    let at = at.map_or_else(String::new, |response| format!(" of {response}"));
    let hit = reason
        .hit
        .map_or_else(String::new, |hit| format!(" in hit {hit}"));
    match reason.cause {
        Cause::Rule(Rule::Overload) => {
            format!("overload{at}{hit}: {value} samples clipped (limit below {limit})")
        }
        Cause::Rule(Rule::Decay) => {
            let end = percent(reason.value.unwrap_or(0.0));
            let limit = percent(reason.limit.unwrap_or(0.0));
            format!("response{at} not decayed{hit}: {end} % at the end (limit at most {limit} %)")
        }
        Cause::Rule(rule) => {
            let name = match rule {
                Rule::DoubleHit => "double hit",
                Rule::Level => "peak force over the median",
                Rule::PreTrigger => "vibration before the hit",
                Rule::Dead => "no signal",
                Rule::InconsistentHit => "FRF unlike the other hits",
                Rule::RollOff => "roll-off of the force",
                Rule::Sign => "negative force",
                Rule::Drift => "offset or drift",
                Rule::Overload | Rule::Decay => rule.name(),
            };
            match reason.value {
                Some(_) => format!("{name}{at}{hit}: {value} (limit {limit})"),
                None => format!("{name}{at}{hit}"),
            }
        }
        Cause::Stated => format!("rejected by the user{hit}"),
        Cause::WeakForce => {
            format!("hammer force{hit} {value} dB against the others (limit at least {limit} dB)")
        }
        Cause::FewHits => format!(
            "{} of {limit}",
            counted(reason.value.unwrap_or(0.0) as usize, "good hit")
        ),
        Cause::LowCoherence { hz } => format!(
            "coherence{at} {} at {} Hz (limit at least {limit})",
            significant(reason.value.unwrap_or(0.0), 3),
            significant(hz, 4)
        ),
    }
}

/// Every excitation point with its hits and the standard deviation of its FRFs.
fn points_table(points: &HitAgain) -> Block {
    let row = |point: &PointCheck| {
        let deviation = point.deviation.as_ref();
        let with_more = |more: usize| {
            let std = deviation.map(|deviation| 100.0 * deviation.with_more(more));
            Cell::number(std, 3)
        };
        vec![
            Cell::text(point.reference.to_string()),
            Cell::text(point.hits.to_string()),
            Cell::text(point.best.len().to_string()),
            Cell::text(best_hits(point)),
            Cell::number(deviation.map(|deviation| deviation.hz), 2),
            with_more(0),
            with_more(1),
            with_more(MIN_GOOD_HITS),
            Cell::text(reasons_text(&point.reasons)),
        ]
    };
    let texts = ["at", "hits", "good hits", "best hits"].map(Column::text);
    let numbers = [
        "resonance (Hz)",
        "std of FRF (%)",
        "1 more hit (%)",
        "3 more hits (%)",
    ]
    .map(Column::number);
    let columns = texts.into_iter().chain(numbers);
    Block::Table(Table {
        caption: "Points to hit again".to_owned(),
        columns: columns.chain([Column::text("why")]).collect(),
        rows: points.points.iter().map(row).collect(),
        footnotes: vec![
            "Standard deviation of the magnitude of the FRF over the magnitude, at the resonance where it is largest; it falls as one over the square root of the number of hits.".to_owned(),
        ],
    })
}

/// A line for each item but the points.
fn item_lines(list: &BeforeYouLeave) -> Vec<String> {
    let lines = |item: &CheckItem| match item {
        CheckItem::HitAgain(_) => Vec::new(),
        CheckItem::Linearity(linearity) => vec![linearity_line(linearity)],
        CheckItem::Reciprocity(figures) => vec![reciprocity_line(figures.as_ref())],
        CheckItem::DrivingPoints(points) => vec![driving_point_line(points.as_ref())],
        CheckItem::Drift(drift) => vec![drift_sentence(drift.as_ref())],
        CheckItem::MassLine(check) => mass_line_lines(check),
        CheckItem::Support(check) => vec![support_line(check)],
    };
    list.items.iter().flat_map(lines).collect()
}

/// The mass, the stated mass, and the sensors of a mass line.
fn mass_line_lines(check: &MassLineCheck) -> Vec<String> {
    let mut lines = vec![match &check.body {
        Some(body) => mass_line(body),
        None => "Mass line: not tested; it needs more sensors with positions ([[point]], [[sensor]]) than motions that they see, and a band between suspension and first elastic mode.".to_owned(),
    }];
    let stated = check.stated_kg.map(|stated_kg| match check.comparison() {
        Some(mass) => stated_mass_line(&mass),
        None => format!(
            "Mass line: stated mass {} kg not compared.",
            significant(stated_kg, 4)
        ),
    });
    lines.extend(stated);
    lines.extend(check.body.as_ref().map(rigid_sensors_line));
    lines
}

/// The mass with its band, or why there is none.
fn mass_line(body: &RigidBody) -> String {
    let lo = significant(body.band.lo_hz, 3);
    let hi = significant(body.band.hi_hz, 3);
    match &body.inertia {
        Ok(inertia) => {
            let mass = significant(inertia.mass_kg, 4);
            let std = significant(inertia.mass_std_kg, 2);
            match body.fault.as_ref().map(|fault| &fault.repair) {
                None => format!("Mass line: {mass} ± {std} kg from {lo} to {hi} Hz."),
                Some(Repair::LeftOut(dof)) => format!(
                    "Mass line: {mass} ± {std} kg from {lo} to {hi} Hz, with {dof} left out; the FRFs are unchanged."
                ),
                Some(repair) => {
                    let sensors = repair.sensors();
                    let names = named(&sensors);
                    format!(
                        "Mass line: {mass} ± {std} kg from {lo} to {hi} Hz, with {names} repaired; the FRFs are unchanged."
                    )
                }
            }
        }
        Err(NoMass::SensorsNotRigid) => format!(
            "Mass line: from {lo} to {hi} Hz, mass not determined, because the sensors do not move as one rigid body."
        ),
        Err(NoMass::FewMotions) => format!(
            "Mass line: from {lo} to {hi} Hz, mass not determined, because the sensors see fewer than six motions; add sensors in other directions and points."
        ),
        Err(NoMass::SuspensionInBand) => format!(
            "Mass line: from {lo} to {hi} Hz, mass not determined, because modes of the suspension without a clear peak are in the band; hang the structure more softly."
        ),
        Err(NoMass::FewHits) => format!(
            "Mass line: from {lo} to {hi} Hz, mass not determined; hit three points or more in different directions (with a roving hammer: use three sensors)."
        ),
        Err(NoMass::Uncertain) => format!(
            "Mass line: from {lo} to {hi} Hz, mass not determined, because its standard deviation is above 20 %; the band is narrow or the FRFs are noisy."
        ),
    }
}

/// The sensors of a mass line.
fn rigid_sensors_line(body: &RigidBody) -> String {
    match &body.fault {
        None if !body.is_rigid() => format!(
            "Mass line: the sensors do not move as one rigid body, no single sensor explains it (misfit {}, limit {}): check signs, axes and sensitivities.",
            significant(body.misfit.value, 2),
            significant(body.misfit.limit, 2)
        ),
        None => format!(
            "Mass line: {} move as a rigid body.",
            counted(body.sensors, "sensor")
        ),
        Some(SensorFault {
            repair: Repair::Exchanged(one, other),
            ..
        }) => format!(
            "Mass line: {one} and {other} fit the rigid body in each other's place: check whether their cables or names are exchanged."
        ),
        Some(fault) => format!(
            "Mass line: {} does not move with the rigid body; {}: check cable, sensitivity, direction and position.",
            fault.dof, fault.repair
        ),
    }
}

fn stated_mass_line(mass: &MassComparison) -> String {
    let stated = significant(mass.stated_kg, 4);
    let difference = signed_percent(mass.difference());
    let limit = percent(mass.limit);
    match mass.differs() {
        false => {
            format!("Mass line: stated mass {stated} kg, difference {difference} % ({limit} %).")
        }
        true => format!(
            "Mass line: stated mass {stated} kg, difference {difference} % ({limit} %); if the stated mass is right, the FRFs are {} ± {} times what they should be; check mass_kg and attached parts, sensitivities, tip mass of the hammer, suspension.",
            significant(mass.gain(), 4),
            significant(mass.gain_std(), 1)
        ),
    }
}

fn support_line(check: &SupportCheck) -> String {
    let support = check.support;
    let below = check.peak_below_hz.map(|hz| significant(hz, 3));
    let above = check.elastic_hz.map(|hz| significant(hz, 4));
    match (check.rigid_body_hz, below, above) {
        (Some(rigid_hz), _, Some(above)) => {
            stated_support_line(check, &significant(rigid_hz, 3), &above)
        }
        (None, Some(below), Some(above)) => format!(
            "Support: {support}; highest_rigid_body_hz is not stated in [test.state]; highest clear peak below the mass line {below} Hz, first clear peak above {above} Hz."
        ),
        (Some(_), _, None) if !check.is_tested() => {
            format!("Support: {support}, not tested; no clear peak above highest_rigid_body_hz.")
        }
        _ if !check.is_tested() => {
            format!("Support: {support}, not tested; state highest_rigid_body_hz in [test.state].")
        }
        _ => format!("Support: {support}."),
    }
}

fn stated_support_line(check: &SupportCheck, rigid: &str, above: &str) -> String {
    let support = check.support;
    let (Some(ratio), Some(limit)) = (check.ratio(), check.limit) else {
        return format!(
            "Support: {support}; highest rigid-body mode {rigid} Hz, first clear peak above {above} Hz."
        );
    };
    let (ratio, limit) = (significant(ratio, 2), significant(limit, 2));
    match check.is_stiff() {
        false => format!(
            "Support: {support}; highest rigid-body mode {rigid} Hz, {ratio} of the first clear peak above at {above} Hz ({limit})."
        ),
        true => format!(
            "Support: {support}; highest rigid-body mode {rigid} Hz, {ratio} of the first clear peak above at {above} Hz ({limit}): it raises that mode; hang the structure more softly."
        ),
    }
}

fn linearity_line(linearity: &Linearity) -> String {
    let (hits, range) = (
        counted(linearity.hits, "hit"),
        significant(linearity.range_db, 2),
    );
    let at = &linearity.reference;
    if !linearity.dependences.is_empty() {
        let count = linearity.dependences.len();
        return format!(
            "Linearity: {} with the force; hit all points with one force.",
            match count {
                1 => "1 resonance changes".to_owned(),
                _ => format!("{count} resonances change"),
            }
        );
    }
    match linearity.is_tested() {
        true => {
            format!("Linearity: no resonance changes with the force; {hits}, {range} dB, at {at}.")
        }
        false => format!(
            "Linearity: not tested; {hits}, {range} dB, at {at}; add hits of half and of twice the force."
        ),
    }
}

fn dependence_lines(linearity: &Linearity) -> Vec<String> {
    let line = |finding: &crate::finding::Finding| {
        let at = match finding.location {
            Location::Mode(hz) => format!("{hz:.2} Hz"),
            _ => String::new(),
        };
        let detail = finding.detail.as_deref().unwrap_or_default();
        format!("- {at}: {detail}.")
    };
    linearity.dependences.iter().map(line).collect()
}

fn reciprocity_line(figures: Option<&PairFigures>) -> String {
    let Some(figures) = figures else {
        return "Reciprocity: not tested; exchange sensor and hammer at two points.".to_owned();
    };
    let (difference, limit) = (percent(figures.difference), percent(figures.limit));
    let pair = format!("{}/{}", figures.response, figures.reference);
    match figures.above_limit {
        0 => format!(
            "Reciprocity: {} within the limit; {pair} differs by {difference} % ({limit} %).",
            counted(figures.pairs, "pair")
        ),
        above => format!(
            "Reciprocity: {above} of {} above the limit; {pair} differs by {difference} % ({limit} %): check directions, points and calibration.",
            counted(figures.pairs, "pair")
        ),
    }
}

fn driving_point_line(points: Option<&DrivingPoints>) -> String {
    let Some(points) = points else {
        return "Driving points: none; hit beside a sensor along its axis.".to_owned();
    };
    match points.wrong.first() {
        None => format!(
            "Driving points: {} with the right sign.",
            counted(points.points, "FRF")
        ),
        Some((response, reference)) => format!(
            "Driving points: {} of {} with the wrong sign; {response}/{reference} for {} % of the energy ({} %): check directions and points.",
            points.wrong.len(),
            counted(points.points, "FRF"),
            percent(points.value),
            percent(points.limit)
        ),
    }
}

fn drift_sentence(drift: Option<&Drift>) -> String {
    let Some(drift) = drift else {
        return "Drift: not tested; hit the first point again at the end.".to_owned();
    };
    let hits = |hits: &[usize]| match hits {
        [only] => format!("hit {only}"),
        [first, .., last] => format!("hits {first} to {last}"),
        [] => String::new(),
    };
    let (first, last) = (hits(&drift.first_hits), hits(&drift.last_hits));
    let Some(worst) = worst_drift(drift) else {
        return "Drift: not tested; no isolated resonance in the hits that were repeated."
            .to_owned();
    };
    let figures = format!(
        "{} Hz changed by {} % ({} %), its residue by {} % ({} %)",
        significant(worst.hz, 4),
        signed_percent(worst.frequency.value),
        percent(worst.frequency.limit),
        signed_percent(worst.amplitude.value),
        percent(worst.amplitude.limit),
    );
    let at = &drift.reference;
    match is_drift(worst) {
        false => format!("Drift: none at {at} from {first} to {last}; {figures}."),
        true => format!(
            "Drift: at {at} from {first} to {last} {figures}: check supports, temperature and sensors, then repeat."
        ),
    }
}

fn is_drift(resonance: &ResonanceDrift) -> bool {
    resonance.frequency.is_drift() || resonance.amplitude.is_drift()
}

/// The resonance with the largest change over its limit.
fn worst_drift(drift: &Drift) -> Option<&ResonanceDrift> {
    let excess = |resonance: &&ResonanceDrift| {
        let changes = [resonance.frequency, resonance.amplitude];
        changes
            .map(|change| change.value.abs() / change.limit)
            .into_iter()
            .fold(0.0, f64::max)
    };
    let resonances = drift.resonances.iter();
    resonances.max_by(|a, b| excess(a).total_cmp(&excess(b)))
}

fn drift_line(resonance: &ResonanceDrift) -> String {
    format!(
        "- {:.2} Hz: frequency {} ± {} % ({} %), residue {} ± {} % ({} %).",
        resonance.hz,
        signed_percent(resonance.frequency.value),
        percent(resonance.frequency.std),
        percent(resonance.frequency.limit),
        signed_percent(resonance.amplitude.value),
        percent(resonance.amplitude.std),
        percent(resonance.amplitude.limit),
    )
}

/// What an item came to.
#[derive(Clone, Copy, PartialEq)]
enum State {
    Right,
    Wrong,
    NotTested,
}

fn item_state(item: &CheckItem) -> State {
    let state = |tested: bool, wrong: bool| match (tested, wrong) {
        (false, _) => State::NotTested,
        (true, true) => State::Wrong,
        (true, false) => State::Right,
    };
    match item {
        CheckItem::HitAgain(_) => State::Right,
        CheckItem::Linearity(linearity) => {
            let depends = !linearity.dependences.is_empty();
            state(depends || linearity.is_tested(), depends)
        }
        CheckItem::Reciprocity(figures) => state(
            figures.is_some(),
            figures.as_ref().is_some_and(|all| all.above_limit > 0),
        ),
        CheckItem::DrivingPoints(points) => state(
            points.is_some(),
            points.as_ref().is_some_and(|all| !all.wrong.is_empty()),
        ),
        CheckItem::Drift(drift) => {
            let worst = drift.as_ref().and_then(worst_drift);
            state(worst.is_some(), worst.is_some_and(is_drift))
        }
        CheckItem::MassLine(check) => {
            let wrong = check.is_wrong();
            state(wrong || check.is_tested(), wrong)
        }
        CheckItem::Support(check) => state(check.is_tested(), check.is_stiff()),
    }
}

fn item_name(item: &CheckItem) -> Option<&'static str> {
    match item {
        CheckItem::HitAgain(_) => None,
        CheckItem::Linearity(_) => Some("linearity"),
        CheckItem::Reciprocity(_) => Some("reciprocity"),
        CheckItem::DrivingPoints(_) => Some("driving points"),
        CheckItem::Drift(_) => Some("drift"),
        CheckItem::MassLine(_) => Some("mass line"),
        CheckItem::Support(_) => Some("support"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::axis::Band;
    use crate::frf::rigid_body::{Inertia, Misfit};

    #[test]
    fn suspension_has_its_ratio_and_limit() {
        let mut check = SupportCheck {
            support: "suspended",
            rigid_body_hz: Some(3.5),
            peak_below_hz: None,
            elastic_hz: Some(100.0),
            limit: Some(0.1),
        };
        let right = support_line(&check);
        assert!(
            right.contains("3.5 Hz, 0.035 of") && right.ends_with("(0.1)."),
            "{right}"
        );
        assert!(item_state(&CheckItem::Support(check.clone())) == State::Right);
        check.rigid_body_hz = Some(20.0);
        assert!(support_line(&check).contains("more softly"));
        assert!(item_state(&CheckItem::Support(check.clone())) == State::Wrong);
        // A clear peak is no measurement of the highest rigid-body mode.
        (check.rigid_body_hz, check.peak_below_hz) = (None, Some(2.0));
        let unstated = support_line(&check);
        let peaks = "highest clear peak below the mass line 2 Hz, first clear peak above 100 Hz.";
        assert!(
            unstated.contains("not stated") && unstated.ends_with(peaks),
            "{unstated}"
        );
        assert!(item_state(&CheckItem::Support(check.clone())) == State::NotTested);
        check.peak_below_hz = None;
        assert!(support_line(&check).contains("state highest_rigid_body_hz"));
        assert!(item_state(&CheckItem::Support(check)) == State::NotTested);
    }

    #[test]
    fn stated_mass_has_its_difference_and_limit() {
        let mut mass = MassComparison {
            stated_kg: 20.0,
            found_kg: 20.2,
            std_kg: 0.05,
            limit: 0.04,
        };
        assert!(stated_mass_line(&mass).ends_with("difference +1 % (4 %)."));
        mass.found_kg = 18.0;
        let line = stated_mass_line(&mass);
        assert!(
            line.contains("-10 %") && line.contains("1.111 ± 0.003 times"),
            "{line}"
        );
    }

    fn check(misfit: f64, inertia: Result<Inertia, NoMass>) -> MassLineCheck {
        let body = RigidBody {
            band: Band::new(10.0, 40.0).unwrap(),
            sensors: 12,
            fault: None,
            misfit: Misfit {
                value: misfit,
                limit: 4.0,
            },
            inertia,
        };
        MassLineCheck {
            body: Some(body),
            stated_kg: None,
        }
    }

    fn state(check: &MassLineCheck) -> State {
        item_state(&CheckItem::MassLine(Box::new(check.clone())))
    }

    #[test]
    fn sensors_that_are_no_rigid_body_are_wrong() {
        let wrong = check(900.0, Err(NoMass::SensorsNotRigid));
        let lines = mass_line_lines(&wrong).join("\n");
        for part in [
            "because the sensors",
            "misfit 900, limit 4",
            "check signs, axes",
        ] {
            assert!(lines.contains(part), "{lines}");
        }
        assert!(!lines.contains("hit three points") && !lines.contains("12 sensors"));
        assert!(state(&wrong) == State::Wrong);
    }

    #[test]
    fn missing_mass_has_its_cause_and_the_stated_mass_is_not_compared() {
        for (cause, text) in [
            (NoMass::FewMotions, "fewer than six motions"),
            (NoMass::SuspensionInBand, "modes of the suspension"),
            (NoMass::FewHits, "hit three points"),
            (NoMass::Uncertain, "above 20 %"),
        ] {
            let mut without = check(1.0, Err(cause));
            assert!(mass_line_lines(&without)[0].contains(text));
            assert!(state(&without) == State::Right);
            without.stated_kg = Some(20.0);
            let lines = mass_line_lines(&without);
            assert_eq!(lines[1], "Mass line: stated mass 20 kg not compared.");
            assert!(state(&without) == State::NotTested);
        }
        let none = MassLineCheck {
            body: None,
            stated_kg: Some(20.0),
        };
        let lines = mass_line_lines(&none);
        assert!(lines[0].contains("more sensors") && lines[1].contains("not compared"));
    }

    #[test]
    fn mass_of_a_repaired_test_has_the_repair() {
        let dofs: [Dof; 2] = ["5:+X", "6:+Y"].map(|dof| dof.parse().unwrap());
        let [one, other] = dofs;
        let lines = |repair: Repair| {
            let mut check = check(1.0, Ok(inertia()));
            check.body.as_mut().unwrap().fault = Some(SensorFault {
                dof: repair.dof().clone(),
                repair,
                fall: 4e5,
            });
            assert!(state(&check) == State::Wrong);
            mass_line_lines(&check)
        };
        let sign = lines(Repair::Sign(other.clone()));
        let repaired = "with 6:+Y repaired; the FRFs are unchanged.";
        assert!(sign[0].ends_with(repaired), "{}", sign[0]);
        let left_out = lines(Repair::LeftOut(other.clone()));
        assert!(left_out[0].contains("with 6:+Y left out"));
        let exchanged = lines(Repair::Exchanged(one, other));
        assert!(exchanged[0].contains("with 5:+X, 6:+Y repaired"));
        assert!(exchanged[1].ends_with("check whether their cables or names are exchanged."));
    }

    fn inertia() -> Inertia {
        Inertia {
            mass_kg: 20.0,
            mass_std_kg: 0.05,
            centre_m: [0.0; 3],
            centre_std_m: [0.0; 3],
            tensor_kg_m2: [0.0; 6],
        }
    }
}
