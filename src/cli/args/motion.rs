//! Flags of `simulate`, `accuracy` and `stability`, and of `plan` what it shares with them.

use std::path::PathBuf;

use clap::Args;

use super::keys::{Key, KeyFlags, KeyGroups, KeyTable, list, number, switch, text, word};
use super::output::OutputArgs;
use crate::scene::study::AccuracyTarget;

/// Keys of the integration of a motion.
#[derive(Debug)]
pub struct IntegrationKeys;

/// Keys of a study of motion.
#[derive(Debug)]
pub struct SimulateKeys;

/// Keys of a study of accuracy.
#[derive(Debug)]
pub struct AccuracyKeys;

/// Keys of a study of stability.
#[derive(Debug)]
pub struct StabilityKeys;

impl KeyTable for IntegrationKeys {
    const KEYS: KeyGroups = &[(None, INTEGRATION)];
}

impl KeyTable for SimulateKeys {
    const KEYS: KeyGroups = &[(None, INTEGRATION), (None, SIGNALS), (None, SIMULATE)];
}

impl KeyTable for AccuracyKeys {
    const KEYS: KeyGroups = &[
        (None, ACCURACY),
        (None, INTEGRATION),
        (None, SIGNALS),
        (None, METHODS),
        (None, ERROR),
    ];
}

impl KeyTable for StabilityKeys {
    const KEYS: KeyGroups = &[
        (None, INTEGRATION),
        (None, SIGNALS),
        (None, METHODS),
        (None, STABILITY),
    ];
}

#[rustfmt::skip]
const INTEGRATION: &[Key] = &[
    number("until", "TIME", "Duration (default unit s)"),
    text("method", "METHOD", "Integration method; by default chosen from the structure of the machine: exact, switched, periodic; by --tolerance radau5, exponential, dop853-events, dop853, dopri5, generalized-alpha-controlled; by --step rk4, newmark, hht, generalized-alpha"),
    number("tolerance", "X", "Local error of a step, relative to the size of each state; default 1e-8"),
    number("step", "TIME", "Maximum step size of fixed-step methods (default unit s), with equal steps between known load jumps"),
    number("samples", "N", "Number of equal output intervals, such as 5000 or 1e6; default 1000"),
];

#[rustfmt::skip]
const SIGNALS: &[Key] = &[
    list("output", "SIGNALS", "Signals: motor.theta, motor.theta.speed, motor.theta.acceleration, motor.theta.load, belt.force, belt.deflection"),
];

#[rustfmt::skip]
const SIMULATE: &[Key] = &[
    switch("energy", "Also the energy balance: stored, supplied, dissipated"),
    number("allow", "TIME", "Time budget, such as 5h (default unit s); default 1h. Work estimated to take longer is refused with the estimate"),
    switch("no-sensitivity", "Skip the second run that measures the sensitivity to initial conditions and the significant digits").sets("sensitivity").to("false"),
    switch("no-history", "Keep no history of the outputs; memory does not grow with the duration").sets("history").to("none"),
    number("spectrum", "N", "Spectra of the outputs, computed during integration, averaged over blocks of N samples"),
    text("track", "NODE:ORDERS", "Orders of the outputs over the angle of a node, such as motor:1,21 or motor:37/12"),
    number("turns", "N", "Turns averaged for each point of the orders; default 8"),
    text("te", "INPUT:OUTPUT", "Transmission error of one node against another, as `te` computes it from a log; of the last million samples"),
    text("teeth", "PAIRS", "Teeth between the two nodes, driver first: 21:63 or 21:63,17:40"),
];

#[rustfmt::skip]
const ACCURACY: &[Key] = &[
    word::<AccuracyTarget>("of", "OF", "Quantity whose error is measured; default the motion"),
    number("lowest", "N", "Number of elastic modes compared; default 10 (with --of modes)"),
    list("input", "NAMES", "Input, such as motor.theta (with --of response; --output names the response)"),
    number("band", "A:B", "Frequencies, LOW:HIGH (default unit Hz; with --of response)"),
    number("lines", "N", "Lines in the band; default 1001 (with --of response)"),
];

#[rustfmt::skip]
const METHODS: &[Key] = &[list("methods", "METHODS", "Only these methods")];

#[rustfmt::skip]
const ERROR: &[Key] = &[
    number("error", "X", "Target error, for which a method is recommended; default 1e-6, of a gear file 1e-2"),
];

#[rustfmt::skip]
const STABILITY: &[Key] = &[
    number("speeds", "A:B:N", "Speeds of a chart of parametric stability, FIRST:LAST:POINTS (default unit rpm, default 50 points)"),
    text("over", "depth=A:B:N", "Second axis of that chart, factors on the values of the scene: depth (of stiffness waves) or damping"),
];

/// Arguments of `simulate`.
#[derive(Debug, Args)]
#[command(mut_arg("csv", |arg| arg.help("Write the outputs over time")))]
#[command(mut_arg("svg", |arg| arg.help("Draw the outputs over time")))]
pub struct SimulateArgs {
    /// A scene or a model
    pub scene: PathBuf,
    /// Keys of the study.
    #[command(flatten)]
    pub study: KeyFlags<SimulateKeys>,
    /// Document, files and silence.
    #[command(flatten)]
    pub out: OutputArgs,
}

/// Arguments of `accuracy`.
#[derive(Debug, Args)]
#[command(mut_arg("csv", |arg| arg.help("Write the runs")))]
#[command(mut_arg("svg", |arg| arg.help("Draw error against run time")))]
pub struct AccuracyArgs {
    /// A scene, a model or a gear file
    pub scene: PathBuf,
    /// Keys of the study.
    #[command(flatten)]
    pub study: KeyFlags<AccuracyKeys>,
    /// Document, files and silence.
    #[command(flatten)]
    pub out: OutputArgs,
}

/// Arguments of `stability`.
#[derive(Debug, Args)]
#[command(mut_arg("csv", |arg| arg.help("Write the extreme cases of the scene, one row per case and method")))]
#[command(mut_arg("svg", |arg| arg.help("Draw the regions of stability with the eigenvalues times the step, the amplification factor per step of each method, and the chart over two axes")))]
pub struct StabilityArgs {
    /// A scene or a model
    pub scene: PathBuf,
    /// Keys of the study.
    #[command(flatten)]
    pub study: KeyFlags<StabilityKeys>,
    /// Document, files and silence.
    #[command(flatten)]
    pub out: OutputArgs,
}
