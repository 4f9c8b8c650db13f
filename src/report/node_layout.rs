//! Layout of the nodes of a drive train for plots, along the train and branch by branch.

use crate::machine::components::Machine;
use crate::machine::direction::Direction;
use crate::scene::model::Axis;

/// Kind of link between a node and its parent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LinkKind {
    /// Both ends have the same rotation when unstrained: a shaft, a coupling.
    Shaft,
    /// Any other link: a mesh, a belt, a planetary stage.
    Mesh,
}

/// Node with its position in the layout.
#[derive(Debug, Clone, Copy)]
pub struct LayoutNode {
    /// Index of the rotational (or sliding) degree of freedom.
    pub dof: usize,
    /// Index of the node.
    pub node: usize,
    /// Position along the axis; neighbours have a distance of 1, branches a larger one.
    pub x: f64,
    /// Index of the parent in the layout, and the kind of link to it; `None` for a root.
    pub from: Option<(usize, LinkKind)>,
    /// Whether the parent is the previous node of the layout.
    pub follows_parent: bool,
}

/// Additional distance before a branch.
const SPACING: f64 = 0.8;

/// Layout of every rotating node: from the first along the longest path, then the branches.
pub fn layout_nodes(machine: &Machine) -> Vec<LayoutNode> {
    let links = links(machine);
    let mut tree = NodeTree::new(machine, links);
    let mut nodes: Vec<LayoutNode> = Vec::new();
    for root in 0..tree.links.len() {
        if tree.dof[root].is_some() && !tree.visited[root] {
            tree.depth_first(root);
            tree.place_subtree(root, &mut nodes);
        }
    }
    nodes
}

/// Neighbours of every node with the kinds of link, in file order.
fn links(machine: &Machine) -> Vec<Vec<(usize, LinkKind)>> {
    let mut links = vec![Vec::new(); machine.nodes.len()];
    for branch in &machine.branches {
        let mut nodes: Vec<usize> = rotors(machine, &branch.direction).collect();
        nodes.dedup();
        let link_kind = link_kind(&branch.direction);
        for (i, &a) in nodes.iter().enumerate() {
            for &b in &nodes[i + 1..] {
                links[a].push((b, link_kind));
                links[b].push((a, link_kind));
            }
        }
    }
    links
}

fn rotors<'a>(machine: &'a Machine, direction: &'a Direction) -> impl Iterator<Item = usize> + 'a {
    let dofs = direction.terms.iter().map(|t| t.0);
    let rotating = dofs.filter(|&f| machine.dofs[f].axis == Axis::Theta || machine.is_slide(f));
    rotating.map(|f| machine.dofs[f].node)
}

fn link_kind(direction: &Direction) -> LinkKind {
    match direction.terms[..] {
        [(_, a), (_, b)] if a == -b => LinkKind::Shaft,
        _ => LinkKind::Mesh,
    }
}

/// Spanning trees of the node graph, one for each root.
struct NodeTree {
    links: Vec<Vec<(usize, LinkKind)>>,
    dof: Vec<Option<usize>>,
    visited: Vec<bool>,
    parent: Vec<Option<(usize, LinkKind)>>,
    children: Vec<Vec<usize>>,
    /// Number of nodes on the longest path down, itself included.
    depth: Vec<usize>,
}

impl NodeTree {
    fn new(machine: &Machine, links: Vec<Vec<(usize, LinkKind)>>) -> NodeTree {
        let n = links.len();
        let mut dof = vec![None; n];
        for (i, f) in machine.dofs.iter().enumerate() {
            if f.axis == Axis::Theta || machine.is_slide(i) {
                dof[f.node] = Some(i);
            }
        }
        NodeTree {
            links,
            dof,
            visited: vec![false; n],
            parent: vec![None; n],
            children: vec![Vec::new(); n],
            depth: vec![1; n],
        }
    }

    /// Grows the tree from a root depth first, so that a loop becomes one long path.
    fn depth_first(&mut self, root: usize) {
        let mut order = vec![root];
        let mut stack = vec![(root, 0)];
        self.visited[root] = true;
        while let Some((node, next)) = stack.pop() {
            let Some(&(other, link)) = self.links[node].get(next) else {
                continue;
            };
            stack.push((node, next + 1));
            if !self.visited[other] {
                self.visited[other] = true;
                self.parent[other] = Some((node, link));
                self.children[node].push(other);
                order.push(other);
                stack.push((other, 0));
            }
        }
        for &node in order.iter().rev() {
            let child_depth = self.children[node].iter().map(|&c| self.depth[c]).max();
            self.depth[node] = 1 + child_depth.unwrap_or(0);
        }
    }

    /// Places the nodes below a root in sequence, the longest path first.
    fn place_subtree(&self, root: usize, nodes: &mut Vec<LayoutNode>) {
        let mut stack: Vec<(usize, Option<usize>)> = vec![(root, None)];
        while let Some((node, from)) = stack.pop() {
            let last = nodes.len().checked_sub(1);
            let follows_parent = from.is_some() && from == last;
            let x = match last {
                None => 0.0,
                Some(last) if follows_parent => nodes[last].x + 1.0,
                Some(last) => nodes[last].x + 1.0 + SPACING,
            };
            let link = self.parent[node].map_or(LinkKind::Mesh, |(_, link)| link);
            let index = nodes.len();
            nodes.push(LayoutNode {
                dof: self.dof[node].unwrap_or_default(),
                node,
                x,
                from: from.map(|parent| (parent, link)),
                follows_parent,
            });
            let mut children = self.children[node].clone();
            // The longest path is placed next, so it is pushed last; the others keep file order.
            children.reverse();
            if let Some(longest) = (0..children.len()).max_by_key(|&i| self.depth[children[i]]) {
                let longest = children.remove(longest);
                children.push(longest);
            }
            stack.extend(children.into_iter().map(|child| (child, Some(index))));
        }
    }
}
