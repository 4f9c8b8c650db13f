//! What acts on a machine while no known line gives way to another: inputs whose lines stand still are constants.

use super::border::Border;
use super::frame::dot;
use super::inputs::Inputs;
use super::instant::Instant;
use super::linear::Linear;
use crate::numeric::slices::add;

/// The inputs on some lines.
#[derive(Debug, Default)]
pub struct Load {
    /// The lines.
    pieces: Vec<u32>,
    /// Push on σ, and of every border, by all that stands still.
    pub push: Vec<f64>,
    /// Of every border.
    pub borders: Vec<Still>,
    /// The inputs that rise or fall.
    pub rising: Vec<usize>,
}

/// What of a border stands still.
#[derive(Debug)]
pub struct Still {
    /// What is not σ.
    pub base: f64,
    /// The size of what that is summed from.
    pub size: f64,
    /// What ṗ has beside the row of σ.
    pub push: f64,
}

impl Load {
    /// Whether it is of these lines.
    pub fn is_on(&self, pieces: &[u32]) -> bool {
        self.pieces == pieces
    }

    /// Of a machine with constant push and its borders.
    pub fn new(
        inputs: &Inputs,
        pieces: &[u32],
        (linear, constant): (&Linear, &[f64]),
        borders: &[Border],
    ) -> Load {
        // Lines that stand still say the same at any instant.
        let lines = inputs.list.iter();
        let lines: Vec<(f64, f64)> = lines.map(|i| i.line(pieces, Instant::new(0.0))).collect();
        let still = |&input: &usize| lines[input].1 == 0.0;
        let mut push = constant.to_vec();
        for input in (0..lines.len()).filter(still) {
            add(&mut push, lines[input].0, &linear.pushes[input][0]);
        }
        let of_border = |border: &Border| {
            let own = border.direct.iter().filter(|(input, _)| still(input));
            let parts = own.map(|&(input, [value, _])| value * lines[input].0);
            let parts: Vec<f64> = parts.collect();
            Still {
                base: border.constant + parts.iter().sum::<f64>(),
                size: border.constant.abs() + parts.iter().map(|x| x.abs()).sum::<f64>(),
                push: dot(&border.row, &push),
            }
        };
        Load {
            borders: borders.iter().map(of_border).collect(),
            rising: (0..lines.len()).filter(|input| !still(input)).collect(),
            pieces: pieces.to_vec(),
            push,
        }
    }
}
