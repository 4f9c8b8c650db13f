//! Correction of machine settings: dials of the next cut, deviations before and after, singular values, what no settings take away.

use std::f64::consts::PI;

use serde_json::{Value, json};

use super::correction_plot;
use super::figure::Figure;
use super::gear::{ARCSEC, title_lines};
use super::number_format::percent;
use super::plan::{step_lines, steps};
use super::presentation::{Presentation, Provenance};
use super::table::{Table, decimal, or_dash};
use crate::base::error::Error;
use crate::gear::bevel::tooth::SIDES;
use crate::gear::cut::dial::{Dial, DialSteps};
use crate::gear::cut::measured_flank::Deviations;
use crate::gear::cut::setting::{Setting, SettingKind};
use crate::numeric::sorting::sort_descending;
use crate::plan::gear::bevel_contact::BevelContact;
use crate::plan::gear::correction::{ContactChange, CorrectionResult};
use crate::plan::gear_limits::MEMBERS;
use crate::scene::correction_study::setting_name;

/// A correction with the steps of the dials.
pub struct CorrectionReport {
    /// Title of the gear file.
    pub title: String,
    /// Steps of the dials.
    pub steps: DialSteps,
    /// The result.
    pub result: CorrectionResult,
}

/// Least share of a direction at which a setting is named.
const NAMED_SHARE: f64 = 0.3;

impl Presentation for CorrectionReport {
    fn provenance(&self) -> Provenance<'_> {
        let result = &self.result;
        Provenance::of_plan(&result.sources, &result.plan, &result.diagnostics)
    }

    fn body(&self) -> Result<Value, Error> {
        let result = &self.result;
        let flank = |(f, side): (usize, &usize)| {
            let (before, after) = self.deviations(f);
            json!({
                "side": SIDES[*side],
                "nodes": before.nodes,
                "rms_before_um": 1e6 * before.rms,
                "largest_before_um": 1e6 * before.largest,
                "rms_after_um": 1e6 * after.rms,
                "largest_after_um": 1e6 * after.largest,
                "deeper_um": result.depths[f].map(|depths| depths.map(|x| 1e6 * x)),
            })
        };
        let direction = |k: usize| {
            let direction = result.fit.nominal.direction(k);
            let shares = result.problem.unknowns.iter().zip(direction).map(|(unknown, share)| {
                json!({ "setting": setting_key(unknown.setting), "share": share })
            });
            json!({ "used": k < result.fit.kept, "shares": shares.collect::<Vec<_>>() })
        };
        let values = result.fit.nominal.singular_values();
        let shape = |rest: &crate::gear::cut::shapes::ResidualShape| json!({ "shape": rest.shape.name, "formula": rest.shape.formula, "share_left": rest.share });
        Ok(json!({
            "title": self.title,
            "kind": "bevel",
            "correct": {
                "member": MEMBERS[result.member],
                "flanks": result.sides.iter().enumerate().map(flank).collect::<Vec<_>>(),
                "settings": self.rows().iter().map(DialRow::json).collect::<Vec<_>>(),
                "singular_values_um": values.iter().map(|x| 1e6 * x).collect::<Vec<_>>(),
                "directions": (0..values.len()).map(direction).collect::<Vec<_>>(),
        "contact": result.contact.as_ref().map(contact_json),
                "not_corrected": result.shapes.iter().map(shape).collect::<Vec<_>>(),
            },
        }))
    }

    fn text(&self) -> String {
        let mut text = title_lines(&self.title);
        text += &self.dial_table().text();
        text += &format!("\n{}", self.deviation_table().text());
        text += &format!("\n{}", self.depth_table().text());
        if let Some(contact) = &self.result.contact {
            text += &format!("\n{}", contact_table(contact).text());
        }
        text += &format!("\n{}", self.direction_table().text());
        text += &format!("\n{}", self.shape_table().text());
        text
    }

    /// Nodes with their deviations before and after.
    fn table(&self) -> Table<'_> {
        let given = if self.result.contact.is_some() {
            "wanted"
        } else {
            "measured"
        };
        let mut table = Table::named(&format!(
            "flank|z [mm]|radius [mm]|face|height|{given} [µm]|before [µm]|after [µm]"
        ));
        let micrometres = |x: Option<f64>| x.map_or(String::new(), |x| decimal(1e6 * x));
        for (f, side) in self.result.sides.iter().enumerate() {
            let flank = &self.result.problem.flanks[f];
            for (k, node) in flank.nodes.iter().enumerate() {
                let [z, radius] = flank.section.at(node.shares[0], node.shares[1]);
                table.row([
                    SIDES[*side].to_string(),
                    decimal(1e3 * z),
                    decimal(1e3 * radius),
                    decimal(node.shares[0]),
                    decimal(node.shares[1]),
                    decimal(1e6 * flank.deviations[k]),
                    micrometres(self.result.before[f][k]),
                    micrometres(self.result.next.deviations[f][k]),
                ]);
            }
        }
        table
    }

    fn notes(&self) -> String {
        step_lines(steps(&self.result.plan))
    }

    fn figures(&self) -> Result<Vec<Figure>, Error> {
        let content = correction_plot::draw(&self.title, &self.result);
        Ok(vec![Figure::first(content)])
    }
}

