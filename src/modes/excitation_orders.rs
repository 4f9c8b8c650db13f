//! Excitation orders of teeth and eccentric members per turn of the reference, exact fractions.
//!
//! A member turning at Ω excites |Ω/Ω_ref| and its second; teeth meshing on a carrier excite `z |Ω − Ω_carrier| / Ω_ref`
//! and multiples (Dresig & Holzweißig, Dynamics of Machinery, 2010, ch. 4, for what excites them).

use crate::base::error::Error;
use crate::machine::components::{Branch, BranchLaw, Gear, Machine};
use crate::machine::kinematics::{Kinematics, mean_speeds, no_rotation_error, supports_turning};
use crate::numeric::exact_constraints::ExactConstraints;
use crate::numeric::fraction::Fraction;
use crate::numeric::sorting::sort_rising;

/// An order, with all that excites it.
#[derive(Debug, Clone, PartialEq)]
pub struct ExcitationOrder {
    /// Per turn of the reference, such as `37/12`; a decimal where the stated speeds are in no ratio of whole numbers.
    pub fraction: String,
    /// The same, where it is exact.
    pub exact: Option<Fraction>,
    /// The same as a number.
    pub value: f64,
    /// Excitation sources of the order: one or more, where orders coincide.
    pub sources: Vec<ExcitationSource>,
}

/// A member of the machine that excites an order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExcitationSource {
    /// The element: a gear pair, a planetary stage, a belt; of the reference its own.
    pub element: String,
    /// The node of its member.
    pub member: String,
    /// The number of that node.
    pub node: usize,
    /// Gear number in `machine.gears`; `None` for the reference where it carries no gear.
    pub gear: Option<usize>,
    /// Cause of the excitation.
    pub cause: ExcitationCause,
    /// 1 for the order itself, 2 for twice it, ….
    pub multiple: u32,
}

/// Cause by which a member excites an order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ExcitationCause {
    /// It turns: eccentricity, unbalance.
    Rotation,
    /// Tooth meshing of the member.
    Mesh,
}

/// Which orders are wanted.
#[derive(Debug, Clone, Copy)]
pub struct OrderOptions {
    /// Multiples of a member's rotation.
    pub rotation_multiples: u32,
    /// Multiples of a mesh.
    pub mesh_multiples: u32,
}

impl Default for OrderOptions {
    /// Two of a rotation, three of a mesh.
    fn default() -> Self {
        OrderOptions {
            rotation_multiples: 2,
            mesh_multiples: 3,
        }
    }
}

/// The degree of freedom all orders refer to: that of the first speed stated, else the first that can turn.
///
/// # Errors
/// Nothing can turn.
pub fn reference_dof(machine: &Machine) -> Result<usize, Error> {
    let stated = machine.speeds.first().map(|&(dof, _)| dof);
    let first = || {
        let turning = joint_constraints(machine, machine.dofs.len());
        (0..machine.dofs.len()).find(|&dof| !turning.is_zero(dof))
    };
    stated
        .or_else(first)
        .ok_or_else(|| no_rotation_error(machine))
}

