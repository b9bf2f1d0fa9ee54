//! Figures of a model: natural frequencies over a parameter, responses in growing detail, and the
//! error of simpler models over their cost.

use std::f64::consts::TAU;

use crate::axis::Band;
use crate::theory::{DetailComparison, DetailResponse, EventKind, Locus, Sweep, TimeResponse};

use super::axis::{Axis, draw_frame, range};
use super::canvas::{Anchor, Canvas, FAINT, INK, LEGEND_ROW_PX, legend_rows};
use super::mark::{DASHES, curve_color, draw_mark};

const WIDTH_PX: f64 = 735.0;
const LEFT_PX: f64 = 75.0;
const RIGHT_PX: f64 = 715.0;
const TOP_PX: f64 = 34.0;
/// Half the side of the mark of a veering, and the radius of that of a crossing, px.
const EVENT_PX: f64 = 4.0;
/// Smaller errors are drawn at this one.
const MIN_ERROR_PERCENT: f64 = 1e-3;
/// Harmonics are drawn up to the last one above this fraction of the largest.
const MIN_HARMONIC: f64 = 0.01;
/// Recorded periods that a panel of a signal shows, and most points of its curve.
const SHOWN_PERIODS: usize = 2;
const MAX_POINTS: usize = 240;

/// Natural frequencies over a parameter, one panel for each sweep, with crossings and veerings
/// marked; `None` where no root is above 0 in the band.
pub fn sweeps_svg(name: &str, sweeps: &[Sweep], band: Option<Band>) -> Option<String> {
    const PANEL_PX: f64 = 400.0;
    let mut canvas = Canvas::new(WIDTH_PX, PANEL_PX * sweeps.len() as f64);
    let mut is_drawn = false;
    for (number, swept) in sweeps.iter().enumerate() {
        let top = PANEL_PX * number as f64;
        is_drawn |= draw_sweep(&mut canvas, name, swept, band, top).is_some();
    }
    is_drawn.then(|| canvas.finish())
}

fn draw_sweep(
    canvas: &mut Canvas,
    name: &str,
    swept: &Sweep,
    band: Option<Band>,
    top: f64,
) -> Option<()> {
    let hz = |locus: &Locus, at: usize| {
        let hz = locus.omega_rad_s[at]? / TAU;
        (hz > 0.0 && band.is_none_or(|band| band.contains(hz))).then_some(hz)
    };
    let places = 0..swept.values.len();
    let all = swept
        .loci
        .iter()
        .flat_map(|locus| places.clone().filter_map(|at| hz(locus, at)));
    let (lo, hi) = range(all)?;
    let pad = 0.04 * (hi - lo);
    let (first, last) = (*swept.values.first()?, *swept.values.last()?);
    let bottom = top + 320.0;
    let is_geometric = first > 0.0 && last >= 10.0 * first;
    let x = match is_geometric {
        true => Axis::log((first, last), (LEFT_PX, RIGHT_PX)),
        false => Axis::linear((first, last), (LEFT_PX, RIGHT_PX)),
    };
    let y = Axis::linear((lo - pad, hi + pad), (bottom, top + TOP_PX));
    let unit = match swept.parameter.unit.as_str() {
        "" | "1" => String::new(),
        unit => format!(" ({unit})"),
    };
    let label = format!("{}{unit}", swept.parameter.name);
    let title = format!(
        "Natural frequencies of {name} over {}",
        swept.parameter.name
    );
    canvas.text([LEFT_PX, top + 18.0], &title, Anchor::Start, INK);
    draw_frame(canvas, (&x, &y), (&label, "Natural frequency (Hz)"));
    for (number, locus) in swept.loci.iter().enumerate() {
        let point = |at: usize| Some([x.position(swept.values[at]), y.position(hz(locus, at)?)]);
        let points: Vec<Option<[f64; 2]>> = places.clone().map(point).collect();
        let is_repeated = locus.multiplicity.iter().any(|count| *count > 1);
        let width = if is_repeated { 2.6 } else { 1.2 };
        canvas.curve("locus", &points, curve_color(number), width, "");
    }
    for event in &swept.events {
        for hz in event.frequency_hz {
            let place = x.visible_position(event.place).zip(y.visible_position(hz));
            let Some((u, v)) = place else { continue };
            match event.kind {
                EventKind::Crossing => canvas.dot([u, v], EVENT_PX, "none", INK),
                EventKind::Veering => {
                    let corner = |sign: f64| [u + sign * EVENT_PX, v + sign * EVENT_PX];
                    canvas.rect(corner(-1.0), corner(1.0), "none", INK);
                }
            }
        }
    }
    let note = "Circle: crossing. Square: veering. Thick: repeated root.";
    canvas.text([LEFT_PX, bottom + 52.0], note, Anchor::Start, FAINT);
    Some(())
}

