//! The linear machine of one regime: its parts, how forces and borders enter them.

use std::collections::BTreeMap;

use super::border::{Border, Kind};
use super::course::Parts;
use super::equations::{Damping, Equations, Inner};
use super::frame::{Modes, Rows, dot, spread};
use super::hold::Hold;
use super::inputs::{Entry, Input, Inputs};
use super::law::{Held, held};
use super::shared::Shared;
use super::spectrum::Spectrum;
use super::stage::Stage;
use super::{apart, mixed};
use crate::base::error::Error;
use crate::machine::direction::Direction;
use crate::motion::contact::Affine;
use crate::motion::friction::Slip;
use crate::motion::train::{BranchStand, Law, Train};
use crate::numeric::slices::{add, add_columns};
use crate::numeric::{Complex, Matrix, registers};

/// A machine in one regime.
#[derive(Debug)]
pub struct Machine {
    /// What it does by itself and under harmonics: the states σ are the cosines and sines of these, then those of its parts.
    pub parts: Parts,
    /// The states of the parts from `(y, turns)`, harmonics as cosine and sine.
    pub enter: Matrix,
    /// y from σ.
    pub leave: Matrix,
    /// Constant push on σ.
    pub constant: Vec<f64>,
    /// Push on σ per value and per rate of every input.
    pub pushes: Vec<[Vec<f64>; 2]>,
    /// Pairs that stick.
    pub hold: Option<Hold>,
    /// Where it gives way.
    pub borders: Vec<Border>,
}

/// What is at hand while a machine is made.
struct Making<'a> {
    spectrum: &'a Spectrum,
    stage: &'a Stage,
    modes: &'a Modes,
    seen: &'a Seen,
    hold: Option<&'a Hold>,
    laws: &'a [Held],
    /// σ of the parts under every harmonic: phasors.
    steady: &'a [Vec<Complex>],
    /// Push of every harmonic that is not in these.
    left: &'a [Vec<Complex>],
}

impl Machine {
    /// Of a regime.
    ///
    /// # Errors
    /// Laws that are not linear; numbers out of range; no convergence.
    pub fn new(shared: &Shared, stands: &[BranchStand]) -> Result<Machine, Error> {
        let train = shared.train;
        let laws = train.branches.iter().zip(stands);
        let laws: Vec<Held> = laws.map(|(b, s)| held(b, *s)).collect::<Result<_, _>>()?;
        let modes = Modes::new(&shared.root, &rows(shared, &laws), train.n())?;
        let seen = Seen::new(train, &laws, &modes);
        let equations = equations(train, &laws, &modes, &seen);

        let raw = RawPushes::new(shared, &laws, &seen, &modes, equations.inner.len());
        let harmonics = raw.harmonics(&shared.inputs);
        let (spectrum, stage) = match apart::parts(&equations) {
            Some(found) => found,
            None => mixed::parts(&equations, &harmonics)?,
        };
        let len = spectrum.count();
        let into = |modal: &[f64]| {
            let mut sigma = vec![0.0; len];
            stage.enter(modal, &mut sigma);
            sigma
        };
        let mut steady = Vec::new();
        let mut near = Vec::new();
        let mut left = Vec::new();
        for (at, (omega, push)) in harmonics.iter().enumerate() {
            let part = |of: fn(&Complex) -> f64| into(&push.iter().map(of).collect::<Vec<f64>>());
            let (re, im) = (part(|x| x.re), part(|x| x.im));
            let push: Vec<Complex> = re
                .iter()
                .zip(&im)
                .map(|(&re, &im)| Complex::new(re, im))
                .collect();
            let found = spectrum.steady(&push, (at, *omega), shared.span);
            steady.push(found.answer);
            near.extend(found.near);
            left.push(found.left);
        }
        let stuck: Vec<usize> = (0..laws.len()).filter(|&b| laws[b].sticks).collect();
        let hold = match stuck.is_empty() {
            true => None,
            false => Some(Hold::new(shared, &laws, &stuck, &modes, &stage, len)?),
        };
        let making = Making {
            spectrum: &spectrum,
            stage: &stage,
            modes: &modes,
            seen: &seen,
            hold: hold.as_ref(),
            laws: &laws,
            steady: &steady,
            left: &left,
        };
        let borders = making.borders(shared, stands)?;
        let (enter, leave) = making.ways(train.inner());
        let turns = 2 * harmonics.len();
        let behind_turns = |modal: &[f64]| [vec![0.0; turns], into(modal)].concat();
        let machine = Machine {
            constant: behind_turns(&raw.constant),
            pushes: raw
                .inputs
                .iter()
                .map(|[value, rate]| [behind_turns(value), behind_turns(rate)])
                .collect(),
            parts: Parts::new(spectrum, &shared.inputs.frequencies, near),
            enter,
            leave,
            hold,
            borders,
        };
        registers::clear();
        Ok(machine)
    }
}

