//! From a machine and its scene to a machine in motion.

use std::f64::consts::TAU;

use super::contact::{Contact, Flanks, Losses};
use super::curve::Curve;
use super::cutting;
use super::outputs::Combination;
use super::signal::{Knot, Signal};
use super::train::{Branch, Drive, Law, Mass, Train};
use super::wave::{Phase, Shape, Wave};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::machine::direction::Direction;
use crate::machine::kinematics::Kinematics;
use crate::machine::linear::{Linear, LinearBranch};
use crate::machine::operating::Operating;
use crate::machine::parts::{self, Machine};
use crate::modes::basis::{self, Solver};
use crate::modes::equations::{Case, Equations};
use crate::numeric::{Matrix, definite};
use crate::scene::laws::{self, History, PhaseOf};

/// A machine in motion, and how its freedoms follow from its coordinates.
pub struct Moving {
    /// The equations.
    pub train: Train,
    /// Of every freedom of the machine.
    pub freedoms: Vec<Combination>,
    /// The branches of the machine's each branch, in the train: one, or one a flank; none where it is rigid.
    pub branches: Vec<Vec<usize>>,
    /// Coordinates whose motion is prescribed, with their speeds over time.
    pub prescribed: Vec<(usize, Vec<(f64, f64)>)>,
}

/// What all parts of the assembly look at.
struct Site<'a> {
    machine: &'a Machine,
    kinematics: &'a Kinematics,
    linear: Linear,
    /// Mean speed of every freedom, rad/s, where the file states any.
    speeds: Option<&'a [f64]>,
    phase: PhaseOf,
}

/// Assembles a machine for integration in time; `speeds` are the mean speeds of all freedoms, rad/s, where any are known.
///
/// # Errors
/// What has no motion in time: loss factors, freedoms without inertia, contacts with play and damping of which nobody says what
/// the damper does when they open; waves or cutters at speeds nobody states.
pub fn assemble(
    machine: &Machine,
    kinematics: &Kinematics,
    phase: PhaseOf,
    speeds: Option<&[f64]>,
) -> Result<Moving, Error> {
    let linear = Linear::new(machine, kinematics, &Operating::default())?;
    refuse(machine, &linear)?;
    let site = Site {
        machine,
        kinematics,
        linear,
        speeds,
        phase,
    };
    let coordinates = site
        .linear
        .free
        .iter()
        .map(|&i| machine.freedom_name(i))
        .collect();
    let mass = site.mass()?;
    let general = site.general()?;
    let (mut branches, mut of) = (Vec::new(), vec![Vec::new(); machine.branches.len()]);
    for lb in &site.linear.branches {
        for branch in site.branch(lb)? {
            of[lb.index].push(branches.len());
            branches.push(branch);
        }
    }
    branches.extend(site.brakes());
    let mut drives = site.loads()?;
    let mut prescribed = Vec::new();
    for motor in &machine.motors {
        let name = machine.elements[motor.element].name.clone();
        let direction = site.row(motor.freedom);
        match &motor.drive {
            laws::Drive::Curve { curve, lag } => {
                branches.push(motor_branch(name, direction, curve, *lag))
            }
            laws::Drive::Speed(points) => {
                let at = site.prescribe(motor, &mass)?;
                drives.retain(|d| !d.direction.terms.iter().any(|t| t.0 == at));
                drives.push(accelerating(name, at, &mass, points));
                branches.iter_mut().for_each(|b| release(b, at));
                prescribed.push((at, points.clone()));
            }
        }
    }
    let train = Train {
        coordinates,
        mass,
        branches,
        drives,
        drag: machine.damping.mass,
        general,
    };
    let freedoms = site.linear.transform.iter().map(|terms| Combination {
        terms: terms.clone(),
        imposed: None,
    });
    Ok(Moving {
        freedoms: freedoms.collect(),
        train,
        branches: of,
        prescribed,
    })
}

