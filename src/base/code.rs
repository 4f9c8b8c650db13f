//! Error codes: the word shown to users, the exit code and the text of `geardyn explain`.

/// Declares every code once: its word, the exit code of a command it ends, and what `geardyn explain` says of it.
macro_rules! codes {
    ($($name:ident $word:literal $exit:literal $explanation:literal)*) => {
        /// Code of an error kind.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        pub enum Code { $(#[doc = concat!("`", $word, "`: `geardyn explain` prints it in full.")] $name,)* }

        impl Code {
            /// Every code, in the order of this table.
            pub const ALL: &'static [Code] = &[$(Code::$name,)*];

            /// The word users see in brackets.
            pub fn as_str(self) -> &'static str {
                match self { $(Code::$name => $word,)* }
            }

            /// The exit code of a command it ends: 2 for bad input, 3 for numerical failure, 130 for an interrupt.
            pub fn exit_code(self) -> u8 {
                match self { $(Code::$name => $exit,)* }
            }

            /// Full explanation: meaning and remedy.
            pub fn explanation(self) -> &'static str {
                match self { $(Code::$name => $explanation,)* }
            }
        }
    };
}

codes! {
    // files
    FileMissing "file-missing" 2 "The file could not be found or opened, or permission is denied. Paths of the command line are relative to the working folder, those of a file to its own folder."
    FileTooLarge "file-too-large" 2 "The file is larger than 64 MB, the limit for model files, and was not read. Check whether the right file was named."
    NotText "not-text" 2 "The file is not UTF-8 text. Save it as UTF-8 in your editor."
    Syntax "syntax" 2 "The file is not valid TOML. Text after the place shown was not checked."
    // keys and values
    UnknownKey "unknown-key" 2 "The table has no such key. The reference of model files lists every key; `geardyn new` writes a model that shows the usual ones."
    MissingKey "missing-key" 2 "The table lacks a required key."
    DuplicateName "duplicate-name" 2 "Names must be unique over all tables of a file, because results name elements."
    UnknownNode "unknown-node" 2 "An end of a branch names a node that no [[inertia]], [[chain]] or segmented shaft declares. A massless node is an [[inertia]] with J = \"0 kg·m²\"."
    WrongType "wrong-type" 2 "The value has the wrong type for the key: text, number, list or table."
    MissingUnit "missing-unit" 2 "A quantity is text with a unit, such as \"85 kN/mm\". Numbers without a unit are SI only if `units = \"SI\"` is at the top of the file."
    WrongUnit "wrong-unit" 2 "The unit has the wrong dimension for the key, or is unknown."
    OutOfRange "out-of-range" 2 "The value is impossible: a negative inertia, a gear without teeth, a number that is not finite, a bore wider than the shaft."
    Conflict "conflict" 2 "Two entries of the file contradict each other, such as a stiffness given and computed from geometry, or damping of a rigid branch, which never deforms."
    // the machine
    EmptyMachine "empty-machine" 2 "The model has no inertia, so nothing can move."
    Disconnected "disconnected" 2 "The element is not connected to the machine: a massless node without a branch with stiffness has no equation of motion."
    ContradictoryRatios "contradictory-ratios" 2 "The ratios of rigid gear pairs in a closed loop must multiply to one; otherwise the loop is locked. Make one pair elastic (give it k) or correct its tooth numbers."
    UnknownDof "no-such-dof" 2 "The node has no degree of freedom along that axis: lateral and tilting axes exist only where a bearing gives the node one."
    UndeterminedSpeed "no-speed" 2 "The computation needs the shaft speeds, and the model does not determine them: nothing can turn, or several parts turn independently of each other. State speeds in [speed]."
    // logs
    UnknownFormat "unknown-format" 2 "The file has none of the supported log formats: delimited text (CSV, TSV and similar), LabVIEW LVM, UFF 58, WAV, MATLAB level 5; each also inside gzip or zip. The message says what its first bytes look like."
    CorruptFile "broken-file" 2 "The file begins as a known format and then violates it: it was truncated, damaged or written by a program that deviates from the format."
    EmptyLog "empty-log" 2 "The log has no samples: the file is empty, has only a header, or contains only spectra or frequency responses, which `geardyn spectrum` and `geardyn identify` read."
    RaggedRow "ragged-row" 2 "A row of numbers has more or fewer cells than the rows before it. Rows are never truncated, padded or skipped; correct the file, or state the delimiter and the decimal mark where they were misread."
    NotANumber "not-a-number" 2 "A cell of a channel holds text. Blank cells, NaN and overload words are read as missing samples; other text is an error."
    InvalidTimeStamps "bad-time" 2 "The time stamps repeat, decrease or jump implausibly far, so that the order of the samples is uncertain; or they are so uneven that lost samples cannot be distinguished from late stamps, or that the samples cannot be resampled evenly within 10 %. Sort or cut the log at the line named, log at a constant rate, or ignore the stamps: --time none --rate HZ."
    RateUnknown "rate-unknown" 2 "Neither time stamps nor the header give the sample rate, or the header states it ambiguously: with a unit that is not of a rate, trailing text, or digits that may be one number or several. State it: --rate 5000, or `rate` in the sidecar."
    RateDisagrees "rate-disagrees" 2 "The sample rates that the file states, or those and the rate of its time stamps, differ by more than 0.1 %; or the files of one test have rates that differ by more than 0.01 %. State the right one: --rate-from time, --rate-from header, or --rate."
    NoChannel "no-channel" 2 "The log has no channel of that name. `geardyn check LOG` lists the channels."
    UnknownPoint "unknown-point" 2 "A line or a channel names a point that no [[point]] of the sidecar declares."
    NoSignal "no-signal" 2 "The channel has no signal: its samples are all zero, constant or missing."
    TooShort "too-short" 2 "The record has fewer samples than the analysis needs."
    RatioMismatch "ratio-mismatch" 2 "The ratio measured by the two encoders differs from that of the tooth numbers. The message gives the measured ratio. Check --teeth (driver first), the lines of both encoders, and whether input and output are interchanged."
    Slip "slip" 2 "Something slips between the two encoders: their ratio is constant for most of the record and then changes. Check couplings, clamps and belts, and select a segment without slip."
    LostCounts "lost-counts" 2 "An encoder lost counts or counted too many, so that its angle is wrong from that point on. The message gives place and number. Select a segment without such a step, or remove the steps with --repair."
    Usage "usage" 2 "The arguments of the command are invalid. See its --help."
    OutputFailed "output-failed" 2 "The output file could not be written: its folder is missing or not writable, the disk is full, or the name is a link that does not resolve. No partly written file remains, and no file of the run is replaced."
    // numbers
    NotPositiveDefinite "indefinite" 3 "The mass matrix is not positive definite, so the modes are not defined. A consistent mass or a rigid joint has left a combination of degrees of freedom without inertia."
    NoConvergence "no-convergence" 3 "An iteration did not converge to its tolerance. The message names it and its last state. For a motion: take another --method (radau5 for stiff machines, dop853-events for contacts), a coarser --tolerance, or a smaller --step; if something jumps at that instant, give it a short ramp. For modes: request fewer, or those near a frequency."
    Overflow "overflow" 3 "Values of the model differ so much that their products exceed the range of double precision (1e-308 to 1e308). Check the units of the values named."
    IllPosed "ill-posed" 3 "The data do not determine the unknowns: the equations of the fit are singular, or there are fewer independent values than unknowns."
    Interrupted "interrupted" 130 "An interrupt (Ctrl-C, SIGTERM or SIGHUP) ended the run before any result was complete. Results completed before an interrupt are shown, with the same exit code. Output files are unchanged."
    BudgetExceeded "budget-exceeded" 3 "The request exceeds the limit of memory or time. The message says what to request instead."
}

impl Code {
    /// The code of a word, if there is one.
    pub fn parse(word: &str) -> Option<Code> {
        Code::ALL.iter().copied().find(|code| code.as_str() == word)
    }
}
