//! Blanks of bevel and hypoid pairs: pitch cones by methods 0 to 3 of ISO 23509:2016, depths, root and face cones, face widths, thicknesses.
//!
//! Numbers in brackets are formulas of ISO 23509:2016; Clause 6 gives the pitch cones, Clause 7 the rest. Methods 1 to 3 are solved to
//! rounding, method 1 to the stated spiral angle: the standard stops at 1 % (method 3: 1e-4) and corrects the spiral angle once.

use std::f64::consts::{FRAC_PI_2, PI};

use super::blank::{Blank, EndCone};
use super::blank_fault::BlankFault;
use super::face_hob::{ConeRule, FaceHob};
use super::pitch_cones::{PitchConeDesign, ToothLine};
use crate::gear::kernel::crossed_axes::CrossedAxes;

/// Inputs of a pair of blanks; angles in rad, lengths in m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BlankDesign {
    /// Pitch cones.
    pub method: PitchCones,
    /// Tooth numbers of pinion and wheel.
    pub teeth: [u32; 2],
    /// Shaft angle Σ.
    pub shaft_angle: f64,
    /// Outer pitch diameter of the wheel d_e2.
    pub outer_pitch_diameter: f64,
    /// Face width of the wheel b₂.
    pub face_width: f64,
    /// Cutter radius r_c0.
    pub cutter_radius: f64,
    /// Design pressure angles α_dD, α_dC of the drive and the coast flank.
    pub pressure_angles: [f64; 2],
    /// Influence of the limit pressure angle f_αlim.
    pub limit_influence: f64,
    /// Mean addendum factor of the wheel c_ham.
    pub addendum_factor: f64,
    /// Depth factor k_d.
    pub depth_factor: f64,
    /// Clearance factor k_c.
    pub clearance_factor: f64,
    /// Circular thickness factor k_t.
    pub thickness_factor: f64,
    /// Outer normal backlash j_en.
    pub backlash: f64,
    /// Addendum and dedendum angle of the wheel θ_a2, θ_f2.
    pub depth_angles: [f64; 2],
}

/// Methods for the pitch cones.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PitchCones {
    /// Method 0: no offset, the spiral angle β_m of both gears.
    Bevel {
        /// β_m, rad.
        spiral_angle: f64,
    },
    /// Method 1: the offset a, below zero where the wheel has the larger spiral angle, and the spiral angle β_m1 of the pinion; the limit radius of curvature is the cutter radius.
    Hypoid {
        /// a, m.
        offset: f64,
        /// β_m1, rad.
        pinion_spiral_angle: f64,
    },
    /// Methods 2 and 3: face-hobbed pairs with an offset a and the spiral angle β_m2 of the wheel.
    FaceHobbed {
        /// a, m.
        offset: f64,
        /// β_m2, rad.
        wheel_spiral_angle: f64,
        /// Blade groups of the cutter z₀.
        blade_groups: u32,
        /// Method 2 or 3.
        rule: ConeRule,
    },
}

impl PitchCones {
    /// Whether the pair is face-hobbed.
    pub fn is_face_hobbed(&self) -> bool {
        matches!(self, PitchCones::FaceHobbed { .. })
    }

    /// Number of the method in ISO 23509.
    pub fn number(&self) -> u32 {
        match self {
            PitchCones::Bevel { .. } => 0,
            PitchCones::Hypoid { .. } => 1,
            PitchCones::FaceHobbed { rule, .. } => match rule {
                ConeRule::ApexLine => 2,
                ConeRule::CrownGears => 3,
            },
        }
    }
}

/// Blanks of a pair with what Clause 7 gives at the mean point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BlankPair {
    /// Method of the pitch cones.
    pub method: PitchCones,
    /// Blanks of pinion and wheel.
    pub blanks: [Blank; 2],
    /// Cutter radius r_c0, m.
    pub cutter_radius: f64,
    /// Mean spiral angles β_m, rad.
    pub spiral_angles: [f64; 2],
    /// Mean normal module m_mn, m.
    pub normal_module: f64,
    /// Limit pressure angle α_lim, rad.
    pub limit_pressure_angle: f64,
    /// Generated normal pressure angles α_nD, α_nC, rad.
    pub pressure_angles: [f64; 2],
    /// Offset angles in the axial plane ζ_m and in the pitch plane ζ_mp, rad.
    pub offset_angles: [f64; 2],
    /// Mean addenda h_am, m.
    pub addenda: [f64; 2],
    /// Mean dedenda h_fm, m.
    pub dedenda: [f64; 2],
    /// Clearance c, m.
    pub clearance: f64,
    /// Spiral angles of pinion and wheel at heel and toe β_e, β_i, rad.
    pub end_spiral_angles: [[f64; 2]; 2],
    /// Mean normal thicknesses s_mn with backlash, m.
    pub thicknesses: [f64; 2],
}

