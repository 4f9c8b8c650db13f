//! Flags of `response`.

use std::path::PathBuf;

use clap::Args;

use super::keys::{Key, KeyFlags, KeyGroups, KeyTable, list, number, switch, word};
use super::output::OutputArgs;
use crate::scene::study::{ResponseMethodTag, ResponseQuantity};

/// Arguments of `response`.
#[derive(Debug, Args)]
#[command(mut_arg("csv", |arg| arg.help("Write the responses, real and imaginary part, one row per line; or the curve, one row per motion or speed")))]
#[command(mut_arg("svg", |arg| arg.help("Draw magnitude and phase, and the complex plane (FILE-nyquist.svg); or the jump curve, or the map")))]
pub struct ResponseArgs {
    /// A model or a scene
    pub scene: PathBuf,
    /// Keys of the study.
    #[command(flatten)]
    pub study: KeyFlags<ResponseKeys>,
    /// Document, files and silence.
    #[command(flatten)]
    pub out: OutputArgs,
}

/// Keys of studies of responses, of run-ups and of harmonic balance.
#[derive(Debug)]
pub struct ResponseKeys;

impl KeyTable for ResponseKeys {
    const KEYS: KeyGroups = &[(None, RESPONSE)];
}

#[rustfmt::skip]
const RESPONSE: &[Key] = &[
    list("input", "NAMES", "Inputs: motor.theta (a torque), first_pair.te (a displacement imposed in a branch), ground.x, motor.theta.motion"),
    list("output", "NAMES", "Outputs: work.theta, work.speed, work.acceleration, \"work - 1/27*motor\", belt.force, belt.deflection"),
    list("hold", "NAMES", "Degrees of freedom held fixed, such as the driver's angle"),
    number("band", "A:B", "Frequencies, LOW:HIGH (default unit Hz)"),
    number("lines", "N", "Lines in the band, both ends included; default 1001"),
    word::<ResponseQuantity>("as", "KIND", "Motions as displacement, speed or acceleration; by default as named").formerly("kind"),
    number("speed", "SPEED", "Mean speed of the first node of `[speed]` (default unit rpm); includes gyroscopic terms"),
    word::<ResponseMethodTag>("method", "METHOD", "Solution method; by default chosen from the machine and the number of lines"),
    number("run-up", "A:B:POINTS", "Run-up instead: responses to all orders over speed, meshes with sidebands, eccentricities, declared errors; speeds of the first node of `[speed]` (default unit rpm). Amplitudes are those of declared errors; without any, 1 µm is assumed for every order").sets("speeds"),
    number("harmonic-balance", "A:B:POINTS", "Periodic motions over speed instead, with play, friction and varying stiffness: harmonic balance with arc-length continuation; speeds of the first node of `[speed]` (default unit rpm), POINTS limits the steps. --output takes the signals of `simulate`").sets("speeds"),
    number("tolerance", "SHARE", "Maximum residual of higher orders, relative to the deflections; default 1e-6 (with --harmonic-balance)"),
    number("orders", "N", "Number of orders; by default chosen to meet the tolerance (with --harmonic-balance)"),
    switch("orders-alone", "Harmonic balance only, motions not refined by locating every switch (with --harmonic-balance)"),
];
