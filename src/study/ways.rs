//! Ways to one answer, exact and approximate, against one reference.

use super::timing::least;
use crate::base::error::Error;

/// What every way to an answer costs.
pub struct Ways {
    /// What is compared, in words.
    pub compared: String,
    /// How errors are measured, in words.
    pub norm: &'static str,
    /// Freedoms of the machine, without rigid joints.
    pub freedoms: usize,
    /// What the errors are against.
    pub reference: String,
    /// Its own relative error, below which none can be told.
    pub reference_error: f64,
    /// Every way that was tried.
    pub list: Vec<Way>,
    /// It ended before all were tried.
    pub interrupted: bool,
}

/// One way.
pub struct Way {
    /// Its name.
    pub method: &'static str,
    /// How fine; absent where nothing is chosen.
    pub size: Option<Size>,
    /// Its relative error.
    pub error: Option<f64>,
    /// The least time of its repeats, s.
    pub seconds: f64,
    /// Why it came to no end.
    pub failed: Option<String>,
}

/// How fine a way is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Size {
    /// So many coordinates are kept.
    Coordinates(usize),
    /// So many elastic modes are kept.
    Modes(usize),
    /// Every shaft with a mass of its own is cut in so many lengths.
    Lengths(usize),
}

impl Ways {
    /// The quickest way to an error.
    pub fn cheapest(&self, error: f64) -> Option<&Way> {
        let reached = self
            .list
            .iter()
            .filter(|w| w.error.is_some_and(|e| e <= error));
        reached.min_by(|a, b| a.seconds.total_cmp(&b.seconds))
    }

    /// The way that comes nearest to the answer.
    pub fn nearest(&self) -> Option<&Way> {
        let off = |w: &Way| w.error.unwrap_or(f64::INFINITY);
        let ended = self.list.iter().filter(|w| w.error.is_some());
        ended.min_by(|a, b| off(a).total_cmp(&off(b)))
    }
}

impl Way {
    /// Takes a way, with the least time of several repeats; `judge` says how far its answer is off.
    pub fn taken<T>(
        method: &'static str,
        size: Option<Size>,
        task: impl FnMut() -> Result<T, Error>,
        judge: impl FnOnce(T) -> Result<f64, String>,
    ) -> Way {
        let (outcome, seconds) = least(task);
        Way::judged(method, size, outcome, seconds, judge)
    }

    /// A way that was taken in so many seconds.
    pub fn judged<T>(
        method: &'static str,
        size: Option<Size>,
        outcome: Result<T, Error>,
        seconds: f64,
        judge: impl FnOnce(T) -> Result<f64, String>,
    ) -> Way {
        let (error, failed) = match outcome.map_err(|e| e.message).and_then(judge) {
            Ok(error) => (Some(error), None),
            Err(why) => (None, Some(why)),
        };
        Way {
            method,
            size,
            error,
            seconds,
            failed,
        }
    }
}
