//! Modes and Campbell crossings as terminal tables.

use super::campbell;
use super::mode_text::dominant_elements_text;
use super::number_format::{column, percent, significant};
use super::table::{Table, or_dash};
use crate::machine::components::Machine;
use crate::modes::campbell::{CampbellDiagram, OrderCrossing};
use crate::modes::mode::modulus;
use crate::modes::sensitivity::{FrequencySensitivity, SensitivityParameter};
use crate::numeric::sorting::sort_descending;
use crate::plan::modes_run::ModesResult;
use crate::plan::prepared_machine::PreparedMachine;

/// Maximum number of rows shown; CSV and JSON contain all.
const MAX_ROWS: usize = 50;

/// Table of modes, one row each.
pub fn modes(machine: &PreparedMachine, result: &ModesResult) -> String {
    let n_rows = result.modes.len().min(MAX_ROWS);
    let frequencies: Vec<f64> = result.modes[..n_rows]
        .iter()
        .map(|m| m.frequency_hz())
        .collect();
    let has_damping = (0..n_rows).any(|k| damping(result, k).is_some());
    let has_decay = result.modes[..n_rows]
        .iter()
        .any(|m| !m.rigid && !m.is_oscillatory());
    let mut table = Table::new("mode|frequency [Hz]")
        .columns_if(has_damping && result.complex, "damping [%]")
        .columns_if(has_damping && !result.complex, "damping* [%]")
        .columns_if(has_decay, "time constant [s]")
        .columns("dominant element");
    for (k, frequency) in column(&frequencies).into_iter().enumerate() {
        let mode = &result.modes[k];
        let oscillates = mode.rigid || mode.is_oscillatory();
        let frequency = or_dash(oscillates.then_some(frequency), |text| text);
        let mut row = vec![(k + 1).to_string(), frequency];
        if has_damping {
            row.push(or_dash(damping(result, k), percent));
        }
        if has_decay {
            let time = (!oscillates).then(|| -1.0 / mode.eigenvalue.re);
            row.push(or_dash(time, significant));
        }
        let energies = &result.energies[k];
        row.push(dominant_elements_text(&machine.machine, mode, energies));
        table.row(row);
    }
    let mut text = table.text();
    if result.modes.len() > n_rows {
        let more = result.modes.len() - n_rows;
        text += &format!("… and {more} more; --lowest N limits them, --csv and --json have all\n");
    }
    if has_damping && !result.complex {
        text += "* estimated from the undamped shape; --damped computes it\n";
    }
    text
}

/// Damping ratio of a complex mode, or its estimate from the losses of the undamped shape.
pub fn damping(result: &ModesResult, k: usize) -> Option<f64> {
    if result.complex {
        result.modes[k].damping_ratio
    } else {
        result.energies[k].estimated_damping_ratio
    }
}

/// Evaluation of one mode: energy shares and frequency sensitivities by element, mode shape.
pub fn mode(prepared_machine: &PreparedMachine, result: &ModesResult, k: usize) -> String {
    let machine = &prepared_machine.machine;
    let (mode, energies) = (&result.modes[k], &result.energies[k]);
    let mut text = match mode.rigid || mode.is_oscillatory() {
        true => format!("mode {}: {:.9} Hz", k + 1, mode.frequency_hz()),
        false => format!(
            "mode {}: time constant {} s, not oscillatory",
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
    let mut table = Table::named(
        "element|strain energy [%]|kinetic energy [%]|dissipation [%]|dω/ω per dk/k [%/%]|dω/ω per dJ/J [%/%]",
    );
    let list = result
        .sensitivities
        .as_ref()
        .map(|list| list[k].as_slice())
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
            let entry = shares.and_then(|s| s.iter().find(|s| s.0 == element));
            or_dash(entry, |s| percent(s.1))
        };
        table.row([
            machine.elements[element].name.clone(),
            share(energies.strain.as_deref()),
            share(Some(&energies.kinetic)),
            share(energies.dissipated.as_deref()),
            sensitivity(list, element, SensitivityParameter::Stiffness),
            sensitivity(list, element, SensitivityParameter::Inertia),
        ]);
    }
    text += &table.text();
    text += "\n";
    text += &shape(machine, result, k);
    text
}

