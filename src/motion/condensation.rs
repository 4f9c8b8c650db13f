//! Static condensation of massless coordinates by the star–mesh transform.
//!
//! Each massless coordinate in turn is the centre of a star (`star_mesh`), whose elements become elements between its neighbours.

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

/// Model without its massless coordinates, with their recovery.
pub struct CondensedModel {
    /// Equations of the condensed model; the retained coordinates keep their order.
    pub model: DynamicModel,
    /// Indices of the retained coordinates in the full model.
    pub retained: Vec<usize>,
    /// New index of every element of the full model; `None` if it was condensed.
    pub branches: Vec<Option<usize>>,
    /// Every coordinate as a combination of the retained ones; `None` for a coordinate with an internal state.
    pub recovery: Vec<Option<LinearCombination>>,
}

/// Condenses massless coordinates; `source_of` returns the place of a coordinate in the source file.
///
/// # Errors
/// Those of a star that is not condensable; `Conflict` for a coordinate without spring or damper (higher index).
pub fn condense(
    full: DynamicModel,
    massless: &[usize],
    source_of: &dyn Fn(usize) -> SourceSpan,
) -> Result<CondensedModel, Error> {
    let mut elements: Vec<(Option<usize>, ForceElement)> = full
        .elements
        .iter()
        .cloned()
        .enumerate()
        .map(|(at, b)| (Some(at), b))
        .collect();
    let mut loads = full.forces.clone();
    let mut followers = Vec::new();
    let mut queue: Vec<usize> = massless.to_vec();
    while !queue.is_empty() {
        // With proportional damping there is no internal state, and neighbours may be massless too.
        let proportional = queue.iter().position(|&z| c_over_k(&elements, z).is_some());
        let z = queue.remove(proportional.unwrap_or(0));
        let adjacent = || elements.iter().map(|(_, b)| b).filter(|b| b.touches(z));
        match reduce(&full, z, adjacent().cloned().collect(), &loads, &queue) {
            Ok(model) => {
                elements.retain(|(_, b)| !b.touches(z));
                elements.extend(model.mesh.into_iter().map(|b| (None, b)));
                loads = model.loads;
                followers.push(model.follower);
            }
            Err(error)
                if error.code != Code::BudgetExceeded
                    && adjacent().all(algebraic::allows_massless)
                    && !has_general_terms(&full, z) => {} // stays in the equations as an algebraic unknown
            Err(error) => return Err(error.with_span(&source_of(z))),
        }
    }
    let condensed_dofs: Vec<usize> = followers.iter().map(|f| f.at).collect();
    let condensed = assemble_condensed(full, &condensed_dofs, elements, loads, &followers)?;
    if let Err(free) = condensed.model.check_index_one() {
        let name = &condensed.model.coordinates[free];
        let message = format!(
            "{name} has no inertia, and neither a spring nor a damper acts on it while the adjacent contacts are open: its equations have a higher index"
        );
        return Err(Error::new(Code::Conflict, message)
            .with_span(&source_of(condensed.retained[free]))
            .with_hint("give the node a (small) inertia, or connect a spring"));
    }
    Ok(condensed)
}

/// Star–mesh equivalent of a coordinate without inertia.
struct StarEquivalent {
    mesh: Vec<ForceElement>,
    loads: Vec<AppliedForce>,
    follower: CondensedDof,
}

/// Whether gyroscopic terms or modal damping act on a coordinate.
fn has_general_terms(model: &DynamicModel, z: usize) -> bool {
    let acts = |(k, c): &(Matrix, Matrix)| {
        (0..model.coordinate_count()).any(|j| k[(z, j)] != 0.0 || c[(z, j)] != 0.0)
    };
    model.global_matrices.as_ref().is_some_and(acts)
}

/// Star–mesh transform of the springs and dampers at a coordinate into springs and dampers between its neighbours.
fn reduce(
    model: &DynamicModel,
    z: usize,
    adjacent: Vec<ForceElement>,
    loads: &[AppliedForce],
    remaining: &[usize],
) -> Result<StarEquivalent, Error> {
    let name = &model.coordinates[z];
    let star = StarPoint::new(z, adjacent).map_err(|reason| cannot_condense(name, &reason))?;
    if has_general_terms(model, z) {
        return Err(cannot_condense(name, "gyroscopic terms or modal damping"));
    }
    let (local, others): (Vec<AppliedForce>, Vec<AppliedForce>) = loads
        .iter()
        .cloned()
        .partition(|d| d.direction.terms.iter().any(|t| t.0 == z));
    let mut loads = others;
    for load in &local {
        if star.has_internal_state() && !is_steady(&load.signal) {
            return Err(cannot_condense(name, "a varying load next to dampers,"));
        }
        loads.push(star.distribute_load(load));
    }
    Ok(StarEquivalent {
        mesh: star.mesh(name, remaining)?,
        follower: star.follower(&local),
        loads,
    })
}

