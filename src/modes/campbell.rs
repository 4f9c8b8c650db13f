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
use crate::machine::spin::spinning;
use crate::numeric::sorting::sort_rising;

/// A Campbell diagram.
#[derive(Debug, Clone)]
pub struct CampbellDiagram {
    /// The node whose speed it is drawn over.
    pub reference: String,
    /// Reference speeds of the diagram, rpm.
    pub speeds_rpm: Vec<f64>,
    /// Branches of every mode that is oscillatory at some of the speeds.
    pub branches: Vec<CampbellBranch>,
    /// Excitation orders drawn over the speeds.
    pub orders: Vec<ExcitationOrder>,
    /// Crossings of orders with branches, by rising speed.
    pub crossings: Vec<OrderCrossing>,
    /// No frequency depends on the speed: the modes were solved once.
    pub is_constant: bool,
    /// Speeds at which modes were solved, those for smaller steps and crossings included.
    pub n_solves: usize,
}

/// A mode tracked over the speeds of the diagram; `None` at speeds where it is not oscillatory.
#[derive(Debug, Clone, Default)]
pub struct CampbellBranch {
    /// `|λ|/2π`, Hz.
    pub frequency_hz: Vec<Option<f64>>,
    /// ζ; `None` where there is no damping.
    pub damping_ratio: Vec<Option<f64>>,
    /// Sense of whirl; `None` for torsional modes and where nothing depends on the speed.
    pub whirl: Vec<Option<Whirl>>,
    /// Speeds, rpm, up to which the mode match stays uncertain even at the smallest step from the speed before.
    pub uncertain_rpm: Vec<f64>,
}

/// An order line meets a branch.
#[derive(Debug, Clone, PartialEq)]
pub struct OrderCrossing {
    /// Reference speed at the crossing, rpm.
    pub speed_rpm: f64,
    /// Hz.
    pub frequency_hz: f64,
    /// Index of the order.
    pub order: usize,
    /// Index of the branch.
    pub branch: usize,
    /// Share of the mode's energy where the order acts, 0 to 1; see [`participation`].
    pub participation: f64,
}

/// Speeds, orders and tracking of a Campbell diagram.
#[derive(Debug, Clone)]
pub struct CampbellOptions {
    /// Speeds of the reference, rad/s, in order.
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
/// No speed, or speeds that do not rise or fall; nothing can turn; those of the solver.
pub fn campbell_diagram(
    machine: &Machine,
    kinematics: &Kinematics,
    model: &LinearModel,
    basis: &ModalBasis,
    options: &CampbellOptions,
) -> Result<CampbellDiagram, Error> {
    check(&options.speeds)?;
    let spins = SpeedRatios::new(machine, kinematics)?;
    let solve = |speed: f64| {
        let speeds = spins.speeds_at(speed);
        let modal = modal_matrices::project(machine, model, basis, Some(&speeds), options.damped);
        damped::modes(model, basis, &modal)
    };
    let orders = excitation_orders(machine, kinematics, &options.orders)?;
    let tracker = ModeTracker::new(model, options.tracking, solve);
    let mut drawing = DiagramBuilder {
        machine,
        model,
        spins: &spins,
        lateral: WhirlNodes::new(machine),
        orders: &orders,
        lines: Vec::new(),
        line_of: Vec::new(),
        crossings: Vec::new(),
        drawn: 0,
    };
    let is_constant = spins.is_speed_independent(machine);
    if is_constant {
        drawing.draw_constant(&tracker, &options.speeds)?;
    } else {
        drawing.draw(&tracker, &options.speeds)?;
    }
    let DiagramBuilder {
        lines: branches,
        mut crossings,
        ..
    } = drawing;
    sort_rising(&mut crossings, |a| a.speed_rpm);
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

fn check(speeds: &[f64]) -> Result<(), Error> {
    let rises = speeds.windows(2).all(|pair| pair[0] < pair[1])
        || speeds.windows(2).all(|pair| pair[0] > pair[1]);
    if speeds.is_empty() || !rises || speeds.iter().any(|speed| !speed.is_finite()) {
        let message = "a Campbell diagram needs at least one speed, and all rising or all falling";
        return Err(Error::new(Code::OutOfRange, message)
            .with_hint("state them as first:last:points, such as 0:3000:61"));
    }
    Ok(())
}

fn rpm(speed: f64) -> f64 {
    speed * 60.0 / TAU
}

/// Mean speed of every degree of freedom over that of the reference: a straight line.
struct SpeedRatios {
    reference: usize,
    at_rest: Vec<f64>,
    per_unit: Vec<f64>,
}

impl SpeedRatios {
    fn new(machine: &Machine, kinematics: &Kinematics) -> Result<SpeedRatios, Error> {
        let at_rest = mean_speeds(machine, kinematics, Some(0.0))?;
        let at_one = spinning(machine, kinematics, Some(1.0))?;
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

    /// Nothing tilts, or is described in a frame that turns, at a speed that varies with the reference's.
    fn is_speed_independent(&self, machine: &Machine) -> bool {
        machine
            .gyroscopic
            .iter()
            .all(|spin| self.per_unit[spin.turning] == 0.0)
    }
}

/// Speeds whose modes are solved before they are matched: a bound on memory, and enough for several threads.
const SPEEDS_AHEAD: usize = 32;

struct DiagramBuilder<'a> {
    machine: &'a Machine,
    model: &'a LinearModel,
    spins: &'a SpeedRatios,
    lateral: WhirlNodes,
    orders: &'a [ExcitationOrder],
    lines: Vec<CampbellBranch>,
    /// Branch number of each mode of the last speed.
    line_of: Vec<usize>,
    crossings: Vec<OrderCrossing>,
    /// Speeds drawn so far.
    drawn: usize,
}

impl DiagramBuilder<'_> {
    fn draw<F>(&mut self, tracker: &ModeTracker<F>, speeds: &[f64]) -> Result<(), Error>
    where
        F: Fn(f64) -> Result<Vec<Mode>, Error> + Sync,
    {
        let mut here = tracker.start(speeds[0], speeds.get(1).copied().unwrap_or(speeds[0]))?;
        self.add(&here, vec![None; here.modes.len()]);
        for ahead in speeds[1..].chunks(SPEEDS_AHEAD) {
            for next in tracker.mode_sets(ahead)? {
                let (next, link) = tracker.follow_to(&here, next)?;
                self.cross(tracker, &here, &next, &link)?;
                self.advance(&next, &link);
                here = next;
            }
        }
        Ok(())
    }

    /// One solution holds at every speed; order lines meet it at `|λ| / order`.
    fn draw_constant<F>(&mut self, tracker: &ModeTracker<F>, speeds: &[f64]) -> Result<(), Error>
    where
        F: Fn(f64) -> Result<Vec<Mode>, Error>,
    {
        let modes = tracker.start(speeds[0], speeds[0])?;
        for followed in &modes.modes {
            let (mode, branch) = (&followed.mode, self.lines.len());
            self.lines.push(CampbellBranch {
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
                        self.note(number, branch, speed, mode);
                    }
                }
            }
        }
        Ok(())
    }

