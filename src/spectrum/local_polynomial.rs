//! FRFs by the local polynomial method (Pintelon & Schoukens), response and transient per window.
//!
//! Pintelon, Schoukens, Vandersteen & Barbé, Estimation of nonparametric noise and FRF models for multivariable systems, Mech. Syst.
//! Signal Process. 24 (2010), pp. 573–595. What rings into a block from before it, and out of it, is smooth over frequency: the second
//! polynomial takes it, where a window would smear the response. So there is no leakage, whatever the excitation, as long as it has
//! power on every line: noise, bursts, sweeps, not what repeats inside the block. Where the input's transform is as smooth as what rings,
//! as near the ends of a sweep, the response is told as from rest.
//!
//! Where a resonance is no wider than a window, no parabola follows it: over one block, or a few, all polynomials then stand over a common
//! `D(r) = 1 + d₁ r (+ d₂ r²)`, if that lowers what is left by more than noise would. McKelvey & Guérin, Non-parametric frequency
//! response estimation using a local rational model, 16th IFAC Symposium on System Identification (2012), with the weights of Sanathanan
//! & Koerner, IEEE Trans. Autom. Control 8 (1963), pp. 56–58.

use super::frf::{EstimatedFrf, FrfEstimate};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::fft::RealFft;
use crate::numeric::statistics::{f_sf, median};
use crate::numeric::symmetric::lu_solve_complex;
use crate::numeric::{Complex, ComplexMatrix};

/// Coefficients of each polynomial: a parabola.
const POLYNOMIAL_TERMS: usize = 3;

/// An input's power in a window, relative to its largest, that is but the rounding of transforms.
const MIN_RELATIVE_POWER: f64 = 1e-26;

/// Largest variance inflation of a coefficient: if the others determine it to this share and inflate its noise as much, it is undetermined.
const MAX_VARIANCE_INFLATION: f64 = 1e5;

/// The smallest half width of a window, in lines, that leaves its residual so many degrees of freedom over so many blocks.
pub fn min_half_width(inputs: usize, blocks: usize, dofs: usize) -> usize {
    let wanted = (POLYNOMIAL_TERMS * inputs + dofs).div_ceil(blocks.max(1)) + POLYNOMIAL_TERMS;
    // Fewer lines than this are no polynomial's worth, however many blocks.
    wanted.max(2 * POLYNOMIAL_TERMS + 1) / 2
}

/// Gathers the windows of blocks.
pub struct LocalPolynomialEstimator {
    rate_hz: f64,
    inputs: usize,
    outputs: usize,
    half_width: usize,
    /// First line of the first window, and the number of windows.
    first: usize,
    /// Orthonormal polynomials over a window.
    basis: Vec<Vec<f64>>,
    fft: RealFft,
    work: Vec<f64>,
    /// By block and channel; none of more than [`MAX_POLE_BLOCKS`].
    transforms: Vec<Vec<Vec<Complex>>>,
    windows: Vec<WindowSums>,
    blocks: usize,
}

/// Windows whose power is below this share of the largest do not count for how even an input is.
const MIN_WINDOW_POWER: f64 = 1e-4;

/// Normal equations.
#[derive(Clone)]
struct LeastSquaresSums {
    /// `Aᴴ A`, its columns input by input inside power by power, row by row.
    normal: Vec<Complex>,
    /// `Aᴴ Y` by output.
    right: Vec<Vec<Complex>>,
    /// `|Y|²` by output.
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

    fn add(&mut self, columns: &[Vec<Complex>], answers: &[Vec<Complex>]) {
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
        for (o, answer) in answers.iter().enumerate() {
            self.power[o] += answer.iter().map(Complex::norm_sqr).sum::<f64>();
            for (a, column) in columns.iter().enumerate() {
                self.right[o][a] += product(column, answer);
            }
        }
    }
}

/// Least-squares sums of a window.
#[derive(Clone)]
struct WindowSums {
    /// With the transient taken out.
    with_transient: LeastSquaresSums,
    /// As if there were none.
    without_transient: LeastSquaresSums,
    /// `Σ|X|²` by input.
    input_power: Vec<f64>,
    /// `(Σ|X|²)²/Σ|X|⁴` over the number of lines by input, summed over blocks.
    input_evenness: Vec<f64>,
}

impl LocalPolynomialEstimator {
    /// Nothing yet, for channels of which the first `inputs` drive; `block` samples each, windows of `2 half_width + 1` lines inside
    /// the band, Hz.
    ///
    /// # Errors
    /// `TooShort` where the band holds no window.
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
        // Neither the mean nor half the rate.
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

