//! Limits of a flank: undercut where `D = 0` (first kind), and where `Φ = ∂f/∂x = 0` the contact lines have an envelope on the tool (second kind).

use super::envelope::{Envelope, FlankPoint};
use super::jet::Surface;
use super::root::sign_change;

/// Kind of a limit of a flank.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Limit {
    /// First kind, `D = 0`: the flank has an edge of regression; beyond it metal is undercut.
    Undercut,
    /// Second kind, `Φ = 0`: contact lines meet their envelope on the tool. On one side of it a point of the tool touches twice, on the other
    /// never; the flank goes on through it.
    Second,
}

impl Limit {
    fn value<Frame>(self, point: &FlankPoint<Frame>) -> f64 {
        match self {
            Limit::Undercut => point.second_order.undercut,
            Limit::Second => point.second_order.second_limit,
        }
    }
}

/// Points of the limit on the straight line between two places `[x, θ]` of a flank, in the line's order; the signs at the ends of `parts`
/// equal parts are compared. In the plane θ is 0.
pub fn limit_points<S: Surface, To>(
    envelope: &Envelope<S, To>,
    limit: Limit,
    [from, to]: [[f64; 2]; 2],
    parts: usize,
) -> Vec<FlankPoint<To>> {
    let place = |share: f64| [0, 1].map(|k| from[k] + share * (to[k] - from[k]));
    let value = |share: f64| Some(limit.value(&envelope.flank(place(share))?));
    let end = |i: usize| i as f64 / parts as f64;
    let mut before = value(end(0));
    let mut found = Vec::new();
    for i in 1..=parts {
        let here = value(end(i));
        if differ(before, here)
            && let Some(share) = sign_change([end(i - 1), end(i)], value)
        {
            found.extend(envelope.flank(place(share)));
        }
        before = here;
    }
    found
}

/// The limit's curves over the flank's domain `x` × `theta`, traced through `cells` cells along each.
///
/// A curve crosses the sides of cells at places found to rounding; where the flank does not exist the curve ends. A closed curve repeats
/// its first point. Curves that pass between two sides of a cell without crossing one are not seen.
pub fn limit_curves<S: Surface, To: Copy>(
    envelope: &Envelope<S, To>,
    limit: Limit,
    [x, theta]: [[f64; 2]; 2],
    cells: [usize; 2],
) -> Vec<Vec<FlankPoint<To>>> {
    let node = |i: usize, j: usize| {
        let share = |k: usize, cell: usize| cell as f64 / cells[k] as f64;
        [
            x[0] + share(0, i) * (x[1] - x[0]),
            theta[0] + share(1, j) * (theta[1] - theta[0]),
        ]
    };
    let value = |at: [f64; 2]| Some(limit.value(&envelope.flank(at)?));
    let column = |i: usize| (0..=cells[1]).map(move |j| value(node(i, j)));
    let values: Vec<Vec<Option<f64>>> = (0..=cells[0]).map(|i| column(i).collect()).collect();
    // Sides are numbered along x first: side (i, j, 0) from node (i, j) to (i + 1, j), side (i, j, 1) from it to (i, j + 1).
    let side = |i: usize, j: usize, along: usize| 2 * (i * (cells[1] + 1) + j) + along;
    let mut crossings: Vec<Option<FlankPoint<To>>> = Vec::new();
    crossings.resize_with(2 * (cells[0] + 1) * (cells[1] + 1), || None);
    for i in 0..=cells[0] {
        for j in 0..=cells[1] {
            for along in 0..2 {
                let (a, b) = (i + 1 - along, j + along);
                if a <= cells[0] && b <= cells[1] && differ(values[i][j], values[a][b]) {
                    let line = [node(i, j), node(a, b)];
                    crossings[side(i, j, along)] = limit_points(envelope, limit, line, 1).pop();
                }
            }
        }
    }
    let mut links = Vec::new();
    for i in 0..cells[0] {
        for j in 0..cells[1] {
            let around = [
                side(i, j, 0),
                side(i + 1, j, 1),
                side(i, j + 1, 0),
                side(i, j, 1),
            ];
            let crossed: Vec<usize> = around
                .into_iter()
                .filter(|s| crossings[*s].is_some())
                .collect();
            // Four crossings are a saddle; either pairing is within the cell.
            links.extend(crossed.chunks_exact(2).map(|pair| [pair[0], pair[1]]));
        }
    }
    chains(links)
        .into_iter()
        .map(|chain| {
            let points = chain.into_iter();
            points.filter_map(|s| crossings[s]).collect()
        })
        .collect()
}

/// Whether two values have different signs.
fn differ(a: Option<f64>, b: Option<f64>) -> bool {
    matches!((a, b), (Some(a), Some(b)) if (a < 0.0) != (b < 0.0))
}

/// Links joined end to end; open chains first.
fn chains(mut links: Vec<[usize; 2]>) -> Vec<Vec<usize>> {
    let mut found = Vec::new();
    while !links.is_empty() {
        let count = |s: usize| links.iter().flatten().filter(|l| **l == s).count();
        let open = links.iter().flatten().copied().find(|s| count(*s) == 1);
        let start = open.unwrap_or(links[0][0]);
        let mut chain = vec![start];
        let mut end = start;
        while let Some(k) = links.iter().position(|l| l.contains(&end)) {
            let [a, b] = links.swap_remove(k);
            end = if a == end { b } else { a };
            chain.push(end);
        }
        found.push(chain);
    }
    found
}
