//! The lowest modes, or those nearest a frequency, of machines too large to decompose whole.
//!
//! Torsional trains are forests of two-ended springs: they are eliminated in series and parallel, without subtraction, and
//! Lanczos works on `K⁻¹M` with the rigid-body modes taken out. Everything else goes through a sparse LDLᵀ. A Sturm count
//! says that no mode is missing.

use super::basis::rigid_modes;
use super::mode::Mode;
use super::undamped;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::machine::linear::Linear;
use crate::numeric::forest::{Forest, Spring};
use crate::numeric::inverse::{Inverse, Measured, Shifted};
use crate::numeric::lanczos::{Ritz, Search, nearest};
use crate::numeric::sparse::{Factor, SparseSym};

/// Which modes are wanted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wanted {
    /// How many, rigid-body modes among them where they are the lowest.
    pub count: usize,
    /// rad/s; `None`: the lowest.
    pub near: Option<f64>,
}

/// How the systems were solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Route {
    /// Elimination of a forest in series and parallel.
    Forest,
    /// Sparse LDLᵀ of the assembled matrices.
    Sparse,
}

/// The modes found.
#[derive(Debug, Clone)]
pub struct Lowest {
    /// By rising frequency.
    pub modes: Vec<Mode>,
    /// How the systems were solved.
    pub route: Route,
    /// Systems solved.
    pub solves: usize,
    /// A Sturm count says that no mode among them is missing.
    pub counted: bool,
}

/// Relative accuracy of a forest's frequencies: worst of the closed forms of 10 to 100 000 discs in tests is below 1e-12.
const FOREST_DIGITS: f64 = 12.0;

/// A shift this far below the lowest mode wanted of a held or free assembled machine, relative to its stiffest spring.
const BELOW_ZERO: f64 = 1e-10;

/// Whether a machine is a forest of two-ended springs on a diagonal mass.
pub fn forest(linear: &Linear) -> Option<Forest> {
    let mass = linear.mass_diagonal()?;
    let springs = linear
        .branches
        .iter()
        .filter(|b| b.stiffness != 0.0)
        .map(|b| {
            let k = b.stiffness * b.direction.scale * b.direction.scale;
            if b.force.is_some() || k <= 0.0 {
                return None;
            }
            match b.direction.terms[..] {
                [(i, a)] => Some(Spring {
                    i,
                    a,
                    other: None,
                    k,
                }),
                [(i, a), (j, c)] => Some(Spring {
                    i,
                    a,
                    other: Some((j, c)),
                    k,
                }),
                _ => None,
            }
        })
        .collect::<Option<Vec<Spring>>>()?;
    Forest::new(linear.n, &springs, &mass)
}

/// Finds the modes wanted.
///
/// # Errors
/// A machine whose strain energy is not a sum of squares; no convergence.
pub fn find(linear: &Linear, forest: Option<&Forest>, wanted: Wanted) -> Result<Lowest, Error> {
    if !linear.is_sum_of_squares() {
        let message = "single modes of a machine with negative or unsymmetric stiffness are not looked for one by one";
        return Err(Error::new(Code::Hopeless, message)
            .hint("leave out --lowest and --near: all modes are solved together"));
    }
    let rigid = rigid_modes(linear);
    let elastic = match wanted.near {
        None => wanted.count.saturating_sub(rigid.len()),
        Some(_) => wanted.count,
    };
    let (ritz, route) = match wanted.near {
        None => around(linear, forest, &rigid, 0.0, elastic)?,
        Some(omega) => {
            // From above the spectrum all modes look alike; from its upper end the highest are as near.
            let omega = omega.min(ceiling(linear));
            near(linear, forest, &rigid, omega, elastic).map_err(|error| {
                let far = "from too far away many modes look alike: name a frequency nearer to those meant";
                match error.code {
                    Code::NoConvergence => error.hint(far),
                    _ => error,
                }
            })?
        }
    };
    let largest = stiffest(linear);
    let digits = |lambda: f64| match route {
        Route::Forest => FOREST_DIGITS,
        Route::Sparse => (-(f64::EPSILON * largest / lambda).log10()).clamp(0.0, FOREST_DIGITS),
    };
    let mut modes = Vec::new();
    if wanted.near.is_none() {
        modes.extend(
            rigid
                .iter()
                .take(wanted.count)
                .map(|p| undamped::mode(linear, p, 0.0, true, f64::INFINITY)),
        );
    }
    for (value, vector) in ritz.values.iter().zip(&ritz.vectors) {
        modes.push(undamped::mode(
            linear,
            vector,
            value.max(0.0).sqrt(),
            false,
            digits(*value),
        ));
    }
    Ok(Lowest {
        modes,
        route,
        solves: ritz.steps,
        counted: ritz.counted,
    })
}

/// Modes whose λ is nearest σ.
fn around(
    linear: &Linear,
    forest: Option<&Forest>,
    rigid: &[Vec<f64>],
    sigma: f64,
    count: usize,
) -> Result<(Ritz, Route), Error> {
    Ok(match forest {
        Some(forest) => (
            on_forest(linear, forest, rigid, sigma, count)?,
            Route::Forest,
        ),
        None => (on_sparse(linear, rigid, sigma, count)?, Route::Sparse),
    })
}

/// How many more modes are looked at than wanted: what is nearest in λ is not always nearest in ω.
const BESIDE: usize = 2;