/// Why a design has no pitch cones.
fn no_cones(design: &PitchConeDesign) -> BlankFault {
    match (design.tooth_line, design.limit_curvatures()) {
        (ToothLine::Limit { curvature, .. }, Some(reached))
            if !(reached[0]..=reached[1]).contains(&curvature) =>
        {
            BlankFault::LimitCurvature { reached }
        }
        _ => BlankFault::NoPitchCones,
    }
}

/// Pitch cones at the calculation point.
#[derive(Debug, Clone, Copy)]
struct Cones {
    angles: [f64; 2],
    distances: [f64; 2],
    spirals: [f64; 2],
    /// Share of the wheel's face outside the calculation point, c_be2.
    outer_share: f64,
}

impl BlankDesign {
    /// The blanks.
    ///
    /// # Errors
    /// Data without pitch cones, or cones without teeth.
    pub fn blanks(&self) -> Result<BlankPair, BlankFault> {
        let (cones, offset) = match self.method {
            PitchCones::Bevel { spiral_angle } => (self.bevel_cones(spiral_angle), 0.0),
            PitchCones::Hypoid { offset, .. } | PitchCones::FaceHobbed { offset, .. } => {
                (self.hypoid_cones()?, offset)
            }
        };
        let found = self.dimensions(&cones, offset);
        for (member, blank) in found.blanks.iter().enumerate() {
            if !(blank.face_width > 0.0 && blank.root_apex.is_finite()) {
                return Err(BlankFault::NoFace { member });
            }
            let fault = |fault| BlankFault::Tooth { member, fault };
            blank.section().map_err(fault)?;
        }
        for (member, thickness) in found.thicknesses.into_iter().enumerate() {
            if thickness.is_nan() {
                return Err(BlankFault::ToothLine);
            }
            if thickness <= 0.0 {
                return Err(BlankFault::NoThickness { member, thickness });
            }
        }
        Ok(found)
    }

    fn ratio(&self) -> f64 {
        f64::from(self.teeth[1]) / f64::from(self.teeth[0])
    }

    /// Method 0 (1)–(7).
    fn bevel_cones(&self, spiral_angle: f64) -> Cones {
        let (sin, cos) = self.shaft_angle.sin_cos();
        let first = sin.atan2(cos + self.ratio());
        let second = self.shaft_angle - first;
        let outer = self.outer_pitch_diameter / (2.0 * second.sin());
        let mean = outer - 0.5 * self.face_width;
        Cones {
            angles: [first, second],
            distances: [mean; 2],
            spirals: [spiral_angle; 2],
            outer_share: 0.5,
        }
    }

    /// Pitch cones of a pair with offset; methods 2 and 3 put the calculation point in the middle of the face.
    fn hypoid_cones(&self) -> Result<Cones, BlankFault> {
        let design = self.pitch_cone_design().ok_or(BlankFault::NoPitchCones)?;
        let found = design.solve().ok_or_else(|| no_cones(&design))?;
        let [_, wheel] = found.pitch_angles;
        let outer = self.outer_pitch_diameter / (2.0 * wheel.sin());
        Ok(Cones {
            angles: found.pitch_angles,
            distances: found.cone_distances,
            spirals: found.spiral_angles,
            outer_share: (outer - found.cone_distances[1]) / self.face_width,
        })
    }

