//! Extremes and means of an output, read while it runs.

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
