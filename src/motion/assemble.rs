//! Assembly of the dynamic model `M q̈ + C q̇ + K q + Σ u F = f` from a machine and its scene.

use std::f64::consts::TAU;
use std::sync::Arc;

use super::assembled::AssembledModel;
use super::combination::LinearCombination;
use super::contact::{ActiveFlanks, ContactDamping, ContactLaw};
use super::curve::TorqueSpeedCurve;
use super::cutting;
use super::dynamic_model::{AppliedForce, DynamicModel, ForceElement, ForceLaw, MassMatrix};
use super::known;
use super::load_friction::{self, LoadFriction};
use super::signal::Signal;
use super::wave::{PeriodicFunction, WavePhase, Waveform};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::source_span::SourceSpan;
use crate::gear::load::load_table::LoadTable;
use crate::machine::components::{self, FrictionCapacity, Machine};
use crate::machine::direction::Direction;
use crate::machine::kinematics::Kinematics;
use crate::machine::linear::{LinearBranch, LinearModel};
use crate::machine::mesh_cycle;
use crate::machine::operating_point::{ActiveFlank, OperatingPoint};
use crate::machine::spin::SpinTerms;
use crate::modes::modal_basis::{self, UndampedSolver};
use crate::modes::system_matrices::{AnalysisContext, SystemMatrices};
use crate::numeric::Matrix;
use crate::scene::initial_conditions::InitialConditions;
use crate::scene::laws::{self, FrictionLaw, InitialState, LoadHistory, MeshPhase, MotionProfile};
use crate::scene::model::{MeshSprings, ToothPairs};

/// Waveform of one period, with the load–deflection table along it.
type WaveShape = (Waveform, Option<Arc<LoadTable>>);

/// Inputs shared by all parts of the assembly.
struct Assembler<'a> {
    machine: &'a Machine,
    kinematics: &'a Kinematics,
    operating: OperatingPoint,
    model: LinearModel,
    /// Mean speed of every degree of freedom, rad/s, if the file states any.
    speeds: Option<&'a [f64]>,
    phase: MeshPhase,
}

/// Assembles the dynamic model of a machine for time integration; `speeds` are the mean speeds of all degrees of freedom, rad/s,
/// if known.
///
/// # Errors
/// Elements without time-domain model: loss factors; massless nodes at elements other than springs and dampers; contacts with play and
/// damping but without contact damping law; waves or cutters without speed.
pub fn assemble(
    machine: &Machine,
    kinematics: &Kinematics,
    operating: &OperatingPoint,
    begin: &InitialConditions,
    speeds: Option<&[f64]>,
) -> Result<AssembledModel, Error> {
    // Contacts with play open and close in time; meshes without play act along the flank in contact under the mean loads.
    let operating = OperatingPoint {
        coast: operating.coast.clone(),
        ..OperatingPoint::default()
    };
    let model = LinearModel::new(machine, kinematics, &operating)?;
    check_supported(machine, &model)?;
    let asm = Assembler {
        machine,
        kinematics,
        operating,
        model,
        speeds,
        phase: begin.phase,
    };
    let coordinates = asm
        .model
        .independent_dofs
        .iter()
        .map(|&i| machine.dof_name(i))
        .collect();
    let mass = asm.mass()?;
    let general = asm.gyroscopic_and_modal_terms()?;
    let (mut elements, mut by_branch) = (Vec::new(), vec![Vec::new(); machine.branches.len()]);
    for linear in &asm.model.branches {
        for branch in asm.branch(linear)? {
            by_branch[linear.index].push(elements.len());
            elements.push(branch);
        }
    }
    elements.extend(asm.friction_elements(&by_branch)?);
    elements.extend(asm.angle_locked_loads());
    let mut known: Vec<(String, usize, Signal)> = Vec::new();
    for motor in &machine.motors {
        let name = machine.elements[motor.element].name.clone();
        match &motor.drive {
            laws::MotorModel::Curve { curve, lag } => {
                elements.push(motor_branch(name, asm.dof_row(motor.dof), curve, *lag))
            }
            laws::MotorModel::Speed(profile) => {
                let (coordinate, ratio) = asm.prescribe(motor, &known)?;
                known.push((
                    name,
                    coordinate,
                    history_to_signal(profile)?.integral().scaled(ratio),
                ));
            }
            laws::MotorModel::Angle(profile) => {
                let (coordinate, ratio) = asm.prescribe(motor, &known)?;
                known.push((name, coordinate, history_to_signal(profile)?.scaled(ratio)));
            }
        }
    }
    let loads = asm.loads()?;
    let drives = loads.iter().map(|(dof, signal)| AppliedForce {
        name: load_name(machine, *dof),
        direction: asm.dof_row(*dof),
        signal: signal.clone(),
    });
    let drives = drives.chain(asm.centrifugal_forces(begin.at));
    let model = DynamicModel {
        coordinates,
        mass,
        elements,
        forces: drives.collect(),
        mass_damping: machine.damping.mass,
        global_matrices: general,
    };
    let dofs = asm.model.transform.iter().map(|terms| {
        Some(LinearCombination {
            terms: terms.clone(),
            imposed: None,
        })
    });
    let assembled = AssembledModel {
        dofs: dofs.collect(),
        retained: (0..model.coordinate_count()).collect(),
        model,
        springs: vec![None; by_branch.len()],
        loads,
        branches: by_branch,
        rigid: asm.model.rigid.clone(),
        prescribed: None,
    };
    let ids = asm.model.massless.iter().copied();
    let massless: Vec<usize> = ids.filter(|j| known.iter().all(|k| k.1 != *j)).collect();
    assembled
        .without_massless(&massless, &|j| {
            let node = machine.dofs[asm.model.independent_dofs[j]].node;
            machine.elements[machine.nodes[node].element].span.clone()
        })?
        .without_prescribed(known)
}

