//! Tooth as beam of variable thickness under unit load: `δ = ∫ [(cos β (h_l − h) − x_l sin β)²/(E I) + 1.2 cos²β/(G A) + sin²β/(E A)] dh`.
//!
//! A slice of unit width is loaded at the height h_l, half thickness x_l, at the angle β to the normal of the middle line; I = 2x³/3,
//! A = 2x. Yang and Lin, J. Mech. Trans. Autom. Des. 109 (1987), with the generated outline from the root circle. The integral splits into
//! cumulative integrals of h^k/x³ and 1/x that do not depend on the load, so a load position costs one Gauss rule.

use std::f64::consts::TAU;

use crate::base::code::Code;
use crate::base::error::Error;
use crate::gear::cylindrical::outline::ToothOutline;
use crate::gear::kernel::root::sign_change;

use super::body::FootLoad;
use super::material::Material;

/// Shear correction factor of a rectangular section.
const SHEAR_FACTOR: f64 = 1.2;

/// Panels of the involute with tabulated integrals; the compliance agrees with 32 panels of six points to 1e-14.
const PANELS: usize = 64;

/// Four-point Gauss–Legendre rule on [0, 1]: nodes and weights.
const GAUSS: [[f64; 2]; 4] = [
    [0.069_431_844_202_973_71, 0.173_927_422_568_726_93],
    [0.330_009_478_207_571_87, 0.326_072_577_431_273_07],
    [0.669_990_521_792_428_1, 0.326_072_577_431_273_07],
    [0.930_568_155_797_026_3, 0.173_927_422_568_726_93],
];

/// Levels of the Romberg table of the fillet, with 2⁷ intervals at the last; 2⁹ change the compliance by 1e-12.
const HALVINGS: usize = 7;

/// Minimum half angle of the tip, rad; below it the tooth is pointed.
const POINTED: f64 = 1e-9;

/// Tip thickness suggested for a loadable tooth, in base pitches.
const LOADED_TIP: f64 = 0.05;

/// Error for a pointed tooth, with the tip diameter of sufficient tip thickness.
fn pointed(outline: &ToothOutline) -> Error {
    let min_thickness = LOADED_TIP * TAU * outline.base_radius / f64::from(outline.teeth);
    let excess = |radius: f64| Some(outline.thickness(radius)? - min_thickness);
    let radius = sign_change([outline.form_radius, outline.tip_radius], excess);
    let error = Error::new(
        Code::OutOfRange,
        format!(
            "the teeth are pointed at a diameter of {:.4} mm and carry no load",
            2e3 * outline.tip_radius
        ),
    )
    .with_key("tip_diameter");
    match radius {
        Some(radius) => error.with_hint(format!(
            "give tip_diameter = \"{:.4} mm\", where the tip is a twentieth of a pitch thick",
            2e3 * radius
        )),
        None => error.with_hint("give more teeth or another profile shift"),
    }
}

/// Section of a tooth with its cumulative integrals.
#[derive(Debug, Clone)]
pub struct ToothSection {
    base_radius: f64,
    root_radius: f64,
    root_half_angle: f64,
    /// Half angle of the tooth extrapolated to the base circle, rad.
    base_half_angle: f64,
    /// +1 for an external, −1 for an internal gear.
    outward: f64,
    material: Material,
    /// Roll angles at form and tip radius, rad.
    roll_angles: [f64; 2],
    /// Integrals from the root circle to the ends of the panels.
    integrals: Vec<Integrals>,
}

/// Integrals ∫dh/x³, ∫h dh/x³, ∫h² dh/x³, ∫dh/x.
#[derive(Debug, Clone, Copy, Default)]
struct Integrals([f64; 4]);

/// Flank point: height above the root circle, m, half thickness, m, and angle β of the normal, rad.
#[derive(Debug, Clone, Copy)]
struct SectionPoint {
    height: f64,
    half_thickness: f64,
    angle: f64,
}

/// Deflections along the line of the load for a unit line load, m²/N.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToothCompliance {
    /// Bending part.
    pub bending: f64,
    /// Shear part.
    pub shear: f64,
    /// Axial compression along the middle line.
    pub axial: f64,
}

impl ToothCompliance {
    /// Sum of bending, shear and axial compression.
    pub fn total(&self) -> f64 {
        self.bending + self.shear + self.axial
    }
}

impl ToothSection {
    /// Section of a tooth outline.
    ///
    /// # Errors
    /// `OutOfRange` for an outline with flanks that intersect below the tip.
    pub fn new(outline: &ToothOutline, material: Material) -> Result<ToothSection, Error> {
        let base = outline.base_radius;
        let outward = if outline.internal { -1.0 } else { 1.0 };
        let roll_angles =
            [outline.form_radius, outline.tip_radius].map(|r| outline.roll_length(r) / base);
        let [_, tip_half_angle] = outline.involute_point(1.0);
        let tip_involute = roll_angles[1] - roll_angles[1].atan();
        let mut section = ToothSection {
            base_radius: base,
            root_radius: outline.root_radius,
            root_half_angle: outline.fillet_point(0.0)[1],
            base_half_angle: tip_half_angle + outward * tip_involute,
            outward,
            material,
            roll_angles,
            integrals: Vec::with_capacity(PANELS + 1),
        };
        let mut sum = section.fillet_integrals(outline);
        section.integrals.push(sum);
        for panel in 0..PANELS {
            let [from, to] = [panel, panel + 1].map(|i| section.panel_end(i));
            sum = sum.plus(&section.involute_integrals(from, to));
            section.integrals.push(sum);
        }
        let is_singular = sum.0.iter().any(|x| !x.is_finite());
        if is_singular || !(tip_half_angle > POINTED) || !(section.root_half_angle > 0.0) {
            return Err(pointed(outline));
        }
        Ok(section)
    }

