//! Flanks cut by discrete blades: document, tables, contact, files of flanks, figures.

use serde_json::{Value, json};

use super::figure::Figure;
use super::gear::{ARCSEC, title_lines};
use super::gear_cut_plot::{self, flank_name};
use super::number_format::four_digits;
use super::plan::{step_lines, steps};
use super::presentation::{Presentation, Provenance};
use super::surface_view::cut_view;
use super::table::{Table, decimal, or_dash};
use super::view::View;
use crate::base::error::Error;
use crate::gear::bevel::solid::Solid;
use crate::gear::bevel::tooth::SIDES;
use crate::gear::cut::cut_surface::cut_surface;
use crate::plan::gear::cut::CutResult;
use crate::plan::gear::cut_chips::ChipResult;
use crate::plan::gear::cut_contact::{ContactSummary, CutContact};
use crate::plan::gear::cut_flank::{CutFlankResult, DeviationMap, DeviationStatistics};
use crate::plan::gear::cut_mesh::CutMesh;
use crate::plan::gear_limits::MEMBERS;
use crate::scene::cut_file::CutFile;

/// Suffixes of the figures.
pub const FIGURES: [&str; 4] = ["", "causes", "profile", "blades"];

/// A cut with what it leaves.
pub struct CutReport<'a> {
    /// The file.
    pub file: &'a CutFile,
    /// The result.
    pub result: CutResult,
}

impl Presentation for CutReport<'_> {
    fn provenance(&self) -> Provenance<'_> {
        let result = &self.result;
        Provenance::of_plan(&self.file.sources, &result.plan, &result.diagnostics)
    }

    fn body(&self) -> Result<Value, Error> {
        let flanks: Vec<Value> = self.result.flanks.iter().map(flank_json).collect();
        Ok(json!({
            "title": self.file.bevel.title,
            "kind": "bevel",
            "cut": {
                "flanks": flanks,
                "contact": self.result.contact.as_ref().map(contact_json),
                "chips": self.chips().map(chips_json).collect::<Vec<_>>(),
            },
        }))
    }

    fn text(&self) -> String {
        let mut text = title_lines(&self.file.bevel.title);
        text += &scallop_table(&self.result.flanks).text();
        text += &format!("\n{}", cause_table(&self.result.flanks).text());
        if let Some(contact) = &self.result.contact {
            text += &format!("\n{}", contact_table(contact).text());
            if !contact.meshes.is_empty() {
                text += &format!("\n{}", mesh_table(&contact.meshes).text());
            }
        }
        if self.chips().next().is_some() {
            text += &format!("\n{}", chip_summary(self.chips()).text());
        }
        text
    }

    /// The profiles at the middle of the face.
    fn table(&self) -> Table<'_> {
        let mut table =
            Table::named("member|side|distance from root [mm]|regular blades [µm]|all causes [µm]");
        for flank in &self.result.flanks {
            let [regular, all] = &flank.profile.curves;
            for (k, place) in flank.profile.distances.iter().enumerate() {
                let shown = |d: Option<f64>| d.map_or(String::new(), |d| decimal(1e6 * d));
                table.row([
                    MEMBERS[flank.member].to_string(),
                    SIDES[flank.side].to_string(),
                    decimal(1e3 * place),
                    shown(regular[k]),
                    shown(all[k]),
                ]);
            }
        }
        table
    }

    fn notes(&self) -> String {
        step_lines(steps(&self.result.plan))
    }

    fn views(&self) -> Vec<View> {
        vec![cut_view(self.file, &self.result.flanks)]
    }

    fn figures(&self) -> Result<Vec<Figure>, Error> {
        let (title, flanks) = (&self.file.bevel.title, &self.result.flanks);
        let mut all = vec![Figure::first(gear_cut_plot::draw_flanks(title, flanks))];
        if let Some(first) = flanks.first() {
            all.push(Figure::new(
                "causes",
                gear_cut_plot::draw_causes(title, first),
            ));
        }
        all.push(Figure::new(
            "profile",
            gear_cut_plot::profiles(title, flanks),
        ));
        all.push(Figure::new(
            "blades",
            gear_cut_plot::blade_shares(title, flanks),
        ));
        Ok(all)
    }
}

