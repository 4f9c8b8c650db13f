//! Bevel pairs: document, setting sheet, structure elements, contact, figures.

use serde_json::{Value, json};

use super::bevel_contact::{
    backlash_json, contact_json, contact_table, ease_off_json, ease_off_table, vh_json, vh_table,
};
use super::figure::Figure;
use super::gear::{ARCSEC, geometry_json, geometry_table, title_lines};
use super::gear_sheet::drawn;
use super::pair_view::pair_view;
use super::plan::{step_lines, steps};
use super::presentation::{Presentation, Provenance};
use super::surface_view::ease_off_view;
use super::table::{Table, decimal, or_dash};
use super::view::View;
use super::{bevel_flank_plot, bevel_mesh, bevel_mesh_plot, bevel_plot, bevel_stability};
use crate::base::error::Error;
use crate::gear::bevel::tooth::SIDES;
use crate::plan::gear::bevel::{BevelResult, hand_name};
use crate::plan::gear::bevel_contact::BevelContactPoint;
use crate::plan::gear::bevel_limits::BevelLimit;
use crate::plan::gear::bevel_member::FlankResult;
use crate::plan::gear::bevel_mesh::BevelMeshResult;
use crate::plan::gear::pattern_states::PatternStates;
use crate::plan::gear::{axodes, hypoid_theory};
use crate::plan::gear_limits::MEMBERS;
use crate::scene::bevel_file::BevelFile;
use crate::scene::machine_settings::FlankCut;

/// A bevel file with what it gives.
pub struct BevelReport<'a> {
    /// The file.
    pub file: &'a BevelFile,
    /// The result.
    pub result: BevelResult,
}

