//! Structure of the equations (linear, time-invariant, switching), as text.

use crate::motion::dynamic_model::{DynamicModel, ForceLaw};

/// Structure of the equations of motion, as text.
pub fn structure_text(model: &DynamicModel) -> String {
    if model.is_linear() {
        return "linear and time-invariant".to_string();
    }
    let count =
        |test: &dyn Fn(&ForceLaw) -> bool| model.elements.iter().filter(|b| test(&b.law)).count();
    let mut parts = Vec::new();
    let mut part = |n: usize, one: &str, many: &str| {
        if n > 0 {
            parts.push(format!("{n} {}", if n == 1 { one } else { many }));
        }
    };
    part(
        (0..model.coordinate_count())
            .filter(|&i| model.is_massless(i))
            .count(),
        "coordinate without inertia",
        "coordinates without inertia",
    );
    part(
        count(&|l| matches!(l, ForceLaw::Contact(c) if c.half_play > 0.0)),
        "contact with play",
        "contacts with play",
    );
    let (followers, waves): (Vec<_>, Vec<_>) = (model.elements.iter())
        .filter(|b| b.stiffness_wave.is_some())
        .partition(|b| b.follows_load());
    part(
        followers.len(),
        "load-dependent stiffness",
        "load-dependent stiffnesses",
    );
    let (steps, smooth): (Vec<_>, Vec<_>) = waves.into_iter().partition(|b| {
        b.stiffness_wave
            .as_ref()
            .is_some_and(|w| w.waveform.is_piecewise_constant())
    });
    part(steps.len(), "stiffness in steps", "stiffnesses in steps");
    part(
        smooth.len(),
        "smooth stiffness wave",
        "smooth stiffness waves",
    );
    part(
        count(&|l| matches!(l, ForceLaw::Friction(_))),
        "friction pair",
        "friction pairs",
    );
    part(
        count(&|l| matches!(l, ForceLaw::Clutch { .. })),
        "clutch with time-varying capacity",
        "clutches with time-varying capacity",
    );
    part(
        count(&|l| matches!(l, ForceLaw::LoadFriction(_))),
        "friction pair with load-dependent friction",
        "friction pairs with load-dependent friction",
    );
    part(
        count(&|l| matches!(l, ForceLaw::AngleLocked { .. })),
        "angle-dependent load",
        "angle-dependent loads",
    );
    part(
        count(&|l| matches!(l, ForceLaw::TorqueSpeed(_) | ForceLaw::LaggedTorque { .. })),
        "motor",
        "motors",
    );
    part(
        model
            .elements
            .iter()
            .filter(|b| !b.angle_waves.is_empty())
            .count(),
        "angle-dependent error",
        "angle-dependent errors",
    );
    part(
        count(&|l| matches!(l, ForceLaw::Nonlinear { .. })),
        "nonlinear spring",
        "nonlinear springs",
    );
    part(
        model.signals().filter(|s| !s.is_piecewise_linear()).count(),
        "piecewise quadratic or burst load or motion",
        "piecewise quadratic or burst loads or motions",
    );
    match model.is_piecewise_linear() {
        true => format!("piecewise linear ({})", parts.join(", ")),
        false => format!("nonlinear or time-varying ({})", parts.join(", ")),
    }
}

/// Nonlinear terms that exclude the exact methods.
pub fn nonlinear_text(model: &DynamicModel) -> String {
    /// Names that a line holds.
    const MAX_NAMES_LISTED: usize = 3;
    let names: Vec<&str> = model
        .nonlinear_elements()
        .map(|b| b.name.as_str())
        .collect();
    match names.len() {
        0 if model.has_massless() => "not exact: nodes without inertia remain".to_string(),
        0 => "not exact: a load or motion is piecewise quadratic, or oscillates for a limited time"
            .to_string(),
        count => {
            let shown: Vec<String> = names
                .iter()
                .take(MAX_NAMES_LISTED)
                .map(|n| format!("`{n}`"))
                .collect();
            let more = match count.saturating_sub(MAX_NAMES_LISTED) {
                0 => String::new(),
                more => format!(" and {more} more"),
            };
            format!("not linear between switches: {}{more}", shown.join(", "))
        }
    }
}
