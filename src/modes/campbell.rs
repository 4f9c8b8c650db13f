//! Campbell diagram: natural frequencies over speed, tracked by MAC, and their order crossings.
//!
//! W. Campbell, Protection of steam-turbine disk wheels from axial vibration, Trans. ASME 46 (1924), 31–160.

use std::f64::consts::TAU;

use super::crossings::{distance_to_order, find_crossing, participation};
use super::excitation_orders::{ExcitationOrder, OrderOptions, excitation_orders, reference_dof};
use super::modal_basis::ModalBasis;
use super::mode::Mode;
use super::tracking::{ModeMatching, ModeSet, ModeTracker, TrackingOptions};
use super::whirl::{Whirl, WhirlNodes};
use super::{damped, modal_matrices};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::machine::components::Machine;
use crate::machine::kinematics::{Kinematics, mean_speeds};
use crate::machine::linear::LinearModel;
use crate::machine::spin::spin_speeds;
use crate::numeric::sorting::sort_ascending;

/// Natural frequencies over reference speed, with order lines and their crossings.
#[derive(Debug, Clone)]
pub struct CampbellDiagram {
    /// Name of the node whose speed is the reference speed.
    pub reference: String,
    /// Reference speeds of the diagram, rpm.
    pub speeds_rpm: Vec<f64>,
    /// Branches of every mode that is oscillatory at some of the speeds.
    pub branches: Vec<CampbellBranch>,
    /// Excitation orders of the order lines.
    pub orders: Vec<ExcitationOrder>,
    /// Crossings of order lines with branches, in order of increasing speed.
    pub crossings: Vec<OrderCrossing>,
    /// Whether all natural frequencies are independent of speed, so that the modes are solved once.
    pub is_constant: bool,
    /// Number of modal solutions, including those for smaller speed steps and crossings.
    pub n_solves: usize,
}

/// A mode tracked over the speeds of the diagram; `None` at speeds where it is not oscillatory.
#[derive(Debug, Clone, Default)]
pub struct CampbellBranch {
    /// `|λ|/2π`, Hz.
    pub frequency_hz: Vec<Option<f64>>,
    /// ζ; `None` where there is no damping.
    pub damping_ratio: Vec<Option<f64>>,
    /// Sense of whirl; `None` for torsional modes and in a diagram independent of speed.
    pub whirl: Vec<Option<Whirl>>,
    /// Speeds, rpm, at which the mode match from the previous speed is uncertain even with the smallest step.
    pub uncertain_rpm: Vec<f64>,
}

/// Intersection of an order line with a branch.
#[derive(Debug, Clone, PartialEq)]
pub struct OrderCrossing {
    /// Reference speed at the crossing, rpm.
    pub speed_rpm: f64,
    /// Natural frequency at the crossing, Hz.
    pub frequency_hz: f64,
    /// Index of the order.
    pub order: usize,
    /// Index of the branch.
    pub branch: usize,
    /// Participation of the mode in the order, 0 to 1; see [`participation`].
    pub participation: f64,
}

/// Speeds, orders and tracking of a Campbell diagram.
#[derive(Debug, Clone)]
pub struct CampbellOptions {
    /// Reference speeds, rad/s, strictly monotonic.
    pub speeds: Vec<f64>,
    /// Include damping.
    pub damped: bool,
    /// Requested orders.
    pub orders: OrderOptions,
    /// Options of mode tracking.
    pub tracking: TrackingOptions,
}

