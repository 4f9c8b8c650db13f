//! Points of axial profiles: height, slope and second derivative over the radius.

/// A point of an axial profile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProfilePoint {
    /// Axial height g.
    pub height: f64,
    /// Slope g′.
    pub slope: f64,
    /// Second derivative g″.
    pub curvature: f64,
}

impl ProfilePoint {
    /// The point a small distance further, by its derivatives.
    pub(super) fn moved(self, by: f64) -> ProfilePoint {
        ProfilePoint {
            height: self.height + by * (self.slope + 0.5 * by * self.curvature),
            slope: self.slope + by * self.curvature,
            curvature: self.curvature,
        }
    }
}

/// Newton steps before a search is given up.
pub(super) const NEWTON_STEPS: usize = 30;
/// A Newton step below this is the last: the next would be its square, rounding.
pub(super) const LAST_STEP: f64 = 1e-9;
