//! Displacements of points from components along measured directions: the minimum-norm solution of `min Σ (d_k·u − v_k)²`.

use crate::base::error::Error;
use crate::numeric::{Complex, Matrix, lstsq};

/// Complex displacement along x, y and z.
pub type Displacement = [Complex; 3];

/// Displacements of points from channel values; each channel has a point index and a unit direction. `None` for a point without a channel.
///
/// # Errors
/// `Overflow` where a value is not finite.
pub fn point_displacements(
    n_points: usize,
    channels: &[(usize, [f64; 3])],
    values: &[Complex],
) -> Result<Vec<Option<Displacement>>, Error> {
    let displacement = |point: usize| {
        let indices: Vec<usize> = (0..channels.len())
            .filter(|&k| channels[k].0 == point)
            .collect();
        if indices.is_empty() {
            return Ok(None);
        }
        // Zero rows pad the system to three equations.
        let rows = indices.len().max(3);
        let row = |i: usize| indices.get(i).copied();
        let directions = Matrix::from_fn(rows, 3, |i, j| row(i).map_or(0.0, |k| channels[k].1[j]));
        let measured = Matrix::from_fn(rows, 2, |i, j| {
            let value = row(i).map_or(Complex::ZERO, |k| values[k]);
            if j == 0 { value.re } else { value.im }
        });
        let solution = lstsq::lstsq(&directions, &measured)?;
        Ok(Some(std::array::from_fn(|k| {
            Complex::new(solution[(k, 0)], solution[(k, 1)])
        })))
    };
    (0..n_points).map(displacement).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One channel moves its point along its direction; two skew ones determine the plane; equal ones are averaged.
    #[test]
    fn exact_displacements() {
        let z = Complex::new;
        let agree = |a: Complex, b: Complex| (a - b).norm() < 1e-14;
        let channels = [
            (2, [0.0, 0.0, -1.0]),
            (0, [1.0, 0.0, 0.0]),
            (0, [0.6, 0.8, 0.0]),
            (3, [0.0, 1.0, 0.0]),
            (3, [0.0, 1.0, 0.0]),
        ];
        let u = [z(2.0, 1.0), z(-1.0, 3.0)];
        let values = [
            z(0.5, 0.25),
            u[0],
            u[0] * 0.6 + u[1] * 0.8,
            z(1.0, 0.0),
            z(3.0, 0.0),
        ];
        let displacements = point_displacements(4, &channels, &values).unwrap();
        let [plane, unmeasured, single, averaged] = &displacements[..] else {
            panic!()
        };
        assert!(unmeasured.is_none());
        let plane = plane.unwrap();
        assert!(agree(plane[0], u[0]) && agree(plane[1], u[1]) && agree(plane[2], Complex::ZERO));
        let single = single.unwrap();
        assert!(agree(single[2], z(-0.5, -0.25)) && agree(single[0], Complex::ZERO));
        assert!(agree(averaged.unwrap()[1], z(2.0, 0.0)));
    }
}