/// A dial with what it shows now and for the next cut, in units of people.
struct DialRow {
    key: &'static str,
    unit: &'static str,
    flank: String,
    now: f64,
    next: f64,
    step: f64,
    digits: usize,
}

impl DialRow {
    fn json(&self) -> Value {
        let unit = self.unit;
        json!({
            "setting": self.key,
            "flank": self.flank,
            "unit": unit,
            "now": self.now,
            "next": self.next,
            "change": self.next - self.now,
            "step": self.step,
        })
    }
}

impl CorrectionReport {
    fn deviations(&self, flank: usize) -> (Deviations, Deviations) {
        let result = &self.result;
        (
            Deviations::of(&result.before[flank]),
            Deviations::of(&result.next.deviations[flank]),
        )
    }

    /// Rows of all dials, those of a machine that two flanks share once.
    fn rows(&self) -> Vec<DialRow> {
        let result = &self.result;
        let mut rows = Vec::new();
        for (f, dials) in result.dials.iter().enumerate() {
            for dial in dials {
                let is_shared =
                    (result.is_one_setting || result.cuts_other_flank) && !dial.is_of_cutter();
                if is_shared && f > 0 {
                    continue;
                }
                let (scale, unit) = unit(*dial);
                let step = scale * dial.step(&self.steps);
                rows.push(DialRow {
                    key: dial_key(*dial),
                    unit,
                    flank: if is_shared {
                        "both"
                    } else {
                        SIDES[result.sides[f]]
                    }
                    .into(),
                    now: scale * dial.value(&result.problem.flanks[f].setup),
                    next: scale * dial.value(&result.next.setups[f]),
                    digits: digits(step),
                    step,
                });
            }
        }
        rows
    }

    fn dial_table(&self) -> Table<'static> {
        let mut table =
            Table::named("settings of the next cut|flank|now|next|change|step|unit").words(&[1, 6]);
        for row in self.rows() {
            let number = |x: f64| format!("{x:.*}", row.digits);
            table.row([
                row.key.to_string(),
                row.flank,
                number(row.now),
                number(row.next),
                format!("{:+.*}", row.digits, row.next - row.now),
                decimal((row.step * 1e9).round() / 1e9),
                row.unit.to_string(),
            ]);
        }
        table
    }

    fn deviation_table(&self) -> Table<'static> {
        let mut table =
            Table::named("deviation|nodes|rms now [µm]|largest [µm]|rms next [µm]|largest [µm]");
        for (f, side) in self.result.sides.iter().enumerate() {
            let (before, after) = self.deviations(f);
            let micrometres = |x: f64| format!("{:.3}", 1e6 * x);
            table.row([
                format!(
                    "{} flank of the {}",
                    SIDES[*side], MEMBERS[self.result.member]
                ),
                before.nodes.to_string(),
                micrometres(before.rms),
                micrometres(before.largest),
                micrometres(after.rms),
                micrometres(after.largest),
            ]);
        }
        table
    }

    fn depth_table(&self) -> Table<'static> {
        let mut table = Table::named("increase of slot depth|toe [mm]|middle [mm]|heel [mm]");
        for (side, depths) in self.result.sides.iter().zip(&self.result.depths) {
            let depth = |k: usize| or_dash(depths.map(|d| d[k]), |x| format!("{:+.3}", 1e3 * x));
            table.row([
                format!("by the blade of the {} flank", SIDES[*side]),
                depth(0),
                depth(1),
                depth(2),
            ]);
        }
        table
    }

    fn direction_table(&self) -> Table<'static> {
        let fit = &self.result.fit;
        let mut table =
            Table::texts("direction|effect on the flank, rms [µm]|used|settings with their shares");
        for (k, value) in fit.nominal.singular_values().iter().enumerate() {
            let direction = fit.nominal.direction(k);
            let mut named: Vec<(f64, Setting)> = direction
                .iter()
                .zip(&self.result.problem.unknowns)
                .map(|(share, unknown)| (*share, unknown.setting))
                .filter(|(share, _)| share.abs() >= NAMED_SHARE)
                .collect();
            sort_descending(&mut named, |a| a.0.abs());
            let names = named
                .iter()
                .map(|(share, setting)| format!("{share:+.2} {}", setting_key(*setting)));
            table.row([
                (k + 1).to_string(),
                format!("{:.4}", 1e6 * value),
                if k < fit.kept { "yes" } else { "no" }.to_string(),
                names.collect::<Vec<_>>().join(", "),
            ]);
        }
        table
    }

    fn shape_table(&self) -> Table<'static> {
        let mut table = Table::named("not corrected, residual share|shape|share [%]").words(&[1]);
        for rest in &self.result.shapes {
            table.row([
                rest.shape.name.to_string(),
                rest.shape.formula.to_string(),
                or_dash(rest.share, percent),
            ]);
        }
        table
    }
}