/// Modes whose ω is nearest.
///
/// Those within D of ω have λ within D (2ω + D) of ω²: more are looked for until that far all are known.
fn near(
    linear: &Linear,
    forest: Option<&Forest>,
    rigid: &[Vec<f64>],
    omega: f64,
    count: usize,
) -> Result<(Ritz, Route), Error> {
    let most = linear.n.saturating_sub(rigid.len() + linear.massless.len());
    let count = count.min(most);
    let mut ask = (count + BESIDE).min(most);
    loop {
        let (mut ritz, route) = around(linear, forest, rigid, omega * omega, ask)?;
        let apart = |value: &f64| (value.max(0.0).sqrt() - omega).abs();
        let mut order: Vec<usize> = (0..ritz.values.len()).collect();
        order.sort_by(|&a, &b| apart(&ritz.values[a]).total_cmp(&apart(&ritz.values[b])));
        let reach = ritz
            .values
            .iter()
            .map(|value| (value - omega * omega).abs())
            .fold(0.0, f64::max);
        let farthest = order
            .get(count.saturating_sub(1))
            .map_or(0.0, |&at| apart(&ritz.values[at]));
        if ask < most && reach < farthest * (2.0 * omega + farthest) {
            ask = (2 * ask).min(most);
            continue;
        }
        order.truncate(count);
        order.sort_unstable();
        ritz.values = order.iter().map(|&at| ritz.values[at]).collect();
        ritz.residuals = order.iter().map(|&at| ritz.residuals[at]).collect();
        ritz.vectors = order
            .iter()
            .map(|&at| std::mem::take(&mut ritz.vectors[at]))
            .collect();
        return Ok((ritz, route));
    }
}

fn on_forest(
    linear: &Linear,
    forest: &Forest,
    rigid: &[Vec<f64>],
    sigma: f64,
    count: usize,
) -> Result<Ritz, Error> {
    let mass = linear.mass_diagonal().unwrap_or_default();
    let matrix = SparseSym::diagonal(&mass);
    let below = |sigma: f64| Ok(forest.count_below(&mass, sigma));
    let inverse = if sigma == 0.0 {
        Shifted::at_zero(forest)
    } else {
        Shifted::near(forest, &mass, sigma)
    };
    nearest(&Search {
        inverse: &inverse,
        mass: &matrix,
        rigid,
        count: Some(&below),
        wanted: count,
    })
}

fn on_sparse(linear: &Linear, rigid: &[Vec<f64>], sigma: f64, count: usize) -> Result<Ritz, Error> {
    let (k, m) = assembled(linear);
    let energy = |p: &[f64]| {
        linear
            .branches
            .iter()
            .map(|b| b.stiffness * b.direction.dot(p).powi(2))
            .sum::<f64>()
    };
    // A free machine has no K⁻¹; a shift a hair below zero has, and rigid motions are taken out anyway.
    let sigma = if sigma == 0.0 && !rigid.is_empty() {
        -BELOW_ZERO * stiffest(linear)
    } else {
        sigma
    };
    let factor = Factor::shifted(&k, &m, sigma)?;
    let below = |sigma: f64| Factor::shifted(&k, &m, sigma).map(|factor| factor.negative());
    let measured = Measured {
        factor: &factor,
        energy: &energy,
    };
    let inverse: &dyn Inverse = &measured;
    nearest(&Search {
        inverse,
        mass: &m,
        rigid,
        count: Some(&below),
        wanted: count,
    })
}

/// K and M as sparse matrices.
fn assembled(linear: &Linear) -> (SparseSym, SparseSym) {
    let mut k = Vec::new();
    for branch in &linear.branches {
        outer(&mut k, branch.stiffness, &branch.direction);
    }
    let mut m = Vec::new();
    for mass in &linear.masses {
        outer(&mut m, mass.value, &mass.direction);
    }
    (
        SparseSym::from_entries(linear.n, &k),
        SparseSym::from_entries(linear.n, &m),
    )
}

fn outer(
    entries: &mut Vec<(usize, usize, f64)>,
    value: f64,
    direction: &crate::machine::direction::Direction,
) {
    let terms: Vec<(usize, f64)> = direction.scaled().collect();
    for (at, &(i, a)) in terms.iter().enumerate() {
        entries.extend(terms[..=at].iter().map(|&(j, b)| (i, j, value * a * b)));
    }
}

/// Above every frequency, rad/s: `(wᵀp)² ≤ m Σ a² p²` for a branch of m terms.
fn ceiling(linear: &Linear) -> f64 {
    let terms = linear.branches.iter().map(|b| b.direction.terms.len());
    let most = terms.max().unwrap_or(0) as f64;
    // A hair more, so that a bound that is met is no eigenvalue.
    (most * stiffest(linear)).sqrt() * (1.0 + 1e-6)
}

/// The largest `Σ k a² / m` of a coordinate.
fn stiffest(linear: &Linear) -> f64 {
    let (mut k, mut m) = (vec![0.0; linear.n], vec![0.0; linear.n]);
    for branch in &linear.branches {
        branch
            .direction
            .scaled()
            .for_each(|(i, a)| k[i] += branch.stiffness.abs() * a * a);
    }
    for mass in &linear.masses {
        mass.direction
            .scaled()
            .for_each(|(i, a)| m[i] += mass.value * a * a);
    }
    k.iter()
        .zip(&m)
        .filter(|(_, m)| **m > 0.0)
        .map(|(k, m)| k / m)
        .fold(0.0, f64::max)
}
