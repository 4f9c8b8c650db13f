//! Path of contact of two involute gears on parallel axes, and the tooth loss factor H_v.
//!
//! The sliding velocity at a distance s from the pitch point is `v = (ω₁ ± ω₂) s`. Pairs in contact share the load evenly; the mean power
//! loss is then `μ H_v` of the power, `H_v = π (1/z₁ ± 1/z₂)/cos β_b · (1 − ε + ε₁² + ε₂²)` for 1 ≤ ε ≤ 2 (Ohlendorf 1958; Niemann and
//! Winter, Maschinenelemente II).

/// Tolerance for equal segment boundaries, share of the mesh cycle: rounding of the geometry.
const SAME_BOUNDARY: f64 = 1e-12;

/// Path of contact from the pitch point, relative to the transverse base pitch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathOfContact {
    /// Transverse base pitch, m.
    pub pitch: f64,
    /// Length of approach ε₁, from the start of contact to the pitch point, with the first gear driving.
    pub approach: f64,
    /// Length of recess ε₂, from the pitch point to the end of contact.
    pub recess: f64,
}

/// Geometry of two gears that determines the path of contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathGeometry {
    /// Radii of the base circles, m.
    pub base: [f64; 2],
    /// Radii of the tip circles, m.
    pub tip: [f64; 2],
    /// Working transverse pressure angle, rad.
    pub angle: f64,
    /// Number of teeth of the first gear.
    pub teeth: u32,
    /// True if the second gear is internal.
    pub internal: bool,
}

/// Interval of the mesh cycle with the same tooth pairs in contact on the same sides of the pitch point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshCycleSegment {
    /// Start in the mesh cycle, 0 to 1.
    pub from: f64,
    /// Load levers of the drive and the coast flanks.
    pub flanks: [LoadLever; 2],
}

/// Lever of the load from the pitch point over a segment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadLever {
    /// Mean absolute distance of the load from the pitch point at the start of the segment, m.
    pub distance: f64,
    /// Change of the distance per mesh cycle, m.
    pub slope: f64,
    /// Load share in recess minus load share in approach, with the first gear driving.
    pub balance: f64,
}

impl PathGeometry {
    /// Transverse base pitch, m.
    pub fn base_pitch(&self) -> f64 {
        std::f64::consts::TAU * self.base[0] / f64::from(self.teeth)
    }

    /// Lengths of roll at the pitch point on both gears, m.
    pub fn pitch_point(&self) -> [f64; 2] {
        self.base.map(|base| base * self.angle.tan())
    }

    /// Lengths of roll at the tip cylinders, m.
    pub fn tip_roll(&self) -> [f64; 2] {
        [0, 1].map(|i| ((self.tip[i] - self.base[i]) * (self.tip[i] + self.base[i])).sqrt())
    }

    /// Lengths of approach and recess with the first gear driving, m. The path is limited by the base circles of the first gear and of an
    /// external second gear.
    pub fn ends(&self) -> [f64; 2] {
        let ([c1, c2], [tip1, tip2]) = (self.pitch_point(), self.tip_roll());
        match self.internal {
            false => [(tip2 - c2).min(c1), (tip1 - c1).min(c2)],
            true => [(c2 - tip2).min(c1), tip1 - c1],
        }
    }
}

impl PathOfContact {
    /// Computes the path; `None` for a contact ratio below one.
    pub fn new(gears: &PathGeometry) -> Option<PathOfContact> {
        let pitch = gears.base_pitch();
        let [approach, recess] = gears.ends();
        let path = PathOfContact {
            pitch,
            approach: approach / pitch,
            recess: recess / pitch,
        };
        let is_valid = path.approach >= 0.0 && path.recess >= 0.0 && path.contact_ratio() >= 1.0;
        is_valid.then_some(path)
    }

    /// Transverse contact ratio ε.
    pub fn contact_ratio(&self) -> f64 {
        self.approach + self.recess
    }

    /// Segments of the mesh cycle in the order of the angle of the first gear. The cycle starts with the contact of a pair of drive flanks;
    /// coast flanks pass the pitch point half a cycle later.
    pub fn segments(&self) -> Vec<MeshCycleSegment> {
        let coast = self.approach - 0.5;
        let mut starts: Vec<f64> = [
            0.0,
            self.contact_ratio(),
            self.approach,
            coast + self.approach,
            coast - self.recess,
            coast,
        ]
        .iter()
        .map(|start| start.rem_euclid(1.0))
        .filter(|start| *start > SAME_BOUNDARY && *start < 1.0 - SAME_BOUNDARY)
        .collect();
        starts.push(0.0);
        starts.sort_by(f64::total_cmp);
        starts.dedup_by(|b, a| *b - *a < SAME_BOUNDARY);
        let ends = starts.iter().skip(1).copied().chain([1.0]);
        let segment = |(from, to): (f64, f64)| MeshCycleSegment {
            from,
            flanks: [false, true].map(|coast| self.load_lever(from, to, coast)),
        };
        starts.iter().copied().zip(ends).map(segment).collect()
    }

