//! A Campbell diagram as JSON, as a table of crossings, and as what its picture shows.

use serde_json::{Value, json};

use super::campbell_picture::{self, Diagram};
use crate::modes::campbell::Campbell;
use crate::modes::orders::{Cause, Order};
use crate::modes::whirl::Whirl;

/// The picture.
pub fn picture(found: &Campbell) -> String {
    let branch = |(k, line): (usize, &crate::modes::campbell::BranchLine)| {
        let whirl = line.whirl.iter().rev().flatten().next();
        campbell_picture::BranchLine {
            label: format!("mode {}", k + 1),
            whirl: match whirl {
                Some(Whirl::Forward) => campbell_picture::Whirl::Forward,
                Some(Whirl::Backward) => campbell_picture::Whirl::Backward,
                _ => campbell_picture::Whirl::None,
            },
            frequencies_hz: line.frequency_hz.clone(),
        }
    };
    let order = |order: &Order| campbell_picture::OrderLine {
        label: words(order),
        order: order.value,
    };
    let crossings = found.crossings.iter().map(|c| campbell_picture::Crossing {
        speed_rpm: c.speed_rpm,
        frequency_hz: c.frequency_hz,
        participation: c.participation,
    });
    campbell_picture::campbell(&Diagram {
        shaft: found.reference.clone(),
        speeds_rpm: found.speeds_rpm.clone(),
        branches: found.branches.iter().enumerate().map(branch).collect(),
        orders: found.orders.iter().map(order).collect(),
        crossings: crossings.collect(),
    })
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
    let branch = |line: &crate::modes::campbell::BranchLine| {
        json!({
            "frequency_hz": line.frequency_hz,
            "damping_ratio": line.damping_ratio,
            "whirl": line.whirl.iter().map(|w| w.map(Whirl::name)).collect::<Vec<_>>(),
            "uncertain_rpm": line.uncertain_rpm,
        })
    };
    let order = |order: &Order| {
        let source = |s: &crate::modes::orders::Source| {
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
    let crossing = |c: &crate::modes::campbell::Crossing| {
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