/// Solves the modes at each speed, tracks them, and locates the crossings with the orders.
///
/// # Errors
/// No speed, or speeds that are not monotonic; no rotating node; errors of the solver.
pub fn campbell_diagram(
    machine: &Machine,
    kinematics: &Kinematics,
    model: &LinearModel,
    basis: &ModalBasis,
    options: &CampbellOptions,
) -> Result<CampbellDiagram, Error> {
    check_speeds(&options.speeds)?;
    let spins = SpeedRatios::new(machine, kinematics)?;
    let solve = |speed: f64| {
        let speeds = spins.speeds_at(speed);
        let modal = modal_matrices::project(machine, model, basis, Some(&speeds), options.damped);
        damped::modes(model, basis, &modal)
    };
    let orders = excitation_orders(machine, kinematics, &options.orders)?;
    let tracker = ModeTracker::new(model, options.tracking, solve);
    let mut builder = DiagramBuilder {
        machine,
        model,
        spins: &spins,
        lateral: WhirlNodes::new(machine),
        orders: &orders,
        branches: Vec::new(),
        branch_of_mode: Vec::new(),
        crossings: Vec::new(),
        n_speeds: 0,
    };
    let is_constant = spins.is_speed_independent(machine);
    if is_constant {
        builder.repeat_modes(&tracker, &options.speeds)?;
    } else {
        builder.track_branches(&tracker, &options.speeds)?;
    }
    let DiagramBuilder {
        branches,
        mut crossings,
        ..
    } = builder;
    sort_ascending(&mut crossings, |a| a.speed_rpm);
    Ok(CampbellDiagram {
        reference: machine.nodes[machine.dofs[spins.reference].node]
            .name
            .clone(),
        speeds_rpm: options.speeds.iter().map(|&speed| rpm(speed)).collect(),
        branches,
        orders,
        crossings,
        is_constant,
        n_solves: tracker.solves(),
    })
}

fn check_speeds(speeds: &[f64]) -> Result<(), Error> {
    let is_monotonic = speeds.windows(2).all(|pair| pair[0] < pair[1])
        || speeds.windows(2).all(|pair| pair[0] > pair[1]);
    if speeds.is_empty() || !is_monotonic || speeds.iter().any(|speed| !speed.is_finite()) {
        let message = "a Campbell diagram needs at least one speed, in rising or falling order";
        return Err(Error::new(Code::OutOfRange, message)
            .with_hint("state them as first:last:points, such as 0:3000:61"));
    }
    Ok(())
}

fn rpm(speed: f64) -> f64 {
    speed * 60.0 / TAU
}

/// Mean speed of every degree of freedom as a linear function of the reference speed.
struct SpeedRatios {
    reference: usize,
    at_rest: Vec<f64>,
    per_unit: Vec<f64>,
}

impl SpeedRatios {
    fn new(machine: &Machine, kinematics: &Kinematics) -> Result<SpeedRatios, Error> {
        let at_rest = mean_speeds(machine, kinematics, Some(0.0))?;
        let at_one = spin_speeds(machine, kinematics, Some(1.0))?;
        let per_unit = at_one
            .iter()
            .zip(&at_rest)
            .map(|(one, rest)| one - rest)
            .collect();
        Ok(SpeedRatios {
            reference: reference_dof(machine)?,
            at_rest,
            per_unit,
        })
    }

    fn speeds_at(&self, speed: f64) -> Vec<f64> {
        self.at_rest
            .iter()
            .zip(&self.per_unit)
            .map(|(rest, slope)| rest + slope * speed)
            .collect()
    }

    /// Whether no gyroscopic or centripetal term varies with the reference speed.
    fn is_speed_independent(&self, machine: &Machine) -> bool {
        machine
            .gyroscopic
            .iter()
            .all(|spin| self.per_unit[spin.spin_dof] == 0.0)
    }
}

/// Number of speeds solved in parallel before mode matching; it bounds memory.
const SPEEDS_PER_BATCH: usize = 32;

struct DiagramBuilder<'a> {
    machine: &'a Machine,
    model: &'a LinearModel,
    spins: &'a SpeedRatios,
    lateral: WhirlNodes,
    orders: &'a [ExcitationOrder],
    branches: Vec<CampbellBranch>,
    /// Branch index of each mode at the latest speed.
    branch_of_mode: Vec<usize>,
    crossings: Vec<OrderCrossing>,
    /// Number of speeds in the branches.
    n_speeds: usize,
}

