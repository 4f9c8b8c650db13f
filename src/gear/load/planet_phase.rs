//! Phase between the two meshes of a planet: `z_p (ψ(r_ws) + ψ(r_wr))/2π − z_p/2`, ψ the half angle of its tooth at both pitch circles.
//!
//! Sun and ring touch opposite flanks of the planet, half a turn apart. Without backlash at one pitch circle ψ = π/(2 z_p): half a pitch
//! for an even tooth number, none for an odd one (Parker and Lin, J. Mech. Des. 126 (2004), eq. 12).

use std::f64::consts::TAU;

use crate::base::code::Code;
use crate::base::error::Error;
use crate::gear::cylindrical::pair::Pair;

/// By how much of a pitch, from 0 to below 1, the cycle of the planet's mesh with the ring is ahead of that with the sun; a cycle
/// begins where a pair touches at the pitch point. `sun` is sun and planet, `ring` planet and ring.
///
/// # Errors
/// `Conflict`: the second gear of one pair is not the first of the other, or the last is not internal. `OutOfRange`: a pitch circle
/// that does not cut the planet's teeth.
pub fn planet_phase(sun: &Pair, ring: &Pair) -> Result<f64, Error> {
    let planet = &sun.outlines[1];
    if *planet != ring.outlines[0] || !ring.outlines[1].internal {
        let message = "the planet of the sun's mesh is not that of the ring's mesh";
        return Err(Error::new(Code::Conflict, message)
            .with_hint("give the pair of sun and planet, then the pair of planet and ring"));
    }
    let half_angle = |pair: &Pair| {
        let radius = planet.base_radius / pair.working_pressure_angle.cos();
        planet.half_angle(radius).ok_or_else(|| {
            let message = format!(
                "pitch circle of {:.4} mm radius is outside the planet's teeth",
                1e3 * radius
            );
            Error::new(Code::OutOfRange, message)
        })
    };
    let teeth = f64::from(planet.teeth);
    let angles = half_angle(sun)? + half_angle(ring)?;
    Ok((teeth * angles / TAU - 0.5 * teeth).rem_euclid(1.0))
}
