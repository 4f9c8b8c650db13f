//! Places of the parts of a drive train on a grid: shafts along rows, meshes between rows.

use std::collections::HashSet;

/// Columns of the grid: longer shafts turn back in another row.
const COLUMNS: i64 = 11;

/// A place on the grid: column to the right, row downwards.
pub type GridPlace = (i64, i64);

/// Side of a link on which its second part is placed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum LinkSide {
    /// Along the shaft.
    Along,
    /// Across the shaft, in another row.
    Across,
}

/// The part at the other end of each link of a part.
pub type Neighbours = Vec<(usize, LinkSide)>;

/// The places of parts of `sizes` cells along both axes, each next to a part it is linked to where there is room, else as near as possible.
///
/// Links are followed depth first from the first part, those along a shaft before those across. The least column and row are 0.
pub fn place_parts(sizes: &[i64], neighbours: &[Neighbours]) -> Vec<GridPlace> {
    let mut grid = Grid::default();
    let mut places: Vec<Option<GridPlace>> = vec![None; sizes.len()];
    for root in 0..sizes.len() {
        let mut stack = vec![(root, None)];
        while let Some((part, from)) = stack.pop() {
            if places[part].is_some() {
                continue;
            }
            let wanted = match from {
                Some((other, side)) => {
                    let at: Option<GridPlace> = places[other];
                    adjacent_places(at.unwrap_or_default(), sizes[other], sizes[part], side)
                }
                None => vec![(0, grid.below)],
            };
            places[part] = Some(grid.take(&wanted, sizes[part]));
            let mut next = neighbours[part].clone();
            next.sort_by_key(|n| n.1);
            let next = next.into_iter().rev();
            stack.extend(next.map(|(other, side)| (other, Some((part, side)))));
        }
    }
    let places: Vec<GridPlace> = places.into_iter().flatten().collect();
    let least = |of: fn(&GridPlace) -> i64| places.iter().map(of).min().unwrap_or(0);
    let (left, top) = (least(|p| p.0), least(|p| p.1));
    places.iter().map(|p| (p.0 - left, p.1 - top)).collect()
}

/// Places next to a part for another, the best first.
fn adjacent_places(
    (column, row): GridPlace,
    size: i64,
    new: i64,
    side: LinkSide,
) -> Vec<GridPlace> {
    let (middle_row, middle_column) = (row + (size - new) / 2, column + (size - new) / 2);
    let along = [(column + size, middle_row), (column - new, middle_row)];
    let across = [(middle_column, row + size), (middle_column, row - new)];
    match side {
        LinkSide::Along => [along, across].concat(),
        LinkSide::Across => [across, along].concat(),
    }
}

/// The cells in use.
#[derive(Default)]
struct Grid {
    used: HashSet<GridPlace>,
    /// The first row below all cells in use.
    below: i64,
}

impl Grid {
    /// Takes the first place that is free, else the nearest to the first.
    fn take(&mut self, wanted: &[GridPlace], size: i64) -> GridPlace {
        let first = wanted.first().copied().unwrap_or_default();
        let found = wanted.iter().copied().find(|&at| self.is_free(at, size));
        let at = found.unwrap_or_else(|| self.nearest(first, size));
        self.used.extend(cells(at, size));
        self.below = self.below.max(at.1 + size);
        at
    }

    fn is_free(&self, at: GridPlace, size: i64) -> bool {
        let inside = at.0 >= 0 && at.0 + size <= COLUMNS;
        inside && cells(at, size).all(|cell| !self.used.contains(&cell))
    }

    /// The free place nearest to another, that below before that above.
    fn nearest(&self, (column, row): GridPlace, size: i64) -> GridPlace {
        let distance = |at: &GridPlace| ((at.0 - column).abs() + (at.1 - row).abs(), -at.1);
        let top = row - COLUMNS;
        let rows = top..=self.below.max(row);
        let all = rows.flat_map(|r| (0..COLUMNS).map(move |c| (c, r)));
        let free = all.filter(|&at| self.is_free(at, size));
        free.min_by_key(distance).unwrap_or((0, self.below))
    }
}

fn cells((column, row): GridPlace, size: i64) -> impl Iterator<Item = GridPlace> {
    (0..size).flat_map(move |i| (0..size).map(move |k| (column + i, row + k)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// No two parts share a cell, whatever the links; the grid begins at 0 and keeps its width.
    #[test]
    fn law_parts_have_cells_of_their_own() {
        let mut rng = fastrand::Rng::with_seed(24);
        for _ in 0..100 {
            let count = rng.usize(1..60);
            let size = |_| if rng.u8(..) < 20 { 3 } else { 1 };
            let sizes: Vec<i64> = (0..count).map(size).collect();
            let mut neighbours = vec![Vec::new(); count];
            for part in 1..count {
                let other = rng.usize(part.saturating_sub(4)..part);
                let side = if rng.bool() {
                    LinkSide::Along
                } else {
                    LinkSide::Across
                };
                neighbours[part].push((other, side));
                neighbours[other].push((part, side));
            }
            let places = place_parts(&sizes, &neighbours);
            let all: Vec<GridPlace> = places
                .iter()
                .zip(&sizes)
                .flat_map(|(&at, &s)| cells(at, s))
                .collect();
            let apart: HashSet<GridPlace> = all.iter().copied().collect();
            assert_eq!(apart.len(), all.len());
            assert!(all.iter().all(|p| p.0 >= 0 && p.1 >= 0 && p.0 < COLUMNS));
        }
    }

    /// A shaft of 14 discs turns back after the eleventh.
    #[test]
    fn exact_long_shafts_turn_back() {
        let links = |k: usize| [k.checked_sub(1), (k < 13).then_some(k + 1)];
        let neighbours: Vec<Neighbours> = (0..14)
            .map(|k| {
                links(k)
                    .into_iter()
                    .flatten()
                    .map(|o| (o, LinkSide::Along))
                    .collect()
            })
            .collect();
        let places = place_parts(&[1; 14], &neighbours);
        assert_eq!(places[10], (10, 0));
        assert_eq!(places[11], (10, 1));
        assert_eq!(places[12], (9, 1));
    }
}
