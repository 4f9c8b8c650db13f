//! Curvature of a tool and of its envelope: `W₂ = W₁ + p pᵀ/D`, `p = −W₁ v + n×w`, `D = p·v − Φ`.
//!
//! Litvin and Fuentes, Gear Geometry and Applied Theory, 2nd ed. 2004, chapter 8; Baxter 1973 reads the same as the speed of the contact
//! line over both bodies.

use super::jet::Jet;
use super::meeting::MeshingState;
use super::vector::Vector;

/// Curvature operator W of a surface at a point, `dn = −W dr`: metal that bulges is negative.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Curvature {
    /// Unit tangent along `∂r/∂u`, and n × that.
    pub tangents: [Vector; 2],
    /// `W₁₁`, `W₁₂`, `W₂₂` in those tangents.
    pub components: [f64; 3],
}

/// Second-order properties of a surface and its envelope where they touch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SecondOrder {
    /// Curvature W₁ of the moving surface.
    pub tool: Curvature,
    /// Tangent vector p with `p·r_u = f_u`, `p·r_θ = f_θ`, in the tangents of W₁; the contact line is perpendicular to it.
    pub p: [f64; 2],
    /// `D = p·v − Φ`: zero at undercut, the limit of the first kind.
    pub undercut: f64,
    /// `Φ = ∂f/∂x`: zero at the limit of the second kind.
    pub second_limit: f64,
}

impl Curvature {
    /// The curvature operator of a jet; none where its tangents are parallel.
    pub fn of(jet: &Jet) -> Option<Curvature> {
        let length = jet.dr[0].norm();
        let e1 = jet.dr[0].unit()?;
        let e2 = jet.n.cross(e1);
        let (a, b) = (jet.dr[1].dot(e1), jet.dr[1].dot(e2));
        let w11 = -jet.dn[0].dot(e1) / length;
        let w12 = -jet.dn[0].dot(e2) / length;
        let w22 = -(jet.dn[1].dot(e2) + a * w12) / b;
        w22.is_finite().then_some(Curvature {
            tangents: [e1, e2],
            components: [w11, w12, w22],
        })
    }

    /// Components of a tangent vector.
    pub fn in_tangents(&self, a: Vector) -> [f64; 2] {
        self.tangents.map(|e| a.dot(e))
    }

    /// `aᵀ W b` for two tangent vectors.
    pub fn between(&self, a: Vector, b: Vector) -> f64 {
        let ([a1, a2], [b1, b2]) = (self.in_tangents(a), self.in_tangents(b));
        let [w11, w12, w22] = self.components;
        a1 * (w11 * b1 + w12 * b2) + a2 * (w12 * b1 + w22 * b2)
    }

    /// Normal curvature along a unit tangent vector.
    pub fn normal(&self, along: Vector) -> f64 {
        self.between(along, along)
    }

    /// Geodesic torsion along a unit tangent vector t: `tᵀ W (n×t)`.
    pub fn torsion(&self, along: Vector) -> f64 {
        let [e1, e2] = self.tangents;
        let [a1, a2] = self.in_tangents(along);
        self.between(along, e2 * a1 - e1 * a2)
    }

    /// Principal curvatures, the lower first, each with its unit direction.
    pub fn principal(&self) -> [(f64, Vector); 2] {
        let [w11, w12, w22] = self.components;
        let angle = 0.5 * f64::atan2(2.0 * w12, w11 - w22);
        let (mean, radius) = (0.5 * (w11 + w22), f64::hypot(0.5 * (w11 - w22), w12));
        let (sin, cos) = angle.sin_cos();
        let [e1, e2] = self.tangents;
        [
            (mean - radius, e2 * cos - e1 * sin),
            (mean + radius, e1 * cos + e2 * sin),
        ]
    }

    /// Gaussian curvature `det W`.
    pub fn gaussian(&self) -> f64 {
        let [w11, w12, w22] = self.components;
        w11 * w22 - w12 * w12
    }
}

impl SecondOrder {
    /// The second order at a meeting with f = 0; none where the jet's tangents are parallel.
    pub fn of(meeting: &MeshingState) -> Option<SecondOrder> {
        let jet = &meeting.jet;
        let tool = Curvature::of(jet)?;
        let [f_u, f_theta, f_x] = meeting.gradient;
        let [a, b] = tool.in_tangents(jet.dr[1]);
        let p1 = f_u / jet.dr[0].norm();
        let p = [p1, (f_theta - a * p1) / b];
        let v = tool.in_tangents(meeting.velocity);
        Some(SecondOrder {
            tool,
            p,
            undercut: p[0] * v[0] + p[1] * v[1] - f_x,
            second_limit: f_x,
        })
    }

    /// Curvature of the envelope, `W₂ = W₁ + p pᵀ/D`; none at an undercut limit.
    pub fn envelope(&self) -> Option<Curvature> {
        let [w11, w12, w22] = self.tool.components;
        let ([p1, p2], d) = (self.p, self.undercut);
        let components = [w11 + p1 * p1 / d, w12 + p1 * p2 / d, w22 + p2 * p2 / d];
        components
            .iter()
            .all(|w| w.is_finite())
            .then_some(Curvature {
                components,
                ..self.tool
            })
    }

    /// Unit tangent of the contact line, perpendicular to p; none where p = 0.
    pub fn contact_line(&self) -> Option<Vector> {
        let [e1, e2] = self.tool.tangents;
        (e2 * self.p[0] - e1 * self.p[1]).unit()
    }

    /// Speeds of the contact line across itself, along p, over the tool `−Φ/|p|` and over the work `D/|p|`, a unit of x; none where p = 0.
    pub fn contact_line_speeds(&self) -> Option<[f64; 2]> {
        let length = f64::hypot(self.p[0], self.p[1]);
        (length > 0.0).then(|| [-self.second_limit / length, self.undercut / length])
    }
}
