//! Grid layout of the components of a drive train: shafts along rows, meshes between rows.

use std::collections::HashSet;

/// Number of grid columns: longer shafts continue in another row.
const COLUMNS: i64 = 11;

/// Grid position: column to the right, row downwards.
pub type GridPlace = (i64, i64);

/// Direction of a link from its first to its second component.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum LinkSide {
    /// Along the shaft.
    Along,
    /// Across the shaft, in another row.
    Across,
}

/// Linked components of a component, each with the direction of its link.
pub type Neighbours = Vec<(usize, LinkSide)>;

/// Grid positions of components of `sizes` cells along both axes, each next to a linked component, or as near as possible.
///
/// Links are traversed depth first from the first component, those along a shaft first. The lowest column and row are 0.
pub fn place_parts(sizes: &[i64], neighbours: &[Neighbours]) -> Vec<GridPlace> {
    let mut grid = Grid::default();
    let mut positions: Vec<Option<GridPlace>> = vec![None; sizes.len()];
    for root in 0..sizes.len() {
        let mut stack = vec![(root, None)];
        while let Some((part, origin)) = stack.pop() {
            if positions[part].is_some() {
                continue;
            }
            let options = match origin {
                Some((other, side)) => {
                    let pos: Option<GridPlace> = positions[other];
                    adjacent_places(pos.unwrap_or_default(), sizes[other], sizes[part], side)
                }
                None => vec![(0, grid.below)],
            };
            positions[part] = Some(grid.occupy(&options, sizes[part]));
            let mut linked = neighbours[part].clone();
            linked.sort_by_key(|n| n.1);
            let linked = linked.into_iter().rev();
            stack.extend(linked.map(|(other, side)| (other, Some((part, side)))));
        }
    }
    let positions: Vec<GridPlace> = positions.into_iter().flatten().collect();
    let lowest = |key: fn(&GridPlace) -> i64| positions.iter().map(key).min().unwrap_or(0);
    let (left, top) = (lowest(|p| p.0), lowest(|p| p.1));
    positions.iter().map(|p| (p.0 - left, p.1 - top)).collect()
}

/// Candidate positions next to a component, by preference.
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

/// Occupied cells of the grid.
#[derive(Default)]
struct Grid {
    occupied: HashSet<GridPlace>,
    /// First row below all occupied cells.
    below: i64,
}

impl Grid {
    /// Occupies the first free candidate position, or the free position nearest to the first candidate.
    fn occupy(&mut self, options: &[GridPlace], size: i64) -> GridPlace {
        let first = options.first().copied().unwrap_or_default();
        let free = options.iter().copied().find(|&pos| self.is_free(pos, size));
        let pos = free.unwrap_or_else(|| self.nearest(first, size));
        self.occupied.extend(cells(pos, size));
        self.below = self.below.max(pos.1 + size);
        pos
    }

    fn is_free(&self, pos: GridPlace, size: i64) -> bool {
        let is_within = pos.0 >= 0 && pos.0 + size <= COLUMNS;
        is_within && cells(pos, size).all(|cell| !self.occupied.contains(&cell))
    }

    /// Free position nearest to another, preferably below it.
    fn nearest(&self, (column, row): GridPlace, size: i64) -> GridPlace {
        let distance = |pos: &GridPlace| ((pos.0 - column).abs() + (pos.1 - row).abs(), -pos.1);
        let top = row - COLUMNS;
        let rows = top..=self.below.max(row);
        let grid = rows.flat_map(|r| (0..COLUMNS).map(move |c| (c, r)));
        let free = grid.filter(|&pos| self.is_free(pos, size));
        free.min_by_key(distance).unwrap_or((0, self.below))
    }
}

fn cells((column, row): GridPlace, size: i64) -> impl Iterator<Item = GridPlace> {
    (0..size).flat_map(move |i| (0..size).map(move |k| (column + i, row + k)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Components share no cell for any links; the grid starts at 0 and keeps its width.
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
            let positions = place_parts(&sizes, &neighbours);
            let all: Vec<GridPlace> = positions
                .iter()
                .zip(&sizes)
                .flat_map(|(&pos, &s)| cells(pos, s))
                .collect();
            let distinct: HashSet<GridPlace> = all.iter().copied().collect();
            assert_eq!(distinct.len(), all.len());
            assert!(all.iter().all(|p| p.0 >= 0 && p.1 >= 0 && p.0 < COLUMNS));
        }
    }

    /// A shaft of 14 discs continues in the next row after the eleventh.
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
        let positions = place_parts(&[1; 14], &neighbours);
        assert_eq!(positions[10], (10, 0));
        assert_eq!(positions[11], (10, 1));
        assert_eq!(positions[12], (9, 1));
    }
}
