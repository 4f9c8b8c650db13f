//! Work of a generator: order lines as surplus of the flank and as transmission error of the cut pair.

use serde_json::{Value, json};

use super::number_format::{four_digits, significant, with_minus_signs};
use super::table::Table;
use super::te_lines::ARCSEC;
use crate::base::text::pluralise;
use crate::gear::bevel::tooth::SIDES;
use crate::numeric::sorting::sort_descending;
use crate::plan::gear_limits::MEMBERS;
use crate::plan::meshes::work::{LEFT_OUT, WorkLine, WorkResult};

/// Lines shown: the largest on the flank.
const MOST_ROWS: usize = 12;

/// The largest lines, the flank, the pair, and what is left out.
pub fn text(work: &WorkResult, all: bool) -> String {
    let pair = &work.pair;
    let mut shown: Vec<&WorkLine> = work.lines.iter().collect();
    sort_descending(&mut shown, |a| a.effect.flank);
    if !all {
        shown.truncate(MOST_ROWS);
    }
    shown.sort_by(|a, b| a.order.cmp(&b.order));
    let [output, cradle] = &work.nodes;
    let mut text = format!(
        "\n{} flank of the {} of {}\ncut on: {}\nErrors of {output} against {cradle}; flank and pair: the largest over the phase.\n\n",
        SIDES[pair.side],
        MEMBERS[pair.member],
        file_name(&work.file),
        work.generator,
    );
    let mut table =
        Table::new("order|source|cause|roll [arcsec]|flank [µm]|pair [arcsec]|").words(&[1, 2, 6]);
    for line in &shown {
        let order = match line.order.is_integer() {
            true => line.order.to_string(),
            false => significant(line.order.to_f64()),
        };
        let cause = match line.harmonic {
            1 => line.cause.to_string(),
            n => format!("{}, order {n}", line.cause),
        };
        table.row(vec![
            order,
            line.source.clone(),
            cause,
            four_digits(ARCSEC * line.amplitude),
            four_digits(1e6 * line.effect.flank),
            four_digits(ARCSEC * line.effect.te),
            if line.effect.is_smooth {
                ""
            } else {
                "first order alone"
            }
            .into(),
        ]);
    }
    text += &table.text();
    if shown.len() < work.lines.len() {
        text += &format!(
            "{} smaller lines are not shown; --all shows them\n",
            work.lines.len() - shown.len()
        );
    }
    let [low, high] = pair.surplus_range();
    let [rows, columns] = pair.grid;
    let smooth = work.lines.iter().filter(|l| l.effect.is_smooth).count();
    text += &format!(
        "\nflank: {} to {} µm on {rows} × {columns} nodes, exact envelope of {} with phases as declared (first order off by up to {} µm)\n",
        four_digits(1e6 * low),
        four_digits(1e6 * high),
        pluralise(smooth, "line"),
        four_digits(1e6 * pair.first_order_error),
    );
    let ranges = |[ideal, cut]: [f64; 2]| {
        format!(
            "{} arcsec peak to peak as designed, {} as cut",
            four_digits(ARCSEC * ideal),
            four_digits(ARCSEC * cut)
        )
    };
    text += &format!("pair without load: {}\n", ranges(pair.peak_to_peak));
    if let Some(load) = &pair.loaded {
        text += &format!(
            "pair at {} N·m of the pinion: {}\n",
            four_digits(load.torque),
            ranges(load.peak_to_peak)
        );
    }
    if let Ok(blades) = &pair.blades {
        text += &format!(
            "blades of [cut]: {}, {} deg of the cradle apart, scallops up to {} µm\nwith the offsets of the blades, largest over the phase: {} µm on the flank, {} arcsec peak to peak in the pair\n",
            blades.feed.blades,
            four_digits(blades.feed.step().to_degrees()),
            four_digits(1e6 * blades.scallop),
            four_digits(1e6 * blades.flank_range),
            four_digits(ARCSEC * blades.te_peak_to_peak),
        );
    }
    text += &format!("left out: {}\n", left_out(work).join("; "));
    with_minus_signs(&text)
}

/// Name of the flank that is cut: member, side and file.
pub fn work_flank_name(work: &WorkResult) -> String {
    let (member, side) = (MEMBERS[work.pair.member], SIDES[work.pair.side]);
    format!("{member} {side} of {}", file_name(&work.file))
}

fn file_name(path: &str) -> &str {
    path.rsplit('/').next().unwrap_or(path)
}

/// Neglected effects, in words.
fn left_out(work: &WorkResult) -> Vec<String> {
    let rough: Vec<&WorkLine> = (work.lines.iter())
        .filter(|l| !l.effect.is_smooth)
        .collect();
    let most = rough.iter().map(|l| l.effect.flank).sum::<f64>();
    let waves = (!rough.is_empty()).then(|| {
        format!(
            "{} of orders so high that passes of the cutter overlap: to first order at most {} µm together",
            pluralise(rough.len(), "line"),
            four_digits(1e6 * most)
        )
    });
    let blades = match &work.pair.blades {
        Ok(_) => {
            "discrete blades with their run-out in the cut pair: their phase differs from tooth to tooth".to_string()
        }
        Err(why) => format!("discrete blades with their run-out, size not computed: {why}"),
    };
    let always = LEFT_OUT.iter().map(ToString::to_string);
    waves.into_iter().chain([blades]).chain(always).collect()
}

/// The document.
pub fn json(work: &WorkResult) -> Value {
    let pair = &work.pair;
    let line = |line: &WorkLine| {
        json!({
            "order": line.order.to_string(),
            "order_value": line.order.to_f64(),
            "source": line.source,
            "cause": line.cause,
            "harmonic": line.harmonic,
            "roll_arcsec": ARCSEC * line.amplitude,
            "flank_um": 1e6 * line.effect.flank,
            "te_peak_to_peak_arcsec": ARCSEC * line.effect.te,
            "in_envelope": line.effect.is_smooth,
        })
    };
    let [rows, columns] = pair.grid;
    let ranges = |[ideal, cut]: [f64; 2]| json!({ "ideal": ARCSEC * ideal, "cut": ARCSEC * cut });
    let um = |x: &Option<f64>| x.map(|x| 1e6 * x);
    json!({
        "generator": work.generator,
        "gear": work.file,
        "member": MEMBERS[pair.member],
        "flank": SIDES[pair.side],
        "work": work.nodes[0],
        "cradle": work.nodes[1],
        "lines": work.lines.iter().map(line).collect::<Vec<_>>(),
        "rows": rows,
        "columns": columns,
        "surplus_um": pair.surplus.iter().map(um).collect::<Vec<_>>(),
        "first_order_error_um": 1e6 * pair.first_order_error,
        "te_peak_to_peak_arcsec": ranges(pair.peak_to_peak),
        "torque_nm": pair.loaded.map(|load| load.torque),
        "loaded_te_peak_to_peak_arcsec": pair.loaded.map(|load| ranges(load.peak_to_peak)),
        "blades": pair.blades.ok().map(|blades| json!({
            "blades": blades.feed.blades,
            "cradle_deg_per_blade": blades.feed.step().to_degrees(),
            "scallop_um": 1e6 * blades.scallop,
            "flank_um": 1e6 * blades.flank_range,
            "te_peak_to_peak_arcsec": ARCSEC * blades.te_peak_to_peak,
        })),
        "left_out": left_out(work),
    })
}
