//! Periodic solutions over speed as JSON, CSV and plot.

use std::f64::consts::TAU;

use serde_json::{Value, json};

use super::amplitude_plot::{AmplitudePlot, amplitude_figure};
use super::figure::{Figure, PlotColumn};
use super::harmonic_balance_table::{self, bifurcation_name};
use super::json::complex;
use super::number_format::{choose_unit, rpm};
use super::plan::{step_lines, steps};
use super::presentation::{Presentation, Provenance, StudyReport};
use super::svg::significant;
use super::table::{Table, decimal};
use crate::base::error::Error;
use crate::plan::response::harmonic_balance::HarmonicBalanceResult;
use crate::response::harmonic_balance::bifurcation::{Bifurcation, BifurcationKind};
use crate::response::harmonic_balance::point::{PeriodicSolution, Refinement};

impl Presentation for StudyReport<'_, HarmonicBalanceResult> {
    fn provenance(&self) -> Provenance<'_> {
        let result = &self.result;
        Provenance {
            effort: json!({ "run_time_s": result.seconds }),
            title: &self.scene.model.title,
            ..Provenance::of_plan(&self.scene.sources, &result.plan, &result.diagnostics)
        }
    }

    fn body(&self) -> Result<Value, Error> {
        let result = &self.result;
        let special = |(s, jump): (&Bifurcation, &Option<f64>)| {
            let mut value = motion(result, &s.point);
            value["kind"] = json!(bifurcation_name(s.kind));
            value["rising_speed"] = json!(s.point.frequency_tangent > 0.0);
            value["after_point"] = json!(s.after);
            value["jumps_to"] = json!(jump);
            value
        };
        let tongues = match &result.instability_tongues {
        Ok(found) => json!(found.iter().map(|t| json!({
            "from_rpm": rpm(result.speed(t.from)), "to_rpm": rpm(result.speed(t.to)), "worst_rpm": rpm(result.speed(t.most_unstable)),
            "growth_per_period": t.growth, "name": t.name,
        })).collect::<Vec<_>>()),
        Err(why) => json!({ "left_out": why }),
    };
        Ok(json!({
            "node": result.node,
            "outputs": result.outputs.iter().map(|(name, unit)| json!({ "name": name, "unit": unit })).collect::<Vec<_>>(),
            "nonlinear": result.branches,
            "bifurcations": result.curve.bifurcations.iter().zip(&result.jumps).map(special).collect::<Vec<_>>(),
            "points": result.curve.points.iter().map(|p| motion(result, p)).collect::<Vec<_>>(),
            "period_doubled": result.curve.period_doubled.iter().map(|d| json!({
                "born_at_bifurcation": d.bifurcation,
                "points": d.points.iter().map(|p| motion(result, p)).collect::<Vec<_>>(),
            })).collect::<Vec<_>>(),
            "tongues": tongues,
            "complete": result.curve.stopped_by.is_none(),
        }))
    }

    fn text(&self) -> String {
        harmonic_balance_table::text(&self.result)
    }

    fn table(&self) -> Table<'_> {
        let result = &self.result;
        let mut table = Table::new(
            "speed [rpm]|frequency [Hz]|stable|largest multiplier|orders|left out|found by|periods",
        );
        for (name, unit) in &result.outputs {
            for part in ["amplitude", "mean", "max", "min", "rms"] {
                table = table.column(&format!("{name} {part}"), unit);
            }
        }
        let single = result.curve.points.iter().map(|p| (p, 1));
        let doubled = result.curve.period_doubled.iter().flat_map(|d| &d.points);
        for (p, periods) in single.chain(doubled.map(|p| (p, 2))) {
            let motion = [
                decimal(rpm(result.speed(p.omega))),
                decimal(p.omega / TAU),
                (p.unstable_count() == 0).to_string(),
                decimal(p.multipliers.first().map_or(0.0, |m| m.norm())),
                p.orders.to_string(),
                decimal(p.truncation_error),
                solution_kind(p).to_string(),
                periods.to_string(),
            ];
            let parts =
                (p.outputs.iter()).flat_map(|o| [o.amplitude(), o.mean, o.max, o.min, o.std_dev]);
            table.row(motion.into_iter().chain(parts.map(decimal)));
        }
        table
    }

    fn figures(&self) -> Result<Vec<Figure>, Error> {
        Ok(vec![Figure::first(plots(
            &self.scene.model.title,
            &self.result,
        ))])
    }

    fn notes(&self) -> String {
        let (exact, rest) = self.result.refinement_counts();
        let found = format!("{exact} motions found by events, {rest} by orders\n");
        found + &step_lines(steps(&self.result.plan))
    }
}

