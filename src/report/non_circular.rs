//! Gears of a varying ratio: document, tables of centrodes and flank, centrodes with teeth.

use std::f64::consts::TAU;

use serde_json::{Value, json};

use super::figure::Figure;
use super::gear::{ARCSEC, geometry_json, geometry_table, title_lines};
use super::non_circular_plot;
use super::outline_file::NamedOutline;
use super::plan::{step_lines, steps};
use super::presentation::{Presentation, Provenance};
use super::table::{Table, decimal};
use crate::base::error::Error;
use crate::gear::plane::centrodes::Member;
use crate::gear::plane::conjugate_flank::ConjugateFlank;
use crate::gear::plane::given_profiles::GivenContact;
use crate::numeric::Complex;
use crate::plan::gear::non_circular::NonCircularResult;
use crate::plan::gear_limits::MEMBERS;
use crate::scene::non_circular_file::{NonCircularFile, RatioKind};

/// A file of non-circular gears with what it gives.
pub struct NonCircularReport<'a> {
    /// The file.
    pub file: &'a NonCircularFile,
    /// The result.
    pub result: NonCircularResult,
}

impl NonCircularReport<'_> {
    /// Flanks of pinion and gear at φ₁ = 0 in the fixed frame, where there are no outlines: one of each tooth of circular gears of known tooth
    /// numbers, else one.
    fn flanks(&self) -> [Vec<Vec<[f64; 2]>>; 2] {
        let (pair, result) = (&self.result.centrodes, &self.result);
        let (Some(flank), Some(state), true) =
            (&result.flank, pair.at(0.0), result.outlines.is_empty())
        else {
            return [Vec::new(), Vec::new()];
        };
        let is_circular = self.file.ratio == RatioKind::Constant;
        let teeth = self.file.teeth.filter(|_| is_circular).unwrap_or([1, 1]);
        let pinion: Vec<Complex> = flank.contacts.iter().map(|c| c.tool_point).collect();
        let members = [
            (Member::First, pinion, teeth[0]),
            (Member::Second, flank.gear_points.clone(), teeth[1]),
        ];
        members.map(|(member, points, teeth)| {
            let (origin, angle) = pair.pose(member, &state);
            let tooth = |k: u32| {
                let turn = Complex::cis(angle + TAU * f64::from(k) / f64::from(teeth));
                let placed = points.iter().map(|z| origin + z * turn);
                placed.map(|z| [z.re, z.im]).collect()
            };
            (0..teeth).map(tooth).collect()
        })
    }

    /// Outlines of pinion and gear at φ₁ = 0 in the fixed frame.
    pub fn outlines(&self) -> Vec<NamedOutline> {
        let pair = &self.result.centrodes;
        let Some(state) = pair.at(0.0) else {
            return Vec::new();
        };
        let members = [Member::First, Member::Second].into_iter().zip(MEMBERS);
        (self.result.outlines.iter().zip(members))
            .map(|(outline, (member, name))| {
                let (origin, angle) = pair.pose(member, &state);
                let placed = |z: Complex| origin + z * Complex::cis(angle);
                let points = outline.points.iter().map(|p| placed(p.point));
                let mut points: Vec<[f64; 2]> = points.map(|z| [z.re, z.im]).collect();
                // The gear's arc runs clockwise.
                if member == Member::Second {
                    points.reverse();
                }
                NamedOutline { name, points }
            })
            .collect()
    }
}

