//! The state a scene starts from.

use super::contact::Contact;
use super::moving::Moving;
use super::pencil::add;
use super::problem::Problem;
use super::train::{Law, Train};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::machine::characteristic::{MOST_ROUNDS, SETTLED};
use crate::machine::linear::Linear;
use crate::numeric::{Matrix, definite};
use crate::scene::laws::StartAt;

/// The state at rest, or running at the given speeds and wound up under the loads of the instant `t`.
///
/// The winding up: `K q = f − M r a`, the accelerations a of rigid motions r taken off first (inertia relief); contacts carry
/// on the flank their load presses, at the end of their play.
///
/// # Errors
/// A static solution that does not exist.
pub fn state(
    moving: &Moving,
    linear: &Linear,
    speeds: Option<&[f64]>,
    at: StartAt,
    t: f64,
) -> Result<Vec<f64>, Error> {
    let train = &moving.train;
    let n = train.n();
    let mut y = vec![0.0; train.len()];
    let carried = moving.carried(t);
    if at == StartAt::Rest {
        for (j, (place, speed)) in carried.into_iter().enumerate() {
            (y[j], y[n + j]) = (-place, -speed);
        }
        return Ok(y);
    }
    let Some(speeds) = speeds else {
        let hint = "state the speed of a node in [speed] of the model, or start from rest";
        return Err(Error::new(Code::NoSpeed, "a steady start needs the speeds").hint(hint));
    };
    for (i, &freedom) in linear.free.iter().enumerate() {
        if let Some(j) = moving.place(i) {
            y[n + j] = speeds[freedom] - carried[j].1;
        }
    }
    keep_up(train, &moving.rigid, t, &mut y)?;
    lag(train, t, &mut y);
    let q = settle(train, &moving.rigid, t, &y)?;
    y[..n].copy_from_slice(&q);
    Ok(y)
}

/// A push below this, relative to what makes it, comes from ratios of speeds that are rounded.
const ROUNDED: f64 = 1e-12;

/// Adds to the speeds what errors ask of them: `K v = −Σ u k δ̇`, so that what is wound up stays so.
fn keep_up(train: &Train, rigid: &[Vec<f64>], t: f64, y: &mut [f64]) -> Result<(), Error> {
    let n = train.n();
    let (q, v) = (vec![0.0; n], y[n..2 * n].to_vec());
    let mut push = vec![0.0; n];
    let mut size = 0.0f64;
    for (at, b) in train.branches.iter().enumerate() {
        let piece = b.imposed.as_ref().map_or(0, |e| e.piece(t) as u32);
        let rate = b.deflection(t, &q, &v, piece).1;
        let stiffness = of_spring(train, at);
        let swept: f64 = b.direction.scaled().map(|(i, a)| (a * v[i]).abs()).sum();
        for (i, a) in b.acts().scaled() {
            push[i] -= a * stiffness * rate;
            size = size.max((a * stiffness * swept).abs());
        }
    }
    if push.iter().all(|p| p.abs() <= ROUNDED * size) {
        return Ok(());
    }
    let mut k = Matrix::zeros(n, n);
    for (at, b) in train.branches.iter().enumerate() {
        add(&mut k, b.acts(), &b.direction, of_spring(train, at));
    }
    let mut speeds = definite::solve_semidefinite(&k, &push)?;
    // No turning of the whole is added.
    let momenta = train.momentum(&speeds);
    let mut turning = momenta;
    relieve(train, rigid, &mut turning);
    train.accelerate(&mut turning);
    speeds.copy_from_slice(&turning);
    y[n..2 * n]
        .iter_mut()
        .zip(speeds)
        .for_each(|(v, s)| *v += s);
    Ok(())
}

/// The stiffness with which a branch winds up, its flanks closed.
fn of_spring(train: &Train, branch: usize) -> f64 {
    match &train.branches[branch].law {
        Law::Linear { stiffness, .. } => *stiffness,
        Law::Contact(contact) => contact.stiffness,
        Law::Nonlinear { characteristic, .. } => characteristic.rated(),
        _ => 0.0,
    }
}