    /// Takes a block of every channel, inputs first.
    ///
    /// # Panics
    /// Another number of channels or samples than announced: mistakes of the caller.
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
        let mut answers = vec![vec![zero; width]; self.outputs];
        for (at, gathered) in self.windows.iter_mut().enumerate() {
            let from = self.first + at * width;
            for (j, input) in transforms[..self.inputs].iter().enumerate() {
                let lines = &input[from..from + width];
                let second: f64 = lines.iter().map(Complex::norm_sqr).sum();
                let fourth: f64 = lines.iter().map(|x| x.norm_sqr().powi(2)).sum();
                gathered.input_power[j] += second;
                if fourth > 0.0 {
                    gathered.input_evenness[j] += second * second / fourth / width as f64;
                }
                for s in 0..POLYNOMIAL_TERMS {
                    let column = &mut columns[s * self.inputs + j];
                    for (k, (c, x)) in column.iter_mut().zip(lines).enumerate() {
                        *c = *x * window_coordinate(k, self.half_width).powi(s as i32);
                    }
                }
            }
            let outputs = &transforms[self.inputs..];
            for (answer, output) in answers.iter_mut().zip(outputs) {
                answer.copy_from_slice(&output[from..from + width]);
            }
            gathered.without_transient.add(&columns, &answers);
            let both = columns.iter_mut().chain(&mut answers);
            both.for_each(|values| project(&self.basis, values));
            gathered.with_transient.add(&columns, &answers);
        }
        match self.blocks <= MAX_POLE_BLOCKS {
            true => self.transforms.push(transforms),
            false => self.transforms.clear(),
        }
    }

    /// The share of lines in a window of a band, Hz, that carry an input's power, by `(Σ|X|²)²/Σ|X|⁴`: the median over the windows that have power, of
    /// the least even input. About one half for noise, one for a sweep, the inverse of the number of repetitions for what repeats.
    pub fn input_flatness(&self, band_hz: (f64, f64)) -> f64 {
        let df = self.rate_hz / self.work.len() as f64;
        let width = 2 * self.half_width + 1;
        let inside = |at: &usize| {
            let middle = (self.first + at * width + self.half_width) as f64 * df;
            (band_hz.0..=band_hz.1).contains(&middle)
        };
        let windows: Vec<&WindowSums> = (0..self.windows.len())
            .filter(inside)
            .map(|at| &self.windows[at])
            .collect();
        let of = |j: usize| {
            let largest = windows.iter().map(|w| w.input_power[j]).fold(0.0, f64::max);
            let has_power = |w: &&&WindowSums| w.input_power[j] > MIN_WINDOW_POWER * largest;
            let share = |w: &&WindowSums| w.input_evenness[j] / self.blocks.max(1) as f64;
            let mut shares: Vec<f64> = windows.iter().filter(has_power).map(share).collect();
            median(&mut shares).unwrap_or(0.0)
        };
        (0..self.inputs).map(of).fold(1.0, f64::min)
    }

    /// The responses at the middles of the windows.
    ///
    /// # Errors
    /// `NoSignal` where no window tells a response.
    pub fn finish(self) -> Result<FrfEstimate, Error> {
        let width = 2 * self.half_width + 1;
        let df = self.rate_hz / self.work.len() as f64;
        let (inputs, size) = (self.inputs, POLYNOMIAL_TERMS * self.inputs);
        let outputs = self.outputs;
        let lines = self.windows.len();
        let total = (self.blocks * (width - POLYNOMIAL_TERMS)) as f64;
        let dofs = total - size as f64;
        let empty = |at: usize| EstimatedFrf {
            input: at % inputs,
            output: inputs + at / inputs,
            values: vec![Complex::new(0.0, 0.0); lines],
            variance: Some(vec![f64::INFINITY; lines]),
            ordinary_coherence: vec![0.0; lines],
            partial_coherence: vec![0.0; lines],
        };
        let mut functions: Vec<EstimatedFrf> = (0..inputs * outputs).map(empty).collect();
        let mut multiple = vec![vec![0.0; lines]; outputs];
        let largest: Vec<f64> = (0..inputs)
            .map(|j| {
                self.windows
                    .iter()
                    .map(|w| w.input_power[j])
                    .fold(0.0, f64::max)
            })
            .collect();
        let mut undetermined = Vec::new();
        for (at, window) in self.windows.iter().enumerate() {
            let is_driven =
                (0..inputs).all(|j| window.input_power[j] > MIN_RELATIVE_POWER * largest[j]);
            let beside = is_driven
                .then(|| inverse(&window.with_transient.normal, size))
                .flatten();
            let from_rest = is_driven
                .then(|| inverse(&window.without_transient.normal, size))
                .flatten();
            if beside.is_none() && from_rest.is_none() {
                undetermined.push(at);
                continue;
            }
            for o in 0..outputs {
                let plain = |sums: &LeastSquaresSums, inverse: &ComplexMatrix, dofs: f64| {
                    polynomial_fit(sums, inverse, o, inputs, dofs)
                };
                let rest = (from_rest.as_ref()).map(|i| {
                    plain(
                        &window.without_transient,
                        i,
                        dofs + (self.blocks * POLYNOMIAL_TERMS) as f64,
                    )
                });
                let beside = beside
                    .as_ref()
                    .map(|i| plain(&window.with_transient, i, dofs));
                let told = match (beside, rest) {
                    (Some(beside), Some(rest)) if !transient_is_identifiable(&beside, &rest) => {
                        estimate_without_transient(beside, rest)
                    }
                    (Some(beside), _) => self.best_rational_fit(at, o, beside),
                    (None, Some(rest)) => WindowEstimate {
                        spread: rest
                            .spread
                            .iter()
                            .map(|s| MAX_VARIANCE_INFLATION * s)
                            .collect(),
                        ..rest
                    },
                    (None, None) => continue,
                };
                let noise = told.residual / told.dof;
                let all = window.with_transient.power[o] / total;
                if all > 0.0 {
                    multiple[o][at] = (1.0 - noise / all).clamp(0.0, 1.0);
                }
                for j in 0..inputs {
                    let own = told.value[j].norm_sqr() / told.spread[j];
                    let partial = own / (own + told.residual).max(f64::MIN_POSITIVE);
                    if inputs == 1 {
                        // So that |H|² (1 − γ²)/γ²/(n − 1) is the variance, as of an average.
                        multiple[o][at] = partial;
                    }
                    let function = &mut functions[o * inputs + j];
                    function.values[at] = told.value[j];
                    if let Some(variance) = &mut function.variance {
                        variance[at] = noise * told.spread[j];
                    }
                    function.partial_coherence[at] = partial;
                    function.ordinary_coherence[at] = multiple[o][at];
                }
            }
        }
        if undetermined.len() == lines {
            return Err(Error::new(
                Code::NoSignal,
                "the inputs have no power of their own on neighbouring lines",
            ));
        }
        let middle = |at: usize| (self.first + at * width + self.half_width) as f64 * df;
        Ok(FrfEstimate {
            frequency_hz: (0..lines).map(middle).collect(),
            functions,
            multiple_coherence: multiple,
            undetermined_lines: undetermined,
            // As many as leave a residual of the same degrees of freedom.
            averages: dofs + inputs as f64,
            window_decay: 0.0,
            diagnostics: Vec::new(),
        })
    }
}