impl DiagramBuilder<'_> {
    fn track_branches<F>(&mut self, tracker: &ModeTracker<F>, speeds: &[f64]) -> Result<(), Error>
    where
        F: Fn(f64) -> Result<Vec<Mode>, Error> + Sync,
    {
        let mut modes = tracker.start(speeds[0], speeds.get(1).copied().unwrap_or(speeds[0]))?;
        self.add_speed(&modes, vec![None; modes.modes.len()]);
        for batch in speeds[1..].chunks(SPEEDS_PER_BATCH) {
            for next in tracker.mode_sets(batch)? {
                let (next, matching) = tracker.follow_to(&modes, next)?;
                self.add_crossings(tracker, &modes, &next, &matching)?;
                self.extend_branches(&next, &matching);
                modes = next;
            }
        }
        Ok(())
    }

    /// Repeats the modes of one solution at all speeds; order lines cross them at `|λ| / order`.
    fn repeat_modes<F>(&mut self, tracker: &ModeTracker<F>, speeds: &[f64]) -> Result<(), Error>
    where
        F: Fn(f64) -> Result<Vec<Mode>, Error>,
    {
        let modes = tracker.start(speeds[0], speeds[0])?;
        for tracked in &modes.modes {
            let (mode, branch) = (&tracked.mode, self.branches.len());
            self.branches.push(CampbellBranch {
                frequency_hz: vec![Some(mode.frequency_hz()); speeds.len()],
                damping_ratio: vec![mode.damping_ratio; speeds.len()],
                whirl: vec![None; speeds.len()],
                uncertain_rpm: Vec::new(),
            });
            let (first, last) = (speeds[0], speeds[speeds.len() - 1]);
            for (number, order) in self.orders.iter().enumerate() {
                let speed = mode.omega() / order.value;
                for speed in [-speed, speed] {
                    if (first.min(last)..=first.max(last)).contains(&speed) {
                        self.add_crossing(number, branch, speed, mode);
                    }
                }
            }
        }
        Ok(())
    }

    /// Appends one speed to every branch; modes without a branch start a new one.
    fn add_speed(&mut self, snapshot: &ModeSet, branches: Vec<Option<usize>>) {
        let speeds = self.spins.speeds_at(snapshot.speed);
        for branch in &mut self.branches {
            branch.frequency_hz.push(None);
            branch.damping_ratio.push(None);
            branch.whirl.push(None);
        }
        self.branch_of_mode = Vec::with_capacity(branches.len());
        for (tracked, branch) in snapshot.modes.iter().zip(branches) {
            let index = branch.unwrap_or_else(|| {
                let n_speeds = self.n_speeds + 1;
                self.branches.push(CampbellBranch {
                    frequency_hz: vec![None; n_speeds],
                    damping_ratio: vec![None; n_speeds],
                    whirl: vec![None; n_speeds],
                    uncertain_rpm: Vec::new(),
                });
                self.branches.len() - 1
            });
            let mode = &tracked.mode;
            let whirl = self.lateral.whirl(
                &mode.shape,
                &speeds,
                &self.spins.per_unit,
                self.spins.reference,
            );
            let branch = &mut self.branches[index];
            branch.frequency_hz[self.n_speeds] = Some(mode.frequency_hz());
            branch.damping_ratio[self.n_speeds] = mode.damping_ratio;
            branch.whirl[self.n_speeds] = whirl;
            self.branch_of_mode.push(index);
        }
        self.n_speeds += 1;
    }

    fn extend_branches(&mut self, next: &ModeSet, matching: &ModeMatching) {
        let mut branches = vec![None; next.modes.len()];
        for (mode, &branch) in self.branch_of_mode.iter().enumerate() {
            if let Some(to) = matching.to[mode] {
                branches[to] = Some(branch);
            }
            if matching.uncertain[mode] {
                self.branches[branch].uncertain_rpm.push(rpm(next.speed));
            }
        }
        self.add_speed(next, branches);
    }

    fn add_crossings<F>(
        &mut self,
        tracker: &ModeTracker<F>,
        previous: &ModeSet,
        next: &ModeSet,
        matching: &ModeMatching,
    ) -> Result<(), Error>
    where
        F: Fn(f64) -> Result<Vec<Mode>, Error>,
    {
        for (from, to) in matching.to.iter().enumerate() {
            let Some(to) = *to else { continue };
            for (number, order) in self.orders.iter().enumerate() {
                let is_below = [(previous, from), (next, to)]
                    .map(|(at, i)| distance_to_order(&at.modes[i].mode, order, at.speed) < 0.0);
                if is_below[0] == is_below[1] {
                    continue;
                }
                if let Some(at) = find_crossing(tracker, order, (previous, from), (next, to))? {
                    self.add_crossing(number, self.branch_of_mode[from], at.speed, &at.mode);
                }
            }
        }
        Ok(())
    }

    fn add_crossing(&mut self, order: usize, branch: usize, speed: f64, mode: &Mode) {
        let participation = participation(self.machine, self.model, mode, &self.orders[order]);
        let frequency_hz = mode.frequency_hz();
        self.crossings.push(OrderCrossing {
            speed_rpm: rpm(speed),
            frequency_hz,
            order,
            branch,
            participation,
        });
    }
}
