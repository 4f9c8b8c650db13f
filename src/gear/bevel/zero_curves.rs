//! Curves on which a function of two shares is zero, followed from places on them by steps along the tangent and a bracketed root across
//! it.

use crate::gear::kernel::root::sign_change;

/// A line of two shares, such as those of face and height.
pub type SharesLine = Vec<[f64; 2]>;

/// Step along a curve.
const STEP: f64 = 1.0 / 64.0;
/// Halvings of a step that meets no sign change across its end.
const HALVINGS: u32 = 5;
/// Most steps of a curve each way.
const MOST_STEPS: usize = 1024;
/// Half the distance over which the first tangent is found by differences.
const NEAR: f64 = 1e-4;

/// The curves through `seeds` on which `value` is zero, from side to side of the unit square or until `value` is not defined; a closed
/// curve repeats its first place. Seeds that a curve before them has passed give no second one.
pub fn zero_curves(
    value: impl Fn([f64; 2]) -> Option<f64>,
    seeds: impl IntoIterator<Item = [f64; 2]>,
) -> Vec<SharesLine> {
    let mut curves: Vec<SharesLine> = Vec::new();
    for seed in seeds {
        let is_passed = |p: &[f64; 2]| distance(*p, seed) < STEP;
        if curves.iter().flatten().any(is_passed) {
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

/// Places on the curve behind `start` in the direction of a tangent, and whether it returns to the start.
fn follow(
    value: &impl Fn([f64; 2]) -> Option<f64>,
    start: [f64; 2],
    mut tangent: [f64; 2],
) -> (SharesLine, bool) {
    let mut found: SharesLine = Vec::new();
    let (mut here, mut left) = (start, false);
    for _ in 0..MOST_STEPS {
        let steps = (0..=HALVINGS).map(|k| STEP / f64::from(1 << k));
        let across = [-tangent[1], tangent[0]];
        let mut next = steps.filter_map(|step| {
            let ahead = moved(here, tangent, step);
            root_on(value, ahead, across, step)
        });
        let Some(next) = next.next() else { break };
        if let Some(end) = end_on_side(value, here, next) {
            found.push(end);
            break;
        }
        let length = distance(here, next);
        tangent = [0, 1].map(|k| (next[k] - here[k]) / length);
        here = next;
        found.push(here);
        left |= distance(here, start) > STEP;
        if left && distance(here, start) < 0.75 * STEP {
            found.push(start);
            return (found, true);
        }
    }
    (found, false)
}

/// The place at which the curve from a place within the unit square to one outside crosses its side; none where both are within.
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
    Some(root_on(value, middle, along, distance(inside, outside)).unwrap_or(middle))
}

/// The zero within a reach of a place on a line through it.
fn root_on(
    value: &impl Fn([f64; 2]) -> Option<f64>,
    middle: [f64; 2],
    along: [f64; 2],
    reach: f64,
) -> Option<[f64; 2]> {
    let found = sign_change([-reach, reach], |w| value(moved(middle, along, w)))?;
    Some(moved(middle, along, found))
}

/// Unit tangent of the curve through a place, across the gradient by differences.
fn tangent(value: &impl Fn([f64; 2]) -> Option<f64>, at: [f64; 2]) -> Option<[f64; 2]> {
    let slope =
        |along: [f64; 2]| Some(value(moved(at, along, NEAR))? - value(moved(at, along, -NEAR))?);
    let (a, b) = (slope([1.0, 0.0])?, slope([0.0, 1.0])?);
    let length = a.hypot(b);
    (length > 0.0).then(|| [-b / length, a / length])
}

fn moved(from: [f64; 2], along: [f64; 2], by: f64) -> [f64; 2] {
    [0, 1].map(|k| from[k] + by * along[k])
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    f64::hypot(a[0] - b[0], a[1] - b[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A circle within the square is one closed curve, one that reaches over two sides ends on them; all places are on the circle.
    #[test]
    fn exact_circles() {
        for (centre, radius, ends) in [([0.5, 0.4], 0.3, None), ([0.0, 0.0], 0.6, Some([0.6, 0.6]))]
        {
            let off = |at: [f64; 2]| Some(distance(at, centre) - radius);
            let seeds = [0.1, 0.4, 1.2].map(|a: f64| moved(centre, [a.cos(), a.sin()], radius));
            let curves = zero_curves(off, seeds);
            let [curve] = &curves[..] else {
                panic!("{} curves", curves.len())
            };
            let worst = curve.iter().map(|p| off(*p).map_or(1.0, f64::abs));
            assert!(worst.fold(0.0, f64::max) < 1e-15);
            let (first, last) = (curve[0], curve[curve.len() - 1]);
            match ends {
                None => assert_eq!(first, last),
                Some([a, b]) => {
                    let apart = distance(first, [0.0, a]) + distance(last, [b, 0.0]);
                    let other = distance(last, [0.0, a]) + distance(first, [b, 0.0]);
                    assert!(apart.min(other) < 1e-15, "{first:?} {last:?}");
                }
            }
        }
    }

    /// A curve ends where the function is not defined.
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
