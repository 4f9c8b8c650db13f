//! Straight lines through the stamps of segments: one slope and an offset for each, `Σ w (x − x̄)(y − ȳ) / Σ w (x − x̄)²` over
//! rows x = 0, 1, 2, … with weights w. The sums are compensated, so that a thousand million rows keep their digits.

/// A sum that carries what rounding loses (Neumaier 1974, Zeitschrift für angewandte Mathematik und Mechanik 54, 39–51).
#[derive(Debug, Default, Clone, Copy)]
struct CompensatedSum {
    sum: f64,
    lost: f64,
}

impl CompensatedSum {
    fn add(&mut self, x: f64) {
        let sum = self.sum + x;
        // Møller and Knuth's exact error of an addition, without a branch.
        let added = sum - self.sum;
        self.lost += (self.sum - (sum - added)) + (x - added);
        self.sum = sum;
    }

    fn value(self) -> f64 {
        self.sum + self.lost
    }
}

/// Rows whose plain sums are added to the compensated ones together.
const PART_ROWS: f64 = 64.0;

/// Plain sums over some rows, with rows and stamps taken from the first of them.
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

/// Sums of a regression over one segment, stamps taken from its first.
#[derive(Debug, Default, Clone, Copy)]
pub(super) struct RegressionSums {
    /// Rows.
    pub rows: f64,
    /// The latest stamp, s from the first.
    pub last_s: f64,
    /// The latest rows, not yet in the sums below.
    part: PartSums,
    w: CompensatedSum,
    x: CompensatedSum,
    y: CompensatedSum,
    xx: CompensatedSum,
    xy: CompensatedSum,
}

impl RegressionSums {
    /// Takes the stamp of the next row, s from the first of the segment.
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

    /// Adds the latest rows: with `x = x₀ + x'` and `y = y₀ + y'` of the first of them.
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

    /// Intercept of the line of a slope at the first row, s from its stamp.
    pub fn offset(mut self, slope: f64) -> f64 {
        self.join_part();
        (self.y.value() - slope * self.x.value()) / self.w.value()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Steps, of the slope over exact stamps, that the last of `rows` rows lies off the line.
    fn off(rows: u64) -> f64 {
        let step = 1.0 / 51_200.0;
        let mut line = RegressionSums::default();
        (0..rows).for_each(|row| line.add(row as f64 * step, 1.0));
        let (xx, xy) = line.centred();
        let end = line.offset(xy / xx) + (rows - 1) as f64 * (xy / xx);
        (end - line.last_s).abs() / step
    }

    /// Exact stamps lie on their line however many they are: plain sums had put rows a hundredth of a step off.
    #[test]
    fn exact_line_of_many_rows() {
        assert!(off(20_000_000) < 1e-7, "{}", off(20_000_000));
    }

    #[test]
    #[ignore = "a thousand million rows take ten seconds"]
    fn exact_line_of_a_thousand_million_rows() {
        assert!(off(1_000_000_000) < 1e-5, "{}", off(1_000_000_000));
    }
}
