//! Command-line arguments as typed (clap).

use std::path::PathBuf;

use clap::builder::PossibleValuesParser;
use clap::{Args, Parser, Subcommand};

pub use gear::{CorrectArgs, CutArgs, GearAction, GearArgs, ReverseArgs};
pub use identify::IdentifyArgs;
pub use log::LogArgs;
pub use modes::{ModesArgs, PlanArgs};
pub use motion::{AccuracyArgs, SimulateArgs, StabilityArgs};
pub use output::{OutputArgs, PageArgs};
pub use response::ResponseArgs;
pub use spectrum::SpectrumArgs;
pub use te::TeArgs;

mod keys;

mod log;

mod output;

mod motion;

mod modes;

mod response;

mod spectrum;

mod identify;

mod te;

mod gear;

/// Machine dynamics of gear drive trains: models become modes and motion, logs become models.
#[derive(Debug, Parser)]
#[command(
    name = "geardyn",
    version,
    about,
    max_term_width = 100,
    arg_required_else_help = true
)]
#[command(after_help = "Example:\n  geardyn modes models/y2250.toml")]
pub struct Cli {
    /// Subcommand.
    #[command(subcommand)]
    pub command: Command,
    /// Number of threads, by default one per core; results do not depend on it
    #[arg(long, value_name = "N", global = true, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
}

