//! A slice locates a user's modes and their distance from the contour of each method.

use std::collections::BTreeMap;

use num_complex::Complex64;
use serde::{Deserialize, Serialize};

use crate::frf::FrfSet;
use crate::linalg::sort_ascending_by;
use crate::modal::{ModalModel, Mode};

use super::slice::{MIN_SUCCESS_RATE, SliceResult, SuccessRate};
use super::{Axis, Factor, Field, Scale};

/// A mode with the values of the factors that its test determines.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct UserMode {
    /// Name of its test, where there are several.
    pub test: String,
    /// Its number in the table of modes, from 1.
    pub number: usize,
    /// Its frequency, Hz.
    pub frequency_hz: f64,
    /// Values of factors.
    pub values: BTreeMap<Factor, f64>,
}

/// The modes of a test: damping; distance to the nearest neighbour in half-power widths; number of
/// references; size at the best of them; and from its FRFs, where they are given, noise over the
/// band (the median of the functions), hits, and length of the record.
pub fn user_modes(test: &str, model: &ModalModel, set: Option<&FrfSet>) -> Vec<UserMode> {
    let of_set = set.map_or_else(BTreeMap::new, |set| values_of_set(set, model));
    let mode = |(index, mode): (usize, &Mode)| {
        let mut values = of_set.clone();
        if !model.references.is_empty() {
            values.insert(Factor::References, model.references.len() as f64);
        }
        values.extend(node_distance(model, mode).map(|distance| (Factor::NodeDistance, distance)));
        if let Some(zeta) = mode.damping_ratio.filter(|zeta| *zeta > 0.0) {
            values.insert(Factor::Damping, zeta);
            let separation_widths = separation(model, index, zeta);
            values.extend(
                separation_widths.map(|separation_widths| (Factor::Separation, separation_widths)),
            );
            let record = set.and_then(|set| set.record_duration_s);
            let constant = zeta * std::f64::consts::TAU * mode.frequency_hz;
            values.extend(record.map(|record| (Factor::RecordLength, record * constant)));
        }
        values.retain(|_, value| value.is_finite());
        UserMode {
            test: test.to_owned(),
            number: index + 1,
            frequency_hz: mode.frequency_hz,
            values,
        }
    };
    model.modes.iter().enumerate().map(mode).collect()
}

fn separation(model: &ModalModel, index: usize, zeta: f64) -> Option<f64> {
    let hz = model.modes[index].frequency_hz;
    let others = model.modes.iter().enumerate().filter(|(k, _)| *k != index);
    let distances = others.map(|(_, other)| (other.frequency_hz - hz).abs());
    let nearest = distances.min_by(f64::total_cmp)?;
    Some(nearest / (2.0 * zeta * hz))
}

fn node_distance(model: &ModalModel, mode: &Mode) -> Option<f64> {
    let (_, largest) = mode.shape.largest()?;
    let at = model.references.iter();
    let at = at.filter_map(|dof| mode.shape.along_positive(dof));
    let best = at.map(|component| component.norm() / largest.norm());
    best.max_by(f64::total_cmp)
}

fn values_of_set(set: &FrfSet, model: &ModalModel) -> BTreeMap<Factor, f64> {
    let mut values = BTreeMap::new();
    let hits = set
        .functions()
        .iter()
        .filter_map(|function| function.averages)
        .min();
    values.extend(hits.map(|hits| (Factor::Hits, f64::from(hits))));
    let lines = match model.band {
        Some(band) => set.axis().lines(&band),
        None => 0..set.axis().len,
    };
    let ratio = |i: usize| {
        let noise: f64 = set.variance(i)?[lines.clone()].iter().sum();
        let power: f64 = set.values(i)[lines.clone()]
            .iter()
            .map(Complex64::norm_sqr)
            .sum();
        Some(10.0 * (power / noise).log10()).filter(|decibels| decibels.is_finite())
    };
    let mut ratios: Vec<f64> = (0..set.len()).filter_map(ratio).collect();
    ratios.sort_by(f64::total_cmp);
    values.extend(
        ratios
            .get(ratios.len() / 2)
            .map(|decibels| (Factor::Noise, *decibels)),
    );
    values
}

/// A mode in a slice.
#[derive(Clone, Debug, PartialEq)]
pub struct UserModePosition {
    /// The mode.
    pub mode: UserMode,
    /// Its position as fractions of the axes; below 0 or above 1 outside the slice.
    pub place: [f64; 2],
    /// By method; none outside the slice.
    pub margins: Vec<Margin>,
}

/// Distance of a mode from where a method fails.
#[derive(Clone, Debug, PartialEq)]
pub struct Margin {
    /// The method.
    pub method: String,
    /// Whether the method meets the stated error where the mode is.
    pub inside: bool,
    /// Distance to the contour of the method, along the axis on which it is nearer; `None` without
    /// a contour in the row and column of the mode.
    pub distance: Option<Distance>,
}