/// Largest error of the natural frequencies of simpler models over the work of their eigenproblem,
/// the simplest within the stated error marked; `None` without a simpler model or a common root.
///
/// Roots count that are in the band and in every model.
pub fn details_svg(
    name: &str,
    compared: &DetailComparison,
    band: Option<Band>,
    within: f64,
) -> Option<String> {
    let whole = compared.models.last()?.coordinates;
    let models = 0..compared.models.len();
    let inside = |root: &usize| {
        let hz = compared.roots[*root].omega_rad_s / TAU;
        band.is_none_or(|band| band.contains(hz))
            && models
                .clone()
                .all(|model| compared.error(model, *root).is_some())
    };
    let roots: Vec<usize> = (0..compared.roots.len()).filter(inside).collect();
    let highest_hz = compared.roots[*roots.last()?].omega_rad_s / TAU;
    let error_percent = |model: usize| {
        let errors = roots.iter().filter_map(|root| compared.error(model, *root));
        let worst = errors.map(f64::abs).fold(0.0, f64::max);
        (100.0 * worst).max(MIN_ERROR_PERCENT)
    };
    let errors: Vec<f64> = models.clone().map(error_percent).collect();
    let costs: Vec<f64> = compared
        .models
        .iter()
        .map(|model| model.cost(whole))
        .collect();
    let (least, _) = range(costs.iter().copied()).filter(|_| costs.len() > 1)?;
    let limit = 100.0 * within;
    let (lo, hi) = range(errors.iter().copied().chain([limit]))?;
    let mut canvas = Canvas::new(WIDTH_PX, 400.0);
    let title = format!(
        "Simpler models of {name}: error of {} roots up to {highest_hz:.1} Hz over cost",
        roots.len()
    );
    canvas.text([LEFT_PX, 18.0], &title, Anchor::Start, INK);
    let x = Axis::log((0.7 * least, 1.4), (LEFT_PX, RIGHT_PX));
    let y = Axis::log((0.5 * lo, 2.0 * hi), (320.0, TOP_PX));
    let labels = (
        "Work of the eigenproblem over that of the whole model",
        "Largest error of a frequency (%)",
    );
    draw_frame(&mut canvas, (&x, &y), labels);
    let level = y.position(limit);
    let ends = [Some([LEFT_PX, level]), Some([RIGHT_PX, level])];
    canvas.curve("limit", &ends, INK, 1.0, "7 4");
    for (cost, error) in costs.iter().zip(&errors) {
        draw_mark(&mut canvas, [x.position(*cost), y.position(*error)], 0);
    }
    let mut all = models;
    if let Some(best) = all.find(|model| errors[*model] <= limit) {
        let at = [x.position(costs[best]), y.position(errors[best])];
        canvas.dot(at, 8.0, "none", INK);
        let described = &compared.models[best];
        let words = format!("{}, {} coordinates", described.name, described.coordinates);
        let anchor = match at[0] > 0.5 * (LEFT_PX + RIGHT_PX) {
            true => Anchor::End,
            false => Anchor::Start,
        };
        canvas.text([at[0], at[1] - 12.0], &words, anchor, INK);
    }
    let note = "Dashed: stated error. Ringed: the simplest model within it.";
    canvas.text([LEFT_PX, 372.0], note, Anchor::Start, FAINT);
    Some(canvas.finish())
}

/// Signals of a steady response over time and their spectra, one row for each signal and a curve
/// for each detail of the model; `None` without a signal.
pub fn response_svg(name: &str, response: &TimeResponse) -> Option<String> {
    const ROW_PX: f64 = 210.0;
    let signals: Vec<&str> = response
        .details
        .last()?
        .signals
        .iter()
        .map(|signal| signal.name)
        .collect();
    let details = response.details.iter().enumerate();
    let names: Vec<(&str, &str)> = details
        .map(|(number, detail)| (detail.detail, curve_color(number)))
        .collect();
    let legend = LEGEND_ROW_PX * legend_rows(LEFT_PX, WIDTH_PX, &names) as f64;
    let height = 40.0 + ROW_PX * signals.len() as f64 + legend + 10.0;
    let mut canvas = Canvas::new(WIDTH_PX, height);
    let title = format!(
        "Steady response of {name}, excited at {:.4} Hz",
        response.excitation_hz
    );
    canvas.text([LEFT_PX, 18.0], &title, Anchor::Start, INK);
    for (row, signal) in signals.iter().enumerate() {
        draw_signal(&mut canvas, response, signal, 40.0 + ROW_PX * row as f64);
    }
    canvas.legend([LEFT_PX, height - legend], &names);
    (!signals.is_empty()).then(|| canvas.finish())
}