/// The winding up, characteristics by their secants, taken again until they stay.
fn settle(train: &Train, rigid: &[Vec<f64>], t: f64, y: &[f64]) -> Result<Vec<f64>, Error> {
    let mut straight = train.clone();
    for b in &mut straight.branches {
        if let Law::Nonlinear { characteristic, .. } = &b.law {
            b.law = Law::Linear {
                stiffness: characteristic.rated(),
                damping: 0.0,
            };
        }
    }
    for _ in 0..MOST_ROUNDS {
        let q = wound(&straight, rigid, t, y)?;
        let mut moved = 0.0f64;
        for (b, straight) in train.branches.iter().zip(&mut straight.branches) {
            let (Law::Nonlinear { characteristic, .. }, Law::Linear { stiffness, .. }) =
                (&b.law, &mut straight.law)
            else {
                continue;
            };
            let piece = b.imposed.as_ref().map_or(0, |e| e.piece(t) as u32);
            let (delta, _) = b.deflection(t, &q, &vec![0.0; q.len()], piece);
            let force = *stiffness * delta;
            moved = moved.max(characteristic.retake(stiffness, force));
        }
        if moved <= SETTLED {
            return Ok(q);
        }
    }
    let message = "the forces in couplings and teeth that are not linear do not settle under the loads at the start";
    Err(Error::new(Code::NoConvergence, message).hint("start from rest, or change a load slightly"))
}

/// Coordinates under the loads of the instant.
fn wound(train: &Train, rigid: &[Vec<f64>], t: f64, y: &[f64]) -> Result<Vec<f64>, Error> {
    let n = train.n();
    let mut tight = train.clone();
    for b in &mut tight.branches {
        if let Law::Contact(contact) = &mut b.law {
            contact.half = 0.0;
        }
    }
    let mut push = tight.pushed(None, t, y);
    relieve(train, rigid, &mut push);
    let mut k = Matrix::zeros(n, n);
    for (at, b) in tight.branches.iter().enumerate() {
        if let Law::Orders { .. } = b.law {
            continue;
        }
        let stiffness = tight.force(at, None, t, y, 0.0).1;
        for (i, a) in b.direction.scaled() {
            for (j, c) in b.direction.scaled() {
                k[(i, j)] += stiffness * a * c;
            }
        }
    }
    let tight_q = definite::solve_semidefinite(&k, &push)?;
    for (at, b) in train.branches.iter().enumerate() {
        let Law::Contact(Contact { half, .. }) = &b.law else {
            continue;
        };
        let stiffness = tight.force(at, None, t, y, 0.0).1;
        let piece = b.imposed.as_ref().map_or(0, |e| e.piece(t) as u32);
        let still = vec![0.0; n];
        let force = stiffness * b.deflection(t, &tight_q, &still, piece).0;
        let largest = push.iter().fold(0.0f64, |m, f| m.max(f.abs()));
        // A force this small is rounding of a branch that carries nothing: it stays in the middle of its play.
        if force.abs() * b.direction.scale > 1e-9 * largest {
            let offset = stiffness * force.signum() * half;
            b.direction
                .scaled()
                .for_each(|(i, a)| push[i] += a * offset);
        }
    }
    definite::solve_semidefinite(&k, &push)
}

/// Inner states as they are at steady speed.
fn lag(train: &Train, t: f64, y: &mut [f64]) {
    let n = train.n();
    let mut inner = 2 * n;
    for b in &train.branches {
        if let Law::Lagged { curve, .. } = &b.law {
            let piece = b.imposed.as_ref().map_or(0, |e| e.piece(t) as u32);
            y[inner] = curve.torque(b.deflection(t, &y[..n], &y[n..2 * n], piece).1);
        }
        inner += b.inner();
    }
}

/// Takes off the forces that accelerate rigid motions.
fn relieve(train: &Train, rigid: &[Vec<f64>], push: &mut [f64]) {
    let m = rigid.len();
    if m == 0 {
        return;
    }
    let momenta: Vec<Vec<f64>> = rigid.iter().map(|r| train.momentum(r)).collect();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    let inertia = Matrix::from_fn(m, m, |i, j| dot(&rigid[i], &momenta[j]));
    let right: Vec<f64> = rigid.iter().map(|r| dot(r, push)).collect();
    if let Ok(a) = definite::solve_semidefinite(&inertia, &right) {
        for (p, a) in momenta.iter().zip(a) {
            push.iter_mut().zip(p).for_each(|(f, p)| *f -= a * p);
        }
    }
}