impl Presentation for BevelReport<'_> {
    fn provenance(&self) -> Provenance<'_> {
        Provenance::of_plan(
            std::slice::from_ref(&self.file.source),
            &self.result.plan,
            &self.result.diagnostics,
        )
    }

    fn body(&self) -> Result<Value, Error> {
        let result = &self.result;
        let member = |k: usize| {
            let flanks: Vec<Value> = (0..2)
                .filter_map(|side| {
                    Some(flank_json(
                        SIDES[side],
                        self.file.members[k].flanks[side].as_ref(),
                        result.members[k].flanks[side].as_ref()?,
                    ))
                })
                .collect();
            json!({ "name": MEMBERS[k], "hand": hand_name(self.file.hand_of(k)), "flanks": flanks })
        };
        let contact = result.contact.as_ref();
        Ok(json!({
            "title": self.file.title,
            "kind": "bevel",
            "geometry": geometry_json(&result.quantities),
            "members": [member(0), member(1)],
            "limits": result.limits.iter().map(limit_json).collect::<Vec<_>>(),
            "tca": contact.map(|c| contact_json(c, self.file.contact.side.name())),
            "least_backlash": result.backlash.as_ref().map(backlash_json),
            "ease_off": contact.map(ease_off_json),
            "vh": contact.and_then(vh_json),
            "vh_states": result.states.as_ref().map(vh_states_json),
            "mesh": result.mesh.as_ref().map(|mesh| bevel_mesh::mesh_json(mesh, &result.studies)),
        }))
    }

    fn text(&self) -> String {
        let result = &self.result;
        let mut text = title_lines(&self.file.title);
        text += &geometry_table(&result.quantities).text();
        if !self.columns().is_empty() {
            if self.columns().iter().any(|(_, cut, _)| cut.is_some()) {
                text += &format!("\n{}", self.sheet().text());
            }
            text += &format!("\n{}", self.elements().text());
        }
        if let Some(contact) = &result.contact {
            let side = self.file.contact.side.name();
            text += &format!(
                "\n{}",
                contact_table(contact, result.backlash.as_ref(), side).text()
            );
            if let Some(terms) = &contact.ease_off.1 {
                text += &format!("\n{}", ease_off_table(terms).text());
            }
            if contact.vh.is_some() {
                text += &format!("\n{}", vh_table(contact).text());
            }
        }
        if let Some(mesh) = &result.mesh {
            text += &format!("\n{}", bevel_mesh::text(mesh, &result.studies));
        }
        text
    }

    /// The transmission error over the positions, with a torque the loaded one; without a contact the geometry.
    fn table(&self) -> Table<'_> {
        if let Some(mesh) = &self.result.mesh {
            return bevel_mesh::position_table(mesh);
        }
        let Some(contact) = &self.result.contact else {
            return geometry_table(&self.result.quantities);
        };
        let of = |value: fn(&BevelContactPoint) -> f64| -> Vec<f64> {
            contact.points.iter().map(value).collect()
        };
        Table::default()
            .numbers("pinion_angle", "rad", of(|p| p.pinion_angle), decimal)
            .numbers("gear_angle", "rad", of(|p| p.gear_angle), decimal)
            .numbers("te", "arcsec", of(|p| ARCSEC * p.te), decimal)
            .numbers("pair", "", of(|p| f64::from(p.pair)), decimal)
            .numbers("x", "mm", of(|p| 1e3 * p.in_pinion.x), decimal)
            .numbers("y", "mm", of(|p| 1e3 * p.in_pinion.y), decimal)
            .numbers("z", "mm", of(|p| 1e3 * p.in_pinion.z), decimal)
    }

    fn notes(&self) -> String {
        step_lines(steps(&self.result.plan))
    }

    fn views(&self) -> Vec<View> {
        let pair = pair_view(self.file, &self.result);
        let ease_off = self.result.contact.as_ref().map(|contact| {
            let section = &contact.pair.flanks[0].section;
            ease_off_view(section, &contact.ease_off.0)
        });
        pair.into_iter().chain(ease_off).collect()
    }

    fn figures(&self) -> Result<Vec<Figure>, Error> {
        let title = &self.file.title;
        let mut all = vec![Figure::first(bevel_plot::draw_blanks(title, self.file))];
        let flanks = bevel_flank_plot::draw_flanks(title, &self.result.members);
        all.extend(flanks.map(|drawn| Figure::new("flanks", drawn)));
        let of_side = &format!("{title}, {} flanks", self.file.contact.side.name());
        if let Some(contact) = &self.result.contact {
            all.push(Figure::new("te", bevel_plot::te(of_side, contact)));
            all.push(Figure::new(
                "pattern",
                bevel_plot::draw_pattern(of_side, contact, self.file.contact.positions),
            ));
            all.push(Figure::new(
                "ease-off",
                bevel_plot::draw_ease_off(of_side, contact),
            ));
            if let Some(BevelMeshResult { mesh, .. }) = &self.result.mesh {
                let stability = &self.result.studies.stability;
                all.push(Figure::new("mesh", bevel_mesh_plot::te(of_side, mesh)));
                let pattern = bevel_mesh_plot::draw_pattern(of_side, &contact.pair, mesh);
                all.push(Figure::new("load", pattern));
                all.push(Figure::new(
                    "lengthwise",
                    bevel_mesh_plot::lengthwise(of_side, mesh),
                ));
                all.push(Figure::new(
                    "sharing",
                    bevel_mesh_plot::sharing(of_side, mesh),
                ));
                if mesh.cycles.len() > 1 {
                    all.push(Figure::new(
                        "harris",
                        bevel_mesh_plot::harris_map(of_side, mesh),
                    ));
                }
                if !stability.is_empty() {
                    all.push(Figure::new(
                        "stability",
                        bevel_stability::draw(of_side, stability),
                    ));
                }
            }
        }
        let outer = self.file.members[0].blank.cone_distances()[1];
        let picture = axodes::picture(&hypoid_theory::axes(self.file), [0.0, outer]);
        all.extend(picture.map(|plot| Figure::new(plot.suffix, drawn(title, &plot))));
        Ok(all)
    }
}

/// Suffixes of the figures.
pub const FIGURES: [&str; 12] = [
    "",
    "flanks",
    "te",
    "pattern",
    "ease-off",
    "mesh",
    "load",
    "lengthwise",
    "sharing",
    "harris",
    "stability",
    axodes::SUFFIX,
];

/// A row of the setting sheet: name, symbol, key in documents, unit, value.
type Setting = (
    &'static str,
    &'static str,
    &'static str,
    fn(&FlankCut) -> Option<f64>,
);

