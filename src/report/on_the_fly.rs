//! What was found while a motion ran, as JSON.

use serde_json::{Map, Value, json};

use super::encoders;
use super::motion::key;
use crate::plan::motion::scene::MotionScene;
use crate::plan::on_the_fly::Found;
use crate::spectrum::peaks::{PeakOptions, peaks};
use crate::spectrum::rotation::demodulation::Tracks;
use crate::spectrum::spectra::Spectra;

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
