//! Loaded transmission error of a pair: `C F = δ − g`, `Σ F = W = T/r_b1`, `e = −δ`; tangent stiffness dW/dδ, secant `W/(δ − δ₀)`.
//!
//! The pinion angle φ is zero with pair 0 in contact at the pitch point. Tooth pairs in possible contact
//! are divided into slices along the face width. The gap of a slice has terms from flank modifications, misalignment and, off the line of
//! action, the tip corner. Slices are not coupled. Positive e: the driven gear leads; a
//! load and relief make e negative; δ₀ is the unloaded approach.

use std::f64::consts::TAU;

use crate::base::bound::Bound;
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::base::quantity::format_number;
use crate::gear::cylindrical::member::MEMBERS;
use crate::gear::cylindrical::modification::FlankModification;
use crate::gear::cylindrical::pair::Pair;
use crate::numeric::complementarity::ContactSolution;

use super::compliance::{PairCompliance, StiffnessMethod};
use super::contact_path::ContactPath;
use super::hertz;
use super::iso6336::LEAST_LINE_LOAD;
use super::material::Material;
use super::mesh_result::{LoadedCycle, MeshResult, PairCurve};
use super::position::{MeshPoint, MeshPosition};

/// Largest number of slices along the face width: a map of more needs minutes.
pub const MAX_SLICES: u32 = 1000;
/// Largest number of positions per pitch: a map of more needs minutes.
pub const MAX_POSITIONS: u32 = 100_000;

/// Options of a loaded mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshOptions {
    /// Stiffness method of the tooth pairs.
    pub method: StiffnessMethod,
    /// Elastic constants of the gears.
    pub materials: [Material; 2],
    /// Flank modifications of both gears.
    pub modifications: [FlankModification; 2],
    /// Misalignment: slope of the gap along the face width in the plane of action, rad; positive opens the far end.
    pub misalignment: f64,
    /// True if the far end of the face, where a positive helix slope removes material, enters the mesh first; else last.
    pub far_end_leads: bool,
    /// Number of positions per pitch.
    pub positions: usize,
    /// Number of slices along the face width; see [`default_slices`].
    pub slices: usize,
}

/// Largest tooth deflection in modules: a load of 50 N/mm² over width and module gives 0.004, 700 N/mm² gives 0.05.
const MAX_DEFLECTION: f64 = 0.05;
/// Largest product of positions and slices: a map of more needs over a second.
const MAX_GRID: usize = 1_000_000;
/// Smallest default number of slices.
const MIN_SLICES: usize = 11;
/// Number of slices per axial pitch: contact lines end in tip corners, with a decay of load to zero over some 3 % of the pitch.
const SLICES_PER_PITCH: f64 = 40.0;

/// Largest overlap ratio of a loaded mesh, from the largest number of slices.
const MAX_OVERLAP: f64 = MAX_SLICES as f64 / SLICES_PER_PITCH;

/// Default number of slices for an overlap ratio: error of e(φ, T) about 1 % of the peak to peak.
pub fn default_slices(overlap: f64) -> usize {
    let count = (SLICES_PER_PITCH * overlap).ceil() as usize;
    count.clamp(MIN_SLICES, MAX_SLICES as usize)
}

impl Default for MeshOptions {
    fn default() -> MeshOptions {
        MeshOptions {
            method: StiffnessMethod::default(),
            materials: [Material::default(); 2],
            modifications: [FlankModification::default(); 2],
            misalignment: 0.0,
            far_end_leads: false,
            positions: 60,
            slices: MIN_SLICES,
        }
    }
}

/// Loaded mesh of a cylindrical pair.
#[derive(Debug, Clone)]
pub struct LoadedMesh {
    options: MeshOptions,
    path: ContactPath,
    compliance: PairCompliance,
    /// Common face width, m.
    width: f64,
    /// Normal module, m.
    module: f64,
    /// Reference radius of the pinion, m.
    reference_radius: f64,
    /// Tangent of the base helix angle.
    base_helix: f64,
    pinion_teeth: u32,
    /// Numbers of the tooth pairs in possible contact over one pitch.
    pairs: Vec<i32>,
}

