//! Step response of an output: overshoot, rise, settling.

use crate::numeric::parabola::vertex;

/// Step response of an output.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepResponse {
    /// The value at the step.
    pub initial_value: f64,
    /// The value it settles at: the mean over the last tenth of the time.
    pub final_value: f64,
    /// The farthest beyond, as a share of the change, and its instant after the step, s.
    pub overshoot: (f64, f64),
    /// From 10 % to 90 % of the change, s.
    pub rise_s: f64,
    /// From the step on until it stays within 2 % of the change, s.
    pub settling_s: f64,
    /// Oscillations through the final value that leave the 2 % band, counted in whole periods.
    pub oscillations: f64,
}

/// Settling band, as a share of the change.
const SETTLING_BAND: f64 = 0.02;

/// Step response to a step at `at` from equally spaced samples; absent where the output does not come to rest: its last tenth still leaves
/// the band. Peaks are those of parabolas through the samples, crossings lie on lines between two.
pub fn step_response(time: &[f64], values: &[f64], at: f64) -> Option<StepResponse> {
    let first = time.partition_point(|&t| t <= at).checked_sub(1)?;
    let tail = first + (time.len().saturating_sub(first)) * 9 / 10;
    let last = values.get(tail..).filter(|v| v.len() > 2)?;
    let after = last.iter().sum::<f64>() / last.len() as f64;
    let before = *values.get(first)?;
    let change = after - before;
    let steady = last
        .iter()
        .all(|x| (x - after).abs() <= SETTLING_BAND * change.abs());
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
    let beyond: Vec<f64> = course.iter().map(|&x| share(x) - 1.0).collect();
    let largest = (0..beyond.len()).fold(0, |at, i| if beyond[i] > beyond[at] { i } else { at });
    let overshoot = match beyond[largest] > 0.0 {
        false => (0.0, 0.0),
        true => {
            let (shift, peak) = smooth_vertex(&beyond, largest);
            let spacing = times.get(1).map_or(0.0, |second| second - times[0]);
            (peak, times[largest] + shift * spacing - at)
        }
    };
    let outside = beyond.iter().rposition(|e| e.abs() > SETTLING_BAND);
    let settling_s = outside.map_or(0.0, |i| {
        let Some(next) = beyond.get(i + 1) else {
            return times[i] - at;
        };
        let share = (beyond[i].abs() - SETTLING_BAND) / (beyond[i] - next).abs();
        times[i] + share.min(1.0) * (times[i + 1] - times[i]) - at
    });
    // Half swings: changes of side with more than the band between them.
    let mut side = 0.0;
    let mut halves = 0;
    for &x in course {
        let e = share(x) - 1.0;
        if e.abs() > SETTLING_BAND && e.signum() != side {
            if side != 0.0 {
                halves += 1;
            }
            side = e.signum();
        }
    }
    Some(StepResponse {
        initial_value: before,
        final_value: after,
        overshoot,
        rise_s: crossing(0.9)? - crossing(0.1)?,
        settling_s,
        oscillations: f64::from(halves) / 2.0,
    })
}

/// Vertex of the parabola through a largest sample and its neighbours, in samples from it, and its value; the sample itself at an end, or
/// where second differences jump.
fn smooth_vertex(values: &[f64], at: usize) -> (f64, f64) {
    let bend = |i: usize| values[i + 1] - 2.0 * values[i] + values[i - 1];
    let smooth = at >= 2 && at + 2 < values.len() && {
        let c = bend(at);
        c < 0.0 && [bend(at - 1), bend(at + 1)].iter().all(|b| *b < 0.5 * c)
    };
    match smooth {
        true => vertex([values[at - 1], values[at], values[at + 1]]),
        false => (0.0, values[at]),
    }
}