/// Distance of each signal of simpler models from that of the most detailed one, a curve for each
/// signal over the details, with the stated limit; `None` without a signal of a simpler model.
pub fn signal_details_svg(name: &str, response: &TimeResponse, within: f64) -> Option<String> {
    let (last, simpler) = response.details.split_last()?;
    let distances = |signal: &str| -> Vec<Option<f64>> {
        let distance = |detail: &DetailResponse| {
            let distance = response.difference(signal, detail.detail, last.detail)?;
            Some((100.0 * distance).max(MIN_ERROR_PERCENT))
        };
        simpler.iter().map(distance).collect()
    };
    let signals = last.signals.iter().map(|signal| signal.name);
    let curves: Vec<(&str, Vec<Option<f64>>)> =
        signals.map(|name| (name, distances(name))).collect();
    let all = curves.iter().flat_map(|(_, of)| of).flatten().copied();
    all.clone().next()?;
    let limit = 100.0 * within;
    let (lo, hi) = range(all.chain([limit]))?;
    let colors = curves.iter().enumerate();
    let names: Vec<(&str, &str)> = colors
        .map(|(number, (name, _))| (*name, curve_color(number)))
        .collect();
    let legend = LEGEND_ROW_PX * legend_rows(LEFT_PX, WIDTH_PX, &names) as f64;
    let height = 400.0 + legend;
    let mut canvas = Canvas::new(WIDTH_PX, height);
    let title = format!(
        "Simpler models of {name}: distance of their signals from those of \"{}\"",
        last.detail
    );
    canvas.text([LEFT_PX, 18.0], &title, Anchor::Start, INK);
    let x = Axis::linear((0.5, simpler.len() as f64 + 0.5), (LEFT_PX, RIGHT_PX));
    let y = Axis::log((0.5 * lo, 2.0 * hi), (320.0, TOP_PX));
    let details = (1..).zip(simpler);
    let details: Vec<String> = details
        .map(|(number, detail)| format!("{number}: {}", detail.detail))
        .collect();
    let labels = (&*details.join(", "), "|a - b|/|b| (%)");
    draw_frame(&mut canvas, (&x, &y), labels);
    let level = y.position(limit);
    let ends = [Some([LEFT_PX, level]), Some([RIGHT_PX, level])];
    canvas.curve("limit", &ends, INK, 1.0, "7 4");
    for (number, (_, distances)) in curves.iter().enumerate() {
        let point = |(detail, distance): (usize, &Option<f64>)| {
            Some([x.position(detail as f64 + 1.0), y.position((*distance)?)])
        };
        let points: Vec<Option<[f64; 2]>> = distances.iter().enumerate().map(point).collect();
        let dashes = DASHES[number % DASHES.len()];
        canvas.curve("distance", &points, curve_color(number), 1.4, dashes);
        for at in points.iter().flatten() {
            canvas.dot(*at, 3.0, curve_color(number), curve_color(number));
        }
    }
    let note = "Dashed: stated error.";
    canvas.text([LEFT_PX, 372.0], note, Anchor::Start, FAINT);
    canvas.legend([LEFT_PX, height - legend], &names);
    Some(canvas.finish())
}