/// Says what has no motion in time.
fn refuse(machine: &Machine, linear: &Linear) -> Result<(), Error> {
    if let Some(lb) = linear.branches.iter().find(|b| b.loss_factor != 0.0) {
        let element = &machine.elements[machine.branches[lb.index].element];
        let message = format!(
            "the loss factor of `{}` is defined in frequency only",
            element.name
        );
        let hint = "give it `c` or `damping_ratio` for motion in time";
        return Err(Error::new(Code::Conflict, message)
            .at(&element.place)
            .hint(hint));
    }
    for (at, motor) in machine.motors.iter().enumerate() {
        let other = machine.motors[..at]
            .iter()
            .find(|m| m.freedom == motor.freedom);
        let is_speed = |m: &parts::Motor| matches!(m.drive, laws::Drive::Speed(_));
        if let Some(other) = other.filter(|m| is_speed(m) || is_speed(motor)) {
            let (one, two) = (
                &machine.elements[other.element],
                &machine.elements[motor.element],
            );
            let message = format!(
                "`{}` and `{}` both drive {}, and one of them prescribes its speed",
                one.name,
                two.name,
                machine.freedom_name(motor.freedom)
            );
            return Err(Error::new(Code::Conflict, message)
                .at(&two.place)
                .hint("leave one of them out"));
        }
    }
    if let Some(&j) = linear.massless.first() {
        let freedom = linear.free[j];
        let element = machine.nodes[machine.freedoms[freedom].node].element;
        let message = format!(
            "{} has no inertia, and motion in time needs one",
            machine.freedom_name(freedom)
        );
        let hint = "give the node its inertia, however small: the exact methods do not mind; or join the two springs into one";
        return Err(Error::new(Code::Conflict, message)
            .at(&machine.elements[element].place)
            .hint(hint));
    }
    Ok(())
}

