//! Report of a gear file: JSON document, tables of geometry, path of contact and load, figures.

use serde_json::{Map, Value, json};

use super::figure::Figure;
use super::gear_plot;
use super::helical_view::helical_view;
use super::number_format::significant;
use super::outline_file::NamedOutline;
use super::plan::{step_lines, steps};
use super::presentation::{Presentation, Provenance};
use super::table::{Table, decimal, or_blank, or_dash};
use super::teeth_view::teeth_view;
use super::view::View;
use crate::base::error::Error;
use crate::gear::cylindrical::backlash::{Backlash, BacklashLimits};
use crate::gear::cylindrical::drawing::ReadingLimits;
use crate::gear::cylindrical::gear_outline::OutlineSteps;
use crate::gear::cylindrical::modification::Relief;
use crate::gear::cylindrical::path_points::PathPoint;
use crate::gear::cylindrical::warnings::{NearestValue, Warning};
use crate::gear::load::compliance::StiffnessRow;
use crate::gear::load::mesh_result::MeshResult;
use crate::gear::load::relief::OptimalRelief;
use crate::numeric::statistics::peak_to_peak;
use crate::plan::gear::drawing::DrawingReading;
use crate::plan::gear::geometry::{GearQuantity, QuantityValue};
use crate::plan::gear::run::GearResult;
use crate::plan::gear_limits::{self, MEMBERS};
use crate::scene::gear_file::GearFile;

/// Seconds of arc in a radian.
pub(super) const ARCSEC: f64 = 648_000.0 / std::f64::consts::PI;

/// Direction and sign of the transmission error of a loaded mesh.
const TE_DIRECTION: &str =
    "along the base tangent of the driven gear in the transverse plane, positive where it leads";

/// Gear file with its analysis result.
pub struct GearReport<'a> {
    /// Gear file.
    pub file: &'a GearFile,
    /// Result of the analysis.
    pub result: GearResult,
}

impl GearReport<'_> {
    /// Outlines of both gears in contact at the pitch point.
    pub fn outlines(&self) -> Vec<NamedOutline> {
        let pair = &self.result.pair;
        let teeth = pair.members.map(|m| 0..m.gear.teeth as i32);
        let polygons = pair.polygons_in_mesh(teeth, OutlineSteps::default());
        let outlines = polygons.into_iter().zip(MEMBERS);
        outlines
            .map(|(points, name)| NamedOutline { name, points })
            .collect()
    }
}

