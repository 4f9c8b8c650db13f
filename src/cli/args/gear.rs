//! Flags of `gear`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::keys::{Key, KeyFlags, KeyGroups, KeyTable, list, number, switch, word};
use super::output::{OutputArgs, PageArgs};
use crate::gear::bevel::flank_theory::ContactSide;
use crate::scene::correction_study::{FlankSide, Member};
use crate::scene::mesh_table::{BodyModel, MeshMethod};

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
    number("slices", "N", "Slices along the face width; 40 for each axial pitch by default, then at least 11"),
    number("stations", "N", "Stations along the face of a bevel pair; 32 by default"),
    switch("changes", "Torques at which strips of a bevel pair begin or cease to carry as the load is raised"),
    word::<MeshMethod>("method", "METHOD", "Stiffness of the tooth pairs; energy by default"),
    word::<BodyModel>("body", "BODY", "Gear body of the energy method; half-plane by default"),
    switch("least-relief", "Find the tip relief of least peak-to-peak transmission error over the torques"),
    word::<ContactSide>("side", "SIDE", "Flanks of a bevel pair that touch; drive by default"),
    switch("vh", "V–H check of a bevel pair: offset and pinion position that move the pattern to toe, middle and heel"),
];

/// Arguments of `gear`.
#[derive(Debug, Args)]
#[command(mut_arg("csv", |arg| arg.help("Write transmission error and stiffness over one pitch; without a torque the geometry; of non-circular gears the centrodes, of bevel gears transmission error, with a torque the loaded one with stiffness, of worms and crossed gears the contacts, of helicoids the profile of the tool")))]
#[command(mut_arg("svg", |arg| arg.help("Draw the teeth in mesh, sliding (FILE-sliding.svg), the designed profile over the length of roll (-profile) and, with a torque, the mesh (FILE-mesh.svg, -stiffness, -sharing, -harris); of non-circular gears centrodes and ratio (FILE-ratio.svg); of bevel gears blanks, transmission error, pattern, ease-off (FILE-te.svg, -pattern, -ease-off), with a torque the mesh (-mesh, -load, -lengthwise, -sharing, -harris) and the stability (-stability); of worms the lines of contact, of crossed gears the ellipse, of helicoids the tool (FILE-deviation.svg) or what the hob leaves (FILE-feed-marks.svg); of pairs on two axes the axodes (FILE-axodes.svg)")))]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub struct GearArgs {
    /// Further computations.
    #[command(subcommand)]
    pub action: Option<GearAction>,
    /// A gear file: a TOML file with `pair` or `helicoid`
    #[arg(required = true)]
    pub file: Option<PathBuf>,
    /// Keys of `[mesh]`.
    #[command(flatten)]
    pub mesh: KeyFlags<MeshKeys>,
    /// Write the outlines of both gears in mesh at scale: .csv, .dxf or .svg
    #[arg(long, value_name = "FILE")]
    pub outline: Option<PathBuf>,
    /// Write the flanks of bevel gears: points and normals as .csv, the solids in mesh as .stl
    #[arg(long, value_name = "FILE")]
    pub flank: Option<PathBuf>,
    /// Output flags.
    #[command(flatten)]
    pub out: OutputArgs,
}

/// Computations on gears next to that of a gear file.
#[derive(Debug, Subcommand)]
pub enum GearAction {
    /// Module, pressure angle, profile shift and rack of an undocumented gear from its readings
    #[command(after_help = "Example:\n  geardyn gear reverse data/unknown_gear.toml")]
    Reverse(ReverseArgs),
    /// Flanks of a bevel pair as discrete blades cut them: scallops, run-out, errors of the generator
    #[command(
        after_help = "Example:\n  geardyn gear cut models/gears/bevel_12_36.toml --svg cut.svg"
    )]
    Cut(CutArgs),
    /// Settings for the next cut of a bevel gear from its measured flank, or of a pinion for a prescribed ease-off, and the residual deviation
    #[command(
        after_help = "Example:\n  geardyn gear correct models/gears/bevel_12_36.toml --measured data/bevel_12_36_grid.csv\n  geardyn gear correct models/gears/bevel_12_36.toml --target data/bevel_12_36_target.toml"
    )]
    Correct(CorrectArgs),
}

