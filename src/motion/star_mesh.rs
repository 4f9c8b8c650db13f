//! Star–mesh transformation: elimination of a massless coordinate by equivalent force elements between its neighbours.
//!
//! At a coordinate z the arms deflect by `δᵢ = aᵢ (z − xᵢ)` with `xᵢ = −(wᵢ·q − eᵢ)/aᵢ` of the other coordinates. With
//! `Kᵢ = kᵢ aᵢ²`, `Cᵢ = cᵢ aᵢ²` equilibrium is `Σ (Kᵢ + s Cᵢ)(z − xᵢ) = f`. The equivalent element of every pair is
//! `(Kᵢ + s Cᵢ)(Kⱼ + s Cⱼ)/(ΣK + s ΣC)`: a spring `KᵢKⱼ/ΣK`, a damper `CᵢCⱼ/ΣC` and, unless damping is proportional to
//! stiffness, one Maxwell element, `1/ΣK` and `ΣC/ΣK²` along `Σ (Kᵢ − Cᵢ ΣK/ΣC) xᵢ`. Pairs of more than three arms
//! are summed to one element per arm, so that chains of massless nodes do not multiply them. No step subtracts stiffness.

use super::dynamic_model::{AppliedForce, ForceElement, ForceLaw};
use super::signal::Signal;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::machine::direction::Direction;

/// Relative rounding error of products: tolerance for equal damping ratios or equal attachments.
pub const SHARE_TOLERANCE: f64 = 1e-12;

/// Largest number of arms without more pairs than arms.
const MAX_MESHED_ARMS: usize = 3;

/// Maximum number of terms of the elements equivalent to one star: 64 MB.
const MAX_TERMS: usize = 4_000_000;

/// Condensed massless coordinate, `z = Σ bⱼ qⱼ + known`.
pub struct CondensedDof {
    /// Index of the coordinate.
    pub at: usize,
    /// Terms (j, bⱼ).
    pub terms: Vec<(usize, f64)>,
    /// Imposed displacement, rad or m.
    pub known: Option<Signal>,
    /// The coordinate lags by an internal state.
    pub has_internal_state: bool,
}

/// Error of a coordinate that cannot be condensed.
pub fn cannot_condense(name: &str, what: &str) -> Error {
    let message = format!("{name} has no inertia, and {what} acts there");
    Error::new(Code::Conflict, message).with_hint(
        "give the node a (small) inertia, which the exact methods take; massless nodes may join springs and dampers only",
    )
}

/// Whether a signal is constant in time.
pub fn is_steady(signal: &Signal) -> bool {
    signal.harmonics.is_empty()
        && signal.bursts.is_empty()
        && signal
            .knots
            .iter()
            .all(|k| k.slope == 0.0 && k.curvature == 0.0)
        && signal.knots.windows(2).all(|p| p[0].value == p[1].value)
        && signal.knots.first().is_none_or(|k| !k.time.is_finite())
}

/// Star point: a massless coordinate and the elements that join it.
pub struct StarPoint {
    at: usize,
    arms: Vec<StarArm>,
    stiffness: f64,
    damping: f64,
    /// Damping is proportional to stiffness.
    is_proportional: bool,
}

/// Arm of a star: an element from the star point to xᵢ.
struct StarArm {
    name: String,
    /// Stiffness Kᵢ, N·m/rad or N/m.
    stiffness: f64,
    /// Damping Cᵢ, N·m·s/rad or N·s/m.
    damping: f64,
    /// Terms of xᵢ without the imposed displacement.
    terms: Vec<(usize, f64)>,
    /// Imposed displacement of xᵢ, rad or m.
    known: Option<Signal>,
}

impl StarArm {
    /// Whether both arms lead to the same xᵢ.
    fn is_parallel(&self, other: &StarArm) -> bool {
        let is_equal = |(a, b): (&(usize, f64), &(usize, f64))| {
            a.0 == b.0 && (a.1 - b.1).abs() <= SHARE_TOLERANCE * a.1.abs().max(b.1.abs())
        };
        self.known == other.known
            && self.terms.len() == other.terms.len()
            && self.terms.iter().zip(&other.terms).all(is_equal)
    }
}

