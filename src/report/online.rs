//! Online results of a simulation (spectra, orders, TE) as JSON.

use serde_json::{Map, Value, json};

use super::encoder_te;
use super::simulation::key;
use crate::plan::motion::simulation_setup::SimulationSetup;
use crate::plan::online::OnlineResult;
use crate::spectrum::peaks::{PeakOptions, find_peaks};
use crate::spectrum::rotation::order_demodulation::DemodulatedOrders;
use crate::spectrum::spectra::Spectra;

/// Puts what was found into the document of the motion.
pub fn extend(document: &mut Value, scene: &SimulationSetup, result: &OnlineResult) {
    let Some(document) = document.as_object_mut() else {
        return;
    };
    if let Some(spectra) = &result.spectra {
        document.insert("spectra".into(), spectra_json(scene, spectra));
    }
    if let Some((node, tracks)) = &result.tracks {
        document.insert("orders".into(), orders_json(scene, node, tracks));
    }
    if let Some((record, teeth)) = &result.te {
        let mut te = encoder_te::json(record, teeth, &[]);
        if let Some(te) = te.as_object_mut() {
            te.remove("geardyn");
            te.remove("repairs");
        }
        document.insert("transmission_error".into(), te);
    }
}

fn spectra_json(scene: &SimulationSetup, spectra: &Spectra) -> Value {
    let (mut densities, mut tops) = (Map::new(), Map::new());
    for (at, output) in scene.outputs.list.iter().enumerate() {
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

fn orders_json(scene: &SimulationSetup, node: &str, tracks: &DemodulatedOrders) -> Value {
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
        "turns": tracks.revolutions,
        "time_s": tracks.points.iter().map(|p| p.time_s).collect::<Vec<_>>(),
        "speed_rad_s": tracks.points.iter().map(|p| p.speed).collect::<Vec<_>>(),
        "orders": tracks.orders.iter().enumerate().map(of_order).collect::<Vec<_>>(),
        "windows_left_out": tracks.skipped_windows,
    })
}
