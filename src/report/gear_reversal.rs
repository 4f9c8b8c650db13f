//! Candidates for a gear of unknown origin: table, document, the readings that would separate them.

use serde_json::{Value, json};

use super::gear::title_lines;
use super::plan::{step_lines, steps};
use super::presentation::{Presentation, Provenance};
use super::table::{Table, decimal, or_dash};
use crate::base::error::Error;
use crate::gear::cylindrical::reverse::candidate::Candidate;
use crate::gear::cylindrical::reverse::confusion::{Ambiguity, Remedy};
use crate::gear::cylindrical::reverse::standard_sizes::ToothSize;
use crate::plan::gear::reversal::ReversalResult;
use crate::scene::gear_readings::GearReadingsFile;

/// Candidates that a terminal shows.
const SHOWN: usize = 12;

/// Readings with the gears that they may come from.
pub struct ReversalReport<'a> {
    /// The readings.
    pub file: &'a GearReadingsFile,
    /// The candidates.
    pub result: ReversalResult,
}

impl Presentation for ReversalReport<'_> {
    fn provenance(&self) -> Provenance<'_> {
        Provenance::of_plan(
            std::slice::from_ref(&self.file.source),
            &self.result.plan,
            &self.result.diagnostics,
        )
    }

    fn body(&self) -> Result<Value, Error> {
        let reversal = &self.result.reversal;
        let candidates: Vec<Value> = reversal.candidates.iter().map(candidate_json).collect();
        let open = reversal.ambiguities.iter();
        Ok(json!({
            "title": self.file.title,
            "kind": "cylindrical",
            "reverse": {
                "candidates": candidates,
                "not_separated": open.map(confusion_json).collect::<Vec<_>>(),
            },
        }))
    }

    fn text(&self) -> String {
        let reversal = &self.result.reversal;
        let mut text = title_lines(&self.file.title);
        let shown = reversal.candidates.len().min(SHOWN);
        text += &candidate_table(&reversal.candidates[..shown]).text();
        if shown < reversal.candidates.len() {
            let more = reversal.candidates.len() - shown;
            text += &format!("… {more} more with larger misfits (--csv, --json)\n");
        }
        if !reversal.ambiguities.is_empty() {
            let mut table = Table::texts("not separated from the first|base pitch|separated by");
            for confusion in &reversal.ambiguities {
                let other = &reversal.candidates[confusion.candidates[1]];
                table.row([
                    format!("{}, {:.1}°", size_text(other.size), pressure_angle(other)),
                    format!("{:.2} µm apart", 1e6 * confusion.base_pitch_difference),
                    remedies_text(confusion),
                ]);
            }
            text += &format!("\n{}", table.text());
        }
        text
    }

    fn table(&self) -> Table<'_> {
        candidate_table(&self.result.reversal.candidates)
    }

    fn notes(&self) -> String {
        step_lines(steps(&self.result.plan))
    }
}

fn pressure_angle(candidate: &Candidate) -> f64 {
    candidate.gear.pressure_angle.to_degrees()
}

fn size_text(size: ToothSize) -> String {
    match size {
        ToothSize::Module(m) => format!("m {m} mm"),
        ToothSize::DiametralPitch(p) => format!("P {p} 1/in"),
    }
}

fn candidate_table(candidates: &[Candidate]) -> Table<'static> {
    let mut table = Table::named(
        "size|m_n [mm]|α_n [deg]|β [deg]|x_E|± x_E|E_sn [µm]|x|h_aP|usual|h_fP|usual|x_E mate|j_bn [µm]|misfit",
    );
    for candidate in candidates {
        let four = |x: f64| format!("{x:.4}");
        let [addendum, usual_addendum] = height_texts(candidate.addendum);
        let [dedendum, usual_dedendum] = height_texts(candidate.dedendum);
        table.row([
            size_text(candidate.size),
            four(1e3 * candidate.gear.module),
            format!("{:.1}", pressure_angle(candidate)),
            format!("{:.3}", candidate.gear.helix.to_degrees()),
            four(candidate.generating_shift.value),
            four(candidate.generating_shift.std),
            or_dash(candidate.thickness_deviation, |e| format!("{:.0}", 1e6 * e)),
            or_dash(candidate.profile_shift(), four),
            addendum,
            usual_addendum,
            dedendum,
            usual_dedendum,
            or_dash(candidate.mate_shift, four),
            or_dash(candidate.backlash, |j| format!("{:.1}", 1e6 * j)),
            format!("{:.2}", candidate.misfit),
        ]);
    }
    table
}

