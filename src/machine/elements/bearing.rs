//! Bearing element: `F_row = k_row,col (u₁ − u₂)_col + c_row,col (u̇₁ − u̇₂)_col` over the axes it joins.
//!
//! A symmetric positive semidefinite matrix is split `A = Σ d l lᵀ` (LDLᵀ factorisation) into one branch per term, so that K stays a sum of
//! squares; an unsymmetric matrix (oil film) becomes branches whose force acts along another direction than their deformation.

use std::collections::BTreeMap;

use super::friction;
use crate::base::error::Error;
use crate::machine::builder::MachineBuilder;
use crate::machine::components::{Branch, BranchLaw, Support};
use crate::machine::direction::Direction;
use crate::scene::model::{Axis, Bearing, BranchDamping, BranchEnd};

/// Axes with a stiffness or damping term, in row or column; the nodes of the bearing need these.
pub fn axes(bearing: &Bearing) -> Vec<Axis> {
    let mut axes: Vec<Axis> = bearing
        .stiffness
        .iter()
        .chain(&bearing.damping)
        .flat_map(|&(row, column, _)| [row, column])
        .collect();
    axes.sort();
    axes.dedup();
    axes
}

/// Adds the branches, supports and friction of a bearing to the machine.
pub fn add(builder: &mut MachineBuilder, element: usize, bearing: &Bearing) -> Result<(), Error> {
    let displacements = axes(bearing)
        .into_iter()
        .map(|axis| {
            Ok((
                axis,
                relative_displacement(builder, &bearing.between, axis)?,
            ))
        })
        .collect::<Result<BTreeMap<Axis, Direction>, Error>>()?;
    let mut forces: BTreeMap<Axis, Vec<(usize, f64)>> = BTreeMap::new();
    let mut add_branches = |entries: &[(Axis, Axis, f64)], law: &dyn Fn(f64) -> BranchLaw| {
        for term in matrix_terms(entries) {
            let index = builder.machine.branches.len();
            match &term.force {
                Some(row) => forces.entry(*row).or_default().push((index, 1.0)),
                None => (term.deformation.iter())
                    .for_each(|&(axis, a)| forces.entry(axis).or_default().push((index, a))),
            }
            let combine = |weights: &[(Axis, f64)]| {
                let terms = weights.iter().flat_map(|&(axis, a)| {
                    displacements[&axis].entries().map(move |(i, x)| (i, a * x))
                });
                Direction::new(1.0, terms)
            };
            let direction = combine(&term.deformation);
            let force = term.force.as_ref().map(|row| combine(&[(*row, 1.0)]));
            let part = Some(term.part.clone());
            let law = law(term.value);
            builder.machine.branches.push(Branch {
                element,
                part,
                direction,
                coast: None,
                force,
                law,
                backlash: 0.0,
                contact_damping: None,
                stiffness_variation: None,
                mesh_springs: None,
                characteristic: None,
            });
        }
    };
    add_branches(&bearing.stiffness, &|stiffness| BranchLaw::Linear {
        stiffness,
        loss: bearing.loss,
    });
    add_branches(&bearing.damping, &|c| BranchLaw::Linear {
        stiffness: 0.0,
        loss: BranchDamping::Viscous(c),
    });
    for (axis, deflection) in displacements {
        let forces = forces.remove(&axis).unwrap_or_default();
        builder.machine.supports.push(Support {
            element,
            axis,
            deflection,
            forces,
        });
    }
    match &bearing.friction {
        Some(friction) => friction::add_bearing_friction(builder, element, bearing, friction),
        None => Ok(()),
    }
}

/// Relative displacement `u₁ − u₂` along one axis.
fn relative_displacement(
    builder: &MachineBuilder,
    ends: &[BranchEnd; 2],
    axis: Axis,
) -> Result<Direction, Error> {
    let mut terms = Vec::new();
    for (end, sign) in ends.iter().zip([1.0, -1.0]) {
        if let BranchEnd::Node(node) = end {
            terms.extend(builder.dof(node, axis)?.map(|dof| (dof, sign)));
        }
    }
    Ok(Direction::new(1.0, terms))
}

/// Term of a stiffness or damping matrix.
struct MatrixTerm {
    part: String,
    value: f64,
    deformation: Vec<(Axis, f64)>,
    force: Option<Axis>,
}

/// Splits a matrix into rank-one terms if it is symmetric and positive semidefinite, else into its entries.
fn matrix_terms(entries: &[(Axis, Axis, f64)]) -> Vec<MatrixTerm> {
    let value = |row: Axis, column: Axis| -> f64 {
        entries
            .iter()
            .filter(|e| (e.0, e.1) == (row, column))
            .map(|e| e.2)
            .sum()
    };
    rank_one_terms(entries, &value).unwrap_or_else(|| {
        let entry = |&(row, column, value): &(Axis, Axis, f64)| MatrixTerm {
            part: if row == column {
                row.name().to_string()
            } else {
                format!("{} from {}", row.name(), column.name())
            },
            value,
            deformation: vec![(column, 1.0)],
            force: (row != column).then_some(row),
        };
        entries.iter().filter(|e| e.2 != 0.0).map(entry).collect()
    })
}

fn rank_one_terms(
    entries: &[(Axis, Axis, f64)],
    value: &dyn Fn(Axis, Axis) -> f64,
) -> Option<Vec<MatrixTerm>> {
    if entries
        .iter()
        .any(|&(row, column, _)| value(row, column) != value(column, row))
    {
        return None;
    }
    let mut axes: Vec<Axis> = entries.iter().flat_map(|e| [e.0, e.1]).collect();
    axes.sort();
    axes.dedup();
    let mut s: Vec<Vec<f64>> = axes
        .iter()
        .map(|&a| axes.iter().map(|&b| value(a, b)).collect())
        .collect();
    let mut terms = Vec::new();
    for j in 0..axes.len() {
        let pivot = s[j][j];
        let scale = value(axes[j], axes[j]).abs();
        if pivot <= scale * 1e-14 {
            // A zero pivot requires a zero row; otherwise the matrix is indefinite.
            if s[j].iter().skip(j).all(|x| x.abs() <= scale * 1e-14) && pivot >= -scale * 1e-14 {
                continue;
            }
            return None;
        }
        let deformation: Vec<(Axis, f64)> = (j..axes.len())
            .map(|i| (axes[i], s[i][j] / pivot))
            .filter(|t| t.1 != 0.0)
            .collect();
        for a in j + 1..axes.len() {
            for b in j + 1..axes.len() {
                s[a][b] -= s[a][j] * s[j][b] / pivot;
            }
        }
        let part = deformation
            .iter()
            .map(|t| t.0.name())
            .collect::<Vec<_>>()
            .join(" with ");
        terms.push(MatrixTerm {
            part,
            value: pivot,
            deformation,
            force: None,
        });
    }
    Some(terms)
}