/// A distance along one axis of a slice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distance {
    /// Share of the axis.
    pub share: f64,
    /// The axis.
    pub axis: Axis,
}

impl Distance {
    /// In decades, or in the factor's unit.
    pub fn value(&self) -> f64 {
        let axis = &self.axis;
        match axis.scale {
            Scale::Linear => self.share * (axis.hi - axis.lo),
            Scale::Log => self.share * (axis.hi / axis.lo).log10(),
        }
    }

    /// Unit of [`Self::value`], with the factor: `decades of damping`, `dB of noise`.
    pub fn unit(&self) -> String {
        let words = self.axis.factor.name().replace('_', " ");
        match self.axis.factor.unit() {
            _ if self.axis.scale == Scale::Log => format!("decades of {words}"),
            "" => format!("of {words}"),
            unit if unit == words => words,
            unit => format!("{unit} of {words}"),
        }
    }
}

impl UserModePosition {
    /// Whether the mode lies in the slice.
    pub fn is_inside(&self) -> bool {
        self.place.iter().all(|share| (0.0..=1.0).contains(share))
    }

    /// The method that succeeds where the mode is and fails nearest to it, with that distance.
    pub fn nearest(&self) -> Option<(&str, Distance)> {
        let holding = self.margins.iter().filter(|margin| margin.inside);
        let measured =
            holding.filter_map(|margin| Some((margin.method.as_str(), margin.distance?)));
        measured.min_by(|a, b| a.1.share.total_cmp(&b.1.share))
    }

    /// `mode 4 (412.3 Hz) is 0.30 decades of separation from where circle fails; peak fails there
    /// already.`
    pub fn sentence(&self) -> String {
        let name = self.mode.name();
        if !self.is_inside() {
            return format!("{name} lies outside this slice.");
        }
        let failing = self.margins.iter().filter(|margin| !margin.inside);
        let failing: Vec<&str> = failing.map(|margin| margin.method.as_str()).collect();
        let already = match failing.as_slice() {
            [] => String::new(),
            [one] => format!("; {one} fails there already"),
            [all @ .., last] => format!("; {} and {last} fail there already", all.join(", ")),
        };
        match self.nearest() {
            Some((method, distance)) => {
                let (value, unit) = (distance.value(), distance.unit());
                format!("{name} is {value:.2} {unit} from where {method} fails{already}.")
            }
            None => {
                format!("{name}: no other method begins to fail near it in this slice{already}.")
            }
        }
    }
}

impl SliceResult {
    /// Positions of the modes with both factors, those nearest to a contour first. A slice of
    /// hammer tests over noise has none: the noise of its responses is not comparable with that of
    /// FRFs.
    pub fn locate_modes(&self, modes: &[UserMode]) -> Vec<UserModePosition> {
        let (x, y) = (self.slice.x, self.slice.y);
        let noise = [x.factor, y.factor].contains(&Factor::Noise);
        if noise && self.slice.needs_test() {
            return Vec::new();
        }
        let methods = 0..self.slice.methods.len();
        let fields: Vec<Field> = methods
            .map(|m| self.field(m, SuccessRate::Counted))
            .collect();
        let point = |mode: &UserMode| {
            let share = |axis: &Axis| axis.share(*mode.values.get(&axis.factor)?);
            let mut point = UserModePosition {
                place: [share(&x)?, share(&y)?],
                mode: mode.clone(),
                margins: Vec::new(),
            };
            if point.is_inside() {
                point.margins = self.margins(point.place, &fields);
            }
            Some(point)
        };
        let mut points: Vec<UserModePosition> = modes.iter().filter_map(point).collect();
        let slack = |point: &UserModePosition| {
            point
                .nearest()
                .map_or(f64::INFINITY, |(_, distance)| distance.share)
        };
        sort_ascending_by(&mut points, slack);
        points
    }

    fn margins(&self, place: [f64; 2], fields: &[Field]) -> Vec<Margin> {
        let margin = |(method, field): (&String, &Field)| {
            let along = |along_x: bool| {
                let share = field
                    .distance_to_crossing(place, along_x, MIN_SUCCESS_RATE)?
                    .abs();
                let axis = if along_x { self.slice.x } else { self.slice.y };
                Some(Distance { share, axis })
            };
            let both = [along(true), along(false)].into_iter().flatten();
            Margin {
                method: method.clone(),
                inside: field.at(place) >= MIN_SUCCESS_RATE,
                distance: both.min_by(|a, b| a.share.total_cmp(&b.share)),
            }
        };
        self.slice.methods.iter().zip(fields).map(margin).collect()
    }
}

impl UserMode {
    /// `mode 4 (412.3 Hz)`, with its test where there are several.
    pub fn name(&self) -> String {
        let test = match self.test.as_str() {
            "" => String::new(),
            test => format!("{test}, "),
        };
        format!("{test}mode {} ({:.1} Hz)", self.number, self.frequency_hz)
    }
}
