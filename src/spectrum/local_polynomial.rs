//! FRFs by the local polynomial method (Pintelon & Schoukens), response and transient per window.
//!
//! Pintelon, Schoukens, Vandersteen & Barbé, Estimation of nonparametric noise and FRF models for multivariable systems, Mech. Syst.
//! Signal Process. 24 (2010), pp. 573–595. The transient at both ends of a block is smooth over frequency: the second polynomial models
//! it, where a time window would smear the response. The estimate has no leakage for any excitation with power on every line: noise,
//! bursts, sweeps, but no signal periodic within the block. Where the input's transform is as smooth as the transient, as near the
//! ends of a sweep, the response is estimated without a transient.
//!
//! A parabola does not follow a resonance narrower than a window. For one block, or a few, all polynomials then have the common
//! denominator `D(r) = 1 + d₁ r (+ d₂ r²)`, if it reduces the residual significantly. McKelvey & Guérin, Non-parametric frequency
//! response estimation using a local rational model, 16th IFAC Symposium on System Identification (2012), with the weights of Sanathanan
//! & Koerner, IEEE Trans. Autom. Control 8 (1963), pp. 56–58.

use super::frf::{EstimatedFrf, FrfEstimate};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::fft::RealFft;
use crate::numeric::statistics::{f_sf, median};
use crate::numeric::symmetric::lu_solve_complex;
use crate::numeric::{Complex, ComplexMatrix};

/// Number of coefficients of each polynomial, a parabola.
const POLYNOMIAL_TERMS: usize = 3;

/// Least significant power of an input in a window, relative to its largest; below it is rounding of the transforms.
const MIN_RELATIVE_POWER: f64 = 1e-26;

/// Largest variance inflation factor of a determined coefficient.
const MAX_VARIANCE_INFLATION: f64 = 1e5;

/// Smallest half width of a window, lines, with a given number of residual degrees of freedom over the blocks.
pub fn min_half_width(inputs: usize, blocks: usize, dofs: usize) -> usize {
    let wanted = (POLYNOMIAL_TERMS * inputs + dofs).div_ceil(blocks.max(1)) + POLYNOMIAL_TERMS;
    // Lower limit for any number of blocks: about two lines per coefficient.
    wanted.max(2 * POLYNOMIAL_TERMS + 1) / 2
}

/// Estimator of FRFs by local polynomials, updated block by block.
pub struct LocalPolynomialEstimator {
    rate_hz: f64,
    inputs: usize,
    outputs: usize,
    half_width: usize,
    /// First line of the first window.
    first: usize,
    /// Orthonormal polynomials over a window.
    basis: Vec<Vec<f64>>,
    fft: RealFft,
    work: Vec<f64>,
    /// Transforms by block and channel; empty beyond [`MAX_POLE_BLOCKS`] blocks.
    transforms: Vec<Vec<Vec<Complex>>>,
    windows: Vec<WindowSums>,
    blocks: usize,
}

/// Least power of a window that counts for the flatness of an input, relative to the largest.
const MIN_WINDOW_POWER: f64 = 1e-4;

/// Normal equations of the least-squares problems of all outputs.
#[derive(Clone)]
struct LeastSquaresSums {
    /// `Aᴴ A` by rows; columns of `A` by power of r, then by input.
    normal: Vec<Complex>,
    /// Right-hand sides `Aᴴ Y` by output.
    right: Vec<Vec<Complex>>,
    /// Power `|Y|²` by output.
    power: Vec<f64>,
}

impl LeastSquaresSums {
    fn new(size: usize, outputs: usize) -> LeastSquaresSums {
        let zero = Complex::new(0.0, 0.0);
        LeastSquaresSums {
            normal: vec![zero; size * size],
            right: vec![vec![zero; size]; outputs],
            power: vec![0.0; outputs],
        }
    }

    fn add(&mut self, columns: &[Vec<Complex>], responses: &[Vec<Complex>]) {
        let size = columns.len();
        for a in 0..size {
            for b in 0..=a {
                let sum = product(&columns[a], &columns[b]);
                self.normal[a * size + b] += sum;
                if a != b {
                    self.normal[b * size + a] += sum.conj();
                }
            }
        }
        for (o, response) in responses.iter().enumerate() {
            self.power[o] += response.iter().map(Complex::norm_sqr).sum::<f64>();
            for (a, column) in columns.iter().enumerate() {
                self.right[o][a] += product(column, response);
            }
        }
    }
}

