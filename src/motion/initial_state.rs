//! Initial state: at rest, or at given speeds with the static deflection `K q = f − M r a`.

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

/// State at rest, or at the given speeds, rad/s, with the static deflection under the loads at time `t`, s.
///
/// The static deflection solves `K q = f − M r a` with the accelerations a of the rigid-body motions r (inertia relief); contacts carry on
/// the flank that their load closes, at the end of their play.
///
/// # Errors
/// `UndeterminedSpeed` without speeds; `NoConvergence` of the static solution.
pub fn initial_state(
    assembled: &AssembledModel,
    linear_model: &LinearModel,
    speeds: Option<&[f64]>,
    at: InitialState,
    t: f64,
) -> Result<Vec<f64>, Error> {
    let model = &assembled.model;
    let n = model.coordinate_count();
    let mut y = vec![0.0; model.len()];
    let prescribed = assembled.prescribed_motion(t);
    if at == InitialState::Rest {
        for (j, (position, speed)) in prescribed.into_iter().enumerate() {
            (y[j], y[n + j]) = (-position, -speed);
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
        if let Some(j) = assembled.coordinate_index(i) {
            y[n + j] = speeds[dof] - prescribed[j].1;
        }
    }
    match_error_rates(assembled, t, &mut y)?;
    init_internal_states(model, t, &mut y);
    let q = match assembled.branches.iter().any(|elements| elements.len() > 1) {
        true => flank_equilibrium(assembled, t, &y)?,
        false => static_equilibrium(model, &assembled.rigid, t, &y)?,
    };
    y[..n].copy_from_slice(&q);
    Ok(y)
}

/// Force that counts as rounding of speed ratios, relative to the largest force term.
const ROUNDING_TOLERANCE: f64 = 1e-12;

/// Adds the speeds that keep the deflections constant under varying geometric errors: `K v = −Σ u k δ̇`.
fn match_error_rates(assembled: &AssembledModel, t: f64, y: &mut [f64]) -> Result<(), Error> {
    let (model, rigid) = (&assembled.model, &assembled.rigid);
    let n = model.coordinate_count();
    let (q, v) = (vec![0.0; n], y[n..2 * n].to_vec());
    let mut force = vec![0.0; n];
    let mut size = 0.0f64;
    for (at, b) in model.elements.iter().enumerate() {
        // The tooth pairs in contact are not yet known, and the gaps of distant pairs change fast.
        if is_tooth_pair(assembled, at) {
            continue;
        }
        let piece = b.pieces_at(t);
        let rate = b.deflection(t, &q, &v, piece).1;
        let stiffness = static_stiffness(model, at);
        let swept: f64 = b.direction.entries().map(|(i, a)| (a * v[i]).abs()).sum();
        for (i, a) in b.force_direction().entries() {
            force[i] -= a * stiffness * rate;
            size = size.max((a * stiffness * swept).abs());
        }
    }
    if force.iter().all(|p| p.abs() <= ROUNDING_TOLERANCE * size) {
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
    let mut speeds = symmetric::solve_semidefinite(&k, &force)?;
    // Rigid-body rotation is removed.
    let mut elastic = model.momentum(&speeds);
    remove_rigid_loads(model, rigid, &mut elastic);
    model.apply_inverse_mass(&mut elastic);
    speeds.copy_from_slice(&elastic);
    y[n..2 * n]
        .iter_mut()
        .zip(speeds)
        .for_each(|(v, s)| *v += s);
    Ok(())
}

/// Static stiffness of an element with closed flanks, N·m/rad or N/m.
fn static_stiffness(model: &DynamicModel, branch: usize) -> f64 {
    match &model.elements[branch].law {
        ForceLaw::Linear { stiffness, .. } => *stiffness,
        ForceLaw::Contact(contact) => contact.stiffness,
        ForceLaw::Nonlinear { characteristic, .. } => characteristic.rated_secant(),
        _ => 0.0,
    }
}

/// Whether an element is one tooth pair of several.
fn is_tooth_pair(assembled: &AssembledModel, at: usize) -> bool {
    assembled
        .branches
        .iter()
        .any(|elements| elements.len() > 2 && elements.contains(&at))
}

/// Flank sign: −1 for a contact on coast flanks only, otherwise +1.
fn side(contact: &ContactLaw) -> f64 {
    match contact.flanks {
        ActiveFlanks::Coast => -1.0,
        _ => 1.0,
    }
}

/// Ratio to the largest applied force below which a force is rounding of an unloaded element.
const IDLE_SHARE: f64 = 1e-9;

/// Maximum number of iterations of the search for the loaded tooth pairs, per pair.
const ROUNDS_PER_PAIR: usize = 10;

/// Static deflection with separate elements for flanks or tooth pairs: all pairs of the drive flank carry at first; then pairs under tension
/// are released and overlapping pairs are closed.
fn flank_equilibrium(assembled: &AssembledModel, t: f64, y: &[f64]) -> Result<Vec<f64>, Error> {
    let model = &assembled.model;
    let meshes: Vec<&Vec<usize>> = assembled.branches.iter().filter(|m| m.len() > 1).collect();
    let n_pairs: usize = meshes.iter().map(|m| m.len()).sum();
    let mut closed: Vec<usize> = meshes
        .iter()
        .flat_map(|m| &m[..m.len() / 2])
        .copied()
        .collect();
    let zero = vec![0.0; model.coordinate_count()];
    let overlap = |at: usize, q: &[f64]| match &model.elements[at].law {
        ForceLaw::Contact(contact) => {
            let b = &model.elements[at];
            let piece = b.pieces_at(t);
            side(contact) * b.deflection(t, q, &zero, piece).0 - contact.half_play
        }
        _ => 0.0,
    };
    let applied = model.applied_forces(None, t, y);
    let idle = IDLE_SHARE * applied.iter().fold(0.0f64, |max, f| max.max(f.abs()));
    let solve = |closed: &[usize]| {
        let mut closed_model = model.clone();
        for &at in meshes.iter().copied().flatten() {
            let element = &mut closed_model.elements[at];
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
        static_equilibrium(&closed_model, &assembled.rigid, t, y)
    };
    // A mesh whose drive pairs are under tension in sum carries on its coast flanks.
    let q = solve(&closed)?;
    for m in &meshes {
        let (drive, coast) = m.split_at(m.len() / 2);
        let force = |at: &usize| static_stiffness(model, *at) * overlap(*at, &q);
        if drive.iter().map(force).sum::<f64>() < 0.0 {
            closed.retain(|at| !drive.contains(at));
            closed.extend(coast);
        }
    }
    for _ in 0..ROUNDS_PER_PAIR * n_pairs {
        let q = solve(&closed)?;
        let mut next: Vec<usize> = Vec::new();
        for m in &meshes {
            for flank in [&m[..m.len() / 2], &m[m.len() / 2..]] {
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
    let message = "the loaded tooth pairs at the start do not converge";
    Err(Error::new(Code::NoConvergence, message)
        .with_hint("start from rest, or change a load slightly"))
}

/// Static deflection with secant stiffnesses of the nonlinear elements, iterated to convergence.
fn static_equilibrium(
    model: &DynamicModel,
    rigid: &[Vec<f64>],
    t: f64,
    y: &[f64],
) -> Result<Vec<f64>, Error> {
    let n = model.coordinate_count();
    let mut linearised = model.clone();
    for b in &mut linearised.elements {
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
        let q = static_deflection(&linearised, rigid, t, y)?;
        let mut change = 0.0f64;
        for (b, linearised) in model.elements.iter().zip(&mut linearised.elements) {
            if b.follows_load() {
                change = change.max(update_mesh_secant(b, linearised, t, &y[..n], &q));
                continue;
            }
            let (ForceLaw::Nonlinear { characteristic, .. }, ForceLaw::Linear { stiffness, .. }) =
                (&b.law, &mut linearised.law)
            else {
                continue;
            };
            let piece = b.pieces_at(t);
            let (delta, _) = b.deflection(t, &q, &vec![0.0; q.len()], piece);
            let force = *stiffness * delta;
            change = change.max(characteristic.update_secant(stiffness, force));
        }
        if change <= SECANT_TOLERANCE {
            return Ok(q);
        }
    }
    let message = "nonlinear forces in couplings and teeth do not converge under the initial loads";
    Err(Error::new(Code::NoConvergence, message)
        .with_hint("start from rest, or change a load slightly"))
}

/// Sets the stiffness of `linearised` to the secant of a load-dependent mesh under the same force and returns the relative change. The wave
/// phases follow from the coordinates `y`.
fn update_mesh_secant(
    b: &ForceElement,
    linearised: &mut ForceElement,
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
    let (Some(curve), ForceLaw::Contact(linearised)) =
        (wave.load_curve(psi, piece), &mut linearised.law)
    else {
        return 0.0;
    };
    let load = factor * linearised.stiffness / law.stiffness * g;
    if load.is_nan() || load <= 0.0 {
        return 0.0;
    }
    let next = law.stiffness * load / curve.at_load(load)[0] / factor;
    let change = (next / linearised.stiffness - 1.0).abs();
    linearised.stiffness = next;
    change
}

/// Coordinates in static equilibrium under the loads at time `t`.
fn static_deflection(
    model: &DynamicModel,
    rigid: &[Vec<f64>],
    t: f64,
    y: &[f64],
) -> Result<Vec<f64>, Error> {
    let n = model.coordinate_count();
    let mut closed = model.clone();
    for b in &mut closed.elements {
        if let ForceLaw::Contact(contact) = &mut b.law {
            contact.half_play = 0.0;
        }
    }
    let mut loads = closed.applied_forces(None, t, y);
    remove_rigid_loads(model, rigid, &mut loads);
    let mut k = Matrix::zeros(n, n);
    for (at, b) in closed.elements.iter().enumerate() {
        if let ForceLaw::AngleLocked { .. } = b.law {
            continue;
        }
        let stiffness = closed.element_force(at, None, t, y, 0.0).1;
        for (i, a) in b.direction.entries() {
            for (j, c) in b.direction.entries() {
                k[(i, j)] += stiffness * a * c;
            }
        }
    }
    let q_closed = symmetric::solve_semidefinite(&k, &loads)?;
    for (at, b) in model.elements.iter().enumerate() {
        let ForceLaw::Contact(ContactLaw {
            half_play: half, ..
        }) = &b.law
        else {
            continue;
        };
        let stiffness = closed.element_force(at, None, t, y, 0.0).1;
        let piece = b.pieces_at(t);
        let zero = vec![0.0; n];
        let f = stiffness * b.deflection(t, &q_closed, &zero, piece).0;
        let largest = loads.iter().fold(0.0f64, |m, f| m.max(f.abs()));
        // An unloaded element stays in the middle of its play.
        if f.abs() * b.direction.scale > IDLE_SHARE * largest {
            let offset = stiffness * f.signum() * half;
            b.direction
                .entries()
                .for_each(|(i, a)| loads[i] += a * offset);
        }
    }
    symmetric::solve_semidefinite(&k, &loads)
}

/// Sets the internal states to their values at constant speed.
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

/// Subtracts the inertia forces of the rigid-body accelerations (inertia relief).
fn remove_rigid_loads(model: &DynamicModel, rigid: &[Vec<f64>], forces: &mut [f64]) {
    let m = rigid.len();
    if m == 0 {
        return;
    }
    let momenta: Vec<Vec<f64>> = rigid.iter().map(|r| model.momentum(r)).collect();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    let inertia = Matrix::from_fn(m, m, |i, j| dot(&rigid[i], &momenta[j]));
    let right: Vec<f64> = rigid.iter().map(|r| dot(r, forces)).collect();
    if let Ok(a) = symmetric::solve_semidefinite(&inertia, &right) {
        for (p, a) in momenta.iter().zip(a) {
            forces.iter_mut().zip(p).for_each(|(f, p)| *f -= a * p);
        }
    }
}
