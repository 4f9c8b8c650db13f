//! Newmark's method and its kin, implicit, of order 2: one linear system of constant parts factored once per step length,
//! and a correction of low rank for the branches that are not constant.
//!
//! `q₁ = q₀ + h v₀ + h² ((½ − β) a₀ + β a₁)`, `v₁ = v₀ + h ((1 − γ) a₀ + γ a₁)`, and the equation of motion holds for
//! `(1 − α_f) x₁ + α_f x₀` with the acceleration `(1 − α_m) a₁ + α_m a₀`.
//!
//! Sources: Newmark 1959; Hilber, Hughes and Taylor 1977; Chung and Hulbert 1993, equations 3 to 8 and 17, 25.

use std::borrow::Cow;

use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::units::{instant, seconds};
use crate::motion::light;
use crate::motion::pencil::add;
use crate::motion::problem::{Ask, Effort, Problem, Sink, Stretch, Wanted};
use crate::motion::progress::{Samples, check, inside, next_stop, within_budget};
use crate::motion::scale::{Scale, norm};
use crate::motion::train::{Branch, Law, Regime, Train};
use crate::numeric::Matrix;
use crate::numeric::lu::Lu;

/// The spectral radius at infinity that the methods of the table are run with.
pub const RADIUS: f64 = 0.8;

/// Weights of a method of the family.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Alpha {
    /// α_m: the share of the old acceleration.
    pub inertia: f64,
    /// α_f: the share of the old state.
    pub force: f64,
    /// β.
    pub beta: f64,
    /// γ.
    pub gamma: f64,
}

impl Alpha {
    /// Newmark's average acceleration: β = ¼, γ = ½; no numerical damping.
    pub fn newmark() -> Alpha {
        Alpha {
            inertia: 0.0,
            force: 0.0,
            beta: 0.25,
            gamma: 0.5,
        }
    }

    /// Hilber, Hughes and Taylor's, by the spectral radius at infinity, from ½ to 1: α = (ρ − 1)/(ρ + 1).
    pub fn hht(radius: f64) -> Alpha {
        let force = (1.0 - radius) / (1.0 + radius);
        Alpha {
            inertia: 0.0,
            force,
            beta: 0.25 * (1.0 + force) * (1.0 + force),
            gamma: 0.5 + force,
        }
    }

    /// Chung and Hulbert's, by the spectral radius at infinity, from 0 to 1.
    pub fn generalized(radius: f64) -> Alpha {
        let (inertia, force) = (
            (2.0 * radius - 1.0) / (radius + 1.0),
            radius / (radius + 1.0),
        );
        let offset = inertia - force;
        Alpha {
            inertia,
            force,
            beta: 0.25 * (1.0 - offset) * (1.0 - offset),
            gamma: 0.5 - offset,
        }
    }

    /// The factor of `h² (a₁ − a₀)` in the local error of positions: ⅙ − β, less what a's offset in time makes up for.
    ///
    /// Source: Zienkiewicz and Xie 1991, equation 9, for Newmark's; with the offset `(α_m − α_f) h` of a after Arnold and
    /// Brüls 2007 for the others.
    pub fn local_error(&self) -> f64 {
        1.0 / 6.0 - self.beta - 0.5 * (self.inertia - self.force)
    }

    /// Positions and speeds for which the equation of motion holds in a step.
    fn mixed(&self, from: &State, to: &State) -> Vec<f64> {
        [
            mix(&from.q, &to.q, self.force),
            mix(&from.v, &to.v, self.force),
        ]
        .concat()
    }

    /// The factor of `h³ ä` in the local error of speeds, ä the second derivative of a: with `δ = α_m − α_f` and `γ = ½ − δ`
    /// it is `1/12 − δ²/2`, from Taylor's series of `v₁ = v₀ + h ((1 − γ) a(t₀ + δh) + γ a(t₁ + δh))`.
    pub fn local_error_of_speed(&self) -> f64 {
        let offset = self.inertia - self.force;
        1.0 / 12.0 - 0.5 * offset * offset
    }
}

/// A share of the old and the rest of the new.
fn mix(old: &[f64], new: &[f64], share: f64) -> Vec<f64> {
    let pairs = old.iter().zip(new);
    pairs
        .map(|(old, new)| share * old + (1.0 - share) * new)
        .collect()
}

/// Newmark's average acceleration.
///
/// # Errors
/// Those of [`run`].
pub fn newmark(train: &Train, ask: &Ask, sink: &mut Sink) -> Result<Effort, Error> {
    run(&Alpha::newmark(), train, ask, sink)
}

