//! Periodic motions over speed as tables for a terminal: folds and bifurcations, segments, resonances.

use super::number_format::{choose_unit, four_digits, rpm, significant};
use super::table::{Table, or_dash};
use crate::base::text::pluralise;
use crate::plan::response::harmonic_balance::HarmonicBalanceResult;
use crate::response::harmonic_balance::bifurcation::{Bifurcation, BifurcationKind};
use crate::response::harmonic_balance::point::PeriodicSolution;

/// The tables.
pub fn text(result: &HarmonicBalanceResult) -> String {
    let amplitude = |p: &PeriodicSolution| p.outputs.first().map_or(0.0, |o| o.amplitude());
    let (name, unit) = result
        .outputs
        .first()
        .map_or(("", ""), |(n, u)| (n.as_str(), u));
    let largest = result
        .curve
        .points
        .iter()
        .max_by(|a, b| amplitude(a).total_cmp(&amplitude(b)));
    let (factor, unit) = choose_unit(largest.map_or(0.0, amplitude), unit);
    let mut text = format!(
        "{name} over the speed of {}: {}",
        result.node,
        pluralise(result.curve.points.len(), "motion")
    );
    if let Some(p) = largest {
        text += &format!(
            ", the largest {} {unit} (half of peak to peak) at {} rpm\n",
            four_digits(factor * amplitude(p)),
            significant(rpm(result.speed(p.omega)))
        );
    }
    if result.curve.bifurcations.is_empty() {
        let stable = result.curve.points.iter().all(|p| p.unstable_count() == 0);
        text += match stable {
            true => "no fold, no bifurcation: all motions are stable\n",
            false => "no fold, no bifurcation: all motions are unstable\n",
        };
    } else {
        let mut table = Table::new("speed [rpm]|frequency [Hz]")
            .column("amplitude", &unit)
            .column("jumps to", &unit)
            .columns("multiplier|bifurcation");
        for (s, jump) in result.curve.bifurcations.iter().zip(&result.jumps) {
            let multiplier = or_dash(s.point.multipliers.first(), |m| {
                let sign = if m.im == 0.0 && m.re < 0.0 { "−" } else { "" };
                format!("{sign}{}", four_digits(m.norm()))
            });
            table.row([
                significant(rpm(result.speed(s.point.omega))),
                significant(s.point.omega / std::f64::consts::TAU),
                four_digits(factor * amplitude(&s.point)),
                or_dash(*jump, |j| four_digits(factor * j)),
                multiplier,
                describe_bifurcation(s),
            ]);
        }
        text += &table.text();
    }
    text += &period_doubled_text(result, factor, &unit);
    if let Ok(tongues) = &result.instability_tongues {
        for t in tongues {
            text += &format!(
                "parametric resonance {}: closed contacts are unstable from {} to {} rpm, growth {} % a period at {} rpm\n",
                t.name,
                significant(rpm(result.speed(t.from))),
                significant(rpm(result.speed(t.to))),
                four_digits(100.0 * (t.growth - 1.0)),
                significant(rpm(result.speed(t.most_unstable))),
            );
        }
    }
    text
}

/// The name of what happens.
pub(super) fn bifurcation_name(kind: BifurcationKind) -> &'static str {
    match kind {
        BifurcationKind::Fold => "fold",
        BifurcationKind::PeriodDoubling => "period doubling",
        BifurcationKind::NeimarkSacker => "Neimark–Sacker",
        BifurcationKind::BranchPoint => "branching",
    }
}

/// Description of a bifurcation, seen from the motion the curve came along.
fn describe_bifurcation(s: &Bifurcation) -> String {
    let sense = if s.point.frequency_tangent > 0.0 {
        "rising"
    } else {
        "falling"
    };
    match s.kind {
        BifurcationKind::Fold => format!("fold: end of the branch for {sense} speed"),
        kind => bifurcation_name(kind).to_string(),
    }
}

/// Description of the period-doubled motions that begin at doublings.
fn period_doubled_text(result: &HarmonicBalanceResult, factor: f64, unit: &str) -> String {
    let curve = &result.curve;
    let speed = |p: &PeriodicSolution| significant(rpm(result.speed(p.omega)));
    let mut text = String::new();
    for (at, special) in curve.bifurcations.iter().enumerate() {
        if special.kind != BifurcationKind::PeriodDoubling {
            continue;
        }
        let born = speed(&special.point);
        let Some(found) = curve.period_doubled.iter().find(|d| d.bifurcation == at) else {
            let reached =
                |d: &&crate::response::harmonic_balance::period_doubling::PeriodDoubledBranch| {
                    d.covers_point(special.after)
                };
            text += &match curve.period_doubled.iter().find(reached) {
                Some(_) => format!(
                    "the period doubling at {born} rpm ends the double-period motions listed above\n"
                ),
                None => format!(
                    "the motion of two periods born at {born} rpm was not found: simulate in time\n"
                ),
            };
            continue;
        };
        let (first, last) = (&found.points[0], &found.points[found.points.len() - 1]);
        let stable = found
            .points
            .iter()
            .filter(|p| p.unstable_count() == 0)
            .count();
        let largest = found
            .points
            .iter()
            .filter_map(|p| p.outputs.first())
            .map(|o| o.amplitude())
            .fold(0.0, f64::max);
        text += &format!(
            "{} of two periods, born at {born} rpm, from {} to {} rpm, {} stable, the largest {} {unit}\n",
            pluralise(found.points.len(), "motion"),
            speed(first),
            speed(last),
            match stable {
                n if n == found.points.len() => "all".to_string(),
                0 => "none".to_string(),
                n => n.to_string(),
            },
            four_digits(factor * largest)
        );
    }
    text
}
