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
        "The column of time stamps, or their unit, is not certain: a column without a name rises evenly, or one named as a time without a unit counts 0, 1, 2, … Say which it is: --time COLUMN or --time none, --time-unit ms, or in the sidecar.",
    ),
    (
        "time-rounded",
        Warning,
        "The time stamps are too coarse to judge single steps. The samples are taken as evenly spaced, which the record as a whole bears out.",
    ),
    (
        "time-jitter",
        Warning,
        "The time stamps lie unevenly and the samples were resampled. Above the stated band the values rest on the interpolation.",
    ),
    (
        "frequency-guessed",
        Warning,
        "The table has no names. Its first column rises by even steps, and the inverse transforms of the others lie at positive times only, as those of frequency responses do and those of signals do not: they are taken for real and imaginary parts, or magnitudes and phases, over frequencies in Hz. Name the columns, or state which is the time: --time.",
    ),
    (
        "decimal-comma",
        Warning,
        "Every comma of the text precedes three digits, so it may be a decimal mark or separate thousands. State it: --decimal.",
    ),
    (
        "names-misfit",
        Warning,
        "The line of names has another number of words than the rows have cells, so no name can be given to a column. Columns are numbered; mend the line, or state --delimiter and --decimal.",
    ),
    (
        "rate-disagrees",
        Warning,
        "Another sample rate of the log differs by more than 0.1 % from the one taken: a stated --rate from the time stamps or the header, a line of the header from the stamps, or a bare `rate`, which of a rotating machine may be the speed of a shaft, from the rate of samples. State the right one: --rate.",
    ),
    (
        "header-rate-mark",
        Warning,
        "The header states a sample rate whose only mark precedes three digits and is not the decimal mark of the file's numbers. It is taken for the mark of thousands; the rate would be a thousandth of it otherwise. State it: --rate.",
    ),
    (
        "header-rate-unread",
        Warning,
        "The header states a sample rate that cannot be read with certainty: an unknown unit, a tail, a number below zero. The time stamps give the rate, and nothing was compared with it.",
    ),
    (
        "date-order",
        Warning,
        "Every date of the log can be read with the day first or with the month first. What passed since the first sample is the same either way; the date of the beginning is not known. Say which comes first: --day-first or --month-first, or `dates` in the sidecar.",
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
        "A channel holds one value for a long time although it moves before or after: its sensor, cable or recorder failed. `identify` leaves that time out where another channel shows that the structure moved.",
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
        "Functions of the file are of a kind that is not read, or lie over other lines than the rest.",
    ),
    (
        "values-missing",
        Warning,
        "A data set holds fewer values than its header states.",
    ),
    (
        "local-axes",
        Warning,
        "Nodes of the UFF file lie or move in coordinate systems of their own, which are not read. Shapes of these nodes point along the wrong axes.",
    ),
    (
        "channel-unplaced",
        Warning,
        "The geometry of the test places some of the response channels and not these, which do not move in the shapes on points. State `point` and `direction` of their [[channel]].",
    ),
    (
        "another-clock",
        Warning,
        "The file holds channels of several clocks: other rates, lengths or beginnings. Channels of one clock are analysed together; the others are reached by their names.",
    ),
    (
        "name-twice",
        Warning,
        "Two variables or channels of the file have one name. Both are kept, the second numbered.",
    ),
    (
        "coherence-above-one",
        Warning,
        "A coherence of the file is larger than one, which no coherence is. Its values are kept as they are.",
    ),
    (
        "coherence-left-out",
        Warning,
        "A coherence of the file belongs to no response of it.",
    ),
    // What was done to a log.
    (
        "row-incomplete",
        Repair,
        "The last row of the log breaks off: it has too few cells, its last cell is the beginning of a number, or storage after it was never written, as where a logger is switched off. The row was left out. A row that breaks off anywhere else is an error.",
    ),
    (
        "header-repeated",
        Repair,
        "Lines of the header are repeated between the rows, as where a logger was started anew or files were joined. They were passed over and the rows joined; only time stamps give the time that passed there.",
    ),
    (
        "sidecar",
        Repair,
        "The sidecar of the log (its name with .toml) was read and applied. --no-sidecar ignores it.",
    ),
    (
        "files-joined",
        Repair,
        "The files are records of one test. Each lies in segments of its own, no average reaches from one to the next, and each hit counts once.",
    ),
    (
        "gap-split",
        Repair,
        "Samples are missing. The record falls into segments there, and no average reaches across. --fill-gaps bridges them instead.",
    ),
    (
        "triggered",
        Repair,
        "What lies before the level of --trigger was left out, but for what --pre-trigger keeps. The level is compared with the size of the numbers as the log has them.",
    ),
    (
        "gap-filled",
        Repair,
        "Straight lines were laid over missing samples, as requested.",
    ),
    (
        "resampled",
        Repair,
        "Samples at uneven times were brought to even steps by band-limited interpolation.",
    ),
    (
        "cells-missing",
        Repair,
        "Cells hold no number. Segments end there, in every channel.",
    ),
    (
        "thousands-joined",
        Repair,
        "Numbers were written with separators of thousands, which were taken out.",
    ),
    (
        "column-left-out",
        Repair,
        "A column is no channel: a counter, or one that holds words or nothing.",
    ),
    (
        "channel-empty",
        Repair,
        "A channel holds no number and was left out.",
    ),
    (
        "footer-skipped",
        Repair,
        "Lines after the rows of numbers were passed over.",
    ),
    (
        "rows-of-another-dialect",
        Repair,
        "Rows of numbers with another delimiter or decimal mark precede the rows that were read, and were passed over: two exports in one file. Bring them into one form.",
    ),
    (
        "lines-skipped",
        Repair,
        "Lines outside of the data were passed over.",
    ),
    (
        "sets-skipped",
        Repair,
        "Data sets of other kinds than UFF 58 were passed over.",
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
        "Nothing rises above the floor. The strongest line is shown although noise could make it.",
    ),
    (
        "no-band",
        Warning,
        "An envelope without --band is that of the whole signal, in which bursts are hidden.",
    ),
    (
        "longest-segment",
        Warning,
        "Gaps split the record, and the method needs one piece: the longest is analysed.",
    ),
    (
        "tacho-pulses",
        Warning,
        "Pulses of the tacho are missing, doubled or uneven, or their number a turn seems to be another than stated with --pulses.",
    ),
    // Encoder records.
    (
        "mesh-above-band",
        Warning,
        "A mesh order lies above the highest order that the rows resolve, and was not evaluated. Read the encoders more often, or turn more slowly.",
    ),
    (
        "counts-repaired",
        Warning,
        "An encoder lost counts or counted too many; the step this makes was taken out, because --repair was given.",
    ),
    (
        "index-pulses",
        Warning,
        "Some index pulses of an encoder are missing or come before a whole turn has passed. Those are ignored. A pulse narrower than a row is missed by the rows; noise on the line makes others.",
    ),
    (
        "step-without-counts",
        Warning,
        "The transmission error steps and stays where it is, and the index pulses show that both encoders counted correctly: a seat, a coupling or an encoder moved. The step is left in the record.",
    ),
    (
        "direction-too-short",
        Warning,
        "In one direction the record turns less than a whole turn of every shaft, in addition to the play: that direction is not evaluated, and the angles that both directions passed serve for the play alone.",
    ),
    (
        "input-uneven",
        Warning,
        "The input of an encoder record does not turn evenly at the orders of declared errors: its driver is free and responds to the meshes. Its motion is in the record; its share in the output is removed through the model.",
    ),
    // Identification.
    (
        "poles-differ",
        Warning,
        "The files of a roving test do not share their poles: a mode is seen in one file alone, where all others show it at another frequency, or a file places it elsewhere by more than its noise explains. The structure was not the same: the mass of the sensor, the mounting or the temperature changed. One set of modes does not describe such files; repeat the named one, or leave it out.",
    ),
    (
        "no-decay",
        Warning,
        "Some files of the test ring down after a release and others do not: their motion is driven, and a fit of free decays takes it for a decay. Leave those files out.",
    ),
    (
        "one-segment",
        Warning,
        "Gaps split the record, and the method needs one piece: the longest is used.",
    ),
    (
        "one-average",
        Warning,
        "There is one average, so no variance and no coherence.",
    ),
    (
        "few-averages",
        Warning,
        "The variance is known to a factor of two at best, and the intervals with it; of fewer than three and a half averages no interval is stated.",
    ),
    (
        "coherent-inputs",
        Warning,
        "The inputs cannot be separated: one follows the other.",
    ),
    (
        "closed-loop",
        Warning,
        "The input has peaks at the modes: the motion feeds the force, and the responses are those of the loop.",
    ),
    (
        "aliasing",
        Warning,
        "A channel has as much power near half the sample rate as below: it was sampled without a filter, and what lies above is folded down. Of a hammer: the spectrum of its force does not fall by 30 dB up to half the rate, so that it drives resonances above, which appear below unless a filter removed them. The residues of such a resonance differ from hit to hit, and three hits or more tell it from a mode; where the pulse lasts one sample all modes are listed as weak.",
    ),
    (
        "transmissibility",
        Warning,
        "Motion over motion: its poles are those of the structure held at the input, not its modes.",
    ),
    (
        "inverse-response",
        Warning,
        "Force over motion: its poles are the frequencies at which the force moves nothing there, zeros of the structure's response, not its modes. Swap --input and --output.",
    ),
    (
        "low-coherence",
        Warning,
        "The response at a mode is mainly noise, or comes from another source than the input.",
    ),
    (
        "leakage",
        Warning,
        "A resonance is narrower than three lines of averaged blocks, or than one and a half windows of local parabolas over several blocks, so the block it was measured in broadens it. Take longer blocks, --resolution, or a longer record.",
    ),
    (
        "coarse-lines",
        Warning,
        "Fewer than four lines of a stepped sine, or of a file of responses, lie within the half-power width of a mode. Its pole rests on the form of the fit between lines: leakage of whoever estimated the responses, a second mode, or a value that is off would not be seen, and intervals hold none of these.",
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
        "The criterion still falls at the highest order that was tried: the search ended, not the evidence. State a higher --order, or narrow the band.",
    ),
    (
        "departs",
        Warning,
        "Noise alone does not explain the responses. Poles were identified with a variance that includes the departure of each mode from the linear model, and the intervals include it. Usual causes: sensor mass, mounting, leakage, dependence on amplitude or temperature.",
    ),
    (
        "residual-delay",
        Warning,
        "The phases of a response's residues fall in proportion to frequency, from mode to mode: one channel is late, by an anti-alias filter that the other does not have or by its converter. The message gives the delay with its 95 % interval (negative: the input is late) and its phase at the top of the band. It turns the mode shapes; --delay common or --delay each takes it off.",
    ),
    (
        "few-hits",
        Warning,
        "Fewer than three hits were used. The intervals of one hit include the noise and the departure from the model, but not the scatter between hits, which on real structures is often larger. Where two hits differ by more than their noise, frequency and damping are their means, and the interval is 12.7 standard errors (Student's t with one degree of freedom): wide, but it holds the mean over all possible hits. Three hits give a usable interval, five a good one.",
    ),
    (
        "driving-point",
        Warning,
        "A modal mass is no positive number: force and motion at the driving point do not belong together, or one of them is turned round.",
    ),
    (
        "uncalibrated",
        Warning,
        "Units that are not those of force and motion give no modal masses.",
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
        "The search ended at the most pole pairs allowed, or at as many operations as some seconds are for. The largest modes are found first; narrow the band for the others: --band.",
    ),
    (
        "no-mode",
        Warning,
        "Nothing rises above the noise as a mode.",
    ),
    (
        "harmonic",
        Warning,
        "A mode lies on an order of the speed, or is distributed like a sine: it is the machine's running, not its structure. Repeat at another speed.",
    ),
    (
        "mode-on-order",
        Warning,
        "A mode lies on an order of the running speed. The sine there was removed before the identification, and the remaining peak is much wider than a spectral line, as a mode excited by noise is. The order may still have excited it: repeat at another speed, where a mode stays.",
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
        "Five or more sines are evenly spaced, as harmonics of a shaft and sidebands of a mesh are, and the modes of a structure hardly ever. Narrow poles in their series are listed with them and not as modes. State the speed, or repeat at another one.",
    ),
    (
        "many-modes",
        Warning,
        "So many modes lie within three octaves that the highest order of the models may not hold all of them. Compare with the peaks of --method fdd.",
    ),
    (
        "close-pair",
        Warning,
        "At one sample rate two modes are found where another shows one. Where their distance exceeds their uncertainty both are listed, else the one. Or one mode is found where the two largest singular values of the spectra both peak, as under two modes nearer to each other than they are wide. Two modes may be hardly resolved, or one may change during the record: take a longer record, or sensors where the two shapes differ.",
    ),
    (
        "peak-without-mode",
        Warning,
        "The spectra show a peak that is no sine, and no mode explains it: a mode whose poles were not certain enough, or one beyond the frequencies in which modes are sought. The poles that were rejected are listed with their reasons.",
    ),
    (
        "residuals",
        Warning,
        "The residuals of the difference equation are not white, or follow the input: something is not modelled, and the intervals are too narrow.",
    ),
    (
        "coefficients-lose-digits",
        Warning,
        "Polynomials of high degree lose digits that poles and residues keep.",
    ),
    (
        "poor-fit",
        Warning,
        "The fit misses a response by half its size or more: modes and intervals rest on what it does not describe.",
    ),
    // Machines.
    (
        "no-load",
        Warning,
        "Contacts with play carry on the flank to which the mean torques press them, and no torque is stated. They are taken as closed on the drive flank.",
    ),
    (
        "loads-accelerate",
        Warning,
        "The mean torques do not balance, so the train speeds up under them.",
    ),
    (
        "implausible",
        Warning,
        "A value lies far outside the usual range, often because of its unit: a mesh stiffness a hundred times off 14 N/(mm·µm) times ten modules of face width (ISO 6336-1), a damping ratio above 0.5, also of modes or as half a loss factor (meshes have 0.03 to 0.17, Kasuba and Evans 1981), a diametral moment of inertia below half the polar one (no body has that), a module above 1 m (ISO 54 ends at 50 mm). The value is taken as written.",
    ),
    (
        "speeds-misfit",
        Warning,
        "The mean speeds stated in [speed] contradict the ratios of the machine or leave a part open. Natural frequencies at rest do not need them; motion in time, waves of stiffness and gyroscopic terms do, and refuse them.",
    ),
    (
        "beyond-load-table",
        Warning,
        "A mesh that follows its load carried more at a sample than the largest of `torques` in [mesh] of its gear file. Beyond it the deflection goes on along the tangent: teeth or edges that touch only there are not in it. Give a larger last torque.",
    ),
    (
        "step-for-exact",
        Warning,
        "A step was stated, and the method that is exact for the machine takes none, so a method with step error was used. Omit the step, or let `geardyn accuracy` show how large the error is.",
    ),
    (
        "long-step",
        Warning,
        "The fixed step is long compared with the shortest period of the machine with closed contacts, or of what acts on it. Beyond the stability limit of an explicit method such an oscillation grows without bound. Implicit methods stay bounded but lower its frequency or damp it, which is harmless if it is not excited. Take a shorter step, or a method that chooses its own; `geardyn accuracy` shows errors over steps.",
    ),
    (
        "coarse-samples",
        Warning,
        "The sampling interval is long compared with a period of what acts on the machine (a load, an error or a stiffness wave), or with the oscillation of an output, judged by its slope. Extremes, means and step responses are those of the samples; values between them are missed, and an interval of whole periods samples one phase only. Request more --samples, with --no-history where only extremes are wanted.",
    ),
    (
        "handed-over",
        Warning,
        "The method that suits the structure of the machine did not converge, as where contacts chatter, and the one named took the motion from its start: its local errors keep to the tolerance, and it locates no switches. Give the contact named some damping, or name a --method.",
    ),
    (
        "not-predictable",
        Warning,
        "The motion amplifies every change of its start, as impacts after a loss of contact do, until two runs whose starts differ by a billionth of the deflections have nothing in common. Beyond the instant given, the history, its extremes and its end value are those of one run among many (an output that keeps four digits to the end is shown); another method, tolerance or processor gives others. Digits that do not hold are not shown. The mean, the rms and the percentiles over the second half hold within their intervals; a longer motion narrows them. `--no-sensitivity` saves the second run.",
    ),
    (
        "not-compared",
        Warning,
        "A second run from a perturbed initial state gives the sensitivity and the digits that hold. It failed, or took far longer than the first, so that extremes are shown with digits that may not hold. Compare a run with another tolerance or method yourself, or `geardyn accuracy`.",
    ),
    (
        "unstable",
        Warning,
        "A root of the linear machine has a growth rate above zero: a small motion grows as exp(rate · t) until a nonlinearity limits it, and no steady state is reached. Growth below 1e-10 |λ| counts as none.",
    ),
    (
        "speed-terms",
        Warning,
        "The result omits terms of the machine: gyroscopic, Coriolis and centripetal ones without --speed, or damping that circulates or feeds without --damped. Their size is that of the shift of a frequency they may cause.",
    ),
    (
        "contact-loss",
        Warning,
        "The linear responses of a run-up give a mesh a larger oscillating force than the mean loads: its teeth would part there, which the responses do not follow. State the backlash and simulate, or follow the speeds by --harmonic-balance.",
    ),
    (
        "undamped",
        Warning,
        "The machine has no damping, so that its response at a natural frequency is infinite and no peak has a height.",
    ),
    (
        "curve-lost",
        Warning,
        "A curve of periodic motions could not be followed any further: the motion may stop repeating with the excitation there.",
    ),
    (
        "doubling",
        Warning,
        "A motion of two periods begins at a period doubling. Such motions are followed where every switch can be located; simulate in time just beyond the doubling to see one elsewhere.",
    ),
    (
        "orders-limited",
        Warning,
        "The harmonic balance would need more orders than its limit; the message gives the size of the omitted ones.",
    ),
    (
        "gyroscopic",
        Warning,
        "Gyroscopic terms are kept as they are at one speed while the excitation passes through a range of speeds.",
    ),
    (
        "contact-open",
        Warning,
        "A contact with play is open under the mean torques and has no stiffness.",
    ),
    (
        "track-coarse",
        Warning,
        "Some windows of an order track held too few samples, or the shaft turned less than one window. Ask for more --samples.",
    ),
    (
        "te-latest",
        Warning,
        "A transmission error found while a motion runs is that of its last million samples: no more are kept.",
    ),
    (
        "rayleigh-brakes",
        Warning,
        "Mass-proportional damping brakes the rigid-body motion as well.",
    ),
    (
        "linearised",
        Warning,
        "A coupling or a mesh with a characteristic is taken by its tangent where the mean loads put it; motion in time takes the whole curve.",
    ),
    (
        "idle-damping",
        Warning,
        "A damping ratio is stated for a branch without mass at one end, and damps nothing.",
    ),
    (
        "unsupported",
        Warning,
        "A body moves sideways without a support, which is a rigid-body mode.",
    ),
    (
        "assembly",
        Warning,
        "The planets of a stage cannot be mounted at even angles with these tooth numbers.",
    ),
    (
        "worm-efficiency",
        Warning,
        "What efficiency the lead, the pressure angle and the friction of a worm pair give.",
    ),
    (
        "loop-misfit",
        Warning,
        "Errors of joints that close a loop do not fit each other: with rigid joints the loop could not turn. The elastic joints share them out, and the table is theirs.",
    ),
    (
        "still",
        Warning,
        "An error is declared on an element that does not turn with the output, so that it has no order.",
    ),
    (
        "belt",
        Warning,
        "Orders of what lies across a friction belt from the output are as good as its diameters, and wander with its slip.",
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
        "The gear lies outside the range of sizes for which the standard states its formulas, so there is no limit to hold the value against. None is made up by extending the formulas.",
    ),
    (
        "readings-small",
        Warning,
        "The total deviation of a chart, of profiles and helices the span of the readings, is less than a tenth of what the finest grade of ISO 1328 allows, which no gear reaches. Readings in mm whose unit is stated as µm are a thousand times too small.",
    ),
    (
        "limit-uncertain",
        Warning,
        "The value lies nearer to its limit than the 95 % interval of its uncertainty: whether the gear keeps the limit is not certain either way.",
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
        "The slot that a blank design leaves between two teeth has no width at its root, so that no blade cuts it. The message gives the width, its least along the face, and the place.",
    ),
    (
        "no-contact",
        Warning,
        "The flanks of a bevel pair do not touch near the middle of their teeth, or at some angles no pair of teeth touches: no transmission error follows there.",
    ),
    (
        "no-reference",
        Warning,
        "Nowhere on the flanks is the ratio that of the tooth numbers: the contact where it is nearest is taken as reference of pattern and transmission error.",
    ),
    (
        "overlap",
        Warning,
        "The teeth of a bevel pair overlap away from the path of contact, as towards a corner where twist lets the ease-off fall below zero. Unloaded transmission error and pattern are those of the path alone; the loaded contact (`--torque`) covers the whole flank.",
    ),
    (
        "contact-ratio",
        Warning,
        "The total contact ratio is below 1: a pair of teeth leaves contact before the next one touches, so that the motion is not transmitted evenly.",
    ),
    (
        "rigid-teeth",
        Warning,
        "The loaded contact of a bevel pair has half spaces alone: the flanks or the thickness that the bending of the teeth needs are not described. The pair is too stiff.",
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
        "The settings of a correction did not settle. Check member, flank and the sign of the deviations, or free fewer settings.",
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
        "On the steps of its dials the next cut would leave deviations no smaller than the measured ones: leave the settings, take finer steps, or free other settings.",
    ),
    (
        "other-flank",
        Warning,
        "One flank is measured, and the machine cuts the other one at the same settings: it moves with the correction, by how much the grid does not tell. Measure both flanks.",
    ),
    (
        "slot-depth",
        Warning,
        "The settings of the next cut make the slot deeper or shallower by more than a hundredth of the depth of the tooth, so that root, clearance and the height at which the blade ends change. A wanted ease-off holds the depth of the present settings to about a tenth as strictly as the flank.",
    ),
    (
        "outlier",
        Warning,
        "A measured deviation departs from the median of those around it by more than twelve times what is usual in the grid, and by more than 5 µm: dirt, or a wrong digit. It pulls the settings. Measure the node again, or leave it out.",
    ),
    (
        "narrow-grid",
        Warning,
        "The nodes of a grid span less than a quarter of the face or of the height: deviations along it are not known. Measure a grid over the whole flank, such as 5 × 9 nodes.",
    ),
    (
        "nodes-off-flank",
        Warning,
        "Nodes of a measured grid where the blade leaves no flank are left out. Measure above the fillet and within the blank.",
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
        "A part of a profile or flank has no contact: its normals do not meet the pitch curve, the cutter does not reach it, or the contact leaves the face.",
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
