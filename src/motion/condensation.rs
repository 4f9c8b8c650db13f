//! Static condensation of massless coordinates by the star–mesh transform.
//!
//! One coordinate after another is a star (`star`) whose branches become branches between its neighbours.

use super::algebraic;
use super::combination::LinearCombination;
use super::dynamic_model::{AppliedForce, DynamicModel, ForceElement, ForceLaw, MassMatrix};
use super::normal_force::missing_normal_force;
use super::star_mesh::{CondensedDof, SHARE_TOLERANCE, StarPoint, cannot_condense, is_steady};
use super::wave::{PeriodicFunction, WavePhase};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::source_span::SourceSpan;
use crate::machine::direction::Direction;
use crate::numeric::Matrix;

/// A machine without its massless coordinates, and the way back.
pub struct CondensedModel {
    /// Equations of the condensed model; the retained coordinates keep their order.
    pub model: DynamicModel,
    /// The independent coordinates.
    pub retained: Vec<usize>,
    /// Retained number of every branch of the machine; `None` where it became part of others.
    pub branches: Vec<Option<usize>>,
    /// Every coordinate in those that stay; none where it remembers.
    pub recovery: Vec<Option<LinearCombination>>,
}

/// Takes coordinates without inertia out of a machine; `where_is` tells where one is written.
///
/// # Errors
/// One whose neighbour is no spring or damper, naming both.
pub fn condense(
    whole: DynamicModel,
    massless: &[usize],
    where_is: &dyn Fn(usize) -> SourceSpan,
) -> Result<CondensedModel, Error> {
    let mut branches: Vec<(Option<usize>, ForceElement)> = whole
        .elements
        .iter()
        .cloned()
        .enumerate()
        .map(|(at, b)| (Some(at), b))
        .collect();
    let mut drives = whole.forces.clone();
    let mut followers = Vec::new();
    let mut left: Vec<usize> = massless.to_vec();
    let mut stay: Vec<usize> = Vec::new();
    while !left.is_empty() {
        // Where all dampers are one share of the springs nothing is remembered, and neighbours may be massless too.
        let plain = left.iter().position(|&z| share(&branches, z).is_some());
        let z = left.remove(plain.unwrap_or(0));
        let joined = || branches.iter().map(|(_, b)| b).filter(|b| b.touches(z));
        match reduce(&whole, z, joined().cloned().collect(), &drives, &left) {
            Ok(model) => {
                branches.retain(|(_, b)| !b.touches(z));
                branches.extend(model.mesh.into_iter().map(|b| (None, b)));
                drives = model.drives;
                followers.push(model.follower);
            }
            Err(error)
                if error.code != Code::BudgetExceeded
                    && joined().all(algebraic::allows_massless)
                    && !is_general(&whole, z) =>
            {
                stay.push(z);
            }
            Err(error) => return Err(error.with_span(&where_is(z))),
        }
    }
    let taken: Vec<usize> = followers.iter().map(|f| f.at).collect();
    let condensed = assemble_condensed(whole, &taken, branches, drives, &followers)?;
    if let Err(floats) = condensed.model.check_index_one() {
        let name = &condensed.model.coordinates[floats];
        let message = format!(
            "{name} has no inertia, and neither a spring nor a damper holds it while the adjacent contacts are open: its equations are of higher index"
        );
        return Err(Error::new(Code::Conflict, message)
            .with_span(&where_is(condensed.retained[floats]))
            .with_hint("give the node its inertia, however small, or a spring that holds it"));
    }
    Ok(condensed)
}

/// Star–mesh equivalent of a coordinate without inertia.
struct StarEquivalent {
    mesh: Vec<ForceElement>,
    drives: Vec<AppliedForce>,
    follower: CondensedDof,
}

/// Gyroscopic terms or modal damping act on a coordinate.
fn is_general(whole: &DynamicModel, z: usize) -> bool {
    let acts = |(k, c): &(Matrix, Matrix)| {
        (0..whole.coordinate_count()).any(|j| k[(z, j)] != 0.0 || c[(z, j)] != 0.0)
    };
    whole.unattached.as_ref().is_some_and(acts)
}

/// Springs and dampers that join a coordinate, as springs and dampers between its neighbours.
fn reduce(
    whole: &DynamicModel,
    z: usize,
    joined: Vec<ForceElement>,
    drives: &[AppliedForce],
    left: &[usize],
) -> Result<StarEquivalent, Error> {
    let name = &whole.coordinates[z];
    let star = StarPoint::new(z, joined).map_err(|what| cannot_condense(name, &what))?;
    if is_general(whole, z) {
        return Err(cannot_condense(name, "gyroscopic terms or modal damping"));
    }
    let (pulls, others): (Vec<AppliedForce>, Vec<AppliedForce>) = drives
        .iter()
        .cloned()
        .partition(|d| d.direction.terms.iter().any(|t| t.0 == z));
    let mut drives = others;
    for pull in &pulls {
        if star.lags() && !is_steady(&pull.signal) {
            return Err(cannot_condense(name, "a varying load next to dampers,"));
        }
        drives.push(star.distribute_load(pull));
    }
    Ok(StarEquivalent {
        mesh: star.mesh(name, left)?,
        follower: star.follower(&pulls),
        drives,
    })
}