/// Hilber, Hughes and Taylor's with ρ = 0.8 (α = −1/9).
///
/// # Errors
/// Those of [`run`].
pub fn hht(train: &Train, ask: &Ask, sink: &mut Sink) -> Result<Effort, Error> {
    run(&Alpha::hht(RADIUS), train, ask, sink)
}

/// Chung and Hulbert's with ρ = 0.8.
///
/// # Errors
/// Those of [`run`].
pub fn generalized(train: &Train, ask: &Ask, sink: &mut Sink) -> Result<Effort, Error> {
    run(&Alpha::generalized(RADIUS), train, ask, sink)
}

/// Why the family cannot take a machine.
pub fn refuses(train: &Train) -> Option<String> {
    let pressed = |b: &&Branch| matches!(b.law, Law::Pressed(_));
    if let Some(b) = train.branches.iter().find(pressed) {
        return Some(format!(
            "the friction of {} goes by the force of another branch, and each branch is solved by itself here",
            b.name
        ));
    }
    if let Some(why) = light::refused(train) {
        return Some(why);
    }
    (train.inner() > 0).then(|| {
        "a branch has an inner state (a late torque, a spring and a damper in series), which is not of second order"
            .to_string()
    })
}

/// Rounds of Newton's iteration; from the tenth on half steps, which end cycles about a corner.
const ROUNDS: u32 = 60;

/// Parts a stretch is divided into where the step is chosen by the error, as a power of two: steps are powers of two of them, and the
/// shortest, which a jump of the force needs, are near rounding.
const HALVINGS: u32 = 50;

/// As many.
const PARTS: u64 = 1 << HALVINGS;

/// The constant parts of a machine.
struct Constant<'a> {
    weights: &'a Alpha,
    train: &'a Train,
    mass: Matrix,
    stiffness: Matrix,
    damping: Matrix,
    /// Branches that are not constant.
    others: Vec<usize>,
    /// By step length.
    systems: Vec<System>,
}

/// `S = (1 − α_m)/(β h²) M + (1 − α_f) (γ/(β h) C + K)` with the other branches' directions solved for.
struct System {
    h: f64,
    lu: Lu,
    /// S⁻¹ U.
    columns: Matrix,
    /// Wᵀ S⁻¹ U.
    small: Matrix,
}

impl<'a> Constant<'a> {
    fn new(weights: &'a Alpha, train: &'a Train) -> Constant<'a> {
        let n = train.n();
        let (mut stiffness, mut damping) = (Matrix::zeros(n, n), Matrix::zeros(n, n));
        let mut others = Vec::new();
        for (at, branch) in train.branches.iter().enumerate() {
            match (&branch.law, &branch.followed[..]) {
                (
                    Law::Linear {
                        stiffness: k,
                        damping: c,
                    },
                    [],
                ) => {
                    add(&mut stiffness, branch.acts(), &branch.direction, *k);
                    add(&mut damping, branch.acts(), &branch.direction, *c);
                }
                _ => others.push(at),
            }
        }
        if let Some((k, c)) = &train.general {
            stiffness += k;
            damping += c;
        }
        let mass = train.mass.matrix();
        for j in 0..n {
            for i in 0..n {
                damping[(i, j)] += train.drag * mass[(i, j)];
            }
        }
        Constant {
            weights,
            train,
            mass,
            stiffness,
            damping,
            others,
            systems: Vec::new(),
        }
    }

    /// The number of the system of a step length.
    fn system(&mut self, h: f64, effort: &mut Effort) -> Result<usize, Error> {
        if let Some(at) = self.systems.iter().position(|s| s.h == h) {
            return Ok(at);
        }
        let (n, w) = (self.train.n(), self.weights);
        let inertia = (1.0 - w.inertia) / (w.beta * h * h);
        let rate = w.gamma / (w.beta * h);
        let lu = Lu::new(&Matrix::from_fn(n, n, |i, j| {
            inertia * self.mass[(i, j)]
                + (1.0 - w.force) * (rate * self.damping[(i, j)] + self.stiffness[(i, j)])
        }))?;
        effort.factorisations += 1;
        let mut forces = Matrix::zeros(n, self.others.len());
        for (j, &at) in self.others.iter().enumerate() {
            for (i, a) in self.train.branches[at].acts().scaled() {
                forces[(i, j)] = a;
            }
        }
        let columns = match self.others.is_empty() {
            true => forces,
            false => lu.solve_all(&forces),
        };
        let m = self.others.len();
        let small = Matrix::from_fn(m, m, |i, j| {
            self.train.branches[self.others[i]]
                .direction
                .dot(columns.col_as_slice(j))
        });
        if self.systems.len() == 16 {
            self.systems.remove(0);
        }
        self.systems.push(System {
            h,
            lu,
            columns,
            small,
        });
        Ok(self.systems.len() - 1)
    }

    /// `(S + U D Wᵀ)⁻¹ r`, D the slopes of the other branches' forces (Woodbury's formula), in place.
    fn correct(&self, system: &System, slopes: &[f64], r: &mut [f64]) -> Result<(), Error> {
        system.lu.solve(r);
        let m = slopes.len();
        if slopes.iter().all(|&d| d == 0.0) {
            return Ok(());
        }
        let direction = |i: usize| &self.train.branches[self.others[i]].direction;
        let matrix = Matrix::from_fn(m, m, |i, j| {
            f64::from(u8::from(i == j)) + slopes[i] * system.small[(i, j)]
        });
        let mut right: Vec<f64> = (0..m).map(|i| slopes[i] * direction(i).dot(r)).collect();
        Lu::new(&matrix)?.solve(&mut right);
        for (j, x) in right.iter().enumerate() {
            for (r, a) in r.iter_mut().zip(system.columns.col_as_slice(j)) {
                *r -= a * x;
            }
        }
        Ok(())
    }
}

