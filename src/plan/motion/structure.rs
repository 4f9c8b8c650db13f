//! What kind of equations a machine has, in words.

use crate::motion::train::{Law, Train};

/// What kind of equations a machine has.
pub fn structure(train: &Train) -> String {
    if train.is_linear() {
        return "linear and time-invariant".to_string();
    }
    let count =
        |test: &dyn Fn(&Law) -> bool| train.branches.iter().filter(|b| test(&b.law)).count();
    let mut parts = Vec::new();
    let mut part = |n: usize, one: &str, many: &str| {
        if n > 0 {
            parts.push(format!("{n} {}", if n == 1 { one } else { many }));
        }
    };
    part(
        (0..train.n()).filter(|&i| train.is_light(i)).count(),
        "coordinate without inertia",
        "coordinates without inertia",
    );
    part(
        count(&|l| matches!(l, Law::Contact(c) if c.half > 0.0)),
        "contact with play",
        "contacts with play",
    );
    let waves = train.branches.iter().filter(|b| b.variation.is_some());
    let (steps, smooth): (Vec<_>, Vec<_>) =
        waves.partition(|b| b.variation.as_ref().is_some_and(|w| w.shape.is_steps()));
    part(steps.len(), "stiffness in steps", "stiffnesses in steps");
    part(
        smooth.len(),
        "smooth stiffness wave",
        "smooth stiffness waves",
    );
    part(
        count(&|l| matches!(l, Law::Friction(_))),
        "friction pair",
        "friction pairs",
    );
    part(
        count(&|l| matches!(l, Law::Clutch { .. })),
        "clutch pressed over time",
        "clutches pressed over time",
    );
    part(
        count(&|l| matches!(l, Law::Pressed(_))),
        "friction pair pressed by forces",
        "friction pairs pressed by forces",
    );
    part(
        count(&|l| matches!(l, Law::Orders { .. })),
        "load that follows an angle",
        "loads that follow angles",
    );
    part(
        count(&|l| matches!(l, Law::Curve(_) | Law::Lagged { .. })),
        "motor",
        "motors",
    );
    part(
        train
            .branches
            .iter()
            .filter(|b| !b.followed.is_empty())
            .count(),
        "error that follows an angle",
        "errors that follow angles",
    );
    part(
        count(&|l| matches!(l, Law::Nonlinear { .. })),
        "nonlinear spring",
        "nonlinear springs",
    );
    match train.is_piecewise_linear() {
        true => format!("piecewise linear ({})", parts.join(", ")),
        false => format!("nonlinear or time-varying ({})", parts.join(", ")),
    }
}

/// What keeps the exact methods out.
pub fn curved(train: &Train) -> String {
    /// Names that a line holds.
    const NAMED: usize = 3;
    let names: Vec<&str> = train.bent().map(|b| b.name.as_str()).collect();
    match names.len() {
        0 if train.has_light() => "not exact: nodes without inertia stay".to_string(),
        0 => "not exact: a load or motion is known by parabolas, or swings for a while".to_string(),
        count => {
            let shown: Vec<String> = names.iter().take(NAMED).map(|n| format!("`{n}`")).collect();
            let more = match count.saturating_sub(NAMED) {
                0 => String::new(),
                more => format!(" and {more} more"),
            };
            format!("not linear between switches: {}{more}", shown.join(", "))
        }
    }
}
