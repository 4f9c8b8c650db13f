//! Excitation orders of rotating members and tooth meshes per revolution of the reference, as exact fractions where possible.
//!
//! A member rotating at Ω excites the orders `n |Ω/Ω_ref|`; a gear with z teeth that meshes relative to a carrier excites
//! `n z |Ω − Ω_carrier| / Ω_ref` (Dresig & Holzweißig, Dynamics of Machinery, 2010, ch. 4).

use crate::base::error::Error;
use crate::machine::components::{Branch, BranchLaw, Gear, Machine};
use crate::machine::kinematics::{Kinematics, mean_speeds, no_rotation_error, supports_turning};
use crate::numeric::exact_constraints::ExactConstraints;
use crate::numeric::fraction::Fraction;
use crate::numeric::sorting::sort_ascending;

/// Excitation order with its sources.
#[derive(Debug, Clone, PartialEq)]
pub struct ExcitationOrder {
    /// Order per revolution of the reference as text, such as `37/12`; decimal if the stated speeds have no rational ratio.
    pub fraction: String,
    /// Exact order; `None` if only the decimal is known.
    pub exact: Option<Fraction>,
    /// Order as a number, > 0.
    pub value: f64,
    /// Sources of the order, at least one; several if their orders coincide.
    pub sources: Vec<ExcitationSource>,
}

/// A member of the machine that excites an order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExcitationSource {
    /// Name of the element: a gear pair, a planetary stage, a belt; for the reference, the element of its node.
    pub element: String,
    /// Name of the node of the member.
    pub member: String,
    /// Index of that node in `machine.nodes`.
    pub node: usize,
    /// Index in `machine.gears`; `None` for a reference without a gear.
    pub gear: Option<usize>,
    /// Cause of the excitation.
    pub cause: ExcitationCause,
    /// Harmonic number n ≥ 1.
    pub multiple: u32,
}

/// Cause by which a member excites an order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ExcitationCause {
    /// Rotation: eccentricity, unbalance.
    Rotation,
    /// Tooth meshing of the member.
    Mesh,
}

/// Numbers of harmonics per source.
#[derive(Debug, Clone, Copy)]
pub struct OrderOptions {
    /// Harmonics of the rotation of a member.
    pub rotation_multiples: u32,
    /// Harmonics of a tooth mesh.
    pub mesh_multiples: u32,
}

impl Default for OrderOptions {
    /// Two harmonics of a rotation, three of a mesh.
    fn default() -> Self {
        OrderOptions {
            rotation_multiples: 2,
            mesh_multiples: 3,
        }
    }
}

/// Degree of freedom that all orders refer to: that of the first stated speed, else the first dof that can rotate.
///
/// # Errors
/// The error of [`no_rotation_error`] if no dof can rotate.
pub fn reference_dof(machine: &Machine) -> Result<usize, Error> {
    let stated = machine.speeds.first().map(|&(dof, _)| dof);
    let first = || {
        let constraints = joint_constraints(machine, machine.dofs.len());
        (0..machine.dofs.len()).find(|&dof| !constraints.is_zero(dof))
    };
    stated
        .or_else(first)
        .ok_or_else(|| no_rotation_error(machine))
}

/// Orders of the reference and of every gear and pulley, ascending, each fraction once; stationary members excite none.
///
/// # Errors
/// Errors of [`mean_speeds`].
pub fn excitation_orders(
    machine: &Machine,
    kinematics: &Kinematics,
    options: &OrderOptions,
) -> Result<Vec<ExcitationOrder>, Error> {
    let reference = reference_dof(machine)?;
    let speeds = mean_speeds(machine, kinematics, Some(1.0))?;
    let ratios = SpeedConstraints {
        speeds,
        reference,
        constraints: speed_constraints(machine, reference),
    };
    let node_of = |dof: usize| machine.dofs[dof].node;
    let mut members: Vec<ExcitingMember> = machine
        .gears
        .iter()
        .enumerate()
        .map(|(n, gear)| ExcitingMember::from_gear(n, gear))
        .collect();
    if members
        .iter()
        .all(|member| node_of(member.dof) != node_of(reference))
    {
        let element = machine.nodes[node_of(reference)].element;
        members.push(ExcitingMember {
            element,
            gear: None,
            dof: reference,
            teeth: None,
            carrier: None,
        });
    }
    let mut orders: Vec<ExcitationOrder> = Vec::new();
    for member in &members {
        let mut add = |cause: ExcitationCause, multiple: u32| {
            let Some((exact, value)) = ratios.order(member, cause, multiple) else {
                return;
            };
            let decimal = || format!("{value:.9}");
            let fraction = exact.as_ref().map_or_else(decimal, Fraction::to_string);
            let node = node_of(member.dof);
            let element = machine.elements[member.element].name.clone();
            let name = machine.nodes[node].name.clone();
            let source = ExcitationSource {
                element,
                member: name,
                node,
                gear: member.gear,
                cause,
                multiple,
            };
            match orders.iter_mut().find(|order| order.fraction == fraction) {
                Some(order) => order.sources.push(source),
                None => orders.push(ExcitationOrder {
                    fraction,
                    exact,
                    value,
                    sources: vec![source],
                }),
            }
        };
        (1..=options.rotation_multiples)
            .for_each(|multiple| add(ExcitationCause::Rotation, multiple));
        if member.teeth.is_some() {
            (1..=options.mesh_multiples).for_each(|multiple| add(ExcitationCause::Mesh, multiple));
        }
    }
    sort_ascending(&mut orders, |a| a.value);
    Ok(orders)
}

