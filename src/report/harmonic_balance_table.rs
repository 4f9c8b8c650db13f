//! Periodic motions over speed as tables for a terminal: folds and bifurcations, stretches, resonances.

use super::harmonic_balance::{named, rpm, scaled};
use super::number::{brief, significant};
use super::table::{finish, plain, right_but_last};
use crate::base::words::counted;
use crate::plan::response::harmonic_balance::Answer;
use crate::response::harmonic::point::Point;
use crate::response::harmonic::special::{Kind, Special};

/// The tables.
pub fn table(answer: &Answer) -> String {
    let amplitude = |p: &Point| p.outputs.first().map_or(0.0, |o| o.amplitude());
    let (name, unit) = answer
        .outputs
        .first()
        .map_or(("", ""), |(n, u)| (n.as_str(), u));
    let largest = answer
        .curve
        .points
        .iter()
        .max_by(|a, b| amplitude(a).total_cmp(&amplitude(b)));
    let (factor, unit) = scaled(largest.map_or(0.0, amplitude), unit);
    let mut text = format!(
        "{name} over the speed of {}: {}",
        answer.node,
        counted(answer.curve.points.len(), "motion")
    );
    if let Some(p) = largest {
        text += &format!(
            ", the largest {} {unit} (half of peak to peak) at {} rpm\n",
            brief(factor * amplitude(p)),
            significant(rpm(answer.speed(p.omega)))
        );
    }
    if answer.curve.specials.is_empty() {
        let stable = answer.curve.points.iter().all(|p| p.unstable() == 0);
        text += match stable {
            true => "no fold, no bifurcation: every motion is stable\n",
            false => "no fold, no bifurcation: every motion is unstable\n",
        };
    } else {
        let mut table = plain();
        table.add_row(vec![
            "speed",
            "frequency",
            "amplitude",
            "jumps to",
            "multiplier",
            "what happens",
        ]);
        table.add_row(vec!["rpm", "Hz", &unit, &unit, "", ""]);
        for (s, jump) in answer.curve.specials.iter().zip(&answer.jumps) {
            let multiplier = s.point.multipliers.first().map_or("–".to_string(), |m| {
                let sign = if m.im == 0.0 && m.re < 0.0 { "−" } else { "" };
                format!("{sign}{}", brief(m.norm()))
            });
            table.add_row(vec![
                significant(rpm(answer.speed(s.point.omega))),
                significant(s.point.omega / std::f64::consts::TAU),
                brief(factor * amplitude(&s.point)),
                jump.map_or("–".to_string(), |j| brief(factor * j)),
                multiplier,
                happens(s),
            ]);
        }
        right_but_last(&mut table);
        text += &finish(&table);
    }
    text += &doubled(answer, factor, &unit);
    if let Ok(tongues) = &answer.tongues {
        for t in tongues {
            text += &format!(
                "parametric resonance {}: closed contacts are unstable from {} to {} rpm, growth {} % a period at {} rpm\n",
                t.name,
                significant(rpm(answer.speed(t.from))),
                significant(rpm(answer.speed(t.to))),
                brief(100.0 * (t.growth - 1.0)),
                significant(rpm(answer.speed(t.worst))),
            );
        }
    }
    text
}

/// What happens at a special place, seen from the motion the curve came along.
fn happens(s: &Special) -> String {
    let sense = if s.point.sense > 0.0 {
        "rising"
    } else {
        "falling"
    };
    match s.kind {
        Kind::Fold => format!("fold: the end for {sense} speed"),
        kind => named(kind).to_string(),
    }
}

/// What the motions of two periods do that doublings begin.
fn doubled(answer: &Answer, factor: f64, unit: &str) -> String {
    let curve = &answer.curve;
    let speed = |p: &Point| significant(rpm(answer.speed(p.omega)));
    let mut text = String::new();
    for (at, special) in curve.specials.iter().enumerate() {
        if special.kind != Kind::PeriodDoubling {
            continue;
        }
        let born = speed(&special.point);
        let Some(found) = curve.doubled.iter().find(|d| d.born == at) else {
            let reached =
                |d: &&crate::response::harmonic::doubled::Doubled| d.stands_beside(special.after);
            text += &match curve.doubled.iter().find(reached) {
                Some(_) => format!(
                    "the doubling at {born} rpm ends the motions of two periods told above\n"
                ),
                None => format!(
                    "the motion of two periods born at {born} rpm was not found: simulate in time to see it\n"
                ),
            };
            continue;
        };
        let (first, last) = (&found.points[0], &found.points[found.points.len() - 1]);
        let stable = found.points.iter().filter(|p| p.unstable() == 0).count();
        let largest = found
            .points
            .iter()
            .filter_map(|p| p.outputs.first())
            .map(|o| o.amplitude())
            .fold(0.0, f64::max);
        text += &format!(
            "{} of two periods, born at {born} rpm, from {} to {} rpm, {} stable, the largest {} {unit}\n",
            counted(found.points.len(), "motion"),
            speed(first),
            speed(last),
            match stable {
                n if n == found.points.len() => "all".to_string(),
                0 => "none".to_string(),
                n => n.to_string(),
            },
            brief(factor * largest)
        );
    }
    text
}
