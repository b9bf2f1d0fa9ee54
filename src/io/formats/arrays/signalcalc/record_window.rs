//! The window of the averaged functions, from the records of the last hit without and with it.
//!
//! The file states no window, but holds each record twice: `X2` as measured and `W2` times the
//! window. Where their ratio is exp(-σt) from the start of the record on, the window is
//! exponential and adds the decay rate σ to every pole. All hits have the same window.

use std::collections::{BTreeMap, VecDeque};

use crate::frf::Window;
use crate::io::formats::arrays::store::ArrayStore;
use crate::io::{ArrayInfo, Block, Catalog, FunctionMetadata, Part};
use crate::linalg::sort_ascending_by;

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
        let mut found = BTreeMap::new();
        for RecordPair {
            channel,
            index,
            windowed,
        } in record_pairs(store.list())
        {
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

/// The records of a channel, by their place in the list of arrays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct RecordPair {
    channel: u32,
    index: usize,
    windowed: usize,
}

/// Records without and with a window of the same channel; of several windowed ones the first.
fn record_pairs(list: &[ArrayInfo]) -> Vec<RecordPair> {
    let mut windowed = BTreeMap::new();
    for (index, info) in list.iter().enumerate() {
        if let Some(channel) = record_channel(info, 'W') {
            windowed.entry(channel).or_insert(index);
        }
    }
    let records = list.iter().enumerate().filter_map(|(index, info)| {
        let channel = record_channel(info, 'X')?;
        let windowed = *windowed.get(&channel)?;
        Some(RecordPair {
            channel,
            index,
            windowed,
        })
    });
    records.collect()
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
    let mut ascending: Vec<RecordWindow> = windows.values().copied().collect();
    sort_ascending_by(&mut ascending, |window| window.decay_rad_s);
    let shared = best_decay_rates(&ascending, &mut 0);
    let rates = ascending.iter().map(|window| window.decay_rad_s.to_bits());
    let shared: BTreeMap<u64, f64> = rates.zip(shared).collect();
    for window in windows.values_mut() {
        let best = shared.get(&window.decay_rad_s.to_bits());
        window.decay_rad_s = best.copied().unwrap_or(window.decay_rad_s);
    }
}

/// For each of the windows, in ascending order of their rates, the rate of the one with the most
/// samples among those of the same rate. Both limits of these ascend, so that each window enters
/// and leaves the candidates once; `comparisons` counts this work.
fn best_decay_rates(ascending: &[RecordWindow], comparisons: &mut usize) -> Vec<f64> {
    // Windows of descending numbers of samples that may be the best of this or a later range.
    let mut candidates: VecDeque<usize> = VecDeque::new();
    let mut next = 0;
    let decay_rates = ascending.iter().map(|window| {
        let rate = window.decay_rad_s;
        let reach = MAX_DECAY_DIFFERENCE * rate;
        while let Some(entering) = ascending.get(next)
            && entering.decay_rad_s <= rate + reach
        {
            while let Some(last) = candidates.back()
                && ascending[*last].samples <= entering.samples
            {
                candidates.pop_back();
                *comparisons += 1;
            }
            candidates.push_back(next);
            next += 1;
            *comparisons += 1;
        }
        while let Some(first) = candidates.front()
            && ascending[*first].decay_rad_s < rate - reach
        {
            candidates.pop_front();
            *comparisons += 1;
        }
        let best = candidates.front();
        best.map_or(rate, |best| ascending[*best].decay_rad_s)
    });
    decay_rates.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn window(decay_rad_s: f64, samples: usize) -> RecordWindow {
        RecordWindow {
            decay_rad_s,
            samples,
            is_cut: false,
            record_s: 1.0,
        }
    }

    #[test]
    fn windows_of_one_rate_share_that_of_the_most_samples() {
        let rates = [
            (1.0, 40),
            (1.0005, 900),
            (2.0, 10),
            (2.001, 5),
            (2.0025, 70),
        ];
        let mut windows: BTreeMap<u32, RecordWindow> = (0..)
            .zip(rates.map(|(rate, samples)| window(rate, samples)))
            .collect();
        share_decay_rates(&mut windows);
        let shared: Vec<f64> = windows.values().map(|window| window.decay_rad_s).collect();
        assert_eq!(shared, [1.0005, 1.0005, 2.0, 2.0025, 2.0025]);
    }

    #[test]
    fn the_work_of_sharing_grows_with_the_number_of_windows_alone() {
        let windows = (0..10_000).map(|n| window(1.0 + 1e-8 * f64::from(n), 10_000 - n as usize));
        let windows: Vec<RecordWindow> = windows.collect();
        let mut comparisons = 0;
        let shared = best_decay_rates(&windows, &mut comparisons);
        assert_eq!(shared, vec![1.0; 10_000]);
        assert!(comparisons <= 3 * windows.len(), "{}", comparisons);
    }

    #[test]
    fn records_are_paired_by_their_channel() {
        let list = ["W1", "X2", "X1", "W2", "W2", "X3"].map(|name| ArrayInfo {
            name: name.to_owned(),
            shape: vec![8, 2],
            kind: "f64".to_owned(),
        });
        let pairs = record_pairs(&list).into_iter();
        let pairs: Vec<[usize; 3]> = pairs
            .map(|pair| [pair.channel as usize, pair.index, pair.windowed])
            .collect();
        assert_eq!(pairs, [[2, 1, 3], [1, 2, 0]]);
    }
}
