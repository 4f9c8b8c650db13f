//! Discrete Fourier transforms, the only file that names their packages: `X_k = Σ x_j exp(−2πi jk/n)`, unscaled forward,
//! `1/n` on the way back.

use std::sync::Arc;

use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use rustfft::{Fft, FftPlanner};

use super::Complex;

/// A transform of real data of one length, with its workspace: plan once, use often, one per thread.
pub struct RealFft {
    planner: RealFftPlanner<f64>,
    forward: Arc<dyn RealToComplex<f64>>,
    forward_space: Vec<Complex>,
    /// Planned where it is first wanted: of awkward lengths a plan costs as much as a transform.
    inverse: Option<(Arc<dyn ComplexToReal<f64>>, Vec<Complex>)>,
}

impl Clone for RealFft {
    /// The same plans with a workspace of their own.
    fn clone(&self) -> RealFft {
        RealFft {
            planner: RealFftPlanner::new(),
            forward: Arc::clone(&self.forward),
            forward_space: self.forward.make_scratch_vec(),
            inverse: self.inverse.clone(),
        }
    }
}

impl RealFft {
    /// Plans transforms of `n` samples; any `n`, fastest for products of small primes.
    pub fn new(n: usize) -> RealFft {
        let mut planner = RealFftPlanner::new();
        let forward = planner.plan_fft_forward(n);
        RealFft {
            planner,
            forward_space: forward.make_scratch_vec(),
            forward,
            inverse: None,
        }
    }

    /// Samples.
    pub fn samples(&self) -> usize {
        self.forward.len()
    }

    /// Spectral lines, `n/2 + 1`.
    pub fn lines(&self) -> usize {
        self.samples() / 2 + 1
    }

    /// `spectrum` becomes the transform of `samples`, which is overwritten as workspace.
    ///
    /// # Panics
    /// Lengths other than [`RealFft::samples`] and [`RealFft::lines`]: a mistake of the caller, never of a user's file.
    pub fn forward(&mut self, samples: &mut [f64], spectrum: &mut [Complex]) {
        assert_eq!(
            (samples.len(), spectrum.len()),
            (self.samples(), self.lines())
        );
        let done = self
            .forward
            .process_with_scratch(samples, spectrum, &mut self.forward_space);
        debug_assert!(done.is_ok(), "lengths were checked above");
    }

    /// `samples` becomes the real signal whose transform is `spectrum`, which is overwritten as workspace. The imaginary parts of
    /// the first line and, for even `n`, of the last are taken as zero.
    ///
    /// # Panics
    /// As [`RealFft::forward`].
    pub fn inverse(&mut self, spectrum: &mut [Complex], samples: &mut [f64]) {
        assert_eq!(
            (samples.len(), spectrum.len()),
            (self.samples(), self.lines())
        );
        let n = samples.len();
        if let Some(first) = spectrum.first_mut() {
            first.im = 0.0;
        }
        if n.is_multiple_of(2)
            && let Some(last) = spectrum.last_mut()
        {
            last.im = 0.0;
        }
        let (inverse, space) = self.inverse.get_or_insert_with(|| {
            let inverse = self.planner.plan_fft_inverse(n);
            let space = inverse.make_scratch_vec();
            (inverse, space)
        });
        let done = inverse.process_with_scratch(spectrum, samples, space);
        debug_assert!(done.is_ok(), "lengths were checked above");
        let scale = 1.0 / n as f64;
        samples.iter_mut().for_each(|x| *x *= scale);
    }
}

/// A transform of complex data of one length, with its workspace.
pub struct ComplexFft {
    forward: Arc<dyn Fft<f64>>,
    inverse: Arc<dyn Fft<f64>>,
    space: Vec<Complex>,
}

impl ComplexFft {
    /// Plans transforms of `n` values.
    pub fn new(n: usize) -> ComplexFft {
        let mut planner = FftPlanner::new();
        let forward = planner.plan_fft_forward(n);
        let inverse = planner.plan_fft_inverse(n);
        let space = forward
            .get_inplace_scratch_len()
            .max(inverse.get_inplace_scratch_len());
        ComplexFft {
            forward,
            inverse,
            space: vec![Complex::new(0.0, 0.0); space],
        }
    }

    /// In place, forward.
    ///
    /// # Panics
    /// Another length than planned.
    pub fn forward(&mut self, values: &mut [Complex]) {
        assert_eq!(values.len(), self.forward.len());
        self.forward.process_with_scratch(values, &mut self.space);
    }

    /// In place, back, scaled by `1/n`.
    ///
    /// # Panics
    /// Another length than planned.
    pub fn inverse(&mut self, values: &mut [Complex]) {
        assert_eq!(values.len(), self.inverse.len());
        self.inverse.process_with_scratch(values, &mut self.space);
        let scale = 1.0 / values.len() as f64;
        values.iter_mut().for_each(|z| *z *= scale);
    }
}

/// The next length at or above `n` whose only prime factors are 2, 3 and 5: quick to transform.
pub fn next_fast_len(n: usize) -> usize {
    (n.max(1)..).find(|&m| is_quick(m)).unwrap_or(n)
}

/// The next such length at or below `n`.
pub fn prev_fast_len(n: usize) -> usize {
    (1..=n).rev().find(|&m| is_quick(m)).unwrap_or(n)
}

fn is_quick(mut m: usize) -> bool {
    for p in [2, 3, 5] {
        while m.is_multiple_of(p) {
            m /= p;
        }
    }
    m == 1
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cosine on line 3 has n/2 there and nothing elsewhere; the way back gives it again; odd and even lengths.
    #[test]
    fn exact_cosine_and_back() {
        for n in [15, 16] {
            let wave = |j: usize| (std::f64::consts::TAU * 3.0 * j as f64 / n as f64).cos();
            let mut x: Vec<f64> = (0..n).map(wave).collect();
            let mut fft = RealFft::new(n);
            let mut spectrum = vec![Complex::new(0.0, 0.0); fft.lines()];
            fft.forward(&mut x, &mut spectrum);
            for (k, z) in spectrum.iter().enumerate() {
                let expected = if k == 3 { n as f64 / 2.0 } else { 0.0 };
                assert!((z - expected).norm() < 1e-14 * n as f64);
            }
            fft.inverse(&mut spectrum, &mut x);
            assert!((0..n).all(|j| (x[j] - wave(j)).abs() < 1e-15 * n as f64));
        }
    }

    #[test]
    fn exact_complex_round_trip() {
        let start: Vec<Complex> = (0..30)
            .map(|j| Complex::new(f64::from(j).sin(), f64::from(j * j).cos()))
            .collect();
        let mut z = start.clone();
        let mut fft = ComplexFft::new(30);
        fft.forward(&mut z);
        fft.inverse(&mut z);
        assert!(z.iter().zip(&start).all(|(a, b)| (a - b).norm() < 1e-14));
        assert_eq!(next_fast_len(1021), 1024);
        assert_eq!(next_fast_len(0), 1);
    }
}
