//! Errors of a generator's chain as they reach the flank of its work and the pair that the work is part of.

use std::f64::consts::TAU;
use std::path::Path;

use super::bevel_curves;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::quantity::format_number;
use crate::gear::cut::roll_errors::RollError;
use crate::machine::build::build;
use crate::machine::components::Machine;
use crate::machine::kinematics::Kinematics;
use crate::machine::operating_point::OperatingPoint;
use crate::modes::excitation_orders::reference_dof;
use crate::numeric::Complex;
use crate::numeric::fraction::Fraction;
use crate::plan::gear::cut_pair::{CutLoad, CutPair, ErrorEffect};
use crate::plan::gear_limits::MEMBERS;
use crate::scene;
use crate::scene::bevel_mesh::BevelMesh;
use crate::scene::model::{CutOn, GeneratorWork, Name};
use crate::transmission::chain::{ChainEnds, TransmissionChain};
use crate::transmission::order_lines::{self, LineOrigin, OrderLine};

/// Largest relative difference of the ratio of the settings from that of the chain: roll change gears meet a ratio to a few parts in a
/// million.
const SAME_RATIO: f64 = 1e-5;
/// Largest turn of the cradle in a turn of the cutter, rad: with more it is no cutter that rolls a flank.
const LARGEST_FEED: f64 = 1.0;
/// Lines below this share of the largest are rounding: errors that move cradle and work alike.
const ROUNDING: f64 = 1e-9;

/// Effects that a cut pair leaves out.
pub const LEFT_OUT: &[&str] = &[
    "deflection of the generator under cutting forces, and regeneration",
    "thermal growth",
    "differences from tooth to tooth (`te --index`)",
];

/// The work of a generator with the errors of its chain.
#[derive(Debug, Clone)]
pub struct WorkResult {
    /// Title of the generator.
    pub generator: String,
    /// Gear file of the work.
    pub file: String,
    /// Work and cradle, by their nodes.
    pub nodes: [String; 2],
    /// Lines of the work against the cradle.
    pub lines: Vec<WorkLine>,
    /// The pair.
    pub pair: CutPair,
}

/// An order line on the flank of the work.
#[derive(Debug, Clone)]
pub struct WorkLine {
    /// Cycles in a turn of the work.
    pub order: Fraction,
    /// The element it comes from.
    pub source: String,
    /// Cause of the line.
    pub cause: &'static str,
    /// Cycles per turn of the element.
    pub harmonic: u32,
    /// Amplitude of the work against the cradle, rad.
    pub amplitude: f64,
    /// Effect on flank and pair.
    pub effect: ErrorEffect,
}

impl WorkResult {
    /// The lines of a chain from cradle to work on the flank of the work; `values` are their amplitudes A and phases ψ.
    ///
    /// # Errors
    /// Settings whose ratio of roll is not that of the chain; as [`CutPair::new`].
    pub fn new(
        work: &GeneratorWork,
        (machine, title): (&Machine, &str),
        chain: &TransmissionChain,
        lines: &[(&OrderLine, Complex)],
        with_load: bool,
    ) -> Result<WorkResult, Error> {
        let ratio = check_ratio(work, chain)?;
        let largest = lines.iter().fold(0.0f64, |m, l| m.max(l.1.norm()));
        let lines: Vec<&(&OrderLine, Complex)> = (lines.iter())
            .filter(|l| l.1.norm() > ROUNDING * largest)
            .collect();
        let errors: Vec<RollError> = (lines.iter())
            .map(|(line, value)| RollError {
                value: *value,
                order: line.order.to_f64() * ratio,
            })
            .collect();
        let torque = match (with_load, &work.bevel.mesh.torques[..]) {
            (true, [torque]) => Some(*torque),
            _ => None,
        };
        let feed = cradle_per_turn(machine, work, chain)?;
        let pair = CutPair::new(&work.bevel, work.member, &errors, (torque, feed))?;
        let row = |((line, value), effect): (&&(&OrderLine, Complex), &ErrorEffect)| {
            let (source, cause) = match line.origin {
                LineOrigin::Declared(number) => {
                    let error = &machine.errors[number];
                    (error.location.clone(), error.cause.name())
                }
                LineOrigin::Stiffness(branch) => (machine.branch_name(branch), "mesh stiffness"),
            };
            WorkLine {
                order: line.order.clone(),
                source,
                cause,
                harmonic: line.harmonic,
                amplitude: value.norm(),
                effect: *effect,
            }
        };
        Ok(WorkResult {
            generator: title.to_string(),
            file: work.bevel.source.path.clone(),
            nodes: [work.work.text.clone(), work.cradle.text.clone()],
            lines: lines.iter().zip(&pair.effects).map(row).collect(),
            pair,
        })
    }