/// A state with its acceleration.
#[derive(Clone)]
struct State {
    q: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
}

/// Where a step leads.
struct Stepped {
    to: State,
    /// How contacts were held to stand; absent where they stood as the mixed state put them.
    held: Option<Regime>,
}

impl State {
    /// The method's a stands for an instant `(α_m − α_f) h` after the state's, so it goes with the step: to another step, longer by a share
    /// of that in which a rose by so much. Left as it is, a rings by the difference for some steps (Arnold and Brüls 2007).
    fn carry(&mut self, weights: &Alpha, longer: f64, rise: &[f64]) {
        let share = (weights.inertia - weights.force) * longer;
        for (a, rise) in self.a.iter_mut().zip(rise) {
            *a += share * rise;
        }
    }
}

/// Integrates a machine, with a fixed step or by a tolerance on positions and speeds. Contacts stand where each step's state puts
/// them, and dry friction is spread over its creep speed.
///
/// # Errors
/// `NoConvergence` of Newton's iteration, `Hopeless` beyond the budget, and what cannot be asked.
pub fn run(weights: &Alpha, train: &Train, ask: &Ask, sink: &mut Sink) -> Result<Effort, Error> {
    check(ask, train.len())?;
    if let Some(why) = refuses(train) {
        return Err(Error::new(Code::Usage, why).hint("take radau5"));
    }
    let n = train.n();
    let mut effort = Effort::default();
    let mut samples = Samples::new(ask, sink);
    let mut constant = Constant::new(weights, train);
    let mut scale = Scale::of_train(train, ask);
    scale.note(&ask.start);
    let mut y = ask.start.clone();
    samples.give_until(ask.from, &mut y, None, |_, _| ())?;
    let mut size = PARTS >> 10;
    let mut from = ask.from;
    while samples.due().is_some() && from < ask.to {
        let to = next_stop(|t| train.next_break(t), from, ask.to);
        let clock = |t: f64| inside(t, from, to);
        let mut slope = vec![0.0; train.len()];
        train.slope(clock(from), &y, &mut slope);
        let mut state = State {
            q: y[..n].to_vec(),
            v: y[n..2 * n].to_vec(),
            a: slope[n..2 * n].to_vec(),
        };
        let parts = match ask.effort {
            Wanted::Step(h) => ((to - from) / h - 1e-6).ceil().max(1.0) as u64,
            Wanted::Tolerance(_) => PARTS,
        };
        let part = (to - from) / parts as f64;
        let mut done = 0;
        let mut last: Option<(f64, Vec<f64>)> = None;
        // The step that a stands for.
        let mut meant = 0.0;
        while done < parts && samples.due().is_some() {
            let t = from + part * done as f64;
            let (h, taken) = match ask.effort {
                Wanted::Step(_) => (part, 1),
                // A step of a power of two begins at a multiple of itself.
                Wanted::Tolerance(_) => {
                    size = size.min(1 << done.trailing_zeros().min(HALVINGS));
                    (part * size as f64, size)
                }
            };
            let controlled = matches!(ask.effort, Wanted::Tolerance(_));
            if let Some((before, rise)) = last.as_ref().filter(|_| controlled) {
                state.carry(weights, (h - meant) / before, rise);
                meant = h;
            }
            let mut stepped = step(&mut constant, &state, t, h, clock, &scale, &mut effort);
            let mut first = None;
            // Before the first step only the motion tells how a changes.
            if let Ok(trial) = stepped.as_ref()
                && controlled
                && last.is_none()
            {
                let there = [&trial.to.q[..], &trial.to.v[..]].concat();
                train.slope(clock(t + h), &there, &mut slope);
                effort.evaluations += 1;
                let rise: Vec<f64> = (0..n).map(|i| slope[n + i] - state.a[i]).collect();
                let carried = first.insert(state.clone());
                carried.carry(weights, 1.0, &rise);
                stepped = step(&mut constant, carried, t, h, clock, &scale, &mut effort);
            }
            let begun = first.as_ref().unwrap_or(&state);
            let Stepped { to: next, held } = match stepped {
                Err(_) if controlled && size > 1 => {
                    effort.rejected += 1;
                    size /= 2;
                    continue;
                }
                other => other?,
            };
            let mut reached = next.q.clone();
            reached.extend(&next.v);
            if let Wanted::Tolerance(tolerance) = ask.effort {
                let before: Vec<f64> = [state.q.clone(), state.v.clone()].concat();
                let sizes = scale.sizes(&before, &reached, h);
                let mut error = local_errors(weights, [begun, &next], h, last.as_ref());
                let times = [t, t + h].map(clock);
                let late = late(&constant, [begun, &next], times, held.as_ref(), &mut effort);
                for (error, late) in error[n..].iter_mut().zip(&late) {
                    *error = error.abs() + h * late.abs();
                }
                let error = norm(&error, &sizes[..2 * n]) / tolerance;
                if !(error <= 1.0) {
                    effort.rejected += 1;
                    if size == 1 {
                        return Err(Error::new(
                            Code::NoConvergence,
                            format!(
                                "no step from t = {} keeps the error within the tolerance",
                                instant(t)
                            ),
                        )
                        .hint("the motion jumps there: take a method that locates switches, or a coarser tolerance"));
                    }
                    size /= 2;
                    within_budget(ask, &effort, t)?;
                    continue;
                }
                if error < 0.07 && size < PARTS {
                    size *= 2;
                }
            }
            effort.steps += 1;
            done += taken;
            let u = if done == parts {
                to
            } else {
                from + part * done as f64
            };
            within_budget(ask, &effort, u)?;
            scale.note(&reached);
            let at = |due: f64, into: &mut [f64]| match due == u {
                true => into.copy_from_slice(&reached),
                false => between(weights, [begun, &next], h, (due - t) / h, into),
            };
            ask.follower.follow(Stretch {
                from: t,
                to: u,
                grain: h,
                regime: None,
                state: &mut { at },
            });
            samples.give_until(u, &mut y, None, at)?;
            let rise = next.a.iter().zip(&begun.a).map(|(b, a)| b - a);
            last = Some((h, rise.collect()));
            meant = h;
            state = next;
        }
        y = [state.q, state.v].concat();
        from = to;
    }
    Ok(effort)
}

