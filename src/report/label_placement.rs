//! Placement of the names of points: next to their points, none over another, over a curve or outside the plot.

use super::svg::Point2;

/// Distance of a name from its point, points.
const DISTANCE: f64 = 5.0;

/// A rectangle: left and right edge, upper and lower edge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Left and right edge.
    pub across: (f64, f64),
    /// Upper and lower edge.
    pub down: (f64, f64),
}

impl Frame {
    fn about((x, y): Point2, (width, height): (f64, f64)) -> Frame {
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
        let meet = |a: (f64, f64), b: (f64, f64)| a.0 < b.1 && b.0 < a.1;
        meet(self.across, other.across) && meet(self.down, other.down)
    }

    /// Distance of a point outside.
    fn distance(&self, (x, y): Point2) -> f64 {
        let beyond = |x: f64, (low, high): (f64, f64)| (low - x).max(x - high).max(0.0);
        f64::hypot(beyond(x, self.across), beyond(y, self.down))
    }

    fn holds(&self, (x, y): Point2) -> bool {
        self.across.0 < x && x < self.across.1 && self.down.0 < y && y < self.down.1
    }
}

/// Middles of names of the widths given next to their points, the first being the most important; `None` of a name without room.
///
/// Names lie inside `room`, not over each other, and nearer to their own points than to others; over `curves` only where nothing else is
/// free.
pub fn place_labels(
    points: &[Point2],
    widths: &[f64],
    height: f64,
    room: &Frame,
    curves: &[Point2],
) -> Vec<Option<Point2>> {
    let mut taken: Vec<Frame> = Vec::new();
    let mut place = |k: usize| {
        let (x, y) = points[k];
        let (aside, above) = (0.5 * widths[k] + DISTANCE, 0.5 * height + DISTANCE);
        let candidates = [
            (x, y - above),
            (x + aside, y),
            (x - aside, y),
            (x + aside, y - above),
            (x - aside, y - above),
            (x, y + above),
            (x, y - above - height),
            (x + aside, y - above - height),
            (x - aside, y - above - height),
        ];
        let is_free = |middle: &&Point2| {
            let frame = Frame::about(**middle, (widths[k], height));
            let mut others = points.iter().enumerate().filter(|(i, _)| *i != k);
            let own = frame.distance(points[k]);
            frame.is_within(room)
                && !taken.iter().any(|other| other.overlaps(&frame))
                && others.all(|(_, point)| frame.distance(*point) > own)
        };
        let is_clear = |middle: &&Point2| {
            let frame = Frame::about(**middle, (widths[k], height));
            !curves.iter().any(|spot| frame.holds(*spot))
        };
        let free = || candidates.iter().filter(is_free);
        let middle = free().find(is_clear).or_else(|| free().next()).copied()?;
        taken.push(Frame::about(middle, (widths[k], height)));
        Some(middle)
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

    /// A free name is above its point; a curve there moves it aside; at the right edge it is on the left.
    #[test]
    fn exact_places() {
        let free = place_labels(&[(100.0, 100.0)], &[40.0], 10.0, &ROOM, &[]);
        assert_eq!(free, [Some((100.0, 90.0))]);
        let aside = place_labels(&[(100.0, 100.0)], &[40.0], 10.0, &ROOM, &[(100.0, 92.0)]);
        assert_eq!(aside, [Some((125.0, 100.0))]);
        let edge = place_labels(&[(398.0, 100.0)], &[40.0], 10.0, &ROOM, &[]);
        assert_eq!(edge, [Some((373.0, 100.0))]);
        assert_eq!(
            place_labels(&[(3.0, 3.0)], &[500.0], 10.0, &ROOM, &[]),
            [None]
        );
    }

    /// No name overlaps another, covers another point or leaves the plot.
    #[test]
    fn law_names_apart() {
        let mut rng = fastrand::Rng::with_seed(11);
        for _ in 0..200 {
            let count = rng.usize(1..40);
            let points: Vec<Point2> = (0..count)
                .map(|_| (400.0 * rng.f64(), 200.0 * rng.f64()))
                .collect();
            let widths: Vec<f64> = (0..count).map(|_| 10.0 + 80.0 * rng.f64()).collect();
            let placed = place_labels(&points, &widths, 10.0, &ROOM, &points);
            let frames: Vec<(usize, Frame)> = (placed.iter().enumerate())
                .filter_map(|(k, p)| Some((k, Frame::about((*p)?, (widths[k], 10.0)))))
                .collect();
            assert!(!frames.is_empty());
            for (i, (k, frame)) in frames.iter().enumerate() {
                assert!(frame.is_within(&ROOM));
                assert!(frames[..i].iter().all(|(_, other)| !other.overlaps(frame)));
                let mut others = points.iter().enumerate().filter(|(j, _)| j != k);
                let own = frame.distance(points[*k]);
                assert!(others.all(|(_, point)| frame.distance(*point) > own));
            }
        }
    }
}