impl CutReport<'_> {
    /// Nodes of the cut flanks with their deviations.
    pub fn nodes(&self) -> Table<'static> {
        let mut table = Table::named(
            "member|side|row|column|x [mm]|y [mm]|z [mm]|n_x|n_y|n_z|cause|deviation [µm]|blade",
        );
        for flank in &self.result.flanks {
            for cause in &flank.causes {
                let nodes = flank.grid.nodes.iter().zip(&cause.cuts).enumerate();
                for (k, (node, cut)) in nodes {
                    let (Some(node), Some(cut)) = (node, cut) else {
                        continue;
                    };
                    let (r, n) = (node.point.point.coordinates, node.point.normal.components);
                    let mut cells = vec![
                        MEMBERS[flank.member].to_string(),
                        SIDES[flank.side].to_string(),
                        (k / flank.grid.columns + 1).to_string(),
                        (k % flank.grid.columns + 1).to_string(),
                    ];
                    cells.extend((r * 1e3).array().map(decimal));
                    cells.extend(n.array().map(decimal));
                    cells.push(cause.name.clone());
                    cells.push(decimal(1e6 * cut.deviation));
                    cells.push((cut.blade + 1).to_string());
                    table.row(cells);
                }
            }
        }
        table
    }

    /// Members with chips.
    fn chips(&self) -> impl Iterator<Item = &ChipResult> {
        self.result.chips.iter().flatten()
    }

    /// The chips of the only member that has some, as a face-mill load reads them.
    pub fn chip_table(&self) -> Option<Table<'static>> {
        let mut members = self.chips();
        let (Some(found), None) = (members.next(), members.next()) else {
            return None;
        };
        let mut table = Table::numeric(
            "pass|blade|cradle [deg]|head [deg]|slot [deg]|area [mm²]|edge [mm]|thickness [mm]",
        );
        for place in &found.chips.places {
            let angles = [place.cradle, place.head, place.theta].map(f64::to_degrees);
            let chip = &place.chip;
            let mut cells = vec![place.pass.to_string(), (place.blade + 1).to_string()];
            cells.extend(angles.map(decimal));
            cells.push(decimal(1e6 * chip.area));
            cells.push(decimal(1e3 * chip.edge));
            cells.push(decimal(1e3 * chip.thickness()));
            table.row(cells);
        }
        Some(table)
    }

    /// The cut flanks with all causes as triangles.
    pub fn surfaces(&self) -> Vec<Solid> {
        let flanks = self.result.flanks.iter();
        flanks
            .filter_map(|f| Some(cut_surface(&f.grid, &f.causes.last()?.cuts)))
            .collect()
    }
}

fn micrometres(x: f64) -> String {
    format!("{:.4}", 1e6 * x)
}

fn place(statistics: &DeviationStatistics) -> String {
    let [face, height] = statistics.at;
    format!("{:.0}, {:.0}", 100.0 * face, 100.0 * height)
}

fn scallop_table(flanks: &[CutFlankResult]) -> Table<'static> {
    let mut table = Table::named(
        "scallops|Δx [deg]|by law, least [µm]|greatest [µm]|on rays, least [µm]|greatest [µm]|at face, height [%]|error of law [%]",
    );
    for flank in flanks {
        let ends = |map: &DeviationMap| {
            let shown = |of: fn(&DeviationStatistics) -> f64| {
                or_dash(map.statistics, |s| micrometres(of(&s)))
            };
            [shown(|s| s.lowest), shown(|s| s.highest)]
        };
        let ([a, b], [c, d]) = (ends(&flank.law), ends(&flank.scallops));
        table.row([
            flank_name(flank),
            format!("{:.4}", flank.feed.step().to_degrees()),
            a,
            b,
            c,
            d,
            or_dash(flank.scallops.statistics, |s| place(&s)),
            or_dash(flank.law_error, |e| format!("{:.3}", 100.0 * e)),
        ]);
    }
    table
}

fn cause_table(flanks: &[CutFlankResult]) -> Table<'static> {
    let mut table = Table::named(
        "deviation left|cause|lowest [µm]|highest [µm]|standard deviation [µm]|at face, height [%]|blades that finish",
    )
    .words(&[1]);
    for flank in flanks {
        for cause in &flank.causes {
            let shown = |of: fn(&DeviationStatistics) -> f64| {
                or_dash(cause.map.statistics, |s| micrometres(of(&s)))
            };
            let finish = cause.blade_shares.iter().filter(|s| **s > 0.0).count();
            table.row([
                flank_name(flank),
                cause.name.clone(),
                shown(|s| s.lowest),
                shown(|s| s.highest),
                shown(|s| s.std),
                or_dash(cause.map.statistics, |s| place(&s)),
                format!("{finish} of {}", cause.blade_shares.len()),
            ]);
        }
    }
    table
}

fn contact_table(contact: &CutContact) -> Table<'static> {
    let mut table = Table::named(
        "unloaded contact|TE, peak-to-peak [arcsec]|gear's face, height [%]|contact ratio",
    );
    let mut row = |name: &str, of: &ContactSummary| {
        table.row([
            name.to_string(),
            or_dash(of.peak_to_peak, |te| format!("{:.3}", ARCSEC * te)),
            or_dash(of.reference, |[f, h]| {
                format!("{:.2}, {:.2}", 100.0 * f, 100.0 * h)
            }),
            format!("{:.4}", of.contact_ratio),
        ]);
    };
    row("ideal flanks", &contact.ideal);
    if let Ok(changed) = &contact.changed {
        row("with errors of the chain", changed);
    }
    table.row([
        "crests of the scallops add at most".to_string(),
        format!("{:.3}", ARCSEC * contact.scallop_bound),
        "–".into(),
        "–".into(),
    ]);
    table
}