    /// Design of the pitch cones: method 1 (8)–(41), 2 (42)–(83), 3 (84)–(109); none for method 0.
    fn pitch_cone_design(&self) -> Option<PitchConeDesign> {
        let u = self.ratio();
        let outer_radius = 0.5 * self.outer_pitch_diameter;
        let (offset, [wheel_radius, outwards], tooth_line) = match self.method {
            PitchCones::Bevel { .. } => return None,
            PitchCones::Hypoid {
                offset,
                pinion_spiral_angle,
            } => {
                let (sin_d, cos_d) = (self.shaft_angle - FRAC_PI_2).sin_cos();
                // (11): the wheel's pitch angle, by which its mean radius is estimated.
                let wheel = f64::atan2(u * cos_d, 1.2 * (1.0 - u * sin_d));
                let limit = ToothLine::Limit {
                    pinion_spiral_angle,
                    curvature: 1.0 / self.cutter_radius,
                };
                let mean_radius = outer_radius - 0.5 * self.face_width * wheel.sin();
                (offset, [mean_radius, 0.0], limit)
            }
            PitchCones::FaceHobbed {
                offset,
                wheel_spiral_angle,
                ..
            } => {
                let hobbed = ToothLine::Hobbed {
                    wheel_spiral_angle,
                    cutter: self.face_hob()?,
                };
                (offset, [outer_radius, 0.5 * self.face_width], hobbed)
            }
        };
        Some(PitchConeDesign {
            axes: CrossedAxes {
                offset,
                shaft_angle: self.shaft_angle,
                ratio: -1.0 / u,
            },
            wheel_radius,
            outwards,
            tooth_line,
        })
    }

    /// The cutter of a face-hobbed pair.
    fn face_hob(&self) -> Option<FaceHob> {
        let PitchCones::FaceHobbed {
            blade_groups, rule, ..
        } = self.method
        else {
            return None;
        };
        Some(FaceHob {
            radius: self.cutter_radius,
            groups: f64::from(blade_groups) / f64::from(self.teeth[1]),
            rule,
        })
    }

