//! The plan of a breakdown map is checked from `[breakdown]` of `study.toml`.

use std::ops::RangeInclusive;

use serde::Deserialize;

use crate::identify::ESTIMATORS;

use super::slice::Slice;
use super::stability::StabilityPlan;
use super::{Axis, BreakdownError, Case, Factor, Scale, StatedError};

/// `[breakdown]`; every key is optional.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BreakdownTable {
    /// Seed of all draws; 1 when not stated.
    pub seed: Option<u64>,
    /// Names of methods; all of [`ESTIMATORS`] when not stated.
    pub methods: Option<Vec<String>>,
    /// Draws for each cell; 80 when not stated: 73 draws without a failure are the minimum that
    /// proves a share of 95 %.
    pub draws: Option<u32>,
    /// Halvings of cells near a contour; 2 when not stated.
    pub refine: Option<u32>,
    /// A `modes.json`, relative to the spec, whose modes are shown in the slices; those of a
    /// scene's run when not stated.
    pub modes: Option<String>,
    /// The stated error.
    #[serde(default)]
    pub stated: StatedTable,
    /// What slices have in common.
    #[serde(default)]
    pub case: CaseTable,
    /// The slices; a default set when none is stated.
    #[serde(default)]
    pub slice: Vec<SliceTable>,
    /// Numerical stability; computed when not stated.
    pub stability: Option<StabilityTable>,
}

/// `[breakdown.stated]`: largest errors of a method.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StatedTable {
    /// Frequency, half-power widths; 0.1 when not stated.
    pub frequency_widths: Option<f64>,
    /// Frequency, percent; not checked when not stated.
    pub frequency_percent: Option<f64>,
    /// Damping ratio, percent; 10 when not stated.
    pub damping_percent: Option<f64>,
    /// Smallest MAC; 0.9 when not stated.
    pub mac: Option<f64>,
    /// Residues, percent; 20 when not stated.
    pub residue_percent: Option<f64>,
}

/// `[breakdown.case]` and `[breakdown.slice.case]`: differences from the base case.
#[derive(Clone, Debug, Default, Deserialize)]
pub struct CaseTable {
    /// Frequency of the lowest mode, Hz.
    pub lowest_hz: Option<f64>,
    /// Hz from the pair to the third mode.
    pub gap_hz: Option<f64>,
    /// Number of sensors, 4 to 1000.
    pub responses: Option<usize>,
    /// Lines of the band where FRFs are drawn.
    pub lines: Option<usize>,
    /// Any factor.
    #[serde(flatten)]
    pub factors: std::collections::BTreeMap<Factor, f64>,
}

/// `[[breakdown.slice]]`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SliceTable {
    /// Its name; `y-x` when not stated.
    pub name: Option<String>,
    /// First axis.
    pub x: AxisTable,
    /// Second axis.
    pub y: AxisTable,
    /// What differs from the case of all slices.
    #[serde(default)]
    pub case: CaseTable,
}

/// An axis of a slice.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AxisTable {
    /// What varies.
    pub factor: Factor,
    /// First value.
    pub lo: f64,
    /// Last value.
    pub hi: f64,
    /// Values before halving; 7 when not stated, every one of up to 7 whole numbers.
    pub count: Option<usize>,
    /// `linear` or `log`; linear when not stated.
    pub scale: Option<Scale>,
}

/// `[breakdown.stability]`.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StabilityTable {
    /// Highest order, even; 40 when not stated. 0: none.
    pub highest_order: Option<usize>,
}

/// The checked plan of a breakdown map.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Its slices.
    pub slices: Vec<Slice>,
    /// Numerical stability, where it is computed.
    pub stability: Option<StabilityPlan>,
}

/// Name under which numerical stability is saved among the slices.
pub(super) const STABILITY: &str = "stability";

const DEFAULT_DRAWS: u32 = 80;
const DEFAULT_REFINE: u32 = 2;
const MAX_REFINE: u32 = 6;
const DEFAULT_AXIS_VALUES: usize = 7;
const DEFAULT_HIGHEST_ORDER: usize = 40;