impl LoadedMesh {
    /// Loaded mesh of a pair with options.
    ///
    /// # Errors
    /// `OutOfRange`: no positions, slices or contact, options that are not finite; as `PairCompliance::new`.
    pub fn new(pair: &Pair, options: MeshOptions) -> Result<LoadedMesh, Error> {
        check(&options)?;
        check_modifications(pair, &options.modifications)?;
        let path = ContactPath::new(pair);
        if !(path.ends[1] > path.ends[0]) {
            let message = format!(
                "the teeth do not touch: path of contact of {:.4} mm",
                1e3 * (path.ends[1] - path.ends[0])
            );
            return Err(Error::new(Code::OutOfRange, message)
                .with_hint("give larger tip diameters or a smaller centre distance"));
        }
        check_overlap(pair)?;
        let gear = &pair.members[0].gear;
        let width = pair.members[0].face_width.min(pair.members[1].face_width);
        let base_helix = (gear.helix.sin() * gear.pressure_angle.cos())
            .asin()
            .abs()
            .tan();
        let [low, high] = path.reach();
        let half_lag = 0.5 * width * base_helix;
        let pair_number = |roll: f64| (roll - path.pitch_rolls[0]) / path.base_pitch;
        let first = (pair_number(low - half_lag) - 1.0).ceil() as i32;
        let last = pair_number(high + half_lag).floor() as i32;
        Ok(LoadedMesh {
            compliance: PairCompliance::new(pair, &options.method, &options.materials)?,
            options,
            path,
            width,
            module: gear.module,
            reference_radius: 0.5 * gear.reference_diameter(),
            base_helix,
            pinion_teeth: gear.teeth,
            pairs: (first..=last).collect(),
        })
    }

    /// Contact points, gaps and compliances of the mesh at a pinion angle, rad.
    ///
    /// # Errors
    /// `OutOfRange`: no tooth pair in possible contact.
    pub fn position(&self, angle: f64) -> Result<MeshPosition, Error> {
        let slices = self.options.slices;
        let slice_width = self.width / slices as f64;
        let mut points = Vec::with_capacity(self.pairs.len() * slices);
        for (pair, number) in self.pairs.iter().enumerate() {
            let middle = self.path.pitch_rolls[0]
                + self.path.base[0] * angle
                + f64::from(*number) * self.path.base_pitch;
            for slice in self.slices_near(middle) {
                let face = (slice as f64 + 0.5) / slices as f64;
                let offset = (face - 0.5) * self.width;
                let Some(place) = self.path.place(middle - offset * self.base_helix) else {
                    continue;
                };
                let to_far_end = match self.options.far_end_leads {
                    true => 1.0 - face,
                    false => face,
                };
                let removed = |i: usize| {
                    let ends = self.path.flank_ends[i];
                    self.options.modifications[i].removed(place.rolls[i], ends, to_far_end)
                };
                let tilt = self.options.misalignment * (to_far_end - 0.5) * self.width;
                let gap = place.gap + removed(0) + removed(1) + tilt;
                points.push(MeshPoint {
                    pair,
                    place,
                    gap,
                    compliance: self.compliance.at(place.rolls) / slice_width,
                });
            }
        }
        if points.is_empty() {
            let message = format!(
                "no tooth pair can touch at the pinion angle {:.4} deg",
                angle.to_degrees()
            );
            return Err(Error::new(Code::OutOfRange, message)
                .with_hint("the contact ratio is too small: give larger tip diameters"));
        }
        MeshPosition::new(points, self.path.base[0])
    }

    /// Slices of a tooth pair in possible contact for a length of roll at mid-face, m: those on the path, and one on either side.
    fn slices_near(&self, middle: f64) -> std::ops::Range<usize> {
        let slices = self.options.slices;
        let lag = self.width * self.base_helix;
        if !(lag > 0.0) {
            return 0..slices;
        }
        // Share of the face, from the near end, at which the slice has a length of roll.
        let share = |roll: f64| (middle - roll) / lag + 0.5;
        let [low, high] = self.path.reach();
        let first = (share(high) * slices as f64 - 1.0).max(0.0) as usize;
        let last = (share(low) * slices as f64 + 2.0).max(0.0) as usize;
        first.min(slices)..last.min(slices)
    }