/// Maximum number of blocks whose windows are fitted with poles; every block adds a transient.
pub const MAX_POLE_BLOCKS: usize = 4;

/// Poles of a window at most, and how often noise alone asks for one: of a thousand windows none, its poles being sought.
const MAX_WINDOW_POLES: usize = 2;
const POLE_FALSE_ALARM: f64 = 1e-6;

/// Beyond this, F is a model without noise.
const MAX_F_STATISTIC: f64 = 1e12;

/// Rounds in which the denominator of the last weighs the next.
const MAX_ITERATIONS: usize = 4;

/// A denominator that falls below this share of its largest inside the window says that a pole lies on a line: none does.
const MIN_DENOMINATOR: f64 = 1e-3;

/// Fewer degrees of freedom left tell no variance.
const MIN_DOF: usize = 3;

/// Estimate of one output in a window.
struct WindowEstimate {
    /// Responses at the middle by input.
    value: Vec<Complex>,
    /// Their variances over that of the noise.
    spread: Vec<f64>,
    /// Residual sum of squares and degrees of freedom.
    residual: f64,
    dof: f64,
}

/// By polynomials alone, from the inverse of the normal matrix.
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
        spread: (0..inputs).map(|j| inverse[(j, j)].re).collect(),
        residual: (sums.power[output] - explained).max(0.0),
        dof: dofs,
    }
}

