//! Spanning forest of a spring network: `K = Σ k w wᵀ`, `wᵀx = a xᵢ + c xⱼ`.
//!
//! On a forest the springs combine in series and parallel from the leaves to the root (see `numeric::elimination`) without cancellation,
//! whatever the spread of stiffness. Springs to ground add to their node; the few springs that close loops are stored separately.

/// Maximum number of springs that close loops; with more the sparse factorisation is faster.
const MAX_LOOPS: usize = 50;

/// Relative deviation from one of the product of the ratios of a loop, below which the tree can rotate: rounding of some hundred ratios.
const SAME_RATIO: f64 = 1e-12;

/// A spring of energy `½ k (a xᵢ + c xⱼ)²`, or `½ k (a xᵢ)²` to ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForestSpring {
    /// First degree of freedom, i.
    pub i: usize,
    /// Coefficient `a`.
    pub a: f64,
    /// Second degree of freedom and its coefficient, (j, c); `None` for a spring to ground.
    pub second: Option<(usize, f64)>,
    /// Stiffness, positive, N·m/rad or N/m: `k (wᵀx)²` is an energy, J.
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

/// Spring that closes a loop; nodes are positions in the elimination order.
#[derive(Debug, Clone)]
pub(super) struct ClosingSpring {
    pub k: f64,
    /// Nodes and coefficients of `wᵀx = Σ coefficient · δ` over the edges from the nodes to their parents.
    pub path: Vec<(usize, f64)>,
    /// Coefficient of x at `apex` in `wᵀx`; zero where the ratios of the loop multiply to one.
    pub slip: f64,
    pub apex: usize,
    pub ends: [(usize, f64); 2],
}

/// Tree of the forest: the positions `start..end` of the elimination order, the root first.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tree {
    pub start: usize,
    pub end: usize,
    /// True if a spring connects the tree to ground.
    pub grounded: bool,
    /// True if a loop whose ratios do not multiply to one prevents rigid rotation.
    pub locked: bool,
}

/// Forest in elimination order: parents precede their children, each tree is contiguous.
#[derive(Debug, Clone)]
pub struct Forest {
    /// `order[position]` = degree of freedom.
    pub(super) order: Vec<usize>,
    /// Edge to the parent, per position; `None` at a root.
    pub(super) edges: Vec<Option<TreeEdge>>,
    /// Stiffness to ground, per position.
    pub(super) ground: Vec<f64>,
    pub(super) trees: Vec<Tree>,
    pub(super) loops: Vec<ClosingSpring>,
    /// Rigid-body shape of the tree, 1 at its root; per position.
    pub(super) rigid_shape: Vec<f64>,
}