    /// Loaded results over one pitch at several pinion torques, N·m.
    ///
    /// # Errors
    /// `OutOfRange`: a torque that is not positive; as `position` and `ContactProblem::solve`.
    pub fn map(&self, torques: &[f64]) -> Result<MeshResult, Error> {
        let count = self.options.positions;
        let pitch = TAU / f64::from(self.pinion_teeth);
        let angles: Vec<f64> = (0..count)
            .map(|i| pitch * i as f64 / count as f64)
            .collect();
        let mut unloaded_te = Vec::with_capacity(count);
        let mut cycles: Vec<LoadedCycle> = torques
            .iter()
            .map(|t| LoadedCycle::new(*t, count))
            .collect();
        for angle in &angles {
            let position = self.position(*angle)?;
            unloaded_te.push(position.unloaded_te());
            let mut start: Option<Vec<bool>> = None;
            for cycle in &mut cycles {
                let solution = self.solve(&position, cycle.torque, start.as_deref())?;
                self.append(&position, &solution, cycle);
                start = Some(solution.active);
            }
        }
        Ok(MeshResult {
            method: self.options.method.name(),
            bodies: self.options.method.bodies(),
            driven_base_radius: self.path.base[1],
            pinion_angles: angles,
            pairs: self.pairs.clone(),
            unloaded_te,
            warnings: self.warnings(&cycles),
            cycles,
        })
    }

    /// Stiffness and gap of one tooth pair at a pinion torque, N·m: secant stiffness of the pair load from first contact, without load
    /// the stiffness of all slices. Springs with these curves, spaced by one pitch, carry the load at the approach of `map`.
    ///
    /// # Errors
    /// As `map`.
    pub fn pair_curve(&self, torque: f64) -> Result<PairCurve, Error> {
        let count = self.options.positions;
        let pitch = TAU / f64::from(self.pinion_teeth);
        let n = self.pairs.len();
        let mut curve = PairCurve {
            angles: Vec::with_capacity(n * count),
            stiffness: vec![0.0; n * count],
            gap: vec![f64::INFINITY; n * count],
        };
        for number in &self.pairs {
            let angle_at = |i: usize| pitch * (f64::from(*number) + i as f64 / count as f64);
            curve.angles.extend((0..count).map(angle_at));
        }
        for i in 0..count {
            let position = self.position(pitch * i as f64 / count as f64)?;
            let solution = self.solve(&position, torque, None)?;
            for pair in 0..n {
                let (stiffness, gap) = position.spring(pair, &solution);
                curve.stiffness[pair * count + i] = stiffness;
                curve.gap[pair * count + i] = gap;
            }
        }
        Ok(curve)
    }

    /// Contact forces at a pinion torque, N·m; an error above the largest deflection.
    fn solve(
        &self,
        position: &MeshPosition,
        torque: f64,
        start: Option<&[bool]>,
    ) -> Result<ContactSolution, Error> {
        let solution = position.solve(torque, start)?;
        if solution.deflection <= MAX_DEFLECTION * self.module {
            return Ok(solution);
        }
        let message = format!(
            "the teeth deflect by {} mm at {} N·m: more than a twentieth of the module",
            format_number(1e3 * solution.deflection),
            format_number(torque)
        );
        let largest = format_number(self.largest_torque(torque)?);
        let error = Error::new(Code::OutOfRange, message).with_key("torque");
        Err(error.with_hint(format!("give a torque of at most {largest} N·m")))
    }

    /// Torque, N·m, with admissible deflection at all positions, below an excessive torque.
    fn largest_torque(&self, torque: f64) -> Result<f64, Error> {
        /// Safety factor for the rounding of the printed torque.
        const ROUNDING_MARGIN: f64 = 0.99;
        let pitch = TAU / f64::from(self.pinion_teeth);
        let count = self.options.positions;
        let limit = MAX_DEFLECTION * self.module;
        let mut admissible = torque;
        for i in 0..count {
            let position = self.position(pitch * i as f64 / count as f64)?;
            loop {
                let deflection = position.solve(admissible, None)?.deflection;
                if deflection <= limit {
                    break;
                }
                admissible *= ROUNDING_MARGIN * limit / deflection;
            }
        }
        Ok(admissible)
    }

    fn append(&self, position: &MeshPosition, solution: &ContactSolution, cycle: &mut LoadedCycle) {
        let load = cycle.torque / self.path.base[0];
        cycle.te.push(-solution.approach);
        cycle.secant.push(load / solution.deflection);
        cycle.tangent.push(solution.stiffness);
        let slice_width = self.width / self.options.slices as f64;
        // Radius of the normal section; force and contact line have the same helix factor, so the line load does not change.
        let helix_factor = self.base_helix.hypot(1.0);
        let mut shares = vec![0.0; self.pairs.len()];
        let (mut corner, mut pressure) = (0.0, None);
        for (point, force) in position.points.iter().zip(&solution.forces) {
            let share = force / load;
            shares[point.pair] += share;
            if point.place.corner.is_some() {
                corner += share;
            } else if let Some(radius) = self.path.relative_radius(&point.place)
                && *force > 0.0
            {
                let line_load = force / slice_width;
                let materials = &self.options.materials;
                let peak = hertz::line_pressure(line_load, radius * helix_factor, materials);
                pressure = Some(peak.max(pressure.unwrap_or(0.0)));
            }
        }
        cycle.shares.push(shares);
        cycle.corner_share.push(corner);
        cycle.pressure.push(pressure);
    }

