//! Equations between inputs and outputs: `D(s) x = b(s) u`, `y = c(s) x + d(s) u`, `D = s² M + s C + K + i sgn(Im s) H`.
//!
//! b, c and d are sums of real columns and rows with the factors 1, s, s² and i sgn(Im s): what is prescribed acts through
//! `−D_rh h`, a branch with an imposed displacement through `u (k + s c + iηk) e`.

use super::coordinates::{Coordinates, Held, Origin};
use super::ports::{Input, Output, Ports};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::machine::linear::{Linear, LinearBranch};
use crate::machine::operating::Operating;
use crate::machine::parts::{Law, Machine};
use crate::modes::basis::{self, Basis, Solver};
use crate::modes::equations::{Case, Equations};
use crate::numeric::{Complex, Matrix};
use crate::scene::model::Axis;

/// A machine at its operating point, as frequency responses need it.
#[derive(Clone, Copy)]
pub struct Setting<'a> {
    /// The machine.
    pub machine: &'a Machine,
    /// How its contacts stand.
    pub operating: &'a Operating,
    /// The same, linear.
    pub linear: &'a Linear,
    /// Mean speed of every freedom, rad/s, for gyroscopic terms; absent: at rest.
    pub speeds: Option<&'a [f64]>,
}

/// A power of s, and whether `i sgn(Im s)` goes with it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Factor {
    pub power: u8,
    pub lossy: bool,
}

impl Factor {
    pub const ONE: Factor = Factor {
        power: 0,
        lossy: false,
    };
    const S: Factor = Factor {
        power: 1,
        lossy: false,
    };
    const SS: Factor = Factor {
        power: 2,
        lossy: false,
    };
    const LOSSY: Factor = Factor {
        power: 0,
        lossy: true,
    };

    /// Its value at s.
    pub fn at(self, s: Complex) -> Complex {
        let power = (0..self.power).fold(Complex::new(1.0, 0.0), |z, _| z * s);
        let sign = if s.im == 0.0 { 0.0 } else { s.im.signum() };
        if self.lossy {
            power * Complex::new(0.0, sign)
        } else {
            power
        }
    }
}

/// Columns or rows with their factors.
pub(super) type Terms = Vec<(Factor, usize)>;

/// A machine between its inputs and outputs.
pub struct System {
    /// Over r.
    pub(super) equations: Equations,
    /// The first coordinates are so many motions that strain nothing.
    pub(super) rigid: usize,
    /// Of these so many that no damper resists either.
    pub(super) undamped_rigid: usize,
    /// Columns b.
    pub(super) loads: Matrix,
    /// Rows c.
    pub(super) reads: Matrix,
    /// Of every input.
    pub(super) inputs: Vec<Terms>,
    /// Of every output.
    pub(super) outputs: Vec<Terms>,
    /// d of every output and input.
    pub(super) through: Vec<Vec<Vec<(Factor, f64)>>>,
    /// Names of the outputs, for messages.
    pub(super) names: Vec<String>,
}

impl System {
    /// Over single coordinates: what is solved line by line.
    ///
    /// # Errors
    /// Prescribed motions that exclude each other; a displacement imposed where nothing carries it; those of the modes where
    /// modal damping needs them.
    pub fn plain(setting: &Setting, ports: &Ports) -> Result<System, Error> {
        let coordinates = coordinates(setting, ports)?;
        let transform = coordinates.plain();
        let rigid = (coordinates.rigid.len(), coordinates.still.n_undamped_rigid);
        System::over(setting, ports, &coordinates, transform, rigid)
    }

    /// Over the undamped modes of the machine with what is prescribed held still; and these modes.
    ///
    /// # Errors
    /// Those of [`System::plain`] and of the modes.
    pub fn modal(setting: &Setting, ports: &Ports) -> Result<(System, Basis), Error> {
        let coordinates = coordinates(setting, ports)?;
        let basis = basis::solve(&coordinates.still, Solver::Factored)?;
        let transform = coordinates.modal(&basis);
        let rigid = (basis.n_rigid, coordinates.still.n_undamped_rigid);
        Ok((
            System::over(setting, ports, &coordinates, transform, rigid)?,
            basis,
        ))
    }

    /// How many coordinates are solved for.
    pub fn len(&self) -> usize {
        self.equations.len()
    }

    /// Nothing is free to move.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Motions that strain nothing while what is prescribed holds still.
    pub fn n_rigid(&self) -> usize {
        self.rigid
    }