    /// Clause 7: (110)–(173), thicknesses, end spiral angles.
    fn dimensions(&self, cones: &Cones, a: f64) -> BlankPair {
        let Cones {
            angles: [delta_1, delta_2],
            distances: [rm_1, rm_2],
            spirals: [_, beta_2],
            outer_share,
        } = *cones;
        let departure = self.shaft_angle - FRAC_PI_2;
        let (tan_d, sin_d, cos_d) = (departure.tan(), departure.sin(), departure.cos());
        let (dm_1, dm_2) = (2.0 * rm_1 * delta_1.sin(), 2.0 * rm_2 * delta_2.sin());
        let across = dm_2 + dm_1 * delta_2.cos() / delta_1.cos();
        let zeta_m = (2.0 * a / across).asin();
        let zeta_mp = (zeta_m.sin() * self.shaft_angle.sin() / delta_1.cos()).asin();
        let module = dm_2 * beta_2.cos() / f64::from(self.teeth[1]);
        let limit = limit_pressure_angle(cones, zeta_mp);
        let f = self.limit_influence;
        let [design_d, design_c] = self.pressure_angles;
        let pressure = [design_d + f * limit, design_c - f * limit];
        let tzm_2 =
            dm_1 * delta_2.sin() / (2.0 * delta_1.cos()) - 0.5 * zeta_m.cos() * tan_d * across;
        let tzm_1 = 0.5 * dm_2 * zeta_m.cos() * cos_d - tzm_2 * sin_d;
        let apex = [rm_1 * delta_1.cos() - tzm_1, rm_2 * delta_2.cos() - tzm_2];
        // Data type II into type I: Table 4.
        let k_hap = 0.5 * self.depth_factor;
        let x_hm = self.depth_factor * (0.5 - self.addendum_factor);
        let k_hfp = self.depth_factor * (self.clearance_factor + 0.5);
        let addenda = [module * (k_hap + x_hm), module * (k_hap - x_hm)];
        let dedenda = [module * (k_hfp - x_hm), module * (k_hfp + x_hm)];
        let clearance = module * (k_hfp - k_hap);
        // Root and face cones (140)–(153).
        let [theta_a, theta_f] = self.depth_angles;
        let (face_2, root_2) = (delta_2 + theta_a, delta_2 - theta_f);
        let plane_offset = |angle: f64, theta: f64| {
            let along = rm_2 * theta.cos() - apex[1] * angle.cos();
            let phi = (a * tan_d * angle.cos() / along).atan();
            (a * phi.cos() * angle.sin() / along).asin() - phi
        };
        let (zeta_r, zeta_o) = (plane_offset(root_2, theta_f), plane_offset(face_2, theta_a));
        let of_mate =
            |mate: f64, zeta: f64| (sin_d * mate.sin() + cos_d * mate.cos() * zeta.cos()).asin();
        let (face_1, root_1) = (of_mate(root_2, zeta_r), of_mate(face_2, zeta_o));
        let face_apex_2 =
            apex[1] - (rm_2 * theta_a.sin() - addenda[1] * theta_a.cos()) / face_2.sin();
        let root_apex_2 =
            apex[1] + (rm_2 * theta_f.sin() - dedenda[1] * theta_f.cos()) / root_2.sin();
        let apex_1 = |zeta: f64, mate: f64, mate_apex: f64, own: f64| {
            (a * zeta.sin() * mate.cos() - mate_apex * mate.sin() - clearance) / own.sin()
        };
        let face_apex_1 = apex_1(zeta_r, root_2, root_apex_2, face_1);
        let root_apex_1 = apex_1(zeta_o, face_2, face_apex_2, root_1);
        let outer_2 = rm_2 + outer_share * self.face_width;
        let depth = PinionDepth {
            offset_angles: [zeta_mp, zeta_r],
            face_angle: face_1,
            addendum: addenda[0],
            mate_dedendum: dedenda[1],
            clearance,
            working_depth: 2.0 * module * k_hap,
            module,
        };
        let [width_1, outer_share_1] = self.pinion_face(cones, &depth);
        let ends_2 = [outer_2, outer_2 - self.face_width].map(|r| self.wheel_spiral(cones, r));
        // (174), (175): cone distances on the wheel of the pinion's ends, and the spiral angles there.
        let ends_1 = [outer_share_1, outer_share_1 - 1.0].map(|share| {
            let r = cone_distance_on_wheel(rm_2, share * width_1, zeta_mp);
            self.wheel_spiral(cones, r) + (rm_2 * zeta_mp.sin() / r).asin()
        });
        let ends = [ends_1, ends_2];
        let alpha = 0.5 * (pressure[0] + pressure[1]);
        let play = self.backlash / (4.0 * module * alpha.cos()) * rm_2 * beta_2.cos()
            / (outer_2 * ends_2[0].cos());
        let thickness = |sign: f64| {
            let x_s = sign * 0.5 * self.thickness_factor - play;
            module * (0.5 * PI + 2.0 * (x_s + sign * x_hm * alpha.tan()))
        };
        let blank = |pitch, face, root, mean, width, share, apexes: [f64; 3]| Blank {
            pitch_angle: pitch,
            face_angle: face,
            root_angle: root,
            mean_cone_distance: mean,
            face_width: width,
            outer_share: share,
            pitch_apex: apexes[0],
            face_apex: apexes[1],
            root_apex: apexes[2],
            ends: EndCone::Pitch,
        };
        BlankPair {
            method: self.method,
            blanks: [
                blank(
                    delta_1,
                    face_1,
                    root_1,
                    rm_1,
                    width_1,
                    outer_share_1,
                    [apex[0], face_apex_1, root_apex_1],
                ),
                blank(
                    delta_2,
                    face_2,
                    root_2,
                    rm_2,
                    self.face_width,
                    outer_share,
                    [apex[1], face_apex_2, root_apex_2],
                ),
            ],
            cutter_radius: self.cutter_radius,
            spiral_angles: cones.spirals,
            normal_module: module,
            limit_pressure_angle: limit,
            pressure_angles: pressure,
            offset_angles: [zeta_m, zeta_mp],
            addenda,
            dedenda,
            clearance,
            end_spiral_angles: ends,
            thicknesses: [thickness(1.0), thickness(-1.0)],
        }
    }

    /// Spiral angle of the wheel at a cone distance: (179)–(184), rad.
    fn wheel_spiral(&self, cones: &Cones, distance: f64) -> f64 {
        let (mean, beta) = (cones.distances[1], cones.spirals[1]);
        if let Some(cutter) = self.face_hob() {
            let line = cutter.epicycloid(mean, cones.angles[1], beta);
            return line.spiral_angle(distance);
        }
        milled_spiral_angle(self.cutter_radius, [mean, beta], distance)
    }

