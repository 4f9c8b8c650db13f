//! Flags of `gear`.

use std::path::PathBuf;

use clap::Args;

use super::keys::{Key, KeyFlags, KeyGroups, KeyTable, number, word};
use super::output::OutputArgs;
use crate::scene::gear_file::{BodyModel, MeshMethod};

/// Keys of the load on a mesh.
#[derive(Debug)]
pub struct MeshKeys;

impl KeyTable for MeshKeys {
    const KEYS: KeyGroups = &[(None, MESH)];
}

#[rustfmt::skip]
const MESH: &[Key] = &[
    number("torque", "TORQUE", "Torque at the pinion (default unit N·m)"),
    number("torques", "A:B:N", "Torques at the pinion, FIRST:LAST:COUNT (default unit N·m)"),
    number("positions", "N", "Positions in one pitch; 60 by default"),
    number("slices", "N", "Slices along the face width; 11 by default"),
    word::<MeshMethod>("method", "METHOD", "Stiffness of the tooth pairs; energy by default"),
    word::<BodyModel>("body", "BODY", "Gear body of the energy method; half-plane by default"),
];

/// Arguments of `gear`.
#[derive(Debug, Args)]
#[command(mut_arg("csv", |arg| arg.help("Write transmission error and stiffness over one pitch; without a torque the geometry")))]
#[command(mut_arg("svg", |arg| arg.help("Draw the teeth in mesh, sliding (FILE-sliding.svg) and, with a torque, the mesh (FILE-mesh.svg, FILE-harris.svg)")))]
pub struct GearArgs {
    /// A gear file: a TOML file with `pair`
    pub file: PathBuf,
    /// Keys of `[mesh]`.
    #[command(flatten)]
    pub mesh: KeyFlags<MeshKeys>,
    /// Output flags.
    #[command(flatten)]
    pub out: OutputArgs,
}
