//! Transmission-error study: rigid, quasi-static and dynamic order lines, budget, coinciding orders.

use std::sync::Arc;

use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::base::text::suggestion;
use crate::machine::components::{BranchLaw, Machine};
use crate::machine::kinematics::mean_speeds;
use crate::modes::excitation_orders::reference_dof;
use crate::numeric::Complex;
use crate::numeric::fraction::Fraction;
use crate::plan::meshes::work::{self, WorkResult};
use crate::plan::prepared_machine::PreparedMachine;
use crate::plan::response::run::natural_frequencies;
use crate::plan::stages::StageDecision;
use crate::plan::transmission::error_record::{self, TransmissionErrorRecord};
use crate::response::frf::ResponseMethod;
use crate::scene::model::GeneratorWork;
use crate::scene::study::{IndexingStudy, TransmissionStudy};
use crate::transmission::budget::{self, ErrorBudget};
use crate::transmission::chain::{ChainEnds, TransmissionChain};
use crate::transmission::coincidence::{self, OrderCoincidence};
use crate::transmission::dynamic::ErrorTransfer;
use crate::transmission::eccentric_pair;
use crate::transmission::indexing::{self, IndexingEffect};
use crate::transmission::loaded;
use crate::transmission::order_lines::{self, LineOrigin, OrderLine};
use crate::transmission::range_distribution::{self, HarmonicTerm};

