//! Comparison of exact and approximate solution methods by error and run time.

use super::timing::min_time;
use crate::base::error::Error;

/// Cost and error of every method for one result.
pub struct ComparisonResult {
    /// Compared quantity, as text.
    pub quantity: String,
    /// Norm of the errors, as text.
    pub norm: &'static str,
    /// Degrees of freedom of the machine, without rigid joints; `None` of gears by themselves.
    pub dofs: Option<usize>,
    /// Reference of the errors.
    pub reference: String,
    /// Relative error of the reference, below which no error is measurable.
    pub reference_error: f64,
    /// Every way that was tried.
    pub methods: Vec<ComparedMethod>,
    /// It ended before all were tried.
    pub interrupted: bool,
}

/// A method with its error and run time.
pub struct ComparedMethod {
    /// Name of the method.
    pub method: &'static str,
    /// Model size; absent where nothing is chosen.
    pub size: Option<ModelSize>,
    /// Relative error.
    pub error: Option<f64>,
    /// The least time of its repeats, s.
    pub seconds: f64,
    /// Why it came to no end.
    pub failure: Option<String>,
}

/// Model size of a method.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ModelSize {
    /// So many coordinates are kept.
    Coordinates(usize),
    /// So many elastic modes are kept.
    Modes(usize),
    /// Every shaft with a mass of its own is cut in so many lengths.
    ShaftElements(usize),
    /// A mesh at so many positions of a pitch, in so many slices along the face.
    MeshGrid {
        /// Positions.
        positions: usize,
        /// Slices.
        slices: usize,
    },
    /// A path of contact at so many positions of a pitch.
    Positions(usize),
    /// A mesh of flanks at so many positions of a pitch and stations along the face.
    FlankGrid {
        /// Positions.
        positions: usize,
        /// Stations.
        stations: usize,
    },
}

impl ComparisonResult {
    /// The quickest way to an error.
    pub fn cheapest(&self, error: f64) -> Option<&ComparedMethod> {
        let reached = self
            .methods
            .iter()
            .filter(|w| w.error.is_some_and(|e| e <= error));
        reached.min_by(|a, b| a.seconds.total_cmp(&b.seconds))
    }

    /// Most accurate method.
    pub fn most_accurate(&self) -> Option<&ComparedMethod> {
        let off = |w: &ComparedMethod| w.error.unwrap_or(f64::INFINITY);
        let ended = self.methods.iter().filter(|w| w.error.is_some());
        ended.min_by(|a, b| off(a).total_cmp(&off(b)))
    }
}

impl ComparedMethod {
    /// Times a method, with the least time of several repeats; `judge` returns the error of its result.
    pub fn time_method<T>(
        method: &'static str,
        size: Option<ModelSize>,
        task: impl FnMut() -> Result<T, Error>,
        judge: impl FnOnce(T) -> Result<f64, String>,
    ) -> ComparedMethod {
        let (outcome, seconds) = min_time(task);
        ComparedMethod::with_error(method, size, outcome, seconds, judge)
    }

    /// A way that was taken in so many seconds.
    pub fn with_error<T>(
        method: &'static str,
        size: Option<ModelSize>,
        outcome: Result<T, Error>,
        seconds: f64,
        judge: impl FnOnce(T) -> Result<f64, String>,
    ) -> ComparedMethod {
        let (error, failed) = match outcome.map_err(|e| e.message).and_then(judge) {
            Ok(error) => (Some(error), None),
            Err(why) => (None, Some(why)),
        };
        ComparedMethod {
            method,
            size,
            error,
            seconds,
            failure: failed,
        }
    }
}
