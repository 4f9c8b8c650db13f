//! Coordinates beside motions that are prescribed: `p = T_r r + T_h h`.
//!
//! A held freedom is a row `q_i = h`; a rigid joint with a displacement imposed in it, `wᵀq = e`, is released and becomes such
//! a row. What r is over, the rows leave at zero; column h of T_h moves its own row by one and the others not at all.

use super::entries::{Sparse, gathered};
use super::ports::{Input, Output, Ports};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::machine::direction::Direction;
use crate::machine::kinematics::Kinematics;
use crate::machine::linear::{Linear, LinearBranch};
use crate::machine::operating::Operating;
use crate::machine::parts::{Branch, Law, Machine};
use crate::modes::basis::{Basis, column};
use crate::numeric::Matrix;
use crate::scene::model::Loss;

/// What a prescribed motion is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Held {
    Freedom(usize),
    Joint(usize),
}

/// A machine with some motions prescribed.
pub(super) struct Coordinates {
    /// The machine with the joints released that a displacement is imposed in.
    pub machine: Machine,
    /// The same, linear; its coordinates are p.
    pub linear: Linear,
    /// The machine with everything held still.
    pub still: Linear,
    /// What is prescribed.
    pub held: Vec<Held>,
    /// Motions that strain nothing with everything held still, over p.
    pub rigid: Vec<Vec<f64>>,
    rows: Rows,
}

/// What the coordinates are found from.
pub(super) struct Origin<'a> {
    pub machine: &'a Machine,
    pub operating: &'a Operating,
    pub linear: &'a Linear,
}

impl Coordinates {
    pub fn new(from: &Origin, ports: &Ports) -> Result<Coordinates, Error> {
        let held = held(from.machine, ports);
        let (mut machine, mut tied) = (from.machine.clone(), from.machine.clone());
        for what in &held {
            match *what {
                // A stiffness so that nothing hangs loose meanwhile; it is taken out below.
                Held::Joint(branch) => {
                    machine.branches[branch].law = Law::Linear {
                        stiffness: 1.0,
                        loss: Loss::None,
                    }
                }
                Held::Freedom(freedom) => tied.branches.push(Branch {
                    element: tied.nodes[tied.freedoms[freedom].node].element,
                    part: None,
                    direction: Direction::of(freedom),
                    coast: None,
                    force: None,
                    law: Law::Rigid,
                    play: 0.0,
                    losses: None,
                    wave: None,
                    characteristic: None,
                }),
            }
        }
        let joints = held.iter().any(|what| matches!(what, Held::Joint(_)));
        let freedoms = held.iter().any(|what| matches!(what, Held::Freedom(_)));
        let again = |machine: &Machine| -> Result<Linear, Error> {
            let mut linear = Linear::new(machine, &Kinematics::new(machine)?, from.operating)?;
            // A damping ratio refers to the masses of the machine as it is.
            for branch in &mut linear.branches {
                let own = from.linear.branch(branch.index);
                branch.damping = own.map_or(branch.damping, |b| b.damping);
            }
            Ok(linear)
        };
        let linear = if joints {
            again(&machine)?
        } else {
            from.linear.clone()
        };
        let still = if freedoms {
            again(&tied)?
        } else {
            from.linear.clone()
        };
        let released = |b: &LinearBranch| held.contains(&Held::Joint(b.index));
        let mut linear = linear;
        linear.branches.retain(|b| !released(b));
        let rows = Rows::new(&machine, &linear, &held)?;
        let rigid = still
            .rigid
            .iter()
            .map(|r| linear.stay(&still.recover(r)))
            .collect();
        Ok(Coordinates {
            machine,
            linear,
            still,
            held,
            rigid,
            rows,
        })
    }

    /// Columns of `[T_r, T_h]` over rigid motions and single coordinates of p.
    pub fn plain(&self) -> Vec<Sparse> {
        let mut taken = self.rows.pivots.clone();
        let mut rigid: Vec<Vec<f64>> = self.rigid.clone();
        for at in 0..rigid.len() {
            let free = (0..self.linear.n).filter(|j| !taken.contains(j));
            let Some(pivot) =
                free.max_by(|&a, &b| rigid[at][a].abs().total_cmp(&rigid[at][b].abs()))
            else {
                continue;
            };
            taken.push(pivot);
            let (done, rest) = rigid.split_at_mut(at + 1);
            for other in rest {
                let factor = other[pivot] / done[at][pivot];
                other
                    .iter_mut()
                    .zip(&done[at])
                    .for_each(|(x, y)| *x -= factor * y);
            }
        }
        let mut free = vec![true; self.linear.n];
        taken.iter().for_each(|&j| free[j] = false);
        let alone = (0..self.linear.n)
            .filter(|&j| free[j])
            .map(|j| self.rows.alone(j));
        let imposed = (0..self.held.len()).map(|h| self.rows.imposed(h));
        let rigid = self.rigid.iter().map(|r| sparse(r.iter().copied()));
        rigid.chain(alone).chain(imposed).collect()
    }

    /// `[T_r, T_h]` over modes of the machine with everything held still, and its coordinates without inertia.
    pub fn modal(&self, basis: &Basis) -> Matrix {
        let over = |p: &[f64]| self.linear.stay(&self.still.recover(p));
        let modes = (0..basis.omega.len()).map(|k| over(&column(&basis.shapes, k)));
        let light = self.still.massless.iter().map(|&j| {
            let mut unit = vec![0.0; self.still.n];
            unit[j] = 1.0;
            over(&unit)
        });
        let imposed = (0..self.held.len()).map(|h| {
            let mut column = vec![0.0; self.linear.n];
            (self.rows.imposed(h).iter()).for_each(|&(j, a)| column[j] = a);
            column
        });
        let columns: Vec<Vec<f64>> = modes.chain(light).chain(imposed).collect();
        Matrix::from_fn(self.linear.n, columns.len(), |i, j| columns[j][i])
    }

