//! Jets: a point of a surface with its unit normal and the first derivatives of both.

use super::pose::Transform;
use super::vector::Vector;

/// A point of a surface r(u, θ) with its unit normal n(u, θ), and their first derivatives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jet {
    /// Point r.
    pub r: Vector,
    /// Unit normal n.
    pub n: Vector,
    /// `∂r/∂u`, `∂r/∂θ`.
    pub dr: [Vector; 2],
    /// `∂n/∂u`, `∂n/∂θ`.
    pub dn: [Vector; 2],
}

/// A surface that gives its jet at two parameters: a tool, or the envelope of a surface.
pub trait Surface {
    /// Frame of its coordinates.
    type Frame;

    /// The jet at `[u, θ]`; none where the surface has no normal, or where an envelope is not touched.
    fn jet(&self, at: [f64; 2]) -> Option<Jet>;

    /// Range of the first parameter u.
    fn range(&self) -> [f64; 2];

    /// Sizes of u and θ, by which steps of iterations are measured.
    fn scales(&self) -> [f64; 2];
}

impl<S: Surface> Surface for &S {
    type Frame = S::Frame;

    fn jet(&self, at: [f64; 2]) -> Option<Jet> {
        (*self).jet(at)
    }

    fn range(&self) -> [f64; 2] {
        (*self).range()
    }

    fn scales(&self) -> [f64; 2] {
        (*self).scales()
    }
}

impl Jet {
    /// The jet in the coordinates of another frame.
    #[inline]
    pub fn moved(&self, to: &Transform) -> Jet {
        Jet {
            r: to.apply(self.r),
            n: to.rotate(self.n),
            dr: self.dr.map(|d| to.rotate(d)),
            dn: self.dn.map(|d| to.rotate(d)),
        }
    }
}
