//! Results of the online analysis of a motion, as tables.

use super::encoder_te_table;
use super::modes_table::{finish, plain, right_but_first};
use super::number_format::four_digits;
use crate::plan::motion::simulation_setup::SimulationSetup;
use crate::plan::online::OnlineResult;
use crate::spectrum::peaks::{PeakOptions, find_peaks};
use crate::spectrum::rotation::order_demodulation::{DemodulatedOrders, OrderPoint};
use crate::spectrum::spectra::Spectra;

/// Peaks shown of an output.
const MAX_ROWS: usize = 5;

/// Everything found.
pub fn text(scene: &SimulationSetup, result: &OnlineResult) -> String {
    let mut text = String::new();
    if let Some(spectra) = &result.spectra {
        text += &lines(scene, spectra);
    }
    if let Some((node, tracks)) = &result.tracks {
        text += &orders(scene, node, tracks);
    }
    if let Some((record, _)) = &result.te {
        text += &format!("\n{}", encoder_te_table::record(record, false));
    }
    text
}

fn lines(scene: &SimulationSetup, spectra: &Spectra) -> String {
    let mut table = plain();
    table.set_header(["peaks of", "unit", "Hz", "amplitude", "above the floor"]);
    for (at, output) in scene.outputs.list.iter().enumerate() {
        for peak in find_peaks(spectra, at, &PeakOptions::default())
            .iter()
            .take(MAX_ROWS)
        {
            let numbers = [peak.frequency_hz, peak.amplitude, peak.signal_to_noise];
            let row = [output.name.clone(), output.unit.to_string()];
            table.add_row(row.into_iter().chain(numbers.map(four_digits)));
        }
    }
    let head = format!(
        "\n{} blocks, lines {} Hz apart\n",
        spectra.blocks,
        four_digits(spectra.frequency_hz.get(1).copied().unwrap_or(0.0))
    );
    match table.row_count() {
        0 => format!("{head}no peak stands above its floor\n"),
        _ => {
            right_but_first(&mut table);
            head + &finish(&table)
        }
    }
}

fn orders(scene: &SimulationSetup, node: &str, tracks: &DemodulatedOrders) -> String {
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
            table.add_row(row.into_iter().chain(numbers.map(four_digits)));
        }
    }
    let head = format!(
        "\norders of {node}: {} points, each over {} turns\n",
        tracks.points.len(),
        four_digits(tracks.revolutions)
    );
    match table.row_count() {
        0 => head,
        _ => {
            right_but_first(&mut table);
            head + &finish(&table)
        }
    }
}
