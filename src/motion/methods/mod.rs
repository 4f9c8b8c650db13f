//! The methods of integration: one table, one way to call them.

use super::light;
use super::problem::Run;
use super::train::Train;

/// Linear machines.
pub mod exact;

/// Machines that are linear between switches.
pub mod switched;

/// Coefficients of a method of order 8.
pub mod dop853_table;

/// Explicit, order 8.
pub mod dop853;

/// Implicit, order 5.
pub mod radau;

/// Both, on machines and on plain problems.
pub mod stepping;

/// Exponential, order 4.
pub mod exponential;

/// Newmark's and its kin.
pub mod alpha;

/// The methods of ode_solvers.
pub mod explicit;

/// Stiffness and loads that repeat in time.
pub mod periodic;

/// Backward differentiation formulas.
#[cfg(feature = "bdf")]
pub mod bdf;

/// A method for machines in motion.
pub struct Method {
    /// The word for it in commands and files.
    pub name: &'static str,
    /// What it is, in a line.
    pub title: &'static str,
    /// What its exactness is asked by.
    pub ladder: Ladder,
    /// Its order of convergence in the step; absent where the step makes no error.
    pub order: Option<u32>,
    /// What it descends from: methods of one kin share their faults, so that they cannot confirm each other.
    pub kin: Kin,
    /// What its steps are bound by; absent where none is too long to be stable.
    pub bound: Option<Bound>,
    /// It takes switches at the instants they happen, so that they cost no order.
    pub locates_events: bool,
    /// Why it cannot take a machine; absent where it can.
    pub refuses: fn(&Train) -> Option<String>,
    /// Integrates.
    pub run: Run<Train>,
}

/// What keeps an explicit method stable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bound {
    /// Evaluations of f in a step.
    pub stages: u32,
    /// The largest |hλ| in the left half-plane with which a step does not grow; along the imaginary axis it is less.
    pub radius: f64,
}

// Radii of the regions of the stability polynomials that `stability` draws.
const ORDER_4: Bound = Bound {
    stages: 4,
    radius: 2.97,
};
const ORDER_5: Bound = Bound {
    stages: 6,
    radius: 3.40,
};
const ORDER_8: Bound = Bound {
    stages: 12,
    radius: 6.80,
};

/// What a method descends from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kin {
    /// Solutions of the linear part in closed form, taken from switch to switch.
    Propagation,
    /// Explicit Runge–Kutta.
    Explicit,
    /// Collocation at Radau's points.
    Collocation,
    /// Multistep formulas.
    #[cfg(feature = "bdf")]
    Multistep,
    /// Newmark's formulas for position and speed.
    Newmark,
}

/// What the exactness of a method is asked by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ladder {
    /// Nothing: it is exact to rounding.
    Exact,
    /// A tolerance.
    Tolerance,
    /// A step.
    Step,
}

/// Every method, the most special first.
pub const METHODS: &[Method] = &[
    exact::METHOD,
    switched::METHOD,
    periodic::METHOD,
    Method {
        name: "dop853-events",
        title: "Dormand–Prince 8(5,3) with switches located",
        ladder: Ladder::Tolerance,
        order: Some(8),
        kin: Kin::Explicit,
        bound: Some(ORDER_8),
        locates_events: true,
        refuses: light::refused,
        run: stepping::dop853,
    },
    Method {
        name: "radau5",
        title: "Radau IIA of order 5 with switches located, for stiff machines",
        ladder: Ladder::Tolerance,
        order: Some(5),
        kin: Kin::Collocation,
        bound: None,
        locates_events: true,
        refuses: |_| None,
        run: stepping::radau5,
    },
    Method {
        name: "exponential",
        title: "exponential Runge–Kutta of stiff order 4, the linear part exact, for stiff machines with smooth forces",
        ladder: Ladder::Tolerance,
        order: Some(4),
        kin: Kin::Propagation,
        bound: None,
        locates_events: true,
        refuses: exponential::refuses,
        run: exponential::exponential,
    },
    Method {
        name: "dop853",
        title: "Dormand–Prince 8(5,3) of ode_solvers",
        ladder: Ladder::Tolerance,
        order: Some(8),
        kin: Kin::Explicit,
        bound: Some(ORDER_8),
        locates_events: false,
        refuses: light::refused,
        run: explicit::dop853,
    },
    Method {
        name: "dopri5",
        title: "Dormand–Prince 5(4) of ode_solvers",
        ladder: Ladder::Tolerance,
        order: Some(5),
        kin: Kin::Explicit,
        bound: Some(ORDER_5),
        locates_events: false,
        refuses: light::refused,
        run: explicit::dopri5,
    },
    Method {
        name: "rk4",
        title: "Runge–Kutta of order 4 of ode_solvers",
        ladder: Ladder::Step,
        order: Some(4),
        kin: Kin::Explicit,
        bound: Some(ORDER_4),
        locates_events: false,
        refuses: light::refused,
        run: explicit::rk4,
    },
    #[cfg(feature = "bdf")]
    Method {
        name: "bdf",
        title: "backward differentiation formulas of order 1 to 5 of diffsol, for stiff machines",
        ladder: Ladder::Tolerance,
        order: None,
        kin: Kin::Multistep,
        bound: None,
        locates_events: false,
        refuses: light::refused,
        run: bdf::machine,
    },
    Method {
        name: "generalized-alpha-controlled",
        title: "generalised α with ρ∞ = 0.8, steps by a tolerance",
        ladder: Ladder::Tolerance,
        order: Some(2),
        kin: Kin::Newmark,
        bound: None,
        locates_events: false,
        refuses: alpha::refuses,
        run: alpha::generalized,
    },
    Method {
        name: "generalized-alpha",
        title: "generalised α with ρ∞ = 0.8",
        ladder: Ladder::Step,
        order: Some(2),
        kin: Kin::Newmark,
        bound: None,
        locates_events: false,
        refuses: alpha::refuses,
        run: alpha::generalized,
    },
    Method {
        name: "hht",
        title: "Hilber, Hughes and Taylor with ρ∞ = 0.8",
        ladder: Ladder::Step,
        order: Some(2),
        kin: Kin::Newmark,
        bound: None,
        locates_events: false,
        refuses: alpha::refuses,
        run: alpha::hht,
    },
    Method {
        name: "newmark",
        title: "Newmark, average acceleration",
        ladder: Ladder::Step,
        order: Some(2),
        kin: Kin::Newmark,
        bound: None,
        locates_events: false,
        refuses: alpha::refuses,
        run: alpha::newmark,
    },
];

/// The method of a name.
pub fn find(name: &str) -> Option<&'static Method> {
    METHODS.iter().find(|method| method.name == name)
}
