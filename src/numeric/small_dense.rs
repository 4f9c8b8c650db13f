//! Small dense systems `A x = b` solved in place without allocation.

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
        let (above, below) = a.split_at_mut((j + 1) * n);
        let (known, left) = b.split_at_mut(j + 1);
        let pivot = &above[j * n + j..];
        for (row, right) in below.chunks_exact_mut(n).zip(left) {
            let factor = row[j] / pivot[0];
            let pairs = row[j..].iter_mut().zip(pivot);
            pairs.for_each(|(x, p)| *x -= factor * p);
            *right -= factor * known[j];
        }
    }
    for j in (0..n).rev() {
        let row = &a[j * n..(j + 1) * n];
        let pairs = row[j + 1..].iter().zip(&b[j + 1..]);
        let known: f64 = pairs.map(|(a, x)| a * x).sum();
        b[j] = (b[j] - known) / row[j];
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
pub fn mul_vec(a: &[f64], x: &[f64], y: &mut [f64]) {
    for (y, row) in y.iter_mut().zip(a.chunks_exact(x.len())) {
        *y = row.iter().zip(x).map(|(a, x)| a * x).sum();
    }
}
