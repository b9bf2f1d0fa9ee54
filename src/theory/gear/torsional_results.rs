//! Results of the paper on the torsional planetary gear, computed with its matrices and closed
//! forms.

use std::f64::consts::TAU;

use crate::theory::parameter::index_of;
use crate::theory::quantity::allowed_or;
use crate::theory::{
    EventKind, LocusEvent, ModeOptions, ModelQuantity, ModelRoot, SweepRange, TheoreticalModel,
    TheoryError, TheoryModes, TorsionalPlanetary, model_roots, modes, sweep,
};

use super::torsional_sensitivities::sensitivity_quantities;

/// The carrier as printed, without the planets that it carries, kg.
const PRINTED_CARRIER_KG: f64 = 4.90;
/// Planets whose motions differ by less than this part of the largest motion move alike: far above
/// rounding.
const ALIKE: f64 = 1e-9;
/// Distance before and after a veering at which the energies are reported.
const BEFORE: f64 = 0.8;
const AFTER: f64 = 1.25;

/// Ranges of the sweeps as parts of the sun mesh's stiffness and of the ring's mass: wide enough
/// for both crossings.
const MESH_RANGE: [f64; 2] = [0.02, 200.0];
const SUN_RANGE: [f64; 2] = [0.1, 25.0];
/// Values of a sweep; the places do not depend on them.
const SWEEP_VALUES: usize = 9;

/// Every quantity, by name.
pub(super) fn quantities(
    model: &TorsionalPlanetary,
    values: &[f64],
) -> Result<Vec<ModelQuantity>, TheoryError> {
    let quantity = ModelQuantity::new;
    let solved = Solved::new(model, values, &[])?;
    let value = |name: &str| -> Result<f64, TheoryError> {
        Ok(values[index_of(model.name(), model.parameters(), name)?])
    };
    let planet = ((value("k_r")? + value("k_s")?) / value("m_p")?).sqrt() / TAU;
    let mut all = vec![
        quantity(
            "planet_mode",
            planet,
            "Hz",
            "planet modes, N - 1 of them: sqrt((k_r + k_s)/m_p)/2π (equation 3)",
        ),
        quantity(
            "other_modes",
            solved.other_modes() as f64,
            "",
            "modes that are neither planet modes nor rotational ones, in which all planets move alike",
        ),
    ];
    all.extend(sensitivity_quantities(model, values)?);
    let Some(forms) = model.closed_forms(values) else {
        let printed = Solved::new(model, values, &[("m_c", PRINTED_CARRIER_KG)])?;
        let what = "lowest rotational frequency above 0 with the carrier of 4.90 kg as printed";
        all.push(quantity(
            "printed_carrier",
            printed.rotational(0),
            "Hz",
            what,
        ));
        return Ok(all);
    };
    let printed = forms.printed_hz();
    let error = |column: usize| 100.0 * (printed[column] / solved.rotational(column) - 1.0).abs();
    all.push(quantity("closed_form_error", error(0).max(error(1)), "%", "largest difference of the rotational frequencies by equation 6 as printed from those of the matrices"));
    all.extend(forms.quantities());
    if let Some([veering, crossing]) = forms.veering_and_crossing() {
        let share = |k_r: f64| -> Result<f64, TheoryError> {
            let solved = Solved::new(model, values, &[("k_r", k_r)]);
            allowed_or(f64::NAN, solved.map(|solution| solution.ring_share()))
        };
        let exchanged = |place: f64| -> Result<f64, TheoryError> {
            let (before, after) = (share(BEFORE * place)?, share(AFTER * place)?);
            Ok((before - after).abs())
        };
        let shares_text = |place: &str| {
            format!(
                "change of the ring mesh's share of the strain energy of rotational mode 2 from 0.8 to 1.25 of the k_r of {place}"
            )
        };
        all.push(quantity(
            "exchange_at_veering",
            exchanged(veering)?,
            "",
            &shares_text("veering"),
        ));
        all.push(quantity(
            "exchange_at_crossing",
            exchanged(crossing)?,
            "",
            &shares_text("crossing"),
        ));
        let (k_s, m_r) = (value("k_s")?, value("m_r")?);
        let mesh = MESH_RANGE.map(|part| part * k_s);
        all.extend(swept(model, values, "k_r", mesh)?);
        let sun = SUN_RANGE.map(|part| part * m_r);
        all.extend(swept(model, values, "m_s", sun)?);
    }
    Ok(all)
}

/// Names of what a sweep finds: lowest crossing, highest crossing, veering, its gap, other events.
fn names_of(parameter: &str) -> [&'static str; 5] {
    match parameter {
        "k_r" => [
            "swept_crossing_k_r_lower",
            "swept_crossing_k_r_upper",
            "swept_veering_k_r",
            "swept_gap_k_r",
            "swept_others_k_r",
        ],
        _ => [
            "swept_crossing_m_s_lower",
            "swept_crossing_m_s_upper",
            "swept_veering_m_s",
            "swept_gap_m_s",
            "swept_others_m_s",
        ],
    }
}

