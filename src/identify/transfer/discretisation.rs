//! Discretisation of a state-space model: zero-order hold, bilinear, prewarped, impulse invariant.

use std::f64::consts::{PI, TAU};

use super::realisation::{DiscretisationMethod, Realisation, Sampling};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::discretisation;

impl DiscretisationMethod {
    /// The word it goes by.
    pub fn name(self) -> &'static str {
        match self {
            DiscretisationMethod::ZeroOrderHold => "zero-order hold",
            DiscretisationMethod::Bilinear => "bilinear",
            DiscretisationMethod::Prewarped(_) => "bilinear, prewarped",
            DiscretisationMethod::ImpulseInvariant => "impulse-invariant",
        }
    }
}

impl Realisation {
    /// The same at a sample time, s. A dead time stays next to the matrices as it is.
    ///
    /// # Errors
    /// `OutOfRange` for a sample time that is not positive, and a prewarping frequency outside 0 to half the sample rate;
    /// `Conflict` where it is sampled already or a direct term meets the impulse-invariant rule; `Overflow` and `Indefinite`
    /// of the rules.
    pub fn discretise(&self, time_s: f64, map: DiscretisationMethod) -> Result<Realisation, Error> {
        if let Some(already) = self.sampling {
            let message = format!("the model is sampled every {} s already", already.time_s);
            return Err(Error::new(Code::Conflict, message).with_hint("sample the continuous form"));
        }
        if !(time_s > 0.0 && time_s.is_finite()) {
            let message = format!("a sample time of {time_s} s is not positive");
            return Err(Error::new(Code::OutOfRange, message)
                .with_hint("start with a tenth of the shortest period of interest"));
        }
        let of = [&self.a, &self.b, &self.c, &self.d];
        let [a, b, c, d] = match map {
            DiscretisationMethod::ZeroOrderHold => discretisation::zero_order(of, time_s)?,
            DiscretisationMethod::Bilinear => discretisation::bilinear(of, time_s)?,
            DiscretisationMethod::Prewarped(frequency_hz) => {
                let half = PI * frequency_hz * time_s;
                if !(half > 0.0 && half < 0.5 * PI) {
                    let message = format!(
                        "{frequency_hz} Hz is not between 0 and half the sample rate, {} Hz",
                        0.5 / time_s
                    );
                    return Err(Error::new(Code::OutOfRange, message)
                        .with_hint("prewarp at the most important resonance"));
                }
                discretisation::bilinear(of, 2.0 * half.tan() / (TAU * frequency_hz))?
            }
            DiscretisationMethod::ImpulseInvariant => {
                if self.d.norm_max() > 0.0 {
                    let message = "the impulse response of a direct term is no function of time, and has no samples";
                    return Err(Error::new(Code::Conflict, message).with_hint(
                        "use zero-order hold or bilinear, or fit without a direct term",
                    ));
                }
                discretisation::impulse_invariant([&self.a, &self.b, &self.c], time_s)?
            }
        };
        let sampling = Some(Sampling { time_s, map });
        Ok(Realisation {
            a,
            b,
            c,
            d,
            sampling,
            ..self.clone()
        })
    }
}