impl Site<'_> {
    /// A freedom over the coordinates that stay.
    fn row(&self, freedom: usize) -> Direction {
        Direction::new(1.0, self.linear.transform[freedom].iter().copied())
    }

    fn mass(&self) -> Result<Mass, Error> {
        if let Some(diagonal) = self.linear.mass_diagonal() {
            return Ok(Mass::Diagonal(diagonal));
        }
        let n = self.linear.n;
        let mut matrix = Matrix::zeros(n, n);
        for mass in &self.linear.masses {
            for (i, a) in mass.direction.scaled() {
                for (j, b) in mass.direction.scaled() {
                    matrix[(i, j)] += mass.value * a * b;
                }
            }
        }
        definite::cholesky(&matrix)?;
        let inverse = definite::solve(&matrix, &Matrix::identity(n, n))?;
        Ok(Mass::Full { matrix, inverse })
    }

    /// K₀ and C₀: gyroscopic and centrifugal terms at the mean speeds, modal damping.
    fn general(&self) -> Result<Option<(Matrix, Matrix)>, Error> {
        let modal = self.machine.damping.modal.iter().any(|&zeta| zeta != 0.0);
        if !modal && (self.machine.spins.is_empty() || self.speeds.is_none()) {
            return Ok(None);
        }
        let basis = basis::solve(&self.linear, Solver::Factored)?;
        let mut bare = self.machine.clone();
        (bare.damping.mass, bare.damping.stiffness) = (0.0, 0.0);
        let mut linear = self.linear.clone();
        linear.branches.clear();
        let case = Case {
            machine: &bare,
            linear: &linear,
            basis: &basis,
            speeds: self.speeds,
        };
        let n = linear.n;
        let equations = Equations::over(&case, Matrix::identity(n, n), Vec::new(), 0);
        Ok(Some((equations.stiffness, equations.damping)))
    }

    /// A branch of the machine, or one for each flank where these push in different directions.
    fn branch(&self, lb: &LinearBranch) -> Result<Vec<Branch>, Error> {
        let part = &self.machine.branches[lb.index];
        let damping = lb.damping + self.machine.damping.stiffness * lb.stiffness;
        let variation = match &part.wave {
            None => None,
            Some(wave) => Some(self.wave(lb.index, wave.shape.clone(), wave.lead)?),
        };
        let errors = [self.errors(lb.index, 0)?, self.errors(lb.index, 1)?];
        let make = |direction: Direction, law: Law, flank: usize| {
            let (imposed, followed) = errors[flank].clone();
            Branch {
                name: self.machine.branch_name(lb.index),
                direction,
                force: lb.force.clone(),
                law,
                variation: variation.clone(),
                imposed,
                followed,
            }
        };
        let reduce = |d: &Direction| Direction {
            scale: d.scale,
            terms: self.kinematics.reduced(&d.terms),
        };
        if let Some(characteristic) = part.characteristic.clone() {
            let law = Law::Nonlinear {
                characteristic,
                damping,
            };
            return Ok(vec![make(lb.direction.clone(), law, 0)]);
        }
        if part.play == 0.0 && part.wave.is_none() {
            let law = Law::Linear {
                stiffness: lb.stiffness,
                damping,
            };
            return Ok(vec![make(lb.direction.clone(), law, 0)]);
        }
        let losses = self.losses(part, damping)?;
        let contact = |flanks: Flanks| {
            Law::Contact(Contact {
                stiffness: lb.stiffness,
                damping,
                half: part.play / 2.0,
                losses,
                flanks,
            })
        };
        Ok(match &part.coast {
            Some(coast) if part.play > 0.0 => {
                vec![
                    make(lb.direction.clone(), contact(Flanks::Drive), 0),
                    make(reduce(coast), contact(Flanks::Coast), 1),
                ]
            }
            _ => vec![make(lb.direction.clone(), contact(Flanks::Both), 0)],
        })
    }

    /// What the damper of a contact does where it opens; nobody may guess.
    fn losses(&self, part: &parts::Branch, damping: f64) -> Result<Losses, Error> {
        let stated = part.losses.or(self.machine.damping.contacts);
        if part.play == 0.0 || damping == 0.0 {
            return Ok(stated.unwrap_or(Losses::Adhesive));
        }
        stated.ok_or_else(|| {
            let element = &self.machine.elements[part.element];
            let message = format!("`{}` has play and damping, and nothing says what its damper does when it opens", element.name);
            let hint = "write contact_damping = \"no-pull\" (or \"continuous\", \"adhesive\", \"throughout\") in it, or contacts = … in [damping] for all";
            Error::new(Code::MissingKey, message).at(&element.place).hint(hint)
        })
    }

    /// The wave of a mesh over its cycle: with the gear that has most teeth to count by.
    fn wave(&self, branch: usize, shape: Shape, lead: f64) -> Result<Wave, Error> {
        let gear = self
            .machine
            .gears
            .iter()
            .find(|g| g.branches.contains(&branch) && g.teeth.is_some());
        let Some(gear) = gear else {
            let element = &self.machine.elements[self.machine.branches[branch].element];
            let message = format!(
                "`{}` has a stiffness wave and no teeth to count its cycle by",
                element.name
            );
            return Err(Error::new(Code::Conflict, message)
                .at(&element.place)
                .hint("waves belong to toothed pairs"));
        };
        let teeth = f64::from(gear.teeth.unwrap_or(1));
        self.turning(shape, gear.turning, gear.carrier, teeth, lead)
    }

    /// A wave that passes `cycles` times a turn of a freedom against its carrier.
    fn turning(
        &self,
        shape: Shape,
        freedom: usize,
        carrier: Option<usize>,
        cycles: f64,
        lead: f64,
    ) -> Result<Wave, Error> {
        if self.phase == PhaseOf::Angle {
            let own = self.linear.transform[freedom].iter().copied();
            let carried = carrier.map(|c| self.linear.transform[c].iter().map(|&(j, a)| (j, -a)));
            let angle = Direction::new(cycles, own.chain(carried.into_iter().flatten()));
            return Ok(Wave {
                shape,
                phase: Phase::Followed { angle, start: lead },
            });
        }
        let omega = cycles * (self.speed(freedom)? - carrier.map_or(Ok(0.0), |c| self.speed(c))?);
        Ok(forward(shape, omega, lead))
    }

    fn speed(&self, freedom: usize) -> Result<f64, Error> {
        self.speeds.as_ref().map(|s| s[freedom]).ok_or_else(|| {
            let message = format!(
                "the speed of {} is needed, and no speed is stated",
                self.machine.freedom_name(freedom)
            );
            Error::new(Code::NoSpeed, message)
                .hint("state the speed of a node in [speed] of the model")
        })
    }

    /// e of a flank of a branch (0 drive, 1 coast): its harmonics where the speed is imposed, else waves that follow the angle.
    fn errors(&self, branch: usize, flank: usize) -> Result<(Option<Signal>, Option<Wave>), Error> {
        let (mut imposed, mut followed): (Option<Signal>, Option<Wave>) = (None, None);
        let acting = self.machine.errors.iter().flat_map(|error| {
            let here = error.acts.iter().filter(|act| act.branch == branch);
            here.map(move |act| (error, act.flanks[flank]))
        });
        for (error, reach) in acting {
            let pace = error.pace.0 as f64 / error.pace.1 as f64;
            let wave = self.turning(
                error.shape.times(-reach.gain),
                error.turning,
                error.carrier,
                pace,
                reach.turn,
            )?;
            match (&wave.phase, followed.is_some()) {
                (Phase::Imposed { omega, start }, _) => {
                    let signal = over_time(&wave.shape, *omega, *start);
                    imposed = Some(imposed.map_or(signal.clone(), |s| s.plus(&signal)));
                }
                (Phase::Followed { .. }, false) => followed = Some(wave),
                (Phase::Followed { .. }, true) => {
                    let element = &self.machine.elements[self.machine.branches[branch].element];
                    let message =
                        format!("`{}` has several errors that follow angles", element.name);
                    let hint = "write mesh_phase = \"speed\" in [start], so that they are imposed in time, or put them into one table of `values`";
                    return Err(Error::new(Code::Conflict, message)
                        .at(&element.place)
                        .hint(hint));
                }
            }
        }
        Ok((imposed, followed))
    }

    fn brakes(&self) -> Vec<Branch> {
        let brake = |brake: &parts::Brake| {
            let direction = Direction {
                scale: brake.direction.scale,
                terms: self.kinematics.reduced(&brake.direction.terms),
            };
            plain(
                self.machine.elements[brake.element].name.clone(),
                direction,
                Law::Friction(brake.friction),
            )
        };
        self.machine.brakes.iter().map(brake).collect()
    }

    /// Loads as drives; orders turn at the mean speed.
    fn loads(&self) -> Result<Vec<Drive>, Error> {
        let mut drives = Vec::new();
        // A motor takes the place of the constant torque that stood for it.
        let motors: Vec<usize> = self.machine.motors.iter().map(|m| m.freedom).collect();
        for (freedom, history) in &self.machine.histories {
            if matches!(history, History::Constant(_)) && motors.contains(freedom) {
                continue;
            }
            let name = format!("load on {}", self.machine.freedom_name(*freedom));
            let signal = match history {
                History::Constant(torque) => Signal::constant(*torque),
                History::Step { torque, time } => Signal::step(*torque, *time),
                History::Ramp { from, to, between } => Signal::ramp(*from, *to, *between),
                History::Harmonic {
                    mean,
                    amplitude,
                    omega,
                    phase,
                } => Signal::constant(*mean).plus(&Signal::harmonic(*amplitude, *omega, *phase)),
                History::Orders { mean, orders } => {
                    let omega = self.speed(*freedom)?;
                    orders
                        .iter()
                        .fold(Signal::constant(*mean), |sum, &(n, a, phase)| {
                            sum.plus(&Signal::harmonic(a, n * omega, phase))
                        })
                }
                History::Table(points) => Signal::table(points)?,
                History::FaceMill(mill) => cutting::torque(mill, self.speed(*freedom)?)?,
            };
            drives.push(Drive {
                name,
                direction: self.row(*freedom),
                signal,
            });
        }
        Ok(drives)
    }

    /// The coordinate that a motor of given speed moves.
    fn prescribe(&self, motor: &parts::Motor, mass: &Mass) -> Result<usize, Error> {
        let terms = &self.linear.transform[motor.freedom];
        let element = &self.machine.elements[motor.element];
        if let ([(j, a)], Mass::Diagonal(_)) = (&terms[..], mass)
            && *a == 1.0
        {
            return Ok(*j);
        }
        let message = format!(
            "the speed of `{}` cannot be prescribed: rigid joints tie it to others",
            element.name
        );
        let hint =
            "put the motor on the body that others are joined to, or give one of the joints its k";
        Err(Error::new(Code::Conflict, message)
            .at(&element.place)
            .hint(hint))
    }
}

