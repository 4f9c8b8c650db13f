//! Spanning forest of a spring network: `K = Σ k w wᵀ`, `wᵀx = a xᵢ + c xⱼ`.
//!
//! On a forest the springs join in series and parallel from the leaves to the root (see `numeric::elimination`), and no digit is lost
//! whatever their spread. Springs to ground only add to their node. A few springs that close loops are kept next to the forest.

/// More springs than this closing loops, and the sparse factorisation is the better tool.
const MAX_LOOPS: usize = 50;

/// A loop whose ratios multiply to one within this (relative; rounding of some hundred ratios) leaves the tree free to turn.
const SAME_RATIO: f64 = 1e-12;

/// A spring of energy `½ k (a xᵢ + c xⱼ)²`, or `½ k (a xᵢ)²` to ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForestSpring {
    /// The first degree of freedom, i.
    pub i: usize,
    /// Coefficient `a`.
    pub a: f64,
    /// The second degree of freedom and its coefficient, (j, c); none for a spring to ground.
    pub second: Option<(usize, f64)>,
    /// Stiffness, positive, in the units that make `k (wᵀx)²` an energy.
    pub k: f64,
}

/// Edge from a node to its parent: `δ = a x_parent + c x_node`.
#[derive(Debug, Clone, Copy)]
pub(super) struct TreeEdge {
    pub parent: usize,
    pub a: f64,
    pub c: f64,
    pub k: f64,
}

/// A spring that closes a loop, in positions of the elimination order.
#[derive(Debug, Clone)]
pub(super) struct ClosingSpring {
    pub k: f64,
    /// `wᵀx = Σ coefficient · δ` over the links of these nodes, for the part of x that deforms the tree.
    pub along: Vec<(usize, f64)>,
    /// `wᵀx` gains this times x at `apex`, where the loop's ratios do not multiply to one.
    pub slip: f64,
    pub apex: usize,
    pub ends: [(usize, f64); 2],
}

/// One tree of the forest, or a part of the order with one root.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tree {
    pub start: usize,
    pub end: usize,
    /// Whether a spring ties it to ground.
    pub grounded: bool,
    /// Whether loops of contradicting ratios keep it from turning.
    pub locked: bool,
}

/// Forest in elimination order: parents precede their children, each tree in one piece.
#[derive(Debug, Clone)]
pub struct Forest {
    /// `order[position]` = degree of freedom.
    pub(super) order: Vec<usize>,
    /// Per position; none at a root.
    pub(super) edges: Vec<Option<TreeEdge>>,
    /// Stiffness to ground, per position.
    pub(super) ground: Vec<f64>,
    pub(super) trees: Vec<Tree>,
    pub(super) loops: Vec<ClosingSpring>,
    /// Rigid-body shape of the tree, 1 at its root; per position.
    pub(super) rigid_shape: Vec<f64>,
}

impl Forest {
    /// The forest over `n` degrees of freedom, or none where more than some fifty springs close loops or a number is not finite.
    ///
    /// `inertia` chooses the root of a free tree, its heaviest degree of freedom: what is pinned there is recovered exactly.
    /// Where there is a choice, the stiffest springs make the tree and the softest close the loops.
    pub fn new(n: usize, springs: &[ForestSpring], inertia: &[f64]) -> Option<Forest> {
        let sound = |s: &ForestSpring| {
            let (j, c) = s.second.unwrap_or((s.i, 1.0));
            s.k > 0.0
                && (s.k * s.a * s.a).is_finite()
                && (s.k * c * c).is_finite()
                && s.i < n
                && j < n
        };
        if inertia.len() != n || !springs.iter().all(sound) {
            return None;
        }
        let mut ground = vec![0.0; n];
        let mut edges = Vec::with_capacity(springs.len());
        for s in springs {
            match s.second {
                None => ground[s.i] += s.k * s.a * s.a,
                Some((j, c)) if j == s.i => ground[j] += s.k * (s.a + c) * (s.a + c),
                Some((j, 0.0)) if j < n => ground[s.i] += s.k * s.a * s.a,
                Some((j, c)) if s.a == 0.0 => ground[j] += s.k * c * c,
                Some((j, c)) => edges.push(Edge {
                    ends: [(s.i, s.a), (j, c)],
                    k: s.k,
                }),
            }
        }
        let rough = BreadthFirstTree::new(n, &edges, &vec![true; edges.len()], |_, tree| tree[0]);
        let in_tree = rough.stiffest_edges(&edges);
        if in_tree.iter().filter(|kept| !**kept).count() > MAX_LOOPS {
            return None;
        }
        let root = |turning: &[f64], tree: &[usize]| -> usize {
            let held = tree.iter().any(|&i| ground[i] > 0.0);
            let weight = |i: usize| if held { ground[i] } else { inertia[i].abs() } * turning[i] * turning[i];
            tree.iter().copied().fold(
                tree[0],
                |best, i| if weight(i) > weight(best) { i } else { best },
            )
        };
        Some(Forest::from_parts(
            BreadthFirstTree::new(n, &edges, &in_tree, root),
            &edges,
            &in_tree,
            &ground,
        ))
    }

