//! What was found while a motion ran, as tables and JSON.

use serde_json::{Map, Value, json};

use super::encoders;
use super::encoders_table;
use super::motion::key;
use super::number::brief;
use super::table::{finish, plain, right_but_first};
use crate::plan::motion::scene::MotionScene;
use crate::plan::on_the_fly::Found;
use crate::spectrum::peaks::{PeakOptions, peaks};
use crate::spectrum::rotation::demodulation::Tracks;
use crate::spectrum::spectra::Spectra;

/// Peaks shown of an output.
const ROWS: usize = 5;

/// Everything found.
pub fn text(scene: &MotionScene, found: &Found) -> String {
    let mut text = String::new();
    if let Some(spectra) = &found.spectra {
        text += &lines(scene, spectra);
    }
    if let Some((node, tracks)) = &found.tracks {
        text += &orders(scene, node, tracks);
    }
    if let Some((record, _)) = &found.te {
        text += &format!("\n{}", encoders_table::record(record, false));
    }
    text
}

/// Puts what was found into the document of the motion.
pub fn extend(document: &mut Value, scene: &MotionScene, found: &Found) {
    let Some(document) = document.as_object_mut() else {
        return;
    };
    if let Some(spectra) = &found.spectra {
        document.insert("spectra".into(), spectra_json(scene, spectra));
    }
    if let Some((node, tracks)) = &found.tracks {
        document.insert("orders".into(), orders_json(scene, node, tracks));
    }
    if let Some((record, teeth)) = &found.te {
        let mut te = encoders::json(record, teeth, &[]);
        if let Some(te) = te.as_object_mut() {
            te.remove("geardyn");
            te.remove("repairs");
        }
        document.insert("transmission_error".into(), te);
    }
}

fn lines(scene: &MotionScene, spectra: &Spectra) -> String {
    let mut table = plain();
    table.set_header(["peaks of", "unit", "Hz", "amplitude", "above the floor"]);
    for (at, output) in scene.outputs.list.iter().enumerate() {
        for peak in peaks(spectra, at, &PeakOptions::default())
            .iter()
            .take(ROWS)
        {
            let numbers = [peak.frequency_hz, peak.amplitude, peak.signal_to_noise];
            let row = [output.name.clone(), output.unit.to_string()];
            table.add_row(row.into_iter().chain(numbers.map(brief)));
        }
    }
    let head = format!(
        "\n{} blocks, lines {} Hz apart\n",
        spectra.blocks,
        brief(spectra.frequency_hz.get(1).copied().unwrap_or(0.0))
    );
    match table.row_count() {
        0 => format!("{head}no peak stands above its floor\n"),
        _ => {
            right_but_first(&mut table);
            head + &finish(&table)
        }
    }
}

fn orders(scene: &MotionScene, node: &str, tracks: &Tracks) -> String {
    let mut table = plain();
    table.set_header([
        "order of",
        "order",
        "unit",
        "least",
        "greatest",
        "there rad/s",
        "phase deg",
    ]);
    for (channel, output) in scene.outputs.list.iter().enumerate() {
        for (at, order) in tracks.orders.iter().enumerate() {
            let size =
                |p: &&crate::spectrum::rotation::demodulation::Point| p.values[channel][at].norm();
            let by = |a: &&_, b: &&_| size(a).total_cmp(&size(b));
            let least = tracks.points.iter().min_by(by);
            let (Some(least), Some(most)) = (least, tracks.points.iter().max_by(by)) else {
                continue;
            };
            let value = most.values[channel][at];
            let numbers = [
                size(&least),
                value.norm(),
                most.speed,
                value.arg().to_degrees(),
            ];
            let row = [output.name.clone(), brief(*order), output.unit.to_string()];
            table.add_row(row.into_iter().chain(numbers.map(brief)));
        }
    }
    let head = format!(
        "\norders of {node}: {} points, each over {} turns\n",
        tracks.points.len(),
        brief(tracks.turns)
    );
    match table.row_count() {
        0 => head,
        _ => {
            right_but_first(&mut table);
            head + &finish(&table)
        }
    }
}

fn spectra_json(scene: &MotionScene, spectra: &Spectra) -> Value {
    let (mut densities, mut tops) = (Map::new(), Map::new());
    for (at, output) in scene.outputs.list.iter().enumerate() {
        densities.insert(key(output), json!(spectra.psd[at]));
        let found = peaks(spectra, at, &PeakOptions::default());
        let found = found.iter().map(|p| {
            json!({
                "frequency_hz": p.frequency_hz, "amplitude": p.amplitude, "density": p.psd,
                "signal_to_noise": p.signal_to_noise,
            })
        });
        tops.insert(key(output), found.collect());
    }
    json!({
        "rate_hz": spectra.rate_hz, "blocks": spectra.blocks, "bandwidth_hz": spectra.bandwidth_hz,
        "frequency_hz": spectra.frequency_hz, "density": densities, "peaks": tops,
    })
}

fn orders_json(scene: &MotionScene, node: &str, tracks: &Tracks) -> Value {
    let of_order = |(at, order): (usize, &f64)| {
        let (mut sizes, mut phases) = (Map::new(), Map::new());
        for (channel, output) in scene.outputs.list.iter().enumerate() {
            let values = tracks.points.iter().map(|p| p.values[channel][at]);
            let (size, phase): (Vec<f64>, Vec<f64>) = values.map(|z| (z.norm(), z.arg())).unzip();
            sizes.insert(key(output), json!(size));
            phases.insert(key(output), json!(phase));
        }
        json!({ "order": order, "amplitude": sizes, "phase_rad": phases })
    };
    json!({
        "node": node,
        "turns": tracks.turns,
        "time_s": tracks.points.iter().map(|p| p.time_s).collect::<Vec<_>>(),
        "speed_rad_s": tracks.points.iter().map(|p| p.speed).collect::<Vec<_>>(),
        "orders": tracks.orders.iter().enumerate().map(of_order).collect::<Vec<_>>(),
        "windows_left_out": tracks.coarse,
    })
}