/// Normal equations and input statistics of a window.
#[derive(Clone)]
struct WindowSums {
    /// Normal equations after projection of the transient.
    with_transient: LeastSquaresSums,
    /// Normal equations without a transient.
    without_transient: LeastSquaresSums,
    /// Power `Σ|X|²` by input.
    input_power: Vec<f64>,
    /// Flatness `(Σ|X|²)²/Σ|X|⁴` per line by input, summed over blocks.
    input_evenness: Vec<f64>,
}

impl LocalPolynomialEstimator {
    /// Empty estimator for channels with inputs first; `block`: samples per block; windows of `2 half_width + 1` lines within the
    /// band, Hz.
    ///
    /// # Errors
    /// `TooShort`: a band narrower than a window.
    pub fn new(
        rate_hz: f64,
        inputs: usize,
        outputs: usize,
        block: usize,
        half_width: usize,
        band_hz: (f64, f64),
    ) -> Result<LocalPolynomialEstimator, Error> {
        let fft = RealFft::new(block);
        let width = 2 * half_width + 1;
        let df = rate_hz / block as f64;
        // The lines at zero and at the Nyquist frequency are excluded.
        let first = ((band_hz.0 / df).floor().max(1.0)) as usize;
        let last = ((band_hz.1 / df).ceil() as usize).min(block.div_ceil(2).saturating_sub(1));
        let count = (last + 1).saturating_sub(first) / width;
        if count == 0 {
            return Err(Error::new(
                Code::TooShort,
                format!("the band holds fewer than {width} lines of {df:.4} Hz"),
            ));
        }
        let size = POLYNOMIAL_TERMS * inputs;
        let empty = WindowSums {
            with_transient: LeastSquaresSums::new(size, outputs),
            without_transient: LeastSquaresSums::new(size, outputs),
            input_power: vec![0.0; inputs],
            input_evenness: vec![0.0; inputs],
        };
        Ok(LocalPolynomialEstimator {
            rate_hz,
            inputs,
            outputs,
            half_width,
            first,
            basis: polynomials(half_width),
            work: vec![0.0; block],
            transforms: Vec::new(),
            fft,
            windows: vec![empty; count],
            blocks: 0,
        })
    }

    /// Adds a block of all channels, inputs first.
    ///
    /// # Panics
    /// A number of channels or samples other than in `new`: mistakes of the caller.
    pub fn push(&mut self, channels: &[&[f64]]) {
        assert_eq!(channels.len(), self.inputs + self.outputs);
        let zero = Complex::new(0.0, 0.0);
        let mut transforms = vec![vec![zero; self.fft.lines()]; channels.len()];
        for (channel, transform) in channels.iter().zip(&mut transforms) {
            self.work.copy_from_slice(channel);
            self.fft.forward(&mut self.work, transform);
        }
        self.blocks += 1;
        let width = 2 * self.half_width + 1;
        let size = POLYNOMIAL_TERMS * self.inputs;
        let mut columns = vec![vec![zero; width]; size];
        let mut responses = vec![vec![zero; width]; self.outputs];
        for (window, sums) in self.windows.iter_mut().enumerate() {
            let first = self.first + window * width;
            for (j, input) in transforms[..self.inputs].iter().enumerate() {
                let lines = &input[first..first + width];
                let second: f64 = lines.iter().map(Complex::norm_sqr).sum();
                let fourth: f64 = lines.iter().map(|x| x.norm_sqr().powi(2)).sum();
                sums.input_power[j] += second;
                if fourth > 0.0 {
                    sums.input_evenness[j] += second * second / fourth / width as f64;
                }
                for s in 0..POLYNOMIAL_TERMS {
                    let column = &mut columns[s * self.inputs + j];
                    for (k, (c, x)) in column.iter_mut().zip(lines).enumerate() {
                        *c = *x * window_coordinate(k, self.half_width).powi(s as i32);
                    }
                }
            }
            let outputs = &transforms[self.inputs..];
            for (response, output) in responses.iter_mut().zip(outputs) {
                response.copy_from_slice(&output[first..first + width]);
            }
            sums.without_transient.add(&columns, &responses);
            let projected = columns.iter_mut().chain(&mut responses);
            projected.for_each(|values| project(&self.basis, values));
            sums.with_transient.add(&columns, &responses);
        }
        match self.blocks <= MAX_POLE_BLOCKS {
            true => self.transforms.push(transforms),
            false => self.transforms.clear(),
        }
    }

