//! Mains lines: 50 or 60 Hz and multiples, which enter any measurement by electrical pick-up.

/// Nominal frequencies, Hz.
const NOMINAL: [f64; 2] = [50.0, 60.0];

/// Largest deviation of a grid from its nominal frequency, Hz: the standard range of continental Europe is ±0.05, its limit ±0.2
/// (Commission Regulation (EU) 2017/1485, annex III).
const GRID_DEVIATION: f64 = 0.2;

/// Maximum multiple of the grid frequency.
const MAX_ORDER: usize = 40;

/// Maximum multiple from which a grid frequency is determined: higher multiples lie too close together.
const MAX_ANCHOR: usize = 6;

/// Uncertainty of a line, Hz, from which mains lines are not distinguished from others.
const MAX_UNCERTAINTY: f64 = 1.0;

/// Minimum number of multiples in a family without the fundamental.
const MIN_FAMILY: usize = 3;

/// Name of each line that belongs to a family of mains lines, which has the fundamental or three multiples of one grid frequency.
/// `positions` and their `uncertainty` are in Hz.
pub fn names(positions: &[f64], uncertainty: f64) -> Vec<Option<String>> {
    let mut labels = vec![None; positions.len()];
    if !(uncertainty < MAX_UNCERTAINTY) {
        return labels;
    }
    let families = NOMINAL.map(|nominal| (nominal, find_family(positions, uncertainty, nominal)));
    let size = |multiples: &[Option<usize>]| multiples.iter().flatten().count();
    let largest = families.iter().max_by_key(|(_, multiples)| size(multiples));
    let Some((nominal, multiples)) = largest else {
        return labels;
    };
    for (name, multiple) in labels.iter_mut().zip(multiples) {
        *name = multiple.map(|k| match k {
            1 => format!("mains {nominal} Hz"),
            k => format!("{k} × mains {nominal} Hz"),
        });
    }
    labels
}

/// Multiple of the grid frequency for each line, at the grid frequency that fits most lines.
fn find_family(positions: &[f64], uncertainty: f64, nominal: f64) -> Vec<Option<usize>> {
    let multiple = |position: f64| {
        let k = (position / nominal).round();
        (1.0..=MAX_ORDER as f64).contains(&k).then_some(k as usize)
    };
    let mut largest = vec![None; positions.len()];
    for &anchor in positions {
        let Some(k) = multiple(anchor).filter(|&k| k <= MAX_ANCHOR) else {
            continue;
        };
        let grid = anchor / k as f64;
        if (grid - nominal).abs() > GRID_DEVIATION + uncertainty / k as f64 {
            continue;
        }
        let member = |&position: &f64| {
            multiple(position).filter(|&m| {
                let tolerance = uncertainty * (1.0 + m as f64 / k as f64);
                (position - m as f64 * grid).abs() <= tolerance.min(2.0 * MAX_UNCERTAINTY)
            })
        };
        let multiples: Vec<Option<usize>> = positions.iter().map(member).collect();
        let count = |multiples: &[Option<usize>]| multiples.iter().flatten().count();
        let is_family = multiples.contains(&Some(1)) || count(&multiples) >= MIN_FAMILY;
        if is_family && count(&multiples) > count(&largest) {
            largest = multiples;
        }
    }
    largest
}

/// Mains frequency, Hz, and multiple that match a frequency, within the tolerance of the grid and `uncertainty`, Hz.
pub fn mains_multiple(frequency_hz: f64, uncertainty: f64) -> Option<(f64, usize)> {
    NOMINAL.into_iter().find_map(|nominal| {
        let k = (frequency_hz / nominal).round();
        let error = (frequency_hz - k * nominal).abs();
        // The time average of a grid frequency deviates far less than the limit.
        let limit = (0.25 * GRID_DEVIATION * k).min(MAX_UNCERTAINTY) + uncertainty;
        ((1.0..=MAX_ORDER as f64).contains(&k) && error <= limit).then_some((nominal, k as usize))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(positions: &[f64], uncertainty: f64) -> Vec<String> {
        let labels = names(positions, uncertainty).into_iter();
        labels.map(Option::unwrap_or_default).collect()
    }

    /// Odd multiples of a grid at 49.97 Hz among other lines; a grid at 60 Hz; none if the uncertainty is large or no grid is common.
    #[test]
    fn exact_names() {
        let grid = 49.97;
        let lines = [grid, 3.0 * grid, 123.4, 5.0 * grid, 401.2];
        let expected = ["mains 50 Hz", "3 × mains 50 Hz", "", "5 × mains 50 Hz", ""];
        assert_eq!(named(&lines, 0.05), expected);
        assert_eq!(
            named(&[60.02, 120.05], 0.1),
            ["mains 60 Hz", "2 × mains 60 Hz"]
        );
        assert_eq!(named(&[50.0, 100.0], 2.0), ["", ""]);
        assert_eq!(named(&[100.0, 77.7], 0.1), ["", ""]);
        assert_eq!(named(&[], 0.1), Vec::<String>::new());
    }

    #[test]
    fn exact_on_mains() {
        assert_eq!(mains_multiple(149.96, 0.0), Some((50.0, 3)));
        assert_eq!(mains_multiple(60.03, 0.0), Some((60.0, 1)));
        assert_eq!(mains_multiple(52.0, 0.1), None);
    }
}
