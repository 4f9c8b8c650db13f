//! What can be read off an output: extremes, means, and the answer to a step.

/// Extremes and means of an output.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// At the end.
    pub end: f64,
    /// The least value and its instant, s.
    pub least: (f64, f64),
    /// The greatest value and its instant, s.
    pub greatest: (f64, f64),
    /// Over time.
    pub mean: f64,
    /// Root of the mean square about the mean.
    pub rms: f64,
}

/// Reads an output at equally spaced instants; absent where there is none.
pub fn read(time: &[f64], values: &[f64]) -> Option<Reading> {
    let by = |better: fn(f64, f64) -> bool| {
        let mut best = (*values.first()?, *time.first()?);
        for (&x, &t) in values.iter().zip(time) {
            if better(x, best.0) {
                best = (x, t);
            }
        }
        Some(best)
    };
    // By the largest size, so that no square leaves the range of numbers.
    let size = values.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    let unit = if size > 0.0 { size } else { 1.0 };
    let count = values.len() as f64;
    let mean = values.iter().map(|x| x / unit).sum::<f64>() / count;
    let square = values
        .iter()
        .map(|x| (x / unit - mean).powi(2))
        .sum::<f64>()
        / count;
    let mean = mean * unit;
    Some(Reading {
        end: *values.last()?,
        least: by(|a, b| a < b)?,
        greatest: by(|a, b| a > b)?,
        mean,
        rms: square.sqrt() * unit,
    })
}

/// The answer of an output to a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepAnswer {
    /// The value at the step.
    pub before: f64,
    /// The value it settles at: the mean over the last tenth of the time.
    pub after: f64,
    /// The farthest beyond, as a share of the change, and its instant after the step, s.
    pub overshoot: (f64, f64),
    /// From 10 % to 90 % of the change, s.
    pub rise_s: f64,
    /// From the step on until it stays within 2 % of the change, s.
    pub settling_s: f64,
    /// Swings through the final value that leave the 2 % band, counted in whole oscillations.
    pub oscillations: f64,
}

/// The band in which an answer counts as settled, as a share of the change.
const BAND: f64 = 0.02;

/// Reads the answer to a step at `at`; absent where the output does not come to rest: its last tenth still leaves the band.
pub fn step(time: &[f64], values: &[f64], at: f64) -> Option<StepAnswer> {
    let first = time.partition_point(|&t| t < at);
    let tail = first + (time.len().saturating_sub(first)) * 9 / 10;
    let last = values.get(tail..).filter(|v| v.len() > 2)?;
    let after = last.iter().sum::<f64>() / last.len() as f64;
    let before = *values.get(first)?;
    let change = after - before;
    let steady = last
        .iter()
        .all(|x| (x - after).abs() <= BAND * change.abs());
    if change == 0.0 || !change.is_finite() || !steady {
        return None;
    }
    let (times, course) = (&time[first..], &values[first..]);
    let share = |x: f64| (x - before) / change;
    let crossing = |level: f64| {
        let i = course.iter().position(|&x| share(x) >= level)?;
        if i == 0 {
            return Some(times[0]);
        }
        let (a, b) = (share(course[i - 1]), share(course[i]));
        Some(times[i - 1] + (times[i] - times[i - 1]) * (level - a) / (b - a))
    };
    let mut overshoot = (0.0f64, 0.0);
    for (&x, &t) in course.iter().zip(times) {
        if share(x) - 1.0 > overshoot.0 {
            overshoot = (share(x) - 1.0, t - at);
        }
    }
    let outside = course.iter().rposition(|&x| (share(x) - 1.0).abs() > BAND);
    let settling_s = outside.map_or(0.0, |i| times[(i + 1).min(times.len() - 1)] - at);
    // Half swings: changes of side with more than the band between them.
    let mut side = 0.0;
    let mut halves = 0;
    for &x in course {
        let e = share(x) - 1.0;
        if e.abs() > BAND && e.signum() != side {
            if side != 0.0 {
                halves += 1;
            }
            side = e.signum();
        }
    }
    Some(StepAnswer {
        before,
        after,
        overshoot,
        rise_s: crossing(0.9)? - crossing(0.1)?,
        settling_s,
        oscillations: f64::from(halves) / 2.0,
    })
}
