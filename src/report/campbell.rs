//! A Campbell diagram as JSON, as a table of crossings, and as what its picture shows.

use serde_json::{Value, json};

use super::campbell_picture::{self, Diagram};
use crate::modes::campbell::{BranchLine, Campbell, Crossing};
use crate::modes::orders::{Cause, Order, Source};
use crate::modes::whirl::Whirl;

/// Orders drawn: those whose parts take most part in the modes they meet.
const ORDERS: usize = 12;

/// Branches drawn whole; of more, those above what the drawn orders reach are left out.
const BRANCHES: usize = 16;

/// Crossings below this participation are not drawn on a crowded diagram.
const FAINT: f64 = 0.01;

/// The picture. A large machine has more orders and modes than a picture can show: it shows those that matter, and the table and
/// the JSON document hold all.
///
/// Modes are numbered as they stand at the first speed, after `n_rigid` rigid ones.
pub fn picture(found: &Campbell, n_rigid: usize) -> String {
    let orders = strongest_orders(found);
    let crowded = found.orders.len() > ORDERS || found.branches.len() > BRANCHES;
    let drawn = |c: &&Crossing| orders.contains(&c.order) && (!crowded || c.participation >= FAINT);
    let crossings: Vec<&Crossing> = found.crossings.iter().filter(drawn).collect();
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
    campbell_picture::campbell(&Diagram {
        shaft: found.reference.clone(),
        speeds_rpm: found.speeds_rpm.clone(),
        branches: branches.iter().map(|&k| line(found, k, n_rigid)).collect(),
        orders: orders.iter().map(|&k| ray(&found.orders[k])).collect(),
        crossings: crossings.map(ring).collect(),
    })
}

/// The orders to draw, by number.
fn strongest_orders(found: &Campbell) -> Vec<usize> {
    let mut strength = vec![0.0f64; found.orders.len()];
    for c in &found.crossings {
        strength[c.order] = strength[c.order].max(c.participation);
    }
    let mut order: Vec<usize> = (0..found.orders.len()).collect();
    order.sort_by(|&a, &b| strength[b].total_cmp(&strength[a]));
    order.truncate(ORDERS);
    order.retain(|&k| found.orders.len() <= ORDERS || strength[k] >= FAINT);
    order.sort_unstable();
    order
}

fn line(found: &Campbell, k: usize, n_rigid: usize) -> campbell_picture::BranchLine {
    let whirl = found.branches[k].whirl.iter().rev().flatten().next();
    campbell_picture::BranchLine {
        label: format!("mode {}", k + 1 + n_rigid),
        whirl: match whirl {
            Some(Whirl::Forward) => campbell_picture::Whirl::Forward,
            Some(Whirl::Backward) => campbell_picture::Whirl::Backward,
            _ => campbell_picture::Whirl::None,
        },
        frequencies_hz: found.branches[k].frequency_hz.clone(),
    }
}

fn ray(order: &Order) -> campbell_picture::OrderLine {
    campbell_picture::OrderLine {
        label: words(order),
        order: order.value,
    }
}

fn ring(c: &Crossing) -> campbell_picture::Crossing {
    campbell_picture::Crossing {
        speed_rpm: c.speed_rpm,
        frequency_hz: c.frequency_hz,
        participation: c.participation,
    }
}

/// What excites an order: `wheel mesh`, `pinion, wheel`.
pub fn words(order: &Order) -> String {
    let mut words: Vec<String> = Vec::new();
    for source in &order.sources {
        let word = match source.cause {
            Cause::Mesh => format!("{} mesh", source.element),
            Cause::Rotation => source.member.clone(),
        };
        if !words.contains(&word) {
            words.push(word);
        }
    }
    words.join(", ")
}

/// The diagram as the `campbell` block of a document.
pub fn json(found: &Campbell) -> Value {
    let branch = |line: &BranchLine| {
        json!({
            "frequency_hz": line.frequency_hz,
            "damping_ratio": line.damping_ratio,
            "whirl": line.whirl.iter().map(|w| w.map(Whirl::name)).collect::<Vec<_>>(),
            "uncertain_rpm": line.uncertain_rpm,
        })
    };
    let order = |order: &Order| {
        let source = |s: &Source| {
            let cause = match s.cause {
                Cause::Mesh => "mesh",
                Cause::Rotation => "rotation",
            };
            json!({ "element": s.element, "member": s.member, "cause": cause, "multiple": s.multiple })
        };
        json!({
            "order": order.fraction,
            "order_value": order.value,
            "sources": order.sources.iter().map(source).collect::<Vec<_>>(),
        })
    };
    let crossing = |c: &Crossing| {
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