fn sensitivity(
    list: &[FrequencySensitivity],
    element: usize,
    parameter: SensitivityParameter,
) -> String {
    let entry = list
        .iter()
        .find(|s| s.element == element && s.parameter == parameter);
    or_dash(entry, |s| format!("{:.4}", s.relative))
}

/// Elements with a share above one in a thousand, the largest first.
fn rank_by_share(machine: &Machine, shares: [Option<&[(usize, f64)]>; 3]) -> Vec<usize> {
    let mut largest = vec![0.0f64; machine.elements.len()];
    for &(element, share) in shares.into_iter().flatten().flatten() {
        largest[element] = largest[element].max(share.abs());
    }
    let mut order: Vec<usize> = (0..largest.len()).filter(|&e| largest[e] >= 1e-3).collect();
    sort_descending(&mut order, |&a| largest[a]);
    order
}

/// Components smaller than this share of the largest are shown as zero.
const ZERO_THRESHOLD: f64 = 5e-7;

fn shape(machine: &Machine, result: &ModesResult, k: usize) -> String {
    let shape = &result.modes[k].shape;
    let largest = shape.iter().fold(0.0f64, |m, &z| m.max(modulus(z)));
    let mut table =
        Table::named("dof|amplitude [of the largest]").columns_if(result.complex, "phase [deg]");
    for (i, &z) in shape.iter().enumerate() {
        let mut row = vec![machine.dof_name(i)];
        if result.complex {
            let is_zero = modulus(z) < ZERO_THRESHOLD * largest;
            row.push(format!("{:.6}", modulus(z) / largest));
            let phase = (!is_zero).then(|| z.im.atan2(z.re).to_degrees());
            row.push(or_dash(phase, |deg| format!("{deg:.1}")));
        } else {
            let nonzero = modulus(z) >= ZERO_THRESHOLD * largest;
            row.push(format!("{:.6}", if nonzero { z.re / largest } else { 0.0 }));
        }
        table.row(row);
    }
    table.text()
}

/// Crossings of excitation orders and modes, by falling participation of the excited part.
/// Modes are numbered in their order at the first speed, after `n_rigid` rigid-body modes.
pub fn crossings(diagram: &CampbellDiagram, n_rigid: usize) -> String {
    // Shares below one in a thousand are not listed.
    let mut order: Vec<usize> = (0..diagram.crossings.len())
        .filter(|&k| diagram.crossings[k].participation >= 1e-3)
        .collect();
    order.sort_by(|&a, &b| {
        diagram.crossings[b]
            .participation
            .total_cmp(&diagram.crossings[a].participation)
    });
    let shown = &order[..order.len().min(MAX_ROWS)];
    let mut table = Table::default()
        .column(&format!("{} at", diagram.reference), "rpm")
        .columns("frequency [Hz]|order|mode|participation [%]|excited by");
    let texts = |quantity: fn(&OrderCrossing) -> f64| -> Vec<String> {
        column(
            &shown
                .iter()
                .map(|&k| quantity(&diagram.crossings[k]))
                .collect::<Vec<_>>(),
        )
    };
    let (speeds, frequencies) = (texts(|c| c.speed_rpm), texts(|c| c.frequency_hz));
    for (row, &k) in shown.iter().enumerate() {
        let crossing = &diagram.crossings[k];
        let order = &diagram.orders[crossing.order];
        table.row([
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
    let mut text = match shown.len() {
        0 => "no order crosses a mode with a participation of 0.1 % or more in this range of speeds\n"
            .to_string(),
        _ => table.text(),
    };
    if order.len() > shown.len() {
        text += &format!("… and {} more; --json has all\n", order.len() - shown.len());
    }
    text
}
