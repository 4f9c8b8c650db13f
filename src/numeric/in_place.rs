//! Small linear systems solved where they stand, without allocation.

/// Solves `A x = b` by elimination with row pivoting; `a` holds A row by row and is used up, `b` becomes x.
///
/// A singular A gives infinities or numbers that are none: whoever calls it knows that it is not.
pub fn solve(a: &mut [f64], b: &mut [f64]) {
    let n = b.len();
    for j in 0..n {
        let pivot = (j..n).fold(j, |best, i| {
            match a[i * n + j].abs() > a[best * n + j].abs() {
                true => i,
                false => best,
            }
        });
        if pivot != j {
            (0..n).for_each(|c| a.swap(j * n + c, pivot * n + c));
            b.swap(j, pivot);
        }
        for i in j + 1..n {
            let factor = a[i * n + j] / a[j * n + j];
            for c in j + 1..n {
                a[i * n + c] -= factor * a[j * n + c];
            }
            b[i] -= factor * b[j];
        }
    }
    for j in (0..n).rev() {
        let known: f64 = (j + 1..n).map(|c| a[j * n + c] * b[c]).sum();
        b[j] = (b[j] - known) / a[j * n + j];
    }
}

/// A⁻¹, both row by row.
pub fn inverse(a: &[f64], n: usize) -> Vec<f64> {
    let mut inverse = vec![0.0; n * n];
    let mut column = vec![0.0; n];
    for j in 0..n {
        column.fill(0.0);
        column[j] = 1.0;
        solve(&mut a.to_vec(), &mut column);
        (0..n).for_each(|i| inverse[i * n + j] = column[i]);
    }
    inverse
}

/// `y = A x`, A row by row.
pub fn times(a: &[f64], x: &[f64], y: &mut [f64]) {
    for (y, row) in y.iter_mut().zip(a.chunks_exact(x.len())) {
        *y = row.iter().zip(x).map(|(a, x)| a * x).sum();
    }
}
