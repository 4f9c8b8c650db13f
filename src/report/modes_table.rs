//! Modes, crossings and the plan as terminal tables.

use comfy_table::presets::NOTHING;
use comfy_table::{CellAlignment, ContentArrangement, Table};

use super::campbell;
use super::mode_text::dominant_elements_text;
use super::number_format::{column, percent, significant, with_minus_signs};
use crate::machine::components::Machine;
use crate::modes::campbell::CampbellDiagram;
use crate::modes::mode::modulus;
use crate::modes::sensitivity::{FrequencySensitivity, SensitivityParameter};
use crate::plan::modes_run::ModesResult;
use crate::plan::prepared_machine::PreparedMachine;
use crate::plan::stages::StageDecision;

/// Rows of modes shown at once; the files hold all.
const MAX_ROWS: usize = 50;

/// One row a mode.
pub fn modes(machine: &PreparedMachine, result: &ModesResult) -> String {
    let shown = result.modes.len().min(MAX_ROWS);
    let frequencies: Vec<f64> = result.modes[..shown]
        .iter()
        .map(|m| m.frequency_hz())
        .collect();
    let damped = (0..shown).any(|k| damping(result, k).is_some());
    let decays = result.modes[..shown]
        .iter()
        .any(|m| !m.rigid && !m.is_oscillatory());
    let mut table = plain();
    let (mut heads, mut units) = (vec!["mode", "frequency"], vec!["", "Hz"]);
    if damped {
        heads.push(if result.complex {
            "damping"
        } else {
            "damping*"
        });
        units.push("%");
    }
    if decays {
        heads.push("time constant");
        units.push("s");
    }
    heads.push("mostly in");
    units.push("");
    table.add_row(heads);
    table.add_row(units);
    for (k, frequency) in column(&frequencies).into_iter().enumerate() {
        let mode = &result.modes[k];
        let swings = mode.rigid || mode.is_oscillatory();
        let mut row = vec![
            (k + 1).to_string(),
            if swings { frequency } else { "–".to_string() },
        ];
        if damped {
            row.push(damping(result, k).map_or("–".to_string(), percent));
        }
        if decays {
            row.push(if swings {
                "–".to_string()
            } else {
                significant(-1.0 / mode.eigenvalue.re)
            });
        }
        row.push(dominant_elements_text(
            &machine.machine,
            mode,
            &result.energies[k],
        ));
        table.add_row(row);
    }
    right_but_last(&mut table);
    let mut text = finish(&table);
    if result.modes.len() > shown {
        let more = result.modes.len() - shown;
        text += &format!("… and {more} more; --lowest N limits them, --csv and --json hold all\n");
    }
    if damped && !result.complex {
        text += "* from the losses of the undamped shape; --damped solves for it\n";
    }
    text
}

fn damping(result: &ModesResult, k: usize) -> Option<f64> {
    if result.complex {
        result.modes[k].damping_ratio
    } else {
        result.energies[k].estimated_damping_ratio
    }
}

/// Everything about one mode: where its energy is, what it depends on, its shape.
pub fn mode(prepared_machine: &PreparedMachine, result: &ModesResult, k: usize) -> String {
    let machine = &prepared_machine.machine;
    let (mode, energies) = (&result.modes[k], &result.energies[k]);
    let mut text = match mode.rigid || mode.is_oscillatory() {
        true => format!("mode {}: {:.9} Hz", k + 1, mode.frequency_hz()),
        false => format!(
            "mode {}: time constant {} s, does not swing",
            k + 1,
            significant(-1.0 / mode.eigenvalue.re)
        ),
    };
    if let Some(zeta) = damping(result, k) {
        text += &format!(", damping {} %", percent(zeta));
    }
    if mode.trusted_digits.is_finite() {
        text += &format!(
            ", {:.0} digits, residual {:.0e}",
            mode.trusted_digits.floor(),
            mode.residual
        );
    }
    text += "\n\n";
    let mut table = plain();
    table.add_row(vec![
        "element",
        "strain energy",
        "kinetic energy",
        "dissipation",
        "dω/ω per dk/k",
        "dω/ω per dJ/J",
    ]);
    table.add_row(vec!["", "%", "%", "%", "%/%", "%/%"]);
    let list = result
        .sensitivities
        .as_ref()
        .map(|all| all[k].as_slice())
        .unwrap_or_default();
    for element in rank_by_share(
        machine,
        [
            energies.strain.as_deref(),
            Some(&energies.kinetic),
            energies.dissipated.as_deref(),
        ],
    ) {
        let share = |shares: Option<&[(usize, f64)]>| {
            let found = shares.and_then(|s| s.iter().find(|s| s.0 == element));
            found.map_or("–".to_string(), |s| percent(s.1))
        };
        table.add_row(vec![
            machine.elements[element].name.clone(),
            share(energies.strain.as_deref()),
            share(Some(&energies.kinetic)),
            share(energies.dissipated.as_deref()),
            sensitivity(list, element, SensitivityParameter::Stiffness),
            sensitivity(list, element, SensitivityParameter::Inertia),
        ]);
    }
    right_but_first(&mut table);
    text += &finish(&table);
    text += "\n";
    text += &shape(machine, result, k);
    text
}

fn sensitivity(
    list: &[FrequencySensitivity],
    element: usize,
    parameter: SensitivityParameter,
) -> String {
    let found = list
        .iter()
        .find(|s| s.element == element && s.parameter == parameter);
    found.map_or("–".to_string(), |s| format!("{:.4}", s.relative))
}

