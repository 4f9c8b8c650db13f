//! Causes of the deviations of a cut flank, each with the conditions of its cut.

use std::f64::consts::TAU;

use crate::base::code::Code;
use crate::base::error::Error;
use crate::gear::bevel::flank_grid::FlankGrid;
use crate::gear::bevel::settings::MachineSettings;
use crate::gear::cut::angle_errors::{AngleError, AngleErrors};
use crate::gear::cut::blade_passes::CutConditions;
use crate::gear::cut::cutter_head::BladeFeed;
use crate::scene::cut_file::CutFile;
use crate::scene::cut_study::{ChainError, CutTarget, SpindleHistory};

/// Name of the cut by regular blades alone.
pub const REGULAR: &str = "regular blades";
/// Name of the cut by blades with their run-out.
pub const RUN_OUT: &str = "run-out";
/// Name of the cut with every cause.
pub const ALL: &str = "all causes";

/// A cause with the conditions of the cut.
pub struct CutCause {
    /// Heading under which it is reported.
    pub name: String,
    /// The conditions.
    pub conditions: CutConditions,
}

/// The causes of a flank: regular blades, each further cause with them, and all together where there are several.
///
/// # Errors
/// A history that ends before the roll over the flank.
pub fn of_flank(
    file: &CutFile,
    settings: &MachineSettings,
    feed: BladeFeed,
    grid: &FlankGrid,
) -> Result<Vec<CutCause>, Error> {
    let study = &file.study;
    let mut causes = vec![CutCause {
        name: REGULAR.into(),
        conditions: CutConditions::regular(feed),
    }];
    let mut all = CutConditions::regular(feed);
    if !study.offsets.is_empty() {
        all.offsets = study.offsets.clone();
        causes.push(CutCause {
            name: RUN_OUT.into(),
            conditions: all.clone(),
        });
    }
    if let Some(roll) = &settings.roll {
        let mut errors = Vec::new();
        for (k, error) in study.errors.iter().enumerate() {
            let name = format!(
                "error {}: {}, {} a revolution",
                k + 1,
                error.target.name(),
                error.cycles
            );
            let law = harmonic(error, roll.work_over_cradle, feed);
            errors.push((name, error.target, law));
        }
        if let (Some(readings), Some(history)) = (&file.history, &study.history) {
            let turns = turns_of(history.target, roll.work_over_cradle, feed);
            let law = of_history(file, history, readings, turns, grid)?;
            errors.push((
                format!("history of the {}", history.target.name()),
                history.target,
                law,
            ));
        }
        for (name, target, error) in errors {
            add(&mut all.errors, target, error.clone());
            let mut conditions = CutConditions::regular(feed);
            add(&mut conditions.errors, target, error);
            causes.push(CutCause { name, conditions });
        }
    }
    if causes.len() > 2 {
        causes.push(CutCause {
            name: ALL.into(),
            conditions: all,
        });
    }
    Ok(causes)
}

/// Errors of cradle and work by their harmonics.
pub fn chain_errors(file: &CutFile, settings: &MachineSettings, feed: BladeFeed) -> AngleErrors {
    let mut errors = AngleErrors::default();
    if let Some(roll) = &settings.roll {
        for error in &file.study.errors {
            let law = harmonic(error, roll.work_over_cradle, feed);
            add(&mut errors, error.target, law);
        }
    }
    errors
}

/// A harmonic over the cradle's turn: the work turns by the ratio of roll, the cutter by its speed.
fn harmonic(error: &ChainError, work_over_cradle: f64, feed: BladeFeed) -> AngleError {
    AngleError::harmonic(
        error.amplitude,
        cradle_order(error, work_over_cradle, feed),
        error.phase,
    )
}

/// Cycles of an error in a revolution of the cradle.
pub fn cradle_order(error: &ChainError, work_over_cradle: f64, feed: BladeFeed) -> f64 {
    error.cycles * turns_of(error.target, work_over_cradle, feed)
}

