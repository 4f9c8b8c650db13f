//! A worm pair on crossed axes: `δ = s (z₁θ₁ ± z₂θ₂) + lateral terms`, `s = m cos αₙ cos γ / 2`, + for a right-hand worm.
//!
//! Driving efficiency `η = tan γ / tan(γ + ρ)`, backwards `η' = tan(γ − ρ)/tan γ`, `ρ = atan(μ / cos αₙ)`; the pair locks
//! itself where γ ≤ ρ (Niemann & Winter, Maschinenelemente III, 2nd ed. 1986, sec. 24.3.3). The losses act against the mean
//! sliding and do not enter small vibrations about steady running.

use super::mesh::{MeshPair, MeshSide, add_pair};
use crate::base::error::Error;
use crate::machine::builder::MachineBuilder;
use crate::scene::model::{Hand, WormPair};

/// Puts the mesh between worm and wheel, and states efficiency and self-locking.
pub fn add(builder: &mut MachineBuilder, element: usize, pair: &WormPair) -> Result<(), Error> {
    let module = pair.module.unwrap_or(2.0);
    let made = MeshPair {
        scale: module * pair.pressure_angle.cos() * pair.lead_angle.cos() / 2.0,
        drive: sides(pair, module, pair.pressure_angle),
        coast: sides(pair, module, -pair.pressure_angle),
        teeth: pair.teeth,
        cylindrical: None,
        sized: pair.module.is_some(),
    };
    add_pair(builder, element, &made, &pair.contact)?;
    if let Some(friction) = pair.friction {
        let Efficiency { driving, backwards } =
            efficiency(pair.lead_angle, pair.pressure_angle, friction);
        let back = match backwards {
            Some(eta) => format!("backwards {:.0} %", 100.0 * eta),
            None => "self-locking when back-driven".to_string(),
        };
        let text = format!(
            "{}: efficiency {:.0} % driving, {back}",
            pair.name.text,
            100.0 * driving
        );
        builder.add_diagnostic("worm-efficiency", text);
    }
    Ok(())
}

/// Efficiencies of a worm pair.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Efficiency {
    /// Worm drives wheel.
    pub driving: f64,
    /// Wheel drives worm; `None` where it locks itself.
    pub backwards: Option<f64>,
}

/// Efficiencies from lead angle γ, normal pressure angle αₙ, rad, and the coefficient of friction.
pub fn efficiency(lead: f64, pressure: f64, friction: f64) -> Efficiency {
    let rho = (friction / pressure.cos()).atan();
    let backwards = (lead > rho).then(|| (lead - rho).tan() / lead.tan());
    Efficiency {
        driving: lead.tan() / (lead + rho).tan(),
        backwards,
    }
}

/// Worm and wheel as the flank with the signed pressure angle `alpha` sees them.
fn sides(pair: &WormPair, module: f64, alpha: f64) -> [MeshSide<'_>; 2] {
    let hand = if pair.hand == Hand::Right { 1.0 } else { -1.0 };
    let (sin_lead, cos_lead) = pair.lead_angle.sin_cos();
    let [starts, teeth] = pair.teeth.map(f64::from);
    let worm = MeshSide {
        node: &pair.between[0],
        sign: 1.0,
        normal: [
            alpha.sin(),
            alpha.cos() * sin_lead,
            -hand * alpha.cos() * cos_lead,
        ],
        theta_coefficient: starts,
        radius: starts * module / (2.0 * pair.lead_angle.tan()),
        angle: pair.mesh_angles[0],
    };
    let wheel = MeshSide {
        node: &pair.between[1],
        sign: -1.0,
        normal: [
            -alpha.sin(),
            -hand * alpha.cos() * cos_lead,
            alpha.cos() * sin_lead,
        ],
        theta_coefficient: hand * teeth,
        radius: teeth * module / 2.0,
        angle: pair.mesh_angles[1],
    };
    [worm, wheel]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// γ = 5°, αₙ = 20°, μ = 0.1: ρ = 6.0744°, so it locks itself and drives with 44.7 %.
    #[test]
    fn exact_self_locking_worm() {
        let eta = efficiency(5f64.to_radians(), 20f64.to_radians(), 0.1);
        let rho = (0.1 / 20f64.to_radians().cos()).atan();
        assert!(
            (rho.to_degrees() - 6.0744).abs() < 1e-4,
            "{}",
            rho.to_degrees()
        );
        assert!(
            (eta.driving - 5f64.to_radians().tan() / (5f64.to_radians() + rho).tan()).abs() < 1e-15
        );
        assert_eq!(eta.backwards, None);
        assert!(
            efficiency(20f64.to_radians(), 20f64.to_radians(), 0.05)
                .backwards
                .unwrap()
                > 0.8
        );
    }
}