/// Commands of the program.
#[derive(Debug, Subcommand)]
#[allow(clippy::large_enum_variant, reason = "made once")]
pub enum Command {
    /// Write an annotated model to start from
    #[command(after_help = "Examples:
  geardyn new my_machine.toml
  geardyn new my_pair.toml --gear bevel")]
    New {
        /// The file to write; it must not exist yet
        file: PathBuf,
        /// Write a gear file of this kind instead of a model
        #[arg(long, value_name = "KIND", value_parser = PossibleValuesParser::new(super::new::gear_kinds()))]
        gear: Option<String>,
    },
    /// Validate models and scenes; report how logs are read
    #[command(after_help = "Examples:
  geardyn check models/y2250.toml models/two_disc.toml
  geardyn check data/spindle_impact.csv")]
    Check(CheckArgs),
    /// Explain the code of an error, a warning or a repair
    #[command(after_help = "Example:\n  geardyn explain contradictory-ratios")]
    Explain {
        /// The code in brackets after an error or a warning, or before a repair; default all codes
        code: Option<String>,
    },
    /// List what would be computed, what is left out and why, without computing it
    #[command(after_help = "Examples:
  geardyn plan models/y2250.toml --damped
  geardyn plan models/y2250.toml --advise 200 --tolerance 0.01
  geardyn plan models/gears/fzg_c.toml
  geardyn plan models/chain_20.toml --until 1 --method radau5 --tolerance 1e-6")]
    Plan(PlanArgs),
    /// Natural frequencies, damping, shapes, energies and sensitivities
    #[command(after_help = "Examples:
  geardyn modes models/y2250.toml
  geardyn modes models/y2250.toml --damped --mode 2
  geardyn modes models/uniform_chain.toml --lowest 5 --json
  geardyn modes models/overhung_rotor.toml --campbell 0:12000:61 --svg campbell.svg")]
    Modes(ModesArgs),
    /// Motion in time: histories, extremes, step responses
    #[command(after_help = "Examples:
  geardyn simulate examples/linear_chain.toml
  geardyn simulate examples/y2250_step.toml --svg step.svg
  geardyn simulate examples/backlash_pair.toml --method radau5 --tolerance 1e-6
  geardyn simulate examples/linear_chain.toml --until 50 --samples 10000 --spectrum 2048 --no-history")]
    Simulate(SimulateArgs),
    /// Error and run time of every applicable method against one reference: motion, natural frequencies or responses
    #[command(after_help = "Examples:
  geardyn accuracy examples/backlash_pair.toml
  geardyn accuracy models/y2250.toml --of modes --lowest 10
  geardyn accuracy models/gears/helical.toml
  geardyn accuracy models/y2250.toml --of response --input motor.theta --output cutter_ring.theta --band 1:300
  geardyn accuracy examples/linear_chain.toml --error 1e-9 --svg accuracy.svg")]
    Accuracy(AccuracyArgs),
    /// Stability of methods and machine: step limits, parametric stability, the scene at its extremes
    #[command(after_help = "Examples:
  geardyn stability examples/backlash_pair.toml --until 0.005
  geardyn stability examples/smooth_mesh.toml --until 0.005 --speeds 500:12000:200 --svg regions.svg
  geardyn stability examples/smooth_mesh.toml --until 0.005 --speeds 500:12000:200 --over depth=0:4:21 --svg regions.svg")]
    Stability(StabilityArgs),
    /// Frequency responses of motions and forces to torques, transmission errors and base motion
    #[command(after_help = "Examples:
  geardyn response models/y2250.toml --input motor --output workpiece --band 1:400
  geardyn response models/y2250.toml --input index_drive.te --output workpiece --hold motor --band 1:400 --svg te.svg
  geardyn response models/y2250.toml --run-up 50:3000:120 --svg run_up.svg
  geardyn response examples/backlash_jumps.toml --harmonic-balance 2000:7000:60 --svg jumps.svg")]
    Response(ResponseArgs),
    /// Gear charts and readings: deviations, uncertainty, grades
    #[command(after_help = "Exit code 1 if a value is outside its required grade.

Examples:
  geardyn measure data/index_gear.toml
  geardyn measure data/index_gear.toml --json
  geardyn measure data/index_gear.toml --svg charts.svg")]
    Measure(MeasureArgs),
    /// Gears from their theory: geometry, path of contact, stiffness, transmission error under load
    #[command(after_help = "Examples:
  geardyn gear models/gears/fzg_c.toml
  geardyn gear models/gears/fzg_c.toml --torques 50:500:10 --svg fzg.svg
  geardyn gear models/gears/fzg_c.toml --outline fzg.dxf
  geardyn gear models/gears/elliptic.toml --svg elliptic.svg
  geardyn gear reverse data/unknown_gear.toml
  geardyn gear cut models/gears/bevel_12_36.toml")]
    Gear(GearArgs),
    /// Transmission error of a chain: the source and size of each order at the output, and sources that cannot be separated
    #[command(after_help = "Examples:
  geardyn te models/three_stage_chain.toml --output spindle
  geardyn te models/three_stage_chain.toml --output spindle --radius 270mm --speed 1400 --all
  geardyn te examples/y2250_te.toml --svg te.svg --speeds 200:3000:141
  geardyn te models/three_stage_chain.toml --output spindle --record record.csv --window 1
  geardyn te data/y2250_te.csv --input index_gear_1 --output work_spindle --teeth 30:37,54:36,1:90 --lines 10000,36000
  geardyn te data/y2250_te.csv --input index_gear_1 --output work_spindle --teeth 30:37,54:36,1:90 --lines 10000,36000 --model examples/y2250_index_te.toml --at index_gear_1,work_spindle --svg te.svg")]
    Te(TeArgs),
    /// Run every study of a scene
    #[command(after_help = "Example:\n  geardyn run examples/linear_chain.toml")]
    Run(RunArgs),
    /// Frequency responses, transfer functions and modes from a measured log
    #[command(after_help = "Examples:
  geardyn identify data/spindle_impact.csv --input force --output ax,ay
  geardyn identify data/spindle_impact.csv --input force --output ax --export model.mat
  geardyn identify data/spindle_impact.csv --input force --output ax,ay --method plscf")]
    Identify(IdentifyArgs),
    /// Spectra, orders, envelopes and cepstra of a measured log, with named lines
    #[command(after_help = "Examples:
  geardyn spectrum data/spindle_impact.csv --channel ax
  geardyn spectrum data/spindle_impact.csv --channel ax --kind amplitude --svg lines.svg")]
    Spectrum(SpectrumArgs),
    /// Convert a log to CSV, UFF 58 or JSON
    #[command(after_help = "Example:\n  geardyn convert data/spindle_impact.csv --to spindle.uff")]
    Convert(ConvertArgs),
    /// Print completions for a shell
    #[command(after_help = "Example:\n  geardyn completions bash > geardyn.bash")]
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
    /// Write the manual pages into a folder
    #[command(after_help = "Example:\n  geardyn man target/man")]
    Man {
        /// The folder; created if missing
        folder: PathBuf,
    },
}