/// The transmission error of a chain.
pub struct TransmissionResult {
    /// The chain.
    pub chain: TransmissionChain,
    /// Every line, by rising order.
    pub lines: Vec<OrderLineResult>,
    /// Orders that coincide, by numbers of rows.
    pub coincidences: Vec<OrderCoincidence>,
    /// After so many turns of what orders are counted by everything repeats; absent where there is no line.
    pub period: Option<Fraction>,
    /// Branches of a rigid loop that is inconsistent with the errors, so that only elastic joints have a solution.
    pub inconsistent_loop: Option<Vec<String>>,
    /// Sums and percentiles.
    pub budget: ErrorBudget,
    /// Names of the elements of the budget.
    pub elements: Vec<String>,
    /// Dynamic budget at speed, on request.
    pub at_speed: Option<DynamicBudget>,
    /// Elements that could be left out, and what that takes off the root of the sum of squares and off the worst case.
    pub negligible: (Vec<usize>, f64, f64),
    /// Second order of offsets, which the lines leave out, at the output, rad.
    pub second_order: f64,
    /// Effect of each line on work that is indexed tooth by tooth.
    pub marks: Option<Vec<IndexingEffect>>,
    /// Lines over speed.
    pub map: Option<SpeedMap>,
    /// Work of generators, cut with the lines: of this machine, and of the gears that it runs.
    pub works: Vec<Arc<WorkResult>>,
    /// The error over the angle.
    pub record: Option<TransmissionErrorRecord>,
    /// By how much the mean loads wind up the chain, rad.
    pub wind_up: f64,
    /// m.
    pub radius: Option<f64>,
    /// Speed of what orders are counted by, for the error at speed, rad/s.
    pub speed: Option<f64>,
    /// Stages with what they do.
    pub plan: Vec<(&'static str, StageDecision)>,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// Sums at speed.
pub struct DynamicBudget {
    /// Sums and percentiles.
    pub budget: ErrorBudget,
    /// As [`TransmissionResult::negligible`].
    pub negligible: (Vec<usize>, f64, f64),
}

/// Every line over the speed of the machine.
pub struct SpeedMap {
    /// Speeds of the first node of `[speed]`, rad/s.
    pub speeds: Vec<f64>,
    /// Amplitude A of every row at each speed, rad.
    pub amplitudes: Vec<Vec<f64>>,
    /// Speed of the largest amplitude of every row, rad/s, and A there, rad: of these speeds and of those between them at which the row's
    /// order meets a natural frequency.
    pub largest: Vec<(f64, f64)>,
}

/// A line of the table.
pub struct OrderLineResult {
    /// Source and order of the line.
    pub line: OrderLine,
    /// A and ψ at the output with rigid joints, slowly, rad; absent where they would lock: a loop does not fit this line alone.
    pub kinematic: Option<Complex>,
    /// The same under load, where joints give way.
    pub loaded: Complex,
    /// The same at speed.
    pub dynamic: Option<Complex>,
    /// Share of the sum of squared amplitudes.
    pub share: f64,
}

impl TransmissionResult {
    /// Quasi-static A and ψ of a row: with rigid joints where these have a solution, in loops as the elastic joints share it out.
    pub fn quasi_static(&self, row: &OrderLineResult) -> Complex {
        match row.line.origin {
            LineOrigin::Declared(_) if self.has_rigid_solution() => row.line.quasi_static,
            _ => row.loaded,
        }
    }

    /// Largest A of a row over the requested conditions: quasi-static, at speed, over speeds, rad.
    pub fn max_amplitude(&self, row: usize) -> f64 {
        let slow = self.quasi_static(&self.lines[row]).norm();
        let at_speed = self.lines[row].dynamic.map_or(0.0, |z| z.norm());
        let over = self.map.as_ref().map_or(0.0, |map| map.largest[row].1);
        slow.max(at_speed).max(over)
    }

    /// Some line is another under load than with rigid joints, beyond what is shown of either.
    pub fn load_changes_lines(&self) -> bool {
        /// Half a unit of the fourth digit, and rounding of the largest.
        const DISPLAY_TOLERANCE: (f64, f64) = (5e-4, 1e-9);
        let largest = self
            .lines
            .iter()
            .fold(0.0f64, |m, r| m.max(r.loaded.norm()));
        let differs = |row: &OrderLineResult| {
            let loaded = row.loaded.norm();
            let off = |rigid: Complex| (rigid.norm() - loaded).abs();
            let shown = DISPLAY_TOLERANCE.0 * loaded + DISPLAY_TOLERANCE.1 * largest;
            row.kinematic.is_none_or(|rigid| off(rigid) > shown)
        };
        self.lines.iter().any(differs)
    }

    /// True if rigid joints have a solution for every single error: no loop shares it out.
    pub fn has_rigid_solution(&self) -> bool {
        self.chain.loop_conditions.is_empty()
    }
}

/// The chain from the driver to the output that a study names.
fn chain_of(
    prepared_machine: &PreparedMachine,
    study: &TransmissionStudy,
) -> Result<TransmissionChain, Error> {
    let PreparedMachine {
        machine, operating, ..
    } = prepared_machine;
    let of_work = prepared_machine.work.as_ref().map(|(work, _)| work);
    let (output, against) = match (&study.output, of_work) {
        (Some(output), _) => (output, study.against.as_deref()),
        (None, Some(work)) => (&work.work.text, Some(work.cradle.text.as_str())),
        (None, None) => {
            return Err(
                Error::new(Code::Usage, "the node of the error is not stated")
                    .with_hint("state `output`, a node"),
            );
        }
    };
    let ends = ChainEnds {
        driver: match &study.driver {
            Some(name) => angle_dof(machine, name)?,
            None => reference_dof(machine)?,
        },
        output: angle_dof(machine, output)?,
        relative_to: against.map(|name| angle_dof(machine, name)).transpose()?,
    };
    if machine.errors.is_empty() {
        return Err(
            Error::new(Code::MissingKey, "no element has a declared error").with_hint(
                "write [[error]] with `on`, `cause` and `amplitude` into the model or the scene",
            ),
        );
    }
    let chain = TransmissionChain::new(machine, operating, ends)?;
    let slides = !machine.dofs[ends.output].axis.is_rotation();
    if let (true, Some(what)) = (
        slides,
        [
            ("a radius", study.radius.is_some()),
            ("indexing", study.index.is_some()),
        ]
        .iter()
        .find_map(|(what, asked)| asked.then_some(what)),
    ) {
        let message = format!("{what} is of an output that turns, and {output} slides");
        return Err(Error::new(Code::Conflict, message)
            .with_hint("omit it: the error of a slide is given in µm of its travel"));
    }
    Ok(chain)
}

/// Decision on the work of a generator.
fn work_decision(works: &[Arc<WorkResult>]) -> StageDecision {
    match works.last() {
        Some(work) => StageDecision::Runs(format!(
            "{} lines to first order on the flank and in the pair; together on the exact envelope",
            work.lines.len()
        )),
        None => StageDecision::LeftOut(
            "the error of the work against the cradle reaches the flank: leave `output` and `against` out".into(),
        ),
    }
}

/// Work that generators cut: the gears of this machine that name one, and, where the lines are those of the work against the cradle, its
/// own.
fn works(
    prepared_machine: &PreparedMachine,
    chain: &TransmissionChain,
    lines: &[OrderLine],
    values: &[Complex],
) -> Result<Vec<Arc<WorkResult>>, Error> {
    let mut works = prepared_machine.meshes.works.clone();
    if let Some((work, title)) = work_of(prepared_machine, chain)? {
        let machine = &prepared_machine.machine;
        let lines: Vec<(&OrderLine, Complex)> = lines.iter().zip(values.iter().copied()).collect();
        let result = WorkResult::new(work, (machine, title), chain, &lines, true)?;
        works.push(Arc::new(result));
    }
    Ok(works)
}

/// The work of a generator and its title, where a chain is that of the work against the cradle.
fn work_of<'a>(
    prepared_machine: &'a PreparedMachine,
    chain: &TransmissionChain,
) -> Result<Option<(&'a GeneratorWork, &'a str)>, Error> {
    let Some((work, title)) = &prepared_machine.work else {
        return Ok(None);
    };
    let own = ChainEnds {
        driver: chain.ends.driver,
        ..work::ends(&prepared_machine.machine, work)?
    };
    Ok((own == chain.ends).then_some((work, title)))
}

/// Refuses what [`run`] would refuse before it solves anything.
///
/// # Errors
/// Names that do not exist; no declared error; what does not go with an output that slides; settings of the work whose ratio is not that of
/// the chain.
pub fn refuse(machine: &PreparedMachine, study: &TransmissionStudy) -> Result<(), Error> {
    let chain = chain_of(machine, study)?;
    match work_of(machine, &chain)? {
        Some((work, _)) => work::check_ratio(work, &chain).map(|_| ()),
        None => Ok(()),
    }
}

/// Runs a study.
///
/// # Errors
/// Names that do not exist; ends that do not turn together; a model without errors; rigid loops that do not fit; those of the
/// equations.
pub fn run(
    prepared_machine: &PreparedMachine,
    study: &TransmissionStudy,
) -> Result<TransmissionResult, Error> {
    let PreparedMachine {
        machine,
        kinematics,
        operating,
        ..
    } = prepared_machine;
    let chain = chain_of(prepared_machine, study)?;
    let model = prepared_machine.frequency_setting(None);
    let mut all = order_lines::order_lines(machine, operating, &chain);
    let misfit = order_lines::incompatible_loop(machine, &chain, &all);
    if let Some(loop_of) = &misfit
        && loop_of
            .iter()
            .all(|&b| machine.branches[b].law == BranchLaw::Rigid)
    {
        return Err(inconsistent_loop_error(machine, loop_of));
    }
    let stiffness = loaded::stiffness_lines(&model, &chain)?;
    loaded::join_mesh_lines(machine, &mut all, stiffness);
    all.sort_by(|a, b| a.order.cmp(&b.order));
    let transfer = ErrorTransfer::new(&model, &chain, &all, ResponseMethod::Direct)?;
    let refs: Vec<&OrderLine> = all.iter().collect();
    let under_load = transfer.response_at(0.0, &refs)?;
    let output_at = |speed: f64| -> Result<f64, Error> {
        Ok(mean_speeds(machine, kinematics, Some(speed))?[chain.order_reference])
    };
    let speed = study.speed.map(output_at).transpose()?;
    let mut undamped = false;
    let map = match study.speeds {
        None => None,
        Some(range) => {
            let speeds = range.values();
            let mut amplitudes = vec![Vec::with_capacity(speeds.len()); all.len()];
            for &speed in &speeds {
                let values = transfer.at_speed(output_at(speed)?, &all)?;
                let each = amplitudes.iter_mut().zip(values);
                each.for_each(|(row, z)| row.push(z.norm()));
            }
            let mut largest: Vec<(f64, f64)> = (amplitudes.iter())
                .map(|row| {
                    let both = speeds.iter().copied().zip(row.iter().copied());
                    both.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or_default()
                })
                .collect();
            let unit = output_at(1.0)?.abs();
            let ends = speeds
                .iter()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |m, &s| {
                    (m.0.min(s), m.1.max(s))
                });
            let fastest = all
                .iter()
                .fold(0.0f64, |m, line| m.max(line.order.to_f64()));
            let most = fastest * unit * ends.0.abs().max(ends.1.abs());
            for omega in natural_frequencies(prepared_machine, transfer.ports(), (0.0, most)) {
                // Nothing damps it: there is no answer there, and what is told is of the speeds asked for.
                let Ok(values) = transfer.response_at(omega, &refs) else {
                    undamped = true;
                    continue;
                };
                for ((line, z), best) in all.iter().zip(values).zip(&mut largest) {
                    let speed = omega / (line.order.to_f64() * unit);
                    let inside = [speed, -speed]
                        .into_iter()
                        .find(|s| (ends.0..=ends.1).contains(s));
                    if let Some(speed) = inside
                        && z.norm() > best.1
                    {
                        *best = (speed, z.norm());
                    }
                }
            }
            Some(SpeedMap {
                speeds,
                amplitudes,
                largest,
            })
        }
    };
    let marks = match &study.index {
        None => None,
        Some(index) => {
            let moved = index_positions(machine, &chain, index)?;
            Some(indexing::indexing_effects(
                machine,
                &chain,
                &all,
                &moved,
                index.teeth,
            ))
        }
    };
    let at_speed = speed
        .map(|speed| transfer.at_speed(speed, &all))
        .transpose()?;
    let slow: Vec<Complex> = (all.iter().zip(&under_load))
        .map(|(line, &loaded)| match line.origin {
            LineOrigin::Declared(_) if chain.loop_conditions.is_empty() => line.quasi_static,
            _ => loaded,
        })
        .collect();
    // Of the largest line: what is common to both ends of a relative error cancels, and rounding is left.
    const MIN_AMPLITUDE_RATIO: f64 = 1e-12;
    let largest = slow.iter().fold(0.0f64, |m, z| m.max(z.norm()));
    let counts: Vec<bool> = slow
        .iter()
        .map(|z| z.norm() > MIN_AMPLITUDE_RATIO * largest)
        .collect();
    let coincidences = coincidence::coincidences(machine, &chain, &all, &counts);
    let (terms, sources, elements) = budget_terms(machine, &all, &slow);
    let window = f64::from(study.window_revs.unwrap_or(1));
    let budget = budget::error_budget(&terms, &sources, window, LATTICE_POINTS);
    let squares = budget.rss.powi(2);
    let counted = all.iter().zip(&counts).filter(|(_, counts)| **counts);
    let period = Fraction::greatest_common_divisor(counted.map(|(line, _)| &line.order))
        .map(|measure| &Fraction::one() / &measure);
    let shown = at_speed.as_ref().unwrap_or(&slow);
    let record = match study.record {
        true => Some(error_record::error_record(
            machine,
            &chain,
            &all,
            shown,
            period.as_ref(),
            study,
        )?),
        false => None,
    };
    let sums_at_speed = at_speed.as_ref().map(|values| {
        let (terms, sources, _) = budget_terms(machine, &all, values);
        let budget = budget::error_budget(&terms, &sources, window, LATTICE_POINTS);
        DynamicBudget {
            negligible: budget::negligible(&budget.elements, NEGLIGIBLE_SHARE),
            budget,
        }
    });
    let works = works(prepared_machine, &chain, &all, &slow)?;
    let mut stages = plan(machine, study);
    if prepared_machine.work.is_some() {
        stages.push(("work", work_decision(&works)));
    }
    let mut result = TransmissionResult {
        at_speed: sums_at_speed,
        negligible: budget::negligible(&budget.elements, NEGLIGIBLE_SHARE),
        budget,
        elements,
        second_order: eccentric_pair::neglected_second_order(machine, &chain),
        works,
        marks,
        map,
        record,
        period,
        inconsistent_loop: misfit
            .map(|list| list.iter().map(|&b| machine.branch_name(b)).collect()),
        wind_up: loaded::windup(&model, &chain)?,
        radius: study.radius,
        speed,
        plan: prepared_machine.after_meshes(stages),
        diagnostics: prepared_machine.warnings(),
        coincidences,
        lines: (all.into_iter().enumerate())
            .map(|(k, line)| OrderLineResult {
                kinematic: rigid_amplitude(&chain, &line),
                line,
                loaded: under_load[k],
                dynamic: at_speed.as_ref().map(|all| all[k]),
                share: match squares > 0.0 {
                    true => slow[k].norm_sqr() / squares,
                    false => 0.0,
                },
            })
            .collect(),
        chain,
    };
    result.diagnostics.extend(diagnostics(machine, &result));
    let of_pairs = result.works.iter().flat_map(|w| w.pair.diagnostics.clone());
    let of_pairs: Vec<Diagnostic> = of_pairs.collect();
    result.diagnostics.extend(of_pairs);
    if undamped {
        result.diagnostics.push(Diagnostic {
            code: "undamped",
            message: "some resonances between the speeds are undamped: lines are infinite there, and the maxima given are those at the requested speeds".to_string(),
            hint: Some("give branches a damping_ratio or c".to_string()),
        });
    }
    Ok(result)
}