/// Turns of a part in a turn of the cradle.
fn turns_of(target: CutTarget, work_over_cradle: f64, feed: BladeFeed) -> f64 {
    match target {
        CutTarget::Cradle => 1.0,
        CutTarget::Work => work_over_cradle,
        CutTarget::Cutter => TAU / feed.cradle_per_turn,
    }
}

fn add(errors: &mut AngleErrors, target: CutTarget, error: AngleError) {
    match target {
        CutTarget::Cradle => errors.cradle.push(error),
        CutTarget::Work => errors.work.push(error),
        CutTarget::Cutter => errors.cutter.push(error),
    }
}

/// Largest difference between the mean speed of a history and that of the part in the cut, as a share of it; a history whose mean speed is
/// below this share is that of the error alone.
const SPEED_TOLERANCE: f64 = 0.05;

/// A history over the cradle's turn, its middle at φ_c = 0, ahead in the sense in which the part turns; `turns` are those of the part in a
/// turn of the cradle.
fn of_history(
    file: &CutFile,
    history: &SpindleHistory,
    [times, angles]: &[Vec<f64>; 2],
    turns: f64,
    grid: &FlankGrid,
) -> Result<AngleError, Error> {
    let speed = file.study.cradle_speed.unwrap_or_default();
    let duration = times[times.len() - 1] - times[0];
    let middle = times[0] + 0.5 * duration;
    let rolled = grid.nodes.iter().flatten().map(|n| n.point.at[2].abs());
    let furthest = rolled.fold(0.0, f64::max);
    let refused = |message: String, hint: &str| {
        Err(Error::new(Code::OutOfRange, message)
            .with_span(&history.span)
            .with_hint(hint))
    };
    if 0.5 * duration * speed.abs() < furthest {
        let message = format!(
            "the history lasts {duration:.3} s; the roll over the flank takes {:.3} s about its middle",
            2.0 * furthest / speed.abs()
        );
        return refused(message, "simulate for longer, or raise `cradle_speed`");
    }
    let straight = straight_line(times, angles);
    let (found, expected) = (straight[1].abs(), (speed * turns).abs());
    if found > SPEED_TOLERANCE * expected && (found / expected - 1.0).abs() > SPEED_TOLERANCE {
        let [found, expected] = [found, expected].map(f64::to_degrees);
        let message = format!(
            "column `{}` turns at {found:.4} deg/s, and the {} at {expected:.4} deg/s",
            history.column,
            history.target.name()
        );
        return refused(message, "check `column`, `target` and `cradle_speed`");
    }
    // A history of the error alone has no sense of turn.
    let turns_back = straight[1] < 0.0 && found > SPEED_TOLERANCE * expected;
    let sense = if turns_back { -1.0 } else { 1.0 };
    let reading = |(t, a): (&f64, &f64)| {
        (
            speed * (t - middle),
            sense * (a - straight[0] - straight[1] * (t - middle)),
        )
    };
    let mut readings: Vec<(f64, f64)> = times.iter().zip(angles).map(reading).collect();
    if speed < 0.0 {
        readings.reverse();
    }
    let (places, errors) = readings.into_iter().unzip();
    AngleError::readings(places, errors)
        .ok_or_else(|| Error::new(Code::OutOfRange, "the history has fewer than two rows"))
}

/// Value at the middle of the times and slope of the straight line of least squares.
fn straight_line(times: &[f64], angles: &[f64]) -> [f64; 2] {
    let count = times.len() as f64;
    let middle = 0.5 * (times[0] + times[times.len() - 1]);
    let mean = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>() / count;
    let mean_time = mean(&mut times.iter().map(|t| t - middle));
    let mean_angle = mean(&mut angles.iter().copied());
    let pairs = || {
        times
            .iter()
            .zip(angles)
            .map(|(t, a)| (t - middle - mean_time, a - mean_angle))
    };
    let slope = pairs().map(|(t, a)| t * a).sum::<f64>() / pairs().map(|(t, _)| t * t).sum::<f64>();
    [mean_angle - slope * mean_time, slope]
}
