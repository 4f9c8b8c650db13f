//! Machine builder: registers nodes and axes, numbers the dofs, then takes masses and branches.

use std::collections::{BTreeSet, HashMap};

use super::components::{Branch, BranchLaw, Dof, Element, Machine, Mass, Node};
use super::direction::Direction;
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::scene::model::{Axis, BranchDamping, BranchEnd, ContactParameters, MeshFlanks, Name};

/// Collects a machine. Degrees of freedom are numbered once, when every node and axis is known.
#[derive(Default)]
pub struct MachineBuilder {
    /// The machine so far.
    pub machine: Machine,
    nodes: HashMap<String, usize>,
    axes: Vec<BTreeSet<Axis>>,
    numbers: HashMap<(usize, Axis), usize>,
    /// Flanks computed from gear files, by branch.
    pub mesh_flanks: Vec<(usize, MeshFlanks)>,
}

impl MachineBuilder {
    /// Registers an element; its number.
    pub fn element(&mut self, name: &Name, kind: &'static str) -> usize {
        self.machine.elements.push(Element {
            name: name.text.clone(),
            kind,
            span: name.span.clone(),
        });
        self.machine.elements.len() - 1
    }

    /// Adds a node with its rotation.
    pub fn node(&mut self, name: &str, element: usize) {
        self.nodes
            .insert(name.to_string(), self.machine.nodes.len());
        self.machine.nodes.push(Node {
            name: name.to_string(),
            element,
        });
        self.axes.push(BTreeSet::from([Axis::Theta]));
    }

    /// Adds a node that moves along z alone.
    pub fn slide(&mut self, name: &str, element: usize) {
        self.node(name, element);
        self.axes[self.nodes[name]] = BTreeSet::from([Axis::Z]);
    }

    /// Gives a node one more axis.
    pub fn axis(&mut self, node: &Name, axis: Axis) -> Result<(), Error> {
        let at = self.find(node)?;
        if !self.axes[at].contains(&Axis::Theta) && axis != Axis::Z {
            let message = format!(
                "`{}` slides along z and has no axis {}",
                node.text,
                axis.name()
            );
            return Err(Error::new(Code::Conflict, message).with_span(&node.span).with_hint(
                "give a slide `k_z` and `c_z` only; declare a body with other axes as [[inertia]]",
            ));
        }
        self.axes[at].insert(axis);
        Ok(())
    }

    /// Numbers the degrees of freedom, node by node.
    pub fn number_dofs(&mut self) {
        for (node, axes) in self.axes.iter().enumerate() {
            for &axis in axes {
                self.numbers.insert((node, axis), self.machine.dofs.len());
                self.machine.dofs.push(Dof { node, axis });
            }
        }
    }

    /// The rotation of a node.
    pub fn theta(&self, node: &Name) -> Result<usize, Error> {
        let at = self.find(node)?;
        self.numbers.get(&(at, Axis::Theta)).copied().ok_or_else(|| {
            let message = format!("`{}` slides and does not turn", node.text);
            Error::new(Code::Conflict, message)
                .with_span(&node.span)
                .with_hint("move it by a [[screw]], support it by `k_z` and `c_z` of a [[bearing]], load it by `force` of a [[load]]")
        })
    }

    /// The rotation of an end, or `None` where it is ground.
    pub fn rotation_of_end(&self, end: &BranchEnd) -> Result<Option<usize>, Error> {
        match end {
            BranchEnd::Ground => Ok(None),
            BranchEnd::Node(node) => self.theta(node).map(Some),
        }
    }

    /// A degree of freedom, where the node has that axis.
    pub fn dof(&self, node: &Name, axis: Axis) -> Result<Option<usize>, Error> {
        Ok(self.numbers.get(&(self.find(node)?, axis)).copied())
    }

    /// A node by its name alone, for nodes that elements made.
    pub fn dof_by_name(&self, node: &str, axis: Axis) -> Option<usize> {
        self.numbers.get(&(*self.nodes.get(node)?, axis)).copied()
    }

    /// A mass on one degree of freedom; zero is left out.
    pub fn mass(&mut self, element: usize, dof: usize, value: f64) {
        self.mass_along(element, Direction::unit(dof), value);
    }

    /// A mass along a direction; zero is left out.
    pub fn mass_along(&mut self, element: usize, direction: Direction, value: f64) {
        if value != 0.0 {
            self.machine.masses.push(Mass {
                element,
                value,
                direction,
            });
        }
    }

    /// A branch without play whose force acts along its direction.
    pub fn branch(
        &mut self,
        element: usize,
        part: Option<String>,
        direction: Direction,
        law: BranchLaw,
    ) {
        self.machine.branches.push(Branch {
            element,
            part,
            direction,
            coast: None,
            force: None,
            law,
            backlash: 0.0,
            contact_damping: None,
            stiffness_variation: None,
            characteristic: None,
            mesh_springs: None,
        });
    }

    /// A branch made by tooth contact; `coast` where the other flank's direction differs.
    pub fn contact(
        &mut self,
        element: usize,
        part: Option<String>,
        drive: Direction,
        coast: Option<Direction>,
        contact: &ContactParameters,
    ) {
        let law = branch_law(contact.stiffness, contact.loss);
        let branch = Branch {
            element,
            part,
            direction: drive,
            coast,
            force: None,
            law,
            backlash: contact.backlash,
            contact_damping: contact.damping_model,
            stiffness_variation: contact.wave.clone(),
            characteristic: contact.characteristic.clone(),
            mesh_springs: (contact.flanks.as_ref()).and_then(|flanks| flanks.springs.clone()),
        };
        if let Some(flanks) = &contact.flanks {
            let branch = self.machine.branches.len();
            self.mesh_flanks.push((branch, flanks.clone()));
        }
        self.machine.branches.push(branch);
    }

    /// Adds a diagnostic for the reader of a result.
    pub fn add_diagnostic(&mut self, code: &'static str, message: String) {
        self.machine.diagnostics.push(Diagnostic {
            code,
            message,
            hint: None,
        });
    }

    fn find(&self, node: &Name) -> Result<usize, Error> {
        self.nodes.get(&node.text).copied().ok_or_else(|| {
            Error::new(
                Code::UnknownNode,
                format!("there is no node `{}`", node.text),
            )
            .with_span(&node.span)
        })
    }
}

/// `e₂ − e₁` of two rotations, ground left out: positive when end 2 is ahead.
pub fn relative_rotation(ends: [Option<usize>; 2]) -> Direction {
    let [first, second] = ends;
    Direction::new(
        1.0,
        first
            .map(|i| (i, -1.0))
            .into_iter()
            .chain(second.map(|j| (j, 1.0))),
    )
}

/// Elastic where a stiffness is given, rigid where not.
pub fn branch_law(stiffness: Option<f64>, loss: BranchDamping) -> BranchLaw {
    stiffness.map_or(BranchLaw::Rigid, |stiffness| BranchLaw::Linear {
        stiffness,
        loss,
    })
}
