//! Initial state: at rest, or at given speeds with static deflection `K q = f − M r a`.

use super::assembled::AssembledModel;
use super::contact::{ActiveFlanks, ContactLaw};
use super::dynamic_model::{DynamicModel, ForceElement, ForceLaw};
use super::pencil::add_outer_product;
use super::problem::OdeProblem;
use super::signal::Signal;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::machine::characteristic::{MAX_SECANT_ITERATIONS, SECANT_TOLERANCE};
use crate::machine::linear::LinearModel;
use crate::numeric::{Matrix, symmetric};
use crate::scene::laws::InitialState;

/// The state at rest, or running at the given speeds and wound up under the loads of the instant `t`.
///
/// The winding up: `K q = f − M r a`, the accelerations a of rigid motions r taken off first (inertia relief); contacts carry
/// on the flank their load presses, at the end of their play.
///
/// # Errors
/// A static solution that does not exist.
pub fn initial_state(
    moving: &AssembledModel,
    linear_model: &LinearModel,
    speeds: Option<&[f64]>,
    at: InitialState,
    t: f64,
) -> Result<Vec<f64>, Error> {
    let train = &moving.model;
    let n = train.coordinate_count();
    let mut y = vec![0.0; train.len()];
    let carried = moving.prescribed_motion(t);
    if at == InitialState::Rest {
        for (j, (place, speed)) in carried.into_iter().enumerate() {
            (y[j], y[n + j]) = (-place, -speed);
        }
        return Ok(y);
    }
    let Some(speeds) = speeds else {
        let hint = "state the speed of a node in [speed] of the model, or start from rest";
        return Err(
            Error::new(Code::UndeterminedSpeed, "a steady start needs the speeds").with_hint(hint),
        );
    };
    for (i, &dof) in linear_model.independent_dofs.iter().enumerate() {
        if let Some(j) = moving.coordinate_index(i) {
            y[n + j] = speeds[dof] - carried[j].1;
        }
    }
    match_error_rates(moving, t, &mut y)?;
    init_internal_states(train, t, &mut y);
    let q = match moving.branches.iter().any(|of| of.len() > 1) {
        true => equilibrium_of_flanks(moving, t, &y)?,
        false => static_equilibrium(train, &moving.rigid, t, &y)?,
    };
    y[..n].copy_from_slice(&q);
    Ok(y)
}

/// A push below this, relative to what makes it, comes from ratios of speeds that are rounded.
const ROUNDING_TOLERANCE: f64 = 1e-12;

/// Adds to the speeds what errors ask of them: `K v = −Σ u k δ̇`, so that what is wound up stays so.
fn match_error_rates(moving: &AssembledModel, t: f64, y: &mut [f64]) -> Result<(), Error> {
    let (model, rigid) = (&moving.model, &moving.rigid);
    let n = model.coordinate_count();
    let (q, v) = (vec![0.0; n], y[n..2 * n].to_vec());
    let mut push = vec![0.0; n];
    let mut size = 0.0f64;
    for (at, b) in model.elements.iter().enumerate() {
        // Which tooth pairs touch is not known yet, and gaps out of reach change fast.
        if is_tooth_pair(moving, at) {
            continue;
        }
        let piece = b.pieces_at(t);
        let rate = b.deflection(t, &q, &v, piece).1;
        let stiffness = static_stiffness(model, at);
        let swept: f64 = b.direction.entries().map(|(i, a)| (a * v[i]).abs()).sum();
        for (i, a) in b.force_direction().entries() {
            push[i] -= a * stiffness * rate;
            size = size.max((a * stiffness * swept).abs());
        }
    }
    if push.iter().all(|p| p.abs() <= ROUNDING_TOLERANCE * size) {
        return Ok(());
    }
    let mut k = Matrix::zeros(n, n);
    for (at, b) in model.elements.iter().enumerate() {
        add_outer_product(
            &mut k,
            b.force_direction(),
            &b.direction,
            static_stiffness(model, at),
        );
    }
    let mut speeds = symmetric::solve_semidefinite(&k, &push)?;
    // No turning of the whole is added.
    let momenta = model.momentum(&speeds);
    let mut turning = momenta;
    remove_rigid_loads(model, rigid, &mut turning);
    model.apply_inverse_mass(&mut turning);
    speeds.copy_from_slice(&turning);
    y[n..2 * n]
        .iter_mut()
        .zip(speeds)
        .for_each(|(v, s)| *v += s);
    Ok(())
}

/// The stiffness with which a branch winds up, its flanks closed.
fn static_stiffness(model: &DynamicModel, branch: usize) -> f64 {
    match &model.elements[branch].law {
        ForceLaw::Linear { stiffness, .. } => *stiffness,
        ForceLaw::Contact(contact) => contact.stiffness,
        ForceLaw::Nonlinear { characteristic, .. } => characteristic.rated_secant(),
        _ => 0.0,
    }
}

/// A branch is one tooth pair of several.
fn is_tooth_pair(moving: &AssembledModel, at: usize) -> bool {
    moving
        .branches
        .iter()
        .any(|of| of.len() > 2 && of.contains(&at))
}

