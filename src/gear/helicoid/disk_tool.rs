//! Profile of the disk tool that cuts a helicoid: contact where the normal of the helicoid intersects the tool axis.

use super::axial_profile::Helicoid;
use super::grinding_wheel::ToolAxis;
use super::profile_point::{LAST_STEP, NEWTON_STEPS};
use crate::gear::kernel::root::{greatest, root};

/// Profile point of a disk tool with its contact point on the helicoid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DiskPoint {
    /// Distance ρ from the axis of the helicoid, m.
    pub distance: f64,
    /// Azimuth χ of the contact, rad.
    pub azimuth: f64,
    /// Tool radius R, m.
    pub radius: f64,
    /// Axial height ζ on the tool, m.
    pub height: f64,
    /// Slope `t = −dζ/dR`.
    pub slope: f64,
}

/// Position at which a disk tool cuts into the finished flank.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interference {
    /// Distance ρ from the axis of the helicoid, m.
    pub distance: f64,
    /// Depth along the tool radius, m.
    pub depth: f64,
}

/// Half the azimuth range searched, rad.
const ARC: f64 = 1.2;
/// Number of intervals of the azimuth range.
const ARC_PARTS: u32 = 24;
/// Number of intervals of the distance; the tool heights of their ends are examined.
const CONTACTS: u32 = 24;

impl ToolAxis {
    /// Tool profile at increasing distances from the helicoid axis, m; points without a normal that intersects the tool axis are omitted.
    ///
    /// The search starts at the contact nearest χ = 0 and proceeds to both ends, each contact from that of the neighbouring distance.
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

    /// Tool profile at a distance from the helicoid axis, with the contact near the azimuth `start`, rad; `None` if no normal intersects
    /// the tool axis.
    ///
    /// `(ρ + z g′) sin S cos χ − (z p/ρ) sin S sin χ + A cos S (g′ sin χ + (p/ρ) cos χ) = A sin S + p cos S` with `z = g + p χ`.
    pub fn disk_point(&self, helicoid: &Helicoid, distance: f64, start: f64) -> Option<DiskPoint> {
        let at = helicoid.at(distance)?;
        let (g, slope, p) = (at.height, at.slope, helicoid.lead);
        let (s, c) = self.angle.sin_cos();
        let lead_slope = p / distance;
        let f = |chi: f64| {
            let (sine, cosine) = chi.sin_cos();
            let z = g + p * chi;
            let value = (distance + z * slope) * s * cosine - z * lead_slope * s * sine
                + self.distance * c * (slope * sine + lead_slope * cosine)
                - self.distance * s
                - p * c;
            let derivative = p * slope * s * cosine
                - (distance + z * slope) * s * sine
                - lead_slope * s * (p * sine + z * cosine)
                + self.distance * c * (slope * cosine - lead_slope * sine);
            Some([value, derivative])
        };
        let chi = newton(start, f).or_else(|| root([start - 1.0, start + 1.0], f))?;
        let [radius, height] = self.tool_coordinates(helicoid, g, distance, chi);
        // The slope follows from normal and point in the tool frame.
        let (sine, cosine) = chi.sin_cos();
        let normal = [
            -slope * cosine + lead_slope * sine,
            -slope * sine - lead_slope * cosine,
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

    /// Tool radius and height of the helicoid point with the axial height `g`, the distance and the azimuth `chi`.
    fn tool_coordinates(&self, helicoid: &Helicoid, g: f64, distance: f64, chi: f64) -> [f64; 2] {
        let (s, c) = self.angle.sin_cos();
        let (sine, cosine) = chi.sin_cos();
        let z = g + helicoid.lead * chi;
        let [x, y] = [distance * cosine - self.distance, distance * sine];
        [f64::hypot(x, y * c + z * s), z * c - y * s]
    }

    /// Deepest interference of the tool with its own flank between two distances; `None` if no depth exceeds `tolerance`, m.
    ///
    /// At the height of each contact the tool radius is compared with the flank over the azimuth range, which detects cusps and second
    /// contacts.
    pub fn interference(
        &self,
        helicoid: &Helicoid,
        distances: [f64; 2],
        tolerance: f64,
    ) -> Option<Interference> {
        let [from, to] = distances;
        let distance_at = |i: u32| from + (to - from) * f64::from(i) / f64::from(CONTACTS);
        let grid: Vec<f64> = (0..=CONTACTS).map(distance_at).collect();
        let contacts = self.disk_profile(helicoid, &grid).into_iter();
        let interferences = contacts.filter_map(|contact| {
            let depth = contact.radius - self.least_radius(helicoid, distances, contact.height)?;
            let distance = contact.distance;
            (depth > tolerance).then_some(Interference { distance, depth })
        });
        interferences.max_by(|a, b| a.depth.total_cmp(&b.depth))
    }

    /// Smallest tool radius of the flank at a tool height.
    fn least_radius(&self, helicoid: &Helicoid, distances: [f64; 2], height: f64) -> Option<f64> {
        let (s, c) = self.angle.sin_cos();
        let radius = |chi: f64| {
            let rho = root(distances, |distance| {
                let at = helicoid.at(distance)?;
                let z = (at.height + helicoid.lead * chi) * c - distance * chi.sin() * s;
                Some([z - height, at.slope * c - chi.sin() * s])
            })?;
            let g = helicoid.at(rho)?.height;
            Some(self.tool_coordinates(helicoid, g, rho, chi)[0])
        };
        let [_, largest] = greatest([-ARC, ARC], ARC_PARTS, |chi| Some(-radius(chi)?))?;
        Some(-largest)
    }
}

fn newton(start: f64, f: impl Fn(f64) -> Option<[f64; 2]>) -> Option<f64> {
    let mut chi = start;
    for _ in 0..NEWTON_STEPS {
        let [value, slope] = f(chi)?;
        let step = value / slope;
        chi -= step;
        if !((chi - start).abs() < 1.0) {
            return None;
        }
        if step.abs() < LAST_STEP {
            return Some(chi);
        }
    }
    None
}
