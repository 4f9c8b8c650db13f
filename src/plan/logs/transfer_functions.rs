//! Transfer functions from poles and residues; exponential window removed by `H(s) = H_w(s − σ)`.

use crate::base::error::Error;
use crate::identify::modal_parameters::ModalParameters;
use crate::identify::transfer::function::{DirectTerms, TransferFunction};
use crate::numeric::Complex;
use crate::recording::frequency_responses::FrequencyResponses;

/// `s^q (Σ R/(s − p) + R*/(s − p*) + L/s² + U)` for each response.
pub struct PartialFractions<'a> {
    /// Poles, rad/s.
    pub poles: &'a [Complex],
    /// Residues by response and pole.
    pub residues: &'a [Vec<Complex>],
    /// L and U by response.
    pub residual_terms: &'a [[f64; 2]],
    /// The power q.
    pub derivative: u8,
    /// Delays, s: none, one, or one for each response.
    pub delay_s: &'a [f64],
    /// Misfit by response.
    pub fit_error: &'a [f64],
}

/// A mode without the exponential window that lay on its record: the pole moves right by its rate.
pub fn without_window(mode: &ModalParameters, decay: f64) -> ModalParameters {
    ModalParameters {
        pole: mode.pole + decay,
        ..mode.clone()
    }
}

/// One transfer function for each response.
///
/// # Errors
/// Those of [`TransferFunction::new`].
pub fn transfer_functions(
    responses: &FrequencyResponses,
    partials: &PartialFractions,
) -> Result<Vec<TransferFunction>, Error> {
    let decay = responses.window_decay;
    let mut all = Vec::new();
    for (i, f) in responses.responses.iter().enumerate() {
        let mut direct = DirectTerms::default();
        let [lower, upper] = partials.residual_terms[i];
        match partials.derivative {
            0 => (direct.inverse_square, direct.constant) = (lower, upper),
            1 => (direct.inverse, direct.slope) = (lower, upper),
            _ => (direct.constant, direct.square) = (lower, upper),
        }
        let mut residues = Vec::new();
        for (&p, &r) in partials.poles.iter().zip(&partials.residues[i]) {
            let both = |z: Complex| if p.im == 0.0 { z.re } else { 2.0 * z.re };
            match partials.derivative {
                0 => residues.push(r),
                1 => {
                    residues.push(p * r);
                    direct.constant += both(r);
                }
                _ => {
                    residues.push(p * p * r);
                    direct.slope += both(r);
                    direct.constant += both(p * r);
                }
            }
        }
        let poles = partials.poles.iter().map(|p| p + decay).collect();
        let delays = partials.delay_s;
        let delay = delays
            .get(i.min(delays.len().saturating_sub(1)))
            .copied()
            .unwrap_or(0.0);
        let mut function = TransferFunction::new(poles, residues, direct)?
            .with_labels(f.input.clone(), f.output.clone());
        if delay > 0.0 {
            function = function.with_delay(delay)?;
        }
        function.fit_error = partials.fit_error.get(i).copied();
        all.push(function);
    }
    Ok(all)
}