impl Forest {
    /// Builds the forest over `n` degrees of freedom; `None` if more than fifty springs close loops or a number is not finite.
    ///
    /// The root of a free tree is its degree of freedom of largest `inertia`, kg·m² or kg, whose motion is then recovered exactly.
    /// The stiffest springs form the tree and the softest close the loops.
    pub fn new(n: usize, springs: &[ForestSpring], inertia: &[f64]) -> Option<Forest> {
        let is_valid = |s: &ForestSpring| {
            let (j, c) = s.second.unwrap_or((s.i, 1.0));
            s.k > 0.0
                && (s.k * s.a * s.a).is_finite()
                && (s.k * c * c).is_finite()
                && s.i < n
                && j < n
        };
        if inertia.len() != n || !springs.iter().all(is_valid) {
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
        let unweighted = Traversal::new(n, &edges, &vec![true; edges.len()], |_, tree| tree[0]);
        let in_tree = unweighted.stiffest_edges(&edges);
        if in_tree.iter().filter(|is_edge| !**is_edge).count() > MAX_LOOPS {
            return None;
        }
        let root = |shape: &[f64], tree: &[usize]| -> usize {
            let is_grounded = tree.iter().any(|&i| ground[i] > 0.0);
            let size = |i: usize| if is_grounded { ground[i] } else { inertia[i].abs() } * shape[i] * shape[i];
            tree.iter()
                .copied()
                .fold(tree[0], |max, i| if size(i) > size(max) { i } else { max })
        };
        Some(Forest::from_parts(
            Traversal::new(n, &edges, &in_tree, root),
            &edges,
            &in_tree,
            &ground,
        ))
    }

    fn from_parts(
        traversal: Traversal,
        edges: &[Edge],
        in_tree: &[bool],
        ground: &[f64],
    ) -> Forest {
        let Traversal {
            order,
            edges: tree_edges,
            roots,
            rigid_shape,
        } = traversal;
        let n = order.len();
        let mut position = vec![0; n];
        for (pos, &i) in order.iter().enumerate() {
            position[i] = pos;
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
            edges: tree_edges,
            ground,
            trees,
            loops: Vec::new(),
            rigid_shape,
        };
        for (edge, _) in edges.iter().zip(in_tree).filter(|(_, is_edge)| !**is_edge) {
            let closing = forest.closing_spring(edge.ends.map(|(i, a)| (position[i], a)), edge.k);
            if closing.slip != 0.0 {
                let tree = forest.trees.partition_point(|t| t.end <= closing.apex);
                forest.trees[tree].locked |= !forest.trees[tree].grounded;
            }
            forest.loops.push(closing);
        }
        forest
    }

    /// Follows the tree from both ends of a spring to their common ancestor, the apex, by `x_child = (δ − a x_parent) / c`.
    fn closing_spring(&self, ends: [(usize, f64); 2], k: f64) -> ClosingSpring {
        let mut ancestors = ends;
        let mut path = Vec::new();
        while ancestors[0].0 != ancestors[1].0 {
            let lower = usize::from(ancestors[0].0 <= ancestors[1].0); // parents precede children: the later one is not the apex
            let (node, factor) = ancestors[lower];
            let Some(edge) = self.edges[node] else { break };
            path.push((node, factor / edge.c));
            ancestors[lower] = (edge.parent, -factor * edge.a / edge.c);
        }
        let [(apex, first), (_, second)] = ancestors;
        let (sum, size) = (first + second, first.abs() + second.abs());
        let slip = if sum.abs() <= SAME_RATIO * size {
            0.0
        } else {
            sum
        };
        ClosingSpring {
            k,
            path,
            slip,
            apex,
            ends,
        }
    }

    /// Number of degrees of freedom.
    pub fn len(&self) -> usize {
        self.order.len()
    }

    /// True if there is no degree of freedom.
    pub fn is_empty(&self) -> bool {
        self.order.is_empty()
    }

    /// Number of springs that close loops.
    pub fn n_loops(&self) -> usize {
        self.loops.len()
    }

    /// Rigid-body motions, which deform no spring: one for each tree that is neither grounded nor locked.
    ///
    /// Each is 1 at the root of its tree and zero outside the tree, hence they are orthogonal in any diagonal mass matrix.
    pub fn rigid_motions(&self) -> Vec<Vec<f64>> {
        let free = self.trees.iter().filter(|t| !t.grounded && !t.locked);
        free.map(|t| {
            let mut motion = vec![0.0; self.len()];
            for pos in t.start..t.end {
                motion[self.order[pos]] = self.rigid_shape[pos];
            }
            motion
        })
        .collect()
    }
}

struct Edge {
    ends: [(usize, f64); 2],
    k: f64,
}

/// Breadth-first traversal from the root of each tree, in the order of visits.
struct Traversal {
    order: Vec<usize>,
    edges: Vec<Option<TreeEdge>>,
    roots: Vec<usize>,
    rigid_shape: Vec<f64>,
}

impl Traversal {
    fn new(
        n: usize,
        edges: &[Edge],
        is_used: &[bool],
        root: impl Fn(&[f64], &[usize]) -> usize,
    ) -> Traversal {
        let neighbours = Neighbours::new(n, edges, is_used);
        let mut traversal = Traversal {
            order: Vec::with_capacity(n),
            edges: Vec::with_capacity(n),
            roots: Vec::new(),
            rigid_shape: Vec::with_capacity(n),
        };
        let mut visits = vec![0_u8; n]; // 1: visited from the first root, 2: visited from the chosen root
        let mut shape_by_dof = vec![0.0; n];
        for first in 0..n {
            if visits[first] > 0 {
                continue;
            }
            let start = traversal.order.len();
            traversal.visit_tree(first, 1, &neighbours, edges, &mut visits);
            for pos in start..traversal.order.len() {
                shape_by_dof[traversal.order[pos]] = traversal.rigid_shape[pos];
            }
            let root_dof = root(&shape_by_dof, &traversal.order[start..]);
            if root_dof != first {
                traversal.order.truncate(start);
                traversal.edges.truncate(start);
                traversal.rigid_shape.truncate(start);
                traversal.visit_tree(root_dof, 2, &neighbours, edges, &mut visits);
            }
            traversal.roots.push(start);
        }
        traversal
    }

