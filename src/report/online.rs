//! Online results of a simulation (spectra, orders, transmission error) in the document and as tables.

use serde_json::{Map, Value, json};

use super::encoder_te;
use super::encoder_te_table;
use super::json::warnings;
use super::number_format::four_digits;
use super::output_key::key;
use super::presentation::step_times;
use super::table::Table;
use crate::plan::motion::simulation_setup::SimulationSetup;
use crate::plan::online::OnlineResult;
use crate::spectrum::peaks::{PeakOptions, find_peaks};
use crate::spectrum::rotation::order_demodulation::{DemodulatedOrders, OrderPoint};
use crate::spectrum::spectra::Spectra;

/// Puts what was found into the document of the motion.
pub fn extend(document: &mut Value, setup: &SimulationSetup, result: &OnlineResult) {
    let Some(document) = document.as_object_mut() else {
        return;
    };
    if let Some(spectra) = &result.spectra {
        document.insert("spectra".into(), spectra_json(setup, spectra));
    }
    if let Some((node, tracks)) = &result.tracks {
        document.insert("orders".into(), orders_json(setup, node, tracks));
    }
    if let Some((record, teeth)) = &result.te {
        let mut te = encoder_te::body(record, teeth);
        te["effort"] = step_times(record.trace.iter().copied());
        te["warnings"] = warnings(&record.diagnostics);
        document.insert("transmission_error".into(), te);
    }
}

fn spectra_json(setup: &SimulationSetup, spectra: &Spectra) -> Value {
    let (mut densities, mut tops) = (Map::new(), Map::new());
    for (at, output) in setup.outputs.list.iter().enumerate() {
        densities.insert(key(output), json!(spectra.psd[at]));
        let found = find_peaks(spectra, at, &PeakOptions::default());
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

fn orders_json(setup: &SimulationSetup, node: &str, tracks: &DemodulatedOrders) -> Value {
    let of_order = |(at, order): (usize, &f64)| {
        let (mut sizes, mut phases) = (Map::new(), Map::new());
        for (channel, output) in setup.outputs.list.iter().enumerate() {
            let values = tracks.points.iter().map(|p| p.values[channel][at]);
            let (size, phase): (Vec<f64>, Vec<f64>) = values.map(|z| (z.norm(), z.arg())).unzip();
            sizes.insert(key(output), json!(size));
            phases.insert(key(output), json!(phase));
        }
        json!({ "order": order, "amplitude": sizes, "phase_rad": phases })
    };
    json!({
        "node": node,
        "turns": tracks.revolutions,
        "time_s": tracks.points.iter().map(|p| p.time_s).collect::<Vec<_>>(),
        "speed_rad_s": tracks.points.iter().map(|p| p.speed).collect::<Vec<_>>(),
        "orders": tracks.orders.iter().enumerate().map(of_order).collect::<Vec<_>>(),
        "windows_left_out": tracks.skipped_windows,
    })
}

/// Peaks shown of an output.
const MAX_ROWS: usize = 5;

/// Everything found.
pub fn text(setup: &SimulationSetup, result: &OnlineResult) -> String {
    let mut text = String::new();
    if let Some(spectra) = &result.spectra {
        text += &lines(setup, spectra);
    }
    if let Some((node, tracks)) = &result.tracks {
        text += &orders(setup, node, tracks);
    }
    if let Some((record, _)) = &result.te {
        text += &format!("\n{}", encoder_te_table::record(record, false));
    }
    text
}

fn lines(setup: &SimulationSetup, spectra: &Spectra) -> String {
    let mut table = Table::named("peaks of|unit|Hz|amplitude|above the floor");
    for (at, output) in setup.outputs.list.iter().enumerate() {
        for peak in find_peaks(spectra, at, &PeakOptions::default())
            .iter()
            .take(MAX_ROWS)
        {
            let numbers = [peak.frequency_hz, peak.amplitude, peak.signal_to_noise];
            let row = [output.name.clone(), output.unit.to_string()];
            table.row(row.into_iter().chain(numbers.map(four_digits)));
        }
    }
    let head = format!(
        "\n{} blocks, lines {} Hz apart\n",
        spectra.blocks,
        four_digits(spectra.frequency_hz.get(1).copied().unwrap_or(0.0))
    );
    match table.row_count() {
        0 => format!("{head}no peak exceeds its floor\n"),
        _ => head + &table.text(),
    }
}

fn orders(setup: &SimulationSetup, node: &str, tracks: &DemodulatedOrders) -> String {
    let mut table = Table::named("order of|order|unit|least|greatest|there rad/s|phase deg");
    for (channel, output) in setup.outputs.list.iter().enumerate() {
        for (at, order) in tracks.orders.iter().enumerate() {
            let size = |p: &&OrderPoint| p.values[channel][at].norm();
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
            let row = [
                output.name.clone(),
                four_digits(*order),
                output.unit.to_string(),
            ];
            table.row(row.into_iter().chain(numbers.map(four_digits)));
        }
    }
    let head = format!(
        "\norders of {node}: {} points, each over {} turns\n",
        tracks.points.len(),
        four_digits(tracks.revolutions)
    );
    match table.row_count() {
        0 => head,
        _ => head + &table.text(),
    }
}
