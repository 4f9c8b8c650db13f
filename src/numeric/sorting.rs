//! Stable sorts by a number: one compiled sort for lists of every type.

/// Numbers of the values by rising value, those alike in their order.
pub fn ascending_order(values: impl IntoIterator<Item = f64>) -> Vec<usize> {
    order(&values.into_iter().collect::<Vec<f64>>())
}

/// Numbers of the values by falling value, those alike in their order.
pub fn falling_order(values: impl IntoIterator<Item = f64>) -> Vec<usize> {
    // The total order of numbers is symmetric about zero.
    ascending_order(values.into_iter().map(|x| -x))
}

/// Sorts by rising `key`.
pub fn sort_ascending<T>(list: &mut [T], key: impl Fn(&T) -> f64) {
    let order = ascending_order(list.iter().map(key));
    permute(list, order);
}

/// Sorts by falling `key`.
pub fn sort_descending<T>(list: &mut [T], key: impl Fn(&T) -> f64) {
    sort_ascending(list, |x| -key(x));
}

fn order(values: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    order
}

/// Puts the element `order[k]` at place k, for every k.
fn permute<T>(list: &mut [T], mut order: Vec<usize>) {
    for start in 0..order.len() {
        // Each cycle is closed once; a place that is done points to itself.
        let mut at = start;
        loop {
            let from = std::mem::replace(&mut order[at], at);
            if from == start {
                break;
            }
            list.swap(at, from);
            at = from;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The same as the standard library's stable sort, on lists with many values alike.
    #[test]
    fn ref_stable_sort() {
        let mut rng = fastrand::Rng::with_seed(5);
        for length in 0..60 {
            let list: Vec<(f64, usize)> = (0..length)
                .map(|k| (f64::from(rng.i32(-5..5)), k))
                .collect();
            let (mut rising, mut falling) = (list.clone(), list.clone());
            sort_ascending(&mut rising, |x| x.0);
            sort_descending(&mut falling, |x| x.0);
            let mut expected = list.clone();
            expected.sort_by(|a, b| a.0.total_cmp(&b.0));
            assert_eq!(rising, expected);
            expected = list;
            expected.sort_by(|a, b| b.0.total_cmp(&a.0));
            assert_eq!(falling, expected);
        }
    }
}