    /// Spectral flatness `(Σ|X|²)²/Σ|X|⁴` per line of the least flat input: the median over the windows of a band, Hz, with power. About
    /// 1/2 for noise, 1 for a sweep, 1/n for n periods in a block.
    pub fn input_flatness(&self, band_hz: (f64, f64)) -> f64 {
        let df = self.rate_hz / self.work.len() as f64;
        let width = 2 * self.half_width + 1;
        let in_band = |window: &usize| {
            let middle = (self.first + window * width + self.half_width) as f64 * df;
            (band_hz.0..=band_hz.1).contains(&middle)
        };
        let windows: Vec<&WindowSums> = (0..self.windows.len())
            .filter(in_band)
            .map(|window| &self.windows[window])
            .collect();
        let flatness = |j: usize| {
            let largest = windows.iter().map(|w| w.input_power[j]).fold(0.0, f64::max);
            let has_power = |w: &&&WindowSums| w.input_power[j] > MIN_WINDOW_POWER * largest;
            let share = |w: &&WindowSums| w.input_evenness[j] / self.blocks.max(1) as f64;
            let mut shares: Vec<f64> = windows.iter().filter(has_power).map(share).collect();
            median(&mut shares).unwrap_or(0.0)
        };
        (0..self.inputs).map(flatness).fold(1.0, f64::min)
    }

    /// Frequency responses at the centre lines of the windows.
    ///
    /// # Errors
    /// `NoSignal`: no window determines a response.
    pub fn finish(self) -> Result<FrfEstimate, Error> {
        let width = 2 * self.half_width + 1;
        let df = self.rate_hz / self.work.len() as f64;
        let (inputs, size) = (self.inputs, POLYNOMIAL_TERMS * self.inputs);
        let outputs = self.outputs;
        let lines = self.windows.len();
        let total = (self.blocks * (width - POLYNOMIAL_TERMS)) as f64;
        let dofs = total - size as f64;
        let initial = |k: usize| EstimatedFrf {
            input: k % inputs,
            output: inputs + k / inputs,
            values: vec![Complex::new(0.0, 0.0); lines],
            variance: Some(vec![f64::INFINITY; lines]),
            ordinary_coherence: vec![0.0; lines],
            partial_coherence: vec![0.0; lines],
        };
        let mut functions: Vec<EstimatedFrf> = (0..inputs * outputs).map(initial).collect();
        let mut coherence = vec![vec![0.0; lines]; outputs];
        let largest: Vec<f64> = (0..inputs)
            .map(|j| {
                self.windows
                    .iter()
                    .map(|w| w.input_power[j])
                    .fold(0.0, f64::max)
            })
            .collect();
        let mut undetermined = Vec::new();
        for (k, window) in self.windows.iter().enumerate() {
            let is_excited =
                (0..inputs).all(|j| window.input_power[j] > MIN_RELATIVE_POWER * largest[j]);
            let joint_inverse = is_excited
                .then(|| inverse(&window.with_transient.normal, size))
                .flatten();
            let plain_inverse = is_excited
                .then(|| inverse(&window.without_transient.normal, size))
                .flatten();
            if joint_inverse.is_none() && plain_inverse.is_none() {
                undetermined.push(k);
                continue;
            }
            for o in 0..outputs {
                let fit = |sums: &LeastSquaresSums, inverse: &ComplexMatrix, dofs: f64| {
                    polynomial_fit(sums, inverse, o, inputs, dofs)
                };
                let plain = (plain_inverse.as_ref()).map(|i| {
                    fit(
                        &window.without_transient,
                        i,
                        dofs + (self.blocks * POLYNOMIAL_TERMS) as f64,
                    )
                });
                let joint = joint_inverse
                    .as_ref()
                    .map(|i| fit(&window.with_transient, i, dofs));
                let estimate = match (joint, plain) {
                    (Some(joint), Some(plain)) if !transient_is_identifiable(&joint, &plain) => {
                        estimate_without_transient(joint, plain)
                    }
                    (Some(joint), _) => self.best_rational_fit(k, o, joint),
                    (None, Some(plain)) => WindowEstimate {
                        gain: plain
                            .gain
                            .iter()
                            .map(|s| MAX_VARIANCE_INFLATION * s)
                            .collect(),
                        ..plain
                    },
                    (None, None) => continue,
                };
                let noise = estimate.residual / estimate.dof;
                let output_power = window.with_transient.power[o] / total;
                if output_power > 0.0 {
                    coherence[o][k] = (1.0 - noise / output_power).clamp(0.0, 1.0);
                }
                for j in 0..inputs {
                    let power = estimate.value[j].norm_sqr() / estimate.gain[j];
                    let partial = power / (power + estimate.residual).max(f64::MIN_POSITIVE);
                    if inputs == 1 {
                        // With it |H|² (1 − γ²)/γ²/(n − 1) is the variance, as for averaged spectra.
                        coherence[o][k] = partial;
                    }
                    let function = &mut functions[o * inputs + j];
                    function.values[k] = estimate.value[j];
                    if let Some(variance) = &mut function.variance {
                        variance[k] = noise * estimate.gain[j];
                    }
                    function.partial_coherence[k] = partial;
                    function.ordinary_coherence[k] = coherence[o][k];
                }
            }
        }
        if undetermined.len() == lines {
            return Err(Error::new(
                Code::NoSignal,
                "the inputs are not independent on neighbouring lines",
            ));
        }
        let middle = |k: usize| (self.first + k * width + self.half_width) as f64 * df;
        Ok(FrfEstimate {
            frequency_hz: (0..lines).map(middle).collect(),
            functions,
            multiple_coherence: coherence,
            undetermined_lines: undetermined,
            // The number of averages with the same residual degrees of freedom.
            averages: dofs + inputs as f64,
            window_decay: 0.0,
            diagnostics: Vec::new(),
        })
    }
}

