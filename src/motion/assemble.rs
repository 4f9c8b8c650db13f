//! From a machine and its scene to a machine in motion.

use super::combination::Combination;
use super::contact::{Contact, Flanks, Losses};
use super::curve::Curve;
use super::cutting;
use super::known;
use super::moving::Moving;
use super::rubbing::{self, Pressed};
use super::signal::Signal;
use super::train::{Branch, Drive, Law, Mass, Train};
use super::wave::{Phase, Shape, Wave};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::machine::direction::Direction;
use crate::machine::kinematics::Kinematics;
use crate::machine::linear::{Linear, LinearBranch};
use crate::machine::mesh_cycle;
use crate::machine::operating::Operating;
use crate::machine::parts::{self, Grip, Machine};
use crate::machine::spin::SpinTerms;
use crate::modes::basis::{self, Solver};
use crate::modes::equations::{Case, Equations};
use crate::numeric::Matrix;
use crate::scene::laws::{self, Course, Friction, History, PhaseOf, StartAt};
use crate::scene::start::Start;

/// What all parts of the assembly look at.
struct Site<'a> {
    machine: &'a Machine,
    kinematics: &'a Kinematics,
    linear: Linear,
    /// Mean speed of every freedom, rad/s, where the file states any.
    speeds: Option<&'a [f64]>,
    phase: PhaseOf,
}

