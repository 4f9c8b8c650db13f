//! Table of integration methods: order, family, step control, stability bound.

use super::algebraic;
use super::dynamic_model::DynamicModel;
use super::problem::IntegrateFn;

pub mod exact;

pub mod switched;

pub mod dop853_table;

pub mod dop853;

pub mod radau;

pub mod with_events;

pub mod exponential;

pub mod alpha;

pub mod explicit_runge_kutta;

pub mod periodic;

/// Integration method for dynamic models.
pub struct IntegrationMethod {
    /// Name in commands and files.
    pub name: &'static str,
    /// One-line description.
    pub title: &'static str,
    /// Step control of the method.
    pub step_control: StepControl,
    /// Order of convergence in the step size; absent for methods without discretisation error.
    pub order: Option<u32>,
    /// Method family; methods of one family are no independent check of each other.
    pub family: MethodFamily,
    /// Stability bound of the step; absent for methods stable at any step size.
    pub bound: Option<StabilityBound>,
    /// True if switches are located as events, so that they do not reduce the order.
    pub locates_events: bool,
    /// Reason why the method does not support a model; `None` if it does.
    pub unsupported_reason: fn(&DynamicModel) -> Option<String>,
    /// Function that integrates a model.
    pub run: IntegrateFn<DynamicModel>,
}

/// Stability region of an explicit method.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StabilityBound {
    /// Evaluations of f per step.
    pub stages: u32,
    /// Largest |hλ| of the stability region in the left half-plane; on the imaginary axis the bound is smaller.
    pub radius: f64,
}

// Radii of the stability regions that the command `stability` plots.
const RK4_BOUND: StabilityBound = StabilityBound {
    stages: 4,
    radius: 2.97,
};
const DOPRI5_BOUND: StabilityBound = StabilityBound {
    stages: 6,
    radius: 3.40,
};
const DOP853_BOUND: StabilityBound = StabilityBound {
    stages: 12,
    radius: 6.80,
};

/// Families of integration methods.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MethodFamily {
    /// Closed-form propagation of the linear part between switches.
    Propagation,
    /// Explicit Runge–Kutta.
    Explicit,
    /// Collocation at the Radau points.
    Collocation,
    /// Newmark's formulas for position and velocity.
    Newmark,
}

/// Step control of a method.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StepControl {
    /// No step control; the method is exact to rounding.
    Exact,
    /// Adaptive steps by a tolerance.
    Adaptive,
    /// Fixed step size.
    Fixed,
}

/// Table of the methods, the most specialised first.
pub const METHODS: &[IntegrationMethod] = &[
    exact::METHOD,
    switched::METHOD,
    periodic::METHOD,
    IntegrationMethod {
        name: "dop853-events",
        title: "Dormand–Prince 8(5,3) with switches located",
        step_control: StepControl::Adaptive,
        order: Some(8),
        family: MethodFamily::Explicit,
        bound: Some(DOP853_BOUND),
        locates_events: true,
        unsupported_reason: algebraic::inertia_requirement,
        run: with_events::dop853,
    },
    IntegrationMethod {
        name: "radau5",
        title: "Radau IIA of order 5 with switches located, for stiff machines",
        step_control: StepControl::Adaptive,
        order: Some(5),
        family: MethodFamily::Collocation,
        bound: None,
        locates_events: true,
        unsupported_reason: |_| None,
        run: with_events::radau5,
    },
    IntegrationMethod {
        name: "exponential",
        title: "exponential Runge–Kutta of stiff order 4, the linear part exact, for stiff machines with smooth forces",
        step_control: StepControl::Adaptive,
        order: Some(4),
        family: MethodFamily::Propagation,
        bound: None,
        locates_events: true,
        unsupported_reason: exponential::unsupported_reason,
        run: exponential::exponential,
    },
    IntegrationMethod {
        name: "dop853",
        title: "Dormand–Prince 8(5,3) of ode_solvers",
        step_control: StepControl::Adaptive,
        order: Some(8),
        family: MethodFamily::Explicit,
        bound: Some(DOP853_BOUND),
        locates_events: false,
        unsupported_reason: algebraic::inertia_requirement,
        run: explicit_runge_kutta::dop853,
    },
    IntegrationMethod {
        name: "dopri5",
        title: "Dormand–Prince 5(4) of ode_solvers",
        step_control: StepControl::Adaptive,
        order: Some(5),
        family: MethodFamily::Explicit,
        bound: Some(DOPRI5_BOUND),
        locates_events: false,
        unsupported_reason: algebraic::inertia_requirement,
        run: explicit_runge_kutta::dopri5,
    },
    IntegrationMethod {
        name: "rk4",
        title: "Runge–Kutta of order 4 of ode_solvers",
        step_control: StepControl::Fixed,
        order: Some(4),
        family: MethodFamily::Explicit,
        bound: Some(RK4_BOUND),
        locates_events: false,
        unsupported_reason: algebraic::inertia_requirement,
        run: explicit_runge_kutta::rk4,
    },
    IntegrationMethod {
        name: "generalized-alpha-controlled",
        title: "generalised α with ρ∞ = 0.8, step control by a tolerance",
        step_control: StepControl::Adaptive,
        order: Some(2),
        family: MethodFamily::Newmark,
        bound: None,
        locates_events: false,
        unsupported_reason: alpha::unsupported_reason,
        run: alpha::generalized,
    },
    IntegrationMethod {
        name: "generalized-alpha",
        title: "generalised α with ρ∞ = 0.8",
        step_control: StepControl::Fixed,
        order: Some(2),
        family: MethodFamily::Newmark,
        bound: None,
        locates_events: false,
        unsupported_reason: alpha::unsupported_reason,
        run: alpha::generalized,
    },
    IntegrationMethod {
        name: "hht",
        title: "Hilber, Hughes and Taylor with ρ∞ = 0.8",
        step_control: StepControl::Fixed,
        order: Some(2),
        family: MethodFamily::Newmark,
        bound: None,
        locates_events: false,
        unsupported_reason: alpha::unsupported_reason,
        run: alpha::hht,
    },
    IntegrationMethod {
        name: "newmark",
        title: "Newmark, average acceleration",
        step_control: StepControl::Fixed,
        order: Some(2),
        family: MethodFamily::Newmark,
        bound: None,
        locates_events: false,
        unsupported_reason: alpha::unsupported_reason,
        run: alpha::newmark,
    },
];

/// Method with a given name.
pub fn method_by_name(name: &str) -> Option<&'static IntegrationMethod> {
    METHODS.iter().find(|method| method.name == name)
}
