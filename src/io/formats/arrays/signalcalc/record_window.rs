//! The window of the averaged functions, from the records of the last hit without and with it.
//!
//! The file states no window, but holds each record twice: `X2` as measured and `W2` times the
//! window. Where their ratio is exp(-σt) from the start of the record on, the window is
//! exponential and adds the decay rate σ to every pole. All hits have the same window.

use std::collections::BTreeMap;

use crate::frf::Window;
use crate::io::formats::arrays::store::ArrayStore;
use crate::io::{Block, Catalog, FunctionMetadata, Part};

use super::named_columns::{AxisAndValues, columns_of, record_channel};

/// Samples of at least this part of the peak are compared. Larger: the record of a force, 39
/// samples above 1 % of its peak in a measurement with 8192 samples, has too few. Smaller: samples
/// near 0 of a record in fixed point have few digits; one in single precision needs no limit, it
/// meets [`MAX_LOG_RATIO_ERROR`] down to 1e-5.
const MIN_SAMPLE_OVER_PEAK: f64 = 1e-2;

/// Maximum error of the logarithm of the ratio of both records. Larger: a slow window of another
/// shape, such as the flat part of a Tukey window, is taken as none. Smaller than 2e-7: the
/// exponential window of a measured file, stored in single precision, is met to 1.4e-7 only
/// (`the_functions_of_an_analyser_file_are_entries`).
const MAX_LOG_RATIO_ERROR: f64 = 1e-5;

/// Decay rates that differ by no more than this part are those of one window. Larger: windows of
/// two settings are taken as one. Smaller: the rate of a force, from 40 samples of a measured file,
/// has an error of 2e-6, and FRFs of two rates are no common set.
const MAX_DECAY_DIFFERENCE: f64 = 1e-3;

/// The ratio of a record with its window to the record without.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RecordWindow {
    /// Decay rate, rad/s; 0 without an exponential window.
    pub decay_rad_s: f64,
    /// Number of samples that the decay rate is estimated from.
    pub samples: usize,
    /// Whether samples behind the pulse are set to 0, as by a force window.
    pub is_cut: bool,
    /// Length of the record, s.
    pub record_s: f64,
}

impl RecordWindow {
    /// The windows of all channels, by their number.
    pub fn read_all(store: &mut dyn ArrayStore, catalog: &mut Catalog) -> BTreeMap<u32, Self> {
        let list = store.list().to_vec();
        let mut found = BTreeMap::new();
        for (index, info) in list.iter().enumerate() {
            let Some(channel) = record_channel(info, 'X') else {
                continue;
            };
            let is_windowed = |other| record_channel(other, 'W') == Some(channel);
            let Some(windowed) = list.iter().position(is_windowed) else {
                continue;
            };
            let mut read = |index| {
                let array = store.read(index);
                array.and_then(|array| columns_of(array, &catalog.path))
            };
            match read(index).and_then(|record| Ok((record, read(windowed)?))) {
                Ok((record, windowed)) => {
                    found
                        .extend(Self::of_records(&record, &windowed).map(|ratio| (channel, ratio)));
                }
                Err(error) => catalog.note_damage(error, Part::Record),
            }
        }
        share_decay_rates(&mut found);
        found
    }

    /// The window between two records; `None` where it is neither exponential nor constant.
    fn of_records(record: &AxisAndValues, windowed: &AxisAndValues) -> Option<Self> {
        let times = &record.axis;
        let (Block::F64(before), Block::F64(after)) = (&record.values, &windowed.values) else {
            return None;
        };
        let (start_s, len) = (*times.first()?, times.len());
        if after.len() != len || windowed.axis != *times {
            return None;
        }
        let peak = before
            .iter()
            .fold(0.0, |peak: f64, value| peak.max(value.abs()));
        let samples = || {
            let pairs = before.iter().zip(after).zip(times);
            pairs.filter(|((before, _), _)| before.abs() >= MIN_SAMPLE_OVER_PEAK * peak)
        };
        let is_zero = |value: f64| value.abs() < f64::MIN_POSITIVE;
        // Behind the pulse of a force the window is 0.
        let is_cut = before
            .iter()
            .zip(after)
            .any(|(x, w)| is_zero(*w) && !is_zero(*x));
        let logarithms = samples().filter(|((_, after), _)| !is_zero(**after));
        let logarithms = logarithms.map(|((x, w), time)| (time - start_s, (w / x).ln()));
        let logarithms: Vec<(f64, f64)> = logarithms.collect();
        let sums = logarithms
            .iter()
            .fold((0.0, 0.0), |(products, squares), (t, ln)| {
                (products + t * ln, squares + t * t)
            });
        let decay_rad_s = -sums.0 / sums.1;
        let fits = |(t, ln): &(f64, f64)| (ln + decay_rad_s * t).abs() <= MAX_LOG_RATIO_ERROR;
        if logarithms.is_empty() || !logarithms.iter().all(fits) {
            return None;
        }
        let record_s = (times.last()? - start_s) * len as f64 / (len - 1) as f64;
        let is_constant = decay_rad_s.abs() * record_s <= MAX_LOG_RATIO_ERROR;
        (is_constant || decay_rad_s > 0.0).then_some(Self {
            decay_rad_s: if is_constant { 0.0 } else { decay_rad_s },
            samples: logarithms.len(),
            is_cut,
            record_s,
        })
    }

    /// States the window in the metadata of an FRF.
    pub fn describe(self, note: &mut FunctionMetadata) {
        note.record_s = Some(self.record_s);
        note.added_damping_rad_s = (self.decay_rad_s > 0.0).then_some(self.decay_rad_s);
        note.window = Some(match (self.decay_rad_s > 0.0, self.is_cut) {
            (true, true) => Window::ForceAndExponential,
            (true, false) => Window::Exponential,
            (false, true) => Window::Force,
            (false, false) => Window::Rectangular,
        });
    }
}

/// The window of an FRF: the decay rate of the response, and whether the force is cut.
pub(super) fn of_function(
    windows: &BTreeMap<u32, RecordWindow>,
    reference: u32,
    response: u32,
) -> Option<RecordWindow> {
    let response = *windows.get(&response)?;
    let force = windows.get(&reference);
    Some(RecordWindow {
        is_cut: force.is_some_and(|force| force.is_cut),
        ..response
    })
}

/// Gives channels of one window the same decay rate, the one estimated from the most samples.
fn share_decay_rates(windows: &mut BTreeMap<u32, RecordWindow>) {
    let all: Vec<RecordWindow> = windows.values().copied().collect();
    for window in windows.values_mut() {
        let decay_rad_s = window.decay_rad_s;
        let is_same = |other: &&RecordWindow| {
            (other.decay_rad_s - decay_rad_s).abs() <= MAX_DECAY_DIFFERENCE * decay_rad_s
        };
        let best = all.iter().filter(is_same).max_by_key(|other| other.samples);
        window.decay_rad_s = best.map_or(decay_rad_s, |best| best.decay_rad_s);
    }
}
