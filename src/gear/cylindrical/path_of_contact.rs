//! Path of contact of two involute gears on parallel axes, sliding and the loss factor H_v.
//!
//! At a distance s from the pitch point teeth slide at `v = (ω₁ ± ω₂) s`. Pairs that touch at once share the load evenly; then the mean
//! loss is `μ H_v` of the power, `H_v = π (1/z₁ ± 1/z₂)/cos β_b · (1 − ε + ε₁² + ε₂²)` for 1 ≤ ε ≤ 2 (Ohlendorf 1958; Niemann and
//! Winter, Maschinenelemente II).

/// Edges of pieces that are nearer than this are one, as a share of the mesh cycle: rounding of geometry.
const ONE_EDGE: f64 = 1e-12;

/// A path of contact, in shares of the transverse base pitch from the pitch point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathOfContact {
    /// Transverse base pitch, m.
    pub pitch: f64,
    /// From the start of contact to the pitch point, where the first gear drives.
    pub approach: f64,
    /// From the pitch point to the end of contact.
    pub recess: f64,
}

/// Two gears as the path needs them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathGeometry {
    /// Radii of the base circles, m.
    pub base: [f64; 2],
    /// Radii of the tip circles, m.
    pub tip: [f64; 2],
    /// Working transverse pressure angle, rad.
    pub angle: f64,
    /// Teeth of the first gear.
    pub teeth: u32,
    /// The second gear is a ring.
    pub internal: bool,
}

/// An interval of the mesh cycle over which the same pairs touch on the same sides of the pitch point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshCycleSegment {
    /// Start in the cycle, from 0 to 1.
    pub from: f64,
    /// On the drive flanks, on the coast flanks.
    pub flanks: [LoadLever; 2],
}

/// Lever of the load from the pitch point on a piece.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadLever {
    /// Mean distance of the load from the pitch point, without sign, where the piece begins, m.
    pub distance: f64,
    /// Change over a whole cycle, m.
    pub slope: f64,
    /// Share of the load beyond the pitch point less the share before it, as the first gear has it.
    pub balance: f64,
}

impl PathGeometry {
    /// Transverse base pitch, m.
    pub fn base_pitch(&self) -> f64 {
        std::f64::consts::TAU * self.base[0] / f64::from(self.teeth)
    }

    /// Lengths of roll of the pitch point on both gears, m.
    pub fn pitch_point(&self) -> [f64; 2] {
        self.base.map(|base| base * self.angle.tan())
    }

    /// Lengths of roll at the tip cylinders, m.
    pub fn tip_roll(&self) -> [f64; 2] {
        [0, 1].map(|i| ((self.tip[i] - self.base[i]) * (self.tip[i] + self.base[i])).sqrt())
    }

    /// Lengths of the path before and beyond the pitch point, the first gear driving, m. No involute lies inside the base circle of the
    /// first gear, nor of an external second one.
    pub fn ends(&self) -> [f64; 2] {
        let ([c1, c2], [tip1, tip2]) = (self.pitch_point(), self.tip_roll());
        match self.internal {
            false => [(tip2 - c2).min(c1), (tip1 - c1).min(c2)],
            true => [(c2 - tip2).min(c1), tip1 - c1],
        }
    }
}

impl PathOfContact {
    /// The path; none where teeth do not overlap: a contact ratio below one.
    pub fn new(gears: &PathGeometry) -> Option<PathOfContact> {
        let pitch = gears.base_pitch();
        let [approach, recess] = gears.ends();
        let path = PathOfContact {
            pitch,
            approach: approach / pitch,
            recess: recess / pitch,
        };
        let whole = path.approach >= 0.0 && path.recess >= 0.0 && path.contact_ratio() >= 1.0;
        whole.then_some(path)
    }

    /// ε.
    pub fn contact_ratio(&self) -> f64 {
        self.approach + self.recess
    }