/// Checks that all elements have a time-domain model.
fn check_supported(machine: &Machine, model: &LinearModel) -> Result<(), Error> {
    if let Some(lb) = model.branches.iter().find(|b| b.loss_factor != 0.0) {
        let element = &machine.elements[machine.branches[lb.index].element];
        let message = format!(
            "the loss factor of `{}` is defined in the frequency domain only",
            element.name
        );
        let hint = "give it `c` or `damping_ratio` for motion in time";
        return Err(Error::new(Code::Conflict, message)
            .with_span(&element.span)
            .with_hint(hint));
    }
    for (at, motor) in machine.motors.iter().enumerate() {
        let other = machine.motors[..at].iter().find(|m| m.dof == motor.dof);
        let is_speed =
            |m: &components::MotorDrive| !matches!(m.drive, laws::MotorModel::Curve { .. });
        if let Some(other) = other.filter(|m| is_speed(m) || is_speed(motor)) {
            let (first, second) = (
                &machine.elements[other.element],
                &machine.elements[motor.element],
            );
            let message = format!(
                "`{}` and `{}` both act on {}, and one of them prescribes its motion",
                first.name,
                second.name,
                machine.dof_name(motor.dof)
            );
            return Err(Error::new(Code::Conflict, message)
                .with_span(&second.span)
                .with_hint("omit one of them"));
        }
    }
    Ok(())
}