    /// Deflections of the tooth for a unit line load at a length of roll, m.
    pub fn compliance(&self, roll: f64) -> ToothCompliance {
        let roll_angle = roll / self.base_radius;
        let point = self.flank_point(roll_angle);
        let Integrals([j0, j1, j2, k]) = self.integrals_to(roll_angle);
        let (sine, cosine) = point.angle.sin_cos();
        let arm = cosine * point.height - point.half_thickness * sine;
        let bending = arm * arm * j0 - 2.0 * arm * cosine * j1 + cosine * cosine * j2;
        let young = self.material.young;
        ToothCompliance {
            bending: 1.5 * bending / young,
            shear: 0.5 * SHEAR_FACTOR * cosine * cosine * k / self.material.shear_modulus(),
            axial: 0.5 * sine * sine * k / young,
        }
    }

    /// Load on the tooth foot for a force at a length of roll, m.
    pub fn foot_load(&self, roll: f64) -> FootLoad {
        let angle = self.flank_point(roll / self.base_radius).angle;
        FootLoad {
            // The normal is tangent to the base circle, so it intersects the middle line at r_b/cos β.
            height: self.outward * (self.base_radius / angle.cos() - self.root_radius),
            angle,
            root_radius: self.root_radius,
            root_half_angle: self.root_half_angle,
        }
    }

    /// Distance from the flank to the middle line along the normal, m, at a length of roll, m.
    pub fn depth(&self, roll: f64) -> f64 {
        let point = self.flank_point(roll / self.base_radius);
        point.half_thickness / point.angle.cos()
    }

    /// Elastic constants of the tooth.
    pub fn material(&self) -> &Material {
        &self.material
    }

    fn panel_end(&self, i: usize) -> f64 {
        let [form, tip] = self.roll_angles;
        form + (tip - form) * i as f64 / PANELS as f64
    }

    fn flank_point(&self, roll_angle: f64) -> SectionPoint {
        let angle = roll_angle - self.outward * self.base_half_angle;
        let (sine, cosine) = angle.sin_cos();
        let radial = self.base_radius * (cosine + roll_angle * sine);
        SectionPoint {
            height: self.outward * (radial - self.root_radius),
            half_thickness: self.outward * self.base_radius * (roll_angle * cosine - sine),
            angle,
        }
    }

    /// Integrals from the root circle to a roll angle, rad.
    fn integrals_to(&self, roll_angle: f64) -> Integrals {
        let [form, tip] = self.roll_angles;
        let panel_position = (roll_angle - form) / (tip - form) * PANELS as f64;
        // Outside the flank the integrals are extended from the first or last panel end.
        let panel = (panel_position.max(0.0) as usize).min(PANELS);
        let remainder = self.involute_integrals(self.panel_end(panel), roll_angle);
        self.integrals[panel].plus(&remainder)
    }

    /// Integrals between two roll angles, rad, with `dh = ±r_b ξ cos β dξ`.
    fn involute_integrals(&self, from: f64, to: f64) -> Integrals {
        let mut sum = Integrals::default();
        for [share, weight] in GAUSS {
            let roll_angle = from + share * (to - from);
            let point = self.flank_point(roll_angle);
            let rise = self.outward * self.base_radius * roll_angle * point.angle.cos();
            let step = weight * (to - from) * rise;
            let inverse = point.half_thickness.recip();
            let third = inverse * inverse * inverse * step;
            let height = point.height;
            sum.0[0] += third;
            sum.0[1] += height * third;
            sum.0[2] += height * height * third;
            sum.0[3] += inverse * step;
        }
        sum
    }

    /// Integrals over the fillet by the trapezoidal rule with Romberg extrapolation.
    fn fillet_integrals(&self, outline: &ToothOutline) -> Integrals {
        let intervals = 1 << HALVINGS;
        let nodes: Vec<[f64; 5]> = (0..=intervals)
            .map(|i| {
                let [radius, angle] = outline.fillet_point(i as f64 / intervals as f64);
                let height = self.outward * (radius * angle.cos() - self.root_radius);
                let inverse = (radius * angle.sin()).recip();
                let third = inverse * inverse * inverse;
                [
                    third,
                    height * third,
                    height * height * third,
                    inverse,
                    height,
                ]
            })
            .collect();
        let trapezoidal = |k: usize, stride: usize| {
            let coarse: Vec<&[f64; 5]> = nodes.iter().step_by(stride).collect();
            let pairs = coarse.windows(2);
            let area = |w: &[&[f64; 5]]| 0.5 * (w[0][k] + w[1][k]) * (w[1][4] - w[0][4]);
            pairs.map(area).sum::<f64>()
        };
        Integrals(std::array::from_fn(|k| {
            let strides = (0..=HALVINGS).rev().map(|level| 1 << level);
            let mut row: Vec<f64> = Vec::new();
            for (level, stride) in strides.enumerate() {
                let mut next = vec![trapezoidal(k, stride)];
                for order in 0..level {
                    let factor = 4f64.powi(order as i32 + 1) - 1.0;
                    next.push(next[order] + (next[order] - row[order]) / factor);
                }
                row = next;
            }
            row[HALVINGS]
        }))
    }
}

impl Integrals {
    fn plus(&self, other: &Integrals) -> Integrals {
        Integrals(std::array::from_fn(|k| self.0[k] + other.0[k]))
    }
}
