//! A population draws the same member wherever it is drawn, with the properties of its kind.

use std::collections::BTreeSet;

use modalign::modal::{Mode, mac};
use modalign::record::Hit;
use modalign::synth::{HammerTest, Noise};

use crate::population::span::Span;
use crate::population::{Member, PopulationError, PopulationSpec, StructureSpec};

const FAMILY: &str = include_str!("../population/family.toml");

fn family() -> PopulationSpec {
    toml::from_str(FAMILY).unwrap()
}

/// Place of a kind in the family.
fn place(family: &PopulationSpec, kind: &str) -> usize {
    let mut kinds = family.members.iter().map(|m| m.structure.kind());
    kinds.position(|drawn| drawn == kind).unwrap()
}

fn all(family: &PopulationSpec, kind: &str) -> Vec<Member> {
    let place = place(family, kind);
    let numbers = 0..family.members[place].count;
    numbers
        .map(|number| family.draw(place, number).unwrap())
        .collect()
}

#[test]
fn every_kind_is_in_the_family_and_its_modes_lie_below_the_filters_edge() {
    let family = family();
    let kinds: BTreeSet<&str> = family.members.iter().map(|m| m.structure.kind()).collect();
    assert_eq!(kinds.len(), 8);
    for kind in kinds {
        for member in all(&family, kind) {
            let test = &member.test;
            let modes = &test.truth.model.modes;
            let highest = modes.iter().map(|m| m.frequency_hz).fold(0.0, f64::max);
            let share = highest / (0.4 * test.sampling_rate_hz);
            assert!(
                (0.6..=0.95 + 1e-12).contains(&share),
                "{}: {share}",
                member.name
            );
            assert!(test.samples <= family.test.most_samples);
            assert!((1..=3).contains(&test.hits.len()));
            let slowest = modes
                .iter()
                .map(|m| -m.pole().unwrap().lambda.re)
                .fold(f64::MAX, f64::min);
            let after_s = test.record_s() - test.pretrigger_s;
            let time_constants = after_s * slowest;
            // A record is lengthened to a multiple of 256 samples.
            assert!(
                time_constants >= 5.0 - 1e-9,
                "{}: {time_constants}",
                member.name
            );
        }
    }
}

#[test]
fn a_member_does_not_depend_on_the_others() {
    let family = family();
    let (beam, close) = (place(&family, "beam"), place(&family, "close"));
    let first = family.draw(beam, 3).unwrap();
    let other = family.draw(close, 3).unwrap();
    let mut fewer = family.clone();
    fewer.members[close].count = 4;
    assert_eq!(fewer.draw(close, 3).unwrap(), other);
    assert_eq!(fewer.draw(beam, 3).unwrap(), first);
    assert_ne!(family.draw(beam, 4).unwrap().test, first.test);
    let mut reseeded = family.clone();
    reseeded.seed += 1;
    assert_ne!(reseeded.draw(beam, 3).unwrap().test, first.test);
}

#[test]
fn the_repeated_kind_has_exactly_repeated_roots_with_independent_shapes() {
    let family = family();
    for member in all(&family, "repeated") {
        assert!(!member.facts.repeated.is_empty(), "{}", member.name);
        let modes = &member.test.truth.model.modes;
        for root in &member.facts.repeated {
            let [a, b] = root[..] else { panic!("{root:?}") };
            let pole = |j: usize| modes[j].pole().unwrap();
            assert_eq!(pole(a), pole(b), "{}", member.name);
            assert_eq!(modes[a].group, modes[b].group);
            let shape = |j: usize| modes[j].shape.iter().map(|(_, v)| v).collect::<Vec<_>>();
            assert!(mac(&shape(a), &shape(b)).unwrap_or(0.0) < 0.99);
        }
    }
}

#[test]
fn square_plates_have_repeated_roots_and_others_need_not() {
    let mut family = family();
    let plate = place(&family, "plate");
    for (probability, repeated) in [(1.0, true), (0.0, false)] {
        let StructureSpec::Plate(spec) = &mut family.members[plate].structure else {
            panic!("a plate");
        };
        spec.square_probability = probability;
        let members = all(&family, "plate");
        let with = members.iter().filter(|m| !m.facts.repeated.is_empty());
        assert_eq!(with.count() == members.len(), repeated);
    }
}

#[test]
fn the_close_kind_has_the_stated_spacing() {
    let mut family = family();
    let close = place(&family, "close");
    for widths in [0.3, 1.0, 4.0] {
        let StructureSpec::Close(spec) = &mut family.members[close].structure else {
            panic!("close pairs");
        };
        spec.spacing_widths = Span::from([widths; 2]);
        for member in all(&family, "close") {
            let modes = &member.test.truth.model.modes;
            assert!(!member.facts.close.is_empty(), "{}", member.name);
            for pair in &member.facts.close {
                let (lower, upper) = (&modes[pair[0]], &modes[pair[1]]);
                let width = lower.pole().unwrap().half_power_width_hz();
                let got = (upper.frequency_hz - lower.frequency_hz) / width;
                // The distance of two frequencies is exact to their rounding over a width of 0.6 %
                // of them.
                assert!((got / widths - 1.0).abs() < 1e-11, "{}: {got}", member.name);
            }
        }
    }
}