    /// Single segment with the mean lever of the mesh cycle.
    pub fn mean_segment(&self) -> MeshCycleSegment {
        let segments = self.segments();
        let ends = segments.iter().skip(1).map(|s| s.from).chain([1.0]);
        let mut mean = LoadLever {
            distance: 0.0,
            slope: 0.0,
            balance: 0.0,
        };
        for (segment, to) in segments.iter().zip(ends) {
            let (width, lever) = (to - segment.from, &segment.flanks[0]);
            mean.distance += width * (lever.distance + 0.5 * width * lever.slope);
            mean.balance += width * lever.balance;
        }
        MeshCycleSegment {
            from: 0.0,
            flanks: [mean; 2],
        }
    }

    /// Tooth loss factor H_v for the base radius of the first gear, m, the ratio `i = z₂/z₁` (negative for an internal gear) and the base
    /// helix angle β_b, rad: the mean power loss is μ H_v of the power.
    pub fn loss_factor(&self, first_base: f64, ratio: f64, base_helix: f64) -> f64 {
        self.mean_segment().flanks[0].distance * (1.0 + 1.0 / ratio)
            / (first_base * base_helix.cos())
    }

    fn load_lever(&self, from: f64, to: f64, coast: bool) -> LoadLever {
        let middle = 0.5 * (from + to);
        let position = |psi: f64, pair: i32| {
            let drive = psi - self.approach;
            f64::from(pair) + if coast { -drive - 0.5 } else { drive }
        };
        let max_pair = self.contact_ratio().ceil() as i32 + 2;
        let pairs = (-max_pair..=max_pair).filter(|&pair| {
            let x = position(middle, pair);
            -self.approach < x && x < self.recess
        });
        let pairs: Vec<i32> = pairs.collect();
        let share = 1.0 / pairs.len().max(1) as f64;
        let side = |pair: &i32| position(middle, *pair).signum();
        let balance: f64 = share * pairs.iter().map(side).sum::<f64>();
        let distance: f64 = pairs.iter().map(|p| side(p) * position(from, *p)).sum();
        LoadLever {
            distance: share * self.pitch * distance,
            slope: self.pitch * if coast { -balance } else { balance },
            balance,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spur(z: [u32; 2], internal: bool) -> PathGeometry {
        let (m, alpha) = (1e-3, 20f64.to_radians());
        let radius = z.map(|z| 0.5 * m * f64::from(z));
        PathGeometry {
            base: radius.map(|r| r * alpha.cos()),
            tip: [
                radius[0] + m,
                radius[1] + if internal { -0.8 * m } else { m },
            ],
            angle: alpha,
            teeth: z[0],
            internal,
        }
    }

    /// Even load sharing gives Ohlendorf's factor, also for an internal gear; its teeth are short, since the formula requires approach and
    /// recess below one pitch.
    #[test]
    fn exact_loss_factor() {
        for (z, internal) in [([20, 60], false), ([17, 17], false), ([25, 90], true)] {
            let gears = spur(z, internal);
            let path = PathOfContact::new(&gears).unwrap();
            let (e, e1, e2) = (path.contact_ratio(), path.approach, path.recess);
            assert!((1.0..2.0).contains(&e) && e1.max(e2) < 1.0, "{e1} {e2}");
            let [z1, z2] = z.map(f64::from);
            let i = if internal { -z2 / z1 } else { z2 / z1 };
            let ohlendorf =
                std::f64::consts::PI * (i + 1.0) / (z1 * i) * (1.0 - e + e1 * e1 + e2 * e2);
            let factor = path.loss_factor(gears.base[0], i, 0.0);
            assert!(
                (factor / ohlendorf - 1.0).abs() < 1e-13,
                "{factor} {ohlendorf}"
            );
        }
    }

    /// Both flanks have the same mean levers; the textbook contact ratio of 20 and 60 teeth is 1.67.
    #[test]
    fn law_flanks_mirror() {
        let path = PathOfContact::new(&spur([20, 60], false)).unwrap();
        assert!(
            (path.contact_ratio() - 1.671).abs() < 1e-3,
            "{}",
            path.contact_ratio()
        );
        let segments = path.segments();
        let ends = segments.iter().skip(1).map(|p| p.from).chain([1.0]);
        let mut sums = [[0.0; 2]; 2];
        for (segment, to) in segments.iter().zip(ends) {
            let width = to - segment.from;
            for (sum, lever) in sums.iter_mut().zip(&segment.flanks) {
                sum[0] += width * (lever.distance + 0.5 * width * lever.slope);
                sum[1] += width * lever.balance;
            }
        }
        assert!((sums[0][0] - sums[1][0]).abs() < 1e-12 * sums[0][0]);
        assert!((sums[0][1] - sums[1][1]).abs() < 1e-12);
    }

    /// Teeth that are too short have a contact ratio below one.
    #[test]
    fn refuses_gaps() {
        let mut gears = spur([20, 60], false);
        gears.tip = [1.01e-2, 3.01e-2];
        assert_eq!(PathOfContact::new(&gears), None);
    }
}