impl Presentation for GearReport<'_> {
    fn provenance(&self) -> Provenance<'_> {
        Provenance::of_plan(
            std::slice::from_ref(&self.file.source),
            &self.result.plan,
            &self.result.diagnostics,
        )
    }

    fn body(&self) -> Result<Value, Error> {
        let result = &self.result;
        Ok(json!({
            "title": self.file.title,
            "kind": "cylindrical",
            "geometry": geometry_json(&result.quantities),
            "limits": result.limits.iter().map(limit_json).collect::<Vec<_>>(),
            "limits_kept": gear_limits::kept(&result.pair, &result.limits),
            "drawing": result.drawing.iter().map(|readings| readings.iter().map(reading_json).collect()).collect::<Vec<Vec<_>>>(),
            "backlash": result.backlash.as_ref().map(backlash_json),
            "path": result.path.iter().map(|(name, point)| path_json(name, point)).collect::<Vec<_>>(),
            "stiffness": result.stiffness.iter().map(|row| json!({
                "method": row.method,
                "bodies": row.bodies,
                "at_pitch_point_n_per_mm_um": 1e-9 * row.at_pitch_point,
                "single_n_per_mm_um": 1e-9 * row.single,
                "mesh_n_per_mm_um": 1e-9 * row.mesh,
                "left_out": row.left_out,
                "outside_range": row.outside_range,
            })).collect::<Vec<_>>(),
            "mesh": result.mesh.as_ref().map(mesh_json),
            "least_relief": result.least_relief.as_ref().map(relief_json),
        }))
    }

    fn text(&self) -> String {
        let result = &self.result;
        let mut text = title_lines(&self.file.title);
        let fulfilled = gear_limits::kept(&result.pair, &result.limits);
        text += &format!("free of {}\n\n", fulfilled.join(", "));
        text += &geometry_table(&result.quantities).text();
        text += &format!("\n{}", drawing_table(&result.drawing).text());
        if let Some(backlash) = &result.backlash {
            text += &format!("\n{}", backlash_table(backlash).text());
        }
        text += &format!("\n{}", path_table(&result.path).text());
        if !result.stiffness.is_empty() {
            text += &format!("\n{}", stiffness_table(&self.result).text());
        }
        if let Some(mesh) = &result.mesh {
            text += &format!("\n{}te {TE_DIRECTION}\n", load_table(mesh).text());
        }
        if let Some(relief) = &result.least_relief {
            text += &format!("\n{}", relief_lines(relief));
        }
        text
    }

    /// Table over the mesh positions of one pitch for a loaded pair, else the geometry table.
    fn table(&self) -> Table<'_> {
        match &self.result.mesh {
            Some(mesh) => position_table(mesh),
            None => geometry_table(&self.result.quantities),
        }
    }

    fn warnings_first(&self) -> bool {
        true
    }

    /// Steps of the analysis, and the effects each stiffness method omits.
    fn notes(&self) -> String {
        let left_out = |row: &StiffnessRow| {
            format!("{} leaves out: {}\n", row.method, row.left_out.join("; "))
        };
        let methods: String = self.result.stiffness.iter().map(left_out).collect();
        step_lines(steps(&self.result.plan)) + &methods
    }

    fn views(&self) -> Vec<View> {
        let pair = &self.result.pair;
        let spatial = helical_view(pair, self.file.hand);
        std::iter::once(teeth_view(pair, &self.result.path))
            .chain(spatial)
            .collect()
    }

    fn figures(&self) -> Result<Vec<Figure>, Error> {
        let (title, result) = (&self.file.title, &self.result);
        let (pair, path) = (&result.pair, &result.path);
        let mut figures = vec![Figure::first(gear_plot::draw_teeth(title, pair, path))];
        figures.push(Figure::new(
            "sliding",
            gear_plot::sliding(title, pair, path),
        ));
        figures.push(Figure::new(
            "profile",
            gear_plot::profile(title, pair, &self.file.modifications),
        ));
        if let Some(mesh) = &result.mesh {
            figures.push(Figure::new("mesh", gear_plot::te_over_pitch(title, mesh)));
            let stiffness = gear_plot::stiffness(title, mesh);
            figures.push(Figure::new("stiffness", stiffness));
            figures.push(Figure::new("sharing", gear_plot::sharing(title, mesh)));
            if mesh.cycles.len() > 1 {
                figures.push(Figure::new("harris", gear_plot::harris_map(title, mesh)));
            }
        }
        Ok(figures)
    }
}

/// Geometric quantities by key: one value of the pair, or one for each member.
pub(super) fn geometry_json(quantities: &[GearQuantity]) -> Map<String, Value> {
    let value = |quantity: &GearQuantity| match quantity.value {
        QuantityValue::Each(values) => json!(values),
        QuantityValue::Pair(value) => json!(value),
    };
    quantities.iter().map(|q| (q.key(), value(q))).collect()
}

/// Title of a file with a blank line below; empty without a title.
pub(super) fn title_lines(title: &str) -> String {
    match title.is_empty() {
        true => String::new(),
        false => format!("{title}\n\n"),
    }
}

fn limit_json(warning: &Warning) -> Value {
    let nearest = warning.nearest.map(|nearest| match nearest {
        NearestValue::ProfileShift { member, value } => {
            json!({ "member": MEMBERS[member], "profile_shift": value.value() })
        }
        NearestValue::TipDiameter { member, value } => {
            json!({ "member": MEMBERS[member], "tip_diameter_mm": 1e3 * value.value() })
        }
        NearestValue::TipDiameters(diameters) => {
            json!({ "tip_diameters_mm": diameters.map(|d| 1e3 * d.value()) })
        }
        NearestValue::FaceWidth(width) => json!({ "face_width_mm": 1e3 * width.value() }),
        NearestValue::CentreDistance(a) => json!({ "centre_distance_mm": 1e3 * a.value() }),
        NearestValue::Teeth { teeth, shifts, .. } => {
            json!({ "teeth": teeth, "profile_shift": shifts })
        }
    });
    json!({
        "kind": gear_limits::code(warning.kind),
        "member": warning.member.map(|m| MEMBERS[m]),
        "by_si": warning.by,
        "nearest": nearest,
    })
}

