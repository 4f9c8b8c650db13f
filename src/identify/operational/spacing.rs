//! Detection of equally spaced spectral lines, `f_k = f_0 + k Δ`: shaft harmonics and sidebands of a mesh frequency.

/// Minimum number of lines in a series: five random lines are equally spaced with a probability of about `(4 tolerance/Δ)³`.
const MIN_SERIES_LINES: usize = 5;

/// Minimum spacing, in tolerances.
const MIN_SPACING_TOLERANCES: f64 = 10.0;

/// Number of following lines tried as the second line of a series, so that unrelated lines may lie between the first two.
const NEIGHBOURS_SEARCHED: usize = 3;

/// Extrapolation of a series beyond its first and last line, in spacings.
const EXTRAPOLATED_LINES: f64 = 2.5;

/// Equally spaced spectral lines.
#[derive(Debug, Clone, PartialEq)]
pub struct HarmonicSeries {
    /// Frequencies of the lines, Hz, ascending.
    pub lines_hz: Vec<f64>,
    /// Mean distance of consecutive lines, Hz.
    pub spacing_hz: f64,
}

impl HarmonicSeries {
    /// True if a frequency lies on the series, between its lines or up to two spacings beyond them.
    pub fn contains(&self, frequency_hz: f64, tolerance_hz: f64) -> bool {
        let (Some(first), Some(last)) = (self.lines_hz.first(), self.lines_hz.last()) else {
            return false;
        };
        let margin = EXTRAPOLATED_LINES * self.spacing_hz;
        let order = (frequency_hz - first) / self.spacing_hz;
        let error = (order - order.round()).abs() * self.spacing_hz;
        frequency_hz > first - margin && frequency_hz < last + margin && error < tolerance_hz
    }
}

/// Detects series of five or more lines in ascending frequencies, each line within `tolerance_hz` of its expected frequency; longest first.
pub fn series(lines_hz: &[f64], tolerance_hz: f64) -> Vec<HarmonicSeries> {
    let mut series: Vec<HarmonicSeries> = Vec::new();
    for (i, &first) in lines_hz.iter().enumerate() {
        for &second in lines_hz.iter().skip(i + 1).take(NEIGHBOURS_SEARCHED) {
            let spacing = second - first;
            let is_duplicate = |s: &HarmonicSeries| {
                (s.spacing_hz - spacing).abs() < tolerance_hz && s.contains(first, tolerance_hz)
            };
            if spacing < MIN_SPACING_TOLERANCES * tolerance_hz || series.iter().any(is_duplicate) {
                continue;
            }
            let mut line_frequencies = vec![first, second];
            loop {
                // Mean spacing of the lines detected so far.
                let steps = (line_frequencies.len() - 1) as f64;
                let last = line_frequencies[line_frequencies.len() - 1];
                let next = last + (last - first) / steps;
                match lines_hz.iter().find(|f| (**f - next).abs() < tolerance_hz) {
                    Some(&line) => line_frequencies.push(line),
                    None => break,
                }
            }
            if line_frequencies.len() >= MIN_SERIES_LINES {
                let steps = (line_frequencies.len() - 1) as f64;
                series.push(HarmonicSeries {
                    spacing_hz: (line_frequencies[line_frequencies.len() - 1] - first) / steps,
                    lines_hz: line_frequencies,
                });
            }
        }
    }
    series.sort_by_key(|s| std::cmp::Reverse(s.lines_hz.len()));
    series
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sidebands of a mesh frequency are detected between other lines, and frequencies on and off their series are distinguished.
    #[test]
    fn exact_sidebands() {
        let mut lines: Vec<f64> = (-3..=3).map(|k| 712.0 + 8.3 * f64::from(k)).collect();
        lines.extend([100.0, 391.7, 709.9, 1001.0]);
        lines.sort_by(f64::total_cmp);
        let found = series(&lines, 0.05);
        assert_eq!(found.len(), 1, "{found:?}");
        assert_eq!(found[0].lines_hz.len(), 7);
        assert!((found[0].spacing_hz - 8.3).abs() < 1e-9);
        assert!(found[0].contains(712.0 + 4.0 * 8.3 + 0.01, 0.05));
        assert!(!found[0].contains(716.0, 0.05));
        assert!(!found[0].contains(712.0 + 8.0 * 8.3, 0.05));
        assert!(series(&[10.0, 21.0, 29.0, 43.0, 50.0, 61.5], 0.05).is_empty());
    }
}