impl Making<'_> {
    /// From y to the parts and back.
    fn ways(&self, inner: usize) -> (Matrix, Matrix) {
        let (n, m) = (self.modes.shapes.nrows(), self.modes.count());
        let (out, into) = self.stage.matrices(self.spectrum.count());
        let states = 2 * n + inner;
        let turns = 2 * self.steady.len();
        let len = into.nrows();
        // Re(a e^{iωt}) = Re a cos − Im a sin, and σ is without it.
        let steady = |turn: usize, i: usize| match turn % 2 {
            0 => self.steady[turn / 2][i].re,
            _ => -self.steady[turn / 2][i].im,
        };
        let (shapes, momenta) = (&self.modes.shapes, &self.modes.momenta);
        let mut enter = Matrix::zeros(len, states + turns);
        let mut leave = Matrix::zeros(states, turns + len);
        // Places, then speeds: each of them by the same modes.
        for half in 0..2 {
            let parts = into.subcols(half * m, m) * momenta.transpose();
            let back = shapes * out.subrows(half * m, m);
            for i in 0..n {
                let column = enter.col_as_slice_mut(half * n + i);
                column.copy_from_slice(parts.col_as_slice(i));
            }
            for k in 0..len {
                let column = &mut leave.col_as_slice_mut(turns + k)[half * n..][..n];
                column.copy_from_slice(back.col_as_slice(k));
            }
        }
        for z in 0..inner {
            let column = enter.col_as_slice_mut(2 * n + z);
            column.copy_from_slice(into.col_as_slice(2 * m + z));
            for k in 0..len {
                leave[(2 * n + z, turns + k)] = out[(2 * m + z, k)];
            }
        }
        for turn in 0..turns {
            let answer: Vec<f64> = (0..len).map(|k| steady(turn, k)).collect();
            add(enter.col_as_slice_mut(states + turn), -1.0, &answer);
            let mut sum = vec![0.0; states];
            add_columns(&mut sum, &answer, |k| leave.col_as_slice(turns + k));
            leave.col_as_slice_mut(turn).copy_from_slice(&sum);
        }
        (enter, leave)
    }

    /// Every border of every stand.
    fn borders(&self, shared: &Shared, stands: &[BranchStand]) -> Result<Vec<Border>, Error> {
        let mut found = Vec::new();
        for (at, branch) in shared.train.branches.iter().enumerate() {
            match (&branch.law, stands[at]) {
                (Law::Contact(contact), BranchStand::Contact(stand, piece)) => {
                    let factor = branch.factor(0.0, &[], piece).0;
                    for (affine, to) in contact.borders(stand, factor) {
                        let kind = Kind::Deflection(affine);
                        let next = BranchStand::Contact(to, piece);
                        found.push(self.border(shared, at, kind, next));
                    }
                }
                (Law::Friction(_), BranchStand::Friction(slip)) if slip != Slip::Stick => {
                    let affine = Affine {
                        rate: slip.sign(),
                        ..Default::default()
                    };
                    let kind = Kind::Deflection(affine);
                    let next = BranchStand::Friction(Slip::Stick);
                    found.push(self.border(shared, at, kind, next));
                }
                (Law::Friction(friction), BranchStand::Friction(_)) => {
                    let Some(hold) = self.hold else { continue };
                    for slip in [Slip::Forward, Slip::Backward] {
                        let held =
                            hold.reaction(shared, self.laws, at, friction.breakaway, slip)?;
                        let next = BranchStand::Friction(slip);
                        found.push(self.border(shared, at, Kind::Reaction(held), next));
                    }
                }
                _ => {}
            }
        }
        Ok(found)
    }

    fn border(&self, shared: &Shared, branch: usize, kind: Kind, to: BranchStand) -> Border {
        let (m, len) = (self.modes.count(), self.spectrum.count());
        let seen = self.seen;
        let mut modal = vec![0.0; 2 * m + shared.train.inner()];
        let mut direct: BTreeMap<usize, [f64; 2]> = BTreeMap::new();
        let (constant, dense) = match &kind {
            Kind::Deflection(affine) => {
                for j in 0..m {
                    modal[j] = affine.deflection * seen.sees[branch][j];
                    modal[m + j] = affine.rate * seen.sees[branch][j];
                }
                let own = |input: &Input| input.entry == Entry::Imposed(branch);
                if let Some(at) = shared.inputs.list.iter().position(own) {
                    direct.insert(at, [-affine.deflection, -affine.rate]);
                }
                let dense = self.hold.map(|_| {
                    let w = spread(&shared.train.branches[branch].direction, shared.train.n());
                    let times = |a: f64| w.iter().map(|w| a * w).collect::<Vec<f64>>();
                    [times(affine.deflection), times(affine.rate)]
                });
                (affine.constant, dense)
            }
            Kind::Reaction(held) => {
                for j in 0..m {
                    let shape = self.modes.shapes.col_as_slice(j);
                    modal[j] = dot(&held.place, shape);
                    modal[m + j] = dot(&held.rate, shape);
                }
                modal[2 * m..].copy_from_slice(&held.inner);
                direct.extend(held.direct.iter().copied());
                (held.constant, Some([held.place.clone(), held.rate.clone()]))
            }
        };
        let row = self.stage.row(&modal, len);
        let rate = self.spectrum.rate_of(&row);
        let phasors = shared.inputs.frequencies.iter().enumerate();
        let phasors = phasors.map(|(f, &omega)| {
            let s = Complex::new(0.0, omega);
            let along = |of: &[Complex]| {
                let both = row.iter().zip(of);
                both.fold(Complex::ZERO, |sum, (c, x)| sum + x * *c)
            };
            let fed = direct
                .iter()
                .fold(Complex::ZERO, |sum, (&input, [value, rate])| {
                    let own = shared.inputs.list[input].harmonics.iter();
                    own.filter(|(at, _)| *at == f)
                        .fold(sum, |sum, (_, phasor)| sum + phasor * (s * rate + *value))
                });
            let value = along(&self.steady[f]) + fed;
            [value, value * s + along(&self.left[f])]
        });
        let phasors: Vec<[Complex; 2]> = phasors.collect();
        let turning = |which: usize| {
            phasors
                .iter()
                .flat_map(move |p| [p[which].re, -p[which].im])
        };
        let sizes = phasors.iter().map(|[p, _]| p.norm());
        let sizes: Vec<f64> = sizes.chain(self.spectrum.sizes_of(&row)).collect();
        let known = shared.inputs.frequencies.iter();
        let known = known.map(|&omega| Complex::new(0.0, omega));
        let lambdas: Vec<Complex> = known.chain(self.spectrum.swings.iter().copied()).collect();
        let rate: Vec<f64> = turning(1).chain(rate).collect();
        let row: Vec<f64> = turning(0).chain(row.iter().copied()).collect();
        Border {
            branch,
            to,
            lanes: Border::lanes(&lambdas, &row, &rate, &sizes),
            sizes,
            row,
            constant,
            direct: direct.into_iter().collect(),
            dense,
            kind,
        }
    }
}

