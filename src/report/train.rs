//! The order in which a picture sets the nodes of a train: along it, branch after branch.

use crate::machine::direction::Direction;
use crate::machine::parts::Machine;
use crate::scene::model::Axis;

/// What joins a node to the one before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Joint {
    /// Both ends turn alike when it is not strained: a shaft, a coupling.
    Shaft,
    /// Anything else: a mesh, a belt, a planetary stage.
    Mesh,
}

/// A node in its place.
#[derive(Debug, Clone, Copy)]
pub struct Stop {
    /// Its rotation.
    pub freedom: usize,
    /// Its node.
    pub node: usize,
    /// Where it stands along the axis; neighbours are 1 apart, branches more.
    pub x: f64,
    /// The stop it hangs on, and by what.
    pub from: Option<(usize, Joint)>,
    /// It stands right beside the stop it hangs on.
    pub beside: bool,
}

/// Additional room before a branch.
const GAP: f64 = 0.8;

/// Every node that turns, from the first one along the longest way, then what branches off.
pub fn stops(machine: &Machine) -> Vec<Stop> {
    let joints = joints(machine);
    let mut tree = Tree::new(machine, joints);
    let mut stops: Vec<Stop> = Vec::new();
    for root in 0..tree.joints.len() {
        if tree.freedom[root].is_some() && !tree.seen[root] {
            tree.grow(root);
            tree.lay(root, &mut stops);
        }
    }
    stops
}

/// For every node: its neighbours, in file order.
fn joints(machine: &Machine) -> Vec<Vec<(usize, Joint)>> {
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
    let freedoms = direction.terms.iter().map(|t| t.0);
    let shown = freedoms.filter(|&f| machine.freedoms[f].axis == Axis::Theta || machine.slides(f));
    shown.map(|f| machine.freedoms[f].node)
}

fn joint(direction: &Direction) -> Joint {
    match direction.terms[..] {
        [(_, a), (_, b)] if a == -b => Joint::Shaft,
        _ => Joint::Mesh,
    }
}

/// A spanning tree of the graph of nodes, grown from one root after the other.
struct Tree {
    joints: Vec<Vec<(usize, Joint)>>,
    freedom: Vec<Option<usize>>,
    seen: Vec<bool>,
    parent: Vec<Option<(usize, Joint)>>,
    children: Vec<Vec<usize>>,
    /// Nodes on the longest way down, itself included.
    depth: Vec<usize>,
}

impl Tree {
    fn new(machine: &Machine, joints: Vec<Vec<(usize, Joint)>>) -> Tree {
        let n = joints.len();
        let mut freedom = vec![None; n];
        for (i, f) in machine.freedoms.iter().enumerate() {
            if f.axis == Axis::Theta || machine.slides(i) {
                freedom[f.node] = Some(i);
            }
        }
        Tree {
            joints,
            freedom,
            seen: vec![false; n],
            parent: vec![None; n],
            children: vec![Vec::new(); n],
            depth: vec![1; n],
        }
    }

    /// Depth first, so that a loop is one long way round.
    fn grow(&mut self, root: usize) {
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
    fn lay(&self, root: usize, stops: &mut Vec<Stop>) {
        let mut stack: Vec<(usize, Option<usize>)> = vec![(root, None)];
        while let Some((node, from)) = stack.pop() {
            let last = stops.len().checked_sub(1);
            let beside = from.is_some() && from == last;
            let x = match last {
                None => 0.0,
                Some(last) if beside => stops[last].x + 1.0,
                Some(last) => stops[last].x + 1.0 + GAP,
            };
            let joint = self.parent[node].map_or(Joint::Mesh, |(_, joint)| joint);
            let here = stops.len();
            stops.push(Stop {
                freedom: self.freedom[node].unwrap_or_default(),
                node,
                x,
                from: from.map(|stop| (stop, joint)),
                beside,
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