impl StarPoint {
    /// Star point of the elements that join z, or the reason against condensation.
    pub fn new(z: usize, joined: Vec<ForceElement>) -> Result<StarPoint, String> {
        let mut arms = Vec::new();
        for b in joined {
            let ForceLaw::Linear { stiffness, damping } = b.law else {
                return Err(format!("`{}`, no plain spring or damper,", b.name));
            };
            if b.force_direction.is_some()
                || b.stiffness_wave.is_some()
                || !b.angle_waves.is_empty()
            {
                return Err(format!("`{}`, which varies or acts across,", b.name));
            }
            let terms: Vec<(usize, f64)> = b.direction.entries().collect();
            let a: f64 = terms.iter().filter(|t| t.0 == z).map(|t| t.1).sum();
            let others = terms.iter().filter(|t| t.0 != z);
            arms.push(StarArm {
                name: b.name,
                stiffness: stiffness * a * a,
                damping: damping * a * a,
                terms: others.map(|&(j, w)| (j, -w / a)).collect(),
                known: b.imposed_displacement.map(|e| e.scaled(1.0 / a)),
            });
        }
        let arms = merge_parallel(arms);
        let sum = |of_arm: fn(&StarArm) -> f64| arms.iter().map(of_arm).sum::<f64>();
        let (stiffness, damping) = (sum(|a| a.stiffness), sum(|a| a.damping));
        if stiffness <= 0.0 || arms.iter().any(|a| a.stiffness < 0.0 || a.damping < 0.0) {
            return Err("a stiffness below zero".to_string());
        }
        let is_proportional = |a: &StarArm| {
            let difference = a.damping * stiffness - a.stiffness * damping;
            difference.abs() <= SHARE_TOLERANCE * (a.damping * stiffness).max(a.stiffness * damping)
        };
        Ok(StarPoint {
            at: z,
            is_proportional: arms.iter().all(is_proportional),
            arms,
            stiffness,
            damping,
        })
    }

    /// Whether z lags its neighbours, or would lag under load.
    pub fn has_internal_state(&self) -> bool {
        self.damping > 0.0
    }

    /// Condensed coordinate `z = Σ Kᵢ xᵢ/ΣK + f/ΣK`, exact without internal state.
    pub fn follower(&self, pulls: &[AppliedForce]) -> CondensedDof {
        let mut terms = Vec::new();
        let mut known: Option<Signal> = None;
        let mut add = |signal: Signal| {
            known = Some(known.take().map_or(signal.clone(), |sum| sum.plus(&signal)));
        };
        for arm in &self.arms {
            let share = arm.stiffness / self.stiffness;
            terms.extend(arm.terms.iter().map(|&(j, w)| (j, share * w)));
            if let Some(x) = &arm.known {
                add(x.scaled(share));
            }
        }
        for pull in pulls {
            add(pull
                .signal
                .scaled(self.along(&pull.direction) / self.stiffness));
        }
        CondensedDof {
            at: self.at,
            terms,
            known,
            has_internal_state: !self.is_proportional,
        }
    }

    fn along(&self, direction: &Direction) -> f64 {
        let terms = direction.entries().filter(|t| t.0 == self.at);
        terms.map(|t| t.1).sum()
    }

    /// Distributes a load f on z to the neighbours: `f Kᵢ/ΣK` along each xᵢ.
    pub fn distribute_load(&self, pull: &AppliedForce) -> AppliedForce {
        let load = self.along(&pull.direction);
        let others = pull.direction.entries().filter(|t| t.0 != self.at);
        let arms = self.arms.iter().flat_map(|arm| {
            let share = load * arm.stiffness / self.stiffness;
            arm.terms.iter().map(move |&(j, w)| (j, share * w))
        });
        AppliedForce {
            direction: Direction::new(1.0, others.chain(arms)),
            ..pull.clone()
        }
    }

    /// Elements equivalent to the star: the side of `Σᵢ Kᵢ (xᵢ − x̄)² = Σᵢ<ⱼ KᵢKⱼ/ΣK (xᵢ − xⱼ)²` with fewer terms.
    ///
    /// # Errors
    /// More terms than [`MAX_TERMS`]; Maxwell elements that would meet at a massless node.
    pub fn mesh(&self, name: &str, left: &[usize]) -> Result<Vec<ForceElement>, Error> {
        let terms: usize = self.arms.iter().map(|arm| arm.terms.len()).sum();
        if terms.saturating_mul(self.arms.len()) > MAX_TERMS {
            let message = format!(
                "{name} has no inertia and joins {} branches: its elimination couples all neighbours, {:.0e} terms (limit {:.0e})",
                self.arms.len(),
                terms as f64 * self.arms.len() as f64,
                MAX_TERMS as f64
            );
            return Err(Error::new(Code::BudgetExceeded, message)
                .with_hint("give the node a (small) inertia, which the exact methods take"));
        }
        let springs = |arm: &StarArm| arm.stiffness;
        let dampers = |arm: &StarArm| arm.damping;
        let mut all = Vec::new();
        match (self.is_proportional, self.arms.len() <= MAX_MESHED_ARMS) {
            (_, true) => all.extend(self.pairs()),
            (true, false) => {
                let share = self.damping / self.stiffness;
                all.extend(self.spokes(self.stiffness, springs, |k| (k, k * share)));
            }
            (false, false) => {
                all.extend(self.spokes(self.stiffness, springs, |k| (k, 0.0)));
                all.extend(self.spokes(self.damping, dampers, |c| (0.0, c)));
            }
        }
        if !self.is_proportional {
            let weight =
                |arm: &StarArm| arm.stiffness - arm.damping * self.stiffness / self.damping;
            let arms: Vec<(f64, &StarArm)> = self.arms.iter().map(|a| (weight(a), a)).collect();
            let law = ForceLaw::Maxwell {
                stiffness: 1.0 / self.stiffness,
                damping: self.damping / (self.stiffness * self.stiffness),
            };
            all.push(equivalent_element(
                &joined_name(self.arms.iter()),
                law,
                &arms,
            ));
        }
        all.retain(|b| !b.direction.terms.is_empty());
        let remembering =
            |b: &&ForceElement| b.internal_count() > 0 && left.iter().any(|&z| b.touches(z));
        if let Some(b) = all.iter().find(remembering) {
            let message = format!(
                "`{}` join massless nodes in series, and their dampers are not proportional to their springs",
                b.name
            );
            return Err(Error::new(Code::Conflict, message).with_hint(
                "give one of these nodes a (small) inertia, which the exact methods take",
            ));
        }
        Ok(all)
    }