/// Variance ratio of the transient's polynomial above which the response is estimated without it.
const MAX_TRANSIENT_COST: f64 = 100.0;

/// Whether a transient ringing into a block is distinguishable from the response to the input. Near the beginning and the end of a
/// sweep it is not: there the input's transform is as smooth as the transient, and the two polynomials take from each other whatever
/// the model misses.
fn transient_is_identifiable(beside: &WindowEstimate, rest: &WindowEstimate) -> bool {
    (beside.spread.iter().zip(&rest.spread))
        .all(|(with, without)| *with < MAX_TRANSIENT_COST * without)
}

/// Response as if nothing rang in or out; its variance is that with a transient plus the squared difference of the two estimates,
/// since an undetermined transient may be present all the same.
fn estimate_without_transient(beside: WindowEstimate, rest: WindowEstimate) -> WindowEstimate {
    let noise = (beside.residual / beside.dof).max(f64::MIN_POSITIVE);
    let off = beside.value.iter().zip(&rest.value);
    let more = off.map(|(a, b)| (a - b).norm_sqr() / noise);
    WindowEstimate {
        spread: beside.spread.iter().zip(more).map(|(s, m)| s + m).collect(),
        value: rest.value,
        ..beside
    }
}

/// Whether more unknowns lower what is left by more than noise would.
fn is_significant(next: &WindowEstimate, plain: &WindowEstimate) -> bool {
    let fewer = plain.dof - next.dof;
    let fall = (plain.residual - next.residual) / fewer;
    let noise = (next.residual / next.dof).max(f64::MIN_POSITIVE);
    let ratio = (fall / noise).min(MAX_F_STATISTIC);
    fall > 0.0 && f_sf(ratio, 2.0 * fewer, 2.0 * next.dof) < POLE_FALSE_ALARM
}

impl LocalPolynomialEstimator {
    /// The same over as many poles as are worth it.
    fn best_rational_fit(&self, at: usize, output: usize, plain: WindowEstimate) -> WindowEstimate {
        (1..=MAX_WINDOW_POLES).fold(plain, |told, order| {
            let next = self.rational_fit(at, output, order);
            next.filter(|next| is_significant(next, &told))
                .unwrap_or(told)
        })
    }

    /// The polynomials of the inputs and of each block's transient over a denominator of the given order.
    fn rational_fit(&self, at: usize, output: usize, order: usize) -> Option<WindowEstimate> {
        let width = 2 * self.half_width + 1;
        let polynomials = POLYNOMIAL_TERMS * (self.inputs + self.blocks);
        let (unknowns, rows) = (polynomials + order, self.blocks * width);
        if self.transforms.is_empty() || rows < unknowns + MIN_DOF {
            return None;
        }
        // Block by block, line by line.
        let value = |channel: usize, k: usize| {
            self.transforms[k / width][channel][self.first + at * width + k % width]
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
                let own = a - POLYNOMIAL_TERMS * self.inputs;
                match own / POLYNOMIAL_TERMS == k / width {
                    true => Complex::new(power(k, own % POLYNOMIAL_TERMS), 0.0),
                    false => Complex::new(0.0, 0.0),
                }
            }
            a => -y[k] * power(k, a + 1 - polynomials),
        };
        let mut denominator = vec![Complex::new(1.0, 0.0); rows];
        let mut found: Option<(WindowEstimate, Vec<Complex>)> = None;
        for _ in 0..MAX_ITERATIONS {
            let weighted = |a: usize| -> Vec<Complex> {
                (0..rows).map(|k| column(a, k) / denominator[k]).collect()
            };
            let columns: Vec<Vec<Complex>> = (0..unknowns).map(weighted).collect();
            let answer: Vec<Complex> = y.iter().zip(&denominator).map(|(y, d)| y / d).collect();
            let mut normal = Vec::with_capacity(unknowns * unknowns);
            for a in &columns {
                normal.extend(columns.iter().map(|b| product(a, b)));
            }
            let inverse = inverse(&normal, unknowns)?;
            let right: Vec<Complex> = columns.iter().map(|a| product(a, &answer)).collect();
            let theta = times(&inverse, &right);
            let off = |k: usize| {
                let model: Complex = (0..unknowns).map(|a| theta[a] * columns[a][k]).sum();
                (answer[k] - model).norm_sqr()
            };
            let told = WindowEstimate {
                value: theta[..self.inputs].to_vec(),
                spread: (0..self.inputs).map(|j| inverse[(j, j)].re).collect(),
                residual: (0..rows).map(off).sum(),
                dof: (rows - unknowns) as f64,
            };
            found = Some((told, theta[unknowns - order..].to_vec()));
            let of = |k: usize| {
                let terms = (1..=order).map(|s| theta[unknowns - order + s - 1] * power(k, s));
                1.0 + terms.sum::<Complex>()
            };
            denominator = (0..rows).map(of).collect();
            let sizes = denominator.iter().map(|d| d.norm());
            let (least, most) =
                sizes.fold((f64::INFINITY, 0.0_f64), |(l, m), d| (l.min(d), m.max(d)));
            if !(least > MIN_DENOMINATOR * most) {
                return None;
            }
        }
        found
            .filter(|(_, d)| are_resonances(d))
            .map(|found| found.0)
    }
}