fn reading_json(reading: &DrawingReading) -> Value {
    let ReadingLimits {
        nominal,
        least,
        greatest,
    } = reading.limits;
    json!({
        "reading": reading.name,
        "symbol": reading.symbol,
        "nominal_mm": 1e3 * nominal,
        "least_mm": 1e3 * least,
        "greatest_mm": 1e3 * greatest,
        "height_mm": reading.height.map(|h| 1e3 * h),
    })
}

fn backlash_json(limits: &BacklashLimits) -> Value {
    let components = |backlash: &Backlash| {
        json!({
            "circumferential_um": 1e6 * backlash.circumferential,
            "normal_um": 1e6 * backlash.normal,
            "radial_um": 1e6 * backlash.radial,
        })
    };
    json!({
        "nominal": components(&limits.nominal),
        "mean": components(&limits.mean),
        "least": components(&limits.least),
        "greatest": components(&limits.greatest),
    })
}

fn path_json(name: &str, point: &PathPoint) -> Value {
    json!({
        "point": name,
        "distance_mm": 1e3 * point.distance,
        "roll_mm": point.roll.map(|x| 1e3 * x),
        "roll_angle_deg": point.roll_angle.map(f64::to_degrees),
        "diameter_mm": point.diameter.map(|x| 1e3 * x),
        "specific_sliding": point.specific_sliding.map(|x| x.is_finite().then_some(x)),
        "sliding_factor": point.sliding_factor,
    })
}

/// JSON of the loaded mesh: lists over torques of lists over mesh positions.
fn mesh_json(mesh: &MeshResult) -> Value {
    let cycles = &mesh.cycles;
    let arcsec = |e: &f64| e / mesh.driven_base_radius * ARCSEC;
    json!({
        "method": mesh.method,
        "body": mesh.bodies,
        "te_direction": TE_DIRECTION,
        "torques_nm": cycles.iter().map(|c| c.torque).collect::<Vec<_>>(),
        "pinion_angle_rad": mesh.pinion_angles,
        "pairs": mesh.pairs,
        "unloaded_te_um": mesh.unloaded_te.iter().map(|e| 1e6 * e + 0.0).collect::<Vec<_>>(),
        "te_um": cycles.iter().map(|c| c.te.iter().map(|e| 1e6 * e).collect()).collect::<Vec<Vec<f64>>>(),
        "te_arcsec": cycles.iter().map(|c| c.te.iter().map(arcsec).collect()).collect::<Vec<Vec<f64>>>(),
        "stiffness_secant_n_per_m": cycles.iter().map(|c| &c.secant).collect::<Vec<_>>(),
        "stiffness_tangent_n_per_m": cycles.iter().map(|c| &c.tangent).collect::<Vec<_>>(),
        "shares": cycles.iter().map(|c| &c.shares).collect::<Vec<_>>(),
        "corner_share": cycles.iter().map(|c| &c.corner_share).collect::<Vec<_>>(),
        "pressure_pa": cycles.iter().map(|c| &c.pressure).collect::<Vec<_>>(),
        "peak_to_peak_um": cycles.iter().map(|c| 1e6 * c.peak_to_peak()).collect::<Vec<_>>(),
        "unloaded_peak_to_peak_um": 1e6 * peak_to_peak(&mesh.unloaded_te),
    })
}

/// Table of quantities of pinion and gear.
pub(super) fn geometry_table(quantities: &[GearQuantity]) -> Table<'static> {
    member_table(MEMBERS, quantities)
}