/// Keys of `[correction]`.
#[derive(Debug)]
pub struct CorrectionKeys;

impl KeyTable for CorrectionKeys {
    const KEYS: KeyGroups = &[(None, CORRECTION)];
}

#[rustfmt::skip]
const CORRECTION: &[Key] = &[
    word::<Member>("member", "MEMBER", "Measured member; pinion by default"),
    word::<FlankSide>("flank", "FLANK", "Measured flank, if the grid has no column `flank` or to use only one"),
    list("settings", "NAMES", "Settings that may be changed, such as radial_distance,tilt; by default those of every machine"),
    number("length-step", "LENGTH", "Resolution of length dials; 0.01 mm by default (default unit mm)"),
    number("angle-step", "ANGLE", "Resolution of angle dials; 1 arcmin by default (default unit deg)"),
    number("ratio-step", "NUMBER", "Step of the ratio of roll and of its modification; 1e-6 by default"),
    number("least", "LENGTH", "Smallest flank displacement (rms) for which a combination of settings is used; 0.05 µm by default"),
];

/// Arguments of `gear correct`.
#[derive(Debug, Args)]
#[command(mut_arg("csv", |arg| arg.help("Write the nodes with their deviations, measured and expected after the next cut")))]
#[command(mut_arg("svg", |arg| arg.help("Draw the maps of deviations, measured and expected after the next cut")))]
pub struct CorrectArgs {
    /// A gear file with `pair = { kind = "bevel", … }`
    pub file: PathBuf,
    /// Nodes as CSV: z and radius (or x, y, z), deviation; or measured points with nominal normals
    #[arg(
        long,
        value_name = "GRID",
        required_unless_present = "target",
        conflicts_with = "target"
    )]
    pub measured: Option<PathBuf>,
    /// Prescribed ease-off of the pinion instead of a measured grid: a TOML file with `[ease_off]` and `[pattern]`
    #[arg(long, value_name = "TARGET")]
    pub target: Option<PathBuf>,
    /// Keys of `[correction]`.
    #[command(flatten)]
    pub study: KeyFlags<CorrectionKeys>,
    /// Output flags.
    #[command(flatten)]
    pub out: OutputArgs,
}

/// Arguments of `gear reverse`.
#[derive(Debug, Args)]
pub struct ReverseArgs {
    /// A TOML file with `[measured_gear]`: spans in place of a module, diameters, mate
    pub readings: PathBuf,
    /// Print one JSON document, and nothing else, on standard output
    #[arg(long)]
    pub json: bool,
    /// Write the candidates
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// The page.
    #[command(flatten)]
    pub page: PageArgs,
    /// Print no warnings, no progress and no notes
    #[arg(long)]
    pub quiet: bool,
}

/// Arguments of `gear cut`.
#[derive(Debug, Args)]
#[command(mut_arg("csv", |arg| arg.help("Write the profiles at the middle of the face")))]
#[command(mut_arg("svg", |arg| arg.help("Draw the deviations over the flanks, those of the first flank for each cause (FILE-causes.svg), profiles (-profile) and the shares of the blades (-blades)")))]
pub struct CutArgs {
    /// A gear file of a bevel pair with `[cut]`
    pub file: PathBuf,
    /// Write the cut flanks: points, normals and deviations as .csv, triangles as .stl
    #[arg(long, value_name = "FILE")]
    pub flank: Option<PathBuf>,
    /// Write the chips of all passes of the blades as CSV, for the key `chips` of a face-mill load
    #[arg(long, value_name = "FILE")]
    pub chips: Option<PathBuf>,
    /// Output flags.
    #[command(flatten)]
    pub out: OutputArgs,
}
