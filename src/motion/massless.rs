//! Coordinates without inertia, taken out of the equations: springs that meet at one become springs between its neighbours.
//!
//! One coordinate after another is a star (`star`) whose branches become branches between its neighbours.

use super::combination::Combination;
use super::light;
use super::pressing::unpressed;
use super::star::{Follower, SAME, Star, hindered, is_steady};
use super::train::{Branch, Drive, Law, Mass, Train};
use super::wave::{Phase, Wave};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::place::Place;
use crate::machine::direction::Direction;
use crate::numeric::Matrix;

/// A machine without its massless coordinates, and the way back.
pub struct Condensed {
    /// Its equations; the coordinates that stay keep their order.
    pub train: Train,
    /// The coordinates that stay.
    pub kept: Vec<usize>,
    /// Of every branch of the machine its number among those that stay; none where it became part of others.
    pub branches: Vec<Option<usize>>,
    /// Every coordinate in those that stay; none where it remembers.
    pub places: Vec<Option<Combination>>,
}

/// Takes coordinates without inertia out of a machine; `where_is` tells where one is written.
///
/// # Errors
/// One whose neighbour is no spring or damper, naming both.
pub fn condense(
    whole: Train,
    massless: &[usize],
    where_is: &dyn Fn(usize) -> Place,
) -> Result<Condensed, Error> {
    let mut branches: Vec<(Option<usize>, Branch)> = whole
        .branches
        .iter()
        .cloned()
        .enumerate()
        .map(|(at, b)| (Some(at), b))
        .collect();
    let mut drives = whole.drives.clone();
    let mut followers = Vec::new();
    let mut left: Vec<usize> = massless.to_vec();
    let mut stay: Vec<usize> = Vec::new();
    while !left.is_empty() {
        // Where all dampers are one share of the springs nothing is remembered, and neighbours may be massless too.
        let plain = left.iter().position(|&z| share(&branches, z).is_some());
        let z = left.remove(plain.unwrap_or(0));
        let joined = || branches.iter().map(|(_, b)| b).filter(|b| b.touches(z));
        match reduce(&whole, z, joined().cloned().collect(), &drives, &left) {
            Ok(reduced) => {
                branches.retain(|(_, b)| !b.touches(z));
                branches.extend(reduced.mesh.into_iter().map(|b| (None, b)));
                drives = reduced.drives;
                followers.push(reduced.follower);
            }
            Err(error)
                if error.code != Code::Hopeless
                    && joined().all(light::may_stay)
                    && !is_general(&whole, z) =>
            {
                stay.push(z);
            }
            Err(error) => return Err(error.at(&where_is(z))),
        }
    }
    let taken: Vec<usize> = followers.iter().map(|f| f.at).collect();
    let condensed = finished(whole, &taken, branches, drives, &followers)?;
    if let Err(floats) = condensed.train.index_one() {
        let name = &condensed.train.coordinates[floats];
        let message = format!(
            "{name} has no inertia, and neither a spring nor a damper holds it while contacts beside it are open: its equations are of higher index"
        );
        return Err(Error::new(Code::Conflict, message)
            .at(&where_is(condensed.kept[floats]))
            .hint("give the node its inertia, however small, or a spring that holds it"));
    }
    Ok(condensed)
}

/// What stands for a coordinate without inertia.
struct Reduced {
    mesh: Vec<Branch>,
    drives: Vec<Drive>,
    follower: Follower,
}

/// Gyroscopic terms or modal damping act on a coordinate.
fn is_general(whole: &Train, z: usize) -> bool {
    let acts =
        |(k, c): &(Matrix, Matrix)| (0..whole.n()).any(|j| k[(z, j)] != 0.0 || c[(z, j)] != 0.0);
    whole.general.as_ref().is_some_and(acts)
}

/// Springs and dampers that join a coordinate, as springs and dampers between its neighbours.
fn reduce(
    whole: &Train,
    z: usize,
    joined: Vec<Branch>,
    drives: &[Drive],
    left: &[usize],
) -> Result<Reduced, Error> {
    let name = &whole.coordinates[z];
    let star = Star::new(z, joined).map_err(|what| hindered(name, &what))?;
    if is_general(whole, z) {
        return Err(hindered(name, "gyroscopic terms or modal damping"));
    }
    let (pulls, others): (Vec<Drive>, Vec<Drive>) = drives
        .iter()
        .cloned()
        .partition(|d| d.direction.terms.iter().any(|t| t.0 == z));
    let mut drives = others;
    for pull in &pulls {
        if star.lags() && !is_steady(&pull.signal) {
            return Err(hindered(name, "a load that changes, beside dampers,"));
        }
        drives.push(star.shared(pull));
    }
    Ok(Reduced {
        mesh: star.mesh(name, left)?,
        follower: star.follower(&pulls),
        drives,
    })
}