/// The rows that decide which motions are rigid.
fn rows(shared: &Shared, laws: &[Held]) -> Rows {
    let train = shared.train;
    let n = train.n();
    let mut rows = Rows::default();
    for (branch, law) in train.branches.iter().zip(laws) {
        let w = shared.root.see(&spread(&branch.direction, n));
        let u = branch
            .force
            .as_ref()
            .map(|u| shared.root.see(&spread(u, n)));
        if law.sticks {
            rows.stuck.push(w);
            continue;
        }
        let (k, c) = (law.force.deflection, law.force.rate);
        if k > 0.0 && u.is_none() {
            rows.squares.push((w, k.sqrt()));
        } else if k != 0.0 {
            rows.springs.extend(std::iter::once(w).chain(u));
        } else if c != 0.0 || law.inner.is_some() {
            rows.dampers.extend(std::iter::once(w).chain(u));
        }
    }
    if let Some((k, c)) = &train.general {
        let row = |a: &Matrix, i: usize| {
            shared
                .root
                .see(&(0..n).map(|j| a[(i, j)]).collect::<Vec<_>>())
        };
        rows.springs.extend((0..n).map(|i| row(k, i)));
        rows.dampers.extend((0..n).map(|i| row(c, i)));
        let transposed = |a: &Matrix| a.transpose().to_owned();
        let (k, c) = (transposed(k), transposed(c));
        rows.dampers
            .extend((0..n).flat_map(|i| [row(&k, i), row(&c, i)]));
    }
    rows.springs.retain(|row| row.iter().any(|x| *x != 0.0));
    rows.dampers.retain(|row| row.iter().any(|x| *x != 0.0));
    rows
}

