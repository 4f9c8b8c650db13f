//! Layout of the nodes of a drive train for plots: along the train, branch by branch.

use crate::machine::components::Machine;
use crate::machine::direction::Direction;
use crate::scene::model::Axis;

/// Kind of link between a node and the one before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LinkKind {
    /// Both ends turn alike when it is not strained: a shaft, a coupling.
    Shaft,
    /// Anything else: a mesh, a belt, a planetary stage.
    Mesh,
}

/// A node in its place.
#[derive(Debug, Clone, Copy)]
pub struct LayoutNode {
    /// Rotational degree of freedom.
    pub dof: usize,
    /// Node.
    pub node: usize,
    /// Position along the axis; neighbours are 1 apart, branches more.
    pub x: f64,
    /// The stop it hangs on, and by what.
    pub from: Option<(usize, LinkKind)>,
    /// True for a node at the place of the stop it is attached to.
    pub same_place: bool,
}

/// Additional room before a branch.
const SPACING: f64 = 0.8;

/// Every node that turns, from the first one along the longest way, then what branches off.
pub fn layout_nodes(machine: &Machine) -> Vec<LayoutNode> {
    let joints = joints(machine);
    let mut tree = NodeTree::new(machine, joints);
    let mut stops: Vec<LayoutNode> = Vec::new();
    for root in 0..tree.joints.len() {
        if tree.dof[root].is_some() && !tree.seen[root] {
            tree.depth_first(root);
            tree.place_subtree(root, &mut stops);
        }
    }
    stops
}

/// For every node: its neighbours, in file order.
fn joints(machine: &Machine) -> Vec<Vec<(usize, LinkKind)>> {
    let mut joints = vec![Vec::new(); machine.nodes.len()];
    for branch in &machine.branches {
        let mut nodes: Vec<usize> = turning(machine, &branch.direction).collect();
        nodes.dedup();
        let joint = joint(&branch.direction);
        for (i, &a) in nodes.iter().enumerate() {
            for &b in &nodes[i + 1..] {
                joints[a].push((b, joint));
                joints[b].push((a, joint));
            }
        }
    }
    joints
}

fn turning<'a>(machine: &'a Machine, direction: &'a Direction) -> impl Iterator<Item = usize> + 'a {
    let dofs = direction.terms.iter().map(|t| t.0);
    let shown = dofs.filter(|&f| machine.dofs[f].axis == Axis::Theta || machine.is_slide(f));
    shown.map(|f| machine.dofs[f].node)
}

fn joint(direction: &Direction) -> LinkKind {
    match direction.terms[..] {
        [(_, a), (_, b)] if a == -b => LinkKind::Shaft,
        _ => LinkKind::Mesh,
    }
}

/// A spanning tree of the graph of nodes, grown from one root after the other.
struct NodeTree {
    joints: Vec<Vec<(usize, LinkKind)>>,
    dof: Vec<Option<usize>>,
    seen: Vec<bool>,
    parent: Vec<Option<(usize, LinkKind)>>,
    children: Vec<Vec<usize>>,
    /// Nodes on the longest way down, itself included.
    depth: Vec<usize>,
}

impl NodeTree {
    fn new(machine: &Machine, joints: Vec<Vec<(usize, LinkKind)>>) -> NodeTree {
        let n = joints.len();
        let mut dof = vec![None; n];
        for (i, f) in machine.dofs.iter().enumerate() {
            if f.axis == Axis::Theta || machine.is_slide(i) {
                dof[f.node] = Some(i);
            }
        }
        NodeTree {
            joints,
            dof,
            seen: vec![false; n],
            parent: vec![None; n],
            children: vec![Vec::new(); n],
            depth: vec![1; n],
        }
    }

    /// Depth first, so that a loop is one long way round.
    fn depth_first(&mut self, root: usize) {
        let mut order = vec![root];
        let mut stack = vec![(root, 0)];
        self.seen[root] = true;
        while let Some((node, next)) = stack.pop() {
            let Some(&(other, joint)) = self.joints[node].get(next) else {
                continue;
            };
            stack.push((node, next + 1));
            if !self.seen[other] {
                self.seen[other] = true;
                self.parent[other] = Some((node, joint));
                self.children[node].push(other);
                order.push(other);
                stack.push((other, 0));
            }
        }
        for &node in order.iter().rev() {
            let below = self.children[node].iter().map(|&c| self.depth[c]).max();
            self.depth[node] = 1 + below.unwrap_or(0);
        }
    }

    /// Sets the nodes below a root one after the other, the longest way first.
    fn place_subtree(&self, root: usize, stops: &mut Vec<LayoutNode>) {
        let mut stack: Vec<(usize, Option<usize>)> = vec![(root, None)];
        while let Some((node, from)) = stack.pop() {
            let last = stops.len().checked_sub(1);
            let beside = from.is_some() && from == last;
            let x = match last {
                None => 0.0,
                Some(last) if beside => stops[last].x + 1.0,
                Some(last) => stops[last].x + 1.0 + SPACING,
            };
            let joint = self.parent[node].map_or(LinkKind::Mesh, |(_, joint)| joint);
            let here = stops.len();
            stops.push(LayoutNode {
                dof: self.dof[node].unwrap_or_default(),
                node,
                x,
                from: from.map(|stop| (stop, joint)),
                same_place: beside,
            });
            let mut children = self.children[node].clone();
            // The longest is laid next, so it goes on the stack last; the others keep file order.
            children.reverse();
            if let Some(longest) = (0..children.len()).max_by_key(|&i| self.depth[children[i]]) {
                let longest = children.remove(longest);
                children.push(longest);
            }
            stack.extend(children.into_iter().map(|child| (child, Some(here))));
        }
    }
}
