//! Coordinates without inertia, taken out of the equations: springs that meet at one become springs between its neighbours.
//!
//! At a coordinate z the branches pull with `δᵢ = aᵢ (z − xᵢ)`, `xᵢ = −(wᵢ·q − eᵢ)/aᵢ` of the others. With `Kᵢ = kᵢ aᵢ²`,
//! `Cᵢ = cᵢ aᵢ²` it stands where `Σ (Kᵢ + s Cᵢ)(z − xᵢ) = f`, and without it every pair is joined by
//! `(Kᵢ + s Cᵢ)(Kⱼ + s Cⱼ)/(ΣK + s ΣC)`: a spring `KᵢKⱼ/ΣK`, a damper `CᵢCⱼ/ΣC` and, where dampers are no common share of the
//! springs, one spring and damper in series, `1/ΣK` and `ΣC/ΣK²` along `Σ (Kᵢ − Cᵢ ΣK/ΣC) xᵢ`. No step subtracts stiffness.

use super::combination::Combination;
use super::light;
use super::pressing::unpressed;
use super::signal::Signal;
use super::train::{Branch, Drive, Law, Mass, Train};
use super::wave::{Phase, Wave};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::place::Place;
use crate::machine::direction::Direction;
use crate::numeric::Matrix;

/// Shares of dampers on springs that differ by less than this are one: the rounding of products.
const SAME: f64 = 1e-12;

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

/// A coordinate that follows its neighbours: `z = Σ bⱼ qⱼ + known`.
struct Follower {
    at: usize,
    terms: Vec<(usize, f64)>,
    known: Option<Signal>,
    remembers: bool,
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
        let joined = || branches.iter().map(|(_, b)| b).filter(|b| touches(b, z));
        match reduce(&whole, z, joined().cloned().collect(), &drives, &left) {
            Ok(reduced) => {
                branches.retain(|(_, b)| !touches(b, z));
                branches.extend(reduced.mesh.into_iter().map(|b| (None, b)));
                drives = reduced.drives;
                followers.push(reduced.follower);
            }
            Err(_) if joined().all(light::may_stay) && !is_general(&whole, z) => stay.push(z),
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
        mesh: star.mesh(left)?,
        follower: star.follower(&pulls),
        drives,
    })
}