fn draw_signal(canvas: &mut Canvas, response: &TimeResponse, name: &str, top: f64) -> Option<()> {
    const TIME_PX: (f64, f64) = (LEFT_PX, 395.0);
    const SPECTRUM_PX: (f64, f64) = (475.0, RIGHT_PX);
    let details = response.details.iter().enumerate();
    let found: Vec<_> = details
        .filter_map(|(number, detail)| Some((number, detail.signal(name)?)))
        .collect();
    let (_, described) = found.last()?;
    let periods = SHOWN_PERIODS.min(response.span.recorded_periods) as f64;
    let shown = |count: usize| {
        let part = periods / response.span.recorded_periods.max(1) as f64;
        (part * count as f64).round() as usize
    };
    let values = found.iter().flat_map(|(_, signal)| {
        let count = shown(signal.samples.len());
        signal.samples[..count].iter().copied()
    });
    let (lo, hi) = range(values)?;
    let pad = 0.05 * (hi - lo);
    let bottom = top + 150.0;
    let unit = match described.unit {
        "" => String::new(),
        unit => format!(" ({unit})"),
    };
    canvas.text([LEFT_PX, top - 6.0], described.meaning, Anchor::Start, INK);
    let x = Axis::linear((0.0, periods), TIME_PX);
    let y = Axis::linear((lo - pad, hi + pad), (bottom, top));
    draw_frame(
        canvas,
        (&x, &y),
        ("Periods of the excitation", &format!("{name}{unit}")),
    );
    for (number, signal) in &found {
        let count = shown(signal.samples.len());
        let point = |i: usize| {
            let at = periods * i as f64 / count as f64;
            Some([x.position(at), y.position(signal.samples[i])])
        };
        let step = count.div_ceil(MAX_POINTS).max(1);
        let points: Vec<Option<[f64; 2]>> = (0..count).step_by(step).map(point).collect();
        canvas.curve(
            "signal",
            &points,
            curve_color(*number),
            1.1,
            DASHES[number % DASHES.len()],
        );
    }
    let amplitudes = found
        .iter()
        .flat_map(|(_, signal)| signal.harmonics.iter().copied());
    let (_, largest) = range(amplitudes)?;
    let above = |amplitude: &f64| *amplitude > MIN_HARMONIC * largest;
    let last = found
        .iter()
        .filter_map(|(_, signal)| signal.harmonics.iter().rposition(above));
    let count = 1 + last.max()?;
    let x = Axis::linear((0.0, count as f64 + 1.0), SPECTRUM_PX);
    let y = Axis::linear((0.0, 1.05 * largest), (bottom, top));
    draw_frame(
        canvas,
        (&x, &y),
        (
            "Multiple of the excitation frequency",
            &format!("Amplitude{unit}"),
        ),
    );
    let width = found.len() as f64;
    for (place, (number, signal)) in found.iter().enumerate() {
        for (harmonic, amplitude) in signal.harmonics.iter().take(count).enumerate() {
            let offset = 2.0 * (place as f64 - 0.5 * (width - 1.0));
            let at = x.position(harmonic as f64 + 1.0) + offset;
            canvas.line(
                [at, bottom],
                [at, y.position(*amplitude)],
                curve_color(*number),
                1.6,
            );
        }
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::theory::{ResponseSignal, ResponseSpan};

    /// A signal of three periods: a cosine of this amplitude, and its harmonics.
    fn detail(name: &'static str, amplitude: f64) -> DetailResponse {
        let samples = (0..3000).map(|i| amplitude * (TAU * f64::from(i) / 1000.0).cos());
        DetailResponse {
            detail: name,
            coordinates: 6,
            evaluations_per_period: 100,
            functions_per_evaluation: 2,
            signals: vec![ResponseSignal {
                name: "x_s",
                unit: "m",
                meaning: "displacement of the sun",
                samples: samples.collect(),
                harmonics: vec![amplitude, 0.5 * amplitude, 1e-4 * amplitude, 0.0],
            }],
        }
    }

    #[test]
    fn a_comparison_of_signals_shows_the_distance_of_each_simpler_model() {
        let response = |amplitudes: [f64; 3]| TimeResponse {
            excitation_hz: 100.0,
            span: ResponseSpan {
                recorded_periods: 3,
                ..ResponseSpan::default()
            },
            details: ["torsional", "constant angle", "varying angle"]
                .into_iter()
                .zip(amplitudes)
                .map(|(name, amplitude)| detail(name, amplitude))
                .collect(),
        };
        let svg = signal_details_svg("gear", &response([1.5, 1.1, 1.0]), 0.01).unwrap();
        for part in [
            "distance of their signals",
            "1: torsional, 2: constant angle",
            "|a - b|/|b| (%)",
        ] {
            assert!(svg.contains(part), "{part} in {svg}");
        }
        // One curve of the signal and the limit; no signal over time.
        assert_eq!(svg.matches("class=\"distance\"").count(), 1);
        assert_eq!(svg.matches("class=\"limit\"").count(), 1);
        let other = signal_details_svg("gear", &response([1.5, 1.3, 1.0]), 0.01).unwrap();
        assert_ne!(svg, other);
        let single = TimeResponse {
            details: vec![detail("torsional", 1.0)],
            ..response([1.0; 3])
        };
        assert!(signal_details_svg("gear", &single, 0.01).is_none());
    }

    #[test]
    fn a_response_shows_each_detail_over_time_and_the_harmonics_that_matter() {
        let response = TimeResponse {
            excitation_hz: 100.0,
            span: ResponseSpan {
                recorded_periods: 3,
                ..ResponseSpan::default()
            },
            details: vec![detail("constant angle", 1.0), detail("varying angle", 2.0)],
        };
        let svg = response_svg("gear", &response).unwrap();
        for part in [
            "displacement of the sun",
            "x_s (m)",
            "constant angle",
            "varying angle",
        ] {
            assert!(svg.contains(part), "{part}");
        }
        assert_eq!(svg.matches("class=\"signal\"").count(), 2);
        // The third harmonic is below 1 %: two lines of each detail, and no curve of 3,000 points.
        assert_eq!(svg.matches("stroke-width=\"1.6\"").count(), 4);
        assert!(svg.len() < 30_000, "{}", svg.len());
    }
}