/// Arguments of `check`.
#[derive(Debug, Args)]
pub struct CheckArgs {
    /// Models, scenes (.toml) or logs; no pipes
    #[arg(required = true)]
    pub files: Vec<PathBuf>,
    /// Keys of the logs.
    #[command(flatten)]
    pub log: LogArgs,
    /// Write how each log was read to its sidecar (LOG.toml), for correction
    #[arg(long)]
    pub write: bool,
    /// One JSON document on standard output
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `convert`.
#[derive(Debug, Args)]
pub struct ConvertArgs {
    /// A log of signals, or a file of frequency responses; no pipe
    pub file: PathBuf,
    /// The file to write (.csv, .uff or .json)
    #[arg(long, value_name = "FILE")]
    pub to: PathBuf,
    /// Only these channels, in this order
    #[arg(long, value_name = "CHANNELS", value_delimiter = ',')]
    pub channel: Vec<String>,
    /// Binary UFF 58, without loss of digits
    #[arg(long)]
    pub binary: bool,
    /// Keys of the log.
    #[command(flatten)]
    pub log: LogArgs,
    /// Print no warnings, no progress and no notes
    #[arg(long)]
    pub quiet: bool,
}

/// Arguments of `measure`.
#[derive(Debug, Args)]
#[command(mut_arg("csv", |arg| arg.help("Write the values, one row each")))]
#[command(mut_arg("svg", |arg| arg.help("Draw the charts; closed ones are also drawn in polar form (FILE-polar.svg)")))]
pub struct MeasureArgs {
    /// A TOML file with `[measured_gear]`, which names the CSV files of its charts
    pub file: PathBuf,
    /// Document, files and silence.
    #[command(flatten)]
    pub out: OutputArgs,
}

/// Arguments of `run`.
#[derive(Debug, Args)]
pub struct RunArgs {
    /// A scene
    pub scene: PathBuf,
    /// Print one JSON document, and nothing else, on standard output
    #[arg(long)]
    pub json: bool,
    /// The page of all studies.
    #[command(flatten)]
    pub page: PageArgs,
    /// Draw the figures of all studies into this folder, as NUMBER-STUDY.svg
    #[arg(long, value_name = "DIR")]
    pub svg: Option<PathBuf>,
    /// Print no notes on what ran and what was left out
    #[arg(long)]
    pub quiet: bool,
}

#[cfg(test)]
mod tests {
    use super::keys::{Key, KeyTable};
    use super::{gear, identify, log, modes, motion, response, spectrum, te};
    use crate::base::flags::{Flag, Flags};
    use crate::base::table_reader::TableReader;
    use crate::plan::logs::encoder_study::EncoderStudy;
    use crate::plan::logs::identify_study::IdentifyStudy;
    use crate::plan::logs::spectrum_study::SpectrumStudy;
    use crate::recording::sidecar;
    use crate::scene::study::{
        AccuracyStudy, HarmonicBalanceStudy, ModesStudy, ReadStudy, ResponseStudy, RunUpStudy,
        SimulateStudy, StabilityStudy, TransmissionStudy,
    };
    use crate::scene::{bevel_file, correction_study, mesh_table};

    fn read<S: ReadStudy>(f: &mut TableReader) {
        S::read(f);
    }

