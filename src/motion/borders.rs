//! Where a regime ends: contacts at the edge of their play, friction at rest or at its breakaway force, waves that follow an angle at the end of a piece.

use super::contact::{Affine, Stand};
use super::friction::Slip;
use super::rubbing::Path;
use super::train::{Branch, BranchStand, Law, Regime, Train};
use super::wave::{Phase, Shape};
use crate::machine::direction::Direction;

/// A border of the present regime. Above zero the regime holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Border {
    /// Of a contact: the branch, which of its borders.
    Contact(usize, usize),
    /// A pair slides until its rate turns.
    Rest(usize),
    /// A pair sticks until it would have to hold its breakaway force, in this sense.
    Loose(usize, Slip),
    /// A wave that follows an angle comes to the end of a piece: number among the spans, and whether upward.
    Piece(usize, bool),
}

/// The stretch of ψ that a piece of a wave spans.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Span {
    /// Whose wave.
    pub branch: usize,
    /// Of what.
    pub of: Of,
    turn: f64,
    piece: usize,
}

/// What goes by pieces over an angle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Of {
    /// The stiffness.
    Stiffness,
    /// A wave of e.
    Error(usize),
    /// Friction along the path of contact.
    Path,
}

/// A period in pieces.
struct Periodic<'a> {
    phase: &'a Phase,
    edges: Edges<'a>,
}

enum Edges<'a> {
    Shape(&'a Shape),
    Path(&'a Path),
}

impl Periodic<'_> {
    fn pieces(&self) -> usize {
        match self.edges {
            Edges::Shape(shape) => pieces(shape),
            Edges::Path(path) => path.pieces.len(),
        }
    }

    fn edge(&self, at: usize) -> f64 {
        match self.edges {
            Edges::Shape(shape) => edge(shape, at),
            Edges::Path(path) => path.edge(at),
        }
    }

    fn piece(&self, psi: f64) -> usize {
        match self.edges {
            Edges::Shape(shape) => shape.piece(psi),
            Edges::Path(path) => path.piece(psi),
        }
    }
}

/// What of a branch goes by pieces.
fn periodic(branch: &Branch, of: Of) -> Option<Periodic<'_>> {
    let wave = match of {
        Of::Stiffness => branch.variation.as_ref()?,
        Of::Error(at) => branch.followed.get(at)?,
        Of::Path => {
            let Law::Pressed(pressed) = &branch.law else {
                return None;
            };
            let path = pressed.path.as_ref()?;
            return Some(Periodic {
                phase: path.phase.as_ref()?,
                edges: Edges::Path(path),
            });
        }
    };
    Some(Periodic {
        phase: &wave.phase,
        edges: Edges::Shape(&wave.shape),
    })
}

impl Span {
    /// The piece before or after.
    pub fn step(&mut self, train: &Train, up: bool) {
        let Some(wave) = periodic(&train.branches[self.branch], self.of) else {
            return;
        };
        let last = wave.pieces() - 1;
        match (up, self.piece) {
            (true, piece) if piece == last => (self.turn, self.piece) = (self.turn + 1.0, 0),
            (true, _) => self.piece += 1,
            (false, 0) => (self.turn, self.piece) = (self.turn - 1.0, last),
            (false, _) => self.piece -= 1,
        }
    }

    /// Its piece.
    pub fn piece(&self) -> u32 {
        self.piece as u32
    }
}

/// How many pieces a period has; one where it is smooth.
fn pieces(shape: &Shape) -> usize {
    match shape {
        Shape::Rectangular { .. } => 2,
        Shape::Fourier { .. } => 1,
        Shape::Table(values) => values.len(),
    }
}

/// Where a piece begins or ends in its period.
fn edge(shape: &Shape, at: usize) -> f64 {
    match shape {
        Shape::Rectangular { duty, .. } => [0.0, *duty, 1.0][at],
        Shape::Fourier { .. } => at as f64,
        Shape::Table(values) => at as f64 / values.len() as f64,
    }
}

/// Waves that follow an angle and have corners or jumps, as they stand at a state.
pub fn spans(train: &Train, t: f64, y: &[f64]) -> Vec<Span> {
    let q = &y[..train.n()];
    let mut spans = Vec::new();
    for (at, branch) in train.branches.iter().enumerate() {
        let errors = (0..branch.followed.len()).map(Of::Error);
        for of in [Of::Stiffness, Of::Path].into_iter().chain(errors) {
            let Some(wave) = periodic(branch, of) else {
                continue;
            };
            if matches!(wave.phase, Phase::Followed { .. }) && wave.pieces() > 1 {
                let psi = wave.phase.at(t, q);
                spans.push(Span {
                    branch: at,
                    of,
                    turn: psi.floor(),
                    piece: wave.piece(psi),
                });
            }
        }
    }
    spans
}