/// Every order of the reference and of every gear and pulley, ascending, each fraction once. Members that stand still have none.
///
/// # Errors
/// Those of `mean_speeds`.
pub fn excitation_orders(
    machine: &Machine,
    kinematics: &Kinematics,
    options: &OrderOptions,
) -> Result<Vec<ExcitationOrder>, Error> {
    let reference = reference_dof(machine)?;
    let unit = mean_speeds(machine, kinematics, Some(1.0))?;
    let ratios = SpeedConstraints {
        unit,
        reference,
        turning: speed_constraints(machine, reference),
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
        .all(|member| node_of(member.turning) != node_of(reference))
    {
        let element = machine.nodes[node_of(reference)].element;
        members.push(ExcitingMember {
            element,
            gear: None,
            turning: reference,
            teeth: None,
            carrier: None,
        });
    }
    let mut orders: Vec<ExcitationOrder> = Vec::new();
    for member in &members {
        let mut put = |cause: ExcitationCause, multiple: u32| {
            let Some((exact, value)) = ratios.order(member, cause, multiple) else {
                return;
            };
            let decimal = || format!("{value:.9}");
            let fraction = exact.as_ref().map_or_else(decimal, Fraction::to_string);
            let node = node_of(member.turning);
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
            .for_each(|multiple| put(ExcitationCause::Rotation, multiple));
        if member.teeth.is_some() {
            (1..=options.mesh_multiples).for_each(|multiple| put(ExcitationCause::Mesh, multiple));
        }
    }
    sort_rising(&mut orders, |a| a.value);
    Ok(orders)
}

/// A member that excites orders.
struct ExcitingMember {
    element: usize,
    gear: Option<usize>,
    turning: usize,
    teeth: Option<u32>,
    carrier: Option<usize>,
}

impl ExcitingMember {
    fn from_gear(number: usize, gear: &Gear) -> ExcitingMember {
        let &Gear {
            element,
            rotation_dof: turning,
            teeth,
            carrier,
            ..
        } = gear;
        ExcitingMember {
            element,
            gear: Some(number),
            turning,
            teeth,
            carrier,
        }
    }
}

/// Everything that ties speeds together, with room for one unknown more.
struct SpeedConstraints {
    unit: Vec<f64>,
    reference: usize,
    turning: ExactConstraints,
}

impl SpeedConstraints {
    /// `|factor (Ω − Ω_carrier)| / Ω_ref`, exact where it can be, and its value; nothing where that is zero.
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
        let order = self.unit.len();
        let mut row = vec![(order, 1.0), (member.turning, -factor)];
        row.extend(carrier.map(|carrier| (carrier, factor)));
        let mut turning = self.turning.clone();
        turning.impose(&row);
        if turning.is_zero(order) {
            return None;
        }
        if let Some(exact) = turning.exact_ratio(order, self.reference) {
            let exact = exact.abs();
            let value = exact.to_f64();
            return Some((Some(exact), value));
        }
        let value =
            (factor * (self.unit[member.turning] - carrier.map_or(0.0, |c| self.unit[c]))).abs();
        // The speeds are of a machine whose reference turns at 1 rad/s: below this is rounding of a member at rest.
        (value > 1e-12 * factor).then_some((None, value))
    }
}

/// Kinematic constraints between speeds: rigid and elastic joints alike, short rows first. One unknown is left over at the end. As in
/// [`mean_speeds`], torsional supports hold about the mean turn where with them nothing, or not what is said to turn, could turn.
fn joint_constraints(machine: &Machine, unknowns: usize) -> ExactConstraints {
    let all = constraints_of(machine, unknowns, |_| true);
    let held = |&(dof, speed): &(usize, f64)| speed != 0.0 && all.is_zero(dof);
    if (0..machine.dofs.len()).any(|dof| !all.is_zero(dof)) && !machine.speeds.iter().any(held) {
        return all;
    }
    constraints_of(machine, unknowns, |branch| {
        !supports_turning(machine, branch)
    })
}

fn constraints_of(
    machine: &Machine,
    unknowns: usize,
    counts: impl Fn(&Branch) -> bool,
) -> ExactConstraints {
    let mut turning = ExactConstraints::new(unknowns);
    let mut rows: Vec<&[(usize, f64)]> = machine
        .branches
        .iter()
        .filter(|branch| match branch.law {
            BranchLaw::Linear { stiffness, .. } => stiffness != 0.0,
            BranchLaw::Rigid => true,
        })
        .filter(|branch| counts(branch))
        .map(|branch| branch.direction.terms.as_slice())
        .collect();
    rows.sort_by_key(|row| row.len());
    for row in rows {
        turning.impose(row);
    }
    turning
}

/// The joints, and the stated speeds beyond the first as ratios to it.
pub fn speed_constraints(machine: &Machine, reference: usize) -> ExactConstraints {
    let mut turning = joint_constraints(machine, machine.dofs.len() + 1);
    let base = machine.speeds.first().map_or(0.0, |stated| stated.1);
    for &(dof, speed) in machine.speeds.iter().skip(1) {
        if speed == 0.0 {
            turning.impose(&[(dof, 1.0)]);
        } else if let Some((top, bottom)) = simple_fraction(speed / base) {
            turning.impose(&[(dof, bottom), (reference, -top)]);
        }
    }
    turning
}

/// The fraction a ratio of speeds in round numbers was meant to be, by continued fractions.
fn simple_fraction(x: f64) -> Option<(f64, f64)> {
    const SAME: f64 = 1e-13; // relative: a few roundings of rpm to rad/s
    const LARGEST: f64 = 1e6; // of a denominator: speeds have six figures at most
    let (mut top, mut bottom) = ([1.0, x.floor()], [0.0, 1.0]);
    let mut rest = x - x.floor();
    while (top[1] / bottom[1] - x).abs() > SAME * x.abs() {
        let whole = (1.0 / rest).floor();
        rest = 1.0 / rest - whole;
        top = [top[1], whole * top[1] + top[0]];
        bottom = [bottom[1], whole * bottom[1] + bottom[0]];
        if bottom[1].is_nan() || bottom[1] > LARGEST {
            return None;
        }
    }
    top[1].is_finite().then_some((top[1], bottom[1]))
}
