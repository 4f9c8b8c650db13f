//! Assignment of names to measured spectral lines: nearest expected line within both tolerances.

use crate::base::error::Error;

use super::validation::{check_count, check_positive};
use crate::base::code::Code;
use crate::numeric::sorting::sort_ascending;

/// A line that may be there.
#[derive(Debug, Clone, PartialEq)]
pub struct ExpectedLine {
    /// Name of the line.
    pub name: String,
    /// Position, as frequency in Hz or as order: all lines and peaks alike.
    pub position: f64,
    /// Largest deviation of the position because speed or geometry are not exactly known, in the unit of `position`.
    pub tolerance: f64,
}

/// A line that was measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredLine {
    /// Position, Hz or order.
    pub position: f64,
    /// Amplitude, zero to peak.
    pub amplitude: f64,
    /// Uncertainty of the position: half the width of a spectral line, or the standard deviation of an estimate, in the unit of `position`.
    pub uncertainty: f64,
}

/// Candidate lines of a peak.
#[derive(Debug, Clone, PartialEq)]
pub struct LineLabel {
    /// Numbers of the expected lines within reach, the nearest first; none where the peak was not expected.
    pub candidates: Vec<usize>,
    /// Number of candidates the measurement cannot distinguish: those no farther than the nearest by more than the peak's uncertainty. 0
    /// unexpected, 1 named, above that ambiguous.
    pub indistinguishable: usize,
}

/// One label for each peak, in their order. Expected lines may be listed in any order.
pub fn label_lines(peaks: &[MeasuredLine], expected_lines: &[ExpectedLine]) -> Vec<LineLabel> {
    let mut order: Vec<usize> = (0..expected_lines.len()).collect();
    order.sort_by(|&a, &b| {
        expected_lines[a]
            .position
            .total_cmp(&expected_lines[b].position)
    });
    let widest = expected_lines
        .iter()
        .fold(0.0_f64, |w, e| w.max(e.tolerance));
    let one = |peak: &MeasuredLine| {
        let reach = peak.uncertainty + widest;
        let from = order.partition_point(|&i| expected_lines[i].position < peak.position - reach);
        let distance = |i: usize| (expected_lines[i].position - peak.position).abs();
        let mut candidates: Vec<usize> = order[from..]
            .iter()
            .copied()
            .take_while(|&i| expected_lines[i].position <= peak.position + reach)
            .filter(|&i| distance(i) <= expected_lines[i].tolerance + peak.uncertainty)
            .collect();
        sort_ascending(&mut candidates, |&a| distance(a));
        let nearest = candidates.first().map_or(0.0, |&i| distance(i));
        let alike = candidates
            .iter()
            .take_while(|&&i| distance(i) - nearest <= peak.uncertainty)
            .count();
        LineLabel {
            candidates,
            indistinguishable: alike,
        }
    };
    peaks.iter().map(one).collect()
}

/// Definition of a family of harmonic lines.
#[derive(Debug, Clone, PartialEq)]
pub struct HarmonicFamily {
    /// Source of the family, such as `mesh 21/63`.
    pub name: String,
    /// Fundamental, Hz or order.
    pub fundamental: f64,
    /// Relative uncertainty of the fundamental.
    pub relative_tolerance: f64,
    /// Number of harmonics.
    pub harmonics: usize,
}

impl HarmonicFamily {
    /// The harmonics: `name`, `2 × name`, …
    pub fn harmonics(&self) -> Vec<ExpectedLine> {
        (1..=self.harmonics).map(|h| self.harmonic(h)).collect()
    }

    fn harmonic(&self, h: usize) -> ExpectedLine {
        let position = h as f64 * self.fundamental;
        ExpectedLine {
            name: if h == 1 {
                self.name.clone()
            } else {
                format!("{h} × {}", self.name)
            },
            position,
            tolerance: position * self.relative_tolerance,
        }
    }

    /// Sidebands of every harmonic at `± k` times another fundamental, `k` up to its harmonics, at positive positions only.
    pub fn sidebands(&self, by: &HarmonicFamily) -> Vec<ExpectedLine> {
        let mut lines = Vec::new();
        for carrier in self.harmonics() {
            for side in by.harmonics() {
                for (sign, word) in [(-1.0, '−'), (1.0, '+')] {
                    let position = carrier.position + sign * side.position;
                    if position > 0.0 {
                        lines.push(ExpectedLine {
                            name: format!("{} {word} {}", carrier.name, side.name),
                            position,
                            tolerance: carrier.tolerance + side.tolerance,
                        });
                    }
                }
            }
        }
        lines
    }
}

/// A rolling bearing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RollingBearing {
    /// Balls or rollers in one row.
    pub rollers: usize,
    /// Their diameter, m.
    pub roller_diameter: f64,
    /// Diameter of the circle through their centres, m.
    pub pitch_diameter: f64,
    /// Contact angle, rad.
    pub contact_angle: f64,
}

/// Frequencies of a bearing that rolls without slip, over the speed of the inner ring relative to the outer one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BearingOrders {
    /// Cage against the outer ring, `½ (1 − γ)` (FTF).
    pub cage: f64,
    /// Rollers passing a point of the outer ring, `n/2 (1 − γ)` (BPFO).
    pub outer_ring: f64,
    /// Rollers passing a point of the inner ring, `n/2 (1 + γ)` (BPFI).
    pub inner_ring: f64,
    /// A roller's own turning in the cage, `D/(2d) (1 − γ²)` (BSF); a fault on it strikes both rings, at twice this.
    pub roller: f64,
}