/// A coefficient of tooth height and the usual one nearest to it.
fn height_texts(height: Option<[f64; 2]>) -> [String; 2] {
    match height {
        Some([read, usual]) => [format!("{read:.3}"), decimal(usual)],
        None => ["–", "–"].map(String::from),
    }
}

/// Distance of two candidates in a diameter, from the least to the most that their usual heights and allowances leave.
fn apart_text([least, most]: [f64; 2]) -> String {
    match least > 0.0 {
        true => format!("{:.3} mm apart", 1e3 * least),
        false => format!("up to {:.3} mm apart, by height and allowance", 1e3 * most),
    }
}

fn remedies_text(confusion: &Ambiguity) -> String {
    let text = |remedy: &Remedy| match remedy {
        Remedy::TipDiameter(apart) => format!("tip diameter ({})", apart_text(*apart)),
        Remedy::RootDiameter(apart) => format!("root diameter ({})", apart_text(*apart)),
        Remedy::Spans {
            teeth: [fewest, most],
            difference,
            std,
        } => format!(
            "spans over {fewest} and {most} teeth ({:.1} µm apart; standard uncertainty up to {:.1} µm)",
            1e6 * difference,
            1e6 * std
        ),
    };
    let texts: Vec<String> = confusion.remedies.iter().map(text).collect();
    match texts.is_empty() {
        true => "no common reading".into(),
        false => texts.join(", or "),
    }
}

fn candidate_json(candidate: &Candidate) -> Value {
    let height = |height: Option<[f64; 2]>| {
        height.map(|[read, usual]| json!({ "value": read, "usual": usual }))
    };
    let pitch = match candidate.size {
        ToothSize::DiametralPitch(pitch) => Some(pitch),
        ToothSize::Module(_) => None,
    };
    json!({
        "size": size_text(candidate.size),
        "module_mm": 1e3 * candidate.gear.module,
        "diametral_pitch_per_in": pitch,
        "pressure_angle_deg": pressure_angle(candidate),
        "helix_angle_deg": candidate.gear.helix.to_degrees(),
        "generating_profile_shift": candidate.generating_shift.value,
        "generating_profile_shift_std": candidate.generating_shift.std,
        "thickness_deviation_um": candidate.thickness_deviation.map(|e| 1e6 * e),
        "profile_shift": candidate.profile_shift(),
        "addendum": height(candidate.addendum),
        "dedendum": height(candidate.dedendum),
        "clearance": candidate.clearance(),
        "mate_generating_profile_shift": candidate.mate_shift,
        "normal_backlash_um": candidate.backlash.map(|j| 1e6 * j),
        "misfit": candidate.misfit,
        "largest_deviation": candidate.largest_deviation.value.abs(),
        "largest_deviation_of": candidate.largest_deviation.reading,
    })
}

fn confusion_json(confusion: &Ambiguity) -> Value {
    let remedy = |remedy: &Remedy| match remedy {
        Remedy::TipDiameter([least, most]) => json!({
            "reading": "tip_diameter", "apart_um": 1e6 * least, "apart_at_most_um": 1e6 * most,
        }),
        Remedy::RootDiameter([least, most]) => json!({
            "reading": "root_diameter", "apart_um": 1e6 * least, "apart_at_most_um": 1e6 * most,
        }),
        Remedy::Spans {
            teeth,
            difference,
            std,
        } => json!({
            "reading": "spans",
            "teeth": teeth,
            "apart_um": 1e6 * difference,
            "standard_uncertainty_um": 1e6 * std,
        }),
    };
    json!({
        "candidates": confusion.candidates,
        "base_pitch_apart_um": 1e6 * confusion.base_pitch_difference,
        "separated_by": confusion.remedies.iter().map(remedy).collect::<Vec<_>>(),
    })
}
