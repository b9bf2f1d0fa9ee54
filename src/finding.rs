//! What the data says that is not a failure: a code, where, the value that was found and the limit
//! it met.
//!
//! A finding never stops the chain. Its sentence is made here from its parts, so that every report
//! says the same.

mod chinese;
mod numbers;
mod place;
mod severity;

use std::fmt;

use serde::{Deserialize, Serialize};

use numbers::{short, with_spread};
pub use place::Place;
pub use severity::Severity;

/// Declares the codes with their sentence and their longer explanation in one table.
macro_rules! codes {
    ($($(#[$doc:meta])* $name:ident: $sentence:literal, $explanation:literal;)*) => {
        /// What a finding is about.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
        #[serde(rename_all = "kebab-case")]
        pub enum Code { $($(#[$doc])* $name,)* }

        impl Code {
            /// Every code, in the order of its declaration.
            pub const ALL: &[Code] = &[$(Code::$name,)*];

            /// The sentence without place, value and limit.
            pub fn sentence(self) -> &'static str {
                match self { $(Code::$name => $sentence,)* }
            }

            /// What it means, why it matters and what to do about it.
            pub fn explanation(self) -> &'static str {
                match self { $(Code::$name => $explanation,)* }
            }
        }
    };
}

codes! {
    /// Records carry no usable version number, load case or identification.
    GroupedByOrder: "records were grouped into hits by order, length and sampling, because their headers do not say which belong together",
        "A universal file names the hit of a record by version number, load case and ID lines. Where these are empty or differ from record to record, the order in the file decides: a second force record, or a response that is already there, opens the next hit. Check the number of hits in the output.";
    /// The hit point comes from the responses or the scene, not from the force record.
    HitPointAssumed: "the hit point is not in the force record; the responses' common reference or the scene's word was taken",
        "The force record's response degree of freedom is the hit point. Where it is empty, the common reference of the responses is used, then the reference that the scene states.";
    /// A dataset of a number that is not read.
    UnknownDataset: "a dataset of this number is not read and was skipped",
        "Universal files hold many dataset numbers. One that modalign does not read is passed over; the value is its number.";
    /// A part of a file could not be read.
    BadDataset: "a dataset is damaged and was left out; the good part of the file was read",
        "Place, got and expected are given. `inspect` and `convert` deliver the good part and exit 1. Other verbs stop with exit 2 where their answer needs the damaged part, unless --partial is given; else they go on and exit 1. Modes and FRFs need neither geometry nor trace lines, titles, coherence or spectra.";
    /// A window that only some functions state.
    WindowNotCommon: "Only some FRFs have a stated window, or the stated windows differ. None was used.",
        "Dataset 1858 states the window of a function. Where all functions of a set state one, poles are fitted with the line shape that it gives to leakage. Here it was not used for any, so that damping may be too high where the force was steady random noise. The value is the number of functions that state a window, the limit the number of functions. State it for the others with `--window` or `window` of `[[test]]`, or identify the FRFs of each window separately.";
    /// An exponential window of unstated decay rate.
    WindowDecayUnknown: "Records had an exponential window whose decay rate is not stated. The damping that it adds was not removed.",
        "An exponential window adds its decay rate σ to that of every mode: damping ratios are too high by σ/(2πf), most at low frequencies. Dataset 1858 of universal files states the window without a rate in a stated unit. A window that falls to 1 % in T seconds has σ = 4.6/T. Subtract σ/(2πf) from the damping ratio of each mode. Or make the FRFs from the recorded hits with `modalign frf --response-window`, which removes the damping that it adds.";
    /// A function with a value that is no number.
    ValueNotFinite: "a function has a value or a variance in the band that is no finite number; it was left out",
        "The value is the frequency of the first such line. Without --partial the command stops there. A mode that was seen only at this response or from this hit point is missed, and without the driving point modes have no modal mass. Export the function anew.";
    /// The binary byte count is wrong.
    ByteCountWrong: "the byte count of a binary dataset does not agree with its number of points; the number of points was used",
        "Dataset 58b states the length of its binary block. Some writers state zero, half of it or another number. The value is the count as stated, the limit the count that the number of points needs.";
    /// The number of points is wrong.
    PointCountWrong: "the number of points of a binary dataset does not agree with its length; the length was used",
        "Dataset 58b states a number of points and a byte count. Where the closing delimiter stands behind the stated bytes and not behind the stated points, the bytes are all taken as values. The value is the number of points as stated, the limit the number that the bytes hold.";
    /// The closing delimiter is missing.
    NotClosed: "the delimiter behind the numbers of a dataset is missing; its numbers are all there",
        "A dataset of a universal file ends with a line `-1`. Where the file ends without it, or the next dataset begins, the dataset counts as whole when it has as many numbers as its header says and its last line is complete.";
    /// A header text is not UTF-8.
    HeaderNotUtf8: "a header text is not valid UTF-8; the offending bytes were replaced",
        "Old systems write units such as m/s² in Latin-1. Numbers are not affected.";
    /// A trace line of another length than stated.
    TraceLineCount: "a trace line has another number of entries than its header states; at most as many as stated were read",
        "Dataset 82 draws a line through nodes. No result depends on it. The value is the number of entries, the limit the number that the header states; zeros that fill up lines are not counted.";
    /// FRFs beside recorded hits.
    FunctionsPassedOver: "FRFs stand beside recorded hits and were passed over; they were estimated anew from the hits",
        "A test is made from its recorded hits where there are any. To use the FRFs of the file instead, give a file that holds them alone.";
    /// Time records beside FRFs.
    RecordsPassedOver: "time records stand beside FRFs and were left out; the FRFs were used",
        "Modes are identified from FRFs. `run` estimates them anew where the records of the file make hits, each with a force record; `identify` uses those of the file. The value is the number of records.";
    /// A record or function of a quantity that is not needed.
    FunctionLeftOut: "a record or function is not used for FRFs or modes and was left out",
        "FRFs and modes need a force and motions along an axis: displacement, velocity or acceleration. Sound pressure, voltage, rotations and the like, and functions over another abscissa than frequency, are left out. With --partial a function whose unit, point or values are not stated is left out too, and the exit code is 1. The detail says why.";
    /// Coherence that is none.
    CoherenceInvalid: "coherence outside 0 to 1 was ignored; the FRF was kept",
        "Coherence lies between 0 and 1; some analysers write other values, mostly at 0 Hz. At these lines the coherence of the nearest valid lines was used for the variance; where most lines are invalid, coherence was not used at all, and the noise is estimated from the fit residual. The value is the largest of the ignored values.";
    /// Something that the output format has no place for.
    NotCarried: "the output format cannot hold this, and it was left out",
        "`convert` writes what the output format can hold. The place names what is lost; the value says how many of it. HDF5, .mat and .npz hold everything but arrays whose meaning nobody has stated.";
    /// A hit of which records are missing.
    HitLeftOut: "this hit has another number of records than most; it was left out",
        "With --partial the whole hits of a partly bad file are used. A hit with another number of records than most, because the file ends inside it or a record beside it is bad, could pair a response with another hit's force. The value is the number of its records, the limit that of a whole hit.";
    /// Directions in local coordinate systems.
    LocalDirections: "directions at nodes with a local coordinate system are local; they are compared by name as if they were global",
        "Nodes of universal files may have a displacement coordinate system (datasets 18, 2420). Sensors and hits of records and FRFs are named in it. The modes identified from them keep these local directions; shapes from a model or from dataset 55 are global. Turn the sensors' directions with --dof-map, or state sensors with their direction in a scene. The value is the number of degrees of freedom.";
    /// The number of averages is not in the file.
    AveragesAssumed: "the number of averages is not stated; the variance of the FRFs assumes this number",
        "The variance of an FRF follows from its coherence and the number of averages. Where the file does not say how many hits were averaged, the value is assumed; standard deviations scale with one over the square root of it less one. State it with `averages` in [[test]] or --averages.";
    /// Samples that are not evenly spaced.
    UnevenAxis: "the abscissa is uneven; the function can be converted but not used for FRFs or identification",
        "FRF estimation and identification need evenly spaced samples or lines. An abscissa printed value by value counts as even when each value lies within the rounding of its place.";
    /// An abscissa of a unit that is not known.
    AxisUnitUnknown: "the unit of the abscissa is not known; its values are kept as they are and taken neither as seconds nor as hertz",
        "The header says time or frequency in a unit that modalign does not know. Such a function can be listed and converted, with the unit's text, but not used for FRFs or identification. Change the unit in the file to s or Hz, with the values.";
    /// Directions that were never measured.
    UnmeasuredLeftOut: "values that are 0 in every mode stand for directions that were not measured and were left out",
        "Measurement systems fill the directions of a node that were not measured with zeros, and dataset 55 cannot say so. Where the ID lines or the title name such a system (Test.Lab, LMS, Simcenter), or a note of modalign says that zeros are unmeasured, a degree of freedom that is exactly 0 in every one of these modes is left out. In every other file 0 is a value and stays. The place is the first of the modes, the value the number of degrees of freedom.";
    /// A modal scale without a unit.
    ModalScaleUnknown: "modal mass, modal A and modal B are of unknown unit and were left out",
        "Modal mass, A and B belong to the scale of the shape. They have a unit only where dataset 164 states the units of the file and the shape is a displacement; to which of its quantities the scale of a velocity or acceleration shape belongs differs from writer to writer. The shape itself stays, in an arbitrary scale. The value is the number of modes.";
    /// Shapes were turned from local coordinate systems.
    LocalSystemApplied: "shape values given in local coordinate systems were turned into the global frame",
        "Nodes of universal files may have a displacement coordinate system (datasets 18, 2420). Shapes are compared in the global frame, so the values at those nodes were turned; the value is the number of nodes.";
    /// A coordinate system that is named but not described.
    UnknownSystem: "a node's coordinate system is not described in the file; its values were taken as global",
        "A node names the coordinate system of its position or displacements by number. Datasets 18 and 2420 describe them; the value is a number that none describes.";
    /// Directions of shape values that are lost with damaged parts.
    DirectionsLost: "Nodes or coordinate systems of this file are damaged, and with them the directions of shape values. The values were taken as global.",
        "A node names the coordinate system of its displacements, and another dataset describes it. Where the nodes are damaged and the file describes a system that is not aligned with the global axes, or both are damaged, values in local directions cannot be distinguished from global ones, and MAC is wrong where they are local. The value is the number of nodes of the shapes without a readable description. Only --partial uses such shapes. Repair the file.";
    /// Analysis results that are no modes.
    NotModes: "data at nodes or elements that are no mode shapes were passed over",
        "Universal datasets 55 and 2414 hold results of many analyses. Shapes of normal modes and of complex eigenvalues are read; anything else is passed over. The value is the number of the analysis: 1 static, 2 normal mode (of another quantity than motion), 4 transient, 5 frequency response, 6 buckling.";
    /// A part of a file that is described but not read.
    ArrayNotRead: "an array of this kind is listed but cannot be read",
        "Containers hold more kinds of data than numbers: objects, functions, sparse arrays, references. They are listed by `inspect`, so that nothing is silently left out; the place names the array.";
    /// Degrees of freedom tied by position.
    DofsByNode: "degrees of freedom of test and theory were tied by the nearest node; the largest distance is given",
        "With --nearest-node the names do not count: a sensor of the test meets the theory's degree of freedom of the same axis at the node nearest to it, within the tolerance. Both geometries must be in one frame and in the same unit; look at the largest distance.";
    /// Motions without mass.
    MasslessCondensed: "coordinates carry no mass; they were condensed statically (exact: every mode with a finite frequency is kept)",
        "Rotations of lumped-mass models, and nodes without mass. Equilibrium alone determines their motion, so that the model has as many modes fewer. Frequencies, shapes at all coordinates, energies and sensitivities are those of the whole model. The value is the number of independent motions without mass.";
    /// Only the lowest modes of a large model were computed.
    LowestModesAlone: "the model is sparse: its lowest modes alone were computed; none is missing up to this frequency",
        "Of a model of many coordinates the modes are computed up to the end of the band, or as many as are asked for (30 where nothing is), by block Lanczos on the shifted and inverted matrices. The eigenvalues below the value are counted by the inertia of the shifted stiffness, and the modes are as many, repeated roots included. Ask for a band to see more.";
    /// Natural frequencies that the stiffness matrix does not determine.
    StiffnessRounding: "Rounding of the stiffness matrix alone may change a natural frequency by this part of it.",
        "The entries of a stiffness matrix are rounded to 16 digits. In a finely divided, slender or softly suspended structure the lowest modes are small differences of large entries, so that this rounding moves them: by up to eps |phi|^T |K| |phi| / omega^2 in omega^2. The value is the largest such part, and the finding is at the mode with it; further modes above the limit are listed. Use fewer or higher-order elements.";
    /// The sampling rate was restored from a rounded spacing.
    SpacingRounded: "the sampling rate was restored from a spacing printed with few digits",
        "Universal files print the spacing with six digits. Where exactly one whole number of samples per second lies within the rounding, that rate is taken.";
    /// One average gives no coherence.
    CoherenceAbsent: "coherence is absent, because there is only one average",
        "With a single hit the coherence is identically one and says nothing, and the variance rests on the noise before the hit alone. Record three hits or more at each point.";
    /// The record ends before the response has decayed.
    Truncated: "the response has not decayed when the record ends; H is wrong near resonance by up to this fraction",
        "A record that captures n time constants of the slowest mode makes H wrong by about exp(-n) of its peak: 2.5e-3 at 6, 7.5e-5 at 9.5. Record longer, or use an exponential window.";
    /// The decay cannot be measured because noise fills the tail.
    TruncationNotDecidable: "the truncation error cannot be told from the record, because its tail is noise",
        "The bound is taken from the fall of the response's energy over the last quarters of the record. Where those are noise, the response has decayed into it, and the noise limits H, not the truncation.";
    /// The hammer touched twice.
    DoubleHit: "the hammer touched the structure a second time",
        "A second contact makes the force spectrum a comb: the quotient of its peak to the first one's is the depth of the dips, at a spacing of one over the delay. The hit is left out when the dips are deep; `--accept` uses it all the same.";
    /// A channel at its rail.
    Overload: "a channel ran into the rail of its converter",
        "Three or more samples lie at the largest value that the converter holds. A clipped force is too small at every frequency, a clipped response puts harmonics into the spectrum. Lower the gain and hit again. A clipped response alone is left out of its own function; a clipped force leaves out the hit.";
    /// A hit much weaker or stronger than the others.
    HitLevel: "this hit is much weaker or stronger than the others at its point",
        "The value is its peak over the median peak of the point's hits. A weak hit has less signal over the noise, a strong one may reach into nonlinear behaviour.";
    /// Something rings before the hit.
    PreTriggerNotQuiet: "the channel is not quiet before the hit",
        "The structure still rang from the hit before, or something else excites it. What rings before the hit adds to the response to it. Wait longer between hits.";
    /// The response has not decayed.
    NotDecayed: "the response has not decayed when the record ends",
        "The value is the rms of the last part of the record over its largest value, the noise taken off.";
    /// The force spectrum falls inside the band.
    ForceRollOff: "the force spectrum falls by 20 dB inside the band of the analyser",
        "Above that frequency the hammer excites little and the noise takes over. A harder tip or a lighter hammer reaches higher. The usable band ends there.";
    /// A channel without signal.
    DeadChannel: "a channel holds no signal",
        "It is constant, or does not rise above its own noise when the hammer hits. Look at the cable, the range and the sensor.";
    /// The pulse is negative.
    NegativeForce: "the pulse of the force is negative",
        "Hammers are calibrated so that a push is positive. A negative pulse turns the phase of every function by 180 degrees, unless the hit point's direction says so.";
    /// Offset or drift.
    ChannelDrift: "a channel has an offset or drifts",
        "The value is in parts of the peak. The mean before the hit is taken off each channel; a drift is not, and disturbs the lowest lines.";
    /// A hit unlike the others.
    OddOneOut: "the FRF of this hit is unlike those of the other hits at its point",
        "The deviation from the average of the others is far beyond what their own scatter explains: another place or direction was hit, or a sensor was disturbed. The hit is left out; `--accept` uses it all the same.";
    /// The level that begins a hit.
    TriggerLevel: "hits were cut from a continuous recording where the force leaves its level by this much",
        "Without a stated level it is 5 % of the largest pulse, or what noise alone does not reach. Weaker hits are not seen: state `level_n` in [test.trigger] (--trigger-level).";
    /// The length of the records that were cut.
    HitLength: "the records of all hits that were cut have this length",
        "Without a stated length it is the smallest distance between two hits, so that one late bounce that counts as a hit shortens all records: state `length_s` in [test.trigger] (--hit-length).";
    /// A hit at the edge of a continuous recording.
    HitCutOff: "hits at the start or end of a continuous recording were left out, because their record is not whole",
        "All hits of a test have records of one length. State a shorter `length_s` (--hit-length) or `pretrigger_s` (--pretrigger) to keep them.";
    /// No record of a function passed.
    NoRecordPassed: "every record of this function ran into the rail or holds nothing; they are used all the same, because there would be none",
        "A function made of such records says little. Look at the range, the cable and the sensor, and measure it again.";
    /// No hit at a point passed.
    NoHitPassed: "no hit at this point passes the rules; they are used all the same, because there would be none",
        "Each has its own finding. The functions of this point are no better than these hits: measure the point again.";
    /// An exponential window was needed.
    WindowAdded: "an exponential window was put on force and responses, because a response has not decayed to 1 % when its record ends",
        "One window serves all hits of the test; its added damping travels with the functions and is taken out of every pole. The records begin at their pulse, so that the end of the record changes no pole. `--response-window none` leaves it away; a longer record needs none.";
    /// The force window is too short.
    ForceWindowCuts: "the force window cuts off part of the force: of the pulse itself, or of the anti-alias filter's ringing after it",
        "What follows the pulse is not noise alone. An anti-alias filter rings for some tens of samples, the same in force and response; cutting that off the force alone makes H wrong, most near the filter's edge. The value is the rms of what was cut off, beyond the noise, over the rms of the force. Hold the window longer.";
    /// The noise ratio of Hv was taken from the channels.
    NoiseRatioFromRecord: "Hv is scaled by the noise variances found before the hit",
        "Hv weighs the noise of force and response. Without a stated ratio the variances of both channels before the pulse are used, averaged over hits; the value is response over force in SI units.";
    /// Usable band ends.
    BandLimited: "the band was limited to where the force excites and the anti-alias filter is open",
        "Lines above 0.4 of the sampling rate, or where the force spectrum is more than 20 dB below its maximum, are not used for identification. The value is the upper edge.";
    /// The power into a driving point is negative.
    DrivingPointSign: "the real part of the mobility at a driving point is negative at resonances, which no passive structure allows",
        "Where force and response meet, power flows into the structure at every frequency: the real part of the mobility is not negative. The value is the share of energy with the wrong sign between the half-power points, the limit half of one resonance. Near 1 the sign of a channel is wrong, or the direction of the hit or the sensor. In between it is another point than the label says (some modes have the other sign there), or the response is late: see channel-delay.";
    /// Two reciprocal functions differ.
    NotReciprocal: "this function and its reciprocal differ by more than noise and calibration explain",
        "Response at i to a hit at j equals response at j to a hit at i while the structure is linear. The value is the rms difference over the rms of both, noise taken off: 0.1 is 10 %, 2 is a wrong sign. Look at the sensitivities, at whether hits and sensors were at the same points and along the same axes, at sensors that load the structure, and at loose parts.";
    /// Two measurements of one pair differ.
    RepeatsDiffer: "this function differs from the first measurement of the same pair by more than noise explains",
        "The pair is in the set more than once (#2, or the sensor turned round). The value is the rms difference over the rms of both, noise taken off; 2 is a wrong sign. The structure, the hit point or a sensitivity changed between the two, or one of them was made at another point.";
    /// Force and response are out of step.
    ChannelDelay: "the response is out of step with the force by a constant delay",
        "The phases of the residues fall in proportion to frequency, as a delay makes them. A positive value is a late response. The limit is a quarter of the sampling interval or what scattered phases explain. The whole test is named when every response is late (or early) alike, which points to the force channel: unsynchronised or multiplexed converters, another anti-alias filter on one channel, a trigger offset. Frequencies and damping stand; signs and phases of shapes, residues and driving points do not.";
    /// Resonances move with the position of the sensor.
    MassLoading: "a resonance moves with the position of the sensor, the more the more the sensor moves: the mass of the sensor loads the structure",
        "The value is how far the frequency of this run lies from the mean of all runs, the limit what noise explains, or 0.15 of the half-power width where that is more. A sensor of mass m lowers a mode by half of m times the square of its mass-normalised component there. Poles and shapes from all runs together are a mixture. Use a lighter sensor, rove the hammer, or put dummy masses at the other positions.";
    /// Resonances move from run to run.
    RunsDisagree: "a resonance has another frequency in this run than in the others",
        "The value is how far the frequency of this run lies from the mean of all runs, the limit what noise explains; where FRFs are checked, 0.15 of the half-power width at least. The structure changed between runs (temperature, boundary, a joint, level of the hits) or a sensor was moved. Identify the runs one by one, or measure this one again.";
    /// Runs of different frequencies were merged into one mode.
    RunsMerged: "the frequency of this mode differs from run to run; every run was fitted with its own, and the mode is their mean; parts that each vibrate by themselves look the same",
        "One frequency for all runs does not describe the functions; one of its own for every run does, and better than further modes would (by the Bayesian information criterion), and what moves the modes has one cause: they move together, or with the mass of a sensor. A run is the functions of one position of a roving sensor or, where there are no more responses than references, of one hit point. Frequency and damping are the mean of the runs. The value is the standard deviation between runs, which the deviation of the frequency contains. A sensor's mass lowers every run, so that the free structure is then above the mean. Where all sensors stood still, two modes closer than their width may look so: compare runs.";
    /// Close modes that respond in different runs.
    RunsApart: "a close mode responds in the runs where this one does not: two parts of the structure, or one mode whose frequency differs between runs",
        "Both descriptions leave the same residual, so that both modes are listed. A run is the functions of one point that a sensor or the hammer went to. The value is the distance of the two in half-power widths. Where the structure has no such parts and sensors or hammer were moved, the runs were measured in different states: identify them one by one.";
    /// Too few lines across a half-power band.
    FewLines: "the half-power band holds too few frequency lines for a damping value",
        "Peak-picking needs about five lines across the half-power band; with fewer, damping is quantised by the line spacing. Record longer or fit a curve.";
    /// A circle fit whose damping surface is not flat.
    DampingSpread: "the damping surface is not flat: damping depends on which points are taken",
        "Each pair of points below and above resonance gives one damping value. For a single mode they agree. A spread beyond the limit means a neighbouring mode, leakage, noise or nonlinearity.";
    /// A peak that no single mode fits.
    NotFitted: "no single mode could be fitted under this peak; its values are those of the first look",
        "The fit found no circle or no half-power points, or left its peak. Frequency and damping of this row are read off the top of the peak, its neighbours not taken out. Use a multi-mode method, or a narrower band.";
    /// A second mode inside a resonance.
    CloseModes: "more than one mode lies under this peak, or its frequency moved between the functions; a single-mode method cannot tell them apart",
        "What single-mode fits leave over across the functions is far above the noise and has a shape of its own, or the functions disagree on the frequency by more than their bounds. Either two modes lie under the peak, and frequency, damping and shape of this row belong to a mixture, or the frequency moved from run to run (a roving sensor or hammer, temperature, amplitude). Use a multi-mode method, or look at the runs one by one.";
    /// Several modes with one pole.
    RepeatedRoot: "several modes share one natural frequency and damping; they are listed as one group",
        "The residues at this peak, as a matrix over responses and references, have more than one independent shape, and all of them have the same pole. The value is their number; there may be more, because no more than the lesser of responses and references can be seen. Any combination of the listed shapes is as good a set of modes: compare the space they span, not one shape with another.";
    /// Damping vanished with the window.
    DampingNotPositive: "no damping is left after that of the exponential window was taken out",
        "The window's decay rate is subtracted from every pole. Where the structure damps far less than the window, the difference is smaller than its error; the frequency stands, the damping is not known. Use a longer record and a weaker window.";
    /// A half-power point is missing.
    HalfPowerMissing: "the response does not fall to half power on one side of the peak before it rises again",
        "The half-power point on that side is hidden by a neighbouring mode or the band edge, so that damping comes from the other side alone.";
    /// A peak was not followed.
    PeakDropped: "a local maximum was not taken as a mode",
        "A peak must stand above the noise, be the highest point within its own half-power band, and give a positive damping. The value and the limit say which of these failed.";
    /// The variances came from the fit.
    NoiseFromFit: "not all FRFs bring variances; noise was told from what the fit leaves over",
        "Deviations of frequency and damping, and what counts as a mode, rest on the noise of the functions. Where one function has no variance, nor coherence and number of averages, that of all is taken from the second differences of the residual over some hundred lines, or from its level where lines share their noise. State the number of averages (`--averages`) where the coherence is there.";
    /// Noise decays over the record.
    LinesShareNoise: "neighbouring lines share their noise, as under an exponential window that the data do not state",
        "Noise that is even over a record differs from line to line. Here neighbouring lines share most of it, which looks like modes; its size was told from the level of what the fit leaves over, and it raises limits and deviations. The value is an estimate of the rate at which it decays over the record; without one it does not decay like that, as after smoothing over the lines. Where a window e^(−at) on force and response made that, the decay rate of every mode holds a as well, and its damping ratio a/ω too much. Export the FRFs without the window, or with its rate.";
    /// Roots of arbitrary phases describe the data.
    PhasesScatter: "no few modes describe the data to their noise, and the shapes of further roots have arbitrary phases; the modes are those that explain most",
        "So many roots as it takes fit any smooth course, but their shapes are then as much in quadrature as in phase with those of modes. Roots that explain less than a fifth of the response around them went, the least first, weak modes among them if there are any; what they described counts in the deviations, and in the limits that a mode must exceed. The value is the number of roots before. A nonlinear joint, a single hit for each function, a clamping that differed between hits or a filter in the chain leaves such a course; so do delays between channels, and damping that makes modes complex. Average several hits, look at their coherence, and look at what the synthesis misses.";
    /// The model leaves over more than noise around a mode.
    ModelMisfit: "the residual near a mode exceeds the noise so far that the mode is uncertain; its standard deviations were enlarged accordingly",
        "The value is the largest root mean square of the residual over the noise within a half-power bandwidth of such a mode, the limit that above which the model misses the data. The detail begins with the number of these modes out of all. Of each, the worst first: the residual over the response (|R|/|H|), the factor of its standard deviations (σ), that of the frequency over the half-power bandwidth (Δf), of the damping over the damping, and the expected loss of MAC of the shape; of the worst, the FRFs with their residual over noise, and how many of all exceed the limit. A misfit is reported where the residual is more than 4 % of the response, the damping uncertain by more than 10 %, the frequency by more than a twentieth of the bandwidth, or the MAC by more than 0.01. All are lower bounds where the misfit is systematic; damping tends to be too high. Causes: noise correlated between lines, a nonlinear or varying structure, truncated records, a variance that is too small. Look at the named FRFs, measure at one level of force, or leave these FRFs out.";
    /// A root that explains little.
    RootMinor: "a root of the fit explains little of the response and was not taken as a mode",
        "Where the model misses the data by more than noise, roots beside the modes can fit what is no resonance. It may be a local or weakly excited mode all the same. The value is the share of the response in the root's half-power band that nothing else explains. Below three parts in ten thousand no structure is linear enough, whatever the noise.";
    /// A root whose residues have the wrong phase.
    RootPhase: "a root of the fit has residues of another phase than modes have and was not taken as a mode",
        "The residues of a normal mode are imaginary (in receptance), those of complex modes can be turned. Beside a strong mode, residues turned by tens of degrees mostly fit the difference between the measured resonance and that of a linear structure; where damping couples close modes it can be a mode: look before discarding it. The value is the angle against real modes, or against the strong neighbour where that is less.";
    /// A peak without a mode.
    PeakWithoutMode: "a peak is seen here, but the fit keeps no mode",
        "A root was tried and dropped, or none stayed over the model orders. With a value: its significance against the limit that noise reaches; or its deviation in decay rates, its distance to a stronger root in deviations, its half-power width. Look at the peak in single functions; choose a narrower band around it, or another method.";
    /// No pole near one that was chosen.
    SelectionMissed: "the method has no pole within the tolerance of this chosen one; it was left out",
        "The file of `--selection` names poles by frequency and, where stated, damping ratio and model order. The value is the distance of the nearest pole of the method (of that order), the limit the tolerance: `tolerance_hz` of the file, else 1 % of the frequency. Without a value, the pole that is meant was left out by the fit. Poles outside the band are not offered, and one mode is taken at a second order only where the file names that order. Look at the poles of all orders with `--stabilization FILE`.";
    /// No mode in the band.
    NoModeFound: "no mode was found in the band",
        "No peak stands above the noise in the band that was searched. Look at the coherence, at the band, and at whether the hammer excites it.";
    /// Low coherence.
    LowCoherence: "the coherence is low over the band: noise biases H",
        "The value is the median coherence of the worst function over its valid band. Noise on the force makes H1 too small by about that factor, noise on the response H2 too large. Use a force window, hit harder, average more, or use hv.";
    /// The record holds too few time constants of this mode.
    FewTimeConstants: "the record captures few time constants of this mode; its damping and its modal mass may be too high",
        "With n time constants in the record the relative error of H at the resonance is about exp(-n); below 6 it exceeds 0.25 %.";
    /// Damping that the window of a steady excitation raises.
    DampingBiasedHigh: "the resonance is few frequency lines wide: leakage of a random excitation under a Hann or flat top window would bias its damping high by about this much; it was not corrected",
        "Under steady random force the averaged FRF is the true one smoothed by the power spectrum of the window; the wider the window's main lobe beside the resonance, the more damping a fit of poles finds. The value is that bias in percent of the true damping, of a least squares fit of one pole, under the stated window, or where none is stated under a Hann or flat top window, whichever describes the data better (other methods than `ml`: Hann); neighbouring modes and the weights of the lines make up to twice as much of it. There is none where even an undamped mode would look as wide. Where the window is stated (dataset 1858 of universal files), `--method ml` fits the smoothed line shape, which removes the bias. A hammer test, and an excitation that is periodic in the record, have no such bias. None is reported where the data contradict both windows, or where `--window none` is stated. Continuous random force without a window raises damping as well, which these data cannot show. Record longer.";
    /// Poles fitted as a window smooths them.
    WindowLineShape: "The stated window is one for steady excitation. The line shape of poles under it was fitted, so that the damping has no leakage bias.",
        "Under steady random force the averaged H1 is the FRF smoothed by the power spectrum of the window, of which a pole 1/(iω − λ) becomes the transform of e^(λt) times the window's autocorrelation, over records as long as the inverse of the line spacing. Where the excitation was not random but periodic in the record, or the spectra were zero-padded, damping comes out too low: export the FRFs without a window then.";
    /// A stated window that the data contradict.
    WindowContradicted: "The stated window is one for steady excitation. Poles without its line shape fit the data much better. The window was not used.",
        "Under steady random force a window smooths the FRFs, and poles have another line shape. An impact, or an excitation that is periodic in the record, has no such smoothing. Correct `--window`, `window` of `[[test]]`, or dataset 1858 of the universal file.";
    /// Close poles that leakage makes of one mode.
    LeakageSplit: "Close poles were merged: fewer poles under the window named describe the data nearly as well. No window is stated.",
        "The value is the number of poles merged. Under steady random force leakage gives a resonance of few frequency lines a line shape that two poles imitate. Of a Hann and a flat top window the better one is named. The damping remains that of the FRFs as they are, with its bias in `damping-biased-high`. If the test had this window, state it (`--window`, `window` of `[[test]]`, or dataset 1858 of universal files): damping is then corrected. If it was an impact, or an excitation that is periodic in the record, state `none`: nothing is merged then. Two modes closer than 3 frequency lines (flat top: 6) cannot be separated from leakage with these data. Record longer, or zoom.";
    /// Poles that a stiffness by amplitude makes of one mode.
    AmplitudeDependent: "The frequency or the damping of this mode probably depends on its amplitude (nonlinear stiffness or damping). Poles at its frequency with 2 to 5 times its decay rate describe this. They were fitted but not listed as modes.",
        "The FRF of a free decay with amplitude-dependent stiffness or damping has further poles at the frequency of the mode and of its shape. Their decay rates are 2, 3, 4, ... times that of the mode for damping that grows with the amplitude, and 3, 5, 7, ... times for stiffness or damping that change with its square. With these poles in the fit, frequency and damping of the mode are those of small amplitudes; above κ = 0.5 they are approximate. The value κ is the largest residue of such a pole over that of the mode. At the start of the decay the frequency differs by about 2ζκ of it (stiffness), or the damping by κ/(1 − κ) to 2κ/(1 − 2κ) of it (damping). Two close modes that the sensors do not tell apart look alike, with a single FRF always, and so does an absorber without sensors: `--method lscf` lists all poles. Dry friction has no such poles. Repeat the test at several force levels: nonlinear stiffness and damping change κ with the force.";
    /// A pole that another band moves by more than noise.
    BandDependent: "On narrower bands this pole differs by more than noise explains. The standard deviations of its frequency and damping include the difference.",
        "The value is the part of the standard deviation of the damping that comes from the choice of the band, in percent of the damping. The pole was compared with itself on fewer of the lines on which it is fitted: the middle half, quarter and eighth of them, and all on one side with a tenth on the other. The largest difference beyond noise counts. Smaller ones enter the standard deviations without a finding; those of the shape have no such part. Something in the data is not in the model: another mode or a mains line nearby, two modes fitted as one, stiffness or damping that depends on the amplitude, a truncated record, or leakage. Look at the FRFs around the mode. Identify it with bands of several widths (`--band`) and take the scatter of the results as its uncertainty.";
    /// A mode above the valid band.
    AboveValidBand: "the mode lies above the valid band: beyond 0.4 of the sampling rate, where the anti-alias filter falls off and aliases cannot be excluded, or where the force excites little",
        "Analog filters are flat up to about 0.4 of the sampling rate; above it they fall, and what lies above half the sampling rate folds back. The frequency may be an alias, damping and shape may be wrong. Sample faster, or hit with a harder tip.";
    /// A stated band with more than there is.
    BandCut: "the band reaches beyond the data, or to lines without a number, and was cut to them",
        "Value and limit are the edge of the band and the outermost line on that side. Modes beyond the data cannot be found.";
    /// Lines at which no function had a value.
    LineFilled: "up to three lines have no value in any function (0, or no number) and were filled in from their neighbours",
        "The value is their frequency. Beside a resonance of few lines the fill is as wrong as a polynomial is there, which is told as misfit. Look where the lines were lost: a filter, a division by a force that is 0, or an edited file.";
    /// Lines that stood out of their neighbours alone.
    SpikeReplaced: "up to three lines stand out of their neighbours without the skirts of a resonance and were replaced by what these say",
        "The value is their frequency. Mains on a line, or a machine that runs nearby, stand so; a resonance would be seen on the lines around, but for one narrower than 0.04 lines, which calculated functions may have. No variance came with the data, which would have told. Average more, record longer, or leave the lines out of the band.";
    /// A band of a mode that is not measured well.
    NearBandEdge: "the mode lies within its half-power width of the band's edge",
        "Part of its resonance is outside the band, so that the fit leans on one flank.";
    /// Two partners are as good.
    Ambiguous: "two partners are as good as each other; the pairing cannot be decided",
        "MAC and frequency of the best and the second partner differ by less than the stated margin. Measure at more points, or give the pairing.";
    /// A MAC that independent shapes reach.
    BelowChanceLevel: "The MAC of this pair is below the chance level for independent shapes. The pair was marked ambiguous.",
        "The value is the MAC, the limit the level that independent shapes at these sensors reach with any of the roots within the frequency gate in 1 of 100 cases, or in 5 where most other modes of the test reach theirs. Real, smooth shapes correlate more. Only the frequency supports this pair. Measure at more points, check names, directions and signs of the sensors, or correct the model.";
    /// A test shape or a root that another one could hold half of.
    ClaimedTwice: "another root could hold half of this test shape or more, or this root as much of another test shape; only one of them can be right",
        "Each root is judged with those near it in frequency alone, so that roots far from each other can each hold a shape that looks the same at these sensors. The value is the part that the other one would hold. Measure at more points, or narrow the gate on the frequency error.";
    /// A test shape that several roots hold together.
    MixedShape: "the root's part of the test shape, less its standard deviation, is below the stated MAC: shapes are mixed, or these sensors do not tell roots apart",
        "All roots of the model explain the shape together; the value is the root's part less one standard deviation. Stiffnesses that are wrong mix neighbouring modes; with few sensors shapes of different modes look alike. Measure at more points, or update the model and pair again.";
    /// A pair whose MAC reaches its gate with reversed sensors turned alone.
    RestsOnReversal: "Sensors have the opposite sign of the theory, and the MAC as measured is below the gate. The pair was marked ambiguous.",
        "Pairs are chosen with the reversed sensors turned; the MAC in the table is of the shapes as measured. The value is that MAC, the limit the gate (`min_mac`). Correct the signs of the sensors named in the findings, or use --turn-reversed, and the pair is judged by the corrected shapes.";
    /// A pairing with low MAC.
    LowMac: "the best partner by frequency has a low MAC and was not accepted",
        "The gate is stated in the scene (`min_mac`). A low MAC at equal frequency means another mode, a wrong direction or sign of a sensor, or a hit near a node.";
    /// A factor on all stiffnesses that would pair most modes.
    CommonFactor: "few modes pair as the model stands, but by their shapes most would with all its stiffnesses times one factor; nothing was changed",
        "Most test modes are like one root of the model alone, and their frequencies are all about as far off. The value is the factor on all stiffnesses (the square of that on frequencies), with its standard deviation from mode to mode: where that is small, one modulus, unit or scale may be wrong, and masses by one over it would do as well. It is a suggestion. Look at units and thicknesses first, or free the parameter that scales all stiffnesses in [update].";
    /// A function whose sign doubles modes.
    TurnedFunction: "turned, this function (of two references: one of the two of this response) makes single modes of all repeated roots: its sign is likely wrong",
        "The value is their number. The residues of a single mode are of rank one over responses and references; one function of the wrong sign makes them rank two at every mode, so that each is found twice. Look whether the sensor or the hammer was turned in that run, and turn the direction or the calibration.";
    /// Test modes at a repeated root with one shape.
    AlikePartners: "test modes at a repeated root have shapes that are alike; one of its modes may be there twice and another missed",
        "The value is the part that they hold of one direction of the root, cos² of the largest principal angle. Modes of one root can be turned into each other, but they span as many directions as the root has modes. Look whether one pole was taken twice, or measure with another reference.";
    /// Two modes of one set with one shape.
    DuplicateModes: "this mode has nearly the same shape and frequency as another of its set: one mode found twice, or sensors that cannot tell two apart",
        "The value is the MAC of both (autoMAC). A stabilization diagram read twice, two poles fitted to one resonance that moved between runs, or too few sensors give such a pair. Keep the one that explains more of the response, or measure at more points.";
    /// A sensor that points the other way.
    ReversedSensor: "this sensor reads against the theory in the pairs; turned, it raises their mean MAC",
        "Its values disagree in sign with the theory's in most pairs of modes. The value is what the mean MAC gains when it is turned. Look at how the sensor was mounted, or at the sign of its channel; it is left as it is unless --turn-reversed is given.";
    /// A group of sensors that points the other way.
    ReversedGroup: "These sensors have the opposite sign of the theory relative to all others. Reversed together, they raise the mean MAC.",
        "The value is what the mean MAC gains. Only the sign relative to the other sensors is observable: reversing this group is the same as reversing all others, and the smaller side is named. Pairs are chosen with the group reversed; MAC is of the shapes as measured. Look at how the sensors of this direction, component or file were mounted, or at the sign of their channels. Values are left as they are unless --turn-reversed is given.";
    /// Sensors of the opposite sign whose values an update does not use.
    ReversedLeftOut: "Values of sensors with the opposite sign of the model were left out of the update.",
        "With the wrong sign they move stiffnesses away from the test. The number of sensors is the value, the detail names them. All natural frequencies and the other sensors are used. A mode that keeps fewer than two sensors counts by its frequency alone. Only the sign relative to the other sensors is observable. Check the mounting and the sign of the channels, correct the test file, and update again.";
    /// A test shape that the modes of a reduction cannot hold.
    OutsideReduction: "part of this test shape lies outside the modes that the SEREP reduction keeps, and its orthogonality does not see it",
        "SEREP takes a test shape for the nearest sum of the modes that it keeps: as many of the model's lowest as the sensors tell apart. What is left, as a part of the squared length, is the value. Where it is large, the orthogonality looks better than the shape is. Look at the MAC, use --orthogonality guyan, or measure at more points.";
    /// A test's frame that was fitted to the theory's.
    NodesAligned: "the test's points were turned, shifted and scaled onto the theory's",
        "The value is the scale, near 0.001 for millimetres that count as metres. Where several frames fit as well, because points on a line or of a symmetric machine do not tell them apart, it is a warning, and the one that turns least was taken. Look at the distances, and at the MAC.";
    /// Degrees of freedom without a partner.
    DofWithoutPartner: "a degree of freedom of the test has no counterpart in the model and was left out of the comparison",
        "MAC is computed on the degrees of freedom that both have. State the missing ones as [[sensor]] in the scene.";
    /// Few DOFs in a MAC.
    FewDofs: "MAC rests on few degrees of freedom",
        "With few degrees of freedom different modes look alike. The value is their number.";
    /// A synthetic recording.
    Synthetic: "this recording is synthetic: it was computed from a model, nobody measured it",
        "Its truth is known exactly and stands beside it. It shows that the tool works, not that a machine behaves so.";
    /// Letters that the font of PNG figures does not have.
    LettersLacking: "the font of PNG figures lacks letters of this figure, and boxes stand in their place; its SVG has them",
        "The program carries one font, with Latin, Greek, Cyrillic and Hebrew letters; fonts with Chinese, Japanese or Korean ones are too large for it. Use the SVG, which is drawn with the fonts of the machine that shows it, save the figure as PNG from report.html, or name tests and parts in letters of the font.";
    /// A built-in model whose name a file or a folder has.
    BuiltInTaken: "a built-in model and a file, or a folder with a scene, have this name; the built-in model was used",
        "MODEL is a built-in name, a file, or a folder with a scene. A name without a path separator means the built-in model where there is one. Put ./ before the name to use the file or the scene.";
    /// An assumption of a model.
    Assumption: "a value was assumed, not measured or published",
        "The parameter's status in the model says so: printed, inferred or assumed.";
    /// A number beside the roots of a model that is not there.
    QuantityAbsent: "a number beside the roots does not exist at these values of the parameters, or needs values that the model does not allow",
        "The theory of some models gives numbers that need the model elsewhere, such as with a stiffness doubled or at the place of a crossing. Where a bound of a parameter, or its sign, forbids that, or where nothing crosses, the number is left out (—). Move the parameters away from their bounds.";
    /// A parameter that the data cannot know.
    ParameterNotSupported: "the data do not support a value of this parameter by itself",
        "Its posterior deviation is more than half of its prior one. A parameter that the test does not see at all is held where it was; one that the test sees only together with others moves as far as their combination asks, and the combinations say which. The value is posterior over prior deviation. Measure at other points or more modes, or state what is known of it as prior_std.";
    /// A parameter that ended at a bound.
    ParameterAtBound: "this parameter ended at one of its bounds; the data ask for a value beyond",
        "Either the bound is too narrow, or the parameter makes up for something else that is wrong in the model. The value is where it ended. Look at the single changes before widening the bound.";
    /// A model that does not fit after it was updated.
    MisfitRemains: "the updated model does not fit the test within the stated uncertainties",
        "The value is chi-square per degree of freedom, the limit what noise alone reaches. The deviations of the parameters take the model for right but for the stated floors; times the root of the value they say what the remaining misfit leaves of them. Look at the single changes, at what the model leaves out, and at the floors.";
    /// A measured mode without a partner after the update.
    PartnerLost: "this measured mode has no partner in the updated model",
        "It had one in the model as it stood. Its frequency and shape count as wholly unexplained, and the errors of the table leave it out. Look at its shape, at the gates of pairing, and at bounds that keep the model near.";
    /// The updated pairing.
    PairingChanged: "this mode met another mode of the model while it was updated",
        "Modes are followed by their shapes; roots that cross change their order, and test and model are paired anew at every optimum. The value is the number of the model's mode before, the limit that after.";
    /// The update did not converge.
    NotConverged: "the update did not converge within the stated number of iterations",
        "The value is the number of iterations. Raise `max_iterations`, or free fewer parameters.";
    /// A test limit missed.
    LimitMissed: "a stated limit is missed",
        "The limit stands in the scene's [limits] or in the file given to `check --against`.";
}

impl Code {
    /// The code as written in JSON and on the command line.
    pub fn name(self) -> String {
        serde_json::to_value(self)
            .ok()
            .and_then(|v| v.as_str().map(str::to_owned))
            .unwrap_or_default()
    }
}

/// One thing the data says, with the numbers behind it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// How much it matters.
    pub severity: Severity,
    /// What it is about.
    pub code: Code,
    /// Where it belongs.
    pub place: Place,
    /// What was found.
    pub value: Option<f64>,
    /// What it was held against.
    pub limit: Option<f64>,
    /// Unit of value and limit.
    pub unit: Option<String>,
    /// Which parts are concerned, with their figures: got and expected of a damaged part, or the
    /// FRFs of a mode.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub detail: Option<String>,
}

impl Finding {
    /// A finding without numbers.
    pub fn new(severity: Severity, code: Code, place: Place) -> Self {
        Self {
            severity,
            code,
            place,
            value: None,
            limit: None,
            unit: None,
            detail: None,
        }
    }

    /// With the value that was found and its unit (empty or `1` for a plain number).
    pub fn value(mut self, value: f64, unit: &str) -> Self {
        self.value = Some(value);
        self.unit = (!matches!(unit, "" | "1")).then(|| unit.to_owned());
        self
    }

    /// With the limit it was held against.
    pub fn limit(mut self, limit: f64) -> Self {
        self.limit = Some(limit);
        self
    }

    /// With the parts that are concerned and their figures.
    pub fn detail(mut self, detail: impl Into<String>) -> Self {
        self.detail = Some(detail.into());
        self
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.place, self.code.sentence())?;
        let unit = self
            .unit
            .as_deref()
            .map_or_else(String::new, |u| format!(" {u}"));
        match (self.value, self.limit) {
            (Some(value), Some(spread)) if self.code == Code::CommonFactor => {
                write!(f, " ({})", with_spread(value, spread))?;
            }
            (Some(value), Some(limit)) => {
                write!(f, " ({}{unit}, limit {}{unit})", short(value), short(limit))?;
            }
            (Some(value), None) => write!(f, " ({}{unit})", short(value))?,
            (None, Some(limit)) => write!(f, " (limit {}{unit})", short(limit))?,
            (None, None) => {}
        }
        let detail = self.detail.as_deref();
        detail.map_or(Ok(()), |detail| write!(f, "; {detail}"))
    }
}

#[cfg(test)]
mod tests;