    /// Puts one speed on every line; modes without a line get a new one.
    fn add(&mut self, snapshot: &ModeSet, lines: Vec<Option<usize>>) {
        let speeds = self.spins.speeds_at(snapshot.speed);
        for line in &mut self.lines {
            line.frequency_hz.push(None);
            line.damping_ratio.push(None);
            line.whirl.push(None);
        }
        self.line_of = Vec::with_capacity(lines.len());
        for (followed, line) in snapshot.modes.iter().zip(lines) {
            let number = line.unwrap_or_else(|| {
                let absent = self.drawn + 1;
                self.lines.push(CampbellBranch {
                    frequency_hz: vec![None; absent],
                    damping_ratio: vec![None; absent],
                    whirl: vec![None; absent],
                    uncertain_rpm: Vec::new(),
                });
                self.lines.len() - 1
            });
            let mode = &followed.mode;
            let whirl = self.lateral.whirl(
                &mode.shape,
                &speeds,
                &self.spins.per_unit,
                self.spins.reference,
            );
            let line = &mut self.lines[number];
            line.frequency_hz[self.drawn] = Some(mode.frequency_hz());
            line.damping_ratio[self.drawn] = mode.damping_ratio;
            line.whirl[self.drawn] = whirl;
            self.line_of.push(number);
        }
        self.drawn += 1;
    }

    fn advance(&mut self, next: &ModeSet, link: &ModeMatching) {
        let mut lines = vec![None; next.modes.len()];
        for (mode, &line) in self.line_of.iter().enumerate() {
            if let Some(now) = link.to[mode] {
                lines[now] = Some(line);
            }
            if link.uncertain[mode] {
                self.lines[line].uncertain_rpm.push(rpm(next.speed));
            }
        }
        self.add(next, lines);
    }

    fn cross<F>(
        &mut self,
        tracker: &ModeTracker<F>,
        here: &ModeSet,
        next: &ModeSet,
        link: &ModeMatching,
    ) -> Result<(), Error>
    where
        F: Fn(f64) -> Result<Vec<Mode>, Error>,
    {
        for (from, to) in link.to.iter().enumerate() {
            let Some(to) = *to else { continue };
            for (number, order) in self.orders.iter().enumerate() {
                let sides = [(here, from), (next, to)]
                    .map(|(at, i)| distance_to_order(&at.modes[i].mode, order, at.speed) < 0.0);
                if sides[0] == sides[1] {
                    continue;
                }
                if let Some(found) = find_crossing(tracker, order, (here, from), (next, to))? {
                    self.note(number, self.line_of[from], found.speed, &found.mode);
                }
            }
        }
        Ok(())
    }

    fn note(&mut self, order: usize, branch: usize, speed: f64, mode: &Mode) {
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