fn mesh_table(meshes: &[CutMesh]) -> Table<'static> {
    let mut table = Table::named(
        "mesh as cut|torque [N·m]|TE unloaded, peak-to-peak [arcsec]|loaded [arcsec]|pattern at pinion's face, height [%]",
    );
    for mesh in meshes {
        table.row([
            mesh.cause.clone().unwrap_or("ideal flanks".into()),
            or_dash(mesh.loaded, |l| four_digits(l.torque)),
            format!("{:.3}", ARCSEC * mesh.unloaded),
            or_dash(mesh.loaded, |l| format!("{:.3}", ARCSEC * l.peak_to_peak)),
            or_dash(mesh.loaded.and_then(|l| l.centre), |[f, h]| {
                format!("{:.2}, {:.2}", 100.0 * f, 100.0 * h)
            }),
        ]);
    }
    table
}

fn flank_json(flank: &CutFlankResult) -> Value {
    let causes: Vec<Value> = (flank.causes.iter())
        .map(|cause| {
            let mut map = map_json(&cause.map);
            map["cause"] = cause.name.clone().into();
            map["blade_shares"] = json!(cause.blade_shares);
            map
        })
        .collect();
    json!({
        "member": MEMBERS[flank.member],
        "side": SIDES[flank.side],
        "blades": flank.feed.blades,
        "cradle_deg_per_turn": flank.feed.cradle_per_turn.to_degrees(),
        "cradle_deg_per_blade": flank.feed.step().to_degrees(),
        "rows": flank.grid.rows,
        "columns": flank.grid.columns,
        "scallops_by_law": map_json(&flank.law),
        "scallops_on_rays": map_json(&flank.scallops),
        "law_error": flank.law_error,
        "causes": causes,
    })
}

fn map_json(map: &DeviationMap) -> Value {
    let of = |value: fn(&DeviationStatistics) -> f64| map.statistics.map(|s| 1e6 * value(&s));
    let deviations = map.deviations.iter().map(|d| d.map(|d| 1e6 * d));
    json!({
        "lowest_um": of(|s| s.lowest),
        "highest_um": of(|s| s.highest),
        "standard_deviation_um": of(|s| s.std),
        "highest_at": map.statistics.map(|s| json!({ "face": s.at[0], "height": s.at[1] })),
        "deviations_um": deviations.collect::<Vec<_>>(),
    })
}

fn contact_json(contact: &CutContact) -> Value {
    let summary = |of: &ContactSummary| {
        json!({
            "peak_to_peak_arcsec": of.peak_to_peak.map(|te| ARCSEC * te),
            "reference_gear": of.reference.map(|[face, height]| json!({ "face": face, "height": height })),
            "contact_ratio": of.contact_ratio,
        })
    };
    json!({
        "ideal": summary(&contact.ideal),
        "with_chain_errors": contact.changed.as_ref().ok().map(summary),
        "scallop_bound_arcsec": ARCSEC * contact.scallop_bound,
        "meshes": contact.meshes.iter().map(mesh_json).collect::<Vec<_>>(),
    })
}

fn mesh_json(mesh: &CutMesh) -> Value {
    let centre = mesh.loaded.and_then(|l| l.centre);
    json!({
        "cause": mesh.cause,
        "unloaded_te_arcsec": ARCSEC * mesh.unloaded,
        "torque_nm": mesh.loaded.map(|l| l.torque),
        "loaded_te_arcsec": mesh.loaded.map(|l| ARCSEC * l.peak_to_peak),
        "centre": centre.map(|[face, height]| json!({ "face": face, "height": height })),
    })
}

fn chip_summary<'a>(chips: impl Iterator<Item = &'a ChipResult>) -> Table<'static> {
    let mut table = Table::named(
        "chips|passes|cradle from [deg]|to [deg]|maximum area [mm²]|edge there [mm]|mean thickness there [mm]|volume [mm³]",
    );
    for result in chips {
        let (Some(greatest), Some(roll)) = (result.greatest(), result.roll()) else {
            continue;
        };
        let chip = &greatest.chip;
        table.row([
            MEMBERS[result.member].to_string(),
            result.chips.passes.to_string(),
            format!("{:.3}", roll[0].to_degrees()),
            format!("{:.3}", roll[1].to_degrees()),
            format!("{:.4}", 1e6 * chip.area),
            format!("{:.3}", 1e3 * chip.edge),
            format!("{:.4}", 1e3 * chip.thickness()),
            format!("{:.1}", 1e9 * result.chips.volume),
        ]);
    }
    table
}

fn chips_json(result: &ChipResult) -> Value {
    let greatest = result.greatest().map(|place| {
        json!({
            "area_mm2": 1e6 * place.chip.area,
            "edge_mm": 1e3 * place.chip.edge,
            "thickness_mm": 1e3 * place.chip.thickness(),
            "cradle_deg": place.cradle.to_degrees(),
            "slot_deg": place.theta.to_degrees(),
        })
    });
    json!({
        "member": MEMBERS[result.member],
        "passes": result.chips.passes,
        "cradle_deg": result.roll().map(|roll| roll.map(f64::to_degrees)),
        "greatest": greatest,
        "volume_mm3": 1e9 * result.chips.volume,
    })
}
