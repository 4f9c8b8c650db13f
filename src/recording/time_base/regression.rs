//! Weighted linear regression of time stamps y over row numbers x = 0, 1, 2, …: an offset for each segment and the common slope
//! `Σ w (x − x̄)(y − ȳ) / Σ w (x − x̄)²` with weights w. Compensated summation keeps the digits of 10⁹ rows.

/// Sum with compensation of its rounding error (Neumaier 1974, Zeitschrift für angewandte Mathematik und Mechanik 54, 39–51).
#[derive(Debug, Default, Clone, Copy)]
struct CompensatedSum {
    sum: f64,
    compensation: f64,
}

impl CompensatedSum {
    fn add(&mut self, x: f64) {
        let sum = self.sum + x;
        // Exact error of an addition by Møller and Knuth, without a branch.
        let increment = sum - self.sum;
        self.compensation += (self.sum - (sum - increment)) + (x - increment);
        self.sum = sum;
    }

    fn value(self) -> f64 {
        self.sum + self.compensation
    }
}

/// Number of rows that are summed without compensation before they are added to the compensated sums.
const PART_ROWS: f64 = 64.0;

/// Uncompensated sums over up to [`PART_ROWS`] rows; rows and stamps are relative to the first of them.
#[derive(Debug, Default, Clone, Copy)]
struct PartSums {
    first_s: f64,
    rows: f64,
    w: f64,
    x: f64,
    y: f64,
    xx: f64,
    xy: f64,
}

/// Regression sums over one segment; stamps are relative to its first stamp.
#[derive(Debug, Default, Clone, Copy)]
pub(super) struct RegressionSums {
    /// Number of rows.
    pub rows: f64,
    /// Last stamp, s from the first.
    pub last_s: f64,
    /// Sums of the last rows, not yet added to the sums below.
    part: PartSums,
    w: CompensatedSum,
    x: CompensatedSum,
    y: CompensatedSum,
    xx: CompensatedSum,
    xy: CompensatedSum,
}

impl RegressionSums {
    /// Adds the stamp of the next row, s from the first stamp of the segment.
    pub fn add(&mut self, since_s: f64, weight: f64) {
        if self.part.rows == PART_ROWS {
            self.join_part();
        }
        let part = &mut self.part;
        if part.rows == 0.0 {
            part.first_s = since_s;
        }
        let (x, y) = (part.rows, since_s - part.first_s);
        part.w += weight;
        part.x += weight * x;
        part.y += weight * y;
        part.xx += weight * x * x;
        part.xy += weight * x * y;
        part.rows += 1.0;
        self.rows += 1.0;
        self.last_s = since_s;
    }

    /// Adds the part to the compensated sums, with `x = x₀ + x'` and `y = y₀ + y'`, where `x₀` and `y₀` are those of its first row.
    fn join_part(&mut self) {
        let part = std::mem::take(&mut self.part);
        let (x0, y0) = (self.rows - part.rows, part.first_s);
        self.w.add(part.w);
        for x in [x0 * part.w, part.x] {
            self.x.add(x);
        }
        for y in [y0 * part.w, part.y] {
            self.y.add(y);
        }
        for xx in [x0 * x0 * part.w, 2.0 * x0 * part.x, part.xx] {
            self.xx.add(xx);
        }
        for xy in [x0 * y0 * part.w, x0 * part.y, y0 * part.x, part.xy] {
            self.xy.add(xy);
        }
    }

    /// `Σ w (x − x̄)²` and `Σ w (x − x̄)(y − ȳ)`.
    pub fn centred(mut self) -> (f64, f64) {
        self.join_part();
        let mean = self.x.value() / self.w.value();
        (
            self.xx.value() - mean * self.x.value(),
            self.xy.value() - mean * self.y.value(),
        )
    }

    /// Intercept at the first row of the line with this slope (s per row), s from the first stamp.
    pub fn offset(mut self, slope: f64) -> f64 {
        self.join_part();
        (self.y.value() - slope * self.x.value()) / self.w.value()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Deviation of the last of `rows` exact stamps from the regression line, in sample intervals.
    fn error(rows: u64) -> f64 {
        let step = 1.0 / 51_200.0;
        let mut line = RegressionSums::default();
        (0..rows).for_each(|row| line.add(row as f64 * step, 1.0));
        let (xx, xy) = line.centred();
        let end = line.offset(xy / xx) + (rows - 1) as f64 * (xy / xx);
        (end - line.last_s).abs() / step
    }

    /// Exact stamps lie on the regression line; uncompensated sums gave deviations of 0.01 sample intervals.
    #[test]
    fn exact_line_of_many_rows() {
        assert!(error(20_000_000) < 1e-7, "{}", error(20_000_000));
    }

    #[test]
    #[ignore = "a thousand million rows take ten seconds"]
    fn exact_line_of_a_thousand_million_rows() {
        assert!(error(1_000_000_000) < 1e-5, "{}", error(1_000_000_000));
    }
}