#[test]
fn the_node_kind_has_no_residue_at_its_reference_and_some_elsewhere() {
    for member in all(&family(), "nodes") {
        assert!(!member.facts.nodes.is_empty(), "{}", member.name);
        let modes = &member.test.truth.model.modes;
        let reference = &member.test.hits[0].hit;
        let on_nodes = member
            .facts
            .nodes
            .iter()
            .filter(|(_, hit)| hit == reference);
        let hidden: BTreeSet<usize> = on_nodes.map(|(j, _)| *j).collect();
        for (j, mode) in modes.iter().enumerate() {
            let here = mode
                .residues
                .iter()
                .filter(|((_, hit), _)| hit == reference);
            let largest = here.map(|(_, a)| a.norm()).fold(0.0, f64::max);
            assert_eq!(
                hidden.contains(&j),
                largest <= 0.0,
                "{} mode {j}",
                member.name
            );
        }
    }
}

#[test]
fn discrete_dampers_turn_the_residues_of_driving_points() {
    let members = all(&family(), "dampers");
    let turned = members.iter().filter(|member| {
        let angle = |mode: &Mode| {
            let driving = mode.residues.iter().filter(|((r, h), _)| r == h);
            // A real shape has the driving-point residue -i/(2 omega_d m).
            driving
                .map(|(_, a)| a.re.abs() / a.norm())
                .fold(0.0, f64::max)
        };
        let largest = member
            .test
            .truth
            .model
            .modes
            .iter()
            .map(angle)
            .fold(0.0, f64::max);
        largest > 0.01
    });
    // Without the dampers no residue is turned at all.
    assert!(turned.count() > members.len() / 2);
}

/// Rms of the difference of two records.
fn noise_rms(noisy: &[f64], clean: &[f64]) -> f64 {
    let sum: f64 = noisy.iter().zip(clean).map(|(a, b)| (a - b).powi(2)).sum();
    (sum / clean.len() as f64).sqrt()
}

#[test]
fn the_noise_of_the_samples_has_the_stated_level() {
    let family = family();
    let (mut channels, mut worst) = (0, 0.0f64);
    for kind in 0..family.members.len() {
        let member = family.draw(kind, 0).unwrap();
        let clean_test = HammerTest {
            noise: Noise::default(),
            ..member.test.clone()
        };
        let (noisy, clean): (Vec<Hit>, Vec<Hit>) = (
            member.test.generate().unwrap(),
            clean_test.generate().unwrap(),
        );
        let mut compare = |level: f64, rms: f64, db: f64, samples: usize| {
            let expected = level / 10f64.powf(db / 20.0);
            // The rms of N normal numbers scatters by 1/sqrt(2N).
            worst = worst.max((rms / expected - 1.0).abs() * (2.0 * samples as f64).sqrt());
            channels += 1;
        };
        for (noisy, clean) in noisy.iter().zip(&clean) {
            let (force, pure) = (noisy.force.si(), clean.force.si());
            let peak = pure.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
            let db = member.test.noise.force_snr_db.unwrap();
            compare(peak, noise_rms(&force, &pure), db, pure.len());
            for (noisy, clean) in noisy.responses.iter().zip(&clean.responses) {
                let (response, pure) = (noisy.si(), clean.si());
                let level = noise_rms(&pure, &vec![0.0; pure.len()]);
                // A response on a node is silent and stays so.
                if level > 0.0 {
                    let db = member.test.noise.response_snr_db.unwrap();
                    compare(level, noise_rms(&response, &pure), db, pure.len());
                }
            }
        }
    }
    // Among a thousand normal deviations one beyond 5 has a probability of 6e-4.
    assert!(channels > 200 && worst < 5.0, "{worst} of {channels}");
}

#[test]
fn impossible_ranges_are_refused_by_name() {
    let family = family();
    let key = |change: fn(&mut PopulationSpec)| {
        let mut changed = family.clone();
        change(&mut changed);
        match changed.draw(0, 0).unwrap_err() {
            PopulationError::Range { key, .. } => key,
            other => panic!("{other}"),
        }
    };
    assert_eq!(
        key(|f| f.test.averages = Span::from([0.0, 3.0])),
        "averages"
    );
    assert_eq!(
        key(|f| f.test.responses = Span::from([2.5, 3.0])),
        "responses"
    );
    assert_eq!(
        key(|f| f.test.time_constants = Span::from([9.0, 5.0])),
        "time_constants"
    );
    assert_eq!(
        key(|f| f.test.force_snr_db = Some(Span::from([f64::NAN, 5.0]))),
        "force_snr_db"
    );
    assert_eq!(key(|f| f.test.modes = Span::from([4.0, 40.0])), "modes");
}

#[test]
fn unknown_keys_other_schemas_and_missing_members_are_errors() {
    let typo = FAMILY.replace("tuning", "tunning");
    let error = toml::from_str::<PopulationSpec>(&typo).unwrap_err();
    assert!(error.to_string().contains("tunning"), "{error}");
    let mut family = family();
    let count = family.members[0].count;
    let error = family.draw(0, count).unwrap_err();
    assert!(
        matches!(error, PopulationError::NoSuchMember { got_number, .. } if got_number == count)
    );
    assert!(family.draw(99, 0).is_err());
    family.schema = "modalign-population/2".to_owned();
    let error = family.draw(0, 0).unwrap_err();
    assert!(matches!(error, PopulationError::Schema { .. }));
}