    /// Face width of the pinion along its pitch cone and the share of it outside the calculation point (154)–(173).
    fn pinion_face(&self, cones: &Cones, depth: &PinionDepth) -> [f64; 2] {
        let [zeta_mp, zeta_r] = depth.offset_angles;
        let ([delta_1, delta_2], mean_2) = (cones.angles, cones.distances[1]);
        let in_pitch_plane = |r: f64| (r * r - (mean_2 * zeta_mp.sin()).powi(2)).sqrt();
        let outer_2 = mean_2 + cones.outer_share * self.face_width;
        match self.method {
            PitchCones::Bevel { .. } => [self.face_width, cones.outer_share],
            PitchCones::FaceHobbed {
                rule: ConeRule::ApexLine,
                ..
            } => {
                let width = self.face_width * (1.0 + zeta_mp.tan().powi(2));
                [width, cones.outer_share]
            }
            PitchCones::FaceHobbed {
                rule: ConeRule::CrownGears,
                ..
            } => {
                let inner = in_pitch_plane(outer_2 - self.face_width);
                let plain = in_pitch_plane(outer_2) - inner;
                // (170): whole millimetres.
                let width =
                    1e-3 * (1e3 * (plain + 3.0 * depth.module * zeta_mp.tan().abs()) + 1.0).floor();
                let inside = in_pitch_plane(mean_2) - inner + 0.5 * (width - plain);
                [width, 1.0 - inside / width]
            }
            PitchCones::Hypoid { .. } => {
                let u = self.ratio();
                let lambda = (zeta_mp.sin() * delta_2.cos()
                    / (u * delta_1.cos() + delta_2.cos() * zeta_mp.cos()))
                .atan();
                let width = self.face_width * lambda.cos() / (zeta_mp - lambda).cos();
                let more = depth.working_depth * zeta_r.sin().abs() * (1.0 - 1.0 / u);
                let theta_a = depth.face_angle - delta_1;
                let along =
                    |share: f64| share * width / theta_a.cos() * depth.face_angle.cos() + more;
                let below = (depth.mate_dedendum - depth.clearance) * delta_1.sin();
                let rise = depth.addendum * delta_1.sin();
                let outer = (along(cones.outer_share) - below + rise) / depth.face_angle.cos()
                    * theta_a.cos();
                let inner = (along(1.0 - cones.outer_share) + below - rise)
                    / (delta_1.cos() - theta_a.tan() * delta_1.sin());
                [inner + outer, outer / (inner + outer)]
            }
        }
    }
}

/// Depths and angles that give the face width of the pinion.
struct PinionDepth {
    /// Offset angles in the pitch plane and in the root plane ζ_mp, ζ_R.
    offset_angles: [f64; 2],
    face_angle: f64,
    addendum: f64,
    mate_dedendum: f64,
    clearance: f64,
    working_depth: f64,
    module: f64,
}

/// Cone distance on the wheel of a place of the pinion, `outwards` from the mean point along its pitch cone: (174), (175).
pub fn cone_distance_on_wheel(mean_2: f64, outwards: f64, offset_angle: f64) -> f64 {
    let square = mean_2 * mean_2 + outwards * outwards;
    (square + 2.0 * mean_2 * outwards * offset_angle.cos()).sqrt()
}

/// Spiral angle at a cone distance of a face-milled wheel by its mean cone distance and spiral angle: (183), (184), rad.
pub fn milled_spiral_angle(cutter_radius: f64, [mean, beta]: [f64; 2], distance: f64) -> f64 {
    let r = distance;
    let sine = 2.0 * mean * cutter_radius * beta.sin() - mean * mean + r * r;
    (sine / (2.0 * r * cutter_radius)).asin()
}

/// Limit pressure angle (32), (117).
fn limit_pressure_angle(cones: &Cones, zeta_mp: f64) -> f64 {
    let [t1, t2] = cones.angles.map(f64::tan);
    let [r1, r2] = cones.distances;
    let [s1, s2] = cones.spirals.map(f64::sin);
    (-t1 * t2 / zeta_mp.cos() * (r1 * s1 - r2 * s2) / (r1 * t1 + r2 * t2)).atan()
}
