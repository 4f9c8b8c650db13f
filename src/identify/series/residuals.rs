//! Residual tests: whiteness (Ljung–Box) and cross-correlation with the input.

use super::autoregressive::{autocovariance, burg_path};
use super::io_data::{check_order, remove_mean};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::statistics::chi_squared_sf;

/// A test of "there is nothing left".
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ResidualTest {
    /// χ²-distributed where nothing is left.
    pub statistic: f64,
    /// Degrees of freedom of the statistic.
    pub dof: usize,
    /// Probability that chance alone gives as much; below 0.05 (say) something is left.
    pub probability: f64,
}

/// Whether residuals are white: `Q = N(N+2) Σ r_k²/(N−k)` over lags 1 to `lags` (Ljung & Box, Biometrika 65 (1978)), with
/// `lags − fitted` degrees of freedom, `fitted` counting the coefficients of A and C.
///
/// # Errors
/// `OutOfRange` where `lags` does not exceed `fitted`; `TooShort` for fewer samples than lags; `NotANumber`.
pub fn ljung_box(residuals: &[f64], lags: usize, fitted: usize) -> Result<ResidualTest, Error> {
    check_finite(residuals)?;
    if lags <= fitted {
        return Err(Error::new(
            Code::OutOfRange,
            format!("{lags} lags are too few to test a model with {fitted} coefficients"),
        )
        .with_hint(format!("use more than {fitted} lags, usually 20 more")));
    }
    check_order(residuals.len(), lags, 0)?;
    let (e, _) = remove_mean(residuals);
    let r = autocovariance(&e, lags);
    let n = e.len() as f64;
    let sum: f64 = (1..=lags)
        .map(|k| (r[k] / r[0]).powi(2) / (n - k as f64))
        .sum();
    Ok(test(n * (n + 2.0) * sum, lags - fitted))
}

/// Whether residuals are unrelated to the input: `N Σ r_k²` over lags 0 to `lags` of the correlation between residuals and an input
/// that was whitened first (Haugh, J. Am. Stat. Assoc. 71 (1976)). Only a model that is right leaves nothing; residuals should be white.
///
/// # Errors
/// `OutOfRange` where the lengths differ; `TooShort`; `NotANumber`.
pub fn cross_correlation(
    residuals: &[f64],
    input: &[f64],
    lags: usize,
) -> Result<ResidualTest, Error> {
    check_finite(residuals)?;
    check_finite(input)?;
    if residuals.len() != input.len() {
        let (e, u) = (residuals.len(), input.len());
        return Err(Error::new(
            Code::OutOfRange,
            format!("{e} residuals and {u} samples of the input"),
        )
        .with_hint("give the input the model was fitted to"));
    }
    let n = input.len();
    check_order(n, lags + 1, WHITENING_ORDER)?;
    let (u, _) = remove_mean(input);
    let (a, _) = burg_path(&u, WHITENING_ORDER).pop().unwrap_or_default();
    let mut white = u.clone();
    for (k, a) in a.iter().enumerate() {
        (white.iter_mut().skip(k + 1).zip(&u)).for_each(|(w, u)| *w += a * u);
    }
    let (e, _) = remove_mean(residuals);
    let power = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>();
    let scale = 1.0 / (power(&e) * power(&white));
    let sum: f64 = (0..=lags)
        .map(|k| {
            let product: f64 = e.iter().skip(k).zip(&white).map(|(e, w)| e * w).sum();
            product * product * scale
        })
        .sum();
    Ok(test(n as f64 * sum, lags + 1))
}

/// Coefficients of the filter that whitens an input.
const WHITENING_ORDER: usize = 30;

fn test(statistic: f64, dofs: usize) -> ResidualTest {
    ResidualTest {
        statistic,
        dof: dofs,
        probability: chi_squared_sf(statistic, dofs as f64),
    }
}

fn check_finite(samples: &[f64]) -> Result<(), Error> {
    match samples.iter().position(|x| !x.is_finite()) {
        None => Ok(()),
        Some(at) => Err(
            Error::new(Code::NotANumber, format!("sample {at} is {}", samples[at]))
                .with_hint("test segments without gaps"),
        ),
    }
}