impl Presentation for NonCircularReport<'_> {
    fn provenance(&self) -> Provenance<'_> {
        Provenance::of_plan(
            &self.file.sources,
            &self.result.plan,
            &self.result.diagnostics,
        )
    }

    fn body(&self) -> Result<Value, Error> {
        let result = &self.result;
        let curvatures: Vec<Value> = (result.curvatures.iter())
            .map(|c| {
                json!({
                    "least_per_m": c.least[0], "least_at_rad": c.least[1],
                    "largest_per_m": c.largest[0], "largest_at_rad": c.largest[1],
                    "convex": c.least[0] > 0.0,
                })
            })
            .collect();
        let of = |value: fn(&Row) -> f64| -> Vec<f64> { self.rows().iter().map(value).collect() };
        Ok(json!({
            "title": self.file.title,
            "kind": "non-circular",
            "geometry": geometry_json(&result.quantities),
            "curvature": curvatures,
            "centrodes": {
                "angle_1_rad": of(|r| r.angles[0]),
                "angle_2_rad": of(|r| r.angles[1]),
                "ratio": of(|r| r.ratio),
                "radius_1_mm": of(|r| 1e3 * r.radii[0]),
                "radius_2_mm": of(|r| 1e3 * r.radii[1]),
                "arc_mm": of(|r| 1e3 * r.arc),
            },
            "flank": result.flank.as_ref().map(flank_json),
            "given": result.given.iter().map(given_json).collect::<Vec<_>>(),
        }))
    }

    fn text(&self) -> String {
        let result = &self.result;
        let mut text = title_lines(&self.file.title);
        text += &geometry_table(&result.quantities).text();
        let mut table = Table::named(
            "centrode|least curvature [1/m]|at φ_1 [deg]|largest [1/m]|at φ_1 [deg]|shape",
        )
        .words(&[5]);
        for (name, c) in MEMBERS.iter().zip(&result.curvatures) {
            table.row([
                name.to_string(),
                format!("{:.4}", c.least[0]),
                format!("{:.2}", c.least[1].to_degrees()),
                format!("{:.4}", c.largest[0]),
                format!("{:.2}", c.largest[1].to_degrees()),
                if c.least[0] > 0.0 {
                    "convex"
                } else {
                    "concave in part"
                }
                .to_string(),
            ]);
        }
        text += &format!("\n{}", table.text());
        if let Some(flank) = &result.flank {
            text += &format!("\n{}\n{}", flank_table(flank).text(), check_lines(flank));
        }
        if !result.given.is_empty() {
            text += &format!("\n{}", given_table(&result.given).text());
        }
        text
    }

    /// The centrodes over a period.
    fn table(&self) -> Table<'_> {
        let rows = self.rows();
        let of = |value: fn(&Row) -> f64| -> Vec<f64> { rows.iter().map(value).collect() };
        Table::default()
            .numbers("angle_1", "deg", of(|r| r.angles[0].to_degrees()), decimal)
            .numbers("angle_2", "deg", of(|r| r.angles[1].to_degrees()), decimal)
            .numbers("ratio", "", of(|r| r.ratio), decimal)
            .numbers("radius_1", "mm", of(|r| 1e3 * r.radii[0]), decimal)
            .numbers("radius_2", "mm", of(|r| 1e3 * r.radii[1]), decimal)
            .numbers("arc", "mm", of(|r| 1e3 * r.arc), decimal)
    }

    fn warnings_first(&self) -> bool {
        true
    }

    fn notes(&self) -> String {
        step_lines(steps(&self.result.plan))
    }

    fn figures(&self) -> Result<Vec<Figure>, Error> {
        let rows = self.rows();
        let ratio = rows.iter().map(|r| (r.angles[0].to_degrees(), r.ratio));
        let title = &self.file.title;
        Ok(vec![
            Figure::first(non_circular_plot::draw_centrodes(
                title,
                &self.result.centrodes,
                &self.outlines(),
                &self.flanks(),
            )),
            Figure::new("ratio", non_circular_plot::ratio(title, ratio)),
        ])
    }
}

/// Both centrodes at one angle of gear 1.
struct Row {
    angles: [f64; 2],
    ratio: f64,
    radii: [f64; 2],
    arc: f64,
}

impl NonCircularReport<'_> {
    fn rows(&self) -> Vec<Row> {
        let pair = &self.result.centrodes;
        let row = |angle: &f64| {
            let (state, law) = (pair.at(*angle)?, self.file.law.at(*angle)?);
            Some(Row {
                angles: [*angle, law.angle_2],
                ratio: law.ratio,
                radii: [state.radius_1, state.radius_1 * law.ratio],
                arc: pair.arc(*angle),
            })
        };
        self.result.angles.iter().filter_map(row).collect()
    }
}

fn flank_json(flank: &ConjugateFlank) -> Value {
    let points = |at: fn(&crate::gear::plane::contact::Contact) -> Complex| -> Vec<[f64; 2]> {
        flank
            .contacts
            .iter()
            .map(at)
            .map(|z| [1e3 * z.re, 1e3 * z.im])
            .collect()
    };
    let sliding: Vec<[Option<f64>; 2]> = (flank.contacts.iter())
        .map(|c| c.specific_sliding().map(|s| s.is_finite().then_some(s)))
        .collect();
    json!({
        "angle_1_rad": flank.angles,
        "pinion_mm": points(|c| c.tool_point),
        "gear_mm": flank.gear_points.iter().map(|z| [1e3 * z.re, 1e3 * z.im]).collect::<Vec<_>>(),
        "path_mm": points(|c| c.path_point),
        "specific_sliding": sliding,
        "route_deviation_um": 1e6 * flank.route_deviation,
        "law_error_arcsec": flank.law_error().map(|error| ARCSEC * error),
        "second_contact": flank.second.iter().map(|second| json!({
            "pinion_mm": [1e3 * second.tool_point.re, 1e3 * second.tool_point.im],
            "path_mm": [1e3 * second.path_point.re, 1e3 * second.path_point.im],
            "apart_mm": 1e3 * (second.tool_point - second.first.tool_point).norm(),
        })).collect::<Vec<_>>(),
        "pitch_point_miss_um": worst(flank, |c| 1e6 * c.pitch_point_deviation),
    })
}

