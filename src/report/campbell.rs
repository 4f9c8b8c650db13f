//! A Campbell diagram as JSON, as a table of crossings, and as what its plot shows.

use serde_json::{Value, json};

use super::campbell_plot::{self, CampbellPlot};
use super::figure::PlotColumn;
use crate::modes::campbell::{CampbellBranch, CampbellDiagram, OrderCrossing};
use crate::modes::excitation_orders::{ExcitationCause, ExcitationOrder, ExcitationSource};
use crate::modes::whirl::Whirl;
use crate::numeric::sorting::falling_order;

/// Orders drawn: those whose parts take most part in the modes they meet.
const ORDERS: usize = 12;

/// Branches drawn whole; of more, those above what the drawn orders reach are left out.
const BRANCHES: usize = 16;

/// Crossings below this participation are not drawn on a crowded diagram.
const MIN_PARTICIPATION: f64 = 0.01;

/// The plot. A large machine has more orders and modes than a plot can show: it shows those that matter, and the table and
/// the JSON document hold all.
///
/// Modes are numbered as they stand at the first speed, after `n_rigid` rigid ones.
pub fn figure(found: &CampbellDiagram, n_rigid: usize, operating_rpm: Option<f64>) -> PlotColumn {
    let orders = strongest_orders(found);
    let crowded = found.orders.len() > ORDERS || found.branches.len() > BRANCHES;
    let drawn = |c: &&OrderCrossing| {
        orders.contains(&c.order) && (!crowded || c.participation >= MIN_PARTICIPATION)
    };
    let crossings: Vec<&OrderCrossing> = found.crossings.iter().filter(drawn).collect();
    let reach = crossings.iter().map(|c| c.frequency_hz).fold(0.0, f64::max);
    let branches = (0..found.branches.len()).filter(|&k| {
        let lowest = found.branches[k]
            .frequency_hz
            .iter()
            .flatten()
            .copied()
            .fold(f64::INFINITY, f64::min);
        found.branches.len() <= BRANCHES || reach == 0.0 || lowest <= 1.15 * reach
    });
    let branches: Vec<usize> = branches.take(2 * BRANCHES).collect();
    let crossings = crossings
        .into_iter()
        .filter(|c| branches.contains(&c.branch));
    campbell_plot::campbell_figure(&CampbellPlot {
        shaft: found.reference.clone(),
        speeds_rpm: found.speeds_rpm.clone(),
        branches: branches.iter().map(|&k| line(found, k, n_rigid)).collect(),
        orders: orders
            .iter()
            .map(|&k| plot_order(&found.orders[k]))
            .collect(),
        crossings: crossings.map(plot_crossing).collect(),
        operating_rpm,
    })
}

/// The orders to draw, by number.
fn strongest_orders(found: &CampbellDiagram) -> Vec<usize> {
    let mut strength = vec![0.0f64; found.orders.len()];
    for c in &found.crossings {
        strength[c.order] = strength[c.order].max(c.participation);
    }
    let mut order = falling_order(strength.iter().copied());
    order.truncate(ORDERS);
    order.retain(|&k| found.orders.len() <= ORDERS || strength[k] >= MIN_PARTICIPATION);
    order.sort_unstable();
    order
}

fn line(found: &CampbellDiagram, k: usize, n_rigid: usize) -> campbell_plot::PlottedBranch {
    let whirl = found.branches[k].whirl.iter().rev().flatten().next();
    campbell_plot::PlottedBranch {
        label: format!("mode {}", k + 1 + n_rigid),
        whirl: match whirl {
            Some(Whirl::Forward) => campbell_plot::PlottedWhirl::Forward,
            Some(Whirl::Backward) => campbell_plot::PlottedWhirl::Backward,
            _ => campbell_plot::PlottedWhirl::None,
        },
        frequencies_hz: found.branches[k].frequency_hz.clone(),
    }
}

fn plot_order(order: &ExcitationOrder) -> campbell_plot::PlottedOrder {
    campbell_plot::PlottedOrder {
        label: order_label(order),
        order: order.value,
    }
}

fn plot_crossing(c: &OrderCrossing) -> campbell_plot::PlottedCrossing {
    campbell_plot::PlottedCrossing {
        speed_rpm: c.speed_rpm,
        frequency_hz: c.frequency_hz,
        participation: c.participation,
    }
}

/// Excitation sources of an order: `wheel mesh`, `pinion, wheel`.
pub fn order_label(order: &ExcitationOrder) -> String {
    let mut words: Vec<String> = Vec::new();
    for source in &order.sources {
        let word = match source.cause {
            ExcitationCause::Mesh => format!("{} mesh", source.element),
            ExcitationCause::Rotation => source.member.clone(),
        };
        if !words.contains(&word) {
            words.push(word);
        }
    }
    words.join(", ")
}

/// The diagram as the `campbell` block of a document.
pub fn json(found: &CampbellDiagram) -> Value {
    let branch = |line: &CampbellBranch| {
        json!({
            "frequency_hz": line.frequency_hz,
            "damping_ratio": line.damping_ratio,
            "whirl": line.whirl.iter().map(|w| w.map(Whirl::name)).collect::<Vec<_>>(),
            "uncertain_rpm": line.uncertain_rpm,
        })
    };
    let order = |order: &ExcitationOrder| {
        let source = |s: &ExcitationSource| {
            let cause = match s.cause {
                ExcitationCause::Mesh => "mesh",
                ExcitationCause::Rotation => "rotation",
            };
            json!({ "element": s.element, "member": s.member, "cause": cause, "multiple": s.multiple })
        };
        json!({
            "order": order.fraction,
            "order_value": order.value,
            "sources": order.sources.iter().map(source).collect::<Vec<_>>(),
        })
    };
    let crossing = |c: &OrderCrossing| {
        json!({
            "speed_rpm": c.speed_rpm,
            "frequency_hz": c.frequency_hz,
            "order": found.orders[c.order].fraction,
            "branch": c.branch + 1,
            "participation": c.participation,
        })
    };
    json!({
        "reference": found.reference,
        "speeds_rpm": found.speeds_rpm,
        "depends_on_speed": !found.is_constant,
        "solutions": found.n_solves,
        "branches": found.branches.iter().map(branch).collect::<Vec<_>>(),
        "orders": found.orders.iter().map(order).collect::<Vec<_>>(),
        "crossings": found.crossings.iter().map(crossing).collect::<Vec<_>>(),
    })
}
