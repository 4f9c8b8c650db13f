//! Correction of settings: Gauss–Newton on exact distances along the normals of nodes, in the directions of settings that the flank shows.
//!
//! Unknowns are changes of settings in units of their reach and the turn of each flank about the work's axis, which costs nothing. A direction
//! whose singular value is below a least displacement is not used: its change could not be measured, and the settings would run away
//! along it (truncated singular value decomposition: Hansen, Rank-Deficient and Discrete Ill-Posed Problems, 1998, section 3.2).

use super::measured_flank::{FlankNode, MeasuredFlank};
use super::node_sensitivities::NodeSensitivities;
use super::root_point::TipPass;
use super::sensitivity::MachineChain;
use super::setting::{FlankSetup, Setting};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::gear::bevel::flank::FlankEnvelope;
use crate::gear::bevel::frames::WorkFrame;
use crate::gear::kernel::envelope::Envelope;
use crate::gear::kernel::pose::Pose;
use crate::gear::kernel::vector::Vector;
use crate::numeric::Matrix;

/// A number that a correction changes.
#[derive(Debug, Clone, PartialEq)]
pub struct Unknown {
    /// The setting.
    pub setting: Setting,
    /// Indices of the flanks that it moves: both where they are cut at one setting.
    pub flanks: Vec<usize>,
    /// Change by which a machine may reasonably be set, m, rad or a bare number: the unit of its column.
    pub reach: f64,
}

/// Flanks with their deviations, and what may be changed.
#[derive(Debug, Clone)]
pub struct CorrectionProblem {
    /// Measured flanks.
    pub flanks: Vec<MeasuredFlank>,
    /// Settings that may be changed.
    pub unknowns: Vec<Unknown>,
    /// Least root mean square over the nodes by which a direction of settings moves the flank, m.
    pub least: f64,
}

/// Settings whose flanks have the deviations.
#[derive(Debug, Clone)]
pub struct CorrectionFit {
    /// Settings of each flank.
    pub setups: Vec<FlankSetup>,
    /// Turns of each flank about the work's axis, rad.
    pub turns: Vec<f64>,
    /// Changes of the unknowns, m, rad or bare numbers.
    pub changes: Vec<f64>,
    /// Deviations less those of the found flank, by flank and node, m; none where the found flank has no point.
    pub rests: Vec<Vec<Option<f64>>>,
    /// Sensitivities at the settings of the start.
    pub nominal: NodeSensitivities,
    /// Sensitivities at the found settings.
    pub fitted: NodeSensitivities,
    /// Directions used.
    pub kept: usize,
    /// Steps taken.
    pub steps: usize,
    /// The last step changed nothing that could be measured.
    pub is_converged: bool,
}

/// Steps before the search is given up.
const STEPS: usize = 60;
/// A step that takes less than this from the deviations is the last, m: the next would be rounding.
const LAST_STEP: f64 = 1e-12;
/// Largest change of a setting in a step, in its reach.
const LARGEST_STEP: f64 = 6.0;
/// Halvings of a step that does not lower the deviations.
const HALVINGS: usize = 8;
/// Root mean square that rounding may add, m.
const ROUNDING: f64 = 1e-13;
/// Weight of a change of the slot's depth next to a deviation of the flank: depths are held to hundredths of a millimetre, flanks to
/// micrometres.
pub(super) const ROOT_WEIGHT: f64 = 0.1;

/// One flank at trial settings.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Trial {
    setup: FlankSetup,
    turn: f64,
}

/// The point at which a trial flank meets the ray of a node.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Hit {
    /// Index of flank and node.
    node: [usize; 2],
    at: [f64; 3],
    /// Normal of the trial flank there.
    normal: Vector,
    /// Deviation of the node less the distance to the trial flank, m.
    rest: f64,
}

/// Hits of the nodes by a trial, and its passes over the root.
#[derive(Debug, Clone, PartialEq)]
struct RayHits {
    hits: Vec<Hit>,
    /// Index of the flank, pass, and weighted rest of its height, m.
    passes: Vec<(usize, TipPass, f64)>,
}

impl RayHits {
    fn rests(&self) -> Vec<f64> {
        let of_nodes = self.hits.iter().map(|hit| hit.rest);
        of_nodes
            .chain(self.passes.iter().map(|pass| pass.2))
            .collect()
    }

    /// Root of the sum of squares over the number of nodes.
    fn rms(&self) -> f64 {
        let squares: f64 = self.rests().iter().map(|x| x * x).sum();
        (squares / self.hits.len().max(1) as f64).sqrt()
    }
}

