//! Convexity of centrodes: the extremes of their curvature over a period.

use super::centrodes::{Centrodes, Mate, Member};

/// Samples over the range where extremes of curvature are sought.
const SAMPLES: usize = 720;

/// Extremes of the curvature of a centrode, positive where it is convex.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurvatureExtremes {
    /// Least curvature, 1/m, and the angle of gear 1 there, rad.
    pub least: [f64; 2],
    /// Largest curvature, 1/m, and the angle of gear 1 there, rad.
    pub largest: [f64; 2],
}

impl Centrodes {
    /// Extremes of a centrode's curvature over its period, counted positive where the body is convex.
    pub fn curvature_extremes(&self, member: Member) -> CurvatureExtremes {
        let sign = match (member, self.mate()) {
            (Member::Second, Some(Mate::External) | None) => -1.0,
            _ => 1.0,
        };
        let curvature = |x: f64| {
            let state = self.at(x);
            state.map_or(f64::NAN, |s| sign * s.curvatures[member as usize])
        };
        let [first, last] = self.period();
        let step = (last - first) / SAMPLES as f64;
        let at = |i: usize| first + step * i as f64;
        let extreme = |direction: f64| {
            let f = |x: f64| direction * curvature(x);
            let best =
                (0..=SAMPLES).fold(0, |best, i| if f(at(i)) > f(at(best)) { i } else { best });
            let reach = |x: f64| match self.repeats() {
                true => x,
                false => x.clamp(first, last),
            };
            let x = golden_maximum(f, reach(at(best) - step), reach(at(best) + step));
            [curvature(x), x]
        };
        CurvatureExtremes {
            least: extreme(-1.0),
            largest: extreme(1.0),
        }
    }
}

/// Place of a maximum between two places, by golden section.
fn golden_maximum(f: impl Fn(f64) -> f64, low: f64, high: f64) -> f64 {
    const SHRINK: f64 = 0.618_033_988_749_894_9;
    let (mut low, mut high) = (low, high);
    let inner = |low: f64, high: f64| {
        let reach = SHRINK * (high - low);
        (high - reach, low + reach)
    };
    for _ in 0..60 {
        let (x1, x2) = inner(low, high);
        match f(x1) > f(x2) {
            true => high = x2,
            false => low = x1,
        }
    }
    0.5 * (low + high)
}