/// Crossings and the veering as loci followed by shape have them.
fn swept(
    model: &TorsionalPlanetary,
    values: &[f64],
    parameter: &str,
    [lower, upper]: [f64; 2],
) -> Result<Vec<ModelQuantity>, TheoryError> {
    let specs = model.parameters();
    let spec = &specs[index_of(model.name(), specs, parameter)?];
    let range = SweepRange {
        lower: lower.max(spec.lower.unwrap_or(lower)),
        upper: upper.min(spec.upper.unwrap_or(upper)),
        count: SWEEP_VALUES,
    };
    let swept = allowed_or(None, sweep(model, values, parameter, range, None).map(Some))?;
    let events = swept.as_ref().map_or(&[][..], |swept| &swept.events);
    let of = |kind: EventKind| {
        let all = events.iter();
        all.filter(move |event| event.kind == kind)
    };
    let place = |event: Option<&LocusEvent>| event.map_or(f64::NAN, |event| event.place);
    let veering = of(EventKind::Veering).next();
    let gap = veering.map_or(f64::NAN, |event| event.gap_hz);
    // Two crossings at most and one veering are reported.
    let others = of(EventKind::Crossing).count().saturating_sub(2)
        + of(EventKind::Veering).count().saturating_sub(1);
    let unit: &'static str = if parameter == "k_r" { "N/m" } else { "kg" };
    let names = names_of(parameter);
    let followed = |what: &str| format!("{what}, of loci followed by shape over {parameter}");
    Ok(vec![
        ModelQuantity::new(
            names[0],
            place(of(EventKind::Crossing).next()),
            unit,
            &followed("first crossing"),
        ),
        ModelQuantity::new(
            names[1],
            place(of(EventKind::Crossing).nth(1)),
            unit,
            &followed("second crossing"),
        ),
        ModelQuantity::new(
            names[2],
            place(veering),
            unit,
            &followed("veering: nearest frequencies"),
        ),
        ModelQuantity::new(names[3], gap, "Hz", &followed("their distance there")),
        ModelQuantity::new(
            names[4],
            swept.as_ref().map_or(f64::NAN, |_| others as f64),
            "",
            &followed("further crossings and veerings"),
        ),
    ])
}

/// Modes and roots at some values.
struct Solved {
    modes: TheoryModes,
    roots: Vec<ModelRoot>,
}

impl Solved {
    fn new(
        model: &TorsionalPlanetary,
        values: &[f64],
        changes: &[(&str, f64)],
    ) -> Result<Self, TheoryError> {
        let mut values = values.to_vec();
        for (name, value) in changes {
            values[index_of(model.name(), model.parameters(), name)?] = *value;
        }
        let modes = modes(model, &values, &[], &ModeOptions::default())?;
        let roots = model_roots(model, &modes);
        Ok(Self { modes, roots })
    }

    /// Motions of the planets in a mode, and the largest motion of all.
    fn planets(&self, mode: usize) -> (Vec<f64>, f64) {
        let all = self.modes.coordinates.iter().enumerate();
        let planet_coordinates =
            all.filter(|(_, coordinate)| coordinate.body.starts_with("planet-"));
        let planets = planet_coordinates
            .map(|(i, _)| self.modes.vectors[(i, mode)])
            .collect();
        let rows = 0..self.modes.coordinates.len();
        let largest = rows.map(|i| self.modes.vectors[(i, mode)].abs());
        (planets, largest.fold(0.0, f64::max))
    }

    fn alike(&self, mode: usize) -> bool {
        let (planets, largest) = self.planets(mode);
        let (low, high) = planets
            .iter()
            .fold((f64::MAX, f64::MIN), |(low, high), &u| {
                (low.min(u), high.max(u))
            });
        high - low <= ALIKE * largest
    }

    fn is_planet_root(root: &ModelRoot) -> bool {
        let kinds = root.energy_by_kind();
        kinds
            .first()
            .is_some_and(|(kind, share)| kind == "planet" && *share > 1.0 - ALIKE)
    }

    fn other_modes(&self) -> usize {
        let others = self.roots.iter().filter(|root| !Self::is_planet_root(root));
        let modes = others.flat_map(|root| &root.modes);
        modes.filter(|mode| !self.alike(**mode)).count()
    }

    /// The rotational roots above 0 that no other root shares, in order.
    fn single_rotational(&self) -> impl Iterator<Item = &ModelRoot> {
        let elastic = self.roots.iter().filter(|root| root.omega_rad_s > 0.0);
        elastic.filter(|root| root.modes.len() == 1 && !Self::is_planet_root(root))
    }

    /// Frequency of a rotational root above 0, from 0, Hz; not a number where there is none.
    fn rotational(&self, number: usize) -> f64 {
        let root = self.single_rotational().nth(number);
        root.map_or(f64::NAN, |root| root.omega_rad_s / TAU)
    }

    /// Share of the ring mesh in the strain energy of the lowest rotational root above 0.
    fn ring_share(&self) -> f64 {
        let root = self.single_rotational().next();
        let mut strain = root.iter().flat_map(|root| &root.strain_energy);
        strain
            .find(|(name, _)| name == "k_r")
            .map_or(f64::NAN, |(_, share)| *share)
    }
}