    /// The work of the generator that a pair names, cut with its rigid chain.
    ///
    /// # Errors
    /// Whatever is wrong with the generator's file; a file without `[work]`, or of another pair; chains with loops; as [`WorkResult::new`].
    pub fn on(cut: &CutOn, pair_file: &str) -> Result<WorkResult, Error> {
        let in_generator = |e: Error| match e.span {
            Some(_) => e.with_label("generator of `cut_on`"),
            None => e.with_span(&cut.span),
        };
        let refused = |message: String, hint: &str| {
            Error::new(Code::Conflict, message)
                .with_span(&cut.span)
                .with_hint(hint)
        };
        let path = &cut.source.path;
        let scene = scene::read(Path::new(path)).map_err(|errors| {
            let first = errors.as_slice().first().cloned();
            let none = || Error::new(Code::EmptyMachine, format!("{path} has no machine"));
            in_generator(first.unwrap_or_else(none))
        })?;
        let model = &scene.model;
        let Some(work) = &model.work else {
            let hint = "write [work] with `gear`, `member`, `cradle` and `work` into it";
            return Err(refused(format!("{path} has no [work]"), hint));
        };
        if work.bevel.source.text != pair_file {
            let message = format!(
                "{path} cuts the pair of {}, and not that of `gear`",
                work.bevel.source.path
            );
            return Err(refused(message, "name the same gear file in both"));
        }
        if !model.gear_meshes().is_empty() {
            let message = format!("gears of the generator {path} name gear files");
            let hint = "state their errors as [[error]]: only these are transmitted to the work";
            return Err(refused(message, hint));
        }
        let machine = build(model).map_err(in_generator)?;
        let kinematics = Kinematics::new(&machine).map_err(in_generator)?;
        let operating = OperatingPoint::solve(&machine, &kinematics).map_err(in_generator)?;
        let ends = ChainEnds {
            driver: reference_dof(&machine).map_err(in_generator)?,
            ..ends(&machine, work)?
        };
        let chain = TransmissionChain::new(&machine, &operating, ends).map_err(in_generator)?;
        if !chain.loop_conditions.is_empty() {
            let message = format!("the chain of {path} has closed loops");
            return Err(refused(message, "use a generator with an open chain"));
        }
        let lines = order_lines::order_lines(&machine, &operating, &chain);
        let lines: Vec<(&OrderLine, Complex)> =
            lines.iter().map(|line| (line, line.quasi_static)).collect();
        WorkResult::new(work, (&machine, &model.title), &chain, &lines, false)
    }
}

impl WorkResult {
    /// The work in the machine that runs it: torque of the pinion, N·m, below zero on coast flanks, and peak-to-peak transmission error of
    /// the cut pair along the normal under it, m, next to that of the pair as designed.
    ///
    /// # Errors
    /// As `bevel_curves::curves`.
    pub fn under_load(
        mut self,
        designed: &BevelMesh,
        load: Option<(f64, f64)>,
    ) -> Result<WorkResult, Error> {
        if let Some((torque, cut)) = load {
            let designed_curves = bevel_curves::curves(designed, torque.abs(), torque < 0.0)?;
            self.pair.loaded = Some(CutLoad {
                torque: torque.abs(),
                peak_to_peak: [designed_curves.peak_to_peak, cut].map(|e| e / designed.levers[1]),
            });
        }
        Ok(self)
    }
}

