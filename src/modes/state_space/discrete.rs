//! Discrete-time state space by the rules of `numeric::discretization`.

use super::system::StateSpace;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::discretisation;
use crate::scene::study::InputHold;

impl StateSpace {
    /// The same, sampled every `sample_time` seconds.
    ///
    /// # Errors
    /// `OutOfRange` for a sample time that is not positive; `Conflict` where it is sampled already; `Overflow` where the
    /// exponential keeps no digit; `Indefinite` where 2/h is a pole and the rule bilinear.
    pub fn discretise(&self, sample_time: f64, method: InputHold) -> Result<StateSpace, Error> {
        if let Some(already) = self.sample_time {
            let message = format!("it is already sampled every {already} s");
            return Err(Error::new(Code::Conflict, message).with_hint("sample the continuous form"));
        }
        if !(sample_time > 0.0 && sample_time.is_finite()) {
            let message = format!("a sample time of {sample_time} s is not positive");
            return Err(Error::new(Code::OutOfRange, message)
                .with_hint("start with a tenth of the shortest period of interest"));
        }
        let of = [&self.a, &self.b, &self.c, &self.d];
        let [a, b, c, d] = match method {
            InputHold::Zero => discretisation::zero_order(of, sample_time)?,
            InputHold::First => discretisation::first_order(of, sample_time)?,
            InputHold::Bilinear => discretisation::bilinear(of, sample_time)?,
        };
        Ok(StateSpace {
            a,
            b,
            c,
            d,
            sample_time: Some(sample_time),
            method: Some(method),
            ..self.clone()
        })
    }
}
