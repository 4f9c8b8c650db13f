//! Transmission-error study: kinematic, quasi-static and dynamic order lines, error budget, coinciding orders.

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

/// Stage decision on the workpiece of a generator.
fn work_decision(works: &[Arc<WorkResult>]) -> StageDecision {
    match works.last() {
        Some(work) => StageDecision::Runs(format!(
            "{} lines to first order on the flank and in the pair; together on the exact envelope",
            work.lines.len()
        )),
        None => StageDecision::LeftOut(
            "the error of the work against the cradle reaches the flank: omit `output` and `against`".into(),
        ),
    }
}

/// Workpieces of generators: those of the gears of this machine and, if the chain leads from the cradle to the work, that of the machine
/// itself.
fn works(
    prepared_machine: &PreparedMachine,
    chain: &TransmissionChain,
    lines: &[OrderLine],
    values: &[Complex],
) -> Result<Vec<Arc<WorkResult>>, Error> {
    let mut works = prepared_machine.meshes.workpieces.clone();
    if let Some((work, title)) = work_of(prepared_machine, chain)? {
        let machine = &prepared_machine.machine;
        let lines: Vec<(&OrderLine, Complex)> = lines.iter().zip(values.iter().copied()).collect();
        let result = WorkResult::new(work, (machine, title), chain, &lines, true)?;
        works.push(Arc::new(result));
    }
    Ok(works)
}

/// Workpiece of a generator with the title of the machine; `None` unless the chain leads from the cradle to the work.
fn work_of<'a>(
    prepared_machine: &'a PreparedMachine,
    chain: &TransmissionChain,
) -> Result<Option<(&'a GeneratorWork, &'a str)>, Error> {
    let Some((work, title)) = &prepared_machine.work else {
        return Ok(None);
    };
    let work_chain = ChainEnds {
        driver: chain.ends.driver,
        ..work::ends(&prepared_machine.machine, work)?
    };
    Ok((work_chain == chain.ends).then_some((work, title)))
}

/// Checks a study before [`run`] solves it.
///
/// # Errors
/// A name does not exist; no error is declared; an option does not apply to a translating output; the ratio of the work settings differs
/// from that of the chain.
pub fn check_study(machine: &PreparedMachine, study: &TransmissionStudy) -> Result<(), Error> {
    let chain = chain_of(machine, study)?;
    if let Some(index) = &study.index {
        index_positions(&machine.machine, &chain, index)?;
    }
    match work_of(machine, &chain)? {
        Some((work, _)) => work::check_ratio(work, &chain).map(|_| ()),
        None => Ok(()),
    }
}