/// Work against cradle; the driver is to be put in.
///
/// # Errors
/// Nodes that do not exist.
pub fn ends(machine: &Machine, work: &GeneratorWork) -> Result<ChainEnds, Error> {
    let output = dof(machine, &work.work)?;
    Ok(ChainEnds {
        driver: output,
        output,
        relative_to: Some(dof(machine, &work.cradle)?),
    })
}

/// Degree of freedom of a node of `[work]`.
fn dof(machine: &Machine, name: &Name) -> Result<usize, Error> {
    machine.dof(&name.text).ok_or_else(|| {
        Error::new(Code::UnknownNode, format!("no node `{}`", name.text))
            .with_span(&name.span)
            .with_hint("name in [work] the nodes `cradle`, `work` and `cutter`")
    })
}

/// Turn of the cradle in a turn of the cutter, rad; none where the cutter is not named.
fn cradle_per_turn(
    machine: &Machine,
    work: &GeneratorWork,
    chain: &TransmissionChain,
) -> Result<Option<f64>, Error> {
    let Some(cutter) = &work.cutter else {
        return Ok(None);
    };
    let turns = |dof: usize| chain.ratio(dof).map(|turns| turns.to_f64());
    let cradle = chain.ends.relative_to.and_then(turns);
    let feed = cradle.zip(turns(dof(machine, cutter)?).filter(|t| *t != 0.0));
    let refused = |message: String| {
        Err(Error::new(Code::Conflict, message)
            .with_span(&cutter.span)
            .with_hint("name the node of the cutter head, or omit `cutter`"))
    };
    let name = &cutter.text;
    match feed.map(|(cradle, cutter)| TAU * (cradle / cutter).abs()) {
        None => refused(format!("`{name}` is not driven by the chain")),
        Some(feed) if feed > LARGEST_FEED => refused(format!(
            "the cradle turns by {feed:.3} rad in a turn of `{name}` (limit {LARGEST_FEED} rad)"
        )),
        feed => Ok(feed),
    }
}

/// Ratio of roll of the flank that is cut, work over cradle.
fn ratio_of_settings(work: &GeneratorWork) -> Result<f64, Error> {
    let file = &work.bevel;
    let side = file.contact.side.flanks()[work.member];
    let cut = file.members[work.member].flanks[side].as_ref();
    let roll = cut.and_then(|cut| cut.settings.roll);
    let none = || {
        let message = format!(
            "the touching flank of the {} is not generated",
            MEMBERS[work.member]
        );
        Error::new(Code::Conflict, message)
            .with_span(&work.span)
            .with_hint("name a member whose flank is generated")
    };
    Ok(roll.ok_or_else(none)?.work_over_cradle)
}

/// The ratio of roll of the settings, work over cradle.
///
/// # Errors
/// Settings whose ratio is not that of the chain.
pub fn check_ratio(work: &GeneratorWork, chain: &TransmissionChain) -> Result<f64, Error> {
    let ratio = ratio_of_settings(work)?;
    let cradle = chain.ends.relative_to.and_then(|dof| chain.ratio(dof));
    let of_chain = cradle.map_or(f64::NAN, |turns| turns.to_f64().abs());
    let of_settings = ratio.recip();
    let apart = of_settings / of_chain - 1.0;
    if apart.abs() <= SAME_RATIO {
        return Ok(ratio);
    }
    let message = format!(
        "cradle_over_work is {of_settings:.8} by the settings of {} and {of_chain:.8} by the chain from `{}` to `{}`: {} apart (limit {SAME_RATIO:e})",
        work.bevel.source.path,
        work.cradle.text,
        work.work.text,
        format_number(apart.abs()),
    );
    Err(Error::new(Code::ContradictoryRatios, message)
        .with_span(&work.span)
        .with_hint("use the roll and index change gears of these settings, or name the gear file of this set-up"))
}