impl BreakdownTable {
    /// The checked plan of the table.
    ///
    /// # Errors
    /// [`BreakdownError::Value`] with the key, the value and the expected ones.
    pub fn plan(&self) -> Result<Plan, BreakdownError> {
        let methods = self.methods()?;
        let stated = self.stated.checked()?;
        let base = self.case.applied(&Case::default(), "breakdown.case")?;
        let draws = self.draws.unwrap_or(DEFAULT_DRAWS);
        check_range("breakdown.draws", f64::from(draws), 1.0..=1e6)?;
        let refine = self.refine.unwrap_or(DEFAULT_REFINE);
        check_range(
            "breakdown.refine",
            f64::from(refine),
            0.0..=f64::from(MAX_REFINE),
        )?;
        let defaults = default_slices();
        let tables = if self.slice.is_empty() {
            &defaults
        } else {
            &self.slice
        };
        let mut slices: Vec<Slice> = Vec::with_capacity(tables.len());
        for (index, table) in tables.iter().enumerate() {
            let key = format!("breakdown.slice {}", index + 1);
            let (x, y) = (table.x.checked(&key)?, table.y.checked(&key)?);
            let name = table.name.clone();
            let name = name.unwrap_or(format!("{}-{}", y.factor.name(), x.factor.name()));
            check_name(&key, &name, &slices)?;
            if x.factor == y.factor {
                return Err(invalid_value(
                    &key,
                    x.factor.name(),
                    "two different factors",
                ));
            }
            let slice = Slice {
                name,
                x,
                y,
                case: table.case.applied(&base, &key)?,
                methods: methods_for(&methods, [x.factor, y.factor]),
                stated,
                draws,
                refine,
                seed: self.seed.unwrap_or(1),
            };
            slices.push(slice);
        }
        Ok(Plan {
            slices,
            stability: self.stability()?,
        })
    }

    fn methods(&self) -> Result<Vec<String>, BreakdownError> {
        let known = || ESTIMATORS.iter().map(|entry| entry.name.to_owned());
        let Some(stated) = &self.methods else {
            return Ok(known().collect());
        };
        let unknown = stated
            .iter()
            .find(|name| !known().any(|name_of_estimator| name_of_estimator == **name));
        match unknown {
            Some(name) => {
                let names: Vec<String> = known().collect();
                Err(invalid_value("breakdown.methods", name, &names.join(", ")))
            }
            None if stated.is_empty() => Err(invalid_value(
                "breakdown.methods",
                "none",
                "the name of a method",
            )),
            None => Ok(stated.clone()),
        }
    }

    fn stability(&self) -> Result<Option<StabilityPlan>, BreakdownError> {
        let stated = self
            .stability
            .as_ref()
            .and_then(|table| table.highest_order);
        let highest = stated.unwrap_or(DEFAULT_HIGHEST_ORDER);
        check_range(
            "breakdown.stability.highest_order",
            highest as f64,
            0.0..=100.0,
        )?;
        Ok((highest >= 2).then_some(StabilityPlan {
            highest_order: highest,
        }))
    }
}

impl StatedTable {
    fn checked(&self) -> Result<StatedError, BreakdownError> {
        let base = StatedError::default();
        let stated = StatedError {
            frequency_widths: self.frequency_widths.unwrap_or(base.frequency_widths),
            frequency_percent: self.frequency_percent,
            damping_percent: self.damping_percent.unwrap_or(base.damping_percent),
            mac: self.mac.unwrap_or(base.mac),
            residue_percent: self.residue_percent.or(base.residue_percent),
        };
        let percent = |name: &str, value: f64| {
            check_range(&format!("breakdown.stated.{name}"), value, 1e-9..=1e9)
        };
        percent("frequency_widths", stated.frequency_widths)?;
        percent("damping_percent", stated.damping_percent)?;
        percent("frequency_percent", stated.frequency_percent.unwrap_or(1.0))?;
        percent("residue_percent", stated.residue_percent.unwrap_or(1.0))?;
        check_range("breakdown.stated.mac", stated.mac, 0.0..=1.0)?;
        Ok(stated)
    }
}