/// Runs a transmission-error study.
///
/// # Errors
/// A name does not exist; the ends are not kinematically coupled; no error is declared; a rigid loop is incompatible; errors of the
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
    let model = prepared_machine.operating_model(None);
    let mut lines = order_lines::order_lines(machine, operating, &chain);
    let incompatible_loop = order_lines::incompatible_loop(machine, &chain, &lines);
    if let Some(branches) = &incompatible_loop
        && branches
            .iter()
            .all(|&b| machine.branches[b].law == BranchLaw::Rigid)
    {
        return Err(diagnostics::inconsistent_loop_error(machine, branches));
    }
    let stiffness = loaded::stiffness_lines(&model, &chain)?;
    loaded::join_mesh_lines(machine, &mut lines, stiffness);
    lines.sort_by(|a, b| a.order.cmp(&b.order));
    let transfer = ErrorTransfer::new(&model, &chain, &lines, ResponseMethod::Direct)?;
    let line_refs: Vec<&OrderLine> = lines.iter().collect();
    let loaded_values = transfer.response_at(0.0, &line_refs)?;
    let output_at = |speed: f64| -> Result<f64, Error> {
        Ok(mean_speeds(machine, kinematics, Some(speed))?[chain.order_reference])
    };
    let speed = study.speed.map(output_at).transpose()?;
    let map = (study.speeds)
        .map(|range| {
            let speeds = range.values();
            let output_speeds = speeds.iter().map(|&s| output_at(s));
            let output_speeds = output_speeds.collect::<Result<Vec<f64>, Error>>()?;
            let ratio = output_at(1.0)?.abs();
            SpeedMap::new((&transfer, &model), &lines, (speeds, &output_speeds), ratio)
        })
        .transpose()?;
    let indexing_effects = match &study.index {
        None => None,
        Some(index) => {
            let index_at = index_positions(machine, &chain, index)?;
            Some(indexing::indexing_effects(
                machine,
                &chain,
                &lines,
                &index_at,
                index.teeth,
            ))
        }
    };
    let at_speed = speed
        .map(|speed| transfer.at_speed(speed, &lines))
        .transpose()?;
    let quasi_static: Vec<Complex> = (lines.iter().zip(&loaded_values))
        .map(|(line, &loaded)| match line.origin {
            LineOrigin::Declared(_) if chain.loop_conditions.is_empty() => line.quasi_static,
            _ => loaded,
        })
        .collect();
    // Relative to the largest line; below it a line is the rounding error of contributions that cancel between both ends.
    const MIN_AMPLITUDE_RATIO: f64 = 1e-12;
    let largest = quasi_static.iter().fold(0.0f64, |m, z| m.max(z.norm()));
    let is_significant: Vec<bool> = quasi_static
        .iter()
        .map(|z| z.norm() > MIN_AMPLITUDE_RATIO * largest)
        .collect();
    let coincidences = coincidence::coincidences(machine, &chain, &lines, &is_significant);
    let window = f64::from(study.window_revs.unwrap_or(1));
    let (budget, elements) = budget::line_budget(machine, &lines, &quasi_static, window);
    let squares = budget.rss.powi(2);
    let counted = lines.iter().zip(&is_significant).filter(|pair| *pair.1);
    let period = Fraction::greatest_common_divisor(counted.map(|(line, _)| &line.order))
        .map(|measure| &Fraction::one() / &measure);
    let record_values = at_speed.as_ref().unwrap_or(&quasi_static);
    let record = match study.record {
        true => Some(error_record::error_record(
            machine,
            &chain,
            &lines,
            record_values,
            period.as_ref(),
            study,
        )?),
        false => None,
    };
    let sums_at_speed = at_speed.as_ref().map(|values| {
        let (budget, _) = budget::line_budget(machine, &lines, values, window);
        DynamicBudget {
            negligible: budget::negligible(&budget.elements, NEGLIGIBLE_SHARE),
            budget,
        }
    });
    let works = works(prepared_machine, &chain, &lines, &quasi_static)?;
    let mut stages = stages::plan(machine, study);
    if prepared_machine.work.is_some() {
        stages.push(("work", work_decision(&works)));
    }
    let mut result = TransmissionResult {
        dynamic_budget: sums_at_speed,
        negligible: budget::negligible(&budget.elements, NEGLIGIBLE_SHARE),
        budget,
        elements,
        second_order: eccentric_pair::neglected_second_order(machine, &chain),
        workpieces: works,
        indexing_effects,
        map,
        record,
        period,
        inconsistent_loop: incompatible_loop
            .map(|list| list.iter().map(|&b| machine.branch_name(b)).collect()),
        wind_up: loaded::windup(&model, &chain)?,
        radius: study.radius,
        speed,
        plan: prepared_machine.after_meshes(stages),
        diagnostics: prepared_machine.warnings(),
        coincidences,
        lines: (lines.into_iter().enumerate())
            .map(|(k, line)| OrderLineResult {
                kinematic: rigid_amplitude(&chain, &line),
                line,
                loaded: loaded_values[k],
                dynamic: at_speed.as_ref().map(|lines| lines[k]),
                share: match squares > 0.0 {
                    true => quasi_static[k].norm_sqr() / squares,
                    false => 0.0,
                },
            })
            .collect(),
        chain,
    };
    let own_diagnostics = diagnostics::diagnostics(machine, &result);
    result.diagnostics.extend(own_diagnostics);
    let pair_diagnostics = result
        .workpieces
        .iter()
        .flat_map(|work| work.pair.diagnostics.clone());
    let pair_diagnostics: Vec<Diagnostic> = pair_diagnostics.collect();
    result.diagnostics.extend(pair_diagnostics);
    if result.map.as_ref().is_some_and(|map| map.is_undamped) {
        result.diagnostics.push(Diagnostic {
            code: "undamped",
            message: "some resonances between the speeds are undamped: lines are infinite there, and the maxima given are those at the requested speeds".to_string(),
            hint: Some("give branches a damping_ratio or c".to_string()),
        });
    }
    Ok(result)
}

/// Amplitude of a line with rigid joints and unloaded meshes; `None` if rigid joints are incompatible with the line.
fn rigid_amplitude(chain: &TransmissionChain, line: &OrderLine) -> Option<Complex> {
    match line.origin {
        LineOrigin::Stiffness(_) => Some(line.quasi_static),
        LineOrigin::Declared(_) => {
            order_lines::is_compatible(chain, line).then_some(line.quasi_static)
        }
    }
}

/// Share of the root sum of squares below which an element is negligible.
pub const NEGLIGIBLE_SHARE: f64 = 0.01;