/// A line with rigid joints, where these can turn with it; what gives way adds nothing there, and a mesh has its error without load.
fn rigid_amplitude(chain: &TransmissionChain, line: &OrderLine) -> Option<Complex> {
    match line.origin {
        LineOrigin::Stiffness(_) => Some(line.quasi_static),
        LineOrigin::Declared(_) => {
            order_lines::is_compatible(chain, line).then_some(line.quasi_static)
        }
    }
}

/// Lattice points a shift of the budget's percentiles.
const LATTICE_POINTS: usize = 61;

/// Negligible share of the root of the sum of squares.
pub const NEGLIGIBLE_SHARE: f64 = 0.01;

/// Terms, sources and names of elements: each declared error is a source, errors on one node are one element.
fn budget_terms(
    machine: &Machine,
    lines: &[OrderLine],
    values: &[Complex],
) -> (
    Vec<HarmonicTerm>,
    Vec<range_distribution::ErrorSource>,
    Vec<String>,
) {
    let mut sources: Vec<(LineOrigin, range_distribution::ErrorSource)> = Vec::new();
    let mut elements: Vec<String> = Vec::new();
    let mut terms = Vec::new();
    for (line, &value) in lines.iter().zip(values) {
        let known = sources.iter().position(|s| s.0 == line.origin);
        let source = known.unwrap_or_else(|| {
            let name = match line.origin {
                LineOrigin::Declared(number) => machine.errors[number].element.clone(),
                LineOrigin::Stiffness(branch) => machine.branch_name(branch),
            };
            let known = elements.iter().position(|e| *e == name);
            let element = known.unwrap_or_else(|| {
                elements.push(name);
                elements.len() - 1
            });
            let source = range_distribution::ErrorSource {
                element,
                phase_known: line.phase_known(machine),
                tolerance: line.declared(machine).map_or(0.0, |error| error.tolerance),
                graded: (line.declared(machine)).is_some_and(|error| error.averaged.is_none()),
            };
            sources.push((line.origin, source));
            sources.len() - 1
        });
        terms.push(HarmonicTerm {
            source,
            order: line.order.to_f64(),
            harmonic: line.harmonic,
            value,
        });
    }
    let sources = sources.into_iter().map(|s| s.1).collect();
    (terms, sources, elements)
}

