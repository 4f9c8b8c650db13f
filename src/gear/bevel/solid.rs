//! The solid of a bevel gear as triangles: teeth with fillets and lands, ends, and an inner face one tooth depth below the root.

use super::tooth::BevelTooth;
use crate::gear::kernel::pose::Transform;
use crate::gear::kernel::vector::Vector;

/// Steps of a land, top or root.
const LAND: usize = 3;
/// Bisections of the height at which a flank begins.
const BISECTIONS: usize = 40;
/// Least radius of the inner face, in radii of the root above it.
const LEAST_INNER: f64 = 0.3;

/// Triangles over shared points, normals outward by the right-hand rule; lengths in m.
#[derive(Debug, Clone, PartialEq)]
pub struct Solid {
    /// Points.
    pub points: Vec<[f64; 3]>,
    /// Triangles by their points.
    pub triangles: Vec<[usize; 3]>,
}

/// One pitch of the surface of a gear: rings of equally many points, toe to heel and back along the inner face; each ring goes on in the
/// next pitch, the last is joined to the first. Lengths in m.
#[derive(Debug, Clone, PartialEq)]
pub struct Sector {
    /// Points, ring by ring.
    pub points: Vec<[f64; 3]>,
    /// Number of rings.
    pub rings: usize,
}

/// A point in cylindrical coordinates.
#[derive(Debug, Clone, Copy)]
struct Cylindrical {
    z: f64,
    radius: f64,
    azimuth: f64,
}

impl BevelTooth {
    /// The solid of the whole gear, `rows` points along the height and `columns` along the face; none where a flank does not exist or the
    /// flanks meet below the tip.
    pub fn solid(&self, rows: usize, columns: usize) -> Option<Solid> {
        let pitch = self.pitch();
        let whole = |ring: Vec<Cylindrical>| -> Vec<Cylindrical> {
            let turned = (0..self.teeth).flat_map(|tooth| {
                ring.iter().map(move |p| Cylindrical {
                    azimuth: p.azimuth + pitch * f64::from(tooth),
                    ..*p
                })
            });
            turned.collect()
        };
        let rings = self.rings(rows, columns)?.into_iter().map(whole);
        Some(Solid::of_rings(&rings.collect::<Vec<_>>()))
    }

    /// One pitch of the solid.
    pub fn sector(&self, rows: usize, columns: usize) -> Option<Sector> {
        let rings = self.rings(rows, columns)?;
        Some(Sector {
            points: rings.iter().flatten().map(Cylindrical::point).collect(),
            rings: rings.len(),
        })
    }

    /// Rings of one pitch: the sections of the teeth from toe to heel, then the inner face from heel to toe.
    fn rings(&self, rows: usize, columns: usize) -> Option<Vec<Vec<Cylindrical>>> {
        let sections: Option<Vec<Vec<Cylindrical>>> = (0..columns)
            .map(|i| self.profile(i as f64 / (columns - 1) as f64, rows))
            .collect();
        let mut rings = sections?;
        let section = &self.flanks[0].section;
        for face in [1.0, 0.0] {
            let (root, below) = (section.at(face, 0.0), section.at(face, -1.0));
            let share = match below[1] < LEAST_INNER * root[1] {
                true => (1.0 - LEAST_INNER) * root[1] / (root[1] - below[1]),
                false => 1.0,
            };
            let [z, radius] = section.at(face, -share);
            let outer = &rings[if face == 1.0 { columns - 1 } else { 0 }];
            let inner = outer.iter().map(|p| Cylindrical { z, radius, ..*p });
            rings.push(inner.collect());
        }
        Some(rings)
    }

    /// One tooth and the root land behind it at a share of the face, by growing azimuth.
    fn profile(&self, face: f64, rows: usize) -> Option<Vec<Cylindrical>> {
        let section = &self.flanks[0].section;
        let at = |flank: usize, height: f64| {
            let place @ [z, radius] = section.at(face, height);
            let (_, azimuth) = self.point(flank, place)?;
            Some(Cylindrical { z, radius, azimuth })
        };
        let side = |flank: usize| -> Option<Vec<Cylindrical>> {
            let mut bottom = 0.0;
            if at(flank, bottom).is_none() {
                let (mut missing, mut found) = (0.0, 0.5);
                at(flank, found)?;
                for _ in 0..BISECTIONS {
                    let middle = 0.5 * (missing + found);
                    match at(flank, middle) {
                        Some(_) => found = middle,
                        None => missing = middle,
                    }
                }
                bottom = found;
            }
            (0..rows)
                .map(|j| {
                    at(
                        flank,
                        bottom + (1.0 - bottom) * j as f64 / (rows - 1) as f64,
                    )
                })
                .collect()
        };
        let [first, second] = self.by_azimuth();
        let (mut points, down) = (side(first)?, side(second)?);
        let (tip, other) = (points[rows - 1], down[rows - 1]);
        if other.azimuth <= tip.azimuth {
            return None;
        }
        points.extend(land(tip, other));
        points.extend(down.iter().rev());
        let next = Cylindrical {
            azimuth: points[0].azimuth + self.pitch(),
            ..points[0]
        };
        let last = points[points.len() - 1];
        if next.azimuth <= last.azimuth {
            return None;
        }
        points.extend(land(last, next));
        Some(points)
    }
}

impl Cylindrical {
    fn point(&self) -> [f64; 3] {
        let (sin, cos) = self.azimuth.sin_cos();
        [self.radius * cos, self.radius * sin, self.z]
    }
}

/// Points between two ends of a land.
fn land(from: Cylindrical, to: Cylindrical) -> impl Iterator<Item = Cylindrical> {
    (1..=LAND).map(move |i| {
        let share = i as f64 / (LAND + 1) as f64;
        let between = |a: f64, b: f64| a + share * (b - a);
        Cylindrical {
            z: between(from.z, to.z),
            radius: between(from.radius, to.radius),
            azimuth: between(from.azimuth, to.azimuth),
        }
    })
}

impl Solid {
    /// The torus over rings of equally many points, each joined to the next and the last to the first.
    fn of_rings(rings: &[Vec<Cylindrical>]) -> Solid {
        let (count, around) = (rings.len(), rings[0].len());
        let points: Vec<[f64; 3]> = rings.iter().flatten().map(Cylindrical::point).collect();
        let mut triangles = Vec::with_capacity(2 * points.len());
        for ring in 0..count {
            for k in 0..around {
                let (next_ring, next) = ((ring + 1) % count, (k + 1) % around);
                let [a, b] = [k, next].map(|i| ring * around + i);
                let [d, c] = [k, next].map(|i| next_ring * around + i);
                triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        let mut solid = Solid { points, triangles };
        if solid.volume() < 0.0 {
            solid.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        solid
    }

    /// Moves the solid.
    pub fn place(&mut self, pose: &Transform) {
        for point in &mut self.points {
            let [x, y, z] = *point;
            *point = pose.apply(Vector::new(x, y, z)).array();
        }
    }

    /// Volume within the triangles, m³.
    pub fn volume(&self) -> f64 {
        let sixth = |t: &[usize; 3]| {
            let [a, b, c] = t.map(|i| self.points[i]);
            let cross = [
                b[1] * c[2] - b[2] * c[1],
                b[2] * c[0] - b[0] * c[2],
                b[0] * c[1] - b[1] * c[0],
            ];
            (a[0] * cross[0] + a[1] * cross[1] + a[2] * cross[2]) / 6.0
        };
        self.triangles.iter().map(sixth).sum()
    }
}