impl RollingBearing {
    /// With `γ = d/D cos α`: T. A. Harris, M. N. Kotzalas, Essential Concepts of Bearing Technology, 5th ed. (2006), chapter 10;
    /// slip makes the true values one or two per cent smaller or larger.
    ///
    /// # Errors
    /// Diameters or angles that make no bearing.
    pub fn orders(&self) -> Result<BearingOrders, Error> {
        check_count(self.rollers, 2, "the number of rolling elements")?;
        check_positive(
            self.roller_diameter,
            "the diameter of a rolling element, m,",
        )?;
        check_positive(self.pitch_diameter, "the pitch diameter, m,")?;
        let (d, pitch, n) = (
            self.roller_diameter,
            self.pitch_diameter,
            self.rollers as f64,
        );
        if d >= pitch || !(self.contact_angle.abs() < std::f64::consts::FRAC_PI_2) {
            return Err(Error::new(
                Code::OutOfRange,
                format!("rolling elements of {d} m on a pitch circle of {pitch} m at a contact angle of {} rad do not form a bearing", self.contact_angle),
            )
            .with_hint("give rolling elements smaller than the pitch circle, and an angle below 90°"));
        }
        let gamma = d / pitch * self.contact_angle.cos();
        Ok(BearingOrders {
            cage: 0.5 * (1.0 - gamma),
            outer_ring: 0.5 * n * (1.0 - gamma),
            inner_ring: 0.5 * n * (1.0 + gamma),
            roller: 0.5 * pitch / d * (1.0 - gamma * gamma),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// SKF 6205-2RS as listed by the Case Western Reserve University bearing data centre: 0.3126 in balls on 1.537 in, nine of
    /// them; 5.4152, 3.5848, 0.39828 and, for a fault on a ball, 4.7135 times the speed.
    #[test]
    fn ref_cwru_6205() {
        let bearing = RollingBearing {
            rollers: 9,
            roller_diameter: 0.3126 * 0.0254,
            pitch_diameter: 1.537 * 0.0254,
            contact_angle: 0.0,
        };
        let orders = bearing.orders().unwrap();
        assert!((orders.inner_ring - 5.4152).abs() < 1e-4, "{orders:?}");
        assert!((orders.outer_ring - 3.5848).abs() < 1e-4);
        assert!((orders.cage - 0.39828).abs() < 5e-5);
        assert!((2.0 * orders.roller - 4.7135).abs() < 2e-4);
        let flat = RollingBearing {
            roller_diameter: 1.0,
            ..bearing
        };
        assert_eq!(flat.orders().unwrap_err().code, Code::OutOfRange);
    }

    /// Both rings together see every roller: BPFO + BPFI = n; BPFO = n FTF.
    #[test]
    fn law_bearing_sums() {
        let mut rng = fastrand::Rng::with_seed(5);
        for _ in 0..100 {
            let bearing = RollingBearing {
                rollers: rng.usize(3..40),
                roller_diameter: 0.01 * rng.f64() + 1e-3,
                pitch_diameter: 0.05,
                contact_angle: rng.f64(),
            };
            let (n, o) = (bearing.rollers as f64, bearing.orders().unwrap());
            assert!((o.outer_ring + o.inner_ring - n).abs() < 1e-12 * n);
            assert!((o.outer_ring - n * o.cage).abs() < 1e-12 * n);
        }
    }

    /// A mesh at 21 orders with sidebands of its shaft, the wheel (1/3) and a line that was not expected.
    #[test]
    fn exact_names() {
        let family = |name: &str, fundamental, harmonics| HarmonicFamily {
            name: name.into(),
            fundamental,
            relative_tolerance: 1e-4,
            harmonics,
        };
        let (mesh, wheel) = (family("mesh", 21.0, 2), family("wheel", 1.0 / 3.0, 3));
        let mut expected_lines = mesh.harmonics();
        expected_lines.extend(family("pinion", 1.0, 2).harmonics());
        expected_lines.extend(wheel.harmonics());
        expected_lines.extend(mesh.sidebands(&wheel));
        let peak = |position| MeasuredLine {
            position,
            amplitude: 1.0,
            uncertainty: 0.02,
        };
        let labels = label_lines(
            &[peak(42.01), peak(20.66), peak(7.7), peak(1.0)],
            &expected_lines,
        );
        let name = |at: usize| &expected_lines[labels[at].candidates[0]].name;
        assert_eq!(
            (name(0).as_str(), labels[0].indistinguishable),
            ("2 × mesh", 1)
        );
        assert_eq!(
            (name(1).as_str(), labels[1].indistinguishable),
            ("mesh − wheel", 1)
        );
        assert_eq!(
            (labels[2].candidates.len(), labels[2].indistinguishable),
            (0, 0)
        );
        // three turns of the wheel are one of the pinion: the peak may be either
        assert_eq!(
            (labels[3].candidates.len(), labels[3].indistinguishable),
            (2, 2)
        );
    }

    #[test]
    fn survives_numbers_that_are_none() {
        let wild = ExpectedLine {
            name: "x".into(),
            position: f64::NAN,
            tolerance: f64::INFINITY,
        };
        let peak = MeasuredLine {
            position: f64::NAN,
            amplitude: 0.0,
            uncertainty: 0.1,
        };
        assert!(label_lines(&[peak], &[wild])[0].candidates.is_empty());
        assert!(label_lines(&[], &[]).is_empty());
    }
}