    fn over(
        setting: &Setting,
        ports: &Ports,
        coordinates: &Coordinates,
        transform: Matrix,
        (rigid, undamped_rigid): (usize, usize),
    ) -> Result<System, Error> {
        let modal = setting
            .machine
            .damping
            .modal
            .iter()
            .any(|&zeta| zeta != 0.0);
        let shapes = match modal {
            true => coordinates.shapes(
                &basis::solve(setting.linear, Solver::Factored)?,
                setting.linear,
            ),
            false => Basis {
                omega: Vec::new(),
                n_rigid: 0,
                shapes: Matrix::zeros(coordinates.linear.n, 0),
                digits: Vec::new(),
                solver: Solver::Factored,
            },
        };
        let case = Case {
            machine: &coordinates.machine,
            linear: &coordinates.linear,
            basis: &shapes,
            speeds: setting.speeds,
        };
        let all = Equations::over(&case, transform, Vec::new(), rigid);
        let n = all.len() - coordinates.held.len();
        let builder = Builder {
            machine: setting.machine,
            coordinates,
            beta: setting.machine.damping.stiffness,
            all: &all,
            n,
        };
        let inputs = ports
            .inputs
            .iter()
            .map(|port| builder.input(port.what))
            .collect::<Result<Vec<_>, _>>()?;
        let (mut loads, mut input_terms) = (Vec::new(), Vec::new());
        for input in &inputs {
            let terms = input
                .force
                .iter()
                .map(|(factor, f)| (*factor, f[..n].to_vec()));
            input_terms.push(gathered(
                &mut loads,
                terms.chain(builder.prescribed(&input.held)),
            ));
        }
        let (mut reads, mut output_terms, mut through) = (Vec::new(), Vec::new(), Vec::new());
        for port in &ports.outputs {
            let read = builder.output(&port.what);
            through.push(
                inputs
                    .iter()
                    .map(|input| builder.through(&read, input))
                    .collect(),
            );
            let rows = read
                .rows
                .iter()
                .map(|(factor, c)| (*factor, c[..n].to_vec()));
            output_terms.push(gathered(&mut reads, rows));
        }
        let loads = Matrix::from_fn(n, loads.len(), |i, j| loads[j][i]);
        let reads = Matrix::from_fn(reads.len(), n, |i, j| reads[i][j]);
        let cut = |a: &Matrix| Matrix::from_fn(n, n, |i, j| a[(i, j)]);
        let equations = Equations {
            mass: cut(&all.mass),
            damping: cut(&all.damping),
            stiffness: cut(&all.stiffness),
            hysteretic: all.hysteretic.as_ref().map(cut),
            massless: all.massless.iter().copied().filter(|&j| j < n).collect(),
            names: (0..n).map(|j| format!("{}", j + 1)).collect(),
            transform: Matrix::from_fn(all.transform.nrows(), n, |i, j| all.transform[(i, j)]),
        };
        Ok(System {
            equations,
            rigid,
            undamped_rigid,
            loads,
            reads,
            inputs: input_terms,
            outputs: output_terms,
            through,
            names: ports.outputs.iter().map(|port| port.name.clone()).collect(),
        })
    }
}

fn coordinates(setting: &Setting, ports: &Ports) -> Result<Coordinates, Error> {
    let origin = Origin {
        machine: setting.machine,
        operating: setting.operating,
        linear: setting.linear,
    };
    Coordinates::new(&origin, ports)
}

/// Vectors put among the others, those without an entry left out; their factors and numbers.
fn gathered(all: &mut Vec<Vec<f64>>, terms: impl Iterator<Item = (Factor, Vec<f64>)>) -> Terms {
    let mut own: Vec<(Factor, Vec<f64>)> = Vec::new();
    for (factor, vector) in terms {
        match own.iter_mut().find(|t| t.0 == factor) {
            Some((_, sum)) => sum.iter_mut().zip(&vector).for_each(|(s, v)| *s += v),
            None => own.push((factor, vector)),
        }
    }
    own.retain(|(_, vector)| vector.iter().any(|&x| x != 0.0));
    let mut put = |vector: Vec<f64>| match all.iter().position(|known| *known == vector) {
        Some(at) => at,
        None => {
            all.push(vector);
            all.len() - 1
        }
    };
    own.into_iter()
        .map(|(factor, vector)| (factor, put(vector)))
        .collect()
}

