//! Flags of `te`.

use std::path::PathBuf;

use clap::Args;

use super::keys::{Key, KeyFlags, KeyGroups, KeyTable, file, list, number, switch, text};
use super::log::LogArgs;
use super::output::OutputArgs;

/// Arguments of `te`.
#[derive(Debug, Args)]
#[command(mut_arg("csv", |arg| arg.help("Write every line")))]
#[command(mut_arg("svg", |arg| arg.help("Draw the lines by order, the budget (FILE-budget.svg), with --speeds the map (FILE-speeds.svg); of a log the error over the angle, and its orders with their sources")))]
pub struct TeArgs {
    /// A model or a scene with declared errors, or the log of two encoders
    pub file: PathBuf,
    /// Keys of the study.
    #[command(flatten)]
    pub study: KeyFlags<TeKeys>,
    /// Every line of the table, not only the largest; of a log also every multiple of the shaft orders
    #[arg(long)]
    pub all: bool,
    /// Document, files and silence.
    #[command(flatten)]
    pub out: OutputArgs,
    /// Keys of the log.
    #[command(flatten)]
    pub log: LogArgs,
}

/// Keys of a transmission error, of a chain and of a record of two encoders.
#[derive(Debug)]
pub struct TeKeys;

impl KeyTable for TeKeys {
    const KEYS: KeyGroups = &[(None, CHAIN), (Some("Encoder records"), ENCODERS)];
}

#[rustfmt::skip]
const CHAIN: &[Key] = &[
    text("output", "NODE", "Output node; of a log the column of its encoder, or its two tracks"),
    text("driver", "NODE", "Node whose angle is prescribed; default the first of `[speed]`"),
    text("against", "NODE", "Node that the output is compared with, such as work against cradle"),
    number("radius", "LENGTH", "Also give the error as an arc at this radius of the output (default unit mm)"),
    number("speed", "SPEED", "Also compute the dynamic error: speed of the first node of `[speed]` (default unit rpm)"),
    number("speeds", "A:B:N", "Draw the lines over speeds A:B:N of that node (default unit rpm), and list where each is largest"),
    number("window", "TURNS", "Revolutions of the output for the peak-to-peak values; default 1, for a record the full common period"),
    text("index", "ELEMENT:TEETH", "Tooth-by-tooth indexing of the work: the element after which it advances, and its teeth, such as differential:37"),
    number("output-teeth", "N", "Teeth of the output, to divide --record by tooth; default those of the gear that turns with it"),
    file("record", "Write the error over the angle; unknown phases are random, the same in every run"),
];

#[rustfmt::skip]
const ENCODERS: &[Key] = &[
    list("input", "COLUMN", "Column of the input's encoder; two columns are tracks in quadrature. --output names that of the output"),
    text("teeth", "z1:z2,…", "Teeth from input to output, driver first: 21:63 or 21:63,17:40"),
    text("lines", "N1,N2", "Lines per revolution of both encoders, input first: 5000,5000; not needed if columns are angles"),
    number("counts-per-line", "N", "Counts per encoder line; default 4"),
    switch("stamps", "The columns are times of pulses, one per line"),
    switch("angle-base", "Rows are not equally spaced in time, such as rows sampled by angle: no speed is computed"),
    text("input-index", "COLUMN", "Column of the input's index pulse (reference mark, Z track), once per turn; with --stamps its times"),
    text("output-index", "COLUMN", "Column of the output's index pulse: angles and phases begin at its mark, and the counts between marks are checked"),
    number("harmonics", "N", "Harmonics of the mesh orders sought; default 4 if the rows resolve them"),
    switch("repair", "Remove the steps of lost or extra counts"),
    number("pressure-angle", "ANGLE", "Transverse pressure angle (default unit deg): with both flanks it separates the encoder's eccentricity from the gear's"),
    text("model", "MODEL", "A model or a scene whose declared errors, shafts and meshes name the orders"),
    text("at", "NODE,NODE", "Its nodes that carry the encoders, input first"),
];
