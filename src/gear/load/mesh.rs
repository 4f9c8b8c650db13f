//! Loaded transmission error of a pair: `C F = δ − g`, `Σ F = W = T/r_b1`, `e = −δ`; tangent stiffness dW/dδ, secant `W/(δ − δ₀)`.
//!
//! At a pinion angle φ, counted from where pair 0 touches at the pitch point, the candidates are the tooth pairs that can touch there,
//! each cut into slices along the face width. A slice has the gap of its flanks' modifications, of misalignment and, off the line of
//! action, of the tip corner, and the compliance of its place; slices are not coupled. e is positive where the driven gear leads, so a
//! load and relief make it negative; δ₀ is the approach without load.

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

/// Most slices along the face width: above it a map needs minutes.
pub const MAX_SLICES: u32 = 1000;
/// Most positions in one pitch: above it a map needs minutes.
pub const MAX_POSITIONS: u32 = 100_000;

/// Options of a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshOptions {
    /// Stiffness of the tooth pairs.
    pub method: StiffnessMethod,
    /// Elastic constants of the gears.
    pub materials: [Material; 2],
    /// Modifications of the gears' flanks.
    pub modifications: [FlankModification; 2],
    /// Slope of the gap along the face width in the plane of action, rad; positive opens the far end.
    pub misalignment: f64,
    /// The far end of the face, where a positive helix slope removes material, enters mesh first; else it leaves mesh last.
    pub far_end_leads: bool,
    /// Positions in one pitch.
    pub positions: usize,
    /// Slices along the face width; see [`default_slices`].
    pub slices: usize,
}

/// Deflection in modules that no tooth bears: at 50 N/mm² of load over width and module teeth deflect by 0.004 of it, 0.05 is 700 N/mm².
const LARGEST_DEFLECTION: f64 = 0.05;
/// Positions times slices: above it a map needs more than a second.
const MAX_GRID: usize = 1_000_000;
/// Slices of a face as wide as the least of any pair.
const LEAST_SLICES: usize = 11;
/// Slices in an axial pitch: contact lines end in tip corners, whose load falls to nothing over some 3 % of it.
const SLICES_OF_A_PITCH: f64 = 40.0;

/// Largest overlap ratio of a face that is loaded: the slices it needs then are the most there are.
const LARGEST_OVERLAP: f64 = MAX_SLICES as f64 / SLICES_OF_A_PITCH;

/// Slices at which e(φ, T) of a pair of an overlap ratio is good to about 1 % of its peak to peak.
pub fn default_slices(overlap: f64) -> usize {
    let wanted = (SLICES_OF_A_PITCH * overlap).ceil() as usize;
    wanted.clamp(LEAST_SLICES, MAX_SLICES as usize)
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
            slices: LEAST_SLICES,
        }
    }
}

/// A pair ready to be loaded.
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
    /// Tooth pairs that can touch over one pitch.
    pairs: Vec<i32>,
}

impl LoadedMesh {
    /// A pair with its options.
    ///
    /// # Errors
    /// `OutOfRange`: no positions, slices or contact, options that are not finite; as `PairCompliance::new`.
    pub fn new(pair: &Pair, options: MeshOptions) -> Result<LoadedMesh, Error> {
        check(&options)?;
        check_modifications(pair, &options.modifications)?;
        let path = ContactPath::new(pair);
        if !(path.ends[1] > path.ends[0]) {
            let message = format!(
                "the teeth do not reach each other: path of contact of {:.4} mm",
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
        let lean = 0.5 * width * base_helix;
        let number = |roll: f64| (roll - path.pitch_rolls[0]) / path.base_pitch;
        let first = (number(low - lean) - 1.0).ceil() as i32;
        let last = number(high + lean).floor() as i32;
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

    /// The mesh at a pinion angle, rad.
    ///
    /// # Errors
    /// `OutOfRange`: no pair of teeth can touch there.
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
                let behind = (face - 0.5) * self.width;
                let Some(place) = self.path.place(middle - behind * self.base_helix) else {
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

    /// Slices of a tooth pair that can touch where its middle has a length of roll: those in reach of the path, and one on either side.
    fn slices_near(&self, middle: f64) -> std::ops::Range<usize> {
        let slices = self.options.slices;
        let lean = self.width * self.base_helix;
        if !(lean > 0.0) {
            return 0..slices;
        }
        // Share of the face, from the near end, at which the slice has a length of roll.
        let share = |roll: f64| (middle - roll) / lean + 0.5;
        let [low, high] = self.path.reach();
        let first = (share(high) * slices as f64 - 1.0).max(0.0) as usize;
        let last = (share(low) * slices as f64 + 2.0).max(0.0) as usize;
        first.min(slices)..last.min(slices)
    }

    /// The pitch at several torques of the pinion, N·m.
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
                let solution = self.loaded(&position, cycle.torque, start.as_deref())?;
                self.enter(&position, &solution, cycle);
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

    /// Stiffness and gap of one tooth pair at a torque of the pinion: secant of its own load from its first touch where it carries, that of
    /// all its slices together where it does not. Springs of this curve, a pitch apart, carry the load at the approach of `map`.
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
            let at = |i: usize| pitch * (f64::from(*number) + i as f64 / count as f64);
            curve.angles.extend((0..count).map(at));
        }
        for i in 0..count {
            let position = self.position(pitch * i as f64 / count as f64)?;
            let solution = self.loaded(&position, torque, None)?;
            for pair in 0..n {
                let (stiffness, gap) = position.spring(pair, &solution);
                curve.stiffness[pair * count + i] = stiffness;
                curve.gap[pair * count + i] = gap;
            }
        }
        Ok(curve)
    }

    /// Forces at a torque, unless the teeth deflect by more than they bear.
    fn loaded(
        &self,
        position: &MeshPosition,
        torque: f64,
        start: Option<&[bool]>,
    ) -> Result<ContactSolution, Error> {
        let solution = position.solve(torque, start)?;
        if solution.deflection <= LARGEST_DEFLECTION * self.module {
            return Ok(solution);
        }
        let message = format!(
            "the teeth deflect by {} mm at {} N·m: more than a twentieth of the module, which no tooth bears",
            format_number(1e3 * solution.deflection),
            format_number(torque)
        );
        let largest = format_number(self.largest_torque(torque)?);
        let error = Error::new(Code::OutOfRange, message).about("torque");
        Err(error.with_hint(format!("give a torque of at most {largest} N·m")))
    }

    /// A torque below one that is too large, at which no position deflects by more than the teeth bear.
    fn largest_torque(&self, torque: f64) -> Result<f64, Error> {
        /// Off the limit, so that the printed torque is below it too.
        const BELOW: f64 = 0.99;
        let pitch = TAU / f64::from(self.pinion_teeth);
        let count = self.options.positions;
        let limit = LARGEST_DEFLECTION * self.module;
        let mut least = torque;
        for i in 0..count {
            let position = self.position(pitch * i as f64 / count as f64)?;
            loop {
                let deflection = position.solve(least, None)?.deflection;
                if deflection <= limit {
                    break;
                }
                least *= BELOW * limit / deflection;
            }
        }
        Ok(least)
    }

    fn enter(&self, position: &MeshPosition, solution: &ContactSolution, cycle: &mut LoadedCycle) {
        let load = cycle.torque / self.path.base[0];
        cycle.te.push(-solution.approach);
        cycle.secant.push(load / solution.deflection);
        cycle.tangent.push(solution.stiffness);
        let slice_width = self.width / self.options.slices as f64;
        // The radius of the normal section; force and contact line lengthen alike with the helix, so the line load does not change.
        let lengthened = self.base_helix.hypot(1.0);
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
                let here = hertz::line_pressure(line_load, radius * lengthened, materials);
                pressure = Some(here.max(pressure.unwrap_or(0.0)));
            }
        }
        cycle.shares.push(shares);
        cycle.corner_share.push(corner);
        cycle.pressure.push(pressure);
    }

