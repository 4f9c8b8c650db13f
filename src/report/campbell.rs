//! Campbell diagram as a plot and as the `campbell` block of a JSON document.

use serde_json::{Value, json};

use super::campbell_plot::{self, CampbellPlot, PlottedBranch};
use super::figure::PlotColumn;
use crate::modes::campbell::{CampbellBranch, CampbellDiagram, OrderCrossing};
use crate::modes::excitation_orders::{ExcitationCause, ExcitationOrder, ExcitationSource};
use crate::modes::whirl::Whirl;
use crate::numeric::sorting::falling_order;

/// Maximum number of order lines in the plot, by the largest participation at their crossings.
const MAX_ORDERS: usize = 12;

/// Number of branches up to which all are plotted; of more, those above the highest plotted crossing are omitted.
const FEW_BRANCHES: usize = 16;

/// Minimum participation of a plotted crossing in a crowded diagram.
const MIN_PARTICIPATION: f64 = 0.01;

/// Campbell plot of the orders of largest participation and the branches that they cross; table and JSON document contain all.
///
/// Mode numbers begin after the `n_rigid` rigid-body modes, in the order of the first speed.
pub fn figure(diagram: &CampbellDiagram, n_rigid: usize, operating_rpm: Option<f64>) -> PlotColumn {
    let orders = strongest_orders(diagram);
    let is_crowded = diagram.orders.len() > MAX_ORDERS || diagram.branches.len() > FEW_BRANCHES;
    let is_plotted = |c: &&OrderCrossing| {
        orders.contains(&c.order) && (!is_crowded || c.participation >= MIN_PARTICIPATION)
    };
    let crossings: Vec<&OrderCrossing> = diagram.crossings.iter().filter(is_plotted).collect();
    let highest_hz = crossings.iter().map(|c| c.frequency_hz).fold(0.0, f64::max);
    let branches = (0..diagram.branches.len()).filter(|&k| {
        let lowest = diagram.branches[k]
            .frequency_hz
            .iter()
            .flatten()
            .copied()
            .fold(f64::INFINITY, f64::min);
        diagram.branches.len() <= FEW_BRANCHES || highest_hz == 0.0 || lowest <= 1.15 * highest_hz
    });
    let branches: Vec<usize> = branches.take(2 * FEW_BRANCHES).collect();
    let crossings = crossings
        .into_iter()
        .filter(|c| branches.contains(&c.branch));
    let plotted = |&k: &usize| plotted_branch(diagram, k, n_rigid);
    campbell_plot::campbell_figure(&CampbellPlot {
        shaft: diagram.reference.clone(),
        speeds_rpm: diagram.speeds_rpm.clone(),
        branches: branches.iter().map(plotted).collect(),
        orders: orders
            .iter()
            .map(|&k| plotted_order(&diagram.orders[k]))
            .collect(),
        crossings: crossings.map(plotted_crossing).collect(),
        operating_rpm,
    })
}

/// Indices of the plotted orders.
fn strongest_orders(diagram: &CampbellDiagram) -> Vec<usize> {
    let mut strength = vec![0.0f64; diagram.orders.len()];
    for c in &diagram.crossings {
        strength[c.order] = strength[c.order].max(c.participation);
    }
    let mut order = falling_order(strength.iter().copied());
    order.truncate(MAX_ORDERS);
    order.retain(|&k| diagram.orders.len() <= MAX_ORDERS || strength[k] >= MIN_PARTICIPATION);
    order.sort_unstable();
    order
}

fn plotted_branch(diagram: &CampbellDiagram, k: usize, n_rigid: usize) -> PlottedBranch {
    let whirl = diagram.branches[k].whirl.iter().rev().flatten().next();
    PlottedBranch {
        label: format!("mode {}", k + 1 + n_rigid),
        whirl: match whirl {
            Some(Whirl::Forward) => campbell_plot::PlottedWhirl::Forward,
            Some(Whirl::Backward) => campbell_plot::PlottedWhirl::Backward,
            _ => campbell_plot::PlottedWhirl::None,
        },
        frequencies_hz: diagram.branches[k].frequency_hz.clone(),
    }
}

fn plotted_order(order: &ExcitationOrder) -> campbell_plot::PlottedOrder {
    campbell_plot::PlottedOrder {
        label: order_label(order),
        order: order.value,
    }
}

fn plotted_crossing(c: &OrderCrossing) -> campbell_plot::PlottedCrossing {
    campbell_plot::PlottedCrossing {
        speed_rpm: c.speed_rpm,
        frequency_hz: c.frequency_hz,
        participation: c.participation,
    }
}

/// Label of an order by its excitation sources: `wheel mesh`, `pinion, wheel`.
pub fn order_label(order: &ExcitationOrder) -> String {
    let mut names: Vec<String> = Vec::new();
    for source in &order.sources {
        let name = match source.cause {
            ExcitationCause::Mesh => format!("{} mesh", source.element),
            ExcitationCause::Rotation => source.member.clone(),
        };
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names.join(", ")
}

/// Campbell diagram as the `campbell` block of a JSON document.
pub fn json(diagram: &CampbellDiagram) -> Value {
    let branch = |b: &CampbellBranch| {
        json!({
            "frequency_hz": b.frequency_hz,
            "damping_ratio": b.damping_ratio,
            "whirl": b.whirl.iter().map(|w| w.map(Whirl::name)).collect::<Vec<_>>(),
            "uncertain_rpm": b.uncertain_rpm,
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
            "order": diagram.orders[c.order].fraction,
            "branch": c.branch + 1,
            "participation": c.participation,
        })
    };
    json!({
        "reference": diagram.reference,
        "speeds_rpm": diagram.speeds_rpm,
        "depends_on_speed": !diagram.is_constant,
        "solutions": diagram.n_solves,
        "branches": diagram.branches.iter().map(branch).collect::<Vec<_>>(),
        "orders": diagram.orders.iter().map(order).collect::<Vec<_>>(),
        "crossings": diagram.crossings.iter().map(crossing).collect::<Vec<_>>(),
    })
}
