//! Load on the modal parts between two time events; constant inputs are summed once.

use super::double_time::DoubleTime;
use super::event_function::EventFunction;
use super::inputs::KnownInputs;
use super::linear_system::LinearSystem;
use super::mass_normalised::dot;
use crate::numeric::vector_ops::axpy;

/// The inputs on some lines.
#[derive(Debug, Default)]
pub struct PieceLoad {
    /// The lines.
    pieces: Vec<u32>,
    /// Push on σ by all terms constant in time.
    pub push: Vec<f64>,
    /// Constant offsets of every switching function.
    pub events: Vec<EventOffset>,
    /// The inputs that rise or fall.
    pub rising: Vec<usize>,
}

/// Constant part of a switching function.
#[derive(Debug)]
pub struct EventOffset {
    /// Part outside σ.
    pub base: f64,
    /// The size of what that is summed from.
    pub size: f64,
    /// Part of ṗ in addition to the row of σ.
    pub push: f64,
}

impl PieceLoad {
    /// Whether it is of these lines.
    pub fn matches(&self, pieces: &[u32]) -> bool {
        self.pieces == pieces
    }

    /// Piece load of a machine with constant push and its switching surfaces.
    pub fn new(
        inputs: &KnownInputs,
        pieces: &[u32],
        (linear_model, constant): (&LinearSystem, &[f64]),
        events: &[EventFunction],
    ) -> PieceLoad {
        // Lines that stand still say the same at any instant.
        let lines = inputs.list.iter();
        let lines: Vec<(f64, f64)> = lines
            .map(|i| i.line(pieces, DoubleTime::new(0.0)))
            .collect();
        let still = |&input: &usize| lines[input].1 == 0.0;
        let mut push = constant.to_vec();
        for input in (0..lines.len()).filter(still) {
            axpy(&mut push, lines[input].0, &linear_model.pushes[input][0]);
        }
        let of_border = |event: &EventFunction| {
            let own = event.direct.iter().filter(|(input, _)| still(input));
            let parts = own.map(|&(input, [value, _])| value * lines[input].0);
            let parts: Vec<f64> = parts.collect();
            EventOffset {
                base: event.constant + parts.iter().sum::<f64>(),
                size: event.constant.abs() + parts.iter().map(|x| x.abs()).sum::<f64>(),
                push: dot(&event.row, &push),
            }
        };
        PieceLoad {
            events: events.iter().map(of_border).collect(),
            rising: (0..lines.len()).filter(|input| !still(input)).collect(),
            pieces: pieces.to_vec(),
            push,
        }
    }
}