/// Table of quantities of two members.
pub(super) fn member_table(
    [first, second]: [&str; 2],
    quantities: &[GearQuantity],
) -> Table<'static> {
    let heads = format!("quantity|symbol|{first}|{second}|unit");
    let mut table = Table::texts(&heads).words(&[]);
    for quantity in quantities {
        let [first, second] = match quantity.value {
            QuantityValue::Each(values) => values.map(|x| or_dash(x, geometry_number)),
            QuantityValue::Pair(value) => [geometry_number(value), String::new()],
        };
        table.row([
            quantity.name.to_string(),
            quantity.symbol.to_string(),
            first,
            second,
            quantity.unit.text().to_string(),
        ]);
    }
    table
}

/// Formats to four decimals (0.1 µm, 1e-4 deg); whole numbers without decimals.
fn geometry_number(x: f64) -> String {
    match x.fract() == 0.0 && x.abs() < 1e6 {
        true => format!("{x}"),
        false => format!("{x:.4}"),
    }
}

fn drawing_table(drawing: &[Vec<DrawingReading>; 2]) -> Table<'static> {
    let mut table =
        Table::named("reading|symbol|nominal [mm]|least [mm]|greatest [mm]|height [mm]")
            .words(&[1]);
    for (member, readings) in MEMBERS.iter().zip(drawing) {
        for reading in readings {
            let millimetres = |x: f64| format!("{:.4}", 1e3 * x);
            table.row([
                format!("{member}: {}", reading.name),
                reading.symbol.to_string(),
                millimetres(reading.limits.nominal),
                millimetres(reading.limits.least),
                millimetres(reading.limits.greatest),
                or_blank(reading.height, millimetres),
            ]);
        }
    }
    table
}

fn backlash_table(limits: &BacklashLimits) -> Table<'static> {
    let mut table = Table::named("backlash|nominal [µm]|mean [µm]|least [µm]|greatest [µm]");
    let cases = [
        &limits.nominal,
        &limits.mean,
        &limits.least,
        &limits.greatest,
    ];
    let mut row = |name: &str, of: fn(&Backlash) -> f64| {
        let [nominal, mean, least, greatest] = cases.map(|b| format!("{:.1}", 1e6 * of(b)));
        table.row([name.to_string(), nominal, mean, least, greatest]);
    };
    row("circumferential j_wt", |b| b.circumferential);
    row("normal j_bn", |b| b.normal);
    row("radial j_r", |b| b.radial);
    table
}