impl CaseTable {
    fn applied(&self, base: &Case, key: &str) -> Result<Case, BreakdownError> {
        let mut case = base.clone();
        for (factor, value) in &self.factors {
            check_value(&format!("{key}.{}", factor.name()), *factor, *value)?;
            case = case.with(*factor, *value);
        }
        case.lowest_hz = self.lowest_hz.unwrap_or(case.lowest_hz);
        case.gap_hz = self.gap_hz.unwrap_or(case.gap_hz);
        case.responses = self.responses.unwrap_or(case.responses);
        case.lines = self.lines.unwrap_or(case.lines);
        check_range(&format!("{key}.lowest_hz"), case.lowest_hz, 1e-3..=1e6)?;
        check_range(&format!("{key}.gap_hz"), case.gap_hz, 1e-6..=1e6)?;
        check_range(
            &format!("{key}.responses"),
            case.responses as f64,
            4.0..=1e3,
        )?;
        check_range(&format!("{key}.lines"), case.lines as f64, 32.0..=1e5)?;
        Ok(case)
    }
}

impl AxisTable {
    fn checked(&self, key: &str) -> Result<Axis, BreakdownError> {
        let key = format!("{key}, axis {}", self.factor.name());
        check_value(&format!("{key}.lo"), self.factor, self.lo)?;
        check_value(&format!("{key}.hi"), self.factor, self.hi)?;
        if self.lo >= self.hi {
            return Err(invalid_value(
                &key,
                &format!("{} to {}", self.lo, self.hi),
                "lo below hi",
            ));
        }
        let scale = self.scale.unwrap_or(Scale::Linear);
        if scale == Scale::Log && self.lo <= 0.0 {
            return Err(invalid_value(
                &key,
                &format!("lo = {}", self.lo),
                "a positive lo of a log axis",
            ));
        }
        let whole = self
            .factor
            .is_whole()
            .then(|| (self.hi - self.lo) as usize + 1);
        let count = self.count.unwrap_or(
            whole
                .unwrap_or(DEFAULT_AXIS_VALUES)
                .min(DEFAULT_AXIS_VALUES),
        );
        check_range(&format!("{key}.count"), count as f64, 2.0..=200.0)?;
        Ok(Axis {
            factor: self.factor,
            lo: self.lo,
            hi: self.hi,
            count,
            scale,
        })
    }
}

/// The slices of a study that states none: they cover conditions under which methods usually fail.
fn default_slices() -> Vec<SliceTable> {
    let axis = |factor, lo, hi, scale| AxisTable {
        factor,
        lo,
        hi,
        count: None,
        scale: Some(scale),
    };
    let separation = || axis(Factor::Separation, 0.1, 10.0, Scale::Log);
    let noise = || axis(Factor::Noise, 10.0, 70.0, Scale::Linear);
    let slice = |x, y| SliceTable {
        name: None,
        x,
        y,
        case: CaseTable::default(),
    };
    let with = |mut table: SliceTable, factors: &[(Factor, f64)]| {
        table.case.factors = factors.iter().copied().collect();
        table
    };
    vec![
        slice(separation(), noise()),
        slice(
            separation(),
            axis(Factor::References, 1.0, 3.0, Scale::Linear),
        ),
        slice(separation(), axis(Factor::Damping, 0.003, 0.1, Scale::Log)),
        with(
            slice(
                axis(Factor::Hits, 1.0, 16.0, Scale::Log),
                axis(Factor::ForceNoise, 10.0, 70.0, Scale::Linear),
            ),
            &[(Factor::Noise, 70.0)],
        ),
        with(
            slice(
                separation(),
                axis(Factor::ExponentialWindow, 1e-8, 1.0, Scale::Log),
            ),
            &[(Factor::Noise, 60.0)],
        ),
        slice(axis(Factor::RecordLength, 1.0, 20.0, Scale::Log), noise()),
    ]
}

/// The methods with a model order, where a factor is the order; else all methods.
fn methods_for(methods: &[String], factors: [Factor; 2]) -> Vec<String> {
    let has_order = |name: &&String| {
        let entry = ESTIMATORS.iter().find(|entry| entry.name == **name);
        entry.is_some_and(|entry| entry.has_order) || !factors.contains(&Factor::Order)
    };
    methods.iter().filter(has_order).cloned().collect()
}

fn check_name(key: &str, name: &str, before: &[Slice]) -> Result<(), BreakdownError> {
    let legal = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    if name.is_empty() || name.starts_with('.') || !name.chars().all(legal) {
        let expected = "letters, digits, hyphens, points and underscores: it is a file's name";
        return Err(invalid_value(&format!("{key}.name"), name, expected));
    }
    if name == STABILITY || before.iter().any(|slice| slice.name == name) {
        return Err(invalid_value(
            &format!("{key}.name"),
            name,
            "a name of no other slice",
        ));
    }
    Ok(())
}