    fn visit_tree(
        &mut self,
        root: usize,
        visit: u8,
        neighbours: &Neighbours,
        edges: &[Edge],
        visits: &mut [u8],
    ) {
        let mut next = self.order.len();
        self.order.push(root);
        self.edges.push(None);
        self.rigid_shape.push(1.0);
        visits[root] = visit;
        while next < self.order.len() {
            let node = self.order[next];
            for &e in neighbours.edges_at(node) {
                let [p, q] = edges[e].ends;
                let ((_, a), (child, c)) = if p.0 == node { (p, q) } else { (q, p) };
                if visits[child] < visit {
                    visits[child] = visit;
                    self.order.push(child);
                    self.edges.push(Some(TreeEdge {
                        parent: next,
                        a,
                        c,
                        k: edges[e].k,
                    }));
                    self.rigid_shape.push(-(a / c) * self.rigid_shape[next]);
                }
            }
            next += 1;
        }
    }

    /// Marks the edges of the stiffest spanning forest, stiffness referred to the root of each tree (Kruskal).
    fn stiffest_edges(&self, edges: &[Edge]) -> Vec<bool> {
        let n = self.order.len();
        if edges.len() + self.roots.len() == n {
            return vec![true; edges.len()];
        }
        let mut shape_by_dof = vec![0.0; n];
        for (pos, &i) in self.order.iter().enumerate() {
            shape_by_dof[i] = self.rigid_shape[pos];
        }
        let stiffness = |e: &Edge| {
            e.ends
                .iter()
                .fold(e.k, |k, &(i, a)| k * (a * shape_by_dof[i]).abs())
        };
        let mut by_stiffness: Vec<(f64, usize)> = edges.iter().map(stiffness).zip(0..).collect();
        by_stiffness.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let mut leaders: Vec<usize> = (0..n).collect();
        let mut is_edge = vec![false; edges.len()];
        for (_, e) in by_stiffness {
            let [p, q] = edges[e].ends.map(|(i, _)| find_leader(&mut leaders, i));
            is_edge[e] = p != q;
            leaders[p.max(q)] = p.min(q);
        }
        is_edge
    }
}

fn find_leader(leaders: &mut [usize], mut i: usize) -> usize {
    while leaders[i] != i {
        leaders[i] = leaders[leaders[i]];
        i = leaders[i];
    }
    i
}

/// Edges at each degree of freedom, as rows of one array.
struct Neighbours {
    start: Vec<usize>,
    edges: Vec<usize>,
}

impl Neighbours {
    fn new(n: usize, edges: &[Edge], is_used: &[bool]) -> Neighbours {
        let mut start = vec![0; n + 1];
        let ends = || {
            (0..edges.len())
                .filter(|&e| is_used[e])
                .flat_map(|e| edges[e].ends.map(|(i, _)| (i, e)))
        };
        ends().for_each(|(i, _)| start[i + 1] += 1);
        for i in 0..n {
            start[i + 1] += start[i];
        }
        let mut next = start.clone();
        let mut rows = vec![0; start[n]];
        for (i, e) in ends() {
            rows[next[i]] = e;
            next[i] += 1;
        }
        Neighbours { start, edges: rows }
    }

    fn edges_at(&self, i: usize) -> &[usize] {
        &self.edges[self.start[i]..self.start[i + 1]]
    }
}