/// True for every degree of freedom that moves on with the work from tooth to tooth.
fn index_positions(
    machine: &Machine,
    chain: &TransmissionChain,
    index: &IndexingStudy,
) -> Result<Vec<bool>, Error> {
    let named = machine
        .elements
        .iter()
        .position(|e| e.name == index.element);
    let Some(element) = named else {
        let known = machine.elements.iter().map(|e| e.name.as_str());
        let hint = match suggestion(&index.element, known) {
            Some(meant) => format!("did you mean `{meant}`?"),
            None => "name a pair or a shaft of the model".to_string(),
        };
        let message = format!("there is no element `{}`", index.element);
        return Err(Error::new(Code::UnknownNode, message).with_hint(hint));
    };
    let side = coincidence::connected_side(machine, element, chain.ends.output);
    if side[chain.ends.driver] {
        let message = format!(
            "`{}` does not lie between the driver and the output",
            index.element
        );
        return Err(Error::new(Code::Conflict, message)
            .with_hint("name the element behind which the work is moved on: the differential"));
    }
    Ok(side)
}

/// The angle of a node, the travel of a slide.
///
/// # Errors
/// `UnknownNode`.
pub fn angle_dof(machine: &Machine, name: &str) -> Result<usize, Error> {
    machine.dof(name).ok_or_else(|| {
        let known = machine.nodes.iter().map(|node| node.name.as_str());
        let hint = match suggestion(name, known) {
            Some(meant) => format!("did you mean `{meant}`?"),
            None => "name a node of the model".to_string(),
        };
        Error::new(Code::UnknownNode, format!("there is no node `{name}`")).with_hint(hint)
    })
}