impl Assembler<'_> {
    /// Row of a degree of freedom over the independent coordinates.
    fn dof_row(&self, dof: usize) -> Direction {
        Direction::new(1.0, self.model.transform[dof].iter().copied())
    }

    fn mass(&self) -> Result<MassMatrix, Error> {
        if let Some(diagonal) = self.model.mass_diagonal() {
            return Ok(MassMatrix::Diagonal(diagonal));
        }
        let n = self.model.n;
        let mut matrix = Matrix::zeros(n, n);
        for mass in &self.model.masses {
            for (i, a) in mass.direction.entries() {
                for (j, b) in mass.direction.entries() {
                    matrix[(i, j)] += mass.value * a * b;
                }
            }
        }
        MassMatrix::full(matrix)
    }

    /// K₀ and C₀: gyroscopic, centripetal and circulatory terms at the mean speeds, modal damping.
    fn gyroscopic_and_modal_terms(&self) -> Result<Option<(Matrix, Matrix)>, Error> {
        let modal = self.machine.damping.is_modal();
        let speeds = self.speeds.filter(|_| !self.machine.gyroscopic.is_empty());
        if !modal && speeds.is_none() {
            return Ok(None);
        }
        let basis = modal_basis::solve(&self.model, UndampedSolver::Factored)?;
        let mut bare = self.machine.clone();
        (bare.damping.mass, bare.damping.stiffness) = (0.0, 0.0);
        let mut model = self.model.clone();
        model.branches.clear();
        let context = AnalysisContext {
            machine: &bare,
            model: &model,
            basis: &basis,
            speeds: None,
        };
        let n = model.n;
        let mut matrices =
            SystemMatrices::in_basis(&context, Matrix::identity(n, n), Vec::new(), 0);
        if let Some(speeds) = speeds {
            let terms = SpinTerms::new(self.machine, &self.model, speeds, true);
            matrices.add_gyroscopic(&terms, 0);
        }
        Ok(Some((matrices.stiffness, matrices.damping)))
    }

    /// Centrifugal forces `m r Ω²` on masses that rotate with a carrier. In a steady start the coordinates contain the mean rotation, so
    /// that the Coriolis terms `2 m r Ω θ̇` exceed them by `m r Ω²`, which is subtracted; a start at rest needs no correction.
    fn centrifugal_forces(&self, at: InitialState) -> Vec<AppliedForce> {
        let speeds = self.speeds.filter(|_| at == InitialState::Steady);
        let forces = self.machine.gyroscopic.iter().filter_map(|spin| {
            let (dof, lever) = spin.outwards?;
            let omega = speeds?[spin.spin_dof];
            (lever * omega != 0.0).then(|| AppliedForce {
                name: format!("centrifugal force on {}", self.machine.dof_name(dof)),
                direction: self.dof_row(dof),
                signal: Signal::constant(-lever * omega * omega),
            })
        });
        forces.collect()
    }

    /// Force elements of a branch: one, or one per flank if the flanks act in different directions.
    fn branch(&self, lb: &LinearBranch) -> Result<Vec<ForceElement>, Error> {
        let branch = &self.machine.branches[lb.index];
        let damping = lb.damping + self.machine.damping.stiffness * lb.stiffness;
        let variation = match &branch.stiffness_variation {
            None => None,
            Some(wave) => {
                let table = match &branch.mesh_springs {
                    Some(MeshSprings::LoadTable(table)) => Some(table.clone()),
                    _ => None,
                };
                let shape = (wave.waveform.clone(), table);
                Some(self.wave(lb.index, shape, wave.phase, 1)?)
            }
        };
        if let Some(MeshSprings::ToothPairs(pairs)) = &branch.mesh_springs {
            return self.tooth_pairs(lb, pairs, damping);
        }
        let errors = [self.errors(lb.index, 0)?, self.errors(lb.index, 1)?];
        let make = |direction: Direction, law: ForceLaw, flank: usize| {
            let (imposed, followed) = errors[flank].clone();
            ForceElement {
                name: self.machine.branch_name(lb.index),
                direction,
                force_direction: lb.force.clone(),
                law,
                stiffness_wave: variation.clone(),
                imposed_displacement: imposed,
                angle_waves: followed,
            }
        };
        let loaded_flank = usize::from(self.operating.state(lb.index) == ActiveFlank::Coast);
        if let Some(characteristic) = branch.characteristic.clone() {
            let law = ForceLaw::Nonlinear {
                characteristic,
                damping,
            };
            return Ok(vec![make(lb.direction.clone(), law, 0)]);
        }
        if branch.backlash == 0.0 && branch.stiffness_variation.is_none() {
            let law = ForceLaw::Linear {
                stiffness: lb.stiffness,
                damping,
            };
            return Ok(vec![make(lb.direction.clone(), law, loaded_flank)]);
        }
        let contact_damping = self.losses(branch, damping)?;
        let contact = |flanks: ActiveFlanks| {
            ForceLaw::Contact(ContactLaw {
                stiffness: lb.stiffness,
                damping,
                half_play: branch.backlash / 2.0,
                contact_damping,
                flanks,
            })
        };
        Ok(match &branch.coast {
            Some(coast) if branch.backlash > 0.0 => {
                vec![
                    make(lb.direction.clone(), contact(ActiveFlanks::Drive), 0),
                    make(self.reduced(coast), contact(ActiveFlanks::Coast), 1),
                ]
            }
            _ => vec![make(
                lb.direction.clone(),
                contact(ActiveFlanks::Both),
                loaded_flank,
            )],
        })
    }

    /// Tooth pairs of a mesh, drive flanks first: one-sided springs with the gap as imposed displacement. The mean number of loaded pairs
    /// shares the mesh damping.
    fn tooth_pairs(
        &self,
        lb: &LinearBranch,
        pairs: &ToothPairs,
        damping: f64,
    ) -> Result<Vec<ForceElement>, Error> {
        let branch = &self.machine.branches[lb.index];
        let contact_damping = self.losses(branch, damping)?;
        let coast = branch.coast.as_ref().map(|coast| self.reduced(coast));
        let sides = [
            (ActiveFlanks::Drive, 1.0, lb.direction.clone()),
            (
                ActiveFlanks::Coast,
                -1.0,
                coast.unwrap_or(lb.direction.clone()),
            ),
        ];
        let mut all = Vec::new();
        for (flank, ((flanks, sign, direction), spring)) in
            sides.into_iter().zip(&pairs.flanks).enumerate()
        {
            // Gear errors without flank errors, which the gaps contain.
            let (imposed, followed) = self.declared_errors(lb.index, flank)?;
            for number in 0..pairs.count {
                let lead = spring.phase + TAU * f64::from(number);
                let wave =
                    |waveform: Waveform| self.wave(lb.index, (waveform, None), lead, pairs.count);
                let gap = wave(spring.gap.scaled(sign))?;
                let (mut imposed, mut followed) = (imposed.clone(), followed.clone());
                add_displacement(gap, &mut imposed, &mut followed);
                all.push(ForceElement {
                    name: format!(
                        "{} {} pair {}",
                        self.machine.branch_name(lb.index),
                        if flanks == ActiveFlanks::Drive {
                            "drive"
                        } else {
                            "coast"
                        },
                        number + 1
                    ),
                    direction: direction.clone(),
                    force_direction: lb.force.clone(),
                    law: ForceLaw::Contact(ContactLaw {
                        stiffness: lb.stiffness,
                        damping: damping / pairs.carrying,
                        half_play: branch.backlash / 2.0,
                        contact_damping,
                        flanks,
                    }),
                    stiffness_wave: Some(wave(spring.stiffness.clone())?),
                    imposed_displacement: imposed,
                    angle_waves: followed,
                });
            }
        }
        Ok(all)
    }

    /// Contact damping at opening and closing; it must be specified.
    fn losses(&self, branch: &components::Branch, damping: f64) -> Result<ContactDamping, Error> {
        let stated = branch.contact_damping.or(self.machine.damping.contacts);
        if branch.backlash == 0.0 || damping == 0.0 {
            return Ok(stated.unwrap_or(ContactDamping::Adhesive));
        }
        stated.ok_or_else(|| {
            let element = &self.machine.elements[branch.element];
            let message = format!("`{}` has play and damping, and its damper force in the open contact is not stated", element.name);
            let hint = "write contact_damping = \"no-pull\" (or \"continuous\", \"adhesive\", \"throughout\") in it, or contacts = … in [damping] for all";
            Error::new(Code::MissingKey, message).with_span(&element.span).with_hint(hint)
        })
    }

    /// Periodic function of a mesh with a period of `period` mesh cycles; `lead` is in rad of one cycle.
    fn wave(
        &self,
        branch: usize,
        shape: WaveShape,
        lead: f64,
        period: u32,
    ) -> Result<PeriodicFunction, Error> {
        let cycles = mesh_cycle::cycles(self.machine, branch);
        // The phase of a gear that moves as prescribed is known in time.
        let prescribed = cycles.iter().find(|c| self.is_prescribed(c.rotation));
        let Some(cycle) = prescribed.or(cycles.first()) else {
            let element = &self.machine.elements[self.machine.branches[branch].element];
            let message = format!(
                "`{}` has a stiffness wave and no teeth that define its cycle",
                element.name
            );
            return Err(Error::new(Code::Conflict, message)
                .with_span(&element.span)
                .with_hint("stiffness waves need teeth; give a stage `teeth` and `module` in place of `base_radii`"));
        };
        let period = f64::from(period);
        let teeth = cycle.teeth as f64 / period;
        self.rotating_wave(shape, cycle.rotation, cycle.carrier, teeth, lead / period)
    }

    /// Periodic function with `cycles` periods per revolution of a degree of freedom relative to its carrier.
    fn rotating_wave(
        &self,
        (waveform, load_table): WaveShape,
        dof: usize,
        carrier: Option<usize>,
        cycles: f64,
        lead: f64,
    ) -> Result<PeriodicFunction, Error> {
        let wave = PeriodicFunction {
            waveform,
            load_table,
            phase: self.phase(dof, carrier, cycles, lead)?,
        };
        Ok(match wave.phase {
            WavePhase::Imposed { omega, start } => wave.imposed(omega, start),
            WavePhase::FollowsAngle { .. } => wave,
        })
    }

    /// Phase, rad, with `cycles` periods per revolution of a degree of freedom relative to its carrier.
    fn phase(
        &self,
        dof: usize,
        carrier: Option<usize>,
        cycles: f64,
        start: f64,
    ) -> Result<WavePhase, Error> {
        if self.phase == MeshPhase::Angle {
            let angle = self.model.transform[dof].iter().copied();
            let frame = carrier.map(|c| self.model.transform[c].iter().map(|&(j, a)| (j, -a)));
            return Ok(WavePhase::FollowsAngle {
                angle: Direction::new(cycles, angle.chain(frame.into_iter().flatten())),
                start,
                known: None,
            });
        }
        let omega = cycles * (self.speed(dof)? - carrier.map_or(Ok(0.0), |c| self.speed(c))?);
        Ok(WavePhase::Imposed { omega, start })
    }

    fn is_prescribed(&self, dof: usize) -> bool {
        let rows = &self.model.transform;
        let mut motors = self.machine.motors.iter();
        motors.any(|m| {
            let prescribes = !matches!(m.drive, laws::MotorModel::Curve { .. });
            prescribes && rows[m.dof].len() == 1 && rows[dof] == rows[m.dof]
        })
    }

    fn speed(&self, dof: usize) -> Result<f64, Error> {
        self.speeds.as_ref().map(|s| s[dof]).ok_or_else(|| {
            let message = format!(
                "the speed of {} is needed, and no speed is stated",
                self.machine.dof_name(dof)
            );
            Error::new(Code::UndeterminedSpeed, message)
                .with_hint("state the speed of a node in [speed] of the model")
        })
    }

    /// Transmission error e of a flank of a branch (0 drive, 1 coast): harmonics at imposed speed, else periodic functions of the angle.
    fn errors(
        &self,
        branch: usize,
        flank: usize,
    ) -> Result<(Option<Signal>, Vec<PeriodicFunction>), Error> {
        self.errors_of(branch, flank, &self.machine.errors)
    }

    /// Transmission error of the declared errors, without flank errors of gear files.
    fn declared_errors(
        &self,
        branch: usize,
        flank: usize,
    ) -> Result<(Option<Signal>, Vec<PeriodicFunction>), Error> {
        let all = self.machine.errors.iter();
        let declared: Vec<_> = all.filter(|e| e.averaged.is_none()).cloned().collect();
        self.errors_of(branch, flank, &declared)
    }

    fn errors_of(
        &self,
        branch: usize,
        flank: usize,
        errors: &[components::GeometricError],
    ) -> Result<(Option<Signal>, Vec<PeriodicFunction>), Error> {
        let (mut imposed, mut followed): (Option<Signal>, Vec<PeriodicFunction>) =
            (None, Vec::new());
        let acting = errors.iter().flat_map(|error| {
            let acts = error.acts.iter().filter(|act| act.branch == branch);
            acts.map(move |act| (error, act.flanks[flank]))
        });
        for (error, action) in acting {
            let order = error.periods_per_rev.0 as f64 / error.periods_per_rev.1 as f64;
            let wave = self.rotating_wave(
                (error.waveform.scaled(-action.gain), None),
                error.rotation_dof,
                error.carrier,
                order,
                action.phase,
            )?;
            add_displacement(wave, &mut imposed, &mut followed);
        }
        Ok((imposed, followed))
    }

    /// Friction elements; `by_branch` lists the force elements of every branch of the machine.
    fn friction_elements(&self, by_branch: &[Vec<usize>]) -> Result<Vec<ForceElement>, Error> {
        let mut elements = Vec::new();
        for brake in &self.machine.friction_elements {
            let direction = self.reduced(&brake.direction);
            let element = &self.machine.elements[brake.element];
            let name = element.name.clone();
            match &brake.capacity {
                FrictionCapacity::Constant => {
                    elements.push(bare_element(
                        name,
                        direction,
                        ForceLaw::Friction(brake.friction),
                    ));
                }
                FrictionCapacity::Timed(share) => {
                    let law = ForceLaw::Clutch {
                        friction: brake.friction,
                        capacity: known::signal(share)?,
                    };
                    elements.push(bare_element(name, direction, law));
                }
                FrictionCapacity::Pressed(pressed) if pressed.coefficient == 0.0 => {
                    let law = ForceLaw::Friction(brake.friction.scaled(pressed.constant));
                    elements.push(bare_element(format!("{name} friction"), direction, law));
                }
                FrictionCapacity::Pressed(pressed) => {
                    let name = format!("{name} friction");
                    for law in self.load_dependent_friction(brake.friction, pressed, by_branch)? {
                        elements.push(bare_element(name.clone(), direction.clone(), law));
                    }
                }
            }
        }
        Ok(elements)
    }

    fn reduced(&self, direction: &Direction) -> Direction {
        Direction {
            scale: direction.scale,
            terms: self.kinematics.reduce_row(&direction.terms),
        }
    }

    /// Load-dependent friction laws: one, or one per flank if the flanks are separate force elements.
    fn load_dependent_friction(
        &self,
        friction: FrictionLaw,
        pressed: &components::LoadDependentCapacity,
        by_branch: &[Vec<usize>],
    ) -> Result<Vec<ForceLaw>, Error> {
        let law = |by: Vec<Vec<(usize, f64)>>, path: Option<load_friction::FrictionLevers>| {
            ForceLaw::LoadFriction(Box::new(LoadFriction {
                friction,
                constant: pressed.constant,
                coefficient: pressed.coefficient,
                force_components: by,
                path,
            }))
        };
        let component = |forces: &Vec<(usize, f64)>| {
            let terms = forces
                .iter()
                .flat_map(|&(b, share)| by_branch[b].iter().map(move |&at| (at, share)));
            terms.collect()
        };
        let Some(path) = &pressed.path else {
            return Ok(vec![law(
                pressed.force_components.iter().map(component).collect(),
                None,
            )]);
        };
        let phase = match path.cycle {
            Some((dof, teeth, start)) => Some(self.phase(dof, None, f64::from(teeth), start)?),
            None => None,
        };
        let flanks = pressed
            .force_components
            .iter()
            .flatten()
            .flat_map(|f| &by_branch[f.0]);
        let flanks: Vec<usize> = flanks.copied().collect();
        let flank_law = |(number, &at): (usize, &usize)| {
            // Elements of coast flanks follow those of drive flanks; their normal force may be negative as well.
            let flank = 2 * number / flanks.len();
            let levers = [&path.pitch_point_sliding[flank]; 2];
            let path = load_friction::FrictionLevers {
                pitch_point_sliding: levers.map(|d| self.reduced(d)),
                pieces: path.pieces.clone(),
                phase: phase.clone(),
            };
            law(vec![vec![(at, 1.0)]], Some(path))
        };
        Ok(flanks.iter().enumerate().map(flank_law).collect())
    }

    /// Loads whose orders are locked to the angle of their node.
    fn angle_locked_loads(&self) -> Vec<ForceElement> {
        let load = |(dof, history, _): &(usize, LoadHistory, SourceSpan)| match history {
            LoadHistory::Orders { mean, orders } if self.phase == MeshPhase::Angle => {
                Some(bare_element(
                    load_name(self.machine, *dof),
                    self.dof_row(*dof),
                    ForceLaw::AngleLocked {
                        mean: *mean,
                        terms: orders.clone(),
                    },
                ))
            }
            _ => None,
        };
        self.machine.histories.iter().filter_map(load).collect()
    }

    /// Whether a motor replaces a constant torque: a torque in the starting direction of the motor, or any torque if the motor
    /// prescribes the motion.
    fn is_replaced_by_motor(&self, dof: usize, torque: f64) -> bool {
        let mut motors = self.machine.motors.iter();
        motors.any(|motor| {
            let replaces = match &motor.drive {
                laws::MotorModel::Curve { curve, .. } => curve.torque(0.0) * torque >= 0.0,
                laws::MotorModel::Speed(_) | laws::MotorModel::Angle(_) => true,
            };
            motor.dof == dof && replaces
        })
    }

    /// Loads over time by degree of freedom, N·m or N, with orders at the mean speed.
    fn loads(&self) -> Result<Vec<(usize, Signal)>, Error> {
        let mut loads = Vec::new();
        for (dof, history, span) in &self.machine.histories {
            if matches!(history, LoadHistory::Constant(torque) if self.is_replaced_by_motor(*dof, *torque))
            {
                continue;
            }
            let signal = match history {
                LoadHistory::Orders { .. } if self.phase == MeshPhase::Angle => continue,
                LoadHistory::Orders { mean, orders } => {
                    let omega = self.speed(*dof)?;
                    orders
                        .iter()
                        .fold(Signal::constant(*mean), |sum, &(n, a, phase)| {
                            sum.plus(&Signal::harmonic(a, n * omega, phase))
                        })
                }
                LoadHistory::FaceMill(mill) => {
                    let load = &self.machine.dofs[*dof];
                    // The first of a node's degrees of freedom is its rotation.
                    let mut all = self.machine.dofs.iter();
                    let spin = all.position(|f| f.node == load.node);
                    cutting::cutting_force(mill, self.speed(spin.unwrap_or(*dof))?, load.axis)?
                }
                history => known::signal(history).map_err(|e| e.with_span(span))?,
            };
            loads.push((*dof, signal));
        }
        Ok(loads)
    }

    /// Coordinate of a prescribed motion, and its displacement per unit of the motion.
    fn prescribe(
        &self,
        motor: &components::MotorDrive,
        known: &[(String, usize, Signal)],
    ) -> Result<(usize, f64), Error> {
        let element = &self.machine.elements[motor.element];
        let terms = &self.model.transform[motor.dof];
        let &[(j, a)] = &terms[..] else {
            let message = format!(
                "the motion of `{}` cannot be prescribed: rigid joints tie it to several others",
                element.name
            );
            let hint = "put the motor on the body to which the others are joined, or give one of the joints its k";
            return Err(Error::new(Code::Conflict, message)
                .with_span(&element.span)
                .with_hint(hint));
        };
        if let Some((other, ..)) = known.iter().find(|k| k.1 == j) {
            let message = format!(
                "`{other}` and `{}` prescribe the motion of one rigid body",
                element.name
            );
            return Err(Error::new(Code::Conflict, message)
                .with_span(&element.span)
                .with_hint("omit one of them"));
        }
        Ok((j, 1.0 / a))
    }
}

