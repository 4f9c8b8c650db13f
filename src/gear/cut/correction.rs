//! Correction of machine settings: Gauss–Newton on exact distances along node normals, by truncated singular value decomposition.
//!
//! Unknowns are changes of settings in units of their reach, and the free rotation of each flank about the work axis. A direction
//! with a singular value below a smallest displacement is truncated: its effect is not measurable, and the settings would diverge
//! along it (Hansen, Rank-Deficient and Discrete Ill-Posed Problems, 1998, section 3.2).

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

/// Machine setting as an unknown of a correction.
#[derive(Debug, Clone, PartialEq)]
pub struct Unknown {
    /// Machine setting.
    pub setting: Setting,
    /// Indices of the flanks affected by the setting: both for flanks cut at a common setting.
    pub flanks: Vec<usize>,
    /// Scale of a reasonable change, m, rad or dimensionless: the unit of the matrix column.
    pub reach: f64,
}

/// Least-squares problem of a correction: measured flanks and free settings.
#[derive(Debug, Clone)]
pub struct CorrectionProblem {
    /// Measured flanks.
    pub flanks: Vec<MeasuredFlank>,
    /// Free settings.
    pub unknowns: Vec<Unknown>,
    /// Truncation threshold: smallest rms displacement of the nodes by a direction of settings, m.
    pub least: f64,
}

/// Result of a correction: fitted settings, residual deviations, sensitivities.
#[derive(Debug, Clone)]
pub struct CorrectionFit {
    /// Settings of each flank.
    pub setups: Vec<FlankSetup>,
    /// Rotation of each flank about the work axis, rad.
    pub turns: Vec<f64>,
    /// Changes of the unknowns, m, rad or dimensionless.
    pub changes: Vec<f64>,
    /// Residual deviations by flank and node, m; `None` for a node without a point of the fitted flank.
    pub residuals: Vec<Vec<Option<f64>>>,
    /// Sensitivities at the initial settings.
    pub nominal: NodeSensitivities,
    /// Sensitivities at the fitted settings.
    pub fitted: NodeSensitivities,
    /// Number of directions used: numerical rank.
    pub kept: usize,
    /// Number of steps.
    pub steps: usize,
    /// True if the effect of the last step is not measurable.
    pub is_converged: bool,
}

/// Largest number of steps.
const STEPS: usize = 60;
/// Convergence tolerance on the reduction of the residual, m: rounding level.
const LAST_STEP: f64 = 1e-12;
/// Largest change of a setting in a step, in units of its reach.
const LARGEST_STEP: f64 = 6.0;
/// Largest number of halvings of a step without decrease of the residual.
const HALVINGS: usize = 8;
/// Rounding tolerance of the rms residual, m.
const ROUNDING: f64 = 1e-13;
/// Weight of a slot-depth deviation relative to a flank deviation: depth tolerances are hundredths of a millimetre, flank tolerances
/// are micrometres.
pub(super) const ROOT_WEIGHT: f64 = 0.1;

/// Flank at trial settings.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Trial {
    setup: FlankSetup,
    turn: f64,
}

/// Intersection of a trial flank with the normal ray of a node.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Hit {
    /// Index of flank and node.
    node: [usize; 2],
    at: [f64; 3],
    /// Normal of the trial flank.
    normal: Vector,
    /// Residual: deviation of the node minus distance to the trial flank, m.
    residual: f64,
}

/// Ray intersections of all nodes and tool passes over the root, for one trial.
#[derive(Debug, Clone, PartialEq)]
struct RayHits {
    hits: Vec<Hit>,
    /// Flank index, pass, weighted residual of the height, m.
    passes: Vec<(usize, TipPass, f64)>,
}

impl RayHits {
    fn residuals(&self) -> Vec<f64> {
        let nodes = self.hits.iter().map(|hit| hit.residual);
        nodes.chain(self.passes.iter().map(|pass| pass.2)).collect()
    }