/// The borders of a regime.
pub fn borders(train: &Train, regime: &Regime, spans: &[Span]) -> Vec<Border> {
    let mut all = Vec::new();
    for (at, branch) in train.branches.iter().enumerate() {
        match (&branch.law, regime.stands[at]) {
            (Law::Contact(contact), BranchStand::Contact(stand, _)) => {
                let count = contact.borders(stand, 1.0).len();
                all.extend((0..count).map(|which| Border::Contact(at, which)));
            }
            (law, BranchStand::Friction(Slip::Stick)) if law.is_dry() => {
                all.push(Border::Loose(at, Slip::Forward));
                all.push(Border::Loose(at, Slip::Backward));
            }
            (law, BranchStand::Friction(_)) if law.is_dry() => all.push(Border::Rest(at)),
            _ => {}
        }
    }
    all.extend((0..spans.len()).flat_map(|at| [true, false].map(|up| Border::Piece(at, up))));
    all
}

impl Border {
    /// The branch it belongs to.
    pub fn branch(&self, spans: &[Span]) -> usize {
        match *self {
            Border::Contact(branch, _) | Border::Rest(branch) | Border::Loose(branch, _) => branch,
            Border::Piece(span, _) => spans[span].branch,
        }
    }

    /// Its value at a state, and the size of what it is a difference of.
    pub fn value(
        &self,
        train: &Train,
        regime: &Regime,
        spans: &[Span],
        t: f64,
        y: &[f64],
    ) -> (f64, f64) {
        let n = train.n();
        let (q, v) = (&y[..n], &y[n..2 * n]);
        let deflection = |branch: usize| {
            train.branches[branch].deflection(t, q, v, train.imposed_piece(regime, branch))
        };
        match *self {
            Border::Contact(branch, which) => {
                let (delta, rate) = deflection(branch);
                let affine = of_contact(train, regime, branch, which, t, q).map_or(
                    Affine {
                        constant: f64::INFINITY,
                        ..Affine::default()
                    },
                    |border| border.0,
                );
                let b = &train.branches[branch];
                let size = affine.constant.abs()
                    + affine.deflection.abs() * (spread(&b.direction, q) + delta.abs())
                    + affine.rate.abs() * (spread(&b.direction, v) + rate.abs());
                (affine.at(delta, rate), size)
            }
            Border::Rest(branch) => {
                let (_, rate) = deflection(branch);
                let sign = match regime.stands[branch] {
                    BranchStand::Friction(slip) => slip.sign(),
                    _ => 0.0,
                };
                (sign * rate, spread(&train.branches[branch].direction, v))
            }
            Border::Loose(branch, slip) => {
                let dry = train.dry(branch, Some(regime), t, y);
                let breakaway = dry.map_or(f64::INFINITY, |friction| friction.breakaway);
                let held = train.held(regime, t, y, branch);
                (
                    breakaway - slip.sign() * held,
                    1e2 * (breakaway + held.abs()),
                )
            }
            Border::Piece(at, up) => {
                let span = &spans[at];
                let Some(wave) = periodic(&train.branches[span.branch], span.of) else {
                    return (f64::INFINITY, 0.0);
                };
                let psi = wave.phase.at(t, q);
                let left = match up {
                    true => span.turn + wave.edge(span.piece + 1) - psi,
                    false => psi - span.turn - wave.edge(span.piece),
                };
                (left, psi.abs() + span.turn.abs() + 1.0)
            }
        }
    }
}

/// A border of a contact, and how it stands beyond.
pub fn of_contact(
    train: &Train,
    regime: &Regime,
    branch: usize,
    which: usize,
    t: f64,
    q: &[f64],
) -> Option<(Affine, Stand)> {
    let b: &Branch = &train.branches[branch];
    match (&b.law, regime.stands[branch]) {
        (Law::Contact(contact), BranchStand::Contact(stand, piece)) => contact
            .borders(stand, b.factor(t, q, piece).0)
            .get(which)
            .copied(),
        _ => None,
    }
}

/// `Σ |w_i x_i|`.
fn spread(direction: &Direction, x: &[f64]) -> f64 {
    direction.scaled().map(|(i, a)| (a * x[i]).abs()).sum()
}