    fn from_parts(
        hanging: BreadthFirstTree,
        edges: &[Edge],
        in_tree: &[bool],
        ground: &[f64],
    ) -> Forest {
        let BreadthFirstTree {
            order,
            edges: links,
            roots,
            turning,
        } = hanging;
        let n = order.len();
        let mut position = vec![0; n];
        for (at, &i) in order.iter().enumerate() {
            position[i] = at;
        }
        let ground: Vec<f64> = order.iter().map(|&i| ground[i]).collect();
        let mut trees: Vec<Tree> = Vec::with_capacity(roots.len());
        for (t, &start) in roots.iter().enumerate() {
            let end = roots.get(t + 1).copied().unwrap_or(n);
            let grounded = ground[start..end].iter().any(|&g| g > 0.0);
            trees.push(Tree {
                start,
                end,
                grounded,
                locked: false,
            });
        }
        let mut forest = Forest {
            order,
            edges: links,
            ground,
            trees,
            loops: Vec::new(),
            rigid_shape: turning,
        };
        for (edge, _) in edges.iter().zip(in_tree).filter(|(_, kept)| !**kept) {
            let closing = forest.closing_spring(edge.ends.map(|(i, a)| (position[i], a)), edge.k);
            if closing.slip != 0.0 {
                let tree = forest.trees.partition_point(|t| t.end <= closing.apex);
                forest.trees[tree].locked |= !forest.trees[tree].grounded;
            }
            forest.loops.push(closing);
        }
        forest
    }

    /// The loop a spring closes: up from both ends to where they meet, `x_child = (δ − a x_parent) / c` all the way.
    fn closing_spring(&self, ends: [(usize, f64); 2], k: f64) -> ClosingSpring {
        let mut at = ends;
        let mut along = Vec::new();
        while at[0].0 != at[1].0 {
            let lower = if at[0].0 > at[1].0 { 0 } else { 1 }; // parents come first: the later one is not the apex
            let (node, factor) = at[lower];
            let Some(link) = self.edges[node] else { break };
            along.push((node, factor / link.c));
            at[lower] = (link.parent, -factor * link.a / link.c);
        }
        let slip = at[0].1 + at[1].1;
        let slip = if slip.abs() <= SAME_RATIO * (at[0].1.abs() + at[1].1.abs()) {
            0.0
        } else {
            slip
        };
        ClosingSpring {
            k,
            along,
            slip,
            apex: at[0].0,
            ends,
        }
    }

    /// The number of degrees of freedom.
    pub fn len(&self) -> usize {
        self.order.len()
    }

    /// Whether there is no degree of freedom at all.
    pub fn is_empty(&self) -> bool {
        self.order.is_empty()
    }

    /// Number of springs that close loops.
    pub fn n_loops(&self) -> usize {
        self.loops.len()
    }

    /// The motions that deform no spring: one for each tree that neither ground nor contradicting ratios hold.
    ///
    /// Each is 1 at its tree's root and zero outside its tree; several are orthogonal in any diagonal mass.
    pub fn rigid_motions(&self) -> Vec<Vec<f64>> {
        let free = self.trees.iter().filter(|t| !t.grounded && !t.locked);
        free.map(|t| {
            let mut r = vec![0.0; self.len()];
            for at in t.start..t.end {
                r[self.order[at]] = self.rigid_shape[at];
            }
            r
        })
        .collect()
    }
}

struct Edge {
    ends: [(usize, f64); 2],
    k: f64,
}

/// Breadth first from a root of each tree: who hangs from whom.
struct BreadthFirstTree {
    order: Vec<usize>,
    edges: Vec<Option<TreeEdge>>,
    roots: Vec<usize>,
    turning: Vec<f64>,
}

