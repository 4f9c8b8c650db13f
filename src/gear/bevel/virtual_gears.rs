//! Virtual cylindrical gears of a bevel pair without offset: `d_v = d_m/cos δ`, `z_v = z/cos δ`; their contact ratios.
//!
//! ISO 10300-1:2023, Annex A, method B1.

use std::f64::consts::PI;

use super::iso23509::BlankPair;

/// A pair of virtual cylindrical gears of the drive flanks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VirtualGears {
    /// Numbers of teeth z_v.
    pub teeth: [f64; 2],
    /// Reference diameters d_v, m.
    pub diameters: [f64; 2],
    /// Tip diameters d_va, m.
    pub tip_diameters: [f64; 2],
    /// Base diameters d_vb, m.
    pub base_diameters: [f64; 2],
    /// Transverse module m_vt, m.
    pub transverse_module: f64,
    /// Transverse pressure angle α_vet, rad.
    pub transverse_pressure_angle: f64,
    /// Base helix angle β_vb, rad.
    pub base_helix_angle: f64,
    /// Transverse base pitch p_vet, m.
    pub base_pitch: f64,
    /// Length of the path of contact g_vα, m.
    pub path_length: f64,
    /// Transverse contact ratio ε_vα.
    pub transverse_contact_ratio: f64,
    /// Overlap ratio ε_vβ.
    pub overlap_ratio: f64,
}

impl VirtualGears {
    /// The virtual gears of blanks of these tooth numbers that carry along an effective face width b_eff; none with an offset or an internal
    /// wheel.
    pub fn of(
        pair: &BlankPair,
        teeth: [u32; 2],
        effective_face_width: f64,
    ) -> Option<VirtualGears> {
        let cosines = pair.blanks.map(|b| b.pitch_angle.cos());
        if pair.offset_angles[0] != 0.0 || cosines[1] < 0.0 {
            return None;
        }
        let (beta, alpha) = (pair.spiral_angles[0], pair.pressure_angles[0]);
        let transverse_pressure_angle = (alpha.tan() / beta.cos()).atan();
        let of = |value: &dyn Fn(usize) -> f64| [value(0), value(1)];
        let diameters = of(&|k| 2.0 * pair.blanks[k].mean_point()[1] / cosines[k]);
        let tip_diameters = of(&|k| diameters[k] + 2.0 * pair.addenda[k]);
        let base_diameters = diameters.map(|d| d * transverse_pressure_angle.cos());
        let base_pitch = PI * pair.normal_module * transverse_pressure_angle.cos() / beta.cos();
        let approach = of(&|k| {
            let square = tip_diameters[k] * tip_diameters[k] - base_diameters[k].powi(2);
            0.5 * (square.sqrt() - diameters[k] * transverse_pressure_angle.sin())
        });
        let path_length = approach[0] + approach[1];
        Some(VirtualGears {
            teeth: of(&|k| f64::from(teeth[k]) / cosines[k]),
            diameters,
            tip_diameters,
            base_diameters,
            transverse_module: pair.normal_module / beta.cos(),
            transverse_pressure_angle,
            base_helix_angle: (beta.sin() * alpha.cos()).asin(),
            base_pitch,
            path_length,
            transverse_contact_ratio: path_length / base_pitch,
            overlap_ratio: effective_face_width * beta.sin() / (PI * pair.normal_module),
        })
    }
}
