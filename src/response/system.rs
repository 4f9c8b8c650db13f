//! Equations between inputs and outputs: `D(s) x = b(s) u`, `y = c(s) x + d(s) u`, `D = s² M + s C + K + i sgn(Im s) H`.
//!
//! b, c and d are sums of real columns and rows with the factors 1, s, s² and i sgn(Im s): what is prescribed acts through
//! `−D_rh h`, a branch with an imposed displacement through `u (k + s c + iηk) e`.

use super::columns::{Builder, List, Terms};
use super::coordinates::{Coordinates, Origin};
use super::entries::{Entries, Entry, Sparse, Transform};
use super::factor::Factor;
use super::ports::Ports;
use crate::base::error::Error;
use crate::machine::linear::Linear;
use crate::machine::operating::Operating;
use crate::machine::parts::Machine;
use crate::modes::basis::{self, Basis, Solver};
use crate::modes::equations::{Case, Equations};
use crate::numeric::{Complex, ComplexMatrix, Matrix};

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

/// What stands on both sides of `D(s)`.
pub struct System {
    /// How many coordinates are solved for.
    n: usize,
    /// The first coordinates are so many motions that strain nothing.
    pub(super) rigid: usize,
    /// Of these so many that no damper resists either.
    pub(super) undamped_rigid: usize,
    /// Columns b.
    pub(super) loads: Vec<Sparse>,
    /// Rows c.
    pub(super) reads: Vec<Sparse>,
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
    /// Over single coordinates, with D entry by entry: what is solved line by line.
    ///
    /// # Errors
    /// Prescribed motions that exclude each other; a displacement imposed where nothing carries it; those of the modes where
    /// modal damping needs them.
    pub(super) fn plain(setting: &Setting, ports: &Ports) -> Result<(System, Entries), Error> {
        let coordinates = coordinates(setting, ports)?;
        let transform = Transform::of_columns(coordinates.linear.n, &coordinates.plain());
        let rigid = (coordinates.rigid.len(), coordinates.still.n_undamped_rigid);
        let all = match damped_modes(setting, &coordinates)? {
            Some(shapes) => {
                let case = case(setting, &coordinates, &shapes);
                let full = Equations::over(&case, transform.matrix(), Vec::new(), rigid.0);
                Entries::of(&full)
            }
            None => {
                let none = Basis::none(coordinates.linear.n);
                Entries::over(&case(setting, &coordinates, &none), &transform, rigid.0)
            }
        };
        let (own, beside) = all.split(transform.columns() - coordinates.held.len());
        let system = System::over(setting, ports, &coordinates, (&transform, &beside), rigid)?;
        Ok((system, own))
    }

    /// Over the undamped modes of the machine with what is prescribed held still; the dense equations of these, and the modes.
    ///
    /// # Errors
    /// Those of [`System::plain`] and of the modes.
    pub(super) fn modal(
        setting: &Setting,
        ports: &Ports,
    ) -> Result<(System, Equations, Basis), Error> {
        let coordinates = coordinates(setting, ports)?;
        let basis = basis::solve(&coordinates.still, Solver::Factored)?;
        let matrix = coordinates.modal(&basis);
        let transform = Transform::of_matrix(&matrix);
        let rigid = (basis.n_rigid, coordinates.still.n_undamped_rigid);
        let shapes = damped_modes(setting, &coordinates)?;
        let shapes = shapes.unwrap_or_else(|| Basis::none(coordinates.linear.n));
        let case = case(setting, &coordinates, &shapes);
        let all = Equations::over(&case, matrix, Vec::new(), rigid.0);
        let n = all.len() - coordinates.held.len();
        let beside = match coordinates.held.is_empty() {
            true => Vec::new(),
            false => Entries::of(&all).split(n).1,
        };
        let system = System::over(setting, ports, &coordinates, (&transform, &beside), rigid)?;
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
        Ok((system, equations, basis))
    }

    /// How many coordinates are solved for.
    pub fn len(&self) -> usize {
        self.n
    }

    /// Nothing is free to move.
    pub fn is_empty(&self) -> bool {
        self.n == 0
    }

    /// Motions that strain nothing while what is prescribed holds still.
    pub fn n_rigid(&self) -> usize {
        self.rigid
    }

