//! Lines of the mains, 50 or 60 Hz and multiples, which electric pick-up brings into every kind of measurement.

/// Nominal frequencies, Hz.
const NOMINAL: [f64; 2] = [50.0, 60.0];

/// Largest deviation of a grid from its nominal frequency, Hz: the standard range of continental Europe is ±0.05, its limit ±0.2
/// (Commission Regulation (EU) 2017/1485, annex III).
const GRID: f64 = 0.2;

/// Multiples looked at.
const MULTIPLES: usize = 40;

/// A grid frequency is taken from a multiple up to this one: higher ones are too near to each other in it.
const ANCHORS: usize = 6;

/// Lines known to less than this, Hz, do not tell the mains from what is near it.
const KNOWN: f64 = 1.0;

/// Multiples that make a family without the first.
const FAMILY: usize = 3;

/// The name of each line, Hz, known to `uncertainty`, that belongs to a family of mains lines: one that has the first, or three multiples,
/// of one grid frequency.
pub fn names(positions: &[f64], uncertainty: f64) -> Vec<Option<String>> {
    let mut all = vec![None; positions.len()];
    if !(uncertainty < KNOWN) {
        return all;
    }
    let families = NOMINAL.map(|nominal| (nominal, family(positions, uncertainty, nominal)));
    let size = |found: &[Option<usize>]| found.iter().flatten().count();
    let best = families.iter().max_by_key(|(_, found)| size(found));
    let Some((nominal, found)) = best else {
        return all;
    };
    for (name, multiple) in all.iter_mut().zip(found) {
        *name = multiple.map(|k| match k {
            1 => format!("mains {nominal} Hz"),
            k => format!("{k} × mains {nominal} Hz"),
        });
    }
    all
}

/// The multiple of the grid frequency that each line is, by the frequency most lines agree on.
fn family(positions: &[f64], uncertainty: f64, nominal: f64) -> Vec<Option<usize>> {
    let multiple = |position: f64| {
        let k = (position / nominal).round();
        (1.0..=MULTIPLES as f64).contains(&k).then_some(k as usize)
    };
    let mut best = vec![None; positions.len()];
    for &anchor in positions {
        let Some(k) = multiple(anchor).filter(|&k| k <= ANCHORS) else {
            continue;
        };
        let grid = anchor / k as f64;
        if (grid - nominal).abs() > GRID + uncertainty / k as f64 {
            continue;
        }
        let member = |&position: &f64| {
            multiple(position).filter(|&m| {
                let reach = uncertainty * (1.0 + m as f64 / k as f64);
                (position - m as f64 * grid).abs() <= reach.min(2.0 * KNOWN)
            })
        };
        let found: Vec<Option<usize>> = positions.iter().map(member).collect();
        let count = |found: &[Option<usize>]| found.iter().flatten().count();
        let is_family = found.contains(&Some(1)) || count(&found) >= FAMILY;
        if is_family && count(&found) > count(&best) {
            best = found;
        }
    }
    best
}

/// The mains frequency and its multiple on which a frequency lies, within what the grid and `uncertainty` leave.
pub fn mains_multiple(frequency_hz: f64, uncertainty: f64) -> Option<(f64, usize)> {
    NOMINAL.into_iter().find_map(|nominal| {
        let k = (frequency_hz / nominal).round();
        let off = (frequency_hz - k * nominal).abs();
        // On time average a grid keeps its frequency far better than at its limits.
        let reach = (0.25 * GRID * k).min(KNOWN) + uncertainty;
        ((1.0..=MULTIPLES as f64).contains(&k) && off <= reach).then_some((nominal, k as usize))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(positions: &[f64], uncertainty: f64) -> Vec<String> {
        let all = names(positions, uncertainty).into_iter();
        all.map(Option::unwrap_or_default).collect()
    }

    /// Odd multiples of a grid at 49.97 Hz among other lines; one of 60 Hz; nothing where lines are far apart, or on no common grid.
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
