//! Series of evenly spaced lines, `f_k = f_0 + k Δ`: harmonics of a shaft, and the sidebands of a mesh.

/// Consecutive lines that make a series: by chance five neighbours lie so with a probability of about `(4 tolerance/Δ)³`.
const MIN_SERIES_LINES: usize = 5;

/// A spacing is at least so many tolerances.
const MIN_SPACING_TOLERANCES: f64 = 10.0;

/// Neighbouring lines between which a spacing is looked for: lines that do not belong to the series may lie between two that do.
const NEIGHBOURS_SEARCHED: usize = 3;

/// A series continues so many places beyond its last line.
const EXTRAPOLATED_LINES: f64 = 2.5;

/// Evenly spaced lines.
#[derive(Debug, Clone, PartialEq)]
pub struct HarmonicSeries {
    /// Frequencies of its lines, Hz, rising.
    pub lines_hz: Vec<f64>,
    /// Distance of neighbours, Hz.
    pub spacing_hz: f64,
}

impl HarmonicSeries {
    /// Whether a frequency lies on the series, within its lines or up to two places beyond.
    pub fn holds(&self, frequency_hz: f64, tolerance_hz: f64) -> bool {
        let (Some(first), Some(last)) = (self.lines_hz.first(), self.lines_hz.last()) else {
            return false;
        };
        let beyond = EXTRAPOLATED_LINES * self.spacing_hz;
        let places = (frequency_hz - first) / self.spacing_hz;
        let off = (places - places.round()).abs() * self.spacing_hz;
        frequency_hz > first - beyond && frequency_hz < last + beyond && off < tolerance_hz
    }
}

/// Series of five or more lines among rising frequencies, each within `tolerance_hz` of its place; the longest first.
pub fn series(lines_hz: &[f64], tolerance_hz: f64) -> Vec<HarmonicSeries> {
    let mut found: Vec<HarmonicSeries> = Vec::new();
    for (i, &first) in lines_hz.iter().enumerate() {
        for &second in lines_hz.iter().skip(i + 1).take(NEIGHBOURS_SEARCHED) {
            let spacing = second - first;
            let is_known = |s: &HarmonicSeries| {
                (s.spacing_hz - spacing).abs() < tolerance_hz && s.holds(first, tolerance_hz)
            };
            if spacing < MIN_SPACING_TOLERANCES * tolerance_hz || found.iter().any(is_known) {
                continue;
            }
            let mut members = vec![first, second];
            loop {
                // The spacing as known so far, from the first to the last.
                let steps = (members.len() - 1) as f64;
                let last = members[members.len() - 1];
                let next = last + (last - first) / steps;
                match lines_hz.iter().find(|f| (**f - next).abs() < tolerance_hz) {
                    Some(&line) => members.push(line),
                    None => break,
                }
            }
            if members.len() >= MIN_SERIES_LINES {
                let steps = (members.len() - 1) as f64;
                found.push(HarmonicSeries {
                    spacing_hz: (members[members.len() - 1] - first) / steps,
                    lines_hz: members,
                });
            }
        }
    }
    found.sort_by_key(|s| std::cmp::Reverse(s.lines_hz.len()));
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sidebands of a mesh among other lines; what lies on their series, and what does not.
    #[test]
    fn exact_sidebands() {
        let mut lines: Vec<f64> = (-3..=3).map(|k| 712.0 + 8.3 * f64::from(k)).collect();
        lines.extend([100.0, 391.7, 709.9, 1001.0]);
        lines.sort_by(f64::total_cmp);
        let found = series(&lines, 0.05);
        assert_eq!(found.len(), 1, "{found:?}");
        assert_eq!(found[0].lines_hz.len(), 7);
        assert!((found[0].spacing_hz - 8.3).abs() < 1e-9);
        assert!(found[0].holds(712.0 + 4.0 * 8.3 + 0.01, 0.05));
        assert!(!found[0].holds(716.0, 0.05));
        assert!(!found[0].holds(712.0 + 8.0 * 8.3, 0.05));
        assert!(series(&[10.0, 21.0, 29.0, 43.0, 50.0, 61.5], 0.05).is_empty());
    }
}