impl BreadthFirstTree {
    fn new(
        n: usize,
        edges: &[Edge],
        used: &[bool],
        root: impl Fn(&[f64], &[usize]) -> usize,
    ) -> BreadthFirstTree {
        let neighbours = Neighbours::new(n, edges, used);
        let mut hanging = BreadthFirstTree {
            order: Vec::with_capacity(n),
            edges: Vec::with_capacity(n),
            roots: Vec::new(),
            turning: Vec::with_capacity(n),
        };
        let mut round = vec![0_u8; n]; // 1: its tree has been walked once, 2: it stands in the order
        let mut by_freedom = vec![0.0; n];
        for first in 0..n {
            if round[first] > 0 {
                continue;
            }
            let start = hanging.order.len();
            hanging.walk(first, 1, &neighbours, edges, &mut round);
            for at in start..hanging.order.len() {
                by_freedom[hanging.order[at]] = hanging.turning[at];
            }
            let chosen = root(&by_freedom, &hanging.order[start..]);
            if chosen != first {
                hanging.order.truncate(start);
                hanging.edges.truncate(start);
                hanging.turning.truncate(start);
                hanging.walk(chosen, 2, &neighbours, edges, &mut round);
            }
            hanging.roots.push(start);
        }
        hanging
    }

    fn walk(
        &mut self,
        root: usize,
        mark: u8,
        neighbours: &Neighbours,
        edges: &[Edge],
        round: &mut [u8],
    ) {
        let mut next = self.order.len();
        self.order.push(root);
        self.edges.push(None);
        self.turning.push(1.0);
        round[root] = mark;
        while next < self.order.len() {
            let node = self.order[next];
            for &e in neighbours.edges_at(node) {
                let [p, q] = edges[e].ends;
                let ((_, a), (child, c)) = if p.0 == node { (p, q) } else { (q, p) };
                if round[child] < mark {
                    round[child] = mark;
                    self.order.push(child);
                    self.edges.push(Some(TreeEdge {
                        parent: next,
                        a,
                        c,
                        k: edges[e].k,
                    }));
                    self.turning.push(-(a / c) * self.turning[next]);
                }
            }
            next += 1;
        }
    }

    /// Which edges make the stiffest forest, measured in the angle of each tree's root.
    fn stiffest_edges(&self, edges: &[Edge]) -> Vec<bool> {
        let n = self.order.len();
        if edges.len() + self.roots.len() == n {
            return vec![true; edges.len()];
        }
        let mut turning = vec![0.0; n];
        for (at, &i) in self.order.iter().enumerate() {
            turning[i] = self.turning[at];
        }
        let stiffness = |e: &Edge| {
            e.ends
                .iter()
                .fold(e.k, |k, &(i, a)| k * (a * turning[i]).abs())
        };
        let mut by_stiffness: Vec<(f64, usize)> = edges.iter().map(stiffness).zip(0..).collect();
        by_stiffness.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let mut leader: Vec<usize> = (0..n).collect();
        let mut kept = vec![false; edges.len()];
        for (_, e) in by_stiffness {
            let [p, q] = edges[e].ends.map(|(i, _)| find(&mut leader, i));
            kept[e] = p != q;
            leader[p.max(q)] = p.min(q);
        }
        kept
    }
}

fn find(leader: &mut [usize], mut i: usize) -> usize {
    while leader[i] != i {
        leader[i] = leader[leader[i]];
        i = leader[i];
    }
    i
}

/// The edges at each degree of freedom, as rows of one array.
struct Neighbours {
    start: Vec<usize>,
    edges: Vec<usize>,
}

impl Neighbours {
    fn new(n: usize, edges: &[Edge], used: &[bool]) -> Neighbours {
        let mut start = vec![0; n + 1];
        let ends = || {
            (0..edges.len())
                .filter(|&e| used[e])
                .flat_map(|e| edges[e].ends.map(|(i, _)| (i, e)))
        };
        ends().for_each(|(i, _)| start[i + 1] += 1);
        for i in 0..n {
            start[i + 1] += start[i];
        }
        let mut fill = start.clone();
        let mut rows = vec![0; start[n]];
        for (i, e) in ends() {
            rows[fill[i]] = e;
            fill[i] += 1;
        }
        Neighbours { start, edges: rows }
    }

    fn edges_at(&self, i: usize) -> &[usize] {
        &self.edges[self.start[i]..self.start[i + 1]]
    }
}