/// Common ratio c/k of the elements at a coordinate, s; `None` if the ratios differ or an element is not linear.
fn c_over_k(elements: &[(Option<usize>, ForceElement)], z: usize) -> Option<f64> {
    let mut common: Option<f64> = None;
    for (_, b) in elements.iter().filter(|(_, b)| b.touches(z)) {
        let ForceLaw::Linear { stiffness, damping } = b.law else {
            return None;
        };
        let ratio = damping / stiffness;
        let first = *common.get_or_insert(ratio);
        if !((ratio - first).abs() <= SHARE_TOLERANCE * first.abs()) {
            return None;
        }
    }
    common
}

/// Condensed model over the retained coordinates.
fn assemble_condensed(
    full: DynamicModel,
    massless: &[usize],
    elements: Vec<(Option<usize>, ForceElement)>,
    loads: Vec<AppliedForce>,
    followers: &[CondensedDof],
) -> Result<CondensedModel, Error> {
    let n = full.coordinate_count();
    let dofs: Vec<usize> = (0..n).filter(|j| !massless.contains(j)).collect();
    let index = |i: usize| dofs.binary_search(&i).unwrap_or_default();
    let reindex = |d: &Direction| Direction {
        scale: d.scale,
        terms: d.terms.iter().map(|&(i, a)| (index(i), a)).collect(),
    };
    let mut numbers = vec![None; full.elements.len()];
    for (at, (number, _)) in elements.iter().enumerate() {
        if let Some(number) = number {
            numbers[*number] = Some(at);
        }
    }
    let reindex_phase = |phase: &WavePhase| {
        let mut phase = phase.clone();
        if let WavePhase::FollowsAngle { angle, .. } = &mut phase {
            *angle = reindex(angle);
        }
        phase
    };
    let reindex_wave = |wave: PeriodicFunction| PeriodicFunction {
        phase: reindex_phase(&wave.phase),
        ..wave
    };
    let reindex_law = |name: &str, law: ForceLaw| match law {
        ForceLaw::LoadFriction(friction) => {
            let friction = friction.with_coordinates(reindex, reindex_phase, &numbers);
            let friction = friction.map_err(|by| missing_normal_force(&full, name, by))?;
            Ok(ForceLaw::LoadFriction(Box::new(friction)))
        }
        law => Ok(law),
    };
    let elements = elements.into_iter().map(|(_, b)| {
        Ok(ForceElement {
            direction: reindex(&b.direction),
            force_direction: b.force_direction.as_ref().map(reindex),
            law: reindex_law(&b.name, b.law)?,
            stiffness_wave: b.stiffness_wave.map(reindex_wave),
            angle_waves: b.angle_waves.into_iter().map(reindex_wave).collect(),
            ..b
        })
    });
    let elements = elements.collect::<Result<_, Error>>()?;
    let block = |a: &Matrix| Matrix::from_fn(dofs.len(), dofs.len(), |i, j| a[(dofs[i], dofs[j])]);
    let model = DynamicModel {
        coordinates: dofs.iter().map(|&i| full.coordinates[i].clone()).collect(),
        mass: match &full.mass {
            MassMatrix::Diagonal(mass) => {
                MassMatrix::Diagonal(dofs.iter().map(|&i| mass[i]).collect())
            }
            MassMatrix::Full { matrix, inverse } => MassMatrix::Full {
                matrix: block(matrix),
                inverse: block(inverse),
            },
        },
        elements,
        forces: loads
            .into_iter()
            .map(|d| AppliedForce {
                direction: reindex(&d.direction),
                ..d
            })
            .filter(|d| !d.direction.terms.is_empty())
            .collect(),
        mass_damping: full.mass_damping,
        global_matrices: full
            .global_matrices
            .as_ref()
            .map(|(k, c)| (block(k), block(c))),
    };
    // The last to be taken out follows independent coordinates; those before it follow these and the later ones.
    let mut recovery: Vec<Option<LinearCombination>> = vec![None; n];
    for (j, &i) in dofs.iter().enumerate() {
        recovery[i] = Some(LinearCombination::coordinate(j));
    }
    for follower in followers.iter().rev() {
        let combination = LinearCombination {
            terms: follower.terms.clone(),
            imposed: follower.known.clone(),
        };
        recovery[follower.at] = match follower.has_internal_state {
            true => None,
            false => combination.substitute(&recovery),
        };
    }
    Ok(CondensedModel {
        model,
        retained: dofs,
        branches: numbers,
        recovery,
    })
}