/// The one share of dampers on springs at a coordinate, s; none where there is not one, or something else joins it.
fn share(branches: &[(Option<usize>, ForceElement)], z: usize) -> Option<f64> {
    let mut one: Option<f64> = None;
    for (_, b) in branches.iter().filter(|(_, b)| b.touches(z)) {
        let ForceLaw::Linear { stiffness, damping } = b.law else {
            return None;
        };
        let own = damping / stiffness;
        let first = *one.get_or_insert(own);
        if !((own - first).abs() <= SHARE_TOLERANCE * first.abs()) {
            return None;
        }
    }
    one
}

/// Everything over the independent coordinates.
fn assemble_condensed(
    whole: DynamicModel,
    massless: &[usize],
    branches: Vec<(Option<usize>, ForceElement)>,
    drives: Vec<AppliedForce>,
    followers: &[CondensedDof],
) -> Result<CondensedModel, Error> {
    let n = whole.coordinate_count();
    let kept: Vec<usize> = (0..n).filter(|j| !massless.contains(j)).collect();
    let place = |i: usize| kept.binary_search(&i).unwrap_or_default();
    let moved = |d: &Direction| Direction {
        scale: d.scale,
        terms: d.terms.iter().map(|&(i, a)| (place(i), a)).collect(),
    };
    let mut numbers = vec![None; whole.elements.len()];
    for (at, (number, _)) in branches.iter().enumerate() {
        if let Some(number) = number {
            numbers[*number] = Some(at);
        }
    }
    let moved_phase = |phase: &WavePhase| {
        let mut phase = phase.clone();
        if let WavePhase::FollowsAngle { angle, .. } = &mut phase {
            *angle = moved(angle);
        }
        phase
    };
    let moved_wave = |wave: PeriodicFunction| PeriodicFunction {
        phase: moved_phase(&wave.phase),
        ..wave
    };
    let moved_law = |name: &str, law: ForceLaw| match law {
        ForceLaw::LoadFriction(pressed) => {
            let pressed = pressed.with_coordinates(moved, moved_phase, &numbers);
            let pressed = pressed.map_err(|by| missing_normal_force(&whole, name, by))?;
            Ok(ForceLaw::LoadFriction(Box::new(pressed)))
        }
        law => Ok(law),
    };
    let branches = branches.into_iter().map(|(_, b)| {
        Ok(ForceElement {
            direction: moved(&b.direction),
            force_direction: b.force_direction.as_ref().map(moved),
            law: moved_law(&b.name, b.law)?,
            stiffness_wave: b.stiffness_wave.map(moved_wave),
            angle_waves: b.angle_waves.into_iter().map(moved_wave).collect(),
            ..b
        })
    });
    let branches = branches.collect::<Result<_, Error>>()?;
    let block = |a: &Matrix| Matrix::from_fn(kept.len(), kept.len(), |i, j| a[(kept[i], kept[j])]);
    let model = DynamicModel {
        coordinates: kept.iter().map(|&i| whole.coordinates[i].clone()).collect(),
        mass: match &whole.mass {
            MassMatrix::Diagonal(mass) => {
                MassMatrix::Diagonal(kept.iter().map(|&i| mass[i]).collect())
            }
            MassMatrix::Full { matrix, inverse } => MassMatrix::Full {
                matrix: block(matrix),
                inverse: block(inverse),
            },
        },
        elements: branches,
        forces: drives
            .into_iter()
            .map(|d| AppliedForce {
                direction: moved(&d.direction),
                ..d
            })
            .filter(|d| !d.direction.terms.is_empty())
            .collect(),
        mass_damping: whole.mass_damping,
        unattached: whole.unattached.as_ref().map(|(k, c)| (block(k), block(c))),
    };
    // The last to be taken out follows independent coordinates; those before it follow these and the later ones.
    let mut places: Vec<Option<LinearCombination>> = vec![None; n];
    for (j, &i) in kept.iter().enumerate() {
        places[i] = Some(LinearCombination::coordinate(j));
    }
    for follower in followers.iter().rev() {
        let own = LinearCombination {
            terms: follower.terms.clone(),
            imposed: follower.known.clone(),
        };
        places[follower.at] = match follower.remembers {
            true => None,
            false => own.substitute(&places),
        };
    }
    Ok(CondensedModel {
        model,
        retained: kept,
        branches: numbers,
        recovery: places,
    })
}