/// Directions over the modes.
#[derive(Debug)]
struct Seen {
    /// wᵀΦ of every branch.
    sees: Vec<Vec<f64>>,
    /// uᵀΦ.
    acts: Vec<Vec<f64>>,
}

impl Seen {
    fn new(train: &Train, laws: &[Held], modes: &Modes) -> Seen {
        let blind = |law: &Held, acting: bool| match law {
            // What a spring sees is not rigid, and where it acts along what it sees nothing rigid is pushed.
            law if law.force.deflection != 0.0 && !acting => modes.rigid,
            law if law.force.deflection != 0.0 || law.force.rate != 0.0 || law.inner.is_some() => {
                modes.free
            }
            _ => 0,
        };
        let of = |direction, blind| modes.seen(direction, blind);
        let both = train.branches.iter().zip(laws);
        let sees = both
            .clone()
            .map(|(b, law)| of(&b.direction, blind(law, false)));
        let acts = both.map(|(b, law)| of(b.acts(), blind(law, b.force.is_some())));
        Seen {
            sees: sees.collect(),
            acts: acts.collect(),
        }
    }
}

fn equations(train: &Train, laws: &[Held], modes: &Modes, seen: &Seen) -> Equations {
    let m = modes.count();
    let mut stiffness = Matrix::zeros(m, m);
    let mut beside = false;
    let mut inner = Vec::new();
    for (at, (branch, law)) in train.branches.iter().zip(laws).enumerate() {
        let (sees, acts) = (&seen.sees[at], &seen.acts[at]);
        let k = law.force.deflection;
        if k != 0.0 && (k < 0.0 || branch.force.is_some()) {
            beside = true;
            for (i, j) in (0..m).flat_map(|i| (0..m).map(move |j| (i, j))) {
                stiffness[(i, j)] += k * acts[i] * sees[j];
            }
        }
        if let Some(own) = &law.inner {
            inner.push(Inner {
                decay: own.decay,
                seen: sees.iter().map(|w| own.seen * w).collect(),
                acts: acts.iter().map(|u| -own.force * u).collect(),
                scale: own.scale,
            });
        }
    }
    if let Some((k, _)) = &train.general
        && k.norm_max() > 0.0
    {
        beside = true;
        let over = modes.shapes.transpose() * k * &modes.shapes;
        for (i, j) in (0..m).flat_map(|i| (modes.rigid..m).map(move |j| (i, j))) {
            stiffness[(i, j)] += over[(i, j)];
        }
    }
    Equations {
        omega: modes.omega.clone(),
        free: modes.free,
        rigid: modes.rigid,
        drag: train.drag,
        damping: damping(train, laws, modes, seen),
        stiffness: beside.then_some(stiffness),
        inner,
    }
}

