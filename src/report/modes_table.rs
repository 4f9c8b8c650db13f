//! Modes, crossings and the plan as terminal tables.

use super::campbell;
use super::mode_text::dominant_elements_text;
use super::number_format::{column, percent, significant};
use super::table::{Table, or_dash};
use crate::machine::components::Machine;
use crate::modes::campbell::{CampbellDiagram, OrderCrossing};
use crate::modes::mode::modulus;
use crate::modes::sensitivity::{FrequencySensitivity, SensitivityParameter};
use crate::numeric::sorting::sort_falling;
use crate::plan::modes_run::ModesResult;
use crate::plan::prepared_machine::PreparedMachine;

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
    let mut table = Table::new("mode|frequency [Hz]")
        .columns_if(damped && result.complex, "damping [%]")
        .columns_if(damped && !result.complex, "damping* [%]")
        .columns_if(decays, "time constant [s]")
        .columns("dominant element");
    for (k, frequency) in column(&frequencies).into_iter().enumerate() {
        let mode = &result.modes[k];
        let swings = mode.rigid || mode.is_oscillatory();
        let frequency = or_dash(swings.then_some(frequency), |text| text);
        let mut row = vec![(k + 1).to_string(), frequency];
        if damped {
            row.push(or_dash(damping(result, k), percent));
        }
        if decays {
            let time = (!swings).then(|| -1.0 / mode.eigenvalue.re);
            row.push(or_dash(time, significant));
        }
        let energies = &result.energies[k];
        row.push(dominant_elements_text(&machine.machine, mode, energies));
        table.row(row);
    }
    let mut text = table.text();
    if result.modes.len() > shown {
        let more = result.modes.len() - shown;
        text += &format!("… and {more} more; --lowest N limits them, --csv and --json hold all\n");
    }
    if damped && !result.complex {
        text += "* from the losses of the undamped shape; --damped solves for it\n";
    }
    text
}

/// Damping ratio: of a complex mode, else estimated from the losses of the undamped shape.
pub fn damping(result: &ModesResult, k: usize) -> Option<f64> {
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
            or_dash(found, |s| percent(s.1))
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
    let found = list
        .iter()
        .find(|s| s.element == element && s.parameter == parameter);
    or_dash(found, |s| format!("{:.4}", s.relative))
}

/// Elements with a share above one in a thousand, the largest first.
fn rank_by_share(machine: &Machine, all: [Option<&[(usize, f64)]>; 3]) -> Vec<usize> {
    let mut largest = vec![0.0f64; machine.elements.len()];
    for &(element, share) in all.into_iter().flatten().flatten() {
        largest[element] = largest[element].max(share.abs());
    }
    let mut order: Vec<usize> = (0..largest.len()).filter(|&e| largest[e] >= 1e-3).collect();
    sort_falling(&mut order, |&a| largest[a]);
    order
}

/// Components smaller than this part of the largest are shown as nothing.
const ZERO_THRESHOLD: f64 = 5e-7;

fn shape(machine: &Machine, result: &ModesResult, k: usize) -> String {
    let shape = &result.modes[k].shape;
    let largest = shape.iter().fold(0.0f64, |m, &z| m.max(modulus(z)));
    let mut table =
        Table::named("dof|amplitude [of the largest]").columns_if(result.complex, "phase [deg]");
    for (i, &z) in shape.iter().enumerate() {
        let mut row = vec![machine.dof_name(i)];
        if result.complex {
            let still = modulus(z) < ZERO_THRESHOLD * largest;
            row.push(format!("{:.6}", modulus(z) / largest));
            let phase = (!still).then(|| z.im.atan2(z.re).to_degrees());
            row.push(or_dash(phase, |deg| format!("{deg:.1}")));
        } else {
            let moves = modulus(z) >= ZERO_THRESHOLD * largest;
            row.push(format!("{:.6}", if moves { z.re / largest } else { 0.0 }));
        }
        table.row(row);
    }
    table.text()
}

/// Crossings of orders and modes, by falling participation of the excited part.
/// Modes are numbered as they stand at the first speed, after `n_rigid` rigid ones.
pub fn crossings(found: &CampbellDiagram, n_rigid: usize) -> String {
    // Shares below one in a thousand are not listed.
    let mut order: Vec<usize> = (0..found.crossings.len())
        .filter(|&k| found.crossings[k].participation >= 1e-3)
        .collect();
    order.sort_by(|&a, &b| {
        found.crossings[b]
            .participation
            .total_cmp(&found.crossings[a].participation)
    });
    let shown = &order[..order.len().min(MAX_ROWS)];
    let mut table = Table::default()
        .column(&format!("{} at", found.reference), "rpm")
        .columns("frequency [Hz]|order|mode|takes part [%]|excited by");
    let all = |of: fn(&OrderCrossing) -> f64| -> Vec<String> {
        column(
            &shown
                .iter()
                .map(|&k| of(&found.crossings[k]))
                .collect::<Vec<_>>(),
        )
    };
    let (speeds, frequencies) = (all(|c| c.speed_rpm), all(|c| c.frequency_hz));
    for (row, &k) in shown.iter().enumerate() {
        let crossing = &found.crossings[k];
        let order = &found.orders[crossing.order];
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
        0 => "no order meets a mode that takes part with 0.1 % or more in this range of speeds\n"
            .to_string(),
        _ => table.text(),
    };
    if order.len() > shown.len() {
        text += &format!(
            "… and {} more; --json holds all\n",
            order.len() - shown.len()
        );
    }
    text
}