    fn flag(name: &str, key: &str, value: &str) -> Flag {
        Flag {
            name: name.to_string(),
            key: key.to_string(),
            values: vec![value.to_string()],
            is_list: false,
            is_switch: false,
        }
    }

    /// Flags that no reader accepts, each tested with the flags `extra`.
    fn unread<K: KeyTable>(readers: &[fn(&mut TableReader)], extra: &[Flag]) -> Vec<&'static str> {
        let keys = K::KEYS.iter().flat_map(|(_, keys)| *keys);
        let is_read = |key: &&Key| {
            let flags = [extra, &[flag("--it", &key.key(), "x")]].concat();
            readers.iter().any(|reader| {
                let result = Flags::new(&flags).read("the study", None, &[], reader);
                result.map_or_else(|e| !e.to_string().contains("--it has no effect"), |_| true)
            })
        };
        keys.filter(|key| !is_read(key))
            .map(|key| key.flag)
            .collect()
    }

    /// Every flag of a key table is read by a reader of its command.
    #[test]
    fn law_every_flag_is_read() {
        assert!(unread::<modes::ModesKeys>(&[read::<ModesStudy>], &[]).is_empty());
        assert!(unread::<motion::SimulateKeys>(&[read::<SimulateStudy>], &[]).is_empty());
        assert!(unread::<motion::StabilityKeys>(&[read::<StabilityStudy>], &[]).is_empty());
        let responses = [
            read::<ResponseStudy>,
            read::<RunUpStudy>,
            read::<HarmonicBalanceStudy>,
        ];
        assert!(unread::<response::ResponseKeys>(&responses, &[]).is_empty());
        let te: [fn(&mut TableReader); 2] =
            [read::<TransmissionStudy>, |f| drop(EncoderStudy::read(f))];
        assert!(unread::<te::TeKeys>(&te, &[]).is_empty());
        let identify: fn(&mut TableReader) = |f| drop(IdentifyStudy::read(f));
        assert!(unread::<identify::IdentifyKeys>(&[identify], &[]).is_empty());
        let spectrum: fn(&mut TableReader) = |f| drop(SpectrumStudy::read(f));
        let order_cut = [flag("--kind", "kind", "order-cut")];
        assert!(unread::<spectrum::SpectrumKeys>(&[spectrum], &order_cut).is_empty());
        let motion = unread::<motion::AccuracyKeys>(&[read::<AccuracyStudy>], &[]);
        assert_eq!(motion, ["lowest", "input", "band", "lines"]);
        for (value, accepted) in [("modes", "lowest"), ("response", "band")] {
            let quantity = [flag("--of", "of", value)];
            let unread = unread::<motion::AccuracyKeys>(&[read::<AccuracyStudy>], &quantity);
            assert!(
                !unread.contains(&accepted) && unread.contains(&"until"),
                "{unread:?}"
            );
        }
        let mesh: fn(&mut TableReader) = |f| drop(mesh_table::mesh(f));
        let contact: fn(&mut TableReader) = |f| {
            bevel_file::contact(f);
        };
        let flank_mesh: fn(&mut TableReader) = |f| drop(bevel_file::mesh(f));
        let readers = [mesh, contact, flank_mesh];
        assert!(unread::<gear::MeshKeys>(&readers, &[]).is_empty());
        let correction: fn(&mut TableReader) = |f| drop(correction_study::correction(f));
        assert!(unread::<gear::CorrectionKeys>(&[correction], &[]).is_empty());
        let log = log::LogKeys::KEYS.iter().flat_map(|(_, keys)| *keys);
        for key in log {
            let flags = Flags::new(&[flag("--it", &key.key(), "x")]);
            let message =
                sidecar::from_flags(&flags).map_or_else(|e| e.to_string(), |_| String::new());
            assert!(!message.contains("does nothing"), "{message}");
        }
    }
}