    /// The mesh cycle in pieces, by rising angle of the first gear. It begins where a pair of drive flanks comes into contact; coast
    /// flanks pass the pitch point half a cycle later.
    pub fn segments(&self) -> Vec<MeshCycleSegment> {
        let coast = self.approach - 0.5;
        let mut edges: Vec<f64> = [
            0.0,
            self.contact_ratio(),
            self.approach,
            coast + self.approach,
            coast - self.recess,
            coast,
        ]
        .iter()
        .map(|edge| edge.rem_euclid(1.0))
        .filter(|edge| *edge > ONE_EDGE && *edge < 1.0 - ONE_EDGE)
        .collect();
        edges.push(0.0);
        edges.sort_by(f64::total_cmp);
        edges.dedup_by(|b, a| *b - *a < ONE_EDGE);
        let ends = edges.iter().skip(1).copied().chain([1.0]);
        let piece = |(from, to): (f64, f64)| MeshCycleSegment {
            from,
            flanks: [false, true].map(|coast| self.load_lever(from, to, coast)),
        };
        edges.iter().copied().zip(ends).map(piece).collect()
    }

    /// The whole cycle by its means.
    pub fn mean_segment(&self) -> MeshCycleSegment {
        let pieces = self.segments();
        let ends = pieces.iter().skip(1).map(|p| p.from).chain([1.0]);
        let mut mean = LoadLever {
            distance: 0.0,
            slope: 0.0,
            balance: 0.0,
        };
        for (piece, to) in pieces.iter().zip(ends) {
            let (width, reach) = (to - piece.from, &piece.flanks[0]);
            mean.distance += width * (reach.distance + 0.5 * width * reach.slope);
            mean.balance += width * reach.balance;
        }
        MeshCycleSegment {
            from: 0.0,
            flanks: [mean; 2],
        }
    }

    /// H_v of a pair whose tooth force acts at the base helix angle β_b, `i = z₂/z₁` negative for a ring: the mean loss as a share of the
    /// power is μ H_v.
    pub fn loss_factor(&self, first_base: f64, ratio: f64, base_helix: f64) -> f64 {
        self.mean_segment().flanks[0].distance * (1.0 + 1.0 / ratio)
            / (first_base * base_helix.cos())
    }

    fn load_lever(&self, from: f64, to: f64, coast: bool) -> LoadLever {
        let middle = 0.5 * (from + to);
        let place = |psi: f64, pair: i32| {
            let drive = psi - self.approach;
            f64::from(pair) + if coast { -drive - 0.5 } else { drive }
        };
        let most = self.contact_ratio().ceil() as i32 + 2;
        let touching = (-most..=most).filter(|&pair| {
            let x = place(middle, pair);
            -self.approach < x && x < self.recess
        });
        let touching: Vec<i32> = touching.collect();
        let share = 1.0 / touching.len().max(1) as f64;
        let side = |pair: &i32| place(middle, *pair).signum();
        let balance: f64 = share * touching.iter().map(side).sum::<f64>();
        let distance: f64 = touching.iter().map(|p| side(p) * place(from, *p)).sum();
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

    /// Even sharing over the cycle gives Ohlendorf's factor, also inside a ring; its teeth are short, since the formula holds where no
    /// more than one pitch lies either side of the pitch point.
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
            let found = path.loss_factor(gears.base[0], i, 0.0);
            assert!(
                (found / ohlendorf - 1.0).abs() < 1e-13,
                "{found} {ohlendorf}"
            );
        }
    }

    /// Both flanks have the same means; the textbook's contact ratio of 20 and 60 teeth is 1.67.
    #[test]
    fn law_flanks_mirror() {
        let path = PathOfContact::new(&spur([20, 60], false)).unwrap();
        assert!(
            (path.contact_ratio() - 1.671).abs() < 1e-3,
            "{}",
            path.contact_ratio()
        );
        let pieces = path.segments();
        let ends = pieces.iter().skip(1).map(|p| p.from).chain([1.0]);
        let mut sums = [[0.0; 2]; 2];
        for (piece, to) in pieces.iter().zip(ends) {
            let width = to - piece.from;
            for (sum, reach) in sums.iter_mut().zip(&piece.flanks) {
                sum[0] += width * (reach.distance + 0.5 * width * reach.slope);
                sum[1] += width * reach.balance;
            }
        }
        assert!((sums[0][0] - sums[1][0]).abs() < 1e-12 * sums[0][0]);
        assert!((sums[0][1] - sums[1][1]).abs() < 1e-12);
    }

    /// Teeth cut too short never hand over.
    #[test]
    fn refuses_gaps() {
        let mut gears = spur([20, 60], false);
        gears.tip = [1.01e-2, 3.01e-2];
        assert_eq!(PathOfContact::new(&gears), None);
    }
}