/// Elements with a share above one in a thousand, the largest first.
fn rank_by_share(machine: &Machine, all: [Option<&[(usize, f64)]>; 3]) -> Vec<usize> {
    let mut largest = vec![0.0f64; machine.elements.len()];
    for &(element, share) in all.into_iter().flatten().flatten() {
        largest[element] = largest[element].max(share.abs());
    }
    let mut order: Vec<usize> = (0..largest.len()).filter(|&e| largest[e] >= 1e-3).collect();
    order.sort_by(|&a, &b| largest[b].total_cmp(&largest[a]));
    order
}

/// Components smaller than this part of the largest are shown as nothing.
const ZERO_THRESHOLD: f64 = 5e-7;

fn shape(machine: &Machine, result: &ModesResult, k: usize) -> String {
    let shape = &result.modes[k].shape;
    let largest = shape.iter().fold(0.0f64, |m, &z| m.max(modulus(z)));
    let mut table = plain();
    if result.complex {
        table.add_row(vec!["freedom", "amplitude", "phase"]);
        table.add_row(vec!["", "of the largest", "deg"]);
    } else {
        table.add_row(vec!["freedom", "amplitude"]);
        table.add_row(vec!["", "of the largest"]);
    }
    for (i, &z) in shape.iter().enumerate() {
        let mut row = vec![machine.dof_name(i)];
        if result.complex {
            let still = modulus(z) < ZERO_THRESHOLD * largest;
            row.push(format!("{:.6}", modulus(z) / largest));
            row.push(if still {
                "–".to_string()
            } else {
                format!("{:.1}", z.im.atan2(z.re).to_degrees())
            });
        } else {
            let moves = modulus(z) >= ZERO_THRESHOLD * largest;
            row.push(format!("{:.6}", if moves { z.re / largest } else { 0.0 }));
        }
        table.add_row(row);
    }
    right_but_first(&mut table);
    finish(&table)
}

/// Crossings of orders and modes, by falling participation of the excited part.
/// Modes are numbered as they stand at the first speed, after `n_rigid` rigid ones.
pub fn crossings(found: &CampbellDiagram, n_rigid: usize) -> String {
    // What takes part with less than one in a thousand is not in danger.
    let mut order: Vec<usize> = (0..found.crossings.len())
        .filter(|&k| found.crossings[k].participation >= 1e-3)
        .collect();
    order.sort_by(|&a, &b| {
        found.crossings[b]
            .participation
            .total_cmp(&found.crossings[a].participation)
    });
    let shown = &order[..order.len().min(MAX_ROWS)];
    let mut table = plain();
    table.add_row(vec![
        format!("{} at", found.reference),
        "frequency".into(),
        "order".into(),
        "mode".into(),
        "takes part".into(),
        "excited by".into(),
    ]);
    table.add_row(vec!["rpm", "Hz", "", "", "%", ""]);
    let speeds = column(
        &shown
            .iter()
            .map(|&k| found.crossings[k].speed_rpm)
            .collect::<Vec<_>>(),
    );
    let frequencies = column(
        &shown
            .iter()
            .map(|&k| found.crossings[k].frequency_hz)
            .collect::<Vec<_>>(),
    );
    for (row, &k) in shown.iter().enumerate() {
        let crossing = &found.crossings[k];
        let order = &found.orders[crossing.order];
        table.add_row(vec![
            speeds[row].clone(),
            frequencies[row].clone(),
            if order.fraction.len() > 9 {
                format!("{:.4}", order.value)
            } else {
                order.fraction.clone()
            },
            (crossing.branch + 1 + n_rigid).to_string(),
            percent(crossing.participation),
            campbell::order_label(order),
        ]);
    }
    right_but_last(&mut table);
    let mut text = match shown.len() {
        0 => "no order meets a mode that takes part with 0.1 % or more in this range of speeds\n"
            .to_string(),
        _ => finish(&table),
    };
    if order.len() > shown.len() {
        text += &format!(
            "… and {} more; --json holds all\n",
            order.len() - shown.len()
        );
    }
    text
}

/// The plan: what runs, what is left out and why.
pub fn plan<'a>(steps: impl Iterator<Item = (&'a str, &'a StageDecision)> + Clone) -> String {
    let mut table = plain();
    for (name, decision) in steps.clone() {
        if let StageDecision::Runs(what) = decision {
            table.add_row(vec![name, what]);
        }
    }
    let mut text = finish(&table);
    text += "\nleft out\n";
    let mut left = plain();
    for (name, decision) in steps {
        if let StageDecision::LeftOut(why) = decision {
            left.add_row(vec![name, why]);
        }
    }
    text += &finish(&left);
    text
}

pub(super) fn plain() -> Table {
    let mut table = Table::new();
    table
        .load_preset(NOTHING)
        .set_content_arrangement(ContentArrangement::Disabled);
    table
}

pub(super) fn right_but_last(table: &mut Table) {
    let last = table.column_count().saturating_sub(1);
    for (at, column) in table.column_iter_mut().enumerate() {
        column.set_cell_alignment(if at == last {
            CellAlignment::Left
        } else {
            CellAlignment::Right
        });
    }
}

pub(super) fn right_but_first(table: &mut Table) {
    for (at, column) in table.column_iter_mut().enumerate() {
        column.set_cell_alignment(if at == 0 {
            CellAlignment::Left
        } else {
            CellAlignment::Right
        });
    }
}

/// The table's text with minus signs and without blanks at line ends.
pub(super) fn finish(table: &Table) -> String {
    with_minus_signs(&table.to_string())
        .lines()
        .map(|line| line.trim_end().to_string() + "\n")
        .collect()
}