impl CorrectionProblem {
    /// Settings within the problem's whose flanks have the deviations as nearly as the directions shown by the flank allow.
    ///
    /// # Errors
    /// Nodes that the flanks at the start do not reach, fewer of them than unknowns.
    pub fn solve(&self) -> Result<CorrectionFit, Error> {
        let start = |flank: &MeasuredFlank| Trial {
            setup: flank.setup,
            turn: 0.0,
        };
        let mut trials: Vec<Trial> = self.flanks.iter().map(start).collect();
        let mut rays = self.ray_hits(&trials, None);
        self.check(&rays.hits)?;
        let nominal = self.system(&trials, &rays)?;
        let kept = nominal.seen(self.least);
        let mut system = nominal.clone();
        let mut changes = vec![0.0; self.unknowns.len()];
        let (mut steps, mut is_converged) = (0, false);
        while steps < STEPS && !is_converged {
            steps += 1;
            let step = system.step(&rays.rests(), kept.min(rays.hits.len()));
            let largest = step.changes.iter().fold(0f64, |most, x| most.max(x.abs()));
            let cut = if largest > LARGEST_STEP {
                LARGEST_STEP / largest
            } else {
                1.0
            };
            is_converged = cut == 1.0 && step.removed <= LAST_STEP;
            let moved = (0..HALVINGS).find_map(|halving| {
                let share = cut * 0.5f64.powi(halving as i32);
                let next = self.stepped(&trials, &step.changes, &step.turns, share);
                let found = self.ray_hits(&next, Some(&rays.hits));
                let is_better = 2 * found.hits.len() >= self.count()
                    && found.passes.len() == rays.passes.len()
                    && found.rms() <= rays.rms() + ROUNDING;
                is_better.then_some((share, next, found))
            });
            let Some((share, next, found)) = moved else {
                is_converged = step.removed <= UNSEEN;
                break;
            };
            for ((change, by), unknown) in changes.iter_mut().zip(&step.changes).zip(&self.unknowns)
            {
                *change += share * by * unknown.reach;
            }
            (trials, rays) = (next, found);
            system = self.system(&trials, &rays)?;
        }
        let mut rests: Vec<Vec<Option<f64>>> = self
            .flanks
            .iter()
            .map(|f| vec![None; f.nodes.len()])
            .collect();
        for hit in &rays.hits {
            rests[hit.node[0]][hit.node[1]] = Some(hit.rest);
        }
        Ok(CorrectionFit {
            setups: trials.iter().map(|trial| trial.setup).collect(),
            turns: trials.iter().map(|trial| trial.turn).collect(),
            changes,
            rests,
            nominal,
            fitted: system,
            kept,
            steps,
            is_converged,
        })
    }

    /// Number of nodes.
    fn count(&self) -> usize {
        self.flanks.iter().map(|flank| flank.nodes.len()).sum()
    }

    fn check(&self, hits: &[Hit]) -> Result<(), Error> {
        let needed = self.unknowns.len() + self.flanks.len();
        if hits.len() >= needed {
            return Ok(());
        }
        let message = format!(
            "{} nodes lie on the flank of the settings, and {needed} unknowns (settings, and a turn of each flank) need as many at least",
            hits.len()
        );
        Err(Error::new(Code::IllPosed, message)
            .with_hint("free fewer settings, or measure more nodes"))
    }

    /// Trials after a share of a step.
    fn stepped(&self, trials: &[Trial], changes: &[f64], turns: &[f64], share: f64) -> Vec<Trial> {
        let mut next = trials.to_vec();
        for (trial, turn) in next.iter_mut().zip(turns) {
            trial.turn += share * turn;
        }
        for (unknown, change) in self.unknowns.iter().zip(changes) {
            for flank in &unknown.flanks {
                let by = share * change * unknown.reach;
                next[*flank].setup = next[*flank].setup.changed(unknown.setting, by);
            }
        }
        next
    }

