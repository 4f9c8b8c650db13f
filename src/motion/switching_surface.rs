//! Switching surfaces of a regime: contact gaps, friction breakaway, ends of wave pieces.

use super::contact::Affine;
use super::dynamic_model::{DynamicModel, ElementState, ForceElement, ForceLaw, Regime};
use super::friction::FrictionState;
use super::load_friction::FrictionLevers;
use super::wave::{WavePhase, Waveform};
use crate::machine::direction::Direction;

/// A switching surface of the present regime. Above zero the regime holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SwitchingSurface {
    /// Contact surface: the branch, which of its switching surfaces.
    Contact(usize, usize),
    /// A pair slides until its rate turns.
    SlipReversal(usize),
    /// A pair sticks until it would have to hold its breakaway force, in this sense.
    Breakaway(usize, FrictionState),
    /// A wave that follows an angle comes to the end of a piece: number among the spans, and whether upward.
    PieceEnd(usize, bool),
}

/// Interval of ψ that a piece of a wave spans.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WavePiece {
    /// Whose wave.
    pub branch: usize,
    /// Kind of the wave.
    pub kind: WaveKind,
    turn: f64,
    piece: usize,
}

/// Kind of a piecewise wave over an angle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WaveKind {
    /// The stiffness.
    Stiffness,
    /// A wave of e.
    Error(usize),
    /// Friction along the path of contact.
    Path,
}

/// A period in pieces.
struct PiecewiseWave<'a> {
    phase: &'a WavePhase,
    edges: PieceEdges<'a>,
}

enum PieceEdges<'a> {
    Shape(&'a Waveform),
    Path(&'a FrictionLevers),
}

impl PiecewiseWave<'_> {
    fn pieces(&self) -> usize {
        match self.edges {
            PieceEdges::Shape(waveform) => pieces(waveform),
            PieceEdges::Path(path) => path.pieces.len(),
        }
    }

    fn edge(&self, at: usize) -> f64 {
        match self.edges {
            PieceEdges::Shape(waveform) => edge(waveform, at),
            PieceEdges::Path(path) => path.edge(at),
        }
    }

    fn piece(&self, psi: f64) -> usize {
        match self.edges {
            PieceEdges::Shape(waveform) => waveform.piece(psi),
            PieceEdges::Path(path) => path.piece(psi),
        }
    }
}

/// Piecewise wave of a branch.
fn periodic(branch: &ForceElement, of: WaveKind) -> Option<PiecewiseWave<'_>> {
    let wave = match of {
        WaveKind::Stiffness => branch.stiffness_wave.as_ref()?,
        WaveKind::Error(at) => branch.angle_waves.get(at)?,
        WaveKind::Path => {
            let ForceLaw::LoadFriction(pressed) = &branch.law else {
                return None;
            };
            let path = pressed.path.as_ref()?;
            return Some(PiecewiseWave {
                phase: path.phase.as_ref()?,
                edges: PieceEdges::Path(path),
            });
        }
    };
    Some(PiecewiseWave {
        phase: &wave.phase,
        edges: PieceEdges::Shape(&wave.waveform),
    })
}

