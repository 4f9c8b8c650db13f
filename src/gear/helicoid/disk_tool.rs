//! Profile of the disk tool that cuts a helicoid: the normal of the helicoid meets the axis of the tool.

use super::axial_profile::Helicoid;
use super::grinding_wheel::ToolAxis;
use super::profile_point::{LAST_STEP, NEWTON_STEPS};
use crate::gear::kernel::root::{greatest, root};

/// A point of a disk tool's profile, with the point of the helicoid that it cuts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DiskPoint {
    /// Distance ρ from the axis of the helicoid.
    pub distance: f64,
    /// Azimuth χ of the contact, rad.
    pub azimuth: f64,
    /// Radius R of the tool.
    pub radius: f64,
    /// Height ζ of the tool.
    pub height: f64,
    /// Slope `t = −dζ/dR`.
    pub slope: f64,
}

/// Place where a disk tool cuts into the flank that it should leave.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interference {
    /// Distance ρ from the axis of the helicoid.
    pub distance: f64,
    /// Depth along the radius of the tool.
    pub depth: f64,
}

/// Half of the arc that is searched, rad.
const ARC: f64 = 1.2;
/// Parts of the arc.
const ARC_PARTS: u32 = 24;
/// Contacts whose heights are searched.
const CONTACTS: u32 = 24;

impl ToolAxis {
    /// The tool's profile at rising distances from the helicoid's axis; points where no normal meets the tool's axis are left out.
    ///
    /// Each contact is sought near that of the neighbouring distance, from the one nearest the middle of the tool (χ = 0) to both ends.
    pub fn disk_profile(&self, helicoid: &Helicoid, distances: &[f64]) -> Vec<DiskPoint> {
        let starts = distances
            .iter()
            .enumerate()
            .filter_map(|(k, distance)| Some((k, self.disk_point(helicoid, *distance, 0.0)?)));
        let middle = starts.min_by(|a, b| a.1.azimuth.abs().total_cmp(&b.1.azimuth.abs()));
        let Some((start, first)) = middle else {
            return Vec::new();
        };
        let march = |distances: &mut dyn Iterator<Item = &f64>| -> Vec<DiskPoint> {
            let mut azimuth = first.azimuth;
            distances
                .map_while(|distance| {
                    let point = self.disk_point(helicoid, *distance, azimuth)?;
                    azimuth = point.azimuth;
                    Some(point)
                })
                .collect()
        };
        let mut profile = march(&mut distances[..start].iter().rev());
        profile.reverse();
        profile.push(first);
        profile.extend(march(&mut distances[start + 1..].iter()));
        profile
    }

    /// The tool's profile at a distance from the helicoid's axis, with the contact near an azimuth; none where no normal meets the tool's
    /// axis.
    ///
    /// `(ρ + z g′) sin S cos χ − (z p/ρ) sin S sin χ + A cos S (g′ sin χ + (p/ρ) cos χ) = A sin S + p cos S` with `z = g + p χ`.
    pub fn disk_point(&self, helicoid: &Helicoid, distance: f64, near: f64) -> Option<DiskPoint> {
        let at = helicoid.at(distance)?;
        let (g, slope, p) = (at.height, at.slope, helicoid.lead);
        let (s, c) = self.angle.sin_cos();
        let steep = p / distance;
        let meets = |chi: f64| {
            let (sine, cosine) = chi.sin_cos();
            let z = g + p * chi;
            let value = (distance + z * slope) * s * cosine - z * steep * s * sine
                + self.distance * c * (slope * sine + steep * cosine)
                - self.distance * s
                - p * c;
            let derivative = p * slope * s * cosine
                - (distance + z * slope) * s * sine
                - steep * s * (p * sine + z * cosine)
                + self.distance * c * (slope * cosine - steep * sine);
            Some([value, derivative])
        };
        let chi = newton(near, meets).or_else(|| root([near - 1.0, near + 1.0], meets))?;
        let [radius, height] = self.seen(helicoid, g, distance, chi);
        // Normal and point in the tool's frame give its slope.
        let (sine, cosine) = chi.sin_cos();
        let normal = [
            -slope * cosine + steep * sine,
            -slope * sine - steep * cosine,
            1.0,
        ];
        let z = g + p * chi;
        let from_axis = [distance * cosine - self.distance, distance * sine, z];
        let axial = |v: [f64; 3]| -v[1] * s + v[2] * c;
        let along = axial(normal);
        let radial = (normal
            .iter()
            .zip(&from_axis)
            .map(|(n, q)| n * q)
            .sum::<f64>()
            - along * axial(from_axis))
            / radius;
        Some(DiskPoint {
            distance,
            azimuth: chi,
            radius,
            height,
            slope: radial / along,
        })
    }

    /// Radius and height, in the tool, of the helicoid's point at a distance and an azimuth.
    fn seen(&self, helicoid: &Helicoid, g: f64, distance: f64, chi: f64) -> [f64; 2] {
        let (s, c) = self.angle.sin_cos();
        let (sine, cosine) = chi.sin_cos();
        let z = g + helicoid.lead * chi;
        let [x, y] = [distance * cosine - self.distance, distance * sine];
        [f64::hypot(x, y * c + z * s), z * c - y * s]
    }

    /// The deepest place between two distances where the tool of a flank cuts into that flank; none where it cuts nowhere by more than a
    /// tolerance.
    ///
    /// At the height of each contact the whole arc of the flank is compared with the radius of the tool, so that cusps and second contacts show.
    pub fn interference(
        &self,
        helicoid: &Helicoid,
        distances: [f64; 2],
        tolerance: f64,
    ) -> Option<Interference> {
        let [from, to] = distances;
        let place = |i: u32| from + (to - from) * f64::from(i) / f64::from(CONTACTS);
        let places: Vec<f64> = (0..=CONTACTS).map(place).collect();
        let contacts = self.disk_profile(helicoid, &places).into_iter();
        let cuts = contacts.filter_map(|contact| {
            let depth = contact.radius - self.least_radius(helicoid, distances, contact.height)?;
            let distance = contact.distance;
            (depth > tolerance).then_some(Interference { distance, depth })
        });
        cuts.max_by(|a, b| a.depth.total_cmp(&b.depth))
    }

    /// Least radius, in the tool, of the flank's points at a height of the tool.
    fn least_radius(&self, helicoid: &Helicoid, distances: [f64; 2], height: f64) -> Option<f64> {
        let (s, c) = self.angle.sin_cos();
        let radius = |chi: f64| {
            let place = root(distances, |distance| {
                let at = helicoid.at(distance)?;
                let here = (at.height + helicoid.lead * chi) * c - distance * chi.sin() * s;
                Some([here - height, at.slope * c - chi.sin() * s])
            })?;
            let g = helicoid.at(place)?.height;
            Some(self.seen(helicoid, g, place, chi)[0])
        };
        let [_, nearest] = greatest([-ARC, ARC], ARC_PARTS, |chi| Some(-radius(chi)?))?;
        Some(-nearest)
    }
}

fn newton(near: f64, f: impl Fn(f64) -> Option<[f64; 2]>) -> Option<f64> {
    let mut chi = near;
    for _ in 0..NEWTON_STEPS {
        let [value, slope] = f(chi)?;
        let step = value / slope;
        chi -= step;
        if !((chi - near).abs() < 1.0) {
            return None;
        }
        if step.abs() < LAST_STEP {
            return Some(chi);
        }
    }
    None
}