    /// Modes of the machine itself over p, for modal damping.
    pub fn shapes(&self, basis: &Basis, linear: &Linear) -> Basis {
        let modes: Vec<Vec<f64>> = (0..basis.omega.len())
            .map(|k| self.linear.stay(&linear.recover(&column(&basis.shapes, k))))
            .collect();
        Basis {
            shapes: Matrix::from_fn(self.linear.n, modes.len(), |i, j| modes[j][i]),
            ..basis.clone()
        }
    }
}

/// What of a column is not zero.
fn sparse(column: impl IntoIterator<Item = f64>) -> Sparse {
    let all = column.into_iter().enumerate();
    all.filter(|term| term.1 != 0.0).collect()
}

/// Held freedoms and joints that an input moves or whose force is measured, each once.
fn held(machine: &Machine, ports: &Ports) -> Vec<Held> {
    let rigid = |branch: usize| machine.branches[branch].law == Law::Rigid;
    let mut all: Vec<Held> = ports
        .held
        .iter()
        .map(|&freedom| Held::Freedom(freedom))
        .collect();
    for input in &ports.inputs {
        match input.what {
            Input::Motion(freedom) => all.push(Held::Freedom(freedom)),
            Input::Displacement(branch) if rigid(branch) => all.push(Held::Joint(branch)),
            _ => {}
        }
    }
    for output in &ports.outputs {
        match output.what {
            Output::Force(branch) if rigid(branch) => all.push(Held::Joint(branch)),
            _ => {}
        }
    }
    let mut once: Vec<Held> = Vec::new();
    all.into_iter().for_each(|what| {
        if !once.contains(&what) {
            once.push(what);
        }
    });
    once
}

/// The rows solved for one coordinate each: `p_pivot = Σ imposed h − Σ others p`.
struct Rows {
    pivots: Vec<usize>,
    others: Vec<Vec<f64>>,
    imposed: Vec<Vec<f64>>,
}

/// Of the size of a row: what is left of one that follows from the others is rounding of whole numbers of teeth.
const FOLLOWS: f64 = 1e-11;

impl Rows {
    fn new(machine: &Machine, linear: &Linear, held: &[Held]) -> Result<Rows, Error> {
        let mut rows = Rows {
            pivots: Vec::new(),
            others: Vec::new(),
            imposed: Vec::new(),
        };
        for (number, what) in held.iter().enumerate() {
            let mut row = vec![0.0; linear.n];
            let direction = match *what {
                Held::Freedom(freedom) => Direction::of(freedom),
                Held::Joint(branch) => machine.branches[branch].direction.clone(),
            };
            for (freedom, a) in direction.scaled() {
                for &(j, b) in &linear.transform[freedom] {
                    row[j] += a * b;
                }
            }
            let size = row.iter().fold(0.0f64, |m, x| m.max(x.abs()));
            let mut share = vec![0.0; held.len()];
            share[number] = 1.0;
            for (at, &pivot) in rows.pivots.iter().enumerate() {
                let factor = row[pivot];
                row.iter_mut()
                    .zip(&rows.others[at])
                    .for_each(|(x, y)| *x -= factor * y);
                share
                    .iter_mut()
                    .zip(&rows.imposed[at])
                    .for_each(|(x, y)| *x -= factor * y);
            }
            let largest = (0..linear.n).max_by(|&a, &b| row[a].abs().total_cmp(&row[b].abs()));
            let Some(pivot) = largest.filter(|&j| row[j].abs() > FOLLOWS * size) else {
                return Err(over_determined(machine, *what));
            };
            let lead = row[pivot];
            row.iter_mut()
                .chain(share.iter_mut())
                .for_each(|x| *x /= lead);
            for at in 0..rows.pivots.len() {
                let factor = rows.others[at][pivot];
                rows.others[at]
                    .iter_mut()
                    .zip(&row)
                    .for_each(|(x, y)| *x -= factor * y);
                rows.imposed[at]
                    .iter_mut()
                    .zip(&share)
                    .for_each(|(x, y)| *x -= factor * y);
            }
            rows.pivots.push(pivot);
            rows.others.push(row);
            rows.imposed.push(share);
        }
        Ok(rows)
    }

    /// Coordinate j moves alone, and what the rows make follow it.
    fn alone(&self, j: usize) -> Sparse {
        let follow = self.pivots.iter().zip(&self.others);
        gathered(std::iter::once((j, 1.0)).chain(follow.map(|(&pivot, row)| (pivot, -row[j]))))
    }

    /// Row h moves by one.
    fn imposed(&self, h: usize) -> Sparse {
        let follow = self.pivots.iter().zip(&self.imposed);
        gathered(follow.map(|(&pivot, share)| (pivot, share[h])))
    }
}

fn over_determined(machine: &Machine, what: Held) -> Error {
    match what {
        Held::Freedom(freedom) => {
            let message = format!(
                "{} cannot be prescribed: rigid joints or another prescribed motion hold it already",
                machine.freedom_name(freedom)
            );
            Error::new(Code::Conflict, message).hint("prescribe one motion of each rigid part")
        }
        Held::Joint(branch) => {
            let message = format!(
                "`{}` closes a rigid loop: neither a displacement in it nor its force is determined",
                machine.branch_name(branch)
            );
            Error::new(Code::Conflict, message).hint("give one joint of the loop a stiffness k")
        }
    }
}