/// The one share of dampers on springs at a coordinate, s; none where there is not one, or something else joins it.
fn share(branches: &[(Option<usize>, Branch)], z: usize) -> Option<f64> {
    let mut one: Option<f64> = None;
    for (_, b) in branches.iter().filter(|(_, b)| b.touches(z)) {
        let Law::Linear { stiffness, damping } = b.law else {
            return None;
        };
        let own = damping / stiffness;
        let first = *one.get_or_insert(own);
        if !((own - first).abs() <= SAME * first.abs()) {
            return None;
        }
    }
    one
}

/// Everything over the coordinates that stay.
fn finished(
    whole: Train,
    massless: &[usize],
    branches: Vec<(Option<usize>, Branch)>,
    drives: Vec<Drive>,
    followers: &[Follower],
) -> Result<Condensed, Error> {
    let n = whole.n();
    let kept: Vec<usize> = (0..n).filter(|j| !massless.contains(j)).collect();
    let place = |i: usize| kept.binary_search(&i).unwrap_or_default();
    let moved = |d: &Direction| Direction {
        scale: d.scale,
        terms: d.terms.iter().map(|&(i, a)| (place(i), a)).collect(),
    };
    let mut numbers = vec![None; whole.branches.len()];
    for (at, (number, _)) in branches.iter().enumerate() {
        if let Some(number) = number {
            numbers[*number] = Some(at);
        }
    }
    let moved_phase = |phase: &Phase| {
        let mut phase = phase.clone();
        if let Phase::Followed { angle, .. } = &mut phase {
            *angle = moved(angle);
        }
        phase
    };
    let moved_wave = |wave: Wave| Wave {
        phase: moved_phase(&wave.phase),
        ..wave
    };
    let moved_law = |name: &str, law: Law| match law {
        Law::Pressed(pressed) => {
            let pressed = pressed.moved(moved, moved_phase, &numbers);
            let pressed = pressed.map_err(|by| unpressed(&whole, name, by))?;
            Ok(Law::Pressed(Box::new(pressed)))
        }
        law => Ok(law),
    };
    let branches = branches.into_iter().map(|(_, b)| {
        Ok(Branch {
            direction: moved(&b.direction),
            force: b.force.as_ref().map(moved),
            law: moved_law(&b.name, b.law)?,
            variation: b.variation.map(moved_wave),
            followed: b.followed.into_iter().map(moved_wave).collect(),
            ..b
        })
    });
    let branches = branches.collect::<Result<_, Error>>()?;
    let block = |a: &Matrix| Matrix::from_fn(kept.len(), kept.len(), |i, j| a[(kept[i], kept[j])]);
    let train = Train {
        coordinates: kept.iter().map(|&i| whole.coordinates[i].clone()).collect(),
        mass: match &whole.mass {
            Mass::Diagonal(mass) => Mass::Diagonal(kept.iter().map(|&i| mass[i]).collect()),
            Mass::Full { matrix, inverse } => Mass::Full {
                matrix: block(matrix),
                inverse: block(inverse),
            },
        },
        branches,
        drives: drives
            .into_iter()
            .map(|d| Drive {
                direction: moved(&d.direction),
                ..d
            })
            .filter(|d| !d.direction.terms.is_empty())
            .collect(),
        drag: whole.drag,
        general: whole.general.as_ref().map(|(k, c)| (block(k), block(c))),
    };
    // The last to be taken out follows coordinates that stay; those before it follow these and the later ones.
    let mut places: Vec<Option<Combination>> = vec![None; n];
    for (j, &i) in kept.iter().enumerate() {
        places[i] = Some(Combination::of(j));
    }
    for follower in followers.iter().rev() {
        let own = Combination {
            terms: follower.terms.clone(),
            imposed: follower.known.clone(),
        };
        places[follower.at] = match follower.remembers {
            true => None,
            false => own.over(&places),
        };
    }
    Ok(Condensed {
        train,
        kept,
        branches: numbers,
        places,
    })
}