fn contact_json(change: &ContactChange) -> Value {
    let of = |contact: &BevelContact| {
        json!({
            "peak_to_peak_arcsec": contact.peak_to_peak.map(|te| ARCSEC * te),
            "face_height_pinion": contact.reference_position[0],
            "face_height_gear": contact.reference_position[1],
        })
    };
    json!({ "now": change.now.as_ref().map(of), "next": change.next.as_ref().map(of) })
}

fn contact_table(change: &ContactChange) -> Table<'static> {
    let mut table = Table::texts("unloaded contact|now|next|unit").words(&[]);
    let both = [&change.now, &change.next].map(Option::as_ref);
    let te = both.map(|c| {
        or_dash(c.and_then(|c| c.peak_to_peak), |te| {
            format!("{:.3}", ARCSEC * te)
        })
    });
    let [now, next] = te;
    table.row([
        "transmission error, peak to peak".to_string(),
        now,
        next,
        "arcsec".into(),
    ]);
    for (k, member) in MEMBERS.iter().enumerate() {
        let place = |c: Option<&BevelContact>| {
            or_dash(c.and_then(|c| c.reference_position[k]), |[face, height]| {
                format!("{:.1}, {:.1}", 100.0 * face, 100.0 * height)
            })
        };
        let [now, next] = both.map(place);
        table.row([
            format!("reference: face, height of the {member}"),
            now,
            next,
            "%".into(),
        ]);
    }
    table
}

/// The key of a setting in a document.
fn setting_key(setting: Setting) -> &'static str {
    match setting {
        Setting::TiltCosine => "tilt cos(swivel)",
        Setting::TiltSine => "tilt sin(swivel)",
        Setting::ProfileCurvature => "profile curvature",
        Setting::Ratio => "work_over_cradle",
        setting => setting_name(setting),
    }
}

fn dial_key(dial: Dial) -> &'static str {
    match dial {
        Dial::Setting(setting) => setting_name(setting),
        Dial::ProfileRadius => setting_name(Setting::ProfileCurvature),
        Dial::EccentricAngle { .. } => "eccentric_angle",
        Dial::Tilt => "tilt",
        Dial::Swivel => "swivel",
        Dial::CradleOverWork => "cradle_over_work",
    }
}

/// Factor from SI and name of a dial's unit.
fn unit(dial: Dial) -> (f64, &'static str) {
    match dial.kind() {
        SettingKind::Length => (1e3, "mm"),
        SettingKind::Angle => (180.0 / PI, "deg"),
        SettingKind::Ratio => (1.0, ""),
    }
}

/// Decimals that show a step.
fn digits(step: f64) -> usize {
    let places = (-step.log10()).ceil() + 1.0;
    places.clamp(0.0, 12.0) as usize
}
