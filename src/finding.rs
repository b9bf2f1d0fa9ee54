//! A finding reports an observation on data or results that is no error: code, location, value and
//! limit.
//!
//! A finding never stops the processing. Its sentence is composed here, so that all reports have
//! the same wording.

mod chinese;
mod limit_kind;
mod location;
mod numbers;
mod severity;

use std::fmt;

use serde::{Deserialize, Serialize};

pub(crate) use chinese::pattern_values;
pub use limit_kind::LimitKind;
pub use location::Location;
use numbers::format_with_std;
pub(crate) use numbers::{format_hz, format_number};
pub use severity::Severity;

/// Declares the codes with the kind of their limit, where they have one, their sentence and their
/// longer explanation in one table.
macro_rules! codes {
    ($($(#[$doc:meta])* $name:ident $([$limit:ident])?: $sentence:literal, $explanation:literal;)*) => {
        /// Subject of a finding.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
        #[serde(rename_all = "kebab-case")]
        pub enum Code { $($(#[$doc])* $name,)* }

        impl Code {
            /// Every code, in the order of its declaration.
            pub const ALL: &[Code] = &[$(Code::$name,)*];

            /// The sentence without location, value and limit.
            pub fn sentence(self) -> &'static str {
                match self { $(Code::$name => $sentence,)* }
            }

            /// Cause, consequence and remedy.
            pub fn explanation(self) -> &'static str {
                match self { $(Code::$name => $explanation,)* }
            }

            /// What the limit of its findings asks of their value.
            pub fn limit_kind(self) -> Option<LimitKind> {
                match self {
                    $($(Code::$name => Some(LimitKind::$limit),)?)*
                    _ => None,
                }
            }
        }
    };
}

codes! {
    /// Records carry no usable version number, load case or identification.
    GroupedByOrder: "Records were grouped into hits by order, length and sampling, because their headers do not name the hit.",
        "A universal file names the hit of a record by version number, load case and ID lines. Where these are empty or differ from record to record, the order in the file decides: a second force record, or a response that is already there, opens the next hit. Check the number of hits in the output.";
    /// The excitation point comes from the responses or the scene, not from the force record.
    HitPointAssumed: "The force record does not name the excitation point. The common reference of the responses was used, or the one stated in the scene.",
        "The response DOF of the force record is the excitation point. Where it is empty, the common reference of the responses is used, then the reference that the scene states.";
    /// A dataset number that is not supported.
    UnknownDataset: "A dataset of this number is not read and was skipped.",
        "Universal files hold many dataset numbers. One that modalign does not read is skipped. The value is its number.";
    /// A part of a file could not be read.
    BadDataset: "A dataset is damaged and was left out. The good part of the file was read.",
        "The place in the file is given, with what stands there (got) and what should (expected). `inspect` and `convert` deliver the good part and exit 1. Other verbs stop with exit 2 where their answer needs the damaged part, unless --partial is given; else they go on and exit 1. Modes and FRFs need neither geometry nor trace lines, titles, coherence or spectra.";
    /// Functions of one set that state different windows or none.
    WindowNotCommon [Total]: "Only some FRFs have a stated window, or the stated windows differ. None was used.",
        "Dataset 1858 states the window of a function. Where all functions of a set state one, poles are fitted with the line shape that it gives to leakage. Here it was not used for any, so that damping may be too high where the force was steady random noise. The value is the number of functions that state a window, the limit the number of functions. State it for the others with `--window` or `window` of `[[test]]`, or identify the FRFs of each window separately.";
    /// An exponential window of unstated decay rate.
    WindowDecayUnknown: "Records had an exponential window whose decay rate is not stated. The damping that it adds was not removed.",
        "An exponential window adds its decay rate σ to that of every mode: damping ratios are too high by σ/(2πf), most at low frequencies. Dataset 1858 of universal files states the window without a rate in a stated unit. A window that falls to 1 % in T seconds has σ = 4.6/T. Subtract σ/(2πf) from the damping ratio of each mode. Or make the FRFs from the recorded hits with `modalign frf --response-window`, which removes the damping that it adds.";
    /// A function with a value that is NaN or infinite.
    ValueNotFinite: "A function has a value or a variance in the band that is no finite number. It was left out.",
        "The value is the frequency of the first such line. Without --partial the command stops there. A mode that only this response or this excitation point shows is missed. Without the driving point modes have no modal mass. Export the function anew.";
    /// The binary byte count is wrong.
    ByteCountWrong [Expected]: "The byte count of a binary dataset does not agree with its number of points. The number of points was used.",
        "Dataset 58b states the length of its binary block. Some writers state zero, half of it or another number. The value is the count as stated, the limit the count that the number of points needs.";
    /// The stated byte order is wrong.
    ByteOrderWrong: "The values of binary datasets make sense only in the byte order opposite to the stated one. The opposite order was used.",
        "Dataset 58b states whether its bytes are little or big endian. Some writers state the wrong one. In the stated order the values are scattered over the whole range of the number format or too small for a measurement; in the opposite order they are ordinary and change gradually. Datasets of the file whose values decide nothing, such as zeros, are read alike. The value is the number of functions. Check their amplitudes, and state the right order in the file.";
    /// The number of points is wrong.
    PointCountWrong [Expected]: "The number of points of a binary dataset does not agree with its length. The length was used.",
        "Dataset 58b states a number of points and a byte count. Where the closing delimiter stands behind the stated bytes and not behind the stated points, all bytes are read as values. The value is the stated number of points, the limit the number that the bytes hold.";
    /// The closing delimiter is missing.
    NotClosed: "The delimiter behind the numbers of a dataset is missing. Its numbers are complete.",
        "A dataset of a universal file ends with a line `-1`. The file may end without it, or the next dataset may begin. The dataset then counts as whole if it has as many numbers as its header states and its last line is complete.";
    /// A header text is not UTF-8.
    HeaderNotUtf8: "A header text is not valid UTF-8. The offending bytes were replaced.",
        "Old systems write units such as m/s² in Latin-1. Numbers are not affected.";
    /// A trace line of another length than stated.
    TraceLineCount [Expected]: "A trace line has another number of entries than its header states. Entries beyond the stated number were not read.",
        "Dataset 82 draws a line through nodes. No result depends on it. The value is the number of entries, the limit the number that the header states; zeros that fill up lines are not counted.";
    /// A file with FRFs and recorded hits.
    FunctionsPassedOver: "The file holds FRFs and recorded hits. The FRFs were estimated anew from the hits.",
        "A test is made from its recorded hits where there are any. To use the FRFs of the file instead, give a file that holds only FRFs.";
    /// A file with time records and FRFs.
    RecordsPassedOver: "The file holds FRFs and time records. The FRFs were used, the records were not.",
        "Modes are identified from FRFs. `run` estimates them anew where the records of the file make hits, each with a force record; `identify` uses those of the file. The value is the number of records.";
    /// Averaged FRFs beside the records of one hit.
    LastHitPassedOver: "The file holds averaged FRFs and the time records of the last hit. The FRFs are used, the records are not.",
        "SignalCalc keeps the time records of the last hit only. An FRF of one hit has more noise than the average of all hits, and no coherence. To use the records, describe their columns in `[[test.channel]]`. The value is the number of records.";
    /// Files with the same channels and no points.
    ChannelsRepeated: "FRFs of several files have the same channels, and no points are stated. They are taken as repeated measurements of one FRF.",
        "The files name channels, not points. In a roving test every file has other points: without them the shapes mix the points. State the points of each file in `[[test.file]]` as `reference` or `response`, or in `modalign new` as `--reference DOF,DOF,...`. The value is the number of files.";
    /// A record or function of a quantity that is not needed.
    FunctionLeftOut: "A record or function is not used for FRFs or modes and was left out.",
        "FRFs and modes need a force and motions along an axis: displacement, velocity or acceleration. Sound pressure, voltage, rotations and the like are left out unless a scene states their `unit` in [[test.channel]]: Pa/N of FRFs, Pa of records; so are functions over another abscissa than frequency. With --partial a function whose unit, point or values are not stated is left out too, and the exit code is 1. The detail says why.";
    /// A hammer that did not hit.
    IdleForce: "The force of this point records no hit beside that of another one. It was left out.",
        "With several hammers at a structure, one hits and the channels of the others record noise and cross-talk of cables. A force whose peak is at most 5 % of the largest of the same hit is idle.";
    /// A channel that starts later than the force.
    ChannelDelayCorrected: "This channel starts later than the force. The phase of its FRFs was corrected.",
        "Modules of a recorder with separate clocks start some microseconds or samples apart, as the headers state. The response is turned by exp(-iωt) with the time t between the first samples. The value is this time; it is negative for a channel that starts earlier.";
    /// Continuous records cut without being asked for.
    CutByTrigger: "Each record holds several hits and was cut into them.",
        "Every force record of the test has several pulses at some distance from each other, so that it is a continuous record. Without the cut, responses to all hits would be divided by one force. `--hits records` or `hits = \"records\"` in [[test]] keeps the records whole; --trigger-level, --pretrigger and --hit-length with `--hits trigger` decide how they are cut.";
    /// Blocks that are short for the resonances.
    BlockLeakage [AtMost]: "The blocks are short for the resonances: leakage lowers the peaks of the FRFs.",
        "Steady random excitation is averaged in blocks with Hann windows. At a resonance that decays for longer than a block, the response of one block comes from the force of the one before, and the peak is too low. The value is the bias of the peak, computed from its change by blocks of half the length. Identification corrects poles by the line shape of the stated window; FRFs, coherence and residues at the peaks remain too low. Use longer blocks (--block-length, `block_length_s` in [frf]), longer records, or burst random.";
    /// A sensor that does not move with the rigid body.
    SensorNotRigid [AtMost]: "This sensor or hit does not move with its rigid body.",
        "Between the modes of a soft suspension and the first elastic mode a structure moves as a rigid body, so that six accelerations, three of translation and three of rotation, determine what every sensor reads. A body of a machine does so in the modes below its first one; the detail then names the body of the model and the modes. The detail says what would make this one fit: its sign, axis, gain, or the place of another sensor. Its position may be wrong as well. The value is the fall of the sum of squares of what does not fit, the limit the least fall that is reported. Check cable, sensitivity, direction and position; of two exchanged sensors, whether their cables or names are exchanged.";
    /// Sensors that do not move as one rigid body, for no single sensor.
    SensorsNotRigid [AtMost]: "The sensors do not move as one rigid body, and no single sensor explains it. No mass was computed.",
        "Between the modes of a soft suspension and the first elastic mode a structure moves as a rigid body, so that six accelerations, three of translation and three of rotation, determine what every sensor reads. Here the sensors contradict each other, and neither the sign, axis or gain of one sensor nor an exchange of two removes the contradiction: several are wrong, or the structure is not rigid in this band. The value is the sum of squares of what does not fit over its degrees of freedom; noise and errors of half a percent give 1. Check signs, axes and sensitivities of all sensors and their positions.";
    /// The mass from the mass line.
    MassOfMassLine: "The FRFs between the suspension's modes and the first elastic one give a mass.",
        "A rigid body has ten inertia parameters; hits at several points and the positions of sensors and hits determine them (Okubo and Furusawa 1986; Almeida, Urgueira and Maia 2007). Compare it with a weighed mass (`mass_kg` of [test.state]). A mass from data with one repaired sensor says so in the detail; the FRFs are unchanged. The value is the mass.";
    /// A stated mass that differs from that of the mass line.
    MassDiffers [Within]: "The mass of the mass line differs from the stated mass.",
        "Between the rigid-body modes on the suspension and the first elastic mode an accelerance is that of a rigid body, whose level is one over its mass. If the stated mass is right, all FRFs are wrong by the factor of the detail, and the modal masses by its inverse; frequencies and damping stay. The value is the difference over the stated mass, the limit 1.96 deviations of the mass line and of a calibration of 2 %. Check `mass_kg` of [test.state] and attached parts, sensitivities and units, the tip mass of the hammer, and the suspension.";
    /// FRFs with both halves of the transform.
    TwoSided: "The FRFs are two-sided: their upper half is the mirror image of the lower. It was left out.",
        "The transform of a real record repeats its lower half, mirrored and conjugate, above half the sampling rate. Modes that are found there are images of those below. The value is half the sampling rate.";
    /// FRFs of the other sign of time.
    ConjugateTurned [Total]: "FRFs are conjugate: their impulse response comes before the hit. They were turned.",
        "With the convention e^{+iωt} the impulse response of a structure is 0 before the hit. Some programs write the conjugate FRF; all damping values would be negative. The value is the number of functions that were turned, the limit that of all.";
    /// FRFs over unevenly spaced lines.
    LinesInterpolated: "The lines of the FRFs are not evenly spaced. They were interpolated onto even ones.",
        "A stepped sine has close lines at resonances and wide ones between them. FRFs are identified on even lines as close as the closest of the file. The variance of an even line is that of a measured one times the even lines per measured one, so that standard deviations of modes are those of the measured lines, or somewhat larger. Without a stated variance it is estimated from neighbouring lines. The value is the spacing of the even lines.";
    /// A sensor whose functions are far larger than all others.
    SensorScale [AtMost]: "All FRFs of this sensor are far larger than those of any other. Its unit or sensitivity may be wrong.",
        "A factor of a thousand is the usual sign of mV for V, mm for m or a sensitivity in the wrong unit. The shape is then this sensor alone, and MAC says nothing. The value is the ratio to the next largest sensor, the limit what is reported. Check the calibration of the channel and state its unit or scale.";
    /// A stated unit that is not that of the file.
    UnitContradictsFile: "The stated unit contradicts the header of the file. The stated unit was used.",
        "A unit in [[test.channel]] precedes the header, since some programs write a fixed code for every function. The detail has both. If the header is right, remove the stated unit.";
    /// Coherence outside 0 to 1.
    CoherenceInvalid: "Coherence outside 0 to 1 was ignored. The FRF was kept.",
        "Coherence lies between 0 and 1. Some analysers write other values, mostly at 0 Hz. At these lines the coherence of the nearest valid lines was used for the variance. Where most lines are invalid, coherence was not used at all, and the noise is estimated from the fit residual. The value is the largest of the ignored values.";
    /// Data that the output format cannot hold.
    NotCarried: "The output format cannot hold this. It was left out.",
        "`convert` writes what the output format can hold. The place names the lost part, the value is the number of lost entries. HDF5, .mat and .npz hold everything but arrays of unspecified meaning.";
    /// A hit with missing records.
    HitLeftOut [Expected]: "This hit has another number of records than most hits and was rejected.",
        "With --partial the whole hits of a partly damaged file are used. A hit can lack records because the file ends inside it or a record is damaged. It could pair a response with the force of another hit. The value is the number of its records, the limit that of a whole hit.";
    /// Directions in local coordinate systems.
    LocalDirections: "Directions at nodes with a local coordinate system are local. They are compared by name as if they were global.",
        "Nodes of universal files may have a displacement coordinate system (datasets 18, 2420). Sensors and hits of records and FRFs are named in it. The modes identified from them keep these local directions; shapes from a model or from dataset 55 are global. Turn the sensors' directions with --dof-map, or state sensors with their direction in a scene. The value is the number of degrees of freedom.";
    /// The number of averages is not in the file.
    AveragesAssumed: "The number of averages is not stated. The variance of the FRFs assumes this number.",
        "The variance of an FRF follows from its coherence and the number of averages. Where the file does not state how many hits were averaged, the value is assumed. Standard deviations are proportional to one over the square root of (averages - 1). State the number with `averages` in [[test]] or --averages.";
    /// Samples that are not evenly spaced.
    UnevenAxis: "The abscissa is uneven. A time record is only converted, an FRF is interpolated onto even lines.",
        "FRF estimation and identification need evenly spaced samples or lines. Samples at uneven times can be listed and converted; FRFs at uneven frequencies, as of a stepped sine, are interpolated. An abscissa written value by value counts as even when the rounding of the values explains every difference.";
    /// An abscissa of unknown unit.
    AxisUnitUnknown: "The unit of the abscissa is not known. Its values are kept unchanged and are taken neither as seconds nor as hertz.",
        "The header says time or frequency in a unit that modalign does not know. Such a function can be listed and converted, with the unit's text, but not used for FRFs or identification. Change the unit in the file to s or Hz, with the values.";
    /// Directions that were never measured.
    UnmeasuredLeftOut: "Values that are 0 in every mode mark directions that were not measured. They were left out.",
        "Measurement systems fill the directions of a node that were not measured with zeros. A comparison leaves out the DOFs that are exactly 0 in every mode of the test and not in the model, because these zeros lower MAC. Noise leaves no measured value at exactly 0 in several modes. In a test of one mode, 0 may be a node of the mode: only an axis that is 0 at all points is left out. Zeros of modes that modalign computed are values. The value is the number of DOFs, the detail names the first. Where the test is itself a model with clamped DOFs, MAC is too high: take them out of both. A universal file whose ID lines or title name Test.Lab, LMS or Simcenter, or with a note of modalign on zeros, loses them at reading; the place is then its first mode.";
    /// Degrees of freedom at which the theory does not move.
    ZeroInModel: "The model is 0 in every mode at DOFs where the test is not. They were kept and lower MAC.",
        "A clamped DOF of a model is 0, and so is a direction that a plane model does not have: the comparison must see that the test moves there. But a measured file that is given as --theory may have zeros in directions that were not measured. Give that file as --test, or take these DOFs out of it. The value is the number of DOFs, the detail names the first.";
    /// Eigenvalues whose real part is the decay rate.
    DecayRateSign: "Eigenvalues have a positive real part, which was read as the decay rate: its sign was reversed.",
        "The real part of the eigenvalue of a stable mode is negative. Some programs write the decay rate, its amount, in its place. It is taken as such where all complex modes of a file have a positive real part, because a structure is not unstable in every mode, and where a positive damping ratio is written beside the eigenvalue. A negative damping ratio beside it says that the mode is unstable. The place is the first of the modes, the value their number. Check the damping ratios.";
    /// Modes with negative damping.
    NegativeDamping: "Modes have negative damping: they are unstable, or the sign is an error. They were read as written.",
        "The real part of the eigenvalue is positive, or the damping ratio negative, while other modes of the file are stable or the damping ratio confirms the sign. Such modes grow in time: chatter, flutter, a control loop. Modes identified from FRFs of a stable structure cannot. The place is the first of the modes, the value their number. Check the sign in the program that wrote the file.";
    /// Damping ratios in percent.
    DampingInPercent: "Damping ratios of 1 and more show that the file states damping in percent. All were divided by 100.",
        "Datasets 55 and 2414 of universal files, `modes.csv` and `modes.json` state the damping ratio as a fraction. A mode with a ratio of 1 or more does not vibrate, so that a file with such a ratio, and without one below 0.05, states percent. The value is the largest ratio as written, the place the first of the modes. Check the damping ratios, and let the program write fractions.";
    /// Damping ratios that are no fractions of a structure and may be percent.
    DampingImplausible: "The damping ratios of the file are implausible as fractions and may be percent. They were read as written.",
        "A file with a damping ratio of 1 or more is read as percent only where no other is below 0.05 and none is 100 or more. Where every ratio is above 0.2 and none reaches 1, either reading is possible. The value is the largest ratio as written, the place the first of the modes. Where the file states percent, divide its damping ratios by 100.";
    /// A modal scale without a unit.
    ModalScaleUnknown: "Modal mass, modal A and modal B are of unknown unit and were left out.",
        "Modal mass, A and B belong to the scale of the shape. They have a unit only where dataset 164 states the units of the file and the shape is a displacement; to which of its quantities the scale of a velocity or acceleration shape belongs differs from writer to writer. The shape itself stays, in an arbitrary scale. The value is the number of modes.";
    /// Shapes were transformed from local coordinate systems.
    LocalSystemApplied: "Shape values in local coordinate systems were transformed into the global frame.",
        "Nodes of universal files may have a displacement coordinate system (datasets 18, 2420). Shapes are compared in the global frame, so the values at those nodes were transformed. The value is the number of nodes.";
    /// A coordinate system that is named but not described.
    UnknownSystem: "The file does not describe the coordinate system of a node. The values at the node were taken as global.",
        "A node names the coordinate system of its position or displacements by number. Datasets 18 and 2420 describe them. The value is a number without a description.";
    /// Directions of shape values that are lost with damaged parts.
    DirectionsLost: "Nodes or coordinate systems of this file are damaged, and with them the directions of shape values. The values were taken as global.",
        "A node names the coordinate system of its displacements, and another dataset describes it. Where the nodes are damaged and the file describes a system that is not aligned with the global axes, or both are damaged, values in local directions cannot be distinguished from global ones, and MAC is wrong where they are local. The value is the number of nodes of the shapes without a readable description. Only --partial uses such shapes. Repair the file.";
    /// Analysis results that are no modes.
    NotModes: "Data at nodes or elements that are no mode shapes were skipped.",
        "Universal datasets 55 and 2414 hold results of many analyses. Shapes of normal modes and of complex eigenvalues are read, anything else is skipped. The value is the number of the analysis: 1 static, 2 normal mode (of another quantity than motion), 4 transient, 5 frequency response, 6 buckling.";
    /// A part of a file that is described but not read.
    ArrayNotRead: "An array of this kind is listed but cannot be read.",
        "Containers hold more kinds of data than numbers: objects, functions, sparse arrays, references. They are listed by `inspect`, so that nothing is silently left out; the place names the array.";
    /// A link of a container that leads to no array of the file.
    LinkNotFollowed: "A link in the file leads to no array or group of it and was passed over.",
        "An HDF5 file can name an object by its path (soft link) or by another file and a path in it (external link). The object may be missing, the links may lead in a circle, or it lies in the other file, which is not opened. The detail says where the link leads. All other arrays are read. Copy the array into the file, or give the file that holds it.";
    /// Degrees of freedom matched by position.
    DofsByNode [AtMost]: "Test and model DOFs were matched by nearest node; the largest distance is given.",
        "With --nearest-node the names are not used. A sensor of the test is matched to the model DOF of the same axis at the nearest node within the tolerance. Both geometries must be in one frame and in the same unit, or --align fits them. Sensors beyond the tolerance have no partner: this is then a warning, with their distances. Check the largest distance.";
    /// Sensors that read one node.
    NodeShared: "Several sensors at different positions were matched to one node of the model.",
        "With --nearest-node each sensor reads the node nearest to it. Sensors that share a node read the same motion of the model, although they do not move alike in the test: the MAC becomes smaller. The value is the number of these sensors, the detail names the first. State a smaller tolerance, so that the farther sensor is left out, or refine the mesh of the model there.";
    /// Motions without mass.
    MasslessCondensed: "Some coordinates have no mass. They were condensed statically, which keeps every mode with a finite frequency exactly.",
        "Rotations of lumped-mass models and some nodes have no mass. Static equilibrium determines their motion, so the model has fewer modes than coordinates. Frequencies, shapes at all coordinates, energies and sensitivities are those of the whole model. The value is the number of independent motions without mass.";
    /// Only the lowest modes of a large model were computed.
    LowestModesAlone: "The model is sparse. Only its lowest modes were computed; none is missing up to this frequency.",
        "For a model of many coordinates, block Lanczos on the shifted and inverted matrices computes the modes up to the end of the band, or as many as are requested (default 30). The inertia of the shifted stiffness counts the eigenvalues below the value. The modes are as many, repeated roots included. Request a band to see more.";
    /// Natural frequencies that the stiffness matrix does not determine.
    StiffnessRounding [AtMost]: "Rounding of the stiffness matrix alone may change a natural frequency by this part of it.",
        "The entries of a stiffness matrix are rounded to 16 digits. In a finely divided, slender or softly suspended structure the lowest modes are small differences of large entries, so that this rounding moves them: by up to eps |phi|^T |K| |phi| / omega^2 in omega^2. The value is the largest such part, and the finding is at the mode with it; further modes above the limit are listed. Use fewer or higher-order elements.";
    /// The sampling rate was computed from a rounded spacing.
    SpacingRounded: "The sampling rate was computed from a rounded Δt.",
        "Universal files print the spacing with six digits. Where exactly one whole number of samples per second lies within the rounding, that rate is taken.";
    /// One average gives no coherence.
    CoherenceAbsent: "There is only one average, so coherence is absent.",
        "With a single hit the coherence is identically one and carries no information. The variance comes from the pre-trigger noise alone. Record three hits or more at each point.";
    /// The record ends before the response has decayed.
    Truncated [AtMost]: "Truncation of the record changes H near resonance by up to this fraction.",
        "The value comes from the slowest fall of the response energy between quarters of the record. `not-decayed` and `response_window = \"auto\"` have another criterion: the amplitude in the last eighth of the record over the largest one. A weak mode of little damping can miss this limit and meet that one. A record that captures n time constants of the slowest mode makes H wrong by about exp(-n) of its peak: 2.5e-3 at 6, 7.5e-5 at 9.5. Record longer, or use an exponential window: `--response-window 0.01`, or `response_window_end` in [frf] of a scene, is its value at the end of the record.";
    /// The decay cannot be measured because noise fills the tail.
    TruncationNotDecidable: "The decay is not assessable at this noise, so the truncation error is unknown.",
        "The bound comes from the decay of the response energy over the last quarters of the record. There the response has decayed into the noise. The noise, not the truncation, then limits H.";
    /// The hammer touched twice.
    DoubleHit [AtMost]: "The force has a second pulse, as from a second contact of the hammer.",
        "A second contact makes the force spectrum a comb. The ratio of its peak to the first peak is the depth of the dips, their spacing is one over the delay. The hit is rejected when the dips are deep; `--accept` uses it all the same.";
    /// Clipped samples of a channel.
    Overload [Below]: "A channel was overloaded (clipped).",
        "Three or more samples lie at the largest value that the converter holds. A clipped force is too small at every frequency, a clipped response puts harmonics into the spectrum. A clipped response is left out of its FRF; a clipped force rejects the hit. Lower the gain and hit again.";
    /// A hit much weaker or stronger than the others.
    HitLevel [Factor]: "This hit is much weaker or stronger than the others at its point.",
        "The value is its peak over the median peak of the hits at the point. A weak hit has a lower signal-to-noise ratio, a strong one may excite nonlinear behaviour. Repeat the hit at the usual level.";
    /// Something rings before the hit.
    PreTriggerNotQuiet [AtMost]: "The channel is not quiet before the hit.",
        "The structure still vibrates from the previous hit, or something else excites it. This vibration adds to the response to the hit. Wait longer between hits.";
    /// The response has not decayed.
    NotDecayed [AtMost]: "The response has not decayed when the record ends: its amplitude there, over the largest one, is above the limit.",
        "The amplitude is that of the last eighth of the record, the noise subtracted. `response_window = \"auto\"` has the same criterion, `truncated` the error of H near resonance. The record is too short: truncation, or leakage of the spectrum, biases the FRF. Record longer or use an exponential window.";
    /// The force spectrum falls inside the band.
    ForceRollOff [AtMost]: "The force spectrum falls by 20 dB inside the band of the analyser.",
        "Above that frequency the hammer excites little and noise dominates. The usable band ends there. A harder tip or a lighter hammer extends it.";
    /// A channel without signal.
    DeadChannel [AtLeast]: "A channel holds no signal.",
        "It is constant, or does not rise above its noise when the hammer hits. Check the cable, the range and the sensor.";
    /// The pulse is negative.
    NegativeForce [AtLeast]: "The pulse of the force is negative.",
        "Hammers are calibrated so that a push is positive. A negative pulse changes the phase of every FRF by 180 degrees, unless the direction of the excitation point accounts for it. Check the polarity of the force channel.";
    /// Offset or drift.
    ChannelDrift [AtMost]: "A channel has an offset or drifts.",
        "The value is in parts of the peak. The mean before the hit is subtracted from each channel. A drift is not, and disturbs the lowest lines.";
    /// A hit whose FRF is inconsistent with the others at its point.
    #[serde(rename = "odd-one-out")]
    InconsistentHit [AtMost]: "The FRF of this hit is inconsistent with the other hits at this point.",
        "The deviation from the average of the other hits is far beyond their scatter. Another point or direction was hit, or a sensor was disturbed. The hit is rejected; `--accept` uses it all the same.";
    /// The force level that starts a hit.
    TriggerLevel: "Hits were cut from a continuous recording where the force exceeds its baseline by this much.",
        "Without a stated level it is 5 % of the largest pulse, or a level that noise alone does not reach. Weaker hits are not detected: state `level_n` in [test.trigger] (--trigger-level).";
    /// The length of the records that were cut.
    HitLength: "The records of all hits that were cut have this length.",
        "Without a stated length it is the smallest distance between two hits. One late bounce that counts as a hit therefore shortens all records: state `length_s` in [test.trigger] (--hit-length).";
    /// A hit at the edge of a continuous recording.
    HitCutOff: "Hits at the start or end of a continuous recording were rejected, because their record is not whole.",
        "All hits of a test have records of one length. State a shorter `length_s` (--hit-length) or `pretrigger_s` (--pretrigger) to keep them.";
    /// All records of an FRF are overloaded or empty.
    NoRecordPassed: "All records of this FRF are overloaded or empty; they were used because no others exist.",
        "An FRF of such records is unreliable. Check the range, the cable and the sensor, and measure it again.";
    /// No hit at a point passes the checks.
    NoHitPassed: "No hit at this point passes the checks; they were used because no others exist.",
        "Each hit has a finding with its fault. The FRFs of this point are no better than these hits: measure the point again.";
    /// An exponential window was needed.
    WindowAdded [AtMost]: "An exponential window was applied to force and responses, because the response had not decayed to 1 % of its largest amplitude.",
        "One window serves all hits of the test. The FRFs carry its decay rate, which is subtracted from every pole. The records begin at their pulse, so that their truncation changes no pole. `--response-window none` applies no window; a longer record needs none.";
    /// The force window is too short.
    ForceWindowCuts [AtMost]: "The force window cuts off part of the pulse or of the ringing of the anti-alias filter after it.",
        "The signal after the pulse is more than noise. An anti-alias filter rings for some tens of samples, equally in force and response. Cutting the ringing off the force alone makes H wrong, most near the filter's edge. The value is the rms of the part that was cut off, beyond the noise, over the rms of the force. Lengthen the window.";
    /// The noise ratio of Hv was estimated from the channels.
    NoiseRatioFromRecord: "Hv is scaled by the noise variances before the hit.",
        "Hv weights the noise of force and response. Without a stated ratio the variances of both channels before the pulse are used, averaged over hits. The value is response over force in SI units.";
    /// Usable band ends.
    BandLimited: "The band was limited to where the force excites and the anti-alias filter is open.",
        "Lines above 0.4 of the sampling rate, or where the force spectrum is more than 20 dB below its maximum, are not used for identification. The value is the upper edge.";
    /// The power into a driving point is negative.
    DrivingPointSign [AtMost]: "The real part of the mobility at a driving point is negative at resonances, which no passive structure allows.",
        "At a driving point power flows into the structure at every frequency: the real part of the mobility is not negative. The value is the fraction of energy with the wrong sign between the half-power points, the limit half of one resonance. Near 1 the sign of a channel is wrong, or the direction of the hit or the sensor. In between it is another point than the label states (some modes have the other sign there), or the response is late: see channel-delay.";
    /// Two reciprocal functions differ.
    NotReciprocal [AtMost]: "This FRF and its reciprocal differ by more than noise and calibration explain.",
        "Response at i to a hit at j equals response at j to a hit at i while the structure is linear. The value is the rms difference over the rms of both, noise subtracted: 0.1 is 10 %, 2 is a wrong sign. Check the sensitivities, the points and axes of hits and sensors, sensors that load the structure, and loose parts.";
    /// Two measurements of one pair differ.
    RepeatsDiffer [AtMost]: "This FRF differs from the first measurement of the same pair by more than noise explains.",
        "The pair is in the set more than once (#2, or the sensor turned round). The value is the rms difference over the rms of both, noise subtracted; 2 is a wrong sign. The structure, the excitation point or a sensitivity changed between the two, or one of them was measured at another point.";
    /// A constant delay between force and response.
    ChannelDelay [Within]: "The response has a constant delay to the force.",
        "The phases of the residues fall in proportion to frequency, as a delay makes them. A positive value is a late response. The limit is a quarter of the sampling interval, or the delay that scattered phases explain. The whole test is named when every response is equally late (or early), which points to the force channel: unsynchronised or multiplexed converters, another anti-alias filter on one channel, a trigger offset. Frequencies and damping remain valid. Signs and phases of shapes, residues and driving points do not.";
    /// Natural frequencies that shift with the position of the sensor.
    MassLoading [Within]: "Natural frequencies shift with sensor position in proportion to its motion: the sensor mass loads the structure.",
        "The value is the distance of the frequency of this run from the mean of all runs. The limit is the scatter that noise explains, or 0.15 of the half-power bandwidth where that is more. A sensor of mass m lowers the natural frequency, relatively, by half of m times the square of its mass-normalised component there. Poles and shapes from all runs together are a mixture. Use a lighter sensor, rove the hammer, or put dummy masses at the other positions.";
    /// Natural frequencies that shift from run to run.
    RunsDisagree [Within]: "A resonance has another frequency in this run than in the others.",
        "The value is the distance of the frequency of this run from the mean of all runs. The limit is the scatter that noise explains; where FRFs are checked, at least 0.15 of the half-power bandwidth. The structure changed between runs (temperature, boundary, a joint, level of the hits) or a sensor was moved. Identify the runs one by one, or measure this one again.";
    /// A mode whose frequency or damping changes with the force of the hit.
    ForceLevelDependent: "Frequency or damping changes with the force of the hit: stiffness or damping is nonlinear, as in joints and gaps, or the structure changed in the order of the hits.",
        "At points where the peak forces of three hits or more differ by 3 dB or more, isolated resonances are fitted to each hit alone, at four responses or fewer. The value is the change of the natural frequency from the weakest to the strongest hit; behind it stand the changes of frequency and damping with their standard deviations. Noise alone gives such a finding in one of 1,000 measurements; changes below 0.02 half-power bandwidths (frequency) or 3 % (damping) per doubling of the force (6 dB) are not reported. About six hits over 6 dB are needed for a finding: with fewer, no finding does not mean linear. An average over such hits belongs to no single force level. Repeat a weak hit at the end to exclude a drift, hit with the same force (within 1 dB), or test at several levels. `amplitude-dependent` is found from the decay within the records.";
    /// Runs of different frequencies were merged into one mode.
    RunsMerged: "The natural frequency differs between runs. The mean over the runs is stated, with the standard deviation of that mean.",
        "One frequency for all runs does not describe the FRFs. One frequency per run does. A run is the FRFs of one point of a roving sensor or, where there are no more responses than references, of one excitation point; or a single FRF. The value in parentheses is the standard deviation between runs: the uncertainty of the frequency in one state of the structure. The standard deviation in tables is that of the mean, smaller by about the square root of the number of runs. The mass of a sensor lowers every run: the structure without it has higher frequencies. Where the mass of a sensor of one axis explains the shifts, residues and shapes are corrected to those without it. Two local modes closer than their half-power bandwidth look the same where no sensor was moved: compare runs.";
    /// A frequency whose values of single runs scatter.
    RunsScatter: "Run by run, the natural frequency scatters by more than noise explains. The mean over the runs is stated, with the standard deviation of that mean.",
        "The FRFs were fitted with one frequency, which one linear step then corrects for each run: the FRFs of one point of a roving sensor or hammer. The value is the standard deviation between runs: the uncertainty of the frequency in one state of the structure. The structure changed a little between runs, the sensor loads it, or a second mode lies under the peak.";
    /// Close modes that respond in different runs.
    RunsApart: "This mode and a close one never respond in the same run: two local modes, or one mode that shifted.",
        "Both descriptions leave the same residual, so that both modes are listed. A run is the FRFs of one position of the roving sensor or hammer. The value is the distance of the two in half-power bandwidths. Where the structure has no such local modes and sensors or hammer were moved, the runs were measured in different states: identify them one by one.";
    /// A shape that the mass of the sensor changes between runs.
    LoadedShape [AtMost]: "The mass of the roving sensor changes this shape much from run to run.",
        "The value is the norm of the change over that of the residues, to first order from the shifts of the runs and the residues of the other modes; or the part of a close mode that the mass mixes into the shape. It is large where the reference is near a node of the mode. The shape is corrected for it, except where modes are mixed. The mode is doubtful; its frequency is the mean of the runs. Use a lighter sensor, dummy masses at the other points, or a reference where the mode moves.";
    /// Too few lines across a half-power band.
    FewLines [AtLeast]: "The half-power band holds too few frequency lines for a damping value.",
        "Peak-picking needs about five lines across the half-power band; with fewer, damping is quantised by the line spacing. Record longer or fit a curve.";
    /// A circle fit whose damping surface is not flat.
    DampingSpread [AtMost]: "The damping surface is not flat: damping depends on the points used.",
        "Each pair of points below and above resonance gives one damping value. For a single mode they agree. A spread beyond the limit means a neighbouring mode, leakage, noise or nonlinearity. Use a multi-mode method, or record longer.";
    /// A peak that no single mode fits.
    NotFitted: "The single-mode fit failed at this peak; the values are initial estimates from the peak itself.",
        "The fit found no circle or no half-power points, or left the peak. Frequency and damping of this row are read at the top of the peak, without correction for neighbouring modes. Use a multi-mode method, or a narrower band.";
    /// A second mode inside a resonance.
    CloseModes [AtMost]: "This peak holds more than one mode, or its frequency shifts between the FRFs. A single-mode method cannot separate them.",
        "The residual of the single-mode fits, over all FRFs, is far above the noise and correlated between them; or the FRFs disagree on the frequency by more than their bounds. Either two modes lie under the peak, and frequency, damping and shape of this row belong to a mixture, or the frequency shifted from run to run (a roving sensor or hammer, temperature, amplitude). Use a multi-mode method, or look at the runs one by one.";
    /// Several modes with one pole.
    RepeatedRoot: "Several modes share one natural frequency and damping (a repeated root). They are listed as one group.",
        "The residue matrix at this peak, responses by references, has more than one independent shape, and all have the same pole. The value is their number. There may be more, because the test shows no more than the smaller number of responses and references. Any combination of the listed shapes is as good a set of modes: compare the subspace they span, not one shape with another.";
    /// No damping remains after that of the window is subtracted.
    DampingNotPositive: "No damping remains after subtraction of the exponential window.",
        "The decay rate of the window is subtracted from every pole. Where the structure damps far less than the window, the difference is smaller than its error. The frequency is valid, the damping is undetermined. Use a longer record and a weaker window.";
    /// A half-power point is missing.
    HalfPowerMissing: "The response does not fall to half power on one side of the peak before it rises again.",
        "A neighbouring mode or the band edge hides the half-power point on that side, so that damping comes from the other side alone. Use a multi-mode method.";
    /// A local maximum that is no mode.
    PeakDropped [AtLeast]: "A local maximum was not taken as a mode.",
        "A peak must exceed the noise, be the highest point within its half-power band, and give a positive damping. The value and the limit show which of these failed.";
    /// Variances estimated from the residual of the fit.
    NoiseFromFit: "Some FRFs have no variance; the noise was estimated from the fit residual.",
        "The noise of the FRFs determines the standard deviations of frequency and damping, and which poles are accepted as modes. Where one FRF has neither a variance nor a coherence with its number of averages, the noise of all FRFs is estimated. It comes from second differences of the residual over some hundred lines, or from the level of the residual where noise is correlated between lines. State the number of averages (`--averages`) where the coherence is known.";
    /// Noise that is correlated between frequency lines.
    LinesShareNoise: "Noise is correlated between frequency lines, as under an unreported exponential window.",
        "Noise of constant variance over the record is independent from line to line. Here it is correlated between neighbouring lines, which looks like modes. Its variance was estimated from the level of the residual, and it raises limits and standard deviations. The value is the estimated rate at which the noise decays over the record. Without a value the noise does not decay exponentially, as after smoothing over lines. Where a window e^(−at) on force and response is the cause, the decay rate of every mode contains a, and its damping ratio is a/ω too high. Export the FRFs without the window, or state its rate.";
    /// Only poles with scattered phases fit the data.
    PhasesScatter: "The data cannot be fitted to the noise level with few modes; additional poles have scattered phases and were discarded.",
        "Enough poles fit any smooth function of frequency, but their residues are then as often in quadrature as in phase with those of modes. Poles that explain less than a fifth of the response around them were removed, the smallest contribution first, weak modes possibly among them. Their contribution enters the standard deviations and the limits that a mode must exceed. The value is the number of poles before. Causes: a nonlinear joint, a single hit for each FRF, a clamping that differed between hits, a filter in the chain, delays between channels, or damping that makes modes complex. Average several hits, check their coherence, and compare measured and synthesized FRFs.";
    /// A pole without damping at a multiple of a mains frequency.
    MainsHum [AtLeast]: "A pole with almost no damping at a multiple of 50 or 60 Hz, probably mains hum, was left out.",
        "Hum in the recordings is a sine. Its pole has no damping: the value is its half-power bandwidth in frequency lines. A mode with so narrow a resonance would ring many times longer than the record. Check cables and earthing, and average more hits. Record longer if it may be a mode.";
    /// A mode that moves with a stronger one.
    RepeatsNeighbour [AtMost]: "A stronger mode close by moves nearly all sensors in the same sense as this mode. Both may be one mode that shifted between hits or is nonlinear.",
        "The value is the agreement of both residue vectors in sign, weighted by their size: 1 where all agree, about 0 for two modes of a structure with enough sensors. Two poles fit a resonance that shifted between runs or hits, or whose frequency depends on the amplitude, better than one. Two modes that the sensors cannot separate look the same, such as a structure with a tuned absorber that has no sensor. The mode is doubtful. Look at single hits; hit and measure in a second direction, or on the absorber.";
    /// A mode with a contribution near the misfit.
    WeakerThanMisfit [AtLeast]: "The contribution of this mode to the response is hardly larger than what the modes together leave unexplained.",
        "The value is its modal contribution, the limit twice the square root of the energy of the residual beyond the noise over that of the response, both on the lines of the mode. A pole of that size can belong to the misfit. The mode is doubtful. Find the cause of the misfit, or look at the FRFs around it.";
    /// A mode that a close one explains.
    HardlySeparate [AtLeast]: "This mode and a close one hardly differ in the data: the other mode explains nearly all that this one does.",
        "The value is the modal contribution of this mode: the fraction of the response on its lines that no other mode explains. Two such poles are two close modes, or one mode whose frequency differed between runs or hits, or with the amplitude. The mode is doubtful. Hit at a point where one of the two hardly moves, or look at single hits.";
    /// A weak mode of a repeated root.
    WeakRepeated [AtLeast]: "The weaker mode of this repeated root contributes little: errors of gain, direction or place of a few percent look the same.",
        "The value is its modal contribution, the fraction of the response on the lines of the root that the stronger mode does not explain. The weaker mode is doubtful, the stronger one is not. Hit at a point or in a direction where the other mode of a symmetric structure moves.";
    /// A complex shape among real ones.
    ComplexShape [AtLeast]: "The phases of this shape scatter, while most shapes of the test are real.",
        "The value is the modal phase collinearity (MPC) of the shape: 1 for a real shape, 0 for phases all around the circle. A pole that fits noise, misfit or a part of a neighbour has such a shape; so has a mode that close modes with much damping make complex, or a travelling wave in a rotating part. The mode is doubtful. Compare it with the modes beside it.";
    /// Residual above the noise near a mode.
    ModelMisfit [AtMost]: "The residual near this mode exceeds the noise; its standard deviations were enlarged accordingly.",
        "The value is the root mean square of the residual over the noise within a half-power bandwidth of the mode. Above the limit the model misses the data. The detail has the residual over the response, the factor on the standard deviations (std ×), the standard deviation of the frequency over the half-power bandwidth (Δf), that of the damping over the damping, and the expected loss of MAC of the shape. It names the FRFs with the largest residual over noise, and how many of all exceed the limit. A misfit is reported where the residual is more than 4 % of the response, the damping uncertain by more than 10 %, the frequency by more than a twentieth of the bandwidth, or the MAC by more than 0.01. All are lower bounds where the misfit is systematic; damping tends to be too high. Causes: noise correlated between lines, a nonlinear or varying structure, truncated records, a variance that is too small. Check the named FRFs, measure at one level of force, or leave these FRFs out.";
    /// A pole with a small modal contribution.
    RootMinor [AtLeast]: "A pole with a small contribution to the response was rejected.",
        "Where the residual exceeds the noise, poles near the modes can fit parts of the response that are no resonance (spurious modes). The pole may be a local or weakly excited mode all the same. The value is its modal contribution: the fraction of the response in its half-power band that no other pole explains. Below 3e-4 it is rejected whatever the noise, because no structure is linear enough. Look at the FRFs there, or choose another reference.";
    /// A pole whose residues do not have the phase of a mode.
    RootPhase [AtMost]: "A pole was rejected because the phase of its residues is not that of a normal mode.",
        "The residues of a normal mode are imaginary (in receptance), those of complex modes may have another phase. Near a strong mode, residues rotated by tens of degrees mostly fit the difference between the measured resonance and that of a linear structure. Where damping couples close modes the pole can be a mode: check before discarding it. The value is the phase angle to real modes, or to the strong neighbour where that is less.";
    /// A peak without a mode.
    PeakWithoutMode [AtLeast]: "The FRFs have a peak here, but no mode was accepted.",
        "A pole was tried and dropped, or none was stable over the model orders. With a value: its significance, against the limit that noise reaches; or its standard deviation in decay rates; or its distance to a stronger pole in standard deviations; or its half-power bandwidth. Look at the peak in single FRFs, and compare with another method. A band around one peak excludes its neighbours, so that it is no test of the mode.";
    /// No pole of the method near a selected one.
    SelectionMissed [Tolerance]: "The method has no pole within the tolerance of this selected one. It was left out.",
        "The file of `--selection` names poles by frequency and, where stated, damping ratio and model order. The value is the distance of the nearest pole of the method (of that order), the limit the tolerance: `tolerance_hz` of the file, else 1 % of the frequency. Without a value, the fit removed the selected pole. Poles outside the band cannot be selected. One mode is selected at a second order only where the file names that order. Look at the poles of all orders with `--stabilization FILE`.";
    /// No mode in the band.
    NoModeFound: "No mode was found in the band.",
        "No peak exceeds the noise in the band that was searched, or no pole at its peaks stands for a mode (listed as peaks without a mode). Check the coherence, the band, and whether the hammer excites it; try another method.";
    /// Low coherence.
    LowCoherence [AtLeast]: "The coherence is low over the band: noise biases H.",
        "The value is the median coherence of the worst FRF over its valid band. Noise on the force makes H1 too small by about that factor, noise on the response H2 too large. Use a force window, hit harder, average more, or use hv.";
    /// The record holds too few time constants of this mode.
    FewTimeConstants [AtLeast]: "The record is too short for this mode (truncation, leakage). Its damping and its modal mass may be too high.",
        "With n time constants of the mode in the record the relative error of H at the resonance is about exp(-n). Below 6 it exceeds 0.25 %. Record longer.";
    /// Damping that leakage under steady random excitation raises.
    DampingBiasedHigh [AtMost]: "The resonance is few frequency lines wide. Leakage of a random excitation under a Hann or flat top window would bias its damping high by about this much. It was not corrected.",
        "Under steady random force the averaged FRF is the true one smoothed by the power spectrum of the window; the wider the window's main lobe beside the resonance, the more damping a fit of poles finds. The value is that bias in percent of the true damping, of a least squares fit of one pole, under the stated window, or where none is stated under a Hann or flat top window, whichever describes the data better (other methods than `ml`: Hann); neighbouring modes and the weights of the lines make up to twice as much of it. There is none where even an undamped mode would look as wide. Where the window is stated (dataset 1858 of universal files), `--method ml` fits the smoothed line shape, which removes the bias. A hammer test, and an excitation that is periodic in the record, have no such bias. None is reported where the data contradict both windows, or where `--window none` is stated. Continuous random force without a window raises damping as well, which these data cannot show. Record longer.";
    /// Poles fitted with the line shape of the window.
    WindowLineShape: "The stated window is one for steady excitation. The line shape of poles under it was fitted, so that the damping has no leakage bias.",
        "Under steady random force the averaged H1 is the FRF smoothed by the power spectrum of the window, of which a pole 1/(iω − λ) becomes the transform of e^(λt) times the window's autocorrelation, over records as long as the inverse of the line spacing. Where the excitation was not random but periodic in the record, or the spectra were zero-padded, damping comes out too low: export the FRFs without a window then.";
    /// A stated window that the data contradict.
    WindowContradicted: "The stated window is one for steady excitation. Poles without its line shape fit the data much better. The window was not used.",
        "Under steady random force a window smooths the FRFs, and poles have another line shape. An impact, or an excitation that is periodic in the record, has no such smoothing. Correct `--window`, `window` of `[[test]]`, or dataset 1858 of the universal file.";
    /// Close poles that leakage makes from one mode.
    LeakageSplit: "Close poles were merged: fewer poles under the window named describe the data nearly as well. No window is stated.",
        "The value is the number of poles merged. Under steady random force leakage gives a resonance of few frequency lines a line shape that two poles imitate. Of a Hann and a flat top window the better one is named. The damping remains that of the FRFs as they are, with its bias in `damping-biased-high`. If the test had this window, state it (`--window`, `window` of `[[test]]`, or dataset 1858 of universal files): damping is then corrected. If it was an impact, or an excitation that is periodic in the record, state `none`: nothing is merged then. Two modes closer than 3 frequency lines (flat top: 6) cannot be separated from leakage with these data. Record longer, or zoom.";
    /// Close poles of one shape.
    PolesMerged: "Pairs of poles of one shape, all at the same distance of a few lines, were merged: the FRFs are probably smoothed.",
        "The value is their distance in frequency lines. Each mode of FRFs that were averaged over neighbouring lines looks like two poles of one shape (MAC above 0.95) at that distance. Their mean replaces them. Damping is less certain than its standard deviation says. Export the FRFs without smoothing.";
    /// Poles of one mode whose frequency varied within the runs.
    VariesWithinRuns: "The natural frequency varied while a run was measured: the poles that stand for this mode were merged. The mean over the runs is stated, with the standard deviation of that mean.",
        "The average of hits between which a natural frequency shifts is no resonance of one frequency: several close poles fit it, with residues of one sign whose shares differ from run to run. Where half of the modes or more look like that, and there are three poles more than modes, those of each become one mode: its residues are their sums, its frequency the mean over the runs. A run is the FRFs of one position of the roving sensor or hammer. The value is the standard deviation of the frequencies. The damping is that of single hits, without a standard deviation. Temperature, loosening joints or a changing mount are the usual reasons: hit again when the structure has settled, or estimate FRFs hit by hit.";
    /// Poles that amplitude-dependent stiffness or damping adds to a mode.
    AmplitudeDependent: "The frequency or the damping of this mode probably depends on its amplitude (nonlinear stiffness or damping). Poles at its frequency with 2 to 5 times its decay rate describe this. They were fitted but not listed as modes.",
        "The FRF of a free decay with amplitude-dependent stiffness or damping has further poles at the frequency of the mode and of its shape. Their decay rates are 2, 3, 4, ... times that of the mode for damping that grows with the amplitude, and 3, 5, 7, ... times for stiffness or damping that change with its square. With these poles in the fit, frequency and damping of the mode are those of small amplitudes; above κ = 0.5 they are approximate. The value κ is the largest residue of such a pole over that of the mode. At the start of the decay the frequency differs by about 2ζκ of it (stiffness), or the damping by κ/(1 − κ) to 2κ/(1 − 2κ) of it (damping). Two close modes that the sensors do not separate look the same, with a single FRF always, and so does an absorber without sensors: `--method lscf` lists all poles. Dry friction has no such poles. Repeat the test at several force levels: nonlinear stiffness and damping change κ with the force.";
    /// A pole that changes with the band by more than noise.
    BandDependent [AtMost]: "On narrower bands this pole differs by more than noise explains. The standard deviations of its frequency and damping include the difference.",
        "The value is the part of the standard deviation of the damping that comes from the choice of the band, in percent of the damping. The pole was compared with itself on fewer of the lines on which it is fitted: the middle half, quarter and eighth of them, and all on one side with a tenth on the other. The largest difference beyond noise counts. Smaller ones enter the standard deviations without a finding; those of the shape have no such part. Something in the data is not in the model: another mode or a mains line nearby, two modes fitted as one, stiffness or damping that depends on the amplitude, a truncated record, or leakage. Look at the FRFs around the mode. Identify it with bands of several widths (`--band`, in a scene `band_hz`) and take the scatter of the results as its uncertainty.";
    /// A mode above the valid band.
    AboveValidBand [AtMost]: "The mode lies above the valid band: beyond 0.4 of the sampling rate, where aliases are possible, or where the force excites little.",
        "Analog filters are flat up to about 0.4 of the sampling rate. Above it they fall, and content above half the sampling rate is aliased. The frequency may be an alias, damping and shape may be wrong. Sample faster, or hit with a harder tip.";
    /// A stated band beyond the data.
    BandCut [EndOfData]: "The band reaches beyond the data, or to lines without a number, and was cut to them.",
        "Value and limit are the edge of the band and the outermost line on that side. Modes beyond the data cannot be found.";
    /// Frequency lines at which no function has a value.
    LineFilled: "Missing frequency lines (0 or NaN in all FRFs) were interpolated.",
        "The value is their frequency; at most three lines in succession are interpolated. Near a resonance of few lines the interpolation has the error of a polynomial there, which is reported as misfit. Find out where the lines were lost: a filter, a division by a force that is 0, or an edited file.";
    /// Outlier lines, narrower than a resonance.
    SpikeReplaced: "Outlier lines (narrower than a resonance can be) were replaced by interpolation.",
        "The value is their frequency; at most three lines in succession are replaced. The mains, or a machine that runs nearby, causes such lines. A resonance would show on the lines around it, unless it is narrower than 0.04 lines, as in calculated FRFs. The data have no variance, which would reveal such lines. Average more, record longer, or exclude the lines from the band.";
    /// A mode at the edge of the band.
    NearBandEdge [AtLeast]: "The mode lies within its half-power bandwidth of the band edge.",
        "Part of its resonance is outside the band, so that the fit uses one flank only. Widen the band.";
    /// Two modes of one side that match one of the other equally well.
    Ambiguous [AtLeast]: "This pair is ambiguous. Another pairing has nearly the same MAC and frequency.",
        "Two model modes may be the partner of this test mode, or two test modes that of one model mode: the detail says which. MAC and frequency of the best and the second match differ by less than the stated margin. Measure at more points, or state the pairing.";
    /// A MAC below the chance level of independent shapes.
    BelowChanceLevel [AtLeast]: "The MAC of this pair is below the chance level for independent shapes. The pair was marked ambiguous.",
        "The value is the MAC, the limit the level that independent shapes at these sensors reach with any of the model modes within the frequency gate in 1 of 100 cases, or in 5 where most other modes of the test reach theirs. Real, smooth shapes correlate more. Only the frequency supports this pair. Measure at more points, check names, directions and signs of the sensors, or correct the model.";
    /// A test shape that two model modes may explain.
    ClaimedTwice [AtMost]: "Another model mode may explain half of this test shape or more, or this model mode half of another test shape. Only one can be right.",
        "Each model mode is compared only with those near it in frequency. Model modes far from each other can each explain a shape that looks the same at these sensors. The value is the part that the other one would explain. Measure at more points, or narrow the gate on the frequency error.";
    /// A test shape that several model modes explain together.
    MixedShape [AtLeast]: "The contribution of this model mode to the test shape, less its standard deviation, is below the stated MAC. Shapes are mixed, or these sensors do not separate the modes.",
        "All modes of the model explain the shape together. The value is the contribution of this mode less one standard deviation. Wrong stiffnesses mix neighbouring modes; with few sensors shapes of different modes look the same. Measure at more points, or update the model and pair again.";
    /// A pair whose MAC reaches the gate only after correction of reversed sensors.
    RestsOnReversal [AtLeast]: "Sensors have the opposite sign of the model, and the MAC as measured is below the gate. The pair was marked ambiguous.",
        "Pairs are chosen with the reversed sensors corrected; the MAC in the table is of the shapes as measured. The value is that MAC, the limit the gate (`min_mac`). Correct the signs of the sensors named in the findings. With --turn-reversed the pair is accepted by the corrected shapes.";
    /// A pairing with low MAC.
    LowMac [AtLeast]: "The model mode nearest in frequency has a low MAC and was not accepted.",
        "The gate is stated in the scene (`min_mac`). A low MAC at equal frequency means another mode, a wrong direction or sign of a sensor, or a hit near a node.";
    /// A factor on all stiffnesses that would pair most modes.
    CommonFactor [StandardDeviation]: "Few modes pair, but most would if all stiffnesses were scaled by this factor; nothing was changed.",
        "Most test modes correlate with one model mode alone, and their frequencies are off by about the same ratio. The value is the factor on all stiffnesses (the square of that on frequencies), with its standard deviation from mode to mode. Where that is small, one modulus, unit or scale may be wrong; one over the factor on all masses has the same effect. This is a suggestion. Check units and thicknesses first, or free the parameter that scales all stiffnesses in [update].";
    /// Two test modes with each other's frequency.
    FrequenciesExchanged: "This test mode has the shape of a model mode near another test mode's frequency, and that one the reverse: the two frequencies may be exchanged.",
        "Each of the two has the shape of one model mode alone, and the frequency of the mode that the other has the shape of. The value is the frequency of the other. A list that was sorted by hand or a wrong label of a shape causes this. Correct the list; as they are, the two do not pair, or bias the parameters.";
    /// Points that are numbered from the other end.
    PointsReversed [AtMost]: "The shapes agree with the model once the points of each direction are numbered in reverse order.",
        "The value is the mean over the test modes of the largest MAC with a model mode in reverse order of the points, the limit that as numbered. Check from which end the points of test and model are numbered, and correct the names.";
    /// A mode that the others do not predict.
    ModeNotPredicted [AtMost]: "The model, updated to the other modes, does not predict this mode. Its value may be wrong, or the model cannot represent both.",
        "The value is the left-out residual over its standard deviation as the other modes show it. One such mode: check its frequency, its shape and its partner, or leave it out by `band_hz` and update again. Several of them: the model lacks something that the structure has.";
    /// Configurations with another value each of a shared parameter.
    ConfigurationsDisagree [Elsewhere]: "The configurations contradict each other. Another value of this parameter in one of them explains most of it. No parameter was identified.",
        "The detail names the configuration. The value is that of the parameter where it may differ there alone, the other value that of the others then. The parameter need not be the cause. Check `modify`, `parameters` and the tests of the configuration first: a wrong added mass, reassembly, preload and temperature look like another stiffness, and a model of a part may lack what the assembly has. If the parameter does differ, list it in `separate` of the configuration.";
    /// Another optimum has another value.
    ParameterAmbiguous: "Another set of parameters fits the test as well, with another value of this one.",
        "The value is that of the other optimum. The measured modes cannot tell the two apart: frequencies alone of a symmetric model do not show on which side a stiffness changed, and a test of few modes can have several solutions. `update.json` lists all optima and the mode that differs most between them. Measure that mode or its shape, or hold one of the parameters.";
    /// An FRF of the wrong sign, which doubles modes.
    TurnedFunction: "This FRF has the sign opposite to that of the other references at this response. It was reversed for the identification.",
        "The residue matrix of a single mode has rank one over responses and references. One FRF of the wrong sign gives it rank two at every mode, so that each mode would be found twice. Check whether the sensor or the hammer was reversed in that run, and correct the direction or the sign of the sensitivity.";
    /// FRFs of an output of which half have the wrong sign.
    SignUndecided: "One of the FRFs of this sensor or hit has the wrong sign, and the data cannot tell which. They were left out, so that the shapes lack this point.",
        "With two references the FRFs of a response have opposite signs relative to those of all other responses. Either of the two may be wrong, and the sign of the response in all shapes depends on it. A driving point among the two, or a third reference, would decide. Check the directions of sensor and hammer in both runs, correct the sign, and identify again.";
    /// Gains that contradict a common shape.
    GainDiffers: "FRFs of different references disagree by factors that are the same at all modes. They were divided by these factors; the error of the worst FRF is given.",
        "The FRFs of a mode are products of a factor of the response and one of the reference. An FRF that differs from the product by the same factor at all modes has a gain error: a sensitivity or a range that was changed between runs, another hammer tip or sensor, an amplitude that was scaled. Uncorrected, such factors look like repeated roots. The value is the error in percent. Shapes may have errors of the same size, because factors of a whole response or a whole reference cannot be detected. Check sensitivities, ranges and units of the channels in that run.";
    /// Test modes at a repeated root with one shape.
    AlikePartners [AtLeast]: "Test modes paired with a repeated root have similar shapes. One of its modes may be there twice and another missed.",
        "The value is the part that they share of one direction of the root, cos² of the largest principal angle. Any rotation of the modes of one root is also a set of modes, but they span as many directions as the root has modes. Check whether one pole was selected twice, or measure with another reference.";
    /// Two modes of one set with one shape.
    DuplicateModes [AtMost]: "This mode has nearly the same shape and frequency as another of its set. It is one mode found twice, or one of two that the sensors cannot separate.",
        "The value is the MAC of both (autoMAC). Causes: one pole selected twice in the stabilization diagram, two poles fitted to one resonance that shifted between runs, or too few sensors. Keep the one that explains more of the response, or measure at more points.";
    /// Rotations without a length that scales them to translations.
    RotationsLeftOut: "The modes have translations and rotations. The rotations were left out of the autoMAC.",
        "Translations are in metres and rotations in radians: their sum in a MAC needs a length that scales the rotations, such as the size of the structure. The value is the number of rotations. State the length with --rotation-length of `correlate`, or rotation_length_m in [pair] of a scene, to compare both.";
    /// A sensor of the opposite sign.
    ReversedSensor: "This sensor has the opposite sign of the model in the pairs. Reversed, it raises their mean MAC.",
        "Its values disagree in sign with those of the model in most pairs of modes. The value is the gain of the mean MAC. Check how the sensor was mounted, and the sign of its channel. Its values are unchanged unless --turn-reversed is given.";
    /// A group of sensors of the opposite sign.
    ReversedGroup: "These sensors have the opposite sign of the model relative to all others. Reversed together, they raise the mean MAC.",
        "The value is the gain of the mean MAC. Only the sign relative to the other sensors is observable: reversing this group is the same as reversing all others, and the smaller side is named. Pairs are chosen with the group reversed; MAC is of the shapes as measured. Check how the sensors of this direction, component or file were mounted, and the sign of their channels. Their values are unchanged unless --turn-reversed is given.";
    /// Sensors of the opposite sign whose values an update does not use.
    ReversedLeftOut: "Values of sensors with the opposite sign of the model were left out of the update.",
        "With the wrong sign they move stiffnesses away from the test. The number of sensors is the value, the detail names them. All natural frequencies and the other sensors are used. A mode that keeps fewer than two sensors counts by its frequency alone. Only the sign relative to the other sensors is observable. Check the mounting and the sign of the channels, correct the test file, and update again.";
    /// A doubtful mode that an update does not use.
    DoubtfulLeftOut: "This test mode is doubtful and was left out of the update.",
        "A mode that is not certain to be one of the structure (`quality` in the table of modes) would pull stiffnesses to a wrong pair. Its remark names the reason. With `doubtful_modes = true` in [update] it counts.";
    /// A test shape outside the subspace of the modes of a reduction.
    OutsideReduction [AtMost]: "Part of this test shape lies outside the modes that the SEREP reduction keeps. Its orthogonality does not contain that part.",
        "SEREP replaces a test shape by the nearest combination of the modes that it keeps: as many of the lowest as the sensors separate (condition number of at most 10). The value is the squared length of the remainder over that of the shape. Where it is large, the orthogonality looks better than the shape is. Check the MAC, use --orthogonality guyan, or measure at more points.";
    /// Paired modes that a reduction does not keep.
    ReductionModesLeftOut: "Paired modes were left out of the SEREP reduction, because the sensors hardly separate them from the modes that it keeps.",
        "SEREP solves for the amplitudes of its modes from the readings of the sensors. The condition number of these readings is the factor by which an error of a test shape grows: with as many modes as sensors a shape of MAC 0.996 may reach a cross-orthogonality of 0.4. Modes are added, the paired ones first, as long as it is at most 10. The value is the number of paired modes that are left out. Measure at more points, or use --orthogonality guyan.";
    /// A test geometry that was fitted to that of the model.
    NodesAligned: "The points of the test were rotated, shifted and scaled onto those of the model.",
        "The value is the scale, near 0.001 for millimetres read as metres. Several frames may fit equally well, because the points lie on a line, cover a part of a grid, or the machine is symmetric. The detail says how many, and whether the shapes select one by their MAC. Where they do not, this is a warning, and the frame with the smallest rotation was taken. A scale that is no ratio of units of length is a warning, too: the fit is probably wrong. Check the distances and the MAC, or give a list of pairs with --align FILE.";
    /// Degrees of freedom without a counterpart.
    DofWithoutPartner: "A DOF of the test has no counterpart in the model and was left out of the comparison.",
        "MAC is computed on the DOFs that test and model have in common. State the missing ones as [[sensor]] in the scene.";
    /// Few DOFs in a MAC.
    FewDofs [AtLeast]: "Test and model have few DOFs in common for a MAC.",
        "With few DOFs different modes look the same. The value is their number; sensors that move alike in every mode of the model, as those at one position, count once. With fewer than three, modes are paired by frequency alone. Measure at more points.";
    /// Shapes that agree where no mode is paired.
    ShapesAgree: "No mode is paired, but mode shapes agree where frequencies differ by this factor.",
        "Modes of test and model have a MAC of 0.9 or more with each other and 0.6 or less with all others. Their frequencies differ by more than the frequency gate (`max_frequency_error`, --max-frequency-error). The value is the mean ratio of the frequencies of the test to those of the model. One ratio for all modes has a common cause: a dimension, the material, or the unit of a value. Check dimensions and material of the model.";
    /// A synthetic recording.
    Synthetic: "This recording is synthetic: computed from a model, not measured.",
        "Its exact truth is known and written with it. It shows that the tool works, not that a machine behaves so.";
    /// Letters that the font of PNG figures does not have.
    LettersLacking: "The font of PNG figures lacks letters of this figure. Boxes replace them; the SVG has them.",
        "The program carries one font, with Latin, Greek, Cyrillic and Hebrew letters; fonts with Chinese, Japanese or Korean ones are too large for it. Use the SVG, which is drawn with the fonts of the machine that shows it. Or save the figure as PNG from report.html, or name tests and parts in letters of the font.";
    /// A built-in model whose name a file or a folder has.
    BuiltInTaken: "A built-in model and a file, or a folder with a scene, have this name.",
        "MODEL is a built-in name, a file, or a folder with a scene. A name without a path separator means the scene where a folder of this name has one, as for the verbs that take a SCENE. It means the built-in model where a file has this name. The detail says which was used. Put ./ before the name to use the file. Work in another folder, or rename the scene, to use the built-in model.";
    /// A model file that is as it was drafted.
    ExampleValues: "The model has the values of an example, not those of the structure.",
        "`modalign new --model beam` or `lumped` drafts a model.toml with the values of an example and `example_values = true`. Frequencies, errors and updated parameters of such a model say nothing about the structure. State dimensions, masses, stiffnesses and supports of the structure in model.toml. Then delete the line `example_values`.";
    /// A mode of a test that is a rigid-body mode on its suspension.
    RigidBodyMode [Stated]: "This mode of the test is a rigid-body mode of the structure on its suspension or mounts.",
        "The scene states the highest of these modes (`highest_rigid_body_hz` in [test.state]), which is the limit. A free model has it at 0 Hz, so that no elastic mode of the model is its partner. Choose `band_hz` above it.";
    /// A suspension that shifts elastic modes.
    SuspensionStiff [AtMost]: "The suspension is stiff: its highest rigid-body mode is above a tenth of the lowest elastic mode.",
        "A suspension with a rigid-body mode at f_r raises an elastic mode at f_e by about half of (f_r/f_e)², which is the stated bias; slings at the ends of a bar raise it four times as much, slings at nodes not at all. A model without the suspension has lower frequencies. The value is f_r, as the scene states it, the limit a tenth of the lowest elastic mode of the test (Ewins, Modal Testing, 2000, chapter 3, allows 0.1 to 0.2). Hang the structure in softer slings, attach them near nodes, or put their stiffness into the model.";
    /// A test and a model with different supports.
    SupportDiffers: "The supports of test and model differ.",
        "The scene states that of the test (`support` in [test.state]). That of the model is stated, or follows from its stiffness matrix: a model is free where no translation of the whole strains it. The value is the largest relative change of the frequencies of the paired modes when the stiffness to ground is removed from the model, each followed by its shape. Part of the errors of the frequencies may come from the support and not from the parameters. Test and model need one support: remove the springs to ground from the model, or test the structure on its support.";
    /// Tests of one machine with different frequencies.
    TestsDisagree [AtMost]: "Tests of one machine in one state differ in their frequencies.",
        "The value is the largest difference of a paired mode between two tests with the same [test.state], the limit 1 %; the difference exceeds four standard deviations, too. Doubtful modes do not count. The detail lists the modes. An error of the model that is smaller than the difference of that mode may be one of the tests. Reassembly, preload, temperature, support and the mass of sensors differ between tests: repeat one test without a change to see the scatter. In [update], scatter_between_tests = true adds the scatter to the deviations of each test. If the tests are of different states, state what differs in [test.state].";
    /// A stated support of a model that its matrices contradict.
    ModelSupportContradicted [AtMost]: "The support that the model states contradicts its stiffness matrix.",
        "A model is free where no translation of the whole strains it. One that states `fixed` or `mounted` needs springs to ground or fixed coordinates. One that states `suspended` may have the springs of its suspension: the value is then the highest frequency at which the whole model moves on them, the limit a tenth of its lowest mode that a test confirms. The stated support was compared with that of the tests. Correct `support` in the model, or its springs.";
    /// A sensor at which the model does not move.
    SensorUnmoved: "The model does not move at this sensor or hit in its direction.",
        "The modes of the model are 0 there. Where that is so at all sensors, no mode is observable and none pairs by shape. A beam moves along its `deflection` alone, a body along its `free` coordinates. Correct the axis of the DOF or `direction` of [[sensor]], or `deflection`, `from_m` and `to_m` of the beam, or `free` of the body.";
    /// A sensor beside the axis of its beam.
    SensorOffBeam [AtMost]: "This sensor or hit lies off the axis of its beam.",
        "A beam has its mass and stiffness on the line from `from_m` to `to_m`. A point beside it counts at the foot of its perpendicular on the line. The value is its distance from the line, the limit a tenth of the length of the beam. Correct `at_m` of [[sensor]], or `from_m` and `to_m` of the beam.";
    /// Sensors of one position and direction.
    SensorsAtOnePosition: "Several sensors or hits have one position and direction in the model.",
        "The model has the same value at all of them, so that its shapes hold less than their number of DOFs says, and a MAC means little. Copied or unfilled positions are the usual cause. The value is their number. Correct `at_m` and `direction` in [[sensor]]. Two sensors that were mounted at one point may stay.";
    /// Points of one position.
    PointsAtOnePosition: "Several points have one position.",
        "The figures of shapes draw these points on top of one another, and the rigid-body motion of the sensors there cannot be checked. Copied or unfilled positions are the usual cause. The value is their number. Correct `at_m` in [[point]], or the positions in the files.";
    /// A model without sensors against a test.
    ModelWithoutSensors: "The model states no sensors, and its coordinates have other names than the DOFs of the test. Modes were paired by frequency alone.",
        "A model is solved at the positions of the sensors, so that its shapes can be compared with those of the test. Without sensors it has the names of its coordinates, no MAC exists, and unlike modes may pair. Give the scene as --theory, or state [[sensor]] in the model file.";
    /// An assumption of a model.
    Assumption: "A value was assumed, not measured or published.",
        "The status of the parameter in the model shows it: printed, inferred or assumed.";
    /// A derived quantity of a model that does not exist.
    QuantityAbsent: "A derived quantity does not exist at these values of the parameters, or needs values that the model does not allow.",
        "Some models define quantities that need other parameter values, such as a doubled stiffness or the values at a crossing. Where a bound or the sign of a parameter forbids these, or where nothing crosses, the quantity is left out (—). Move the parameters away from their bounds.";
    /// A parameter that no part of its model uses.
    ParameterUnused: "No part of the model uses this parameter.",
        "Neither mass, damping nor stiffness depends on it, so that no value of it changes a mode and no update can determine it. A body or a spring probably states a number where it should name the parameter (`stiffness_n_per_m = \"NAME\"` or `parameter = \"NAME\"`), or the name is misspelt. Use the parameter, or delete it.";
    /// A parameter that the data do not determine.
    ParameterNotSupported [AtMost]: "The data do not determine this parameter individually.",
        "Its posterior standard deviation is more than half of its prior one. A parameter that the test does not see at all keeps its value. One that the test sees only together with others moves with their combination; the table of identifiable combinations lists these. The value is posterior over prior standard deviation. Measure at other points or more modes, or state prior knowledge as prior_std.";
    /// A parameter that ended at a bound.
    ParameterAtBound: "This parameter ended at one of its bounds. The data require a value beyond it.",
        "Either the bound is too narrow, or the parameter compensates for another error of the model. The value is where it ended. Look at the single changes before widening the bound.";
    /// Misfit of the updated model.
    MisfitRemains [AtMost]: "The updated model does not fit the test within the stated uncertainties.",
        "The value is chi-square per degree of freedom with the stated deviations, the limit the level that noise alone reaches. Where frequencies and shapes count, both are of the kind that exceeds noise most, which the detail names. The standard deviations of the parameters include the misfit as model error: do not enlarge them again. Look at the single changes, at effects that the model neglects, and at the stated model errors.";
    /// A test mode without a counterpart after the update.
    PartnerLost: "This test mode has no counterpart in the updated model.",
        "It had one in the initial model. Its frequency and shape count as wholly unexplained, and the table of errors leaves it out. Check its shape, the pairing gates, and bounds that keep the parameters near their start.";
    /// A pairing that the update changed.
    PairingChanged [After]: "This test mode is paired with another mode of the model than before the update.",
        "Modes are tracked by their shapes. Crossing modes change their order, and test and model are paired anew at every optimum. The value is the number of the model mode before, the limit that after.";
    /// The update did not converge.
    NotConverged: "The update did not converge within the stated number of iterations.",
        "The value is the number of iterations. Raise `max_iterations`, or free fewer parameters.";
    /// A missed limit.
    LimitMissed: "A stated limit is missed.",
        "The scene states the limit in [limits], or the file given to `check --against` does.";
}

impl Code {
    /// Codes that put the verdict of a comparison in question, in this order.
    pub const ON_THE_VERDICT: [Code; 7] = [
        Code::ExampleValues,
        Code::SupportDiffers,
        Code::ModelSupportContradicted,
        Code::SuspensionStiff,
        Code::MassDiffers,
        Code::CommonFactor,
        Code::ShapesAgree,
    ];

    /// Its rank among the findings of one severity: those on the verdict come first.
    pub fn rank(self) -> usize {
        let mut codes = Self::ON_THE_VERDICT.iter();
        let position = codes.position(|code| *code == self);
        position.unwrap_or(Self::ON_THE_VERDICT.len())
    }

    /// The code as written in JSON and on the command line.
    pub fn name(self) -> String {
        serde_json::to_value(self)
            .ok()
            .and_then(|v| v.as_str().map(str::to_owned))
            .unwrap_or_default()
    }
}

/// An observation on data or results, with its numbers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// Its consequence for the results.
    pub severity: Severity,
    /// Its subject.
    pub code: Code,
    /// Its location.
    #[serde(rename = "place")]
    pub location: Location,
    /// The value found.
    pub value: Option<f64>,
    /// The limit that the value is compared with.
    pub limit: Option<f64>,
    /// Unit of value and limit.
    pub unit: Option<String>,
    /// The parts concerned, with their numbers: got and expected of a damaged part, or the FRFs of
    /// a mode.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub detail: Option<String>,
}

impl Finding {
    /// A finding without numbers.
    pub fn new(severity: Severity, code: Code, location: Location) -> Self {
        Self {
            severity,
            code,
            location,
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

    /// With the limit that the value is compared with.
    pub fn limit(mut self, limit: f64) -> Self {
        self.limit = Some(limit);
        self
    }

    /// Value and limit with their unit, the limit in the words of its kind; `None` without numbers.
    pub fn numbers_text(&self) -> Option<String> {
        let in_words = |kind: Option<LimitKind>, limit: &str| match kind {
            Some(kind) => kind.english(limit),
            None => format!("limit {limit}"),
        };
        self.numbers(in_words, ", ")
    }

    fn numbers(
        &self,
        in_words: impl Fn(Option<LimitKind>, &str) -> String,
        comma: &str,
    ) -> Option<String> {
        let kind = self.code.limit_kind();
        if let (Some(value), Some(std), Some(LimitKind::StandardDeviation)) =
            (self.value, self.limit, kind)
        {
            return Some(format_with_std(value, std));
        }
        let unit = self.unit.as_deref().unwrap_or_default();
        let is_rounded_away = match (self.value, self.limit) {
            (Some(value), Some(limit)) => {
                value.total_cmp(&limit).is_ne() && format_number(value) == format_number(limit)
            }
            _ => false,
        };
        let number = |value: f64| {
            let text = match is_rounded_away {
                true => value.to_string(),
                false => format_number(value),
            };
            format!("{text} {unit}").trim_end().to_owned()
        };
        let limit = self.limit.map(|limit| in_words(kind, &number(limit)));
        let parts: Vec<String> = self.value.map(number).into_iter().chain(limit).collect();
        (!parts.is_empty()).then(|| parts.join(comma))
    }

    /// With the parts concerned and their numbers.
    pub fn detail(mut self, detail: impl Into<String>) -> Self {
        self.detail = Some(detail.into());
        self
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sentence = self.code.sentence();
        let ends = self.value.is_none() && self.limit.is_none() && self.detail.is_none();
        // The full stop would stand before the parenthesis or the detail.
        let sentence = match sentence.strip_suffix('.') {
            Some(sentence) if !ends => sentence,
            _ => sentence,
        };
        write!(f, "{}: {sentence}", self.location)?;
        let numbers = self.numbers_text();
        numbers.map_or(Ok(()), |numbers| write!(f, " ({numbers})"))?;
        let detail = self.detail.as_deref();
        detail.map_or(Ok(()), |detail| write!(f, "; {detail}"))
    }
}

#[cfg(test)]
mod tests;
