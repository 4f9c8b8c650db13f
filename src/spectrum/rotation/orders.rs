//! Order spectra and order tracks by blocks: `x(θ) = Σ Re A_o e^{ioθ}`, phase at zero shaft angle.

use std::f64::consts::TAU;

use super::angle_curve::AngleCurve;
use super::angular_resampling::AngularSignal;
use crate::base::error::Error;
use crate::numeric::Complex;
use crate::numeric::fft::RealFft;
use crate::spectrum::validation::check_count;
use crate::spectrum::window::Window;

/// Amplitudes over orders, averaged over blocks of revolutions.
#[derive(Debug, Clone)]
pub struct OrderSpectrum {
    /// Orders, spacing `1/turns`.
    pub order: Vec<f64>,
    /// Amplitude, zero to peak: root mean square over the blocks (at order zero the modulus of the mean).
    pub amplitude: Vec<f64>,
    /// Mean of the complex amplitudes over the blocks. Its modulus equals `amplitude` if the phase is locked to the shaft, and
    /// falls with the square root of the number of blocks otherwise.
    pub coherent_amplitude: Vec<Complex>,
    /// Number of blocks, with 50 % overlap.
    pub blocks: usize,
}

/// Order spectrum from blocks of `turns` revolutions with Hann's window: line spacing `1/turns`, main lobe four lines wide.
///
/// # Errors
/// A signal shorter than one block.
pub fn order_spectrum(signal: &AngularSignal, turns: usize) -> Result<OrderSpectrum, Error> {
    check_count(turns, 1, "the number of turns in a block")?;
    signal.check_revolutions(turns)?;
    let n = turns * signal.samples_per_rev;
    let weights = Window::Hann.samples(n);
    let scale = 2.0 / weights.iter().sum::<f64>();
    let mut fft = RealFft::new(n);
    let zero = Complex::new(0.0, 0.0);
    let (mut lines, mut block) = (vec![zero; fft.lines()], vec![0.0; n]);
    let (mut square, mut sum) = (vec![0.0; lines.len()], vec![zero; lines.len()]);
    let mut blocks = 0;
    for start in (0..=signal.values.len() - n).step_by((n / 2).max(1)) {
        let values = &signal.values[start..start + n];
        block
            .iter_mut()
            .zip(values.iter().zip(&weights))
            .for_each(|(b, (x, w))| *b = x * w);
        fft.forward(&mut block, &mut lines);
        let origin = (signal.first + start as i64).rem_euclid(n as i64) as u128;
        for (k, z) in lines.iter().enumerate() {
            // Start angle of the block in cycles of line k, fractional part.
            let cycles = (k as u128 * origin % n as u128) as f64 / n as f64;
            let factor = if k == 0 || 2 * k == n { 0.5 } else { 1.0 };
            let value = z * Complex::from_polar(factor * scale, -TAU * cycles);
            square[k] += value.norm_sqr();
            sum[k] += value;
        }
        blocks += 1;
    }
    let count = f64::from(blocks);
    Ok(OrderSpectrum {
        order: (0..lines.len()).map(|k| k as f64 / turns as f64).collect(),
        amplitude: square.iter().map(|s| (s / count).sqrt()).collect(),
        coherent_amplitude: sum.iter().map(|z| z / count).collect(),
        blocks: blocks as usize,
    })
}

/// Track of one order over a run.
#[derive(Debug, Clone)]
pub struct OrderTrack {
    /// The order.
    pub order: f64,
    /// Complex amplitude, zero to peak, at each point of [`OrderTracks`].
    pub values: Vec<Complex>,
}

/// Tracks of several orders over a run.
#[derive(Debug, Clone)]
pub struct OrderTracks {
    /// Middle of each block, s.
    pub time_s: Vec<f64>,
    /// Speed at the middle of each block, rad/s.
    pub speed: Vec<f64>,
    /// Requested orders.
    pub tracks: Vec<OrderTrack>,
}

/// Block lengths of order tracks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrderTrackOptions {
    /// Revolutions in a block: resolves orders `2/revolutions` apart, and smooths amplitudes over about half a block.
    pub revolutions: usize,
    /// Revolutions from one block to the next.
    pub step: usize,
}

/// Tracks of `orders` (cycles per revolution, not necessarily integers) over a run.
///
/// # Errors
/// A signal shorter than one block; blocks or steps of zero revolutions.
pub fn order_tracks(
    signal: &AngularSignal,
    curve: &AngleCurve,
    orders: &[f64],
    settings: OrderTrackOptions,
) -> Result<OrderTracks, Error> {
    check_count(settings.revolutions, 1, "the number of turns in a block")?;
    check_count(settings.step, 1, "the number of turns between blocks")?;
    signal.check_revolutions(settings.revolutions)?;
    let n = settings.revolutions * signal.samples_per_rev;
    let starts: Vec<usize> = (0..=signal.values.len() - n)
        .step_by(settings.step * signal.samples_per_rev)
        .collect();
    let weights = Window::Hann.samples(n);
    let sum: f64 = weights.iter().sum();
    let track = |&order: &f64| {
        let scale = if order == 0.0 { 1.0 } else { 2.0 } / sum;
        let waves: Vec<Complex> = (0..n)
            .map(|j| {
                let turns = order * j as f64 / signal.samples_per_rev as f64;
                Complex::from_polar(scale * weights[j], -TAU * turns.fract())
            })
            .collect();
        let value = |&start: &usize| {
            let block = &signal.values[start..start + n];
            let (re, im) = block
                .iter()
                .zip(&waves)
                .fold((0.0, 0.0), |(re, im), (x, w)| {
                    (re + x * w.re, im + x * w.im)
                });
            Complex::new(re, im) * Complex::from_polar(1.0, -order * signal.angle(start))
        };
        OrderTrack {
            order,
            values: starts.iter().map(value).collect(),
        }
    };
    let middle = |&start: &usize| curve.time_at(signal.angle(start + n / 2));
    let time_s: Vec<f64> = starts
        .iter()
        .map(|s| middle(s).unwrap_or(f64::NAN))
        .collect();
    Ok(OrderTracks {
        speed: time_s.iter().map(|&t| curve.speed(t)).collect(),
        time_s,
        tracks: orders.iter().map(track).collect(),
    })
}
