//! The section of a bevel tooth by a plane through its axis: a quadrilateral of axial place z and radius.

use crate::gear::kernel::newton::newton;

/// A side of the section at which a flank may have an edge; the root has none, it goes over into the fillet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// Tip.
    Tip,
    /// Toe: the end nearer the apex.
    Toe,
    /// Heel.
    Heel,
}

/// The axial section of a tooth flank, `[z, radius]` at its four corners, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToothSection {
    /// Corners by `[toe, heel]`, each by `[root, tip]`.
    pub corners: [[[f64; 2]; 2]; 2],
}

impl ToothSection {
    /// `[z, radius]` at shares of the face from toe to heel and of the height from root to tip.
    pub fn at(&self, face: f64, height: f64) -> [f64; 2] {
        let between = |a: [f64; 2], b: [f64; 2], share: f64| {
            [0, 1].map(|k| (1.0 - share) * a[k] + share * b[k])
        };
        let [toe, heel] = self.corners.map(|[root, tip]| between(root, tip, height));
        between(toe, heel, face)
    }

    /// Rates of `[z, radius]` over the share of the height at a share of the face.
    pub fn up(&self, face: f64) -> [f64; 2] {
        let [[a, d], [b, c]] = self.corners;
        [0, 1].map(|k| (1.0 - face) * (d[k] - a[k]) + face * (c[k] - b[k]))
    }

    /// A side as `c_z z + c_ρ ρ = c₀`, the left less the right its distance, positive outside.
    pub fn side(&self, side: Side) -> [f64; 3] {
        let [[toe_root, toe_tip], [heel_root, heel_tip]] = self.corners;
        let (from, to, inside) = match side {
            Side::Tip => (toe_tip, heel_tip, toe_root),
            Side::Toe => (toe_root, toe_tip, heel_root),
            Side::Heel => (heel_root, heel_tip, toe_root),
        };
        let [c_z, c_rho, c_0] = line(from, to);
        let sign = -(c_z * inside[0] + c_rho * inside[1] - c_0).signum();
        [sign * c_z, sign * c_rho, sign * c_0]
    }

    /// The line from root to tip at a share of the face, in the form of [`ToothSection::side`], on either side positive.
    pub fn profile(&self, face: f64) -> [f64; 3] {
        line(self.at(face, 0.0), self.at(face, 1.0))
    }

    /// Greatest length from root to tip, m.
    pub fn depth(&self) -> f64 {
        let length = |[a, b]: [[f64; 2]; 2]| f64::hypot(b[0] - a[0], b[1] - a[1]);
        length(self.corners[0]).max(length(self.corners[1]))
    }

    /// Length of the face at half height, and from root to tip at half the face, m.
    pub fn mean_lengths(&self) -> [f64; 2] {
        let length = |a: [f64; 2], b: [f64; 2]| f64::hypot(b[0] - a[0], b[1] - a[1]);
        [
            length(self.at(0.0, 0.5), self.at(1.0, 0.5)),
            length(self.at(0.5, 0.0), self.at(0.5, 1.0)),
        ]
    }

    /// Shares of face and height of `[z, radius]`, the inverse of [`ToothSection::at`]; none where the section is degenerate.
    pub fn shares(&self, place: [f64; 2]) -> Option<[f64; 2]> {
        newton([0.5, 0.5], [1.0, 1.0], |[face, height]| {
            let [[a, d], [b, c]] = self.corners;
            let here = self.at(face, height);
            let along = |k: usize| (1.0 - height) * (b[k] - a[k]) + height * (c[k] - d[k]);
            let up = self.up(face);
            Some((
                [here[0] - place[0], here[1] - place[1]],
                [[along(0), up[0]], [along(1), up[1]]],
            ))
        })
    }

    /// The runs of a line of places `[z, radius]` within the section, as shares; between a place inside and one outside the end on the side
    /// is interpolated.
    pub fn runs(&self, line: impl IntoIterator<Item = [f64; 2]>) -> Vec<Vec<[f64; 2]>> {
        let is_inside = |p: &[f64; 2]| p.iter().all(|x| (0.0..=1.0).contains(x));
        let end = |inside: [f64; 2], outside: [f64; 2]| {
            let reach = |k: usize| {
                let side = f64::from(u8::from(outside[k] > 1.0));
                match (0.0..=1.0).contains(&outside[k]) {
                    true => 1.0,
                    false => (side - inside[k]) / (outside[k] - inside[k]),
                }
            };
            let share = reach(0).min(reach(1));
            [0, 1].map(|k| inside[k] + share * (outside[k] - inside[k]))
        };
        let mut runs: Vec<Vec<[f64; 2]>> = Vec::new();
        let mut before: Option<[f64; 2]> = None;
        for place in line {
            let here = self.shares(place);
            match (before, here) {
                (Some(b), Some(h)) if is_inside(&b) => {
                    let next = if is_inside(&h) { h } else { end(b, h) };
                    runs.last_mut().into_iter().for_each(|run| run.push(next));
                }
                (Some(b), Some(h)) if is_inside(&h) => runs.push(vec![end(h, b), h]),
                (None, Some(h)) if is_inside(&h) => runs.push(vec![h]),
                _ => {}
            }
            before = here;
        }
        runs
    }
}

/// The line through two places `[z, ρ]` as `c_z z + c_ρ ρ = c₀`.
fn line(from: [f64; 2], to: [f64; 2]) -> [f64; 3] {
    let (dz, dr) = (to[0] - from[0], to[1] - from[1]);
    let length = f64::hypot(dz, dr);
    let (c_z, c_rho) = (-dr / length, dz / length);
    [c_z, c_rho, c_z * from[0] + c_rho * from[1]]
}
