//! Zero curves of a function on the unit square, followed from seed points by steps along the tangent and a bracketed root normal
//! to it.

use crate::gear::kernel::root::sign_change;

/// Polyline in two shares, such as those of face and height.
pub type SharesLine = Vec<[f64; 2]>;

/// Step length along a curve.
const STEP: f64 = 1.0 / 64.0;
/// Maximum number of halvings of a step without a sign change across its end.
const HALVINGS: u32 = 5;
/// Maximum number of steps of a curve in each direction.
const MAX_STEPS: usize = 1024;
/// Half-step of the central differences of the gradient.
const H: f64 = 1e-4;

/// Zero curves of `value` through `seeds`, up to the sides of the unit square or to the end of the domain of `value`; a closed curve
/// repeats its first point. A seed on a preceding curve adds no curve.
pub fn zero_curves(
    value: impl Fn([f64; 2]) -> Option<f64>,
    seeds: impl IntoIterator<Item = [f64; 2]>,
) -> Vec<SharesLine> {
    let mut curves: Vec<SharesLine> = Vec::new();
    for seed in seeds {
        let is_at_seed = |p: &[f64; 2]| distance(*p, seed) < STEP;
        if curves.iter().flatten().any(is_at_seed) {
            continue;
        }
        let Some(tangent) = tangent(&value, seed) else {
            continue;
        };
        let (ahead, is_closed) = follow(&value, seed, tangent);
        let mut curve = match is_closed {
            true => Vec::new(),
            false => follow(&value, seed, tangent.map(|t| -t)).0,
        };
        curve.reverse();
        curve.push(seed);
        curve.extend(ahead);
        curves.push(curve);
    }
    curves
}

/// Points of the curve after `start` in the direction of a tangent, and true if the curve is closed.
fn follow(
    value: &impl Fn([f64; 2]) -> Option<f64>,
    start: [f64; 2],
    mut tangent: [f64; 2],
) -> (SharesLine, bool) {
    let mut points: SharesLine = Vec::new();
    let (mut point, mut has_left) = (start, false);
    for _ in 0..MAX_STEPS {
        let steps = (0..=HALVINGS).map(|k| STEP / f64::from(1 << k));
        let normal = [-tangent[1], tangent[0]];
        let mut next = steps.filter_map(|step| {
            let ahead = translate(point, tangent, step);
            root_on_line(value, ahead, normal, step)
        });
        let Some(next) = next.next() else { break };
        if let Some(end) = end_on_side(value, point, next) {
            points.push(end);
            break;
        }
        let length = distance(point, next);
        tangent = [0, 1].map(|k| (next[k] - point[k]) / length);
        point = next;
        points.push(point);
        has_left |= distance(point, start) > STEP;
        if has_left && distance(point, start) < 0.75 * STEP {
            points.push(start);
            return (points, true);
        }
    }
    (points, false)
}

/// Point where the curve crosses a side of the unit square; `None` if both points are inside.
fn end_on_side(
    value: &impl Fn([f64; 2]) -> Option<f64>,
    inside: [f64; 2],
    outside: [f64; 2],
) -> Option<[f64; 2]> {
    let crossing = |k: usize| {
        let side = outside[k].clamp(0.0, 1.0);
        let share = (side - inside[k]) / (outside[k] - inside[k]);
        (outside[k] != side).then_some((share, k, side))
    };
    let crossings = [0, 1].into_iter().filter_map(crossing);
    let (share, k, side) = crossings.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let mut middle = [0, 1].map(|i| inside[i] + share * (outside[i] - inside[i]));
    middle[k] = side;
    let along = [[0.0, 1.0], [1.0, 0.0]][k];
    Some(root_on_line(value, middle, along, distance(inside, outside)).unwrap_or(middle))
}

/// Zero on a line through `middle`, within the distance `reach`.
fn root_on_line(
    value: &impl Fn([f64; 2]) -> Option<f64>,
    middle: [f64; 2],
    along: [f64; 2],
    reach: f64,
) -> Option<[f64; 2]> {
    let offset = sign_change([-reach, reach], |w| value(translate(middle, along, w)))?;
    Some(translate(middle, along, offset))
}

/// Unit tangent of the curve, normal to the gradient by central differences.
fn tangent(value: &impl Fn([f64; 2]) -> Option<f64>, at: [f64; 2]) -> Option<[f64; 2]> {
    let slope =
        |along: [f64; 2]| Some(value(translate(at, along, H))? - value(translate(at, along, -H))?);
    let (a, b) = (slope([1.0, 0.0])?, slope([0.0, 1.0])?);
    let length = a.hypot(b);
    (length > 0.0).then(|| [-b / length, a / length])
}

fn translate(from: [f64; 2], along: [f64; 2], step: f64) -> [f64; 2] {
    [0, 1].map(|k| from[k] + step * along[k])
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    f64::hypot(a[0] - b[0], a[1] - b[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A circle within the square is one closed curve; a circle across two sides ends on them. All points are on the circle.
    #[test]
    fn exact_circles() {
        for (centre, radius, ends) in [([0.5, 0.4], 0.3, None), ([0.0, 0.0], 0.6, Some([0.6, 0.6]))]
        {
            let deviation = |at: [f64; 2]| Some(distance(at, centre) - radius);
            let seeds = [0.1, 0.4, 1.2].map(|a: f64| translate(centre, [a.cos(), a.sin()], radius));
            let curves = zero_curves(deviation, seeds);
            let [curve] = &curves[..] else {
                panic!("{} curves", curves.len())
            };
            let deviations = curve.iter().map(|p| deviation(*p).map_or(1.0, f64::abs));
            assert!(deviations.fold(0.0, f64::max) < 1e-15);
            let (first, last) = (curve[0], curve[curve.len() - 1]);
            match ends {
                None => assert_eq!(first, last),
                Some([a, b]) => {
                    let gap = distance(first, [0.0, a]) + distance(last, [b, 0.0]);
                    let reversed_gap = distance(last, [0.0, a]) + distance(first, [b, 0.0]);
                    assert!(gap.min(reversed_gap) < 1e-15, "{first:?} {last:?}");
                }
            }
        }
    }

    /// A curve ends where the function is undefined.
    #[test]
    fn survives_a_function_that_ends() {
        let value = |[a, b]: [f64; 2]| (a < 0.7).then_some(b - 0.5 * a * a);
        let curves = zero_curves(value, [[0.2, 0.02]]);
        let [curve] = &curves[..] else {
            panic!("{} curves", curves.len())
        };
        let ends = [curve[0], curve[curve.len() - 1]];
        assert!(
            ends.iter().any(|p| p[0] == 0.0) && ends.iter().any(|p| p[0] > 0.69),
            "{ends:?}"
        );
    }
}