/// The one share of dampers on springs at a coordinate, s; none where there is not one, or something else joins it.
fn share(branches: &[(Option<usize>, Branch)], z: usize) -> Option<f64> {
    let mut one: Option<f64> = None;
    for (_, b) in branches.iter().filter(|(_, b)| touches(b, z)) {
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

fn touches(b: &Branch, z: usize) -> bool {
    let along = |d: &Direction| d.terms.iter().any(|t| t.0 == z);
    let waves = b.variation.iter().chain(&b.followed);
    let rubs = match &b.law {
        Law::Pressed(pressed) => pressed.along().any(along),
        _ => false,
    };
    rubs || along(&b.direction)
        || along(b.acts())
        || waves.filter_map(|w| w.phase.angle()).any(along)
}

fn hindered(name: &str, what: &str) -> Error {
    let message = format!("{name} has no inertia, and {what} acts there");
    Error::new(Code::Conflict, message).hint(
        "give the node its inertia, however small: the exact methods do not mind; springs and dampers alone may meet at a node without one",
    )
}

/// The same at all times.
fn is_steady(signal: &Signal) -> bool {
    signal.harmonics.is_empty()
        && signal.bursts.is_empty()
        && signal.knots.iter().all(|k| k.slope == 0.0 && k.bend == 0.0)
        && signal.knots.windows(2).all(|p| p[0].value == p[1].value)
        && signal.knots.first().is_none_or(|k| !k.time.is_finite())
}

/// What meets at a coordinate.
struct Star {
    at: usize,
    arms: Vec<Arm>,
    stiffness: f64,
    damping: f64,
    /// Dampers are one share of the springs.
    alike: bool,
}

/// One branch of a star.
struct Arm {
    name: String,
    /// Kᵢ.
    stiffness: f64,
    /// Cᵢ.
    damping: f64,
    /// xᵢ without its imposed part.
    place: Vec<(usize, f64)>,
    /// The imposed part of xᵢ.
    known: Option<Signal>,
}

impl Star {
    /// Of what joins z, or what does not belong there.
    fn new(z: usize, joined: Vec<Branch>) -> Result<Star, String> {
        let mut arms = Vec::new();
        for b in joined {
            let Law::Linear { stiffness, damping } = b.law else {
                return Err(format!("`{}`, no plain spring or damper,", b.name));
            };
            if b.force.is_some() || b.variation.is_some() || !b.followed.is_empty() {
                return Err(format!("`{}`, which varies or acts across,", b.name));
            }
            let terms: Vec<(usize, f64)> = b.direction.scaled().collect();
            let a: f64 = terms.iter().filter(|t| t.0 == z).map(|t| t.1).sum();
            let others = terms.iter().filter(|t| t.0 != z);
            arms.push(Arm {
                name: b.name,
                stiffness: stiffness * a * a,
                damping: damping * a * a,
                place: others.map(|&(j, w)| (j, -w / a)).collect(),
                known: b.imposed.map(|e| e.times(1.0 / a)),
            });
        }
        let sum = |of: fn(&Arm) -> f64| arms.iter().map(of).sum::<f64>();
        let (stiffness, damping) = (sum(|a| a.stiffness), sum(|a| a.damping));
        if stiffness <= 0.0 || arms.iter().any(|a| a.stiffness < 0.0 || a.damping < 0.0) {
            return Err("a stiffness below zero".to_string());
        }
        let alike = |a: &Arm| {
            let apart = a.damping * stiffness - a.stiffness * damping;
            apart.abs() <= SAME * (a.damping * stiffness).max(a.stiffness * damping)
        };
        Ok(Star {
            at: z,
            alike: arms.iter().all(alike),
            arms,
            stiffness,
            damping,
        })
    }

    /// z follows its neighbours late, or a load on it would make it do so.
    fn lags(&self) -> bool {
        self.damping > 0.0
    }

    /// `z = Σ Kᵢ xᵢ/ΣK + f/ΣK` where nothing is remembered.
    fn follower(&self, pulls: &[Drive]) -> Follower {
        let mut terms = Vec::new();
        let mut known: Option<Signal> = None;
        let mut add = |signal: Signal| {
            known = Some(known.take().map_or(signal.clone(), |sum| sum.plus(&signal)));
        };
        for arm in &self.arms {
            let share = arm.stiffness / self.stiffness;
            terms.extend(arm.place.iter().map(|&(j, w)| (j, share * w)));
            if let Some(x) = &arm.known {
                add(x.times(share));
            }
        }
        for pull in pulls {
            add(pull
                .signal
                .times(self.along(&pull.direction) / self.stiffness));
        }
        Follower {
            at: self.at,
            terms,
            known,
            remembers: !self.alike,
        }
    }

    fn along(&self, direction: &Direction) -> f64 {
        let own = direction.scaled().filter(|t| t.0 == self.at);
        own.map(|t| t.1).sum()
    }

    /// What a load on z does to the neighbours: `f Kᵢ/ΣK` along each.
    fn shared(&self, pull: &Drive) -> Drive {
        let own = self.along(&pull.direction);
        let others = pull.direction.scaled().filter(|t| t.0 != self.at);
        let arms = self.arms.iter().flat_map(|arm| {
            let share = own * arm.stiffness / self.stiffness;
            arm.place.iter().map(move |&(j, w)| (j, share * w))
        });
        Drive {
            direction: Direction::new(1.0, others.chain(arms)),
            ..pull.clone()
        }
    }

    /// The branches that stand for the star.
    fn mesh(&self, left: &[usize]) -> Result<Vec<Branch>, Error> {
        let mut all = Vec::new();
        for (i, a) in self.arms.iter().enumerate() {
            for b in &self.arms[i + 1..] {
                let stiffness = a.stiffness * b.stiffness / self.stiffness;
                let damping = match self.damping > 0.0 {
                    true => a.damping * b.damping / self.damping,
                    false => 0.0,
                };
                let law = Law::Linear { stiffness, damping };
                if stiffness > 0.0 || damping > 0.0 {
                    all.push(between(
                        &format!("{}+{}", a.name, b.name),
                        law,
                        &[(1.0, a), (-1.0, b)],
                    ));
                }
            }
        }
        if !self.alike {
            let weight = |arm: &Arm| arm.stiffness - arm.damping * self.stiffness / self.damping;
            let arms: Vec<(f64, &Arm)> = self.arms.iter().map(|a| (weight(a), a)).collect();
            let law = Law::Maxwell {
                stiffness: 1.0 / self.stiffness,
                damping: self.damping / (self.stiffness * self.stiffness),
            };
            let names: Vec<&str> = self.arms.iter().map(|a| &a.name[..]).collect();
            all.push(between(&names.join("+"), law, &arms));
        }
        all.retain(|b| !b.direction.terms.is_empty());
        let remembering = |b: &&Branch| b.inner() > 0 && left.iter().any(|&z| touches(b, z));
        if let Some(b) = all.iter().find(remembering) {
            let message = format!(
                "`{}` join nodes without inertia in a row, and their dampers are no common share of their springs",
                b.name
            );
            return Err(Error::new(Code::Conflict, message).hint(
                "give one of these nodes its inertia, however small: the exact methods do not mind",
            ));
        }
        Ok(all)
    }
}

/// A branch along `Σ gᵢ xᵢ`.
fn between(name: &str, law: Law, arms: &[(f64, &Arm)]) -> Branch {
    let terms = arms
        .iter()
        .flat_map(|(g, arm)| arm.place.iter().map(move |&(j, w)| (j, g * w)));
    let mut imposed: Option<Signal> = None;
    for (g, arm) in arms {
        if let Some(x) = &arm.known {
            // δ = w·q − e, and x holds its known part with the sign of a displacement.
            let e = x.times(-g);
            imposed = Some(imposed.map_or(e.clone(), |sum| sum.plus(&e)));
        }
    }
    Branch {
        name: name.to_string(),
        direction: Direction::new(1.0, terms),
        force: None,
        law,
        variation: None,
        imposed,
        followed: Vec::new(),
    }
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