fn plain(name: String, direction: Direction, law: Law) -> Branch {
    Branch {
        name,
        direction,
        force: None,
        law,
        variation: None,
        imposed: None,
        followed: None,
    }
}

fn motor_branch(name: String, direction: Direction, curve: &Curve, lag: f64) -> Branch {
    let law = match lag {
        0.0 => Law::Curve(curve.clone()),
        lag => Law::Lagged {
            curve: curve.clone(),
            lag,
        },
    };
    plain(name, direction, law)
}

/// What moves a coordinate as prescribed: its inertia times the acceleration, while nothing else acts on it.
fn accelerating(name: String, at: usize, mass: &Mass, points: &[(f64, f64)]) -> Drive {
    let inertia = match mass {
        Mass::Diagonal(mass) => mass[at],
        Mass::Full { matrix, .. } => matrix[(at, at)],
    };
    let mut knots = Vec::new();
    for pair in points.windows(2).filter(|p| p[1].0 > p[0].0) {
        let ((t, a), (u, b)) = (pair[0], pair[1]);
        knots.push(Knot {
            time: t,
            value: inertia * (b - a) / (u - t),
            slope: 0.0,
        });
    }
    knots.extend(points.last().map(|p| Knot {
        time: p.0,
        value: 0.0,
        slope: 0.0,
    }));
    Drive {
        name,
        direction: Direction::of(at),
        signal: Signal {
            knots,
            harmonics: Vec::new(),
        },
    }
}