/// Maximum number of blocks for a fit with poles; every block adds the unknowns of a transient.
pub const MAX_POLE_BLOCKS: usize = 4;

/// Maximum number of poles of a window; and significance level of a pole, small as the poles are searched.
const MAX_WINDOW_POLES: usize = 2;
const POLE_FALSE_ALARM: f64 = 1e-6;

/// Upper limit of F, reached by data without noise.
const MAX_F_STATISTIC: f64 = 1e12;

/// Number of Sanathanan–Koerner iterations.
const MAX_ITERATIONS: usize = 4;

/// Least ratio of smallest to largest denominator in a window; below it the pole lies on a line, which is no resonance.
const MIN_DENOMINATOR: f64 = 1e-3;

/// Minimum number of residual degrees of freedom for a variance.
const MIN_DOF: usize = 3;

/// Estimated responses of one output in a window.
struct WindowEstimate {
    /// Responses at the centre line by input.
    value: Vec<Complex>,
    /// Noise gains: variances of the responses relative to that of the noise.
    gain: Vec<f64>,
    /// Residual sum of squares and its degrees of freedom.
    residual: f64,
    dof: f64,
}

/// Estimate by polynomials alone, from the inverse of the normal matrix.
fn polynomial_fit(
    sums: &LeastSquaresSums,
    inverse: &ComplexMatrix,
    output: usize,
    inputs: usize,
    dofs: f64,
) -> WindowEstimate {
    let right = &sums.right[output];
    let theta = times(inverse, right);
    let explained: f64 = (theta.iter().zip(right))
        .map(|(t, r)| (t.conj() * r).re)
        .sum();
    WindowEstimate {
        value: theta[..inputs].to_vec(),
        gain: (0..inputs).map(|j| inverse[(j, j)].re).collect(),
        residual: (sums.power[output] - explained).max(0.0),
        dof: dofs,
    }
}

/// Largest variance ratio of a response with a transient to one without it.
const MAX_TRANSIENT_COST: f64 = 100.0;

/// Whether the transient is distinguishable from the response to the input. Near the beginning and the end of a sweep it is not: there
/// the input's transform is as smooth as the transient, and the two polynomials compensate each other's model errors.
fn transient_is_identifiable(joint: &WindowEstimate, plain: &WindowEstimate) -> bool {
    (joint.gain.iter().zip(&plain.gain)).all(|(a, b)| *a < MAX_TRANSIENT_COST * b)
}