/// Assembles a machine for integration in time, as it begins; `speeds` are the mean speeds of all freedoms, rad/s, where any are known.
///
/// # Errors
/// What has no motion in time: loss factors, nodes without inertia at anything but springs and dampers, contacts with play and damping of which nobody says what
/// the damper does when they open; waves or cutters at speeds nobody states.
pub fn assemble(
    machine: &Machine,
    kinematics: &Kinematics,
    begin: &Start,
    speeds: Option<&[f64]>,
) -> Result<Moving, Error> {
    let linear = Linear::new(machine, kinematics, &Operating::default())?;
    refuse(machine, &linear)?;
    let site = Site {
        machine,
        kinematics,
        linear,
        speeds,
        phase: begin.phase,
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
    branches.extend(site.brakes(&of)?);
    branches.extend(site.locked());
    let mut known: Vec<(String, usize, Signal)> = Vec::new();
    for motor in &machine.motors {
        let name = machine.elements[motor.element].name.clone();
        match &motor.drive {
            laws::Drive::Curve { curve, lag } => {
                branches.push(motor_branch(name, site.row(motor.freedom), curve, *lag))
            }
            laws::Drive::Speed(course) => {
                let (at, ratio) = site.prescribe(motor, &known)?;
                known.push((name, at, over_time(course)?.integral().times(ratio)));
            }
            laws::Drive::Angle(course) => {
                let (at, ratio) = site.prescribe(motor, &known)?;
                known.push((name, at, over_time(course)?.times(ratio)));
            }
        }
    }
    let loads = site.loads()?;
    let drives = loads.iter().map(|(freedom, signal)| Drive {
        name: load_on(machine, *freedom),
        direction: site.row(*freedom),
        signal: signal.clone(),
    });
    let drives = drives.chain(site.carried_round(begin.at));
    let train = Train {
        coordinates,
        mass,
        branches,
        drives: drives.collect(),
        drag: machine.damping.mass,
        general,
    };
    let freedoms = site.linear.transform.iter().map(|terms| {
        Some(Combination {
            terms: terms.clone(),
            imposed: None,
        })
    });
    let moving = Moving {
        freedoms: freedoms.collect(),
        kept: (0..train.n()).collect(),
        train,
        springs: vec![None; of.len()],
        loads,
        branches: of,
        rigid: site.linear.rigid.clone(),
        prescribed: None,
    };
    let light = site.linear.massless.iter().copied();
    let light: Vec<usize> = light.filter(|j| known.iter().all(|k| k.1 != *j)).collect();
    moving
        .without_massless(&light, &|j| {
            let node = machine.freedoms[site.linear.free[j]].node;
            machine.elements[machine.nodes[node].element].place.clone()
        })?
        .without_prescribed(known)
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
        let is_speed = |m: &parts::Motor| !matches!(m.drive, laws::Drive::Curve { .. });
        if let Some(other) = other.filter(|m| is_speed(m) || is_speed(motor)) {
            let (one, two) = (
                &machine.elements[other.element],
                &machine.elements[motor.element],
            );
            let message = format!(
                "`{}` and `{}` both drive {}, and one of them prescribes its motion",
                one.name,
                two.name,
                machine.freedom_name(motor.freedom)
            );
            return Err(Error::new(Code::Conflict, message)
                .at(&two.place)
                .hint("leave one of them out"));
        }
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
        Mass::full(matrix)
    }

    /// K₀ and C₀: gyroscopic, centripetal and circulatory terms at the mean speeds, modal damping.
    fn general(&self) -> Result<Option<(Matrix, Matrix)>, Error> {
        let modal = self.machine.damping.is_modal();
        let speeds = self.speeds.filter(|_| !self.machine.spins.is_empty());
        if !modal && speeds.is_none() {
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
            speeds: None,
        };
        let n = linear.n;
        let mut equations = Equations::over(&case, Matrix::identity(n, n), Vec::new(), 0);
        if let Some(speeds) = speeds {
            let terms = SpinTerms::new(self.machine, &self.linear, speeds, true);
            equations.add_spins(&terms, 0);
        }
        Ok(Some((equations.stiffness, equations.damping)))
    }

    /// What `m r Ω²` pulls outwards on masses that a carrier takes round. Of a steady start the coordinates hold the mean turn, on which
    /// the Coriolis terms act with `2 m r Ω θ̇`: `m r Ω²` of it is too much. About a start at rest nothing is added.
    fn carried_round(&self, at: StartAt) -> Vec<Drive> {
        let speeds = self.speeds.filter(|_| at == StartAt::Steady);
        let each = self.machine.spins.iter().filter_map(|spin| {
            let (freedom, lever) = spin.outwards?;
            let omega = speeds?[spin.turning];
            (lever * omega != 0.0).then(|| Drive {
                name: format!(
                    "centrifugal force on {}",
                    self.machine.freedom_name(freedom)
                ),
                direction: self.row(freedom),
                signal: Signal::constant(-lever * omega * omega),
            })
        });
        each.collect()
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
                    make(self.reduced(coast), contact(Flanks::Coast), 1),
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

    /// The wave of a mesh over its cycle.
    fn wave(&self, branch: usize, shape: Shape, lead: f64) -> Result<Wave, Error> {
        let cycles = mesh_cycle::cycles(self.machine, branch);
        // The phase of a gear that moves as prescribed is known in time.
        let prescribed = cycles.iter().find(|c| self.is_prescribed(c.turning));
        let Some(cycle) = prescribed.or(cycles.first()) else {
            let element = &self.machine.elements[self.machine.branches[branch].element];
            let message = format!(
                "`{}` has a stiffness wave and no teeth to count its cycle by",
                element.name
            );
            return Err(Error::new(Code::Conflict, message)
                .at(&element.place)
                .hint("waves belong to toothed pairs; a stage given by `base_radii` has no teeth, `teeth` and `module` give it some"));
        };
        let teeth = cycle.teeth as f64;
        self.turning(shape, cycle.turning, cycle.carrier, teeth, lead)
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
        Ok(match self.phase(freedom, carrier, cycles, lead)? {
            Phase::Imposed { omega, start } => Wave::imposed(shape, omega, start),
            phase => Wave { shape, phase },
        })
    }

    /// What passes `cycles` times a turn of a freedom against its carrier.
    fn phase(
        &self,
        freedom: usize,
        carrier: Option<usize>,
        cycles: f64,
        start: f64,
    ) -> Result<Phase, Error> {
        if self.phase == PhaseOf::Angle {
            let own = self.linear.transform[freedom].iter().copied();
            let carried = carrier.map(|c| self.linear.transform[c].iter().map(|&(j, a)| (j, -a)));
            return Ok(Phase::Followed {
                angle: Direction::new(cycles, own.chain(carried.into_iter().flatten())),
                start,
                known: None,
            });
        }
        let omega = cycles * (self.speed(freedom)? - carrier.map_or(Ok(0.0), |c| self.speed(c))?);
        Ok(Phase::Imposed { omega, start })
    }

    fn is_prescribed(&self, freedom: usize) -> bool {
        let rows = &self.linear.transform;
        let mut motors = self.machine.motors.iter();
        motors.any(|m| {
            let prescribes = !matches!(m.drive, laws::Drive::Curve { .. });
            prescribes && rows[m.freedom].len() == 1 && rows[freedom] == rows[m.freedom]
        })
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
    fn errors(&self, branch: usize, flank: usize) -> Result<(Option<Signal>, Vec<Wave>), Error> {
        let (mut imposed, mut followed): (Option<Signal>, Vec<Wave>) = (None, Vec::new());
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
            match wave.phase {
                Phase::Imposed { omega, start } => {
                    let signal = wave.shape.over_time(omega, start);
                    imposed = Some(imposed.map_or(signal.clone(), |s| s.plus(&signal)));
                }
                Phase::Followed { .. } => followed.push(wave),
            }
        }
        Ok((imposed, followed))
    }

    /// Dry friction; `of` are the branches of the train that each branch of the machine is.
    fn brakes(&self, of: &[Vec<usize>]) -> Result<Vec<Branch>, Error> {
        let mut branches = Vec::new();
        for brake in &self.machine.brakes {
            let direction = self.reduced(&brake.direction);
            let element = &self.machine.elements[brake.element];
            let name = element.name.clone();
            match &brake.grip {
                Grip::Constant => {
                    branches.push(plain(name, direction, Law::Friction(brake.friction)));
                }
                Grip::Timed(share) => {
                    let law = Law::Clutch {
                        friction: brake.friction,
                        grip: known::signal(share)?,
                    };
                    branches.push(plain(name, direction, law));
                }
                Grip::Pressed(pressed) if pressed.coefficient == 0.0 => {
                    let law = Law::Friction(brake.friction.gripped(pressed.constant));
                    branches.push(plain(format!("{name} friction"), direction, law));
                }
                Grip::Pressed(pressed) => {
                    let name = format!("{name} friction");
                    for law in self.pressed(brake.friction, pressed, of)? {
                        branches.push(plain(name.clone(), direction.clone(), law));
                    }
                }
            }
        }
        Ok(branches)
    }

    fn reduced(&self, direction: &Direction) -> Direction {
        Direction {
            scale: direction.scale,
            terms: self.kinematics.reduced(&direction.terms),
        }
    }

    /// Friction that goes by forces of branches; one law a flank where these are branches of their own.
    fn pressed(
        &self,
        friction: Friction,
        pressed: &parts::Pressed,
        of: &[Vec<usize>],
    ) -> Result<Vec<Law>, Error> {
        let law = |by: Vec<Vec<(usize, f64)>>, path: Option<rubbing::Path>| {
            Law::Pressed(Box::new(Pressed {
                friction,
                constant: pressed.constant,
                coefficient: pressed.coefficient,
                by,
                path,
            }))
        };
        let component = |forces: &Vec<(usize, f64)>| {
            let each = forces
                .iter()
                .flat_map(|&(b, share)| of[b].iter().map(move |&at| (at, share)));
            each.collect()
        };
        let Some(path) = &pressed.path else {
            return Ok(vec![law(pressed.by.iter().map(component).collect(), None)]);
        };
        let phase = match path.cycle {
            Some((freedom, teeth, start)) => {
                Some(self.phase(freedom, None, f64::from(teeth), start)?)
            }
            None => None,
        };
        let flanks = pressed.by.iter().flatten().flat_map(|f| &of[f.0]);
        let flanks: Vec<usize> = flanks.copied().collect();
        let own = |(flank, &at): (usize, &usize)| {
            // A branch of its own for coast flanks pulls with a force below zero as well.
            let aside = match flanks.len() {
                1 => [&path.aside[0]; 2],
                _ => [&path.aside[flank]; 2],
            };
            let path = rubbing::Path {
                aside: aside.map(|d| self.reduced(d)),
                pieces: path.pieces.clone(),
                phase: phase.clone(),
            };
            law(vec![vec![(at, 1.0)]], Some(path))
        };
        Ok(flanks.iter().enumerate().map(own).collect())
    }

    /// Loads whose orders are locked to the angle of their node.
    fn locked(&self) -> Vec<Branch> {
        let load = |(freedom, history): &(usize, History)| match history {
            History::Orders { mean, orders } if self.phase == PhaseOf::Angle => Some(plain(
                load_on(self.machine, *freedom),
                self.row(*freedom),
                Law::Orders {
                    mean: *mean,
                    terms: orders.clone(),
                },
            )),
            _ => None,
        };
        self.machine.histories.iter().filter_map(load).collect()
    }

    /// Whether a constant torque stood for a motor that is there now: one that pushes the way the motor starts, or any where the
    /// motion itself is prescribed.
    fn stands_for_motor(&self, freedom: usize, torque: f64) -> bool {
        let mut motors = self.machine.motors.iter();
        motors.any(|motor| {
            let takes = match &motor.drive {
                laws::Drive::Curve { curve, .. } => curve.torque(0.0) * torque >= 0.0,
                laws::Drive::Speed(_) | laws::Drive::Angle(_) => true,
            };
            motor.freedom == freedom && takes
        })
    }

    /// Loads over time by freedom, orders where they turn at the mean speed.
    fn loads(&self) -> Result<Vec<(usize, Signal)>, Error> {
        let mut loads = Vec::new();
        for (freedom, history) in &self.machine.histories {
            if matches!(history, History::Constant(torque) if self.stands_for_motor(*freedom, *torque))
            {
                continue;
            }
            let signal = match history {
                History::Orders { .. } if self.phase == PhaseOf::Angle => continue,
                History::Orders { mean, orders } => {
                    let omega = self.speed(*freedom)?;
                    orders
                        .iter()
                        .fold(Signal::constant(*mean), |sum, &(n, a, phase)| {
                            sum.plus(&Signal::harmonic(a, n * omega, phase))
                        })
                }
                History::FaceMill(mill) => {
                    let moved = &self.machine.freedoms[*freedom];
                    // The first of a node's freedoms is its rotation.
                    let mut all = self.machine.freedoms.iter();
                    let head = all.position(|f| f.node == moved.node);
                    cutting::force(mill, self.speed(head.unwrap_or(*freedom))?, moved.axis)?
                }
                history => known::signal(history)?,
            };
            loads.push((*freedom, signal));
        }
        Ok(loads)
    }

    /// The coordinate that a prescribed motion moves, and how far per unit.
    fn prescribe(
        &self,
        motor: &parts::Motor,
        known: &[(String, usize, Signal)],
    ) -> Result<(usize, f64), Error> {
        let element = &self.machine.elements[motor.element];
        let terms = &self.linear.transform[motor.freedom];
        let &[(j, a)] = &terms[..] else {
            let message = format!(
                "the motion of `{}` cannot be prescribed: rigid joints tie it to several others",
                element.name
            );
            let hint = "put the motor on the body that others are joined to, or give one of the joints its k";
            return Err(Error::new(Code::Conflict, message)
                .at(&element.place)
                .hint(hint));
        };
        if let Some((other, ..)) = known.iter().find(|k| k.1 == j) {
            let message = format!(
                "`{other}` and `{}` prescribe the motion of one rigid body",
                element.name
            );
            return Err(Error::new(Code::Conflict, message)
                .at(&element.place)
                .hint("leave one of them out"));
        }
        Ok((j, 1.0 / a))
    }
}

/// What the load on a freedom is called, as a drive and as a branch.
pub fn load_on(machine: &Machine, freedom: usize) -> String {
    format!("load on {}", machine.freedom_name(freedom))
}

/// A course as a known function of time.
fn over_time(course: &Course) -> Result<Signal, Error> {
    let swing = course
        .swing
        .map(|s| Signal::harmonic(s.amplitude, s.omega, s.phase));
    let line = Signal::table(&course.points)?;
    Ok(swing.map_or(line.clone(), |swing| line.plus(&swing)))
}

fn plain(name: String, direction: Direction, law: Law) -> Branch {
    Branch {
        name,
        direction,
        force: None,
        law,
        variation: None,
        imposed: None,
        followed: Vec::new(),
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