/// What an input does.
struct Driven {
    /// Forces over all coordinates, prescribed ones too.
    force: Vec<(Factor, Vec<f64>)>,
    /// h per unit of input.
    held: Vec<f64>,
    /// e per unit of input: number of a branch in the machine, and its displacement.
    imposed: Vec<(usize, f64)>,
}

/// What an output sees.
struct Seen {
    /// Rows over all coordinates.
    rows: Vec<(Factor, Vec<f64>)>,
    /// Of a branch: what its own imposed displacement takes off.
    own: Vec<(usize, Factor, f64)>,
    /// Of a joint: forces that act along its own motion count with this sign.
    along: Option<usize>,
}

struct Builder<'a> {
    machine: &'a Machine,
    coordinates: &'a Coordinates,
    beta: f64,
    all: &'a Equations,
    n: usize,
}

impl Builder<'_> {
    fn held(&self, what: Held) -> usize {
        let held = &self.coordinates.held;
        held.iter().position(|h| *h == what).unwrap_or(held.len())
    }

    fn branch(&self, index: usize) -> Option<&LinearBranch> {
        self.coordinates
            .linear
            .branches
            .iter()
            .find(|b| b.index == index)
    }

    /// `k + s (c + βk) + iηk`.
    fn law(&self, branch: &LinearBranch) -> [(Factor, f64); 3] {
        [
            (Factor::ONE, branch.stiffness),
            (Factor::S, branch.damping + self.beta * branch.stiffness),
            (Factor::LOSSY, branch.loss_factor * branch.stiffness),
        ]
    }

    fn sees(&self, freedom: usize) -> Vec<f64> {
        self.all.sees(&self.coordinates.linear.transform[freedom])
    }

    fn input(&self, input: Input) -> Result<Driven, Error> {
        let mut driven = Driven {
            force: Vec::new(),
            held: vec![0.0; self.coordinates.held.len()],
            imposed: Vec::new(),
        };
        match input {
            Input::Torque(freedom) => driven.force.push((Factor::ONE, self.sees(freedom))),
            Input::Motion(freedom) => driven.held[self.held(Held::Freedom(freedom))] = 1.0,
            Input::Displacement(branch) if self.machine.branches[branch].law == Law::Rigid => {
                driven.held[self.held(Held::Joint(branch))] = 1.0;
            }
            Input::Displacement(branch) => driven.imposed.push((branch, 1.0)),
            Input::Base(axis) => driven.imposed = self.base(axis)?,
        }
        for &(index, e) in &driven.imposed {
            let Some(branch) = self.branch(index) else {
                let name = self.machine.branch_name(index);
                let message = format!(
                    "a displacement imposed in `{name}` moves nothing: it is open at the operating point, or both its ends move as one"
                );
                return Err(Error::new(Code::Conflict, message)
                    .hint("state the torques in [[load]] that close it"));
            };
            let acts: Vec<(usize, f64)> = branch.acts().scaled().collect();
            let acts = self.all.sees(&acts);
            for (factor, value) in self.law(branch) {
                driven
                    .force
                    .push((factor, acts.iter().map(|u| value * e * u).collect()));
            }
        }
        Ok(driven)
    }

    /// Displacements of the branches that end at the ground, per unit of its motion: what its motion takes from their δ.
    fn base(&self, axis: Axis) -> Result<Vec<(usize, f64)>, Error> {
        let mut imposed = Vec::new();
        for (index, branch) in self.machine.branches.iter().enumerate() {
            let along = branch
                .direction
                .terms
                .iter()
                .filter(|t| self.machine.freedoms[t.0].axis == axis);
            let sum: f64 = branch.direction.scale * along.clone().map(|t| t.1).sum::<f64>();
            let size: f64 =
                branch.direction.scale.abs() * along.clone().map(|t| t.1.abs()).sum::<f64>();
            // Of its terms: what a body's motion takes and another's gives back cancels to rounding.
            let grounded = sum.abs() > 1e-12 * size;
            let turning = axis == Axis::Theta
                && (branch.direction.terms.len() != 1 || branch.direction.scale != 1.0);
            if !grounded || turning {
                continue;
            }
            if branch.law == Law::Rigid {
                let message = format!(
                    "`{}` holds a body rigidly to the ground, which is to move along {}",
                    self.machine.branch_name(index),
                    axis.name()
                );
                return Err(Error::new(Code::Conflict, message).hint("give it a stiffness k"));
            }
            if self.branch(index).is_some() {
                imposed.push((index, sum));
            }
        }
        if imposed.is_empty() {
            let message = format!(
                "nothing of this machine is joined to the ground along {}",
                axis.name()
            );
            return Err(Error::new(Code::Conflict, message)
                .hint("a bearing, or a shaft to \"ground\", joins it"));
        }
        Ok(imposed)
    }

    /// `−D_rh h`.
    fn prescribed(&self, held: &[f64]) -> Vec<(Factor, Vec<f64>)> {
        if held.iter().all(|&h| h == 0.0) {
            return Vec::new();
        }
        let column = |a: &Matrix| -> Vec<f64> {
            (0..self.n)
                .map(|i| {
                    -held
                        .iter()
                        .enumerate()
                        .map(|(k, h)| a[(i, self.n + k)] * h)
                        .sum::<f64>()
                })
                .collect()
        };
        self.matrices()
            .map(|(factor, a)| (factor, column(a)))
            .collect()
    }

    fn matrices(&self) -> impl Iterator<Item = (Factor, &Matrix)> {
        let lossy = self.all.hysteretic.iter().map(|h| (Factor::LOSSY, h));
        [
            (Factor::ONE, &self.all.stiffness),
            (Factor::S, &self.all.damping),
            (Factor::SS, &self.all.mass),
        ]
        .into_iter()
        .chain(lossy)
    }

    fn output(&self, output: &Output) -> Seen {
        let mut seen = Seen {
            rows: Vec::new(),
            own: Vec::new(),
            along: None,
        };
        match output {
            Output::Sum(terms, times) => {
                let mut row = vec![0.0; self.all.len()];
                for &(freedom, factor) in terms {
                    row.iter_mut()
                        .zip(self.sees(freedom))
                        .for_each(|(r, c)| *r += factor * c);
                }
                let factor = Factor {
                    power: *times,
                    lossy: false,
                };
                seen.rows.push((factor, row));
            }
            &Output::Force(index) if self.machine.branches[index].law == Law::Rigid => {
                let at = self.n + self.held(Held::Joint(index));
                seen.along = Some(at);
                let row = |a: &Matrix| (0..self.all.len()).map(|j| -a[(at, j)]).collect();
                seen.rows
                    .extend(self.matrices().map(|(factor, a)| (factor, row(a))));
            }
            &Output::Force(index) => self.add(&mut seen, index, 1.0, true),
            Output::Forces(all) => {
                (all.iter()).for_each(|&(index, share)| self.add(&mut seen, index, share, true))
            }
            &Output::Deflection(index) => self.add(&mut seen, index, 1.0, false),
        }
        seen
    }

    /// Adds the force of a branch, or its deformation, times a factor.
    fn add(&self, seen: &mut Seen, index: usize, share: f64, force: bool) {
        let Some(branch) = self.branch(index) else {
            return; // Open, or between what moves as one.
        };
        let w: Vec<(usize, f64)> = branch.direction.scaled().collect();
        let mut along = self.all.sees(&w);
        along
            .iter_mut()
            .take(self.still(branch))
            .for_each(|x| *x = 0.0);
        let law = match force {
            true => self.law(branch).to_vec(),
            false => vec![(Factor::ONE, 1.0)],
        };
        for (factor, value) in law {
            let value = share * value;
            seen.rows
                .push((factor, along.iter().map(|w| value * w).collect()));
            seen.own.push((index, factor, value));
        }
    }

    /// Coordinates that leave a branch exactly as it is.
    fn still(&self, branch: &LinearBranch) -> usize {
        let still = &self.coordinates.still;
        if branch.stiffness != 0.0 {
            still.rigid.len()
        } else {
            still.n_undamped_rigid
        }
    }

    fn through(&self, seen: &Seen, input: &Driven) -> Vec<(Factor, f64)> {
        let mut all: Vec<(Factor, f64)> = Vec::new();
        for (factor, row) in &seen.rows {
            let moved: f64 = input
                .held
                .iter()
                .enumerate()
                .map(|(k, h)| row[self.n + k] * h)
                .sum();
            all.push((*factor, moved));
        }
        for &(index, factor, value) in &seen.own {
            let e: f64 = input
                .imposed
                .iter()
                .filter(|i| i.0 == index)
                .map(|i| i.1)
                .sum();
            all.push((factor, -value * e));
        }
        if let Some(at) = seen.along {
            all.extend(input.force.iter().map(|(factor, f)| (*factor, f[at])));
        }
        all.retain(|term| term.1 != 0.0);
        all
    }
}