/// +1 of what touches on drive flanks, −1 of coast flanks.
fn side(contact: &ContactLaw) -> f64 {
    match contact.flanks {
        ActiveFlanks::Coast => -1.0,
        _ => 1.0,
    }
}

/// Share of the largest applied force below which a force is rounding of a branch that carries nothing.
const IDLE_SHARE: f64 = 1e-9;

/// Rounds of the search for the tooth pairs that carry, for each pair.
const ROUNDS_PER_PAIR: usize = 10;

/// The winding up with flanks or tooth pairs that are elements of their own: all of a drive flank carry at first; then those that would pull
/// are let go and those that overlap are added.
fn equilibrium_of_flanks(moving: &AssembledModel, t: f64, y: &[f64]) -> Result<Vec<f64>, Error> {
    let model = &moving.model;
    let meshes: Vec<&Vec<usize>> = moving.branches.iter().filter(|of| of.len() > 1).collect();
    let n_pairs: usize = meshes.iter().map(|of| of.len()).sum();
    let mut closed: Vec<usize> = meshes
        .iter()
        .flat_map(|of| &of[..of.len() / 2])
        .copied()
        .collect();
    let still = vec![0.0; model.coordinate_count()];
    let overlap = |at: usize, q: &[f64]| match &model.elements[at].law {
        ForceLaw::Contact(contact) => {
            let b = &model.elements[at];
            let piece = b.pieces_at(t);
            side(contact) * b.deflection(t, q, &still, piece).0 - contact.half_play
        }
        _ => 0.0,
    };
    let applied = model.applied_forces(None, t, y);
    let idle = IDLE_SHARE * applied.iter().fold(0.0f64, |most, f| most.max(f.abs()));
    let solve = |closed: &[usize]| {
        let mut tight = model.clone();
        for &at in meshes.iter().copied().flatten() {
            let element = &mut tight.elements[at];
            if let (ForceLaw::Contact(contact), true) = (&mut element.law, closed.contains(&at)) {
                let play = Signal::constant(side(contact) * contact.half_play);
                element.imposed_displacement = Some(match &element.imposed_displacement {
                    Some(errors) => errors.plus(&play),
                    None => play,
                });
                contact.half_play = 0.0;
                contact.flanks = ActiveFlanks::Both;
            } else {
                element.law = ForceLaw::Linear {
                    stiffness: 0.0,
                    damping: 0.0,
                };
            }
        }
        static_equilibrium(&tight, &moving.rigid, t, y)
    };
    // A mesh whose drive pairs would pull together carries on its coast flanks.
    let q = solve(&closed)?;
    for of in &meshes {
        let (drive, coast) = of.split_at(of.len() / 2);
        let force = |at: &usize| static_stiffness(model, *at) * overlap(*at, &q);
        if drive.iter().map(force).sum::<f64>() < 0.0 {
            closed.retain(|at| !drive.contains(at));
            closed.extend(coast);
        }
    }
    for _ in 0..ROUNDS_PER_PAIR * n_pairs {
        let q = solve(&closed)?;
        let mut next: Vec<usize> = Vec::new();
        for of in &meshes {
            for flank in [&of[..of.len() / 2], &of[of.len() / 2..]] {
                if flank.iter().any(|at| closed.contains(at)) {
                    let touches = |at: &&usize| {
                        let scale = model.elements[**at].direction.scale;
                        static_stiffness(model, **at) * overlap(**at, &q) * scale > idle
                    };
                    next.extend(flank.iter().filter(touches));
                }
            }
        }
        if next == closed {
            return Ok(q);
        }
        closed = next;
    }
    let message = "the tooth pairs that carry at the start do not settle";
    Err(Error::new(Code::NoConvergence, message)
        .with_hint("start from rest, or change a load slightly"))
}

/// The winding up, characteristics by their secants, taken again until they stay.
fn static_equilibrium(
    model: &DynamicModel,
    rigid: &[Vec<f64>],
    t: f64,
    y: &[f64],
) -> Result<Vec<f64>, Error> {
    let n = model.coordinate_count();
    let mut straight = model.clone();
    for b in &mut straight.elements {
        if let Some(wave) = &mut b.stiffness_wave {
            wave.load_table = None;
        }
        if let ForceLaw::Nonlinear { characteristic, .. } = &b.law {
            b.law = ForceLaw::Linear {
                stiffness: characteristic.rated_secant(),
                damping: 0.0,
            };
        }
    }
    for _ in 0..MAX_SECANT_ITERATIONS {
        let q = static_deflection(&straight, rigid, t, y)?;
        let mut moved = 0.0f64;
        for (b, straight) in model.elements.iter().zip(&mut straight.elements) {
            if b.follows_load() {
                moved = moved.max(update_mesh_secant(b, straight, t, &y[..n], &q));
                continue;
            }
            let (ForceLaw::Nonlinear { characteristic, .. }, ForceLaw::Linear { stiffness, .. }) =
                (&b.law, &mut straight.law)
            else {
                continue;
            };
            let piece = b.pieces_at(t);
            let (delta, _) = b.deflection(t, &q, &vec![0.0; q.len()], piece);
            let force = *stiffness * delta;
            moved = moved.max(characteristic.update_secant(stiffness, force));
        }
        if moved <= SECANT_TOLERANCE {
            return Ok(q);
        }
    }
    let message = "the forces in couplings and teeth that are not linear do not settle under the loads at the start";
    Err(Error::new(Code::NoConvergence, message)
        .with_hint("start from rest, or change a load slightly"))
}