/// Response without a transient; its variance is that with a transient plus the squared difference of the two estimates, as an
/// undetermined transient may be present.
fn estimate_without_transient(joint: WindowEstimate, plain: WindowEstimate) -> WindowEstimate {
    let noise = (joint.residual / joint.dof).max(f64::MIN_POSITIVE);
    let pairs = joint.value.iter().zip(&plain.value);
    let bias = pairs.map(|(a, b)| (a - b).norm_sqr() / noise);
    WindowEstimate {
        gain: joint.gain.iter().zip(bias).map(|(s, m)| s + m).collect(),
        value: plain.value,
        ..joint
    }
}

/// F test of the reduction of the residual by additional unknowns.
fn is_significant(next: &WindowEstimate, current: &WindowEstimate) -> bool {
    let added = current.dof - next.dof;
    let reduction = (current.residual - next.residual) / added;
    let noise = (next.residual / next.dof).max(f64::MIN_POSITIVE);
    let ratio = (reduction / noise).min(MAX_F_STATISTIC);
    reduction > 0.0 && f_sf(ratio, 2.0 * added, 2.0 * next.dof) < POLE_FALSE_ALARM
}

impl LocalPolynomialEstimator {
    /// Estimate with as many poles as are significant.
    fn best_rational_fit(
        &self,
        k: usize,
        output: usize,
        initial: WindowEstimate,
    ) -> WindowEstimate {
        (1..=MAX_WINDOW_POLES).fold(initial, |estimate, order| {
            let next = self.rational_fit(k, output, order);
            next.filter(|next| is_significant(next, &estimate))
                .unwrap_or(estimate)
        })
    }

    /// Estimate by polynomials of the inputs and of the transient of each block, over a denominator of the given order.
    fn rational_fit(&self, window: usize, output: usize, order: usize) -> Option<WindowEstimate> {
        let width = 2 * self.half_width + 1;
        let polynomials = POLYNOMIAL_TERMS * (self.inputs + self.blocks);
        let (unknowns, rows) = (polynomials + order, self.blocks * width);
        if self.transforms.is_empty() || rows < unknowns + MIN_DOF {
            return None;
        }
        // Equations by block, then by line.
        let value = |channel: usize, k: usize| {
            self.transforms[k / width][channel][self.first + window * width + k % width]
        };
        let y: Vec<Complex> = (0..rows).map(|k| value(self.inputs + output, k)).collect();
        let power =
            |k: usize, s: usize| window_coordinate(k % width, self.half_width).powi(s as i32);
        let column = |a: usize, k: usize| match a {
            a if a < POLYNOMIAL_TERMS * self.inputs => {
                let (s, j) = (a / self.inputs, a % self.inputs);
                value(j, k) * power(k, s)
            }
            a if a < polynomials => {
                let term = a - POLYNOMIAL_TERMS * self.inputs;
                match term / POLYNOMIAL_TERMS == k / width {
                    true => Complex::new(power(k, term % POLYNOMIAL_TERMS), 0.0),
                    false => Complex::new(0.0, 0.0),
                }
            }
            a => -y[k] * power(k, a + 1 - polynomials),
        };
        let mut denominator = vec![Complex::new(1.0, 0.0); rows];
        let mut best: Option<(WindowEstimate, Vec<Complex>)> = None;
        for _ in 0..MAX_ITERATIONS {
            let weighted = |a: usize| -> Vec<Complex> {
                (0..rows).map(|k| column(a, k) / denominator[k]).collect()
            };
            let columns: Vec<Vec<Complex>> = (0..unknowns).map(weighted).collect();
            let response: Vec<Complex> = y.iter().zip(&denominator).map(|(y, d)| y / d).collect();
            let mut normal = Vec::with_capacity(unknowns * unknowns);
            for a in &columns {
                normal.extend(columns.iter().map(|b| product(a, b)));
            }
            let inverse = inverse(&normal, unknowns)?;
            let right: Vec<Complex> = columns.iter().map(|a| product(a, &response)).collect();
            let theta = times(&inverse, &right);
            let squared_error = |k: usize| {
                let model: Complex = (0..unknowns).map(|a| theta[a] * columns[a][k]).sum();
                (response[k] - model).norm_sqr()
            };
            let estimate = WindowEstimate {
                value: theta[..self.inputs].to_vec(),
                gain: (0..self.inputs).map(|j| inverse[(j, j)].re).collect(),
                residual: (0..rows).map(squared_error).sum(),
                dof: (rows - unknowns) as f64,
            };
            best = Some((estimate, theta[unknowns - order..].to_vec()));
            let denominator_at = |k: usize| {
                let terms = (1..=order).map(|s| theta[unknowns - order + s - 1] * power(k, s));
                1.0 + terms.sum::<Complex>()
            };
            denominator = (0..rows).map(denominator_at).collect();
            let sizes = denominator.iter().map(|d| d.norm());
            let (min, max) = sizes.fold((f64::INFINITY, 0.0_f64), |(l, m), d| (l.min(d), m.max(d)));
            if !(min > MIN_DENOMINATOR * max) {
                return None;
            }
        }
        best.filter(|(_, d)| are_resonances(d)).map(|best| best.0)
    }
}

