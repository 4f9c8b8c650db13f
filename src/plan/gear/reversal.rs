//! Reversal of the readings of an unknown gear: candidates, what the readings leave open, stages.

use crate::base::error::{Diagnostic, Error};
use crate::base::text::pluralise;
use crate::gear::cylindrical::reverse::readings::GearReadings;
use crate::gear::cylindrical::reverse::reversal::Reversal;
use crate::plan::decision::StageDecision;
use crate::scene::gear_readings::GearReadingsFile;

/// Candidates for a gear with the stages that found them.
#[derive(Debug, Clone)]
pub struct ReversalResult {
    /// Candidates and what is left open between them.
    pub reversal: Reversal,
    /// Stages that ran and that were left out.
    pub plan: Vec<(&'static str, StageDecision)>,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// Fits every standard gear to the readings.
///
/// # Errors
/// As `GearReadings::reverse`, at the place of the readings.
pub fn run(file: &GearReadingsFile) -> Result<ReversalResult, Error> {
    let reversal = file.readings.reverse();
    let reversal = reversal.map_err(|error| error.with_span(&file.span))?;
    let open = reversal.ambiguities.len();
    let not_separated = (open > 0).then(|| Diagnostic {
        code: "not-separated",
        message: format!(
            "the readings do not distinguish the first candidate from {}",
            pluralise(open, "other")
        ),
        hint: (reversal.ambiguities.iter())
            .any(|confusion| !confusion.remedies.is_empty())
            .then(|| "take the reading named in the result".into()),
    });
    Ok(ReversalResult {
        plan: plan(&file.readings),
        diagnostics: poor_fit(&reversal)
            .into_iter()
            .chain(not_separated)
            .collect(),
        reversal,
    })
}

/// A first candidate that misses a reading by more than this is doubtful, standard uncertainties.
const GOOD_FIT: f64 = 3.0;

/// The warning that even the first candidate misses a reading.
fn poor_fit(reversal: &Reversal) -> Option<Diagnostic> {
    let worst = &reversal.candidates.first()?.largest_deviation;
    let largest = worst.value.abs();
    (largest > GOOD_FIT).then(|| Diagnostic {
        code: "readings-misfit",
        message: format!(
            "the first candidate misses {} by {largest:.1} standard uncertainties (limit {GOOD_FIT})",
            worst.reading
        ),
        hint: Some(
            "repeat the readings and check their uncertainties; the gear may not be of a standard size"
                .into(),
        ),
    })
}

fn plan(readings: &GearReadings) -> Vec<(&'static str, StageDecision)> {
    use StageDecision::{LeftOut, Runs};
    let has_diameter = readings.tip_diameter.is_some() || readings.root_diameter.is_some();
    let mate = readings.mate.as_ref();
    vec![
        (
            "flanks",
            Runs(format!(
                "standard modules and diametral pitches, pressure angles from 14.5 to 30 deg; {}",
                match readings.thickness_deviation {
                    None =>
                        "thickness_deviation unknown, between 0 and −0.1 mm − 0.05 m_n (−0.15 m_n below 1 mm)"
                            .into(),
                    Some(deviation) =>
                        format!("tooth thickness deviation of {:.1} µm", 1e6 * deviation),
                }
            )),
        ),
        (
            "tooth heights",
            match has_diameter {
                true => Runs("coefficients nearest to the tip and root diameters".into()),
                false => LeftOut("neither tip_diameter nor root_diameter is given".into()),
            },
        ),
        (
            "mate",
            match mate {
                Some(mate) if !mate.spans.is_empty() => Runs("shift from its spans".into()),
                Some(mate) if mate.centre_distance.is_some() => {
                    Runs("shift from the centre distance without backlash".into())
                }
                Some(_) => LeftOut("it has neither spans nor centre_distance".into()),
                None => LeftOut("no mate is given".into()),
            },
        ),
        (
            "backlash",
            match mate {
                Some(mate) if !mate.spans.is_empty() && mate.centre_distance.is_some() => {
                    Runs("normal backlash at the centre distance".into())
                }
                _ => LeftOut("it needs spans of both gears and the centre distance".into()),
            },
        ),
    ]
}
