//! The view of deviations over flanks as surfaces in space.

use std::sync::Arc;

use serde_json::{Value, json};

use super::bevel_plot::Flat;
use super::gear_cut_plot::flank_name;
use super::view::{View, ViewKind};
use super::work::work_flank_name;
use crate::gear::bevel::tooth_section::ToothSection;
use crate::gear::contact::ease_off::EaseOff;
use crate::numeric::statistics::extremes;
use crate::plan::gear::cut_flank::CutFlankResult;
use crate::plan::meshes::work::WorkResult;
use crate::scene::cut_file::CutFile;

/// Steps in the range of a surface: finer than a picture shows.
const STEPS: f64 = 500.0;

/// The flanks of a cut for each cause, all causes of a flank first.
pub fn cut_view(file: &CutFile, flanks: &[CutFlankResult]) -> View {
    let of_flank = |flank: &CutFlankResult| -> Vec<Value> {
        let section = &file.bevel.members[flank.member].section;
        let size = [flank.grid.rows, flank.grid.columns];
        let causes = flank.causes.iter().rev();
        let surface = |(name, values): (&str, &[Option<f64>])| {
            surface([&flank_name(flank), name], section, size, values)
        };
        causes
            .map(|c| surface((&c.name, &c.map.deviations)))
            .collect()
    };
    View {
        kind: ViewKind::Surface,
        title: "Deviations of the cut flanks".into(),
        replaces: &["", "causes"],
        data: json!({
            "heads": ["flank", "cause"],
            "quantity": "deviation from the ideal flank, out of the metal",
            "surfaces": flanks.iter().flat_map(of_flank).collect::<Vec<_>>(),
        }),
    }
}

/// The flanks that generators cut with the errors of their rolls.
pub fn work_view(works: &[Arc<WorkResult>]) -> View {
    let surface = |work: &Arc<WorkResult>| {
        let pair = &work.pair;
        let name = work_flank_name(work);
        let names = [name.as_str(), work.generator.as_str()];
        surface(names, &pair.flank.section, pair.grid, &pair.surplus)
    };
    View {
        kind: ViewKind::Surface,
        title: "Error of the cut flank".into(),
        replaces: &["flank"],
        data: json!({
            "heads": ["flank", "cut on"],
            "quantity": "surplus over the ideal flank, out of the metal",
            "surfaces": works.iter().map(surface).collect::<Vec<_>>(),
        }),
    }
}

/// The ease-off of a pinion.
pub fn ease_off_view(section: &ToothSection, grid: &EaseOff) -> View {
    let size = [grid.rows, grid.columns];
    View {
        kind: ViewKind::Surface,
        title: "Ease-off".into(),
        replaces: &["ease-off"],
        data: json!({
            "heads": ["flank", "reference"],
            "quantity": "gap of the cut pinion from the pinion conjugate to the gear, along its normals",
            "surfaces": [surface(["pinion", "conjugate pinion"], section, size, &grid.gaps)],
        }),
    }
}

/// One surface: its names, the corners of its flank in the plane, values in µm row by row from the root.
fn surface(
    names: [&str; 2],
    section: &ToothSection,
    [rows, columns]: [usize; 2],
    values: &[Option<f64>],
) -> Value {
    let known = || values.iter().flatten().map(|v| 1e6 * v);
    let (low, high) = extremes(known());
    // Multiples of a power of two have few digits to store.
    let step = ((high - low).max(f64::MIN_POSITIVE) / STEPS)
        .log2()
        .floor()
        .exp2();
    let rounded = values
        .iter()
        .map(|v| v.map(|v| (1e6 * v / step).round() * step));
    json!({
        "names": names,
        "rows": rows,
        "columns": columns,
        "corners_m": Flat::of(section).corners(),
        "lowest_um": low,
        "highest_um": high,
        "values_um": rounded.collect::<Vec<_>>(),
    })
}