/// Whether the roots of `1 + d₁ r (+ d₂ r²)` are stable poles (above the real axis) within a few of the window's half-widths, and no
/// wider. Others only follow noise.
fn are_resonances(d: &[Complex]) -> bool {
    // A parabola misses resonances up to several of its widths away.
    const MAX_POLE_DISTANCE: f64 = 4.0;
    let is_one =
        |r: Complex| r.re.abs() < MAX_POLE_DISTANCE && r.im > 0.0 && r.im < MAX_POLE_DISTANCE;
    match d {
        [first] => is_one(-first.inv()),
        [first, second] => {
            let root = (first * first - second * 4.0).sqrt();
            let twice = second * 2.0;
            is_one((root - first) / twice) && is_one((-root - first) / twice)
        }
        _ => false,
    }
}

/// The inverse of a normal matrix, row by row; nothing where it does not tell the unknowns.
fn inverse(normal: &[Complex], size: usize) -> Option<ComplexMatrix> {
    // Over the sizes of the columns.
    let scale: Vec<f64> = (0..size).map(|a| normal[a * size + a].re.sqrt()).collect();
    if scale.iter().any(|s| !(*s > 0.0)) {
        return None;
    }
    let scaled = ComplexMatrix::from_fn(size, size, |a, b| {
        normal[a * size + b] / (scale[a] * scale[b])
    });
    let one = ComplexMatrix::identity(size, size);
    let inverse = lu_solve_complex(&scaled, &one).ok()?;
    let is_told =
        |a: usize| inverse[(a, a)].re > 0.0 && inverse[(a, a)].re < MAX_VARIANCE_INFLATION;
    (0..size)
        .all(is_told)
        .then(|| ComplexMatrix::from_fn(size, size, |a, b| inverse[(a, b)] / (scale[a] * scale[b])))
}

/// `A x`.
fn times(a: &ComplexMatrix, x: &[Complex]) -> Vec<Complex> {
    (0..x.len())
        .map(|i| (0..x.len()).map(|j| a[(i, j)] * x[j]).sum())
        .collect()
}

/// Coordinate of a line in its window, −1 to 1.
fn window_coordinate(line: usize, half_width: usize) -> f64 {
    (line as f64 - half_width as f64) / half_width as f64
}

/// Orthonormal polynomials over a window, by Gram and Schmidt.
fn polynomials(half_width: usize) -> Vec<Vec<f64>> {
    let mut all: Vec<Vec<f64>> = Vec::new();
    for s in 0..POLYNOMIAL_TERMS {
        let mut next: Vec<f64> = (0..=2 * half_width)
            .map(|k| window_coordinate(k, half_width).powi(s as i32))
            .collect();
        for known in &all {
            let along: f64 = known.iter().zip(&next).map(|(a, b)| a * b).sum();
            next.iter_mut()
                .zip(known)
                .for_each(|(n, k)| *n -= along * k);
        }
        let size = next.iter().map(|x| x * x).sum::<f64>().sqrt();
        next.iter_mut().for_each(|x| *x /= size);
        all.push(next);
    }
    all
}

/// Takes the polynomials out.
fn project(basis: &[Vec<f64>], values: &mut [Complex]) {
    for polynomial in basis {
        let along: Complex = polynomial
            .iter()
            .zip(values.iter())
            .map(|(p, v)| v * *p)
            .sum();
        values
            .iter_mut()
            .zip(polynomial)
            .for_each(|(v, p)| *v -= along * *p);
    }
}

/// `aᴴ b`.
fn product(a: &[Complex], b: &[Complex]) -> Complex {
    a.iter().zip(b).map(|(a, b)| a.conj() * b).sum()
}