    fn over(
        setting: &Setting,
        ports: &Ports,
        coordinates: &Coordinates,
        (transform, beside): (&Transform, &[Entry]),
        (rigid, undamped_rigid): (usize, usize),
    ) -> Result<System, Error> {
        let n = transform.columns() - coordinates.held.len();
        let builder = Builder {
            machine: setting.machine,
            coordinates,
            beta: setting.machine.damping.stiffness,
            transform,
            beside,
            n,
        };
        let inputs = ports
            .inputs
            .iter()
            .map(|port| builder.input(port.what))
            .collect::<Result<Vec<_>, _>>()?;
        let cut = |(factor, all): &(Factor, Sparse)| {
            let own = all.iter().copied().filter(|term| term.0 < n);
            (*factor, own.collect::<Sparse>())
        };
        let (mut loads, mut reads) = (List::default(), List::default());
        let input_terms = inputs.iter().map(|input| {
            let own = input.force.iter().map(cut);
            loads.put(own.chain(builder.prescribed(&input.held)))
        });
        let input_terms = input_terms.collect();
        let (mut output_terms, mut through) = (Vec::new(), Vec::new());
        for port in &ports.outputs {
            let read = builder.output(&port.what);
            let direct = inputs.iter().map(|input| builder.through(&read, input));
            through.push(direct.collect());
            output_terms.push(reads.put(read.rows.iter().map(cut)));
        }
        Ok(System {
            n,
            rigid,
            undamped_rigid,
            loads: loads.all,
            reads: reads.all,
            inputs: input_terms,
            outputs: output_terms,
            through,
            names: ports.outputs.iter().map(|port| port.name.clone()).collect(),
        })
    }

    /// Columns b.
    pub(super) fn load_columns(&self) -> Matrix {
        let mut all = Matrix::zeros(self.n, self.loads.len());
        for (j, load) in self.loads.iter().enumerate() {
            load.iter().for_each(|&(i, b)| all[(i, j)] = b);
        }
        all
    }

    /// Rows c.
    pub(super) fn read_rows(&self) -> Matrix {
        let mut all = Matrix::zeros(self.reads.len(), self.n);
        for (i, read) in self.reads.iter().enumerate() {
            read.iter().for_each(|&(j, c)| all[(i, j)] = c);
        }
        all
    }

    /// `Σ φ_c φ_b g(c, b) + d`, outputs by inputs, from `g = c D⁻¹ b` of every row and column.
    pub(super) fn joined(&self, s: Complex, g: impl Fn(usize, usize) -> Complex) -> ComplexMatrix {
        ComplexMatrix::from_fn(self.outputs.len(), self.inputs.len(), |o, i| {
            let mut sum = Complex::ZERO;
            for &(read, row) in &self.outputs[o] {
                for &(load, column) in &self.inputs[i] {
                    sum += read.at(s) * load.at(s) * g(row, column);
                }
            }
            self.through[o][i]
                .iter()
                .fold(sum, |sum, &(factor, value)| sum + factor.at(s) * value)
        })
    }
}

/// Undamped natural frequencies with what is prescribed held still, rad/s, rising.
///
/// # Errors
/// Prescribed motions that exclude each other; those of the modes.
pub fn held_frequencies(
    setting: &Setting,
    ports: &Ports,
    solver: Solver,
) -> Result<Vec<f64>, Error> {
    let coordinates = coordinates(setting, ports)?;
    Ok(basis::solve(&coordinates.still, solver)?.omega)
}

fn coordinates(setting: &Setting, ports: &Ports) -> Result<Coordinates, Error> {
    let origin = Origin {
        machine: setting.machine,
        operating: setting.operating,
        linear: setting.linear,
    };
    Coordinates::new(&origin, ports)
}

/// The equations that are to be summed; modal damping refers to `shapes`.
fn case<'a>(setting: &Setting<'a>, coordinates: &'a Coordinates, shapes: &'a Basis) -> Case<'a> {
    Case {
        machine: &coordinates.machine,
        linear: &coordinates.linear,
        basis: shapes,
        speeds: setting.speeds,
    }
}

/// The modes that modal damping refers to; nothing where there is none.
fn damped_modes(setting: &Setting, coordinates: &Coordinates) -> Result<Option<Basis>, Error> {
    if !setting.machine.damping.is_modal() {
        return Ok(None);
    }
    let own = basis::solve(setting.linear, Solver::Factored)?;
    Ok(Some(coordinates.shapes(&own, setting.linear)))
}