/// What a step of length `h` errs by in positions and speeds. `last` is the step before it with the rise of a in it: both rises give
/// ä. Where there is none, h² ä is taken as large as the whole rise of a, so that first steps are short rather than unseen.
fn local_errors(
    weights: &Alpha,
    [from, to]: [&State; 2],
    h: f64,
    last: Option<&(f64, Vec<f64>)>,
) -> Vec<f64> {
    let rise: Vec<f64> = to.a.iter().zip(&from.a).map(|(b, a)| b - a).collect();
    let of_speed = |i: usize| match last {
        Some((before, rose)) => {
            let ratio = h / before;
            2.0 * (rise[i] - ratio * rose[i]) / (1.0 + 1.0 / ratio)
        }
        None => rise[i],
    };
    let positions = rise.iter().map(|rise| weights.local_error() * h * h * rise);
    let speeds = (0..rise.len()).map(|i| weights.local_error_of_speed() * h * of_speed(i));
    positions.chain(speeds).collect()
}

/// What a jumps by at the end of a step because contacts stand otherwise there than in the step, which knows the mixed state alone: the
/// switch came too late for it. Empty where nothing does.
fn late(
    constant: &Constant,
    [from, to]: [&State; 2],
    [begin, end]: [f64; 2],
    held: Option<&Regime>,
    effort: &mut Effort,
) -> Vec<f64> {
    let (train, w) = (constant.train, constant.weights);
    let contact = |&&b: &&usize| matches!(train.branches[b].law, Law::Contact(_));
    let contacts: Vec<usize> = constant.others.iter().filter(contact).copied().collect();
    if contacts.is_empty() {
        return Vec::new();
    }
    effort.evaluations += 1;
    let u = w.force * begin + (1.0 - w.force) * end;
    let mixed = || train.placed(u, &w.mixed(from, to));
    let stood = held.map_or_else(|| Cow::Owned(mixed()), Cow::Borrowed);
    let y = [&to.q[..], &to.v[..]].concat();
    let mut jump = vec![0.0; train.n()];
    for b in contacts {
        let force = |regime| train.force(b, regime, end, &y, 0.0).0;
        let more = force(None) - force(Some(&*stood));
        let acts = train.branches[b].acts();
        acts.scaled().for_each(|(i, a)| jump[i] -= a * more);
    }
    train.accelerate(&mut jump);
    jump
}