fn inconsistent_loop_error(machine: &Machine, loop_of: &[usize]) -> Error {
    let names: Vec<String> = loop_of
        .iter()
        .map(|&b| format!("`{}`", machine.branch_name(b)))
        .collect();
    let message = format!(
        "the errors of {} do not fit: these rigid joints close a loop, which would have to break",
        names.join(", ")
    );
    let element = machine.branches[loop_of[0]].element;
    Error::new(Code::ContradictoryRatios, message)
        .with_span(&machine.elements[element].span)
        .with_hint("give the joints of the loop their stiffness k: it shares the errors out")
}

fn diagnostics(machine: &Machine, result: &TransmissionResult) -> Vec<Diagnostic> {
    let mut all = Vec::new();
    let mut warn = |code, message: String, hint: &str| {
        all.push(Diagnostic {
            code,
            message,
            hint: Some(hint.to_string()),
        });
    };
    if let Some(names) = &result.inconsistent_loop {
        let message = format!(
            "the errors do not fit the loop through {}: with rigid joints it could not turn",
            names.join(", ")
        );
        warn(
            "loop-misfit",
            message,
            "the table is that of the elastic joints, which share the errors out",
        );
    }
    let still: Vec<&str> = (machine.errors.iter().enumerate())
        .filter(|(number, error)| {
            let has_line = result
                .lines
                .iter()
                .any(|row| row.line.origin == LineOrigin::Declared(*number));
            // Flanks of gear files may have joined the lines of their meshes.
            let own = error.averaged.is_none();
            own && !has_line && !error.waveform.harmonics().iter().all(|h| h.1 == 0.0)
        })
        .map(|(_, error)| error.location.as_str())
        .collect();
    if !still.is_empty() {
        let message = format!(
            "errors of elements that do not turn with the output have no line: {}",
            still.join(", ")
        );
        warn(
            "still",
            message,
            "they do not turn, or their speed is not tied to the output's",
        );
    }
    // What lies on the far side of a friction belt, and still has a line.
    let slips = |at: usize| {
        let pulley = machine
            .gears
            .iter()
            .any(|g| g.element == at && g.teeth.is_none());
        let near = coincidence::connected_side(machine, at, result.chain.ends.output);
        let across = result.lines.iter().any(|row| {
            let far = row
                .line
                .declared(machine)
                .is_some_and(|error| !near[error.rotation_dof]);
            far && row.share > 0.0
        });
        machine.elements[at].kind == "belt" && pulley && across
    };
    if let Some(at) = (0..machine.elements.len()).find(|&at| slips(at)) {
        let name = &machine.elements[at].name;
        let message =
            format!("{name} is no gear: if it slips, the orders of what lies beyond it wander");
        warn(
            "belt",
            message,
            "orders across a belt hold to its slip; a timing belt does not slip",
        );
    }
    all
}

