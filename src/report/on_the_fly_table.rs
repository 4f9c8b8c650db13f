//! What was found while a motion ran, as tables.

use super::encoders_table;
use super::number::brief;
use super::table::{finish, plain, right_but_first};
use crate::plan::motion::scene::MotionScene;
use crate::plan::on_the_fly::Found;
use crate::spectrum::peaks::{PeakOptions, peaks};
use crate::spectrum::rotation::demodulation::{Point, Tracks};
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
            let size = |p: &&Point| p.values[channel][at].norm();
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