/// The setting sheet, each quantity by both names where there are two.
const SHEET: &[Setting] = &[
    ("point radius", "r_p [mm]", "point_radius_mm", |c| {
        Some(1e3 * c.cutter.point_radius)
    }),
    ("blade angle", "α_b [deg]", "blade_angle_deg", |c| {
        Some(c.cutter.blade_angle.to_degrees())
    }),
    ("edge radius", "ρ_e [mm]", "edge_radius_mm", |c| {
        Some(1e3 * c.cutter.edge_radius)
    }),
    ("profile radius", "R_b [mm]", "profile_radius_mm", |c| {
        let curvature = c.cutter.profile_curvature;
        (curvature != 0.0).then_some(1e3 / curvature)
    }),
    ("profile height", "h_p [mm]", "profile_height_mm", |c| {
        (c.cutter.profile_curvature != 0.0).then_some(1e3 * c.cutter.profile_height)
    }),
    ("Toprem angle", "Δα_t [deg]", "toprem_angle_deg", |c| {
        Some(c.cutter.toprem?.angle.to_degrees())
    }),
    ("Toprem depth", "h_t [mm]", "toprem_depth_mm", |c| {
        Some(1e3 * c.cutter.toprem?.depth)
    }),
    ("radial distance", "S_r [mm]", "radial_distance_mm", |c| {
        Some(1e3 * c.settings.radial_distance)
    }),
    (
        "eccentric angle",
        "β_e [deg]",
        "eccentric_angle_deg",
        |c| Some(c.eccentric?.angle.to_degrees()),
    ),
    ("cradle angle", "q [deg]", "cradle_angle_deg", |c| {
        Some(c.settings.cradle_angle.to_degrees())
    }),
    ("blank offset", "E_m [mm]", "blank_offset_mm", |c| {
        Some(1e3 * c.settings.blank_offset)
    }),
    (
        "machine root angle",
        "γ_m [deg]",
        "machine_root_angle_deg",
        |c| Some(c.settings.machine_root_angle.to_degrees()),
    ),
    ("sliding base", "X_B [mm]", "sliding_base_mm", |c| {
        Some(1e3 * c.settings.sliding_base)
    }),
    (
        "machine centre to back",
        "X_D [mm]",
        "centre_to_back_mm",
        |c| Some(1e3 * c.settings.centre_to_back),
    ),
    ("tilt", "i [deg]", "tilt_deg", |c| {
        Some(c.settings.tilt.to_degrees())
    }),
    ("swivel", "j [deg]", "swivel_deg", |c| {
        Some(c.settings.swivel.to_degrees())
    }),
    (
        "ratio of roll, work over cradle",
        "R_a",
        "work_over_cradle",
        |c| Some(c.settings.roll?.work_over_cradle),
    ),
    (
        "ratio of roll, cradle over work",
        "1/R_a",
        "cradle_over_work",
        |c| Some(1.0 / c.settings.roll?.work_over_cradle),
    ),
    ("modified roll", "2C", "modified_roll_2C", |c| {
        Some(2.0 * c.settings.roll?.modification[0])
    }),
    ("modified roll", "6D", "modified_roll_6D", |c| {
        Some(6.0 * c.settings.roll?.modification[1])
    }),
    ("modified roll", "24E", "modified_roll_24E", |c| {
        Some(24.0 * c.settings.roll?.modification[2])
    }),
    ("modified roll", "120F", "modified_roll_120F", |c| {
        Some(120.0 * c.settings.roll?.modification[3])
    }),
    (
        "helical motion",
        "X_B1 [mm/rad]",
        "helical_motion_mm_per_rad",
        |c| c.settings.roll.map(|_| 1e3 * c.settings.helical_motion),
    ),
];