/// Stages of a study, run and left out.
pub fn plan(machine: &Machine, study: &TransmissionStudy) -> Vec<(&'static str, StageDecision)> {
    let runs = |text: &str| StageDecision::Runs(text.to_string());
    let out = |text: &str| StageDecision::LeftOut(text.to_string());
    let waves = machine
        .branches
        .iter()
        .any(|b| b.stiffness_variation.is_some());
    vec![
        ("ratios", runs("exact fractions of tooth numbers")),
        (
            "rigid joints",
            StageDecision::Runs(format!(
                "{} declared errors to the output",
                machine.errors.len()
            )),
        ),
        (
            "static transmission",
            runs("elastic joints at rest, the driver's angle held"),
        ),
        (
            "mesh stiffness under load",
            match (waves, machine.loads.is_empty()) {
                (true, false) => runs("what carries a torque gives way as its stiffness changes"),
                (true, true) => out("no load is stated"),
                (false, _) => out("no mesh has a stiffness wave"),
            },
        ),
        (
            "at speed",
            match (study.speed, study.speeds) {
                (None, None) => out("no speed was requested"),
                _ => runs("the dynamic stiffness solved at every order"),
            },
        ),
        (
            "budget",
            runs("sums, and percentiles of the range over unknown phases and tolerances"),
        ),
        (
            "second order of offsets",
            out("given as a sum, not line by line"),
        ),
        (
            "flank form and pitch",
            match study.index {
                Some(_) => runs("what repeats from tooth to tooth and what does not"),
                None => out("the work is not indexed"),
            },
        ),
        (
            "record",
            match study.record {
                true => runs("the error over the angle, with its ranges"),
                false => out("no record was requested"),
            },
        ),
    ]
}