fn motion(result: &HarmonicBalanceResult, p: &PeriodicSolution) -> Value {
    json!({
        "speed_rpm": rpm(result.speed(p.omega)),
        "frequency_hz": p.omega / TAU,
        "stable": p.unstable_count() == 0,
        "multipliers": p.multipliers.iter().map(|&m| complex(m)).collect::<Vec<_>>(),
        "orders": p.orders,
        "left_out": p.truncation_error,
        "found_by": solution_kind(p),
        "outputs": p.outputs.iter().map(|o| json!({
            "amplitude": o.amplitude(), "mean": o.mean, "max": o.max, "min": o.min, "rms": o.std_dev,
        })).collect::<Vec<_>>(),
    })
}

fn solution_kind(p: &PeriodicSolution) -> &'static str {
    match p.refinement {
        Refinement::Shooting => "events",
        Refinement::HarmonicBalance => "orders",
    }
}

/// The jump curve of the first output.
fn plots(title: &str, result: &HarmonicBalanceResult) -> PlotColumn {
    let (name, unit) = result
        .outputs
        .first()
        .map_or(("", ""), |(n, u)| (n.as_str(), u));
    let amplitude = |p: &PeriodicSolution| p.outputs.first().map_or(0.0, |o| o.amplitude());
    let (factor, unit) = choose_unit(
        result
            .curve
            .points
            .iter()
            .chain(result.curve.period_doubled.iter().flat_map(|d| &d.points))
            .map(amplitude)
            .fold(0.0, f64::max),
        unit,
    );
    let at = |p: &PeriodicSolution| (rpm(result.speed(p.omega)), factor * amplitude(p));
    let shown = |p: &PeriodicSolution| {
        let (x, y) = at(p);
        (x, y, p.unstable_count() == 0)
    };
    let mark = |s: &Bifurcation| {
        let (speed, height) = at(&s.point);
        (
            speed,
            height,
            format!("{} {}", bifurcation_name(s.kind), significant(speed, 5)),
        )
    };
    let jump = |(s, to): (&Bifurcation, &Option<f64>)| {
        let (speed, from) = at(&s.point);
        (s.kind == BifurcationKind::Fold).then_some((speed, from, factor * (*to)?))
    };
    let tongues = result.instability_tongues.as_ref().map_or(Vec::new(), |t| {
        t.iter()
            .map(|t| {
                (
                    rpm(result.speed(t.from)),
                    rpm(result.speed(t.to)),
                    t.name.clone(),
                )
            })
            .collect()
    });
    amplitude_figure(&AmplitudePlot {
        title: title.to_string(),
        across: format!("speed of {}, rpm", result.node),
        up: format!("{name}, half of peak to peak, {unit}"),
        points: points_with_folds(result).into_iter().map(shown).collect(),
        others: (result.curve.period_doubled.iter())
            .map(|d| d.points.iter().map(shown).collect())
            .collect(),
        marks: result.curve.bifurcations.iter().map(mark).collect(),
        jumps: result
            .curve
            .bifurcations
            .iter()
            .zip(&result.jumps)
            .filter_map(jump)
            .collect(),
        bands: tongues,
    })
}

/// Points with the folds among them, so that the line goes through these.
fn points_with_folds(result: &HarmonicBalanceResult) -> Vec<&PeriodicSolution> {
    let curve = &result.curve;
    let mut all = Vec::with_capacity(curve.points.len() + curve.bifurcations.len());
    for (at, p) in curve.points.iter().enumerate() {
        all.push(p);
        all.extend(
            curve
                .bifurcations
                .iter()
                .filter(|s| s.after == at)
                .map(|s| &s.point),
        );
    }
    all
}