impl BevelReport<'_> {
    /// Every flank that the file describes, in columns.
    fn columns(&self) -> Vec<(String, Option<&FlankCut>, &FlankResult)> {
        let mut all = Vec::new();
        for (k, name) in MEMBERS.into_iter().enumerate() {
            for (side, word) in SIDES.into_iter().enumerate() {
                if let Some(result) = &self.result.members[k].flanks[side] {
                    let cut = self.file.members[k].flanks[side].as_ref();
                    all.push((format!("{name} {word}"), cut, result));
                }
            }
        }
        all
    }

    fn sheet(&self) -> Table<'static> {
        let mut columns = self.columns();
        columns.retain(|(_, cut, _)| cut.is_some());
        let mut table = Table::named("setting|symbol").words(&[1]);
        for (name, ..) in &columns {
            table = table.column(name, "");
        }
        for (name, symbol, _, value) in SHEET {
            let values: Vec<Option<f64>> = columns.iter().map(|c| value(c.1?)).collect();
            // What no flank has is not on the sheet.
            if values.iter().flatten().all(|v| *v == 0.0) {
                continue;
            }
            let mut cells = vec![name.to_string(), symbol.to_string()];
            cells.extend(values.iter().map(|v| or_dash(*v, |x| format!("{x:.6}"))));
            table.row(cells);
        }
        table
    }

    fn elements(&self) -> Table<'static> {
        let mut table = Table::named(
            "flank at the mean point|α [deg]|β [deg]|dα/dL [deg/mm]|lengthwise χ [1/mm]|profile ζ [1/mm]|κ_1 [1/mm]|κ_2 [1/mm]",
        );
        for (name, _, result) in self.columns() {
            let Some(e) = result.elements else { continue };
            let [k1, k2] =
                [0, 1].map(|i| or_dash(result.curvatures, |k| format!("{:.6}", 1e-3 * k[i])));
            table.row([
                name,
                format!("{:.4}", e.pressure_angle.abs().to_degrees()),
                format!("{:.4}", e.spiral_angle.abs().to_degrees()),
                format!("{:.5}", 1e-3 * e.diagonal.to_degrees()),
                format!("{:.6}", 1e-3 * e.lengthwise_curvature),
                format!("{:.6}", 1e-3 * e.profile_curvature),
                k1,
                k2,
            ]);
        }
        table
    }
}

fn flank_json(side: &str, cut: Option<&FlankCut>, result: &FlankResult) -> Value {
    let grid = &result.grid;
    let nodes = || grid.nodes.iter();
    let points: Vec<Option<[f64; 3]>> = nodes()
        .map(|n| n.map(|n| n.point.point.coordinates.array()))
        .collect();
    let normals: Vec<Option<[f64; 3]>> = nodes()
        .map(|n| n.map(|n| n.point.normal.components.array()))
        .collect();
    let curvatures: Vec<Option<[f64; 2]>> = nodes()
        .map(|n| {
            Some(
                (*n)?
                    .point
                    .second_order
                    .envelope()?
                    .principal()
                    .map(|(k, _)| k),
            )
        })
        .collect();
    let fillet: Vec<Option<bool>> = nodes().map(|n| n.map(|n| n.in_fillet)).collect();
    let settings: serde_json::Map<String, Value> = SHEET
        .iter()
        .filter_map(|(_, _, key, value)| Some((key.to_string(), json!(value(cut?)?))))
        .collect();
    json!({
        "side": side,
        "settings": settings,
        "rows": grid.rows,
        "columns": grid.columns,
        "points_m": points,
        "normals": normals,
        "curvatures_per_m": curvatures,
        "in_fillet": fillet,
        "structure": result.elements.map(|e| json!({
            "cone_distance_mm": 1e3 * e.cone_distance,
            "cone_angle_deg": e.cone_angle.to_degrees(),
            "pressure_angle_deg": e.pressure_angle.to_degrees(),
            "spiral_angle_deg": e.spiral_angle.to_degrees(),
            "diagonal_rad_per_m": e.diagonal,
            "lengthwise_curvature_per_m": e.lengthwise_curvature,
            "profile_curvature_per_m": e.profile_curvature,
        })),
    })
}

fn limit_json(limit: &BevelLimit) -> Value {
    json!({
        "kind": limit.kind,
        "member": MEMBERS[limit.member],
        "side": limit.side.map(|side| SIDES[side]),
        "at": { "face": limit.at[0], "height": limit.at[1] },
        "nearest": { "depth_less_mm": 1e3 * limit.depth },
    })
}

/// The transmission error over the grid of V and H: for each V every H, null where the flanks do not touch at every angle.
fn vh_states_json(states: &PatternStates) -> Value {
    let peaks = (states.states.iter()).map(|s| Some(ARCSEC * s.as_ref()?.peak_to_peak?));
    let peaks: Vec<Option<f64>> = peaks.collect();
    json!({
        "offset_mm": states.offsets.iter().map(|v| 1e3 * v).collect::<Vec<_>>(),
        "pinion_axial_mm": states.axials.iter().map(|h| 1e3 * h).collect::<Vec<_>>(),
        "peak_to_peak_arcsec": peaks.chunks(states.axials.len()).collect::<Vec<_>>(),
    })
}