/// Keeps a branch from acting on a coordinate that moves as prescribed.
fn release(branch: &mut Branch, at: usize) {
    let acts = branch.acts();
    if acts.terms.iter().any(|t| t.0 == at) {
        let terms = acts.terms.iter().copied().filter(|t| t.0 != at).collect();
        branch.force = Some(Direction {
            scale: acts.scale,
            terms,
        });
    }
}

/// The wave in the sense of rising phase: run backward, a period is its mirror image.
fn forward(shape: Shape, omega: f64, lead: f64) -> Wave {
    if omega >= 0.0 {
        return Wave {
            shape,
            phase: Phase::Imposed { omega, start: lead },
        };
    }
    let (shape, start) = match shape {
        // High for 0 ≤ ψ < duty backward is high for 0 ≤ ψ + duty < duty forward.
        Shape::Rectangular { duty, .. } => (shape, TAU * duty - lead),
        Shape::Fourier { mean, terms } => {
            let terms = terms
                .into_iter()
                .map(|(n, a, phase)| (n, a, -phase))
                .collect();
            (Shape::Fourier { mean, terms }, -lead)
        }
        Shape::Table(values) => {
            let n = values.len();
            (
                Shape::Table((0..n).map(|i| values[(n - i) % n]).collect()),
                -lead,
            )
        }
    };
    Wave {
        shape,
        phase: Phase::Imposed {
            omega: -omega,
            start,
        },
    }
}

/// A wave at imposed speed as harmonics in time. A table becomes as many as it can tell: the smooth curve through its points.
fn over_time(shape: &Shape, omega: f64, start: f64) -> Signal {
    let mean = Signal::constant(shape.mean());
    shape.harmonics().iter().fold(mean, |sum, &(n, a, phase)| {
        let n = f64::from(n);
        sum.plus(&Signal::harmonic(a, n * omega, n * start + phase))
    })
}
