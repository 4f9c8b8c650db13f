//! Placement of point labels next to their points without overlap of labels, curves and plot edges.

use super::svg::Point2;

/// Distance of a label from its point, points.
const DISTANCE: f64 = 5.0;

/// Rectangle on the canvas, points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Left and right edge.
    pub across: (f64, f64),
    /// Upper and lower edge.
    pub down: (f64, f64),
}

impl Frame {
    fn centred((x, y): Point2, (width, height): (f64, f64)) -> Frame {
        Frame {
            across: (x - 0.5 * width, x + 0.5 * width),
            down: (y - 0.5 * height, y + 0.5 * height),
        }
    }

    fn is_within(&self, other: &Frame) -> bool {
        let within = |a: (f64, f64), b: (f64, f64)| a.0 >= b.0 && a.1 <= b.1;
        within(self.across, other.across) && within(self.down, other.down)
    }

    fn overlaps(&self, other: &Frame) -> bool {
        let intersect = |a: (f64, f64), b: (f64, f64)| a.0 < b.1 && b.0 < a.1;
        intersect(self.across, other.across) && intersect(self.down, other.down)
    }

    /// Distance of a point from the rectangle; zero inside.
    fn distance(&self, (x, y): Point2) -> f64 {
        let excess = |x: f64, (low, high): (f64, f64)| (low - x).max(x - high).max(0.0);
        f64::hypot(excess(x, self.across), excess(y, self.down))
    }

    fn contains(&self, (x, y): Point2) -> bool {
        self.across.0 < x && x < self.across.1 && self.down.0 < y && y < self.down.1
    }
}

/// Centres of labels of the given widths next to their points, most important first; `None` for a label without room.
///
/// Labels lie inside `room`, do not overlap, and are closest to their own points; they cover `curves` only if no other place is free.
pub fn place_labels(
    points: &[Point2],
    widths: &[f64],
    height: f64,
    room: &Frame,
    curves: &[Point2],
) -> Vec<Option<Point2>> {
    let mut occupied: Vec<Frame> = Vec::new();
    let mut place = |k: usize| {
        let (x, y) = points[k];
        let (dx, dy) = (0.5 * widths[k] + DISTANCE, 0.5 * height + DISTANCE);
        let candidates = [
            (x, y - dy),
            (x + dx, y),
            (x - dx, y),
            (x + dx, y - dy),
            (x - dx, y - dy),
            (x, y + dy),
            (x, y - dy - height),
            (x + dx, y - dy - height),
            (x - dx, y - dy - height),
        ];
        let is_free = |centre: &&Point2| {
            let frame = Frame::centred(**centre, (widths[k], height));
            let mut others = points.iter().enumerate().filter(|(i, _)| *i != k);
            let distance = frame.distance(points[k]);
            frame.is_within(room)
                && !occupied.iter().any(|other| other.overlaps(&frame))
                && others.all(|(_, point)| frame.distance(*point) > distance)
        };
        let is_clear = |centre: &&Point2| {
            let frame = Frame::centred(**centre, (widths[k], height));
            !curves.iter().any(|point| frame.contains(*point))
        };
        let free = || candidates.iter().filter(is_free);
        let centre = free().find(is_clear).or_else(|| free().next()).copied()?;
        occupied.push(Frame::centred(centre, (widths[k], height)));
        Some(centre)
    };
    (0..points.len()).map(&mut place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROOM: Frame = Frame {
        across: (0.0, 400.0),
        down: (0.0, 200.0),
    };

    /// A label lies above its point by default, on the right if a curve passes above, and on the left at the right edge.
    #[test]
    fn exact_places() {
        let above = place_labels(&[(100.0, 100.0)], &[40.0], 10.0, &ROOM, &[]);
        assert_eq!(above, [Some((100.0, 90.0))]);
        let right = place_labels(&[(100.0, 100.0)], &[40.0], 10.0, &ROOM, &[(100.0, 92.0)]);
        assert_eq!(right, [Some((125.0, 100.0))]);
        let left = place_labels(&[(398.0, 100.0)], &[40.0], 10.0, &ROOM, &[]);
        assert_eq!(left, [Some((373.0, 100.0))]);
        assert_eq!(
            place_labels(&[(3.0, 3.0)], &[500.0], 10.0, &ROOM, &[]),
            [None]
        );
    }

    /// Labels do not overlap, cover other points or leave the plot.
    #[test]
    fn law_names_apart() {
        let mut rng = fastrand::Rng::with_seed(11);
        for _ in 0..200 {
            let count = rng.usize(1..40);
            let points: Vec<Point2> = (0..count)
                .map(|_| (400.0 * rng.f64(), 200.0 * rng.f64()))
                .collect();
            let widths: Vec<f64> = (0..count).map(|_| 10.0 + 80.0 * rng.f64()).collect();
            let centres = place_labels(&points, &widths, 10.0, &ROOM, &points);
            let frames: Vec<(usize, Frame)> = (centres.iter().enumerate())
                .filter_map(|(k, p)| Some((k, Frame::centred((*p)?, (widths[k], 10.0)))))
                .collect();
            assert!(!frames.is_empty());
            for (i, (k, frame)) in frames.iter().enumerate() {
                assert!(frame.is_within(&ROOM));
                assert!(frames[..i].iter().all(|(_, other)| !other.overlaps(frame)));
                let mut others = points.iter().enumerate().filter(|(j, _)| j != k);
                let distance = frame.distance(points[*k]);
                assert!(others.all(|(_, point)| frame.distance(*point) > distance));
            }
        }
    }
}
