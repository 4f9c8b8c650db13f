//! Linearity by amplitude: whether the hits of a test place a resonance differently by their level.

use super::frf_estimation::EstimatedResponses;
use crate::base::error::Diagnostic;
use crate::identify::level_dependence::{
    LevelDependence, LevelGroup, LevelShift, level_dependence,
};
use crate::identify::modal_parameters::ModalParameters;
use crate::identify::pole_shift::partial_fraction;

/// The check for the hits of a test; `modes` as measured, an exponential window on them.
pub fn check_test(
    estimated_responses: &EstimatedResponses,
    frequency_hz: &[f64],
    modes: &[ModalParameters],
    unit: &str,
) -> Option<Diagnostic> {
    let level = |hits: &[usize]| {
        let peaks = hits
            .iter()
            .filter_map(|&at| estimated_responses.hits.get(at));
        peaks.map(|h| h.peak.abs()).sum::<f64>() / hits.len().max(1) as f64
    };
    let groups: Vec<LevelGroup> = (estimated_responses.hit_responses.iter())
        .map(|g| LevelGroup {
            level: level(&g.hits),
            responses: &g.value,
        })
        .collect();
    let found = level_dependence(frequency_hz, &groups, modes, &partial_fraction)?;
    Some(warning(&found, "from hits of", unit))
}

/// The warning that resonances shift with the level, by how much from the lowest to the highest.
pub fn warning(found: &LevelDependence, levels_of: &str, unit: &str) -> Diagnostic {
    let shift = |s: &LevelShift| {
        let verb = if s.change < 0.0 { "falls" } else { "rises" };
        let [change, bound] = [s.change.abs(), s.bound].map(|x| 100.0 * x);
        format!(
            "{:.4} Hz {verb} by {change:.3} ± {bound:.3} %",
            s.frequency_hz
        )
    };
    let [low, high] = found.levels;
    let all: Vec<String> = found.shifts.iter().map(shift).collect();
    Diagnostic {
        code: "nonlinear",
        message: format!(
            "{levels_of} {low:.4} to {high:.4} {unit}: {}",
            all.join(", ")
        ),
        hint: Some("the structure is not linear at these levels: excite it at one level, or state the amplitude with the modes".into()),
    }
}