    fn warnings(&self, cycles: &[LoadedCycle]) -> Vec<Diagnostic> {
        let outside = self.compliance.outside_range().into_iter();
        let mut warnings: Vec<Diagnostic> = outside
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
            hint: Some("take the energy method for small loads".into()),
        }));
        warnings
    }

    /// Statement of the least line load F_t/b, with the tangential force at the reference circle, where c′ of ISO 6336-1 does not hold for it.
    pub fn below_iso_load(&self, torques: &[f64]) -> Option<String> {
        let line_load = |torque: &f64| torque / self.reference_radius / self.width;
        let least = torques.iter().map(line_load).fold(f64::INFINITY, f64::min);
        (least < LEAST_LINE_LOAD).then(|| {
            format!(
                "line load of {:.3} N/mm is below 100 N/mm, where c′ of ISO 6336-1 falls with the load",
                1e-3 * least
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
    let mut each = modifications.iter().zip(ends).zip(MEMBERS);
    each.try_for_each(|((modification, ends), name)| {
        let checked = modification.check(ends, pair.members[0].gear.module);
        checked.map_err(|error| error.in_part(name))
    })
}

/// Refuses faces of more axial pitches than slices resolve.
fn check_overlap(pair: &Pair) -> Result<(), Error> {
    let overlap = pair.contact_ratios().overlap;
    if overlap <= LARGEST_OVERLAP {
        return Ok(());
    }
    let width = pair.members[0].face_width.min(pair.members[1].face_width);
    let message = format!(
        "the face is {overlap:.1} axial pitches wide; a loaded mesh takes at most {LARGEST_OVERLAP}"
    );
    let most = Bound::AtMost(1e3 * width * LARGEST_OVERLAP / overlap).text(3);
    let narrower = usize::from(pair.members[1].face_width < pair.members[0].face_width);
    let error = Error::new(Code::OutOfRange, message).about("face_width");
    Err(error.in_part(MEMBERS[narrower]).with_hint(format!(
        "give face_width = \"{most} mm\" or less and the share of the torque it carries"
    )))
}

fn check(options: &MeshOptions) -> Result<(), Error> {
    let out_of_range = |message: String| Err(Error::new(Code::OutOfRange, message));
    if !(1..=MAX_SLICES as usize).contains(&options.slices) {
        let slices = options.slices;
        return out_of_range(format!("{slices} slices; the face has 1 to {MAX_SLICES}"));
    }
    if !(1..=MAX_POSITIONS as usize).contains(&options.positions) {
        let positions = options.positions;
        return out_of_range(format!(
            "{positions} positions; a pitch has 1 to {MAX_POSITIONS}"
        ));
    }
    if options.positions * options.slices > MAX_GRID {
        let [positions, slices] = [options.positions, options.slices];
        return out_of_range(format!(
            "{positions} positions × {slices} slices; a mesh has at most {MAX_GRID} places"
        ));
    }
    for material in &options.materials {
        let Material { young, poisson } = *material;
        if !(young > 0.0 && young.is_finite() && (0.0..0.5).contains(&poisson)) {
            return out_of_range(format!(
                "elastic constants are {young} Pa and {poisson}; the modulus is positive, Poisson's ratio from 0 to below 0.5"
            ));
        }
    }
    if !options.misalignment.is_finite() {
        return out_of_range(format!(
            "misalignment is {}; it is finite",
            options.misalignment
        ));
    }
    Ok(())
}
