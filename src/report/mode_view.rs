//! The view of modes: the drive train, and shapes and strain energies as flat lists.

use serde_json::{Value, json};

use super::mode_text::dominant_elements_text;
use super::modes_table::damping;
use super::train::train;
use super::view::{View, ViewKind};
use crate::machine::components::Machine;
use crate::plan::modes_run::ModesResult;
use crate::plan::prepared_machine::PreparedMachine;
use crate::scene::model::Model;

/// Nodes of a train that are drawn at most: the names of more cannot be read.
pub const MAX_NODES: usize = 60;

/// The view of the modes of a machine, with one mode shown at first by its index.
pub fn mode_view(
    prepared: &PreparedMachine,
    result: &ModesResult,
    model: &Model,
    first: usize,
) -> View {
    let machine = &prepared.machine;
    let train = train(prepared, model);
    let entry = |k: usize| {
        let mode = &result.modes[k];
        let swings = mode.rigid || mode.is_oscillatory();
        json!({
            "mode": k + 1,
            "frequency_hz": swings.then(|| mode.frequency_hz()),
            "damping_ratio": damping(result, k),
            "rigid": mode.rigid,
            "dominant": dominant_elements_text(machine, mode, &result.energies[k]),
        })
    };
    let shapes = || result.modes.iter().flat_map(|m| &m.shape);
    let imaginary: Vec<f64> = match result.complex {
        true => shapes().map(|z| z.im).collect(),
        false => Vec::new(),
    };
    let strain: Vec<f64> = (0..result.modes.len())
        .flat_map(|k| link_shares(machine, result, k, &train["links"]))
        .collect();
    View {
        kind: ViewKind::Modes,
        title: "Mode shapes".into(),
        replaces: &[],
        data: json!({
            "first": first,
            "modes": (0..result.modes.len()).map(entry).collect::<Vec<_>>(),
            "real": shapes().map(|z| z.re).collect::<Vec<_>>(),
            "imaginary": imaginary,
            "strain": strain,
            "train": train,
        }),
    }
}

/// The share of the strain energy of a mode in each link: that of its element, evenly over the links of one element.
fn link_shares(machine: &Machine, result: &ModesResult, k: usize, links: &Value) -> Vec<f64> {
    let names = || {
        links
            .as_array()
            .into_iter()
            .flatten()
            .map(|l| &l["element"])
    };
    let strain = result.energies[k].strain.as_deref().unwrap_or_default();
    let share = |name: &Value| {
        let own = strain.iter().find(|s| *name == machine.elements[s.0].name);
        let count = names().filter(|other| *other == name).count();
        own.map_or(0.0, |s| s.1 / count as f64)
    };
    names().map(share).collect()
}