fn path_table(path: &[(&'static str, PathPoint)]) -> Table<'static> {
    let mut table = Table::named(
        "point|distance [mm]|d pinion [mm]|d gear [mm]|roll pinion [deg]|roll gear [deg]|ζ pinion|ζ gear",
    );
    for (name, point) in path {
        let [d1, d2] = point.diameter.map(|d| format!("{:.4}", 1e3 * d));
        let [r1, r2] = point.roll_angle.map(|r| format!("{:.4}", r.to_degrees()));
        let [s1, s2] = point.specific_sliding.map(|s| match s.is_finite() {
            true => format!("{s:.4}"),
            false => "–".into(),
        });
        let distance = format!("{:.4}", 1e3 * point.distance);
        table.row([name.to_string(), distance, d1, d2, r1, r2, s1, s2]);
    }
    table
}

fn stiffness_table(result: &GearResult) -> Table<'static> {
    let mut table =
        Table::named("stiffness by|at C [N/(mm µm)]|c′ [N/(mm µm)]|c_γ [N/(mm µm)]|bodies")
            .words(&[4]);
    for row in &result.stiffness {
        let scaled = |x: f64| format!("{:.3}", 1e-9 * x);
        let [pinion, gear] = row.bodies;
        let bodies = match pinion == gear {
            true => pinion.to_string(),
            false => format!("{pinion}; {gear}"),
        };
        table.row([
            row.method.to_string(),
            scaled(row.at_pitch_point),
            scaled(row.single),
            scaled(row.mesh),
            bodies,
        ]);
    }
    table
}

/// Table of the loaded mesh, one row per torque.
fn load_table(mesh: &MeshResult) -> Table<'static> {
    let mut table = Table::numeric(
        "torque [N·m]|te peak to peak [µm]|te peak to peak [arcsec]|k mean [N/µm]|k least [N/µm]|k most [N/µm]|pressure [N/mm²]|on corners [%]",
    );
    for cycle in &mesh.cycles {
        let peak_to_peak = cycle.peak_to_peak();
        let mean = cycle.tangent.iter().sum::<f64>() / cycle.tangent.len().max(1) as f64;
        let range = |values: &[f64]| {
            (values.iter()).fold([f64::INFINITY, 0.0f64], |[l, h], x| [l.min(*x), h.max(*x)])
        };
        let [least, greatest] = range(&cycle.tangent);
        let pressure = cycle.pressure.iter().flatten().copied().reduce(f64::max);
        let corner = cycle.corner_share.iter().copied().fold(0.0, f64::max);
        table.row([
            significant(cycle.torque),
            format!("{:.4}", 1e6 * peak_to_peak),
            format!("{:.4}", peak_to_peak / mesh.driven_base_radius * ARCSEC),
            significant(1e-6 * mean),
            significant(1e-6 * least),
            significant(1e-6 * greatest),
            or_dash(pressure, |p| format!("{:.1}", 1e-6 * p)),
            format!("{:.1}", 100.0 * corner),
        ]);
    }
    table
}

fn relief_json(relief: &OptimalRelief) -> Value {
    let relief_of =
        |r: &Relief| json!({ "tip_relief_um": 1e6 * r.amount, "relief_from_mm": 1e3 * r.from });
    json!({
        "pinion": relief_of(&relief.reliefs[0]),
        "gear": relief_of(&relief.reliefs[1]),
        "share": relief.share,
        "torques_nm": relief.torques,
        "peak_to_peak_um": relief.peak_to_peak.iter().map(|e| 1e6 * e).collect::<Vec<_>>(),
        "without_um": relief.without.iter().map(|e| 1e6 * e).collect::<Vec<_>>(),
    })
}

/// Tip relief as keys of the gear file, and the remaining peak-to-peak transmission error by torque.
fn relief_lines(relief: &OptimalRelief) -> String {
    let mut table = Table::numeric("torque [N·m]|te peak to peak [µm]|without tip relief [µm]");
    let rows = relief
        .torques
        .iter()
        .zip(&relief.peak_to_peak)
        .zip(&relief.without);
    for ((torque, modified), unmodified) in rows {
        table.row([
            significant(*torque),
            format!("{:.4}", 1e6 * modified),
            format!("{:.4}", 1e6 * unmodified),
        ]);
    }
    let keys: String = MEMBERS
        .iter()
        .zip(&relief.reliefs)
        .map(|(name, r)| {
            format!(
                "{name}: tip_relief = \"{:.2} µm\", relief_from = \"{:.4} mm\"\n",
                1e6 * r.amount,
                1e3 * r.from
            )
        })
        .collect();
    format!(
        "relief of minimum peak to peak over the torques, over {:.1} % of the path of multiple contact\n{keys}{}",
        100.0 * relief.share,
        table.text()
    )
}

/// Table over mesh positions: transmission error and stiffness at every torque.
fn position_table(mesh: &MeshResult) -> Table<'_> {
    let micro = |values: &[f64]| values.iter().map(|e| 1e6 * e + 0.0).collect::<Vec<f64>>();
    let mut table = Table::default()
        .numbers("pinion_angle", "rad", &mesh.pinion_angles[..], decimal)
        .numbers("te_unloaded", "µm", micro(&mesh.unloaded_te), decimal);
    for cycle in &mesh.cycles {
        let load = format!("{} N·m", decimal(cycle.torque));
        table = table
            .numbers(&format!("te at {load}"), "µm", micro(&cycle.te), decimal)
            .numbers(
                &format!("secant stiffness at {load}"),
                "N/m",
                &cycle.secant[..],
                decimal,
            )
            .numbers(
                &format!("tangent stiffness at {load}"),
                "N/m",
                &cycle.tangent[..],
                decimal,
            );
    }
    table
}
