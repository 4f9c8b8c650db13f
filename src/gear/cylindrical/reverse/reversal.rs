//! The reversal: every standard gear fitted to the readings, those kept that agree, ranked by misfit.

use super::candidate::{CENTRE_DISTANCE, Candidate, Deviation};
use super::confusion::Ambiguity;
use super::readings::GearReadings;
use super::standard_sizes::{PRESSURE_ANGLES, ToothSize};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::sorting::sort_ascending;

/// Candidates, best first, and pairs of them that the readings leave open.
#[derive(Debug, Clone, PartialEq)]
pub struct Reversal {
    /// Candidates by rising misfit.
    pub candidates: Vec<Candidate>,
    /// Pairs of the candidates that the readings do not separate from the best.
    pub ambiguities: Vec<Ambiguity>,
}

/// Largest deviation of a span in its standard uncertainties at which a candidate is kept. Tip and root diameters only rank: tips are
/// altered, and tools are not always of the usual depth.
const WIDEST: f64 = 5.0;

impl GearReadings {
    /// The standard gears that agree with the readings, and what the readings leave open.
    ///
    /// # Errors
    /// `OutOfRange`: a reading no gear has. `IllPosed`: spans over one number of teeth only, or a helix angle without the tip diameter.
    /// `NoConvergence`: no standard gear agrees; the nearest is named.
    pub fn reverse(&self) -> Result<Reversal, Error> {
        self.check()?;
        // The nearest is that of the spans: a centre distance that fits none says nothing of the gear.
        let mut nearest: Option<(f64, Deviation, Candidate)> = None;
        let mut candidates = Vec::new();
        let angles = |size| {
            PRESSURE_ANGLES
                .iter()
                .map(move |angle: &f64| (size, angle.to_radians()))
        };
        for (size, angle) in ToothSize::all().flat_map(angles) {
            let Some((widest, candidate)) = self.fit(size, angle) else {
                continue;
            };
            let [of_spans, of_all] = widest;
            let is_kept = of_all.value.abs() <= WIDEST;
            if is_kept {
                candidates.push(candidate);
            } else if (nearest.as_ref()).is_none_or(|(least, ..)| of_spans.value.abs() < *least) {
                nearest = Some((of_spans.value.abs(), of_all, candidate));
            }
        }
        if candidates.is_empty() {
            let nearest = nearest.map(|(_, deviation, candidate)| (deviation, candidate));
            return Err(self.no_candidate(nearest));
        }
        sort_ascending(&mut candidates, |a| a.misfit);
        let confusions = self.ambiguities(&candidates);
        Ok(Reversal {
            candidates,
            ambiguities: confusions,
        })
    }

    fn no_candidate(&self, nearest: Option<(Deviation, Candidate)>) -> Error {
        let Some((widest, candidate)) = nearest else {
            let message = "no standard gear has these readings";
            return Error::new(Code::NoConvergence, message)
                .with_hint("check the helix angle and the tip diameter");
        };
        let size = match candidate.size {
            ToothSize::Module(m) => format!("m {m} mm"),
            ToothSize::DiametralPitch(p) => format!("P {p} 1/in"),
        };
        let message = format!(
            "no standard gear agrees with the readings; the nearest, {size} / {:.1} deg, misses {} by {:.1} standard uncertainties",
            candidate.gear.pressure_angle.to_degrees(),
            widest.reading,
            widest.value.abs()
        );
        Error::new(Code::NoConvergence, message).with_hint(match widest.reading.as_str() {
            CENTRE_DISTANCE => {
                "check the centre distance, the teeth of the mate and the uncertainties"
            }
            _ => "check the teeth spanned and the uncertainties, or measure spans farther apart",
        })
    }
}