    fn warnings(&self, cycles: &[LoadedCycle]) -> Vec<Diagnostic> {
        let messages = self.compliance.outside_range().into_iter();
        let mut warnings: Vec<Diagnostic> = messages
            .map(|message| Diagnostic {
                code: "stiffness-range",
                message,
                hint: None,
            })
            .collect();
        let torques: Vec<f64> = cycles.iter().map(|cycle| cycle.torque).collect();
        let is_iso = matches!(self.options.method, StiffnessMethod::Iso6336 { .. });
        let below = self.below_iso_load(&torques).filter(|_| is_iso);
        warnings.extend(below.map(|message| Diagnostic {
            code: "stiffness-range",
            message,
            hint: Some("use the energy method for small loads".into()),
        }));
        warnings
    }

    /// Message on the smallest line load F_t/b, F_t at the reference circle, below the range of c′ of ISO 6336-1.
    pub fn below_iso_load(&self, torques: &[f64]) -> Option<String> {
        let line_load = |torque: &f64| torque / self.reference_radius / self.width;
        let lowest = torques.iter().map(line_load).fold(f64::INFINITY, f64::min);
        (lowest < LEAST_LINE_LOAD).then(|| {
            format!(
                "line load of {:.3} N/mm is below 100 N/mm, where c′ of ISO 6336-1 falls with the load",
                1e-3 * lowest
            )
        })
    }
}

/// Checks the modifications of both gears against their flanks.
///
/// # Errors
/// As `FlankModification::check`.
pub fn check_modifications(
    pair: &Pair,
    modifications: &[FlankModification; 2],
) -> Result<(), Error> {
    let ends = ContactPath::new(pair).flank_ends;
    let mut gears = modifications.iter().zip(ends).zip(MEMBERS);
    gears.try_for_each(|((modification, ends), name)| {
        let result = modification.check(ends, pair.members[0].gear.module);
        result.map_err(|error| error.with_part(name))
    })
}

/// Checks the overlap ratio against the resolution of the slices.
fn check_overlap(pair: &Pair) -> Result<(), Error> {
    let overlap = pair.contact_ratios().overlap;
    if overlap <= MAX_OVERLAP {
        return Ok(());
    }
    let width = pair.members[0].face_width.min(pair.members[1].face_width);
    let message = format!("the face is {overlap:.1} axial pitches wide (limit {MAX_OVERLAP})");
    let max_width = Bound::AtMost(1e3 * width * MAX_OVERLAP / overlap).text(3);
    let narrower = usize::from(pair.members[1].face_width < pair.members[0].face_width);
    let error = Error::new(Code::OutOfRange, message).with_key("face_width");
    Err(error.with_part(MEMBERS[narrower]).with_hint(format!(
        "give face_width = \"{max_width} mm\" or less and the share of the torque it carries"
    )))
}

fn check(options: &MeshOptions) -> Result<(), Error> {
    let out_of_range = |message: String| Err(Error::new(Code::OutOfRange, message));
    if !(1..=MAX_SLICES as usize).contains(&options.slices) {
        let slices = options.slices;
        return out_of_range(format!("{slices} slices (limits 1 to {MAX_SLICES})"));
    }
    if !(1..=MAX_POSITIONS as usize).contains(&options.positions) {
        let positions = options.positions;
        return out_of_range(format!(
            "{positions} positions per pitch (limits 1 to {MAX_POSITIONS})"
        ));
    }
    if options.positions * options.slices > MAX_GRID {
        let [positions, slices] = [options.positions, options.slices];
        return out_of_range(format!(
            "{positions} positions × {slices} slices (limit {MAX_GRID})"
        ));
    }
    for material in &options.materials {
        let Material { young, poisson } = *material;
        if !(young > 0.0 && young.is_finite() && (0.0..0.5).contains(&poisson)) {
            return out_of_range(format!(
                "elastic constants are {young} Pa and {poisson}; the modulus must be positive, Poisson's ratio from 0 to below 0.5"
            ));
        }
    }
    if !options.misalignment.is_finite() {
        return out_of_range(format!(
            "misalignment is {}; it must be finite",
            options.misalignment
        ));
    }
    Ok(())
}