/// D: by its diagonal where that is all of it.
fn damping(train: &Train, laws: &[Held], modes: &Modes, seen: &Seen) -> Damping {
    if let Some(beta) = rayleigh(train, laws) {
        let own = modes.omega.iter().map(|w| train.drag + beta * w * w);
        return Damping::Diagonal(own.collect());
    }
    let (n, m) = (train.n(), modes.count());
    let pairs = || (0..m).flat_map(|i| (0..m).map(move |j| (i, j)));
    let mut d = Matrix::zeros(m, m);
    // What each entry sums, without signs.
    let mut size = Matrix::zeros(m, m);
    let large = |w: &Direction| -> Vec<f64> {
        let whole = |j: usize| {
            let shape = modes.shapes.col_as_slice(j);
            w.scaled().map(|(i, a)| (a * shape[i]).abs()).sum()
        };
        (0..m).map(whole).collect()
    };
    for (at, (branch, law)) in train.branches.iter().zip(laws).enumerate() {
        let c = law.force.rate;
        if c == 0.0 {
            continue;
        }
        let (sees, acts) = (&seen.sees[at], &seen.acts[at]);
        let (large_w, large_u) = (large(&branch.direction), large(branch.acts()));
        for j in 0..m {
            add(d.col_as_slice_mut(j), c * sees[j], acts);
            add(size.col_as_slice_mut(j), c.abs() * large_w[j], &large_u);
        }
    }
    if let Some((_, c)) = &train.general {
        let over = modes.shapes.transpose() * c * &modes.shapes;
        let plain = |a: &Matrix| Matrix::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)].abs());
        let shapes = plain(&modes.shapes);
        let large = shapes.transpose() * plain(c) * &shapes;
        for (i, j) in pairs().filter(|&(i, j)| i >= modes.free && j >= modes.free) {
            d[(i, j)] += over[(i, j)];
            size[(i, j)] += large[(i, j)];
        }
    }
    (0..m).for_each(|j| d[(j, j)] += train.drag);
    let rounding = 4.0 * n as f64 * f64::EPSILON;
    let beside = pairs().any(|(i, j)| i != j && d[(i, j)].abs() > rounding * size[(i, j)]);
    match beside {
        true => Damping::Full(d),
        false => Damping::Diagonal((0..m).map(|j| d[(j, j)]).collect()),
    }
}

/// β where every spring's damper is β times the spring and nothing else damps but drag.
fn rayleigh(train: &Train, laws: &[Held]) -> Option<f64> {
    if train.general.is_some() {
        return None;
    }
    let mut beta: Option<f64> = None;
    for (branch, law) in train.branches.iter().zip(laws) {
        let (k, c) = (law.force.deflection, law.force.rate);
        if law.sticks || (k == 0.0 && c == 0.0) {
            continue;
        }
        if !(k > 0.0) || branch.force.is_some() {
            return None;
        }
        let own = c / k;
        let known = *beta.get_or_insert(own);
        if (own - known).abs() > 8.0 * f64::EPSILON * known.abs() {
            return None;
        }
    }
    Some(beta.unwrap_or(0.0))
}

/// Pushes on modal states.
struct RawPushes {
    constant: Vec<f64>,
    inputs: Vec<[Vec<f64>; 2]>,
}

impl RawPushes {
    fn new(shared: &Shared, laws: &[Held], seen: &Seen, modes: &Modes, inner: usize) -> RawPushes {
        let train = shared.train;
        let m = modes.count();
        let nothing = vec![0.0; 2 * m + inner];
        let mut constant = nothing.clone();
        let before = |branch: usize| {
            train.branches[..branch]
                .iter()
                .map(|b| b.inner())
                .sum::<usize>()
        };
        for (at, law) in laws.iter().enumerate() {
            (0..m).for_each(|j| constant[m + j] -= law.force.constant * seen.acts[at][j]);
            if let Some(own) = &law.inner {
                constant[2 * m + before(at)] += own.constant;
            }
        }
        let inputs = shared.inputs.list.iter().map(|input| {
            let (mut value, mut rate) = (nothing.clone(), nothing.clone());
            match input.entry {
                Entry::Drive(at) => {
                    let d = modes.seen(&train.drives[at].direction, 0);
                    value[m..2 * m].copy_from_slice(&d);
                }
                Entry::Imposed(at) => {
                    let law = &laws[at];
                    for j in 0..m {
                        value[m + j] = law.force.deflection * seen.acts[at][j];
                        rate[m + j] = law.force.rate * seen.acts[at][j];
                    }
                    if let Some(own) = &law.inner {
                        rate[2 * m + before(at)] = -own.imposed;
                    }
                }
            }
            [value, rate]
        });
        RawPushes {
            inputs: inputs.collect(),
            constant,
        }
    }

    /// ω and phasors of the push on modal states.
    fn harmonics(&self, inputs: &Inputs) -> Vec<(f64, Vec<Complex>)> {
        let of = |(f, &omega): (usize, &f64)| {
            let mut push = vec![Complex::ZERO; self.constant.len()];
            for (input, [value, rate]) in inputs.list.iter().zip(&self.inputs) {
                for (_, phasor) in input.harmonics.iter().filter(|(at, _)| *at == f) {
                    for (i, push) in push.iter_mut().enumerate() {
                        *push += phasor * Complex::new(value[i], omega * rate[i]);
                    }
                }
            }
            (omega, push)
        };
        inputs.frequencies.iter().enumerate().map(of).collect()
    }
}
