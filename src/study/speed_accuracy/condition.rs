//! A condition of the twin states its band, its lines and the end of its record.

use crate::axis::{Band, FrequencyAxis};

use super::super::{StudyError, System};
use super::SpeedAccuracyOptions;

/// Time before the hit, over the time from the hit to the end of a short record. Assumed: a
/// measurement system keeps a few percent.
const PRETRIGGER: f64 = 0.02;
/// Smallest number of modes of a twin whose first and last mode can lie outside the band.
pub(super) const MIN_MODES_FOR_OUTSIDE: usize = 4;

/// Condition of the twin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Condition {
    /// The modes of the band alone, in white noise: what every method assumes.
    White,
    /// The band excludes the first and the last mode of the twin.
    Outside,
    /// The record ends before the response has decayed, with the time before the hit in it.
    Truncated,
}

impl Condition {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::White, Self::Outside, Self::Truncated];

    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::White => "white noise",
            Self::Outside => "modes outside the band",
            Self::Truncated => "record ends early",
        }
    }

    /// The twin under this condition; `None` where it has too few modes.
    pub(super) fn apply_to(
        self,
        twin: &System,
        options: &SpeedAccuracyOptions,
    ) -> Result<Option<System>, StudyError> {
        let inside = twin.modes.iter().filter(|mode| twin.inside(mode)).cloned();
        let alone = System {
            modes: inside.collect(),
            ..twin.clone()
        };
        match self {
            Self::White => thinned(alone, options.lines_per_width).map(Some),
            Self::Outside => {
                let hz: Vec<f64> = alone.modes.iter().map(|mode| mode.hz()).collect();
                let between = |r: usize| 0.5 * (hz[r] + hz[r + 1]);
                let enough = hz.len() >= MIN_MODES_FOR_OUTSIDE;
                let band = enough.then(|| Band::new(between(0), between(hz.len() - 2)).ok());
                let Some(band) = band.flatten() else {
                    return Ok(None);
                };
                let narrow = twin.clone().on_lines(twin.axis, band)?;
                thinned(narrow, options.lines_per_width).map(Some)
            }
            Self::Truncated => {
                let decay = alone.modes.iter().map(|mode| -mode.pole.lambda.re);
                let Some(slowest) = decay.reduce(f64::min) else {
                    return Ok(None);
                };
                let end_s = options.record_time_constants / slowest;
                let ended = System {
                    record_end_s: Some(end_s),
                    ..alone
                };
                let step_hz = (end_s * (1.0 + PRETRIGGER)).recip();
                let axis = FrequencyAxis {
                    start_hz: 0.0,
                    step_hz,
                    len: (twin.band.hi_hz / step_hz) as usize + 2,
                };
                ended.on_lines(axis, twin.band).map(Some)
            }
        }
    }
}

/// The system with at most the stated number of lines per half-power bandwidth of its narrowest
/// mode.
fn thinned(system: System, lines_per_width: Option<f64>) -> Result<System, StudyError> {
    let inside = system.modes.iter().filter(|mode| system.inside(mode));
    let narrowest = inside.map(|mode| mode.width_hz()).reduce(f64::min);
    let Some((wanted, width)) = lines_per_width.zip(narrowest) else {
        return Ok(system);
    };
    let (axis, band) = (system.axis, system.band);
    let every = (width / wanted / axis.step_hz).floor().max(1.0);
    let sparse = FrequencyAxis {
        step_hz: every * axis.step_hz,
        len: (axis.len - 1) / every as usize + 1,
        ..axis
    };
    system.on_lines(sparse, band)
}