    /// Root mean square of the residuals per node, m.
    fn rms(&self) -> f64 {
        let squares: f64 = self.residuals().iter().map(|x| x * x).sum();
        (squares / self.hits.len().max(1) as f64).sqrt()
    }
}

impl CorrectionProblem {
    /// Least-squares fit of the settings to the deviations, within the numerical rank.
    ///
    /// # Errors
    /// Fewer ray intersections at the initial settings than unknowns.
    pub fn solve(&self) -> Result<CorrectionFit, Error> {
        let start = |flank: &MeasuredFlank| Trial {
            setup: flank.setup,
            turn: 0.0,
        };
        let mut trials: Vec<Trial> = self.flanks.iter().map(start).collect();
        let mut rays = self.ray_hits(&trials, None);
        self.check(&rays.hits)?;
        let nominal = self.system(&trials, &rays)?;
        let rank = nominal.numerical_rank(self.least);
        let mut system = nominal.clone();
        let mut changes = vec![0.0; self.unknowns.len()];
        let (mut steps, mut is_converged) = (0, false);
        while steps < STEPS && !is_converged {
            steps += 1;
            let step = system.step(&rays.residuals(), rank.min(rays.hits.len()));
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
                let next_rays = self.ray_hits(&next, Some(&rays.hits));
                let is_better = 2 * next_rays.hits.len() >= self.count()
                    && next_rays.passes.len() == rays.passes.len()
                    && next_rays.rms() <= rays.rms() + ROUNDING;
                is_better.then_some((share, next, next_rays))
            });
            let Some((share, next, next_rays)) = moved else {
                is_converged = step.removed <= UNMEASURABLE;
                break;
            };
            for ((change, delta), unknown) in
                changes.iter_mut().zip(&step.changes).zip(&self.unknowns)
            {
                *change += share * delta * unknown.reach;
            }
            (trials, rays) = (next, next_rays);
            system = self.system(&trials, &rays)?;
        }
        let mut rests: Vec<Vec<Option<f64>>> = self
            .flanks
            .iter()
            .map(|f| vec![None; f.nodes.len()])
            .collect();
        for hit in &rays.hits {
            rests[hit.node[0]][hit.node[1]] = Some(hit.residual);
        }
        Ok(CorrectionFit {
            setups: trials.iter().map(|trial| trial.setup).collect(),
            turns: trials.iter().map(|trial| trial.turn).collect(),
            changes,
            residuals: rests,
            nominal,
            fitted: system,
            kept: rank,
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
            "{} nodes lie on the flank of the settings; {needed} unknowns (settings, and a rotation of each flank) need at least {needed}",
            hits.len()
        );
        Err(Error::new(Code::IllPosed, message)
            .with_hint("free fewer settings, or measure more nodes"))
    }

    /// Trials after a fraction of a step.
    fn stepped(&self, trials: &[Trial], changes: &[f64], turns: &[f64], share: f64) -> Vec<Trial> {
        let mut next = trials.to_vec();
        for (trial, turn) in next.iter_mut().zip(turns) {
            trial.turn += share * turn;
        }
        for (unknown, change) in self.unknowns.iter().zip(changes) {
            for flank in &unknown.flanks {
                let delta = share * change * unknown.reach;
                next[*flank].setup = next[*flank].setup.changed(unknown.setting, delta);
            }
        }
        next
    }

    /// Intersections of all rays, with those of an earlier trial as starts, and passes over the root; rays beyond an undercut or the
    /// end of a trial flank have none.
    fn ray_hits(&self, trials: &[Trial], before: Option<&[Hit]>) -> RayHits {
        let mut hits = Vec::with_capacity(self.count());
        let mut passes = Vec::new();
        for (f, (flank, trial)) in self.flanks.iter().zip(trials).enumerate() {
            let envelope = trial.envelope(flank);
            for (k, node) in flank.nodes.iter().enumerate() {
                let nearest = before.and_then(|hits| hits.iter().find(|hit| hit.node == [f, k]));
                let start = nearest.map_or(node.at, |hit| hit.at);
                if let Some((at, normal, distance)) = intersect(&envelope, node, start) {
                    hits.push(Hit {
                        node: [f, k],
                        at,
                        normal,
                        residual: flank.deviations[k] - distance,
                    });
                }
            }
            for root in &flank.roots {
                let pass = root.pass(&trial.setup, flank.hand, trial.turn);
                passes.extend(pass.map(|pass| {
                    let residual = ROOT_WEIGHT * (root.height - pass.height);
                    (f, pass, residual)
                }));
            }
        }
        RayHits { hits, passes }
    }

    /// Sensitivities of the ray residuals and of the root passes.
    ///
    /// Along a ray of direction n a flank of normal m advances by `m·∂r/∂p / m·n`; a root point approaches the tip plane of
    /// normal n by `n·∂r/∂p`.
    fn system(&self, trials: &[Trial], rays: &RayHits) -> Result<NodeSensitivities, Error> {
        let count = rays.hits.len() + rays.passes.len();
        let mut columns = Matrix::zeros(count, self.unknowns.len());
        let mut turns = Matrix::zeros(count, self.flanks.len());
        let mut row = |i: usize, f: usize, normal: Vector, rate: &dyn Fn(Setting) -> Vector| {
            for (j, unknown) in self.unknowns.iter().enumerate() {
                if unknown.flanks.contains(&f) {
                    columns[(i, j)] = normal.dot(rate(unknown.setting)) * unknown.reach;
                }
            }
        };
        // The chain ends in the work frame before the flank rotation.
        let before_turn = |f: usize, v: Vector| {
            let (sin, cos) = trials[f].turn.sin_cos();
            Vector::new(cos * v.x + sin * v.y, cos * v.y - sin * v.x, v.z)
        };
        let chain = |f: usize, x: f64| MachineChain::at(&trials[f].setup, self.flanks[f].hand, x);
        for (i, hit) in rays.hits.iter().enumerate() {
            let [f, k] = hit.node;
            let node = &self.flanks[f].nodes[k];
            let normal = hit.normal * (1.0 / hit.normal.dot(node.normal.components));
            let ([s, theta, x], direction) = (hit.at, before_turn(f, normal));
            let chain = chain(f, x);
            row(i, f, direction, &|setting| {
                chain.displacement(setting, [s, theta])
            });
            turns[(i, f)] = normal.dot(Vector::Z.cross(node.point.coordinates));
        }
        for (i, (f, pass, _)) in rays.passes.iter().enumerate() {
            let (i, normal) = (rays.hits.len() + i, pass.normal * -ROOT_WEIGHT);
            let (direction, r) = (before_turn(*f, normal), before_turn(*f, pass.point));
            let chain = chain(*f, pass.turn);
            row(i, *f, direction, &|setting| {
                chain.displacement_of_plane(setting, r)
            });
            turns[(i, *f)] = normal.dot(Vector::Z.cross(pass.point));
        }
        NodeSensitivities::new(columns, turns)
    }
}

/// Reduction of the residual below measurement resolution, m.
const UNMEASURABLE: f64 = 1e-9;

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

/// Intersection of an envelope with the ray of a node: parameters, normal, distance, m; `None` beyond an undercut limit.
fn intersect(
    envelope: &FlankEnvelope,
    node: &FlankNode,
    start: [f64; 3],
) -> Option<([f64; 3], Vector, f64)> {
    let (at, distance) = envelope.intersect_ray(node.point, node.normal, start)?;
    let point = envelope.point(at)?;
    let is_flank = point.second_order.undercut.signum() == node.side;
    let normal = point.normal.components;
    let faces = normal.dot(node.normal.components) > MIN_COSINE;
    (is_flank && faces).then_some((at, normal, distance))
}

/// Smallest cosine between the normals of node and flank at the intersection.
const MIN_COSINE: f64 = 0.5;