/// One step of length `h` from `t`.
fn step(
    constant: &mut Constant,
    from: &State,
    t: f64,
    h: f64,
    clock: impl Fn(f64) -> f64,
    scale: &Scale,
    effort: &mut Effort,
) -> Result<Stepped, Error> {
    let at = constant.system(h, effort)?;
    let (train, w) = (constant.train, constant.weights);
    let n = train.n();
    let u = clock(t + (1.0 - w.force) * h);
    let start = [from.q.clone(), from.v.clone()].concat();
    let sizes = scale.sizes(&start, &start, h);
    let reach: Vec<f64> = (0..n)
        .map(|i| {
            sizes[i]
                .max(h * from.v[i].abs())
                .max(h * h * from.a[i].abs())
        })
        .collect();
    // Foot: acceleration carried on.
    let mut to = State {
        q: (0..n)
            .map(|i| from.q[i] + h * from.v[i] + 0.5 * h * h * from.a[i])
            .collect(),
        v: (0..n).map(|i| from.v[i] + h * from.a[i]).collect(),
        a: from.a.clone(),
    };
    let mut held: Option<Regime> = None;
    for round in 0..ROUNDS {
        let y = w.mixed(from, &to);
        let a = mix(&from.a, &to.a, w.inertia);
        let pushed = train.pushed(held.as_ref(), u, &y);
        effort.evaluations += 1;
        let carried: Vec<f64> = (0..n).map(|i| a[i] + train.drag * y[n + i]).collect();
        let mut change: Vec<f64> = train
            .momentum(&carried)
            .iter()
            .zip(&pushed)
            .map(|(p, g)| g - p)
            .collect();
        let slopes: Vec<f64> = constant
            .others
            .iter()
            .map(|&b| {
                let (_, k, c) = train.force(b, held.as_ref(), u, &y, 0.0);
                (1.0 - w.force) * (k + c * w.gamma / (w.beta * h))
            })
            .collect();
        constant.correct(&constant.systems[at], &slopes, &mut change)?;
        let share = if round < 10 { 1.0 } else { 0.5 };
        for i in 0..n {
            let change = share * change[i];
            to.q[i] += change;
            to.v[i] += w.gamma / (w.beta * h) * change;
            to.a[i] += change / (w.beta * h * h);
        }
        let size = norm(&change, &reach);
        if !size.is_finite() {
            break;
        }
        if size < 1e-13 || constant.others.is_empty() {
            return Ok(Stepped { to, held });
        }
        // A contact whose force jumps may have no solution at its border: it stands as it stood.
        let only_contacts = || {
            let law = |&b: &usize| train.branches[b].law.is_dry();
            !constant.others.iter().any(law)
        };
        if round == ROUNDS / 2 && only_contacts() {
            held = Some(train.regime(u, &start));
        }
    }
    Err(Error::new(
        Code::NoConvergence,
        format!(
            "Newton's iteration of a step of {} at t = {} does not converge",
            seconds(h),
            instant(t)
        ),
    )
    .hint("ask for a shorter step, or widen the creep speed of dry friction"))
}

/// The motion inside a step: the cubic through both ends' positions and speeds. How far the mean speed is from the mean of the speeds
/// comes from a, `h (γ/2 − β) (a₀ − a₁)` by the method's two lines: as a difference of positions it would drown in rounding where a
/// switch makes steps short.
fn between(weights: &Alpha, [from, to]: [&State; 2], h: f64, theta: f64, y: &mut [f64]) {
    let n = from.q.len();
    for i in 0..n {
        let (v, gain) = (from.v[i], to.v[i] - from.v[i]);
        let apart = h * (0.5 * weights.gamma - weights.beta) * (from.a[i] - to.a[i]);
        let bulge = theta * theta * (3.0 - 2.0 * theta) * apart;
        y[i] = from.q[i] + h * (theta * (v + 0.5 * theta * gain) + bulge);
        y[n + i] = v + theta * (gain + 6.0 * (1.0 - theta) * apart);
    }
}
