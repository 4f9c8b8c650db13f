//! Flags of `response`.

use std::path::PathBuf;

use clap::Args;

use super::keys::{Key, KeyFlags, KeyGroups, KeyTable, list, number, switch, word};
use super::output::OutputArgs;
use crate::scene::study::{ResponseMethodTag, ResponseQuantity};

/// Arguments of `response`.
#[derive(Debug, Args)]
#[command(mut_arg("csv", |arg| arg.help("Write the responses, real and imaginary part, one row a line; or the curve, one row a motion or a speed")))]
#[command(mut_arg("svg", |arg| arg.help("Draw magnitude and phase, and the complex plane beside (FILE-nyquist.svg); or the jump curve, or the map")))]
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
    list("input", "NAMES", "What drives: motor.theta (a torque), first_pair.te (a displacement imposed in a branch), ground.x, motor.theta.motion"),
    list("output", "NAMES", "What is measured: work.theta, work.speed, work.acceleration, \"work - 1/27*motor\", belt.force, belt.deflection"),
    list("hold", "NAMES", "Degrees of freedom held still, such as the driver's angle"),
    number("band", "A:B", "Frequencies, LOW:HIGH (Hz where bare)"),
    number("lines", "N", "Lines in the band, both ends included; 1001 where left out"),
    word::<ResponseQuantity>("as", "KIND", "Motions as displacement, speed or acceleration; as named where left out").formerly("kind"),
    number("speed", "SPEED", "Mean speed of the first node of `[speed]` (rpm where bare); gyroscopic terms count"),
    word::<ResponseMethodTag>("method", "METHOD", "How; chosen from the machine and the number of lines where left out"),
    number("run-up", "A:B:POINTS", "Answers to all orders over speed instead: meshes with sidebands, eccentricities, declared errors; speeds of the first node of `[speed]` (rpm where bare). Amplitudes are those of declared errors; where none is declared, 1 µm is assumed of every order").sets("speeds"),
    number("harmonic-balance", "A:B:POINTS", "Periodic motions over speed instead, with play, friction and varying stiffness: a balance of orders followed by arc length; speeds of the first node of `[speed]` (rpm where bare), POINTS bounds the steps. --output takes what `simulate` takes").sets("speeds"),
    number("tolerance", "SHARE", "What higher orders may add to the balance, of the size of the deflections; 1e-6 where left out (with --harmonic-balance)"),
    number("orders", "N", "So many orders; as many as the tolerance asks where left out (with --harmonic-balance)"),
    switch("orders-alone", "The balance alone, motions not refined by locating every switch (with --harmonic-balance)"),
];
