//! The methods of integration: one table, one way to call them.

use super::problem::Run;
use super::train::Train;

/// Stiffness and loads that repeat in time.
pub mod periodic;

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
    /// It takes switches at the instants they happen, so that they cost no order.
    pub locates_events: bool,
    /// Why it cannot take a machine; absent where it can.
    pub refuses: fn(&Train) -> Option<String>,
    /// Integrates.
    pub run: Run<Train>,
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
pub const METHODS: &[Method] = &[periodic::PERIODIC];

/// The method of a name.
pub fn find(name: &str) -> Option<&'static Method> {
    METHODS.iter().find(|method| method.name == name)
}
