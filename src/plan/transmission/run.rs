//! Transmission-error study: rigid, quasi-static and dynamic order lines, budget, coinciding orders.

use std::sync::Arc;

use super::chain::{chain_of, index_positions};
use super::result::{DynamicBudget, OrderLineResult, TransmissionResult};
use super::{diagnostics, error_record, stages};
use crate::base::error::{Diagnostic, Error};
use crate::machine::components::BranchLaw;
use crate::machine::kinematics::mean_speeds;
use crate::numeric::Complex;
use crate::numeric::fraction::Fraction;
use crate::plan::meshes::work::{self, WorkResult};
use crate::plan::prepared_machine::PreparedMachine;
use crate::plan::stages::StageDecision;
use crate::response::frf::ResponseMethod;
use crate::scene::model::GeneratorWork;
use crate::scene::study::TransmissionStudy;
use crate::transmission::chain::{ChainEnds, TransmissionChain};
use crate::transmission::dynamic::ErrorTransfer;
use crate::transmission::order_lines::{self, LineOrigin, OrderLine};
use crate::transmission::speed_map::SpeedMap;
use crate::transmission::{budget, coincidence, eccentric_pair, indexing, loaded};

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
    if let Some(index) = &study.index {
        index_positions(&machine.machine, &chain, index)?;
    }
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
        return Err(diagnostics::inconsistent_loop_error(machine, loop_of));
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
    let map = (study.speeds)
        .map(|range| {
            let speeds = range.values();
            let turned = speeds.iter().map(|&s| output_at(s));
            let turned = turned.collect::<Result<Vec<f64>, Error>>()?;
            let ratio = output_at(1.0)?.abs();
            SpeedMap::new((&transfer, &model), &all, (speeds, &turned), ratio)
        })
        .transpose()?;
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
    let window = f64::from(study.window_revs.unwrap_or(1));
    let (budget, elements) = budget::line_budget(machine, &all, &slow, window);
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
        let (budget, _) = budget::line_budget(machine, &all, values, window);
        DynamicBudget {
            negligible: budget::negligible(&budget.elements, NEGLIGIBLE_SHARE),
            budget,
        }
    });
    let works = works(prepared_machine, &chain, &all, &slow)?;
    let mut stages = stages::plan(machine, study);
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
    let own = diagnostics::diagnostics(machine, &result);
    result.diagnostics.extend(own);
    let of_pairs = result.works.iter().flat_map(|w| w.pair.diagnostics.clone());
    let of_pairs: Vec<Diagnostic> = of_pairs.collect();
    result.diagnostics.extend(of_pairs);
    if result.map.as_ref().is_some_and(|map| map.is_undamped) {
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

/// Negligible share of the root of the sum of squares.
pub const NEGLIGIBLE_SHARE: f64 = 0.01;