/// Replaces the stiffness of `straight` by the secant of a mesh that follows its load under the same force; the relative change. Waves go
/// by the coordinates `y`.
fn update_mesh_secant(
    b: &ForceElement,
    straight: &mut ForceElement,
    t: f64,
    y: &[f64],
    q: &[f64],
) -> f64 {
    let (Some(wave), ForceLaw::Contact(law)) = (&b.stiffness_wave, &b.law) else {
        return 0.0;
    };
    let psi = wave.phase.phase_at(t, y);
    let piece = wave.waveform.piece(psi);
    let (delta, _) = b.deflection(t, q, &vec![0.0; q.len()], b.pieces_at(t));
    let g = delta.abs() - law.half_play;
    let factor = wave.waveform.value_in(psi, piece);
    let (Some(curve), ForceLaw::Contact(straight)) =
        (wave.load_curve(psi, piece), &mut straight.law)
    else {
        return 0.0;
    };
    let load = factor * straight.stiffness / law.stiffness * g;
    if load.is_nan() || load <= 0.0 {
        return 0.0;
    }
    let next = law.stiffness * load / curve.at_load(load)[0] / factor;
    let moved = (next / straight.stiffness - 1.0).abs();
    straight.stiffness = next;
    moved
}

/// Coordinates under the loads of the instant.
fn static_deflection(
    model: &DynamicModel,
    rigid: &[Vec<f64>],
    t: f64,
    y: &[f64],
) -> Result<Vec<f64>, Error> {
    let n = model.coordinate_count();
    let mut tight = model.clone();
    for b in &mut tight.elements {
        if let ForceLaw::Contact(contact) = &mut b.law {
            contact.half_play = 0.0;
        }
    }
    let mut push = tight.applied_forces(None, t, y);
    remove_rigid_loads(model, rigid, &mut push);
    let mut k = Matrix::zeros(n, n);
    for (at, b) in tight.elements.iter().enumerate() {
        if let ForceLaw::AngleLocked { .. } = b.law {
            continue;
        }
        let stiffness = tight.element_force(at, None, t, y, 0.0).1;
        for (i, a) in b.direction.entries() {
            for (j, c) in b.direction.entries() {
                k[(i, j)] += stiffness * a * c;
            }
        }
    }
    let tight_q = symmetric::solve_semidefinite(&k, &push)?;
    for (at, b) in model.elements.iter().enumerate() {
        let ForceLaw::Contact(ContactLaw {
            half_play: half, ..
        }) = &b.law
        else {
            continue;
        };
        let stiffness = tight.element_force(at, None, t, y, 0.0).1;
        let piece = b.pieces_at(t);
        let still = vec![0.0; n];
        let force = stiffness * b.deflection(t, &tight_q, &still, piece).0;
        let largest = push.iter().fold(0.0f64, |m, f| m.max(f.abs()));
        // A branch that carries nothing stays in the middle of its play.
        if force.abs() * b.direction.scale > IDLE_SHARE * largest {
            let offset = stiffness * force.signum() * half;
            b.direction
                .entries()
                .for_each(|(i, a)| push[i] += a * offset);
        }
    }
    symmetric::solve_semidefinite(&k, &push)
}

/// Inner states as they are at steady speed.
fn init_internal_states(model: &DynamicModel, t: f64, y: &mut [f64]) {
    let n = model.coordinate_count();
    let mut inner = 2 * n;
    for b in &model.elements {
        if let ForceLaw::LaggedTorque { curve, .. } = &b.law {
            let piece = b.pieces_at(t);
            y[inner] = curve.torque(b.deflection(t, &y[..n], &y[n..2 * n], piece).1);
        }
        inner += b.internal_count();
    }
}

/// Takes off the forces that accelerate rigid motions.
fn remove_rigid_loads(model: &DynamicModel, rigid: &[Vec<f64>], push: &mut [f64]) {
    let m = rigid.len();
    if m == 0 {
        return;
    }
    let momenta: Vec<Vec<f64>> = rigid.iter().map(|r| model.momentum(r)).collect();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    let inertia = Matrix::from_fn(m, m, |i, j| dot(&rigid[i], &momenta[j]));
    let right: Vec<f64> = rigid.iter().map(|r| dot(r, push)).collect();
    if let Ok(a) = symmetric::solve_semidefinite(&inertia, &right) {
        for (p, a) in momenta.iter().zip(a) {
            push.iter_mut().zip(p).for_each(|(f, p)| *f -= a * p);
        }
    }
}