/// Adds a displacement to those imposed in time or to the functions of an angle.
fn add_displacement(
    wave: PeriodicFunction,
    imposed: &mut Option<Signal>,
    followed: &mut Vec<PeriodicFunction>,
) {
    match wave.phase {
        WavePhase::Imposed { omega, start } => {
            let signal = wave.waveform.to_signal(omega, start);
            *imposed = Some(match imposed.take() {
                Some(others) => others.plus(&signal),
                None => signal,
            });
        }
        WavePhase::FollowsAngle { .. } => followed.push(wave),
    }
}

/// Name of the load on a degree of freedom, as an applied force and as a force element.
pub fn load_name(machine: &Machine, dof: usize) -> String {
    format!("load on {}", machine.dof_name(dof))
}

/// Converts a motion profile to a known function of time.
fn history_to_signal(profile: &MotionProfile) -> Result<Signal, Error> {
    let oscillation = profile
        .oscillation
        .map(|s| Signal::harmonic(s.amplitude, s.omega, s.phase));
    let line = Signal::table(&profile.points)?;
    Ok(oscillation.map_or(line.clone(), |oscillation| line.plus(&oscillation)))
}

fn bare_element(name: String, direction: Direction, law: ForceLaw) -> ForceElement {
    ForceElement {
        name,
        direction,
        force_direction: None,
        law,
        stiffness_wave: None,
        imposed_displacement: None,
        angle_waves: Vec::new(),
    }
}

fn motor_branch(
    name: String,
    direction: Direction,
    curve: &TorqueSpeedCurve,
    lag: f64,
) -> ForceElement {
    let law = match lag {
        0.0 => ForceLaw::TorqueSpeed(curve.clone()),
        lag => ForceLaw::LaggedTorque {
            curve: curve.clone(),
            lag,
        },
    };
    bare_element(name, direction, law)
}