/// Member with its gear data; `element`, the rotation `dof` and the dof `carrier` are indices.
struct ExcitingMember {
    element: usize,
    gear: Option<usize>,
    dof: usize,
    teeth: Option<u32>,
    carrier: Option<usize>,
}

impl ExcitingMember {
    fn from_gear(number: usize, gear: &Gear) -> ExcitingMember {
        let &Gear {
            element,
            rotation_dof: dof,
            teeth,
            carrier,
            ..
        } = gear;
        ExcitingMember {
            element,
            gear: Some(number),
            dof,
            teeth,
            carrier,
        }
    }
}

/// Mean speeds for a reference at 1 rad/s, and the constraints between them with one extra unknown for the order.
struct SpeedConstraints {
    speeds: Vec<f64>,
    reference: usize,
    constraints: ExactConstraints,
}

impl SpeedConstraints {
    /// `|factor (Ω − Ω_carrier)| / Ω_ref`, as an exact fraction if possible, and as a number; `None` if it is zero.
    fn order(
        &self,
        member: &ExcitingMember,
        cause: ExcitationCause,
        multiple: u32,
    ) -> Option<(Option<Fraction>, f64)> {
        let (factor, carrier) = match cause {
            ExcitationCause::Rotation => (f64::from(multiple), None),
            ExcitationCause::Mesh => (
                f64::from(multiple) * f64::from(member.teeth?),
                member.carrier,
            ),
        };
        let unknown = self.speeds.len();
        let mut row = vec![(unknown, 1.0), (member.dof, -factor)];
        row.extend(carrier.map(|carrier| (carrier, factor)));
        let mut constraints = self.constraints.clone();
        constraints.impose(&row);
        if constraints.is_zero(unknown) {
            return None;
        }
        if let Some(exact) = constraints.exact_ratio(unknown, self.reference) {
            let exact = exact.abs();
            let value = exact.to_f64();
            return Some((Some(exact), value));
        }
        let value =
            (factor * (self.speeds[member.dof] - carrier.map_or(0.0, |c| self.speeds[c]))).abs();
        // The reference rotates at 1 rad/s: a value below this is rounding of a stationary member.
        (value > 1e-12 * factor).then_some((None, value))
    }
}

/// Kinematic constraints that rigid and elastic joints impose on the mean speeds, short rows first. As in [`mean_speeds`], torsional
/// supports are omitted if they would block every dof or a dof with a stated nonzero speed.
fn joint_constraints(machine: &Machine, unknowns: usize) -> ExactConstraints {
    let joints = branch_constraints(machine, unknowns, |_| true);
    let idle = |&(dof, speed): &(usize, f64)| speed != 0.0 && joints.is_zero(dof);
    if (0..machine.dofs.len()).any(|dof| !joints.is_zero(dof)) && !machine.speeds.iter().any(idle) {
        return joints;
    }
    branch_constraints(machine, unknowns, |branch| {
        !supports_turning(machine, branch)
    })
}

fn branch_constraints(
    machine: &Machine,
    unknowns: usize,
    includes: impl Fn(&Branch) -> bool,
) -> ExactConstraints {
    let mut constraints = ExactConstraints::new(unknowns);
    let mut rows: Vec<&[(usize, f64)]> = machine
        .branches
        .iter()
        .filter(|branch| match branch.law {
            BranchLaw::Linear { stiffness, .. } => stiffness != 0.0,
            BranchLaw::Rigid => true,
        })
        .filter(|branch| includes(branch))
        .map(|branch| branch.direction.terms.as_slice())
        .collect();
    rows.sort_by_key(|row| row.len());
    for row in rows {
        constraints.impose(row);
    }
    constraints
}

/// Constraints of the joints and of the second and further stated speeds, as ratios to the first.
pub fn speed_constraints(machine: &Machine, reference: usize) -> ExactConstraints {
    let mut constraints = joint_constraints(machine, machine.dofs.len() + 1);
    let first_speed = machine.speeds.first().map_or(0.0, |stated| stated.1);
    for &(dof, speed) in machine.speeds.iter().skip(1) {
        if speed == 0.0 {
            constraints.impose(&[(dof, 1.0)]);
        } else if let Some((numerator, denominator)) = simple_fraction(speed / first_speed) {
            constraints.impose(&[(dof, denominator), (reference, -numerator)]);
        }
    }
    constraints
}

/// Numerator and denominator of a ratio of rounded speeds, by continued fractions; `None` beyond denominators of 10⁶.
fn simple_fraction(x: f64) -> Option<(f64, f64)> {
    const TOLERANCE: f64 = 1e-13; // relative: a few roundings of rpm to rad/s
    const MAX_DENOMINATOR: f64 = 1e6; // speeds have six figures at most
    let (mut p, mut q) = ([1.0, x.floor()], [0.0, 1.0]);
    let mut remainder = x - x.floor();
    while (p[1] / q[1] - x).abs() > TOLERANCE * x.abs() {
        let quotient = (1.0 / remainder).floor();
        remainder = 1.0 / remainder - quotient;
        p = [p[1], quotient * p[1] + p[0]];
        q = [q[1], quotient * q[1] + q[0]];
        if q[1].is_nan() || q[1] > MAX_DENOMINATOR {
            return None;
        }
    }
    p[1].is_finite().then_some((p[1], q[1]))
}