    /// Hits of all rays, from those of other trials where there are any, and passes over the root; where a trial flank is undercut or ends
    /// it has none.
    fn ray_hits(&self, trials: &[Trial], before: Option<&[Hit]>) -> RayHits {
        let mut hits = Vec::with_capacity(self.count());
        let mut passes = Vec::new();
        for (f, (flank, trial)) in self.flanks.iter().zip(trials).enumerate() {
            let envelope = trial.envelope(flank);
            for (k, node) in flank.nodes.iter().enumerate() {
                let near = before.and_then(|hits| hits.iter().find(|hit| hit.node == [f, k]));
                let start = near.map_or(node.at, |hit| hit.at);
                if let Some((at, normal, distance)) = intersect(&envelope, node, start) {
                    hits.push(Hit {
                        node: [f, k],
                        at,
                        normal,
                        rest: flank.deviations[k] - distance,
                    });
                }
            }
            for root in &flank.roots {
                let pass = root.pass(&trial.setup, flank.hand, trial.turn);
                passes.extend(pass.map(|pass| {
                    let rest = ROOT_WEIGHT * (root.height - pass.height);
                    (f, pass, rest)
                }));
            }
        }
        RayHits { hits, passes }
    }

    /// Sensitivities at the hits and of the passes.
    ///
    /// Along a ray of direction n a flank of normal m advances by `m·∂r/∂p / m·n`; a point of the root comes nearer to the tip plane of
    /// normal n by `n·∂r/∂p`.
    fn system(&self, trials: &[Trial], rays: &RayHits) -> Result<NodeSensitivities, Error> {
        let count = rays.hits.len() + rays.passes.len();
        let mut columns = Matrix::zeros(count, self.unknowns.len());
        let mut turns = Matrix::zeros(count, self.flanks.len());
        let mut row = |i: usize, f: usize, normal: Vector, by: &dyn Fn(Setting) -> Vector| {
            for (j, unknown) in self.unknowns.iter().enumerate() {
                if unknown.flanks.contains(&f) {
                    columns[(i, j)] = normal.dot(by(unknown.setting)) * unknown.reach;
                }
            }
        };
        // The chain ends in the work before its turn.
        let before_turn = |f: usize, v: Vector| {
            let (sin, cos) = trials[f].turn.sin_cos();
            Vector::new(cos * v.x + sin * v.y, cos * v.y - sin * v.x, v.z)
        };
        let chain = |f: usize, x: f64| MachineChain::at(&trials[f].setup, self.flanks[f].hand, x);
        for (i, hit) in rays.hits.iter().enumerate() {
            let [f, k] = hit.node;
            let node = &self.flanks[f].nodes[k];
            let normal = hit.normal * (1.0 / hit.normal.dot(node.normal.components));
            let ([s, theta, x], own) = (hit.at, before_turn(f, normal));
            let chain = chain(f, x);
            row(i, f, own, &|setting| {
                chain.displacement(setting, [s, theta])
            });
            turns[(i, f)] = normal.dot(Vector::Z.cross(node.point.coordinates));
        }
        for (i, (f, pass, _)) in rays.passes.iter().enumerate() {
            let (i, normal) = (rays.hits.len() + i, pass.normal * -ROOT_WEIGHT);
            let (own, r) = (before_turn(*f, normal), before_turn(*f, pass.point));
            let chain = chain(*f, pass.turn);
            row(i, *f, own, &|setting| {
                chain.displacement_of_plane(setting, r)
            });
            turns[(i, *f)] = normal.dot(Vector::Z.cross(pass.point));
        }
        NodeSensitivities::new(columns, turns)
    }
}

/// A step that would take less than this from the deviations changes nothing that is measured, m.
const UNSEEN: f64 = 1e-9;

impl Trial {
    fn envelope(&self, flank: &MeasuredFlank) -> FlankEnvelope {
        let envelope = self.setup.flank(flank.hand, flank.section).envelope;
        let turn = Pose::<WorkFrame, WorkFrame>::turned(Vector::Z, self.turn);
        Envelope {
            motion: envelope.motion.then(turn),
            ..envelope
        }
    }
}

/// Parameters, normal and distance at which an envelope meets the ray of a node; none on the part that is cut away.
fn intersect(
    envelope: &FlankEnvelope,
    node: &FlankNode,
    start: [f64; 3],
) -> Option<([f64; 3], Vector, f64)> {
    let (at, distance) = envelope.on_ray(node.point, node.normal, start)?;
    let point = envelope.point(at)?;
    let is_flank = point.second_order.undercut.signum() == node.side;
    let normal = point.normal.components;
    let faces = normal.dot(node.normal.components) > LEAST_COSINE;
    (is_flank && faces).then_some((at, normal, distance))
}

/// Least cosine between the normals of a node and of the flank that its ray meets.
const LEAST_COSINE: f64 = 0.5;