fn check_value(key: &str, factor: Factor, value: f64) -> Result<(), BreakdownError> {
    let (lo, hi) = factor.limits();
    check_range(key, value, lo..=hi)?;
    if factor.is_whole() && value.fract() != 0.0 {
        return Err(invalid_value(key, &value.to_string(), "a whole number"));
    }
    Ok(())
}

fn check_range(key: &str, value: f64, range: RangeInclusive<f64>) -> Result<(), BreakdownError> {
    if range.contains(&value) {
        return Ok(());
    }
    let expected = format!("{} to {}", range.start(), range.end());
    Err(invalid_value(key, &value.to_string(), &expected))
}

fn invalid_value(key: &str, got: &str, expected: &str) -> BreakdownError {
    BreakdownError::Value {
        key: key.to_owned(),
        got: got.to_owned(),
        expected: expected.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::parse;

    fn plan(text: &str) -> Result<Plan, String> {
        let table = parse::<BreakdownTable>(text, "study.toml");
        let table = table.map_err(|error| error.to_string())?;
        table.plan().map_err(|error| error.to_string())
    }

    #[test]
    fn nothing_stated_is_the_default_set() {
        let plan_of_defaults = plan("").unwrap();
        assert_eq!(plan_of_defaults.slices.len(), 6);
        assert_eq!(plan_of_defaults.slices[0].name, "noise-separation");
        assert_eq!(plan_of_defaults.slices[0].methods.len(), ESTIMATORS.len());
        assert_eq!(plan_of_defaults.slices[2].name, "damping-separation");
        assert!(
            plan_of_defaults.slices[3].needs_test() && !plan_of_defaults.slices[1].needs_test()
        );
        assert_eq!(plan_of_defaults.slices[1].y.count, 3);
        assert_eq!(plan_of_defaults.stability.unwrap().highest_order, 40);
    }

    #[test]
    fn a_slice_has_the_stated_case_and_axes() {
        let plan_of_text = plan(
            "seed = 4\ndraws = 10\nmethods = [\"peak\", \"lscf\"]\n[case]\ndamping = 0.02\nresponses = 9\n\
             [[slice]]\nname = \"a\"\nx = { factor = \"order\", lo = 4, hi = 12 }\n\
             y = { factor = \"noise\", lo = 20, hi = 60, count = 3 }\ncase = { separation = 3 }\n",
        );
        let plan_of_text = plan_of_text.unwrap();
        let slice = &plan_of_text.slices[0];
        assert_eq!(slice.methods, ["lscf"]);
        assert_eq!((slice.case.damping, slice.case.separation), (0.02, 3.0));
        assert_eq!((slice.case.responses, slice.x.count, slice.seed), (9, 7, 4));
    }

    #[test]
    fn invalid_values_are_reported_with_their_key() {
        let axes = "x = { factor = \"noise\", lo = 10, hi = 20 }\ny = { factor = \"hits\", lo = 1, hi = 3 }\n";
        for (text, part) in [
            ("methods = [\"rpf\"]".to_owned(), "breakdown.methods: got rpf, expected peak"),
            ("draws = 0".to_owned(), "breakdown.draws: got 0"),
            (format!("[[slice]]\nname = \"a/b\"\n{axes}"), "breakdown.slice 1.name: got a/b"),
            (format!("[[slice]]\n{axes}[[slice]]\n{axes}"), "got hits-noise, expected a name of no other slice"),
            (
                "[[slice]]\nx = { factor = \"hits\", lo = 1.5, hi = 3 }\ny = { factor = \"noise\", lo = 1, hi = 3 }".to_owned(),
                "axis hits.lo: got 1.5, expected a whole number",
            ),
            (
                "[[slice]]\nx = { factor = \"damping\", lo = 0.1, hi = 0.01 }\ny = { factor = \"noise\", lo = 1, hi = 3 }".to_owned(),
                "got 0.1 to 0.01, expected lo below hi",
            ),
            ("[case]\ndampng = 0.02".to_owned(), "dampng"),
            ("[stated]\nmac = 2.0".to_owned(), "breakdown.stated.mac: got 2, expected 0 to 1"),
        ] {
            let error = plan(&text).unwrap_err();
            assert!(error.contains(part), "{text}\n{error}");
        }
    }
}
