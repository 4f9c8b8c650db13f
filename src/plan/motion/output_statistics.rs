//! Statistics of an output and characteristics of its step response.

/// Extremes of an output, and its means over equally spaced instants.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutputStatistics {
    /// At the end.
    pub end: f64,
    /// The least value and its instant, s.
    pub min: (f64, f64),
    /// The greatest value and its instant, s.
    pub max: (f64, f64),
    /// Over time.
    pub mean: f64,
    /// Root of the mean square about the mean.
    pub standard_deviation: f64,
}

/// Reads an output while it runs.
#[derive(Debug, Clone, Default)]
pub struct StatisticsAccumulator {
    count: f64,
    /// A power of two no value exceeds: no square leaves the range of numbers.
    unit: f64,
    /// In that unit: the mean, and the sum of squares about it (Welford 1962).
    mean: f64,
    squares: f64,
    extremes: Option<ExtremeValues>,
}

/// Least, greatest and last.
#[derive(Debug, Clone, Copy)]
struct ExtremeValues {
    min: (f64, f64),
    max: (f64, f64),
    end: f64,
}

impl StatisticsAccumulator {
    /// Takes the next value; they are equally spaced in time.
    pub fn push(&mut self, t: f64, x: f64) {
        let first = ExtremeValues {
            min: (x, t),
            max: (x, t),
            end: x,
        };
        self.extremes.get_or_insert(first).end = x;
        self.extend(t, x);
        if x.abs() > self.unit {
            let unit = x.abs().log2().ceil().min(1023.0).exp2();
            let shrink = self.unit / unit;
            self.mean *= shrink;
            self.squares *= shrink * shrink;
            self.unit = unit;
        }
        self.count += 1.0;
        let value = if self.unit > 0.0 { x / self.unit } else { 0.0 };
        let off = value - self.mean;
        self.mean += off / self.count;
        self.squares += off * (value - self.mean);
    }

    /// Whether a value lies beyond the extremes.
    pub fn is_beyond(&self, x: f64) -> bool {
        self.extremes
            .is_none_or(|seen| x < seen.min.0 || x > seen.max.0)
    }

    /// Takes an extreme between the samples.
    pub fn extend(&mut self, t: f64, x: f64) {
        if let Some(seen) = &mut self.extremes {
            if x < seen.min.0 {
                seen.min = (x, t);
            }
            if x > seen.max.0 {
                seen.max = (x, t);
            }
        }
    }

    /// Statistics of the samples; absent where there are none.
    pub fn statistics(&self) -> Option<OutputStatistics> {
        self.extremes.map(|seen| OutputStatistics {
            end: seen.end,
            min: seen.min,
            max: seen.max,
            mean: self.mean * self.unit,
            standard_deviation: (self.squares / self.count).sqrt() * self.unit,
        })
    }
}

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
            let (shift, peak) = parabola_vertex(&beyond, largest);
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

/// The vertex of the parabola through a largest sample and its neighbours, in samples from it, and its value; the sample itself
/// where the curve about it is none: at an end, or where second differences jump.
fn parabola_vertex(values: &[f64], at: usize) -> (f64, f64) {
    let bend = |i: usize| values[i + 1] - 2.0 * values[i] + values[i - 1];
    let smooth = at >= 2 && at + 2 < values.len() && {
        let c = bend(at);
        c < 0.0 && [bend(at - 1), bend(at + 1)].iter().all(|b| *b < 0.5 * c)
    };
    if !smooth {
        return (0.0, values[at]);
    }
    let slope = 0.5 * (values[at + 1] - values[at - 1]);
    let shift = -slope / bend(at);
    (shift, values[at] + 0.5 * slope * shift)
}