/// Whether the roots of `1 + d₁ r (+ d₂ r²)` are stable poles (above the real axis) within a few half widths of the window. Other
/// roots fit noise.
fn are_resonances(d: &[Complex]) -> bool {
    // Resonances at up to several window widths distort a parabola.
    const MAX_POLE_DISTANCE: f64 = 4.0;
    let is_resonance =
        |r: Complex| r.re.abs() < MAX_POLE_DISTANCE && r.im > 0.0 && r.im < MAX_POLE_DISTANCE;
    match d {
        [first] => is_resonance(-first.inv()),
        [first, second] => {
            let root = (first * first - second * 4.0).sqrt();
            let twice = second * 2.0;
            is_resonance((root - first) / twice) && is_resonance((-root - first) / twice)
        }
        _ => false,
    }
}

/// Inverse of a normal matrix given by rows; `None` for undetermined unknowns.
fn inverse(normal: &[Complex], size: usize) -> Option<ComplexMatrix> {
    // Scaled by the norms of the columns.
    let scale: Vec<f64> = (0..size).map(|a| normal[a * size + a].re.sqrt()).collect();
    if scale.iter().any(|s| !(*s > 0.0)) {
        return None;
    }
    let scaled = ComplexMatrix::from_fn(size, size, |a, b| {
        normal[a * size + b] / (scale[a] * scale[b])
    });
    let identity = ComplexMatrix::identity(size, size);
    let inverse = lu_solve_complex(&scaled, &identity).ok()?;
    let is_determined =
        |a: usize| inverse[(a, a)].re > 0.0 && inverse[(a, a)].re < MAX_VARIANCE_INFLATION;
    (0..size)
        .all(is_determined)
        .then(|| ComplexMatrix::from_fn(size, size, |a, b| inverse[(a, b)] / (scale[a] * scale[b])))
}

/// Matrix–vector product `A x`.
fn times(a: &ComplexMatrix, x: &[Complex]) -> Vec<Complex> {
    (0..x.len())
        .map(|i| (0..x.len()).map(|j| a[(i, j)] * x[j]).sum())
        .collect()
}

/// Coordinate of a line in its window, −1 to 1.
fn window_coordinate(line: usize, half_width: usize) -> f64 {
    (line as f64 - half_width as f64) / half_width as f64
}

/// Orthonormal polynomials over a window, by the Gram–Schmidt process.
fn polynomials(half_width: usize) -> Vec<Vec<f64>> {
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for s in 0..POLYNOMIAL_TERMS {
        let mut next: Vec<f64> = (0..=2 * half_width)
            .map(|k| window_coordinate(k, half_width).powi(s as i32))
            .collect();
        for previous in &basis {
            let component: f64 = previous.iter().zip(&next).map(|(a, b)| a * b).sum();
            next.iter_mut()
                .zip(previous)
                .for_each(|(n, k)| *n -= component * k);
        }
        let norm = next.iter().map(|x| x * x).sum::<f64>().sqrt();
        next.iter_mut().for_each(|x| *x /= norm);
        basis.push(next);
    }
    basis
}

/// Subtracts the projection onto the polynomials.
fn project(basis: &[Vec<f64>], values: &mut [Complex]) {
    for polynomial in basis {
        let component: Complex = polynomial
            .iter()
            .zip(values.iter())
            .map(|(p, v)| v * *p)
            .sum();
        values
            .iter_mut()
            .zip(polynomial)
            .for_each(|(v, p)| *v -= component * *p);
    }
}

/// Inner product `aᴴ b`.
fn product(a: &[Complex], b: &[Complex]) -> Complex {
    a.iter().zip(b).map(|(a, b)| a.conj() * b).sum()
}