impl WavePiece {
    /// The piece before or after.
    pub fn advance(&mut self, model: &DynamicModel, up: bool) {
        let Some(wave) = periodic(&model.elements[self.branch], self.kind) else {
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

    /// dψ/dt of the wave, periods per second.
    pub fn rate(&self, model: &DynamicModel, t: f64, y: &[f64]) -> f64 {
        let n = model.coordinate_count();
        let wave = periodic(&model.elements[self.branch], self.kind);
        wave.map_or(0.0, |wave| wave.phase.rate(t, &y[n..2 * n]))
    }

    /// Piece number.
    pub fn piece(&self) -> u32 {
        self.piece as u32
    }
}

/// Number of pieces in a period; one where it is smooth.
fn pieces(waveform: &Waveform) -> usize {
    match waveform {
        Waveform::Rectangular { .. } => 2,
        Waveform::Fourier { .. } => 1,
        Waveform::Table(values) => values.len(),
    }
}

/// Edge of a piece in its period (beginning or end).
fn edge(waveform: &Waveform, at: usize) -> f64 {
    match waveform {
        Waveform::Rectangular { duty, .. } => [0.0, *duty, 1.0][at],
        Waveform::Fourier { .. } => at as f64,
        Waveform::Table(values) => at as f64 / values.len() as f64,
    }
}

/// Pieces, at a state, of the waves that follow an angle and have corners or jumps.
pub fn wave_pieces(model: &DynamicModel, t: f64, y: &[f64]) -> Vec<WavePiece> {
    let q = &y[..model.coordinate_count()];
    let mut spans = Vec::new();
    for (at, branch) in model.elements.iter().enumerate() {
        let errors = (0..branch.angle_waves.len()).map(WaveKind::Error);
        for of in [WaveKind::Stiffness, WaveKind::Path]
            .into_iter()
            .chain(errors)
        {
            let Some(wave) = periodic(branch, of) else {
                continue;
            };
            if matches!(wave.phase, WavePhase::FollowsAngle { .. }) && wave.pieces() > 1 {
                let psi = wave.phase.phase_at(t, q);
                spans.push(WavePiece {
                    branch: at,
                    kind: of,
                    turn: psi.floor(),
                    piece: wave.piece(psi),
                });
            }
        }
    }
    spans
}

/// Piece, at a state, of each wave that imposes a displacement over an angle, by branch.
pub fn error_wave_pieces(model: &DynamicModel, t: f64, y: &[f64]) -> Vec<Vec<u32>> {
    let q = &y[..model.coordinate_count()];
    let of = |b: &ForceElement| {
        let pieces = b.waves_at(t, q, b.pieces_at(t));
        pieces.map(|(_, _, piece)| piece as u32).collect()
    };
    model.elements.iter().map(of).collect()
}

/// The switching surfaces of a regime.
pub fn switching_surfaces(
    model: &DynamicModel,
    regime: &Regime,
    spans: &[WavePiece],
) -> Vec<SwitchingSurface> {
    let mut all = Vec::new();
    for (at, branch) in model.elements.iter().enumerate() {
        match (&branch.law, regime.states[at]) {
            (ForceLaw::Contact(contact), ElementState::Contact(state, _)) => {
                let count = contact.switching_functions(state, 1.0).len();
                all.extend((0..count).map(|which| SwitchingSurface::Contact(at, which)));
            }
            (law, ElementState::Friction(FrictionState::Stick)) if law.is_dry_friction() => {
                all.push(SwitchingSurface::Breakaway(at, FrictionState::Forward));
                all.push(SwitchingSurface::Breakaway(at, FrictionState::Backward));
            }
            (law, ElementState::Friction(_)) if law.is_dry_friction() => {
                all.push(SwitchingSurface::SlipReversal(at))
            }
            _ => {}
        }
    }
    all.extend(
        (0..spans.len()).flat_map(|at| [true, false].map(|up| SwitchingSurface::PieceEnd(at, up))),
    );
    all
}

impl SwitchingSurface {
    /// The branch it belongs to.
    pub fn branch(&self, spans: &[WavePiece]) -> usize {
        match *self {
            SwitchingSurface::Contact(branch, _)
            | SwitchingSurface::SlipReversal(branch)
            | SwitchingSurface::Breakaway(branch, _) => branch,
            SwitchingSurface::PieceEnd(span, _) => spans[span].branch,
        }
    }

    /// Value of the switching function at a state, and the size of the terms that it is a difference of.
    pub fn value(
        &self,
        model: &DynamicModel,
        regime: &Regime,
        spans: &[WavePiece],
        t: f64,
        y: &[f64],
    ) -> (f64, f64) {
        let n = model.coordinate_count();
        let (q, v) = (&y[..n], &y[n..2 * n]);
        let deflection = |branch: usize| {
            model.elements[branch].deflection(t, q, v, model.error_pieces(Some(regime), branch, t))
        };
        match *self {
            SwitchingSurface::Contact(branch, which) => {
                let (delta, rate) = deflection(branch);
                let affine = contact_boundary(model, regime, (branch, which), (t, q), delta)
                    .unwrap_or(Affine {
                        constant: f64::INFINITY,
                        ..Affine::default()
                    });
                let b = &model.elements[branch];
                let size = affine.constant.abs()
                    + affine.deflection.abs() * (rounding_scale(&b.direction, q) + delta.abs())
                    + affine.rate.abs() * (rounding_scale(&b.direction, v) + rate.abs());
                (affine.value_at(delta, rate), size)
            }
            SwitchingSurface::SlipReversal(branch) => {
                let (_, rate) = deflection(branch);
                let sign = match regime.states[branch] {
                    ElementState::Friction(slip) => slip.sign(),
                    _ => 0.0,
                };
                (
                    sign * rate,
                    rounding_scale(&model.elements[branch].direction, v),
                )
            }
            SwitchingSurface::Breakaway(branch, slip) => {
                let dry = model.friction_at(branch, Some(regime), t, y);
                let breakaway = dry.map_or(f64::INFINITY, |friction| friction.breakaway);
                let held = model.friction_force(regime, t, y, branch);
                (
                    breakaway - slip.sign() * held,
                    1e2 * (breakaway + held.abs()),
                )
            }
            SwitchingSurface::PieceEnd(at, up) => {
                let span = &spans[at];
                let Some(wave) = periodic(&model.elements[span.branch], span.kind) else {
                    return (f64::INFINITY, 0.0);
                };
                let psi = wave.phase.phase_at(t, q);
                let left = match up {
                    true => span.turn + wave.edge(span.piece + 1) - psi,
                    false => psi - span.turn - wave.edge(span.piece),
                };
                (left, psi.abs() + span.turn.abs() + 1.0)
            }
        }
    }
}

/// Switching function of a contact with its secant stiffness at a deflection.
fn contact_boundary(
    model: &DynamicModel,
    regime: &Regime,
    (branch, which): (usize, usize),
    at: (f64, &[f64]),
    delta: f64,
) -> Option<Affine> {
    let b: &ForceElement = &model.elements[branch];
    match (&b.law, regime.states[branch]) {
        (ForceLaw::Contact(contact), ElementState::Contact(state, piece)) => {
            let g = contact.penetration(state, delta);
            let spring = b.contact_spring(at, g, piece);
            let functions = contact.switching_functions(state, spring.secant);
            functions.get(which).map(|function| function.0)
        }
        _ => None,
    }
}

/// `Σ |w_i x_i|`.
fn rounding_scale(direction: &Direction, x: &[f64]) -> f64 {
    direction.entries().map(|(i, a)| (a * x[i]).abs()).sum()
}