/// Largest size of a value over the checks of the law of gearing.
fn worst(
    flank: &ConjugateFlank,
    value: fn(&crate::gear::plane::law_of_gearing::GearingCheck) -> f64,
) -> f64 {
    flank
        .checks
        .iter()
        .map(|c| value(c).abs())
        .fold(0.0, f64::max)
}

/// Rows of the flank's table.
const FLANK_ROWS: usize = 8;

fn flank_table(flank: &ConjugateFlank) -> Table<'static> {
    let mut table = Table::numeric(
        "flank at φ_1 [deg]|r pinion [mm]|r gear [mm]|ζ pinion|ζ gear|from pitch point [mm]",
    );
    let count = flank.contacts.len();
    let step = (count / FLANK_ROWS).max(1);
    for k in (0..count).step_by(step) {
        let contact = &flank.contacts[k];
        let [first, second] = contact.specific_sliding().map(|s| match s.is_finite() {
            true => format!("{s:.4}"),
            false => "–".into(),
        });
        table.row([
            format!("{:.3}", flank.angles[k].to_degrees()),
            format!("{:.4}", 1e3 * contact.tool_point.norm()),
            format!("{:.4}", 1e3 * flank.gear_points[k].norm()),
            first,
            second,
            format!("{:.4}", 1e3 * contact.path_point.norm()),
        ]);
    }
    table
}

fn check_lines(flank: &ConjugateFlank) -> String {
    let mut lines = match flank.law_error() {
        Some(error) => format!(
            "law of gearing over {} contacts: the gear deviates by at most {:.1e} arcsec, the normal from the pitch point by {:.1e} µm\n",
            flank.checks.len(),
            ARCSEC * error,
            worst(flank, |c| 1e6 * c.pitch_point_deviation),
        ),
        None => "law of gearing not checked: a flank folds back\n".into(),
    };
    if flank.route_deviation > 0.0 {
        lines += &format!(
            "points of the gear differ from those by normals by {:.1e} µm at most\n",
            1e6 * flank.route_deviation
        );
    }
    let apart = (flank.second.iter()).map(|s| (s.tool_point - s.first.tool_point).norm());
    let [near, far] = apart.fold([f64::INFINITY, 0.0f64], |[l, h], x| [l.min(x), h.max(x)]);
    lines += &match flank.second.len() {
        0 => "no second contact of the gear's flank with the pinion\n".into(),
        n => format!(
            "{n} points of the gear's flank touch the body of the pinion a second time, {:.4} to {:.4} mm from the first contact, {} of them at radii of the pinion's flank\n",
            1e3 * near,
            1e3 * far,
            flank.n_second_contacts()
        ),
    };
    lines
}

fn given_json(contact: &GivenContact) -> Value {
    let GivenContact { check, ratio } = contact;
    json!({
        "angle_1_rad": check.angle_1,
        "point_mm": [1e3 * check.point.re, 1e3 * check.point.im],
        "ratio": check.ratio,
        "ratio_of_law": ratio,
        "pitch_point_miss_mm": 1e3 * check.pitch_point_deviation,
        "te_arcsec": ARCSEC * check.error,
    })
}

/// Contacts of a given pair: the ratio of the common normal and its distance from the pitch point.
fn given_table(given: &[GivenContact]) -> Table<'static> {
    let mut table = Table::numeric(
        "given flanks at φ_1 [deg]|i_12|i_12 of the law|normal off the pitch point [mm]|gear ahead [arcsec]",
    );
    let step = (given.len() / FLANK_ROWS).max(1);
    for GivenContact { check, ratio } in given.iter().step_by(step) {
        table.row([
            format!("{:.3}", check.angle_1.to_degrees()),
            format!("{:.6}", check.ratio),
            format!("{ratio:.6}"),
            format!("{:.6}", 1e3 * check.pitch_point_deviation),
            format!("{:.4}", ARCSEC * check.error),
        ]);
    }
    table
}