    /// Equivalent element for every pair of arms.
    fn pairs(&self) -> Vec<ForceElement> {
        let mut all = Vec::new();
        for (i, a) in self.arms.iter().enumerate() {
            for b in &self.arms[i + 1..] {
                let stiffness = a.stiffness * b.stiffness / self.stiffness;
                let damping = match self.damping > 0.0 {
                    true => a.damping * b.damping / self.damping,
                    false => 0.0,
                };
                if stiffness > 0.0 || damping > 0.0 {
                    let law = ForceLaw::Linear { stiffness, damping };
                    let name = joined_name([a, b].into_iter());
                    all.push(equivalent_element(&name, law, &[(1.0, a), (-1.0, b)]));
                }
            }
        }
        all
    }

    /// Equivalent element for every arm, along `xᵢ − x̄ = Σⱼ (sⱼ/Σs)(xᵢ − xⱼ)`.
    fn spokes(
        &self,
        sum: f64,
        strength: impl Fn(&StarArm) -> f64,
        law: impl Fn(f64) -> (f64, f64),
    ) -> Vec<ForceElement> {
        let arms = || self.arms.iter().filter(|arm| strength(arm) > 0.0);
        let spoke = |arm: &StarArm| {
            let others = arms().filter(|other| !std::ptr::eq(*other, arm));
            let mut terms: Vec<(f64, &StarArm)> = others
                .map(|other| (-strength(other) / sum, other))
                .collect();
            let weight = -terms.iter().map(|w| w.0).sum::<f64>();
            terms.push((weight, arm));
            let (stiffness, damping) = law(strength(arm));
            equivalent_element(&arm.name, ForceLaw::Linear { stiffness, damping }, &terms)
        };
        arms().map(spoke).collect()
    }
}

/// Joined name of arms; beyond the maximum length the first name.
fn joined_name<'a>(arms: impl Iterator<Item = &'a StarArm>) -> String {
    /// Maximum number of characters of a name.
    const MAX_NAME_LEN: usize = 80;
    let all: Vec<&str> = arms.map(|arm| &arm.name[..]).collect();
    let joined = all.join("+");
    match (joined.chars().count() > MAX_NAME_LEN, all.first()) {
        (true, Some(first)) => format!("{}+…", first.trim_end_matches("+…")),
        _ => joined,
    }
}

/// Merges parallel arms: their stiffness and damping add up.
fn merge_parallel(arms: Vec<StarArm>) -> Vec<StarArm> {
    let mut all: Vec<StarArm> = Vec::with_capacity(arms.len());
    for arm in arms {
        match all.iter_mut().find(|other| other.is_parallel(&arm)) {
            Some(other) => {
                other.stiffness += arm.stiffness;
                other.damping += arm.damping;
                other.name = joined_name([&*other, &arm].into_iter());
            }
            None => all.push(arm),
        }
    }
    all
}

/// Force element along `Σ gᵢ xᵢ`.
fn equivalent_element(name: &str, law: ForceLaw, arms: &[(f64, &StarArm)]) -> ForceElement {
    let terms = arms
        .iter()
        .flat_map(|(g, arm)| arm.terms.iter().map(move |&(j, w)| (j, g * w)));
    let mut imposed: Option<Signal> = None;
    for (g, arm) in arms {
        if let Some(x) = &arm.known {
            // δ = w·q − e: e is the negative imposed displacement.
            let e = x.scaled(-g);
            imposed = Some(imposed.map_or(e.clone(), |sum| sum.plus(&e)));
        }
    }
    ForceElement {
        name: name.to_string(),
        direction: Direction::new(1.0, terms),
        force_direction: None,
        law,
        stiffness_wave: None,
        imposed_displacement: imposed,
        angle_waves: Vec::new(),
    }
}
