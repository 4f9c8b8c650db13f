//! Catalogue of warnings and repairs with the text of `geardyn explain`.

/// Kind of a diagnostic.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DiagnosticKind {
    /// Warning about a result.
    Warning,
    /// Something done to the data of a log.
    Repair,
}

use DiagnosticKind::{Repair, Warning};

/// Every code, its kind, and what `geardyn explain` says of it.
pub const DIAGNOSTICS: &[(&str, DiagnosticKind, &str)] = &[
    // Reading a log.
    (
        "time-guessed",
        Warning,
        "The column of time stamps, or their unit, is uncertain: a column without a name increases evenly, or one named as a time without a unit counts 0, 1, 2, … State it: --time COLUMN or --time none, --time-unit ms, or in the sidecar.",
    ),
    (
        "time-rounded",
        Warning,
        "The time stamps are too coarse to judge single intervals. The samples are treated as evenly spaced, which the record as a whole confirms.",
    ),
    (
        "time-jitter",
        Warning,
        "The time stamps are uneven, and the samples were resampled. Above the stated band the values depend on the interpolation.",
    ),
    (
        "frequency-guessed",
        Warning,
        "The columns have no names. The first increases in equal steps, and the inverse transforms of the others are causal, as those of frequency responses are and those of signals are not: they are read as real and imaginary parts, or magnitudes and phases, over frequencies in Hz. Name the columns, or state the time column: --time.",
    ),
    (
        "decimal-comma",
        Warning,
        "Every comma of the text precedes three digits, so it may be a decimal mark or separate thousands. State it: --decimal.",
    ),
    (
        "names-misfit",
        Warning,
        "The number of names in the header line differs from the number of cells in the rows, so no column can be named. Columns are numbered; correct the line, or state --delimiter and --decimal.",
    ),
    (
        "rate-disagrees",
        Warning,
        "A second sample rate of the log differs by more than 0.1 % from the one used: a stated --rate from the time stamps or the header, a line of the header from the stamps, or a bare `rate`, which of a rotating machine may be the speed of a shaft, from the rate of samples. State the right one: --rate.",
    ),
    (
        "header-rate-mark",
        Warning,
        "The header states a sample rate whose only mark precedes three digits and is not the decimal mark of the file's numbers. It is read as the thousands separator; the rate would be a thousandth of it otherwise. State it: --rate.",
    ),
    (
        "header-rate-unread",
        Warning,
        "The header states an ambiguous sample rate: an unknown unit, trailing text, a negative number. The time stamps give the rate, and nothing was compared with it.",
    ),
    (
        "date-order",
        Warning,
        "Every date of the log can be read with the day first or with the month first. The time since the first sample is the same either way; the date of the first sample is not known. State the order: --day-first or --month-first, or `dates` in the sidecar.",
    ),
    (
        "clipped",
        Warning,
        "A channel was clipped at its limit: samples there are not the motion. Where enough remains, the clipped samples are removed and the record is split there; otherwise modes and damping may be wrong by more than their intervals, and spectra show too low levels and false harmonics.",
    ),
    (
        "nonlinear",
        Warning,
        "The frequencies found from the hits of a test, or from parts of a record with different input levels, depend significantly on the level: the structure is not linear at these levels. The message gives the change over the range of levels. Excite at one level, or state the level with the modes.",
    ),
    (
        "not-reciprocal",
        Warning,
        "A pair of points was driven both ways, and the two responses, which are equal for a linear structure, differ by more than one and a half times what their variances explain (by more than 10 % where no variance is known). A sensor or a force points along another direction, a calibration is wrong, or the structure is not linear at these levels.",
    ),
    (
        "mains",
        Warning,
        "A mode lies on a multiple of 50 or 60 Hz and is no wider than a spectral line: a sign of electric pick-up of the mains. A record without excitation shows whether it stays.",
    ),
    (
        "stuck",
        Warning,
        "A channel is constant for a long time although it varies before or after: its sensor, cable or recorder failed. `identify` omits that time if another channel shows that the structure moved.",
    ),
    (
        "taken-as-spectrum",
        Warning,
        "A channel's name says that it is a spectrum, though the header says it is over time.",
    ),
    (
        "variables-left-out",
        Warning,
        "Variables of the MATLAB file that are neither signals nor functions of frequency were not read.",
    ),
    (
        "functions-left-out",
        Warning,
        "Functions of the file are of a kind that is not read, or have other spectral lines than the rest.",
    ),
    (
        "values-missing",
        Warning,
        "A data set has fewer values than its header states.",
    ),
    (
        "local-axes",
        Warning,
        "Nodes of the UFF file use local coordinate systems, which are not read. Shapes at these nodes point in the wrong directions.",
    ),
    (
        "channel-unplaced",
        Warning,
        "The geometry of the test locates some of the response channels but not these, which are at rest in the shapes on points. State `point` and `direction` of their [[channel]].",
    ),
    (
        "another-clock",
        Warning,
        "The file has channels with several time bases: different rates, lengths or start times. Channels of one time base are analysed together; select the others by name.",
    ),
    (
        "name-twice",
        Warning,
        "Two variables or channels of the file have one name. Both are kept, the second numbered.",
    ),
    (
        "coherence-above-one",
        Warning,
        "A coherence of the file exceeds one, its maximum. Its values are not changed.",
    ),
    (
        "coherence-left-out",
        Warning,
        "A coherence of the file has no matching response.",
    ),
    // What was done to a log.
    (
        "row-incomplete",
        Repair,
        "The last row of the log is incomplete: it has too few cells, its last cell is the beginning of a number, or storage after it was never written, as when a logger is switched off. The row was left out. An incomplete row anywhere else is an error.",
    ),
    (
        "header-repeated",
        Repair,
        "Lines of the header are repeated between the rows, as when a logger is restarted or files are joined. They were skipped and the rows joined; only time stamps give the time between them.",
    ),
    (
        "sidecar",
        Repair,
        "The sidecar of the log (its name with .toml) was read and applied. --no-sidecar ignores it.",
    ),
    (
        "files-joined",
        Repair,
        "The files are records of one test. Each has its own segments, no average extends over two files, and each hit counts once.",
    ),
    (
        "gap-split",
        Repair,
        "Samples are missing. The record is split into segments there, and no average extends across. --fill-gaps interpolates them instead.",
    ),
    (
        "triggered",
        Repair,
        "Samples before the level of --trigger were left out, except those kept by --pre-trigger. The level is compared with absolute values in the log's unit.",
    ),
    (
        "gap-filled",
        Repair,
        "Missing samples were interpolated linearly, as requested.",
    ),
    (
        "resampled",
        Repair,
        "Samples at uneven times were resampled by band-limited interpolation.",
    ),
    (
        "cells-missing",
        Repair,
        "Cells have no number. Segments end there, in every channel.",
    ),
    (
        "thousands-joined",
        Repair,
        "Numbers have thousands separators, which were removed.",
    ),
    (
        "column-left-out",
        Repair,
        "A column is not a channel: a counter, text or empty.",
    ),
    (
        "channel-empty",
        Repair,
        "A channel has no numbers and was left out.",
    ),
    (
        "footer-skipped",
        Repair,
        "Lines after the rows of numbers were skipped.",
    ),
    (
        "rows-of-another-dialect",
        Repair,
        "Rows of numbers with another delimiter or decimal mark precede the rows that were read, and were skipped: two exports in one file. Save them in one format.",
    ),
    (
        "lines-skipped",
        Repair,
        "Lines outside of the data were skipped.",
    ),
    (
        "sets-skipped",
        Repair,
        "Data sets of other kinds than UFF 58 were skipped.",
    ),
    (
        "segments-joined",
        Repair,
        "Segments of an LVM file follow each other in time and were joined.",
    ),
    // Spectra.
    (
        "no-line",
        Warning,
        "No line exceeds the noise floor. The strongest line is shown, although it may be noise.",
    ),
    (
        "no-band",
        Warning,
        "An envelope without --band is that of the whole signal, in which bursts are hidden.",
    ),
    (
        "longest-segment",
        Warning,
        "Gaps split the record, and the method needs one segment: the longest is analysed.",
    ),
    (
        "tacho-pulses",
        Warning,
        "Pulses of the tacho are missing, doubled or uneven, or their number per revolution appears to differ from --pulses.",
    ),
    // Encoder records.
    (
        "mesh-above-band",
        Warning,
        "A mesh order lies above the highest order that the rows resolve, and was not evaluated. Sample the encoders faster, or turn more slowly.",
    ),
    (
        "counts-repaired",
        Warning,
        "An encoder lost counts or counted too many; the resulting step was removed, because --repair was given.",
    ),
    (
        "index-pulses",
        Warning,
        "Some index pulses of an encoder are missing or occur before a full revolution. The early ones are ignored. A pulse narrower than a sampling interval may be missed; noise on the line adds pulses.",
    ),
    (
        "step-without-counts",
        Warning,
        "The transmission error has a permanent step, and the index pulses show that both encoders counted correctly: a seat, a coupling or an encoder moved. The step is left in the record.",
    ),
    (
        "direction-too-short",
        Warning,
        "In one direction the record covers less than a full revolution of every shaft plus the play: that direction is not evaluated, and angles passed in both directions are used for the play only.",
    ),
    (
        "input-uneven",
        Warning,
        "The input of an encoder record does not turn uniformly at the orders of declared errors: its driver is free and responds to the meshes. Its motion is in the record; its share in the output is removed through the model.",
    ),
    // Identification.
    (
        "poles-differ",
        Warning,
        "The files of a roving test do not share their poles: a mode occurs in one file only, where all others have it at another frequency, or its frequency in one file differs by more than the noise explains. The structure was not the same: the mass of the sensor, the mounting or the temperature changed. One set of modes does not describe such files; repeat the named one, or leave it out.",
    ),
    (
        "no-decay",
        Warning,
        "Some files of the test are free decays after a release and others are not: their motion is forced, and the fit would treat it as a decay. Leave those files out.",
    ),
    (
        "one-segment",
        Warning,
        "Gaps split the record, and the method needs one segment: the longest is used.",
    ),
    (
        "one-average",
        Warning,
        "There is one average, so no variance and no coherence.",
    ),
    (
        "few-averages",
        Warning,
        "Variance and intervals are known to a factor of two at best; with fewer than three and a half averages no interval is given.",
    ),
    (
        "coherent-inputs",
        Warning,
        "The inputs cannot be separated: they are linearly dependent.",
    ),
    (
        "closed-loop",
        Warning,
        "The input has peaks at the modes: the motion feeds back to the force, and the responses are those of the closed loop.",
    ),
    (
        "aliasing",
        Warning,
        "A channel has as much power near half the sample rate as below: it was sampled without an anti-alias filter, and higher frequencies are aliased. For a hammer: the spectrum of its force does not fall by 30 dB up to half the rate, so that it excites resonances above, which are aliased unless a filter removed them. The residues of such a resonance differ from hit to hit, and three hits or more distinguish it from a mode; where the pulse lasts one sample all modes are listed as weak.",
    ),
    (
        "transmissibility",
        Warning,
        "Motion over motion: its poles are those of the structure held at the input, not its modes.",
    ),
    (
        "inverse-response",
        Warning,
        "Force over motion: its poles are the frequencies at which the force causes no motion there, antiresonances of the structure, not its modes. Swap --input and --output.",
    ),
    (
        "low-coherence",
        Warning,
        "The response at a mode is mainly noise, or is caused by another source than the input.",
    ),
    (
        "leakage",
        Warning,
        "A resonance is narrower than three lines of averaged blocks, or than one and a half windows of local parabolas over several blocks, so the block length broadens it. Take longer blocks, --resolution, or a longer record.",
    ),
    (
        "coarse-lines",
        Warning,
        "Fewer than four lines of a stepped sine, or of a file of responses, lie within the half-power width of a mode. Its pole depends on the form of the fit between lines: leakage in the estimate of the responses, a second mode, or a wrong value would not be detected, and the intervals include none of these.",
    ),
    (
        "unsettled",
        Warning,
        "Dwells of a stepped sine end before the response has settled. The settled value is extrapolated from the decay between quarters of the dwell, as of one mode, and is uncertain by a fifth of the correction.",
    ),
    (
        "kind-differs",
        Warning,
        "The units of the response contradict --kind, and --kind was used: residual terms of modes outside the band are then fitted in another form.",
    ),
    (
        "order-limit",
        Warning,
        "The criterion still decreases at the highest order tried: the order is limited by the search, not by the data. State a higher --order, or narrow the band.",
    ),
    (
        "departs",
        Warning,
        "Noise alone does not explain the responses. Poles were identified with a variance that includes the departure of each mode from the linear model, and the intervals include it. Usual causes: sensor mass, mounting, leakage, dependence on amplitude or temperature.",
    ),
    (
        "residual-delay",
        Warning,
        "The phases of a response's residues fall in proportion to frequency, from mode to mode: one channel is late, by an anti-alias filter that the other does not have or by its converter. The message gives the delay with its 95 % interval (negative: the input is late) and its phase at the top of the band. It rotates the mode shapes in phase; --delay common or --delay each removes it.",
    ),
    (
        "few-hits",
        Warning,
        "Fewer than three hits were used. The intervals of one hit include the noise and the departure from the model, but not the scatter between hits, which on real structures is often larger. Where two hits differ by more than their noise, frequency and damping are their means, and the interval is 12.7 standard errors (Student's t with one degree of freedom): wide, but it contains the mean over all possible hits. Three hits give a usable interval, five a good one.",
    ),
    (
        "driving-point",
        Warning,
        "A modal mass is not a positive number: force and motion at the driving point do not match, or the sign of one is reversed.",
    ),
    (
        "uncalibrated",
        Warning,
        "Modal masses need units of force and motion.",
    ),
    (
        "misfit",
        Warning,
        "The misfit is larger than the variance explains. Standard deviations were widened to it.",
    ),
    (
        "zero-response",
        Warning,
        "A response is zero throughout and was left out.",
    ),
    (
        "pole-limit",
        Warning,
        "The search ended at the limit of pole pairs or of operations (a few seconds). The largest modes are found first; narrow the band for the others: --band.",
    ),
    ("no-mode", Warning, "No mode exceeds the noise."),
    (
        "harmonic",
        Warning,
        "A mode lies on an order of the speed, or has the amplitude distribution of a sine: it is excitation by the running machine, not a mode. Repeat at another speed.",
    ),
    (
        "mode-on-order",
        Warning,
        "A mode lies on an order of the running speed. The sine there was removed before the identification, and the remaining peak is much wider than a spectral line, like that of a mode excited by noise. The order may still have excited it: repeat at another speed, where a mode stays.",
    ),
    (
        "few-block-rows",
        Warning,
        "The record holds too few periods of the lowest frequencies of the band, or is so short that the covariances reach over fewer lags than usual: no mode is sought below the frequency named. Take a longer record.",
    ),
    (
        "band-cut",
        Warning,
        "The band reaches beyond 0.4 of the sample rate, where filters of loggers end: no mode is sought there. Sample faster.",
    ),
    (
        "evenly-spaced",
        Warning,
        "Five or more sines are evenly spaced, like harmonics of a shaft and sidebands of a mesh, and rarely modes of a structure. Narrow poles in their series are listed with them and not as modes. State the speed, or repeat at another one.",
    ),
    (
        "many-modes",
        Warning,
        "The highest model order may be too low for the number of modes within three octaves. Compare with the peaks of --method fdd.",
    ),
    (
        "close-pair",
        Warning,
        "At one sample rate two modes are found where another shows one. Where their distance exceeds their uncertainty both are listed, else the one. Or one mode is found where the two largest singular values of the spectra both peak, as for two modes closer than their half-power width. Two modes may be hardly resolved, or one may change during the record: take a longer record, or sensors where the two shapes differ.",
    ),
    (
        "peak-without-mode",
        Warning,
        "The spectra have a peak that is neither a sine nor explained by a mode: a mode whose poles were not certain enough, or one beyond the frequencies in which modes are sought. The poles that were rejected are listed with their reasons.",
    ),
    (
        "residuals",
        Warning,
        "The residuals of the difference equation are not white, or follow the input: the model is incomplete, and the intervals are too narrow.",
    ),
    (
        "coefficients-lose-digits",
        Warning,
        "Polynomials of high degree lose digits; poles and residues do not.",
    ),
    (
        "poor-fit",
        Warning,
        "The fit misses a response by half its size or more: the modes and intervals are unreliable.",
    ),
    // Machines.
    (
        "no-load",
        Warning,
        "The mean torques determine the loaded flank of contacts with play, and no torque is stated. The contacts are taken as closed on the drive flank.",
    ),
    (
        "loads-accelerate",
        Warning,
        "The mean torques do not balance, so they accelerate the gear train.",
    ),
    (
        "implausible",
        Warning,
        "A value lies far outside the usual range, often because of its unit: a mesh stiffness a hundred times off 14 N/(mm·µm) times ten modules of face width (ISO 6336-1), a damping ratio above 0.5, also of modes or as half a loss factor (meshes have 0.03 to 0.17, Kasuba and Evans 1981), a diametral moment of inertia below half the polar one (no body has that), a module above 1 m (ISO 54 ends at 50 mm). The value is taken as written.",
    ),
    (
        "speeds-misfit",
        Warning,
        "The mean speeds stated in [speed] contradict the ratios of the machine or leave a speed undetermined. Natural frequencies at rest do not need them; motion in time, waves of stiffness and gyroscopic terms do, and are refused.",
    ),
    (
        "beyond-load-table",
        Warning,
        "A mesh that follows its load carried more at a sample than the largest of `torques` in [mesh] of its gear file. Beyond it the deflection goes on along the tangent: teeth or edges that touch only there are not in it. Give a larger last torque.",
    ),
    (
        "step-for-exact",
        Warning,
        "A step was stated, but the exact method for this machine has no step, so a method with step error was used. Omit the step, or measure the error by `geardyn accuracy`.",
    ),
    (
        "long-step",
        Warning,
        "The fixed step is long compared with the shortest period of the machine with closed contacts, or of an excitation. Beyond the stability limit of an explicit method such an oscillation grows without bound. Implicit methods stay bounded but lower its frequency or damp it, which is harmless if it is not excited. Take a shorter step, or a method that chooses its own; `geardyn accuracy` shows errors over steps.",
    ),
    (
        "coarse-samples",
        Warning,
        "The sampling interval is long compared with a period of an excitation (a load, an error or a stiffness wave), or with the oscillation of an output, judged by its slope. Extremes, means and step responses are those of the samples; values between them are missed, and an interval of whole periods samples one phase only. Request more --samples, with --no-history where only extremes are wanted.",
    ),
    (
        "handed-over",
        Warning,
        "The method that suits the structure of the machine did not converge, as where contacts chatter, and the one named took the motion from its start: its local errors keep to the tolerance, and it locates no switches. Give the contact named some damping, or name a --method.",
    ),
    (
        "not-predictable",
        Warning,
        "The motion amplifies every change of its initial state, typically by impacts after a loss of contact, until two runs whose initial states differ by a billionth of the deflections are uncorrelated. Beyond the instant given, the history, its extremes and its end value are those of one run among many (an output that keeps four digits to the end is shown); another method, tolerance or processor gives others. Uncertain digits are not shown. The mean, the rms and the percentiles over the second half hold within their intervals; a longer motion narrows them. `--no-sensitivity` saves the second run.",
    ),
    (
        "not-compared",
        Warning,
        "A second run from a perturbed initial state gives the sensitivity and the significant digits. It failed, or took far longer than the first, so that extremes may be shown with uncertain digits. Compare a run with another tolerance or method yourself, or `geardyn accuracy`.",
    ),
    (
        "unstable",
        Warning,
        "A root of the linear machine has a growth rate above zero: a small motion grows as exp(rate · t) until a nonlinearity limits it, and no steady state is reached. Growth below 1e-10 |λ| counts as none.",
    ),
    (
        "speed-terms",
        Warning,
        "The result omits terms of the machine: gyroscopic, Coriolis and centripetal ones without --speed, or circulatory or negative damping without --damped. Their size is that of the shift of a frequency they may cause.",
    ),
    (
        "contact-loss",
        Warning,
        "The linear responses of a run-up give a mesh a larger oscillating force than the mean load: its teeth would separate, which linear responses cannot describe. State the backlash and simulate, or follow the speeds by --harmonic-balance.",
    ),
    (
        "undamped",
        Warning,
        "The machine has no damping, so that its response at a natural frequency is infinite.",
    ),
    (
        "curve-lost",
        Warning,
        "A curve of periodic motions could not be followed any further: the motion may stop repeating with the excitation there.",
    ),
    (
        "doubling",
        Warning,
        "A motion of two periods begins at a period doubling. Such motions are followed where every switch can be located; elsewhere simulate in time just beyond the doubling.",
    ),
    (
        "orders-limited",
        Warning,
        "The harmonic balance needs more orders than its limit; the message gives the size of the omitted ones.",
    ),
    (
        "gyroscopic",
        Warning,
        "Gyroscopic terms are those of one speed, while the excitation covers a range of speeds.",
    ),
    (
        "contact-open",
        Warning,
        "A contact with play is open under the mean torques and has no stiffness.",
    ),
    (
        "track-coarse",
        Warning,
        "Some windows of an order track held too few samples, or the shaft turned less than one window. Request more --samples, or lengthen the motion.",
    ),
    (
        "te-latest",
        Warning,
        "A transmission error computed during a motion is that of its last million samples (limit).",
    ),
    (
        "rayleigh-brakes",
        Warning,
        "Mass-proportional damping brakes the rigid-body motion as well.",
    ),
    (
        "linearised",
        Warning,
        "A coupling or a mesh with a characteristic is linearised at the mean loads; motion in time uses the whole curve.",
    ),
    (
        "idle-damping",
        Warning,
        "A damping ratio is stated for a branch without mass at one end, and damps nothing.",
    ),
    (
        "unsupported",
        Warning,
        "A body has lateral degrees of freedom without a support: a rigid-body mode.",
    ),
    (
        "assembly",
        Warning,
        "The planets of a stage cannot be mounted at even angles with these tooth numbers.",
    ),
    (
        "worm-efficiency",
        Warning,
        "Efficiency of a worm pair from its lead, pressure angle and friction.",
    ),
    (
        "loop-misfit",
        Warning,
        "Errors of joints that close a loop do not fit each other: with rigid joints the loop could not turn. The elastic joints deform to accommodate them, and the table is computed with these.",
    ),
    (
        "still",
        Warning,
        "An error is declared on an element that does not turn with the output, so that it has no order.",
    ),
    (
        "belt",
        Warning,
        "Orders of elements separated from the output by a friction belt are only as accurate as its diameters, and drift with its slip.",
    ),
    (
        "not-counted",
        Warning,
        "The number of modes found could not be confirmed by counting.",
    ),
    (
        "branch-uncertain",
        Warning,
        "A branch of the Campbell diagram could not be followed with certainty.",
    ),
    // Measured gears.
    (
        "outside-standard",
        Warning,
        "The gear lies outside the range of sizes for which the standard states its formulas, so it has no limit for the value. The formulas are not extrapolated.",
    ),
    (
        "readings-small",
        Warning,
        "The total deviation of a chart, of profiles and helices the span of the readings, is less than a tenth of what the finest grade of ISO 1328 allows, which no gear reaches. Readings in mm whose unit is stated as µm are a thousand times too small.",
    ),
    (
        "limit-uncertain",
        Warning,
        "The value lies nearer to its limit than the 95 % interval of its uncertainty: conformity is uncertain.",
    ),
    // Gears.
    (
        "undercut",
        Warning,
        "The tool, or the mating flank of a non-circular gear, cuts off part of a flank. The message or the hint names what avoids it: a profile shift coefficient, or the radius at which the flank should end.",
    ),
    (
        "interference",
        Warning,
        "The tip of one gear reaches where the other has no involute: inside its base circle, into its fillet or its relieved root, or, inside a ring, outside the path of contact; or a worm, a disk tool or a crossed gear cuts into the flank of its mate away from the contact. The message names the nearest tip diameter that avoids it, or the depth and the place.",
    ),
    (
        "cones-apart",
        Warning,
        "The pitch cones of both blanks do not touch on the axes of the pair: shaft angle, offset and cones are not those of one pair. The message gives the gap or the overlap; nothing is computed at a pitch point.",
    ),
    (
        "no-slot",
        Warning,
        "The slot that a blank design leaves between two teeth has no width at its root, so that no blade can cut it. The message gives the minimum width along the face and its place.",
    ),
    (
        "no-contact",
        Warning,
        "The flanks of a bevel pair do not touch near the middle of their teeth, or at some angles no pair of teeth touches: the transmission error is undefined there.",
    ),
    (
        "no-reference",
        Warning,
        "Nowhere on the flanks is the ratio that of the tooth numbers: the contact where it is nearest is taken as reference of pattern and transmission error.",
    ),
    (
        "overlap",
        Warning,
        "The teeth of a bevel pair overlap away from the path of contact, as towards a corner where twist makes the ease-off negative. Unloaded transmission error and pattern are those of the path alone; the loaded contact (`--torque`) covers the whole flank.",
    ),
    (
        "contact-ratio",
        Warning,
        "The total contact ratio is below 1: a pair of teeth leaves contact before the next one touches, so that the motion is not transmitted uniformly.",
    ),
    (
        "rigid-teeth",
        Warning,
        "The loaded contact of a bevel pair is computed with half spaces only: the flanks or the thickness that the bending of the teeth needs are not described. The pair is too stiff.",
    ),
    (
        "edge-contact",
        Warning,
        "Under load the tips or ends of the teeth carry a share of the torque. The pressure on an edge has no bound in this model and is not in the table; crowning or another assembly keeps the contact on the flanks.",
    ),
    (
        "short-cells",
        Warning,
        "The cells along the face are shorter than the contact is wide there, so that its pressure is not resolved. Give fewer stations.",
    ),
    (
        "ellipse-beyond-teeth",
        Warning,
        "A contact with a/b below 2.9 is computed by the closed form of an ellipse, and this ellipse reaches beyond the end of the teeth. Its approach and pressure are those of a whole ellipse.",
    ),
    (
        "short-contact",
        Warning,
        "At some position the contact covers so few stations that approach and pressure are off by more than 2 %. Give more stations.",
    ),
    (
        "not-converged",
        Warning,
        "The settings of a correction did not converge. Check member, flank and the sign of the deviations, or free fewer settings.",
    ),
    (
        "large-change",
        Warning,
        "A setting of the next cut would change by far more than errors of a machine explain. Check member, flank and units, or free fewer settings.",
    ),
    (
        "nothing-changes",
        Warning,
        "No combination of the settings that may be changed moves the flank by as much as `least`: the next cut has the present settings. Free other settings.",
    ),
    (
        "no-better",
        Warning,
        "With the dial steps of the machine the deviations of the next cut are no smaller than the measured ones: keep the settings, use finer steps, or free other settings.",
    ),
    (
        "other-flank",
        Warning,
        "One flank is measured, and the machine cuts the other one at the same settings: the correction changes it by an amount that the grid does not determine. Measure both flanks.",
    ),
    (
        "slot-depth",
        Warning,
        "The settings of the next cut make the slot deeper or shallower by more than a hundredth of the depth of the tooth, so that root, clearance and the height at which the blade ends change. With a target ease-off the depth of the present settings is constrained with about a tenth of the weight of the flank.",
    ),
    (
        "outlier",
        Warning,
        "A measured deviation departs from the median of those around it by more than twelve times the typical departure in the grid, and by more than 5 µm: dirt, or a wrong digit. It distorts the settings. Measure the node again, or omit it.",
    ),
    (
        "narrow-grid",
        Warning,
        "The nodes of a grid span less than a quarter of the face or of the height: deviations along it are not known. Measure a grid over the whole flank, such as 5 × 9 nodes.",
    ),
    (
        "nodes-off-flank",
        Warning,
        "Nodes of a measured grid outside the flank are left out. Measure above the fillet and within the blank.",
    ),
    (
        "pointed",
        Warning,
        "The flanks of a tooth meet before the tip cylinder. The tooth ends there. A blank design without flanks gives the top land instead, below zero at the stated end.",
    ),
    (
        "clearance",
        Warning,
        "The tip of one gear reaches the root circle of the other.",
    ),
    (
        "no-backlash",
        Warning,
        "At the limits of centre distance and tooth thickness, or at the mean points of a bevel pair, the teeth would overlap.",
    ),
    (
        "other-spiral",
        Warning,
        "A flank of a bevel gear has another spiral angle at its mean point than its blank was designed for, by more than 2°: one of them belongs to another gear.",
    ),
    (
        "folded",
        Warning,
        "A flank turns back on itself: no tooth can be cut with it. End the given flank before that place.",
    ),
    (
        "law-of-gearing",
        Warning,
        "The common normal of the flanks misses the pitch point, so that the ratio is not that of the law.",
    ),
    (
        "contact-ends",
        Warning,
        "A part of a profile or flank has no contact: its normals do not meet the pitch curve, the cutter does not reach it, or the contact extends beyond the face.",
    ),
    (
        "double-contact",
        Warning,
        "Contact lines of cutter and flank have an envelope on the cutter, the limit of the second kind: on one side of it every point of the blade touches twice and makes two parts of the flank, on the other never. The flank is whole, the blade wears on one side.",
    ),
    (
        "readings-misfit",
        Warning,
        "Even the standard gear that fits the readings best misses one of them by more than three standard uncertainties: a reading or its uncertainty is wrong, or the gear is not of a standard size.",
    ),
    (
        "not-separated",
        Warning,
        "The readings agree with several standard gears alike: their misfits differ by less than three standard uncertainties of one reading. The result names the reading that would separate them.",
    ),
    (
        "stiffness-range",
        Warning,
        "The pair lies outside the range for which the stiffness method was fitted.",
    ),
];
