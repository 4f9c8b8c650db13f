//! Loaded contact of flanks over one pitch: transmission error, stiffness, shares, pressure and places by torque and position.

use std::collections::BTreeMap;

use super::tooth_plate::RootMoment;

/// A change of the set of strips that carry as the load is raised.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StripChange {
    /// Torque at the pinion, N·m.
    pub torque: f64,
    /// The pair of teeth.
    pub pair: i32,
    /// Share of the pinion's face.
    pub face: f64,
    /// The strip begins to carry; else it ceases.
    pub begins: bool,
}

impl StripChange {
    /// Torque at which so many pairs of teeth carry for the first time on a path from zero; none where they never do or do from the start.
    pub fn first_with(path: &[StripChange], pairs: usize) -> Option<f64> {
        let mut strips: BTreeMap<i32, i64> = BTreeMap::new();
        let first = path.iter().find(|change| {
            *strips.entry(change.pair).or_default() += if change.begins { 1 } else { -1 };
            strips.values().filter(|n| **n > 0).count() == pairs
        });
        first.map(|change| change.torque)
    }
}

/// A cell that carries.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadedPlace {
    /// The pair of teeth.
    pub pair: i32,
    /// `[z, radius]` in the frames of pinion and gear, m.
    pub at: [[f64; 2]; 2],
    /// Share of the pinion's face.
    pub face: f64,
    /// Normal force, N.
    pub force: f64,
    /// Force of a unit length, N/m: of an ellipse the greatest, half width times pressure times π/2.
    pub line_load: f64,
    /// Greatest pressure, Pa.
    pub pressure: f64,
    /// Half width of the contact, m.
    pub width: f64,
    /// It lies on an edge.
    pub on_edge: bool,
}

/// The flanks at one position under one torque.
#[derive(Debug, Clone, PartialEq)]
pub struct FlankLoad {
    /// Transmission error, rad at the gear: positive where it leads.
    pub te: f64,
    /// Secant stiffness T/Δ between no load and this one, N·m/rad at the gear.
    pub secant: f64,
    /// Tangent stiffness dT/dΔ, N·m/rad at the gear.
    pub tangent: f64,
    /// Pairs of teeth that can touch, each with its share of the torque.
    pub shares: Vec<(i32, f64)>,
    /// Greatest pressure within the flanks, away from edges that carry, Pa; none where there is no such place.
    pub pressure: Option<f64>,
    /// Share of the torque on edges, whose pressure has no bound.
    pub edge_share: f64,
    /// Depth, m, and size, Pa, of the greatest shear below the place of that pressure.
    pub shear: Option<[f64; 2]>,
    /// Largest half width of the contact over the length of its cell.
    pub coarse: f64,
    /// Contacts that carry by the closed form of an ellipse.
    pub ellipses: usize,
    /// Largest long semi-axis of these over its distance from the end of the teeth.
    pub overhang: f64,
    /// Pairs of teeth with the moments in the root lines of pinion and gear; none of rigid teeth.
    pub root_moments: Vec<(i32, [RootMoment; 2])>,
    /// The cells that carry.
    pub places: Vec<LoadedPlace>,
}

/// The pitch at one torque.
#[derive(Debug, Clone, PartialEq)]
pub struct FlankCycle {
    /// Torque at the pinion, N·m.
    pub torque: f64,
    /// Position by position.
    pub positions: Vec<FlankLoad>,
}

/// Loaded contact of flanks over one pitch.
#[derive(Debug, Clone, PartialEq)]
pub struct FlankMeshResult {
    /// Angles of the pinion, rad.
    pub pinion_angles: Vec<f64>,
    /// Pitch of the pinion, rad.
    pub pitch: f64,
    /// Transmission error without load, by position, rad.
    pub unloaded_te: Vec<f64>,
    /// The pitch at each torque.
    pub cycles: Vec<FlankCycle>,
}

impl FlankLoad {
    /// Most strips that one pair of teeth carries on; none where an ellipse carries.
    pub fn longest_contact(&self) -> Option<usize> {
        let of = |pair: i32| self.places.iter().filter(|p| p.pair == pair).count();
        let longest = self.shares.iter().map(|(pair, _)| of(*pair)).max();
        longest.filter(|_| self.ellipses == 0)
    }

    /// Pairs of teeth that carry.
    pub fn carrying(&self) -> usize {
        self.shares.iter().filter(|(_, share)| *share > 0.0).count()
    }

    /// Moments in the root lines of a pair of teeth.
    pub fn root_moments(&self, pair: i32) -> Option<[RootMoment; 2]> {
        let found = self.root_moments.iter().find(|(of, _)| *of == pair);
        found.map(|(_, moments)| *moments)
    }

    /// Share of the torque on a pair of teeth.
    pub fn share(&self, pair: i32) -> f64 {
        let found = self.shares.iter().find(|(of, _)| *of == pair);
        found.map_or(0.0, |(_, share)| *share)
    }
}

impl FlankCycle {
    pub(super) fn new(torque: f64) -> FlankCycle {
        FlankCycle {
            torque,
            positions: Vec::new(),
        }
    }

    /// A quantity by position.
    pub fn of(&self, value: impl Fn(&FlankLoad) -> f64) -> Vec<f64> {
        self.positions.iter().map(value).collect()
    }

    /// Mean number of pairs of teeth that carry: the effective contact ratio.
    pub fn contact_ratio(&self) -> f64 {
        let all: usize = self.positions.iter().map(FlankLoad::carrying).sum();
        all as f64 / self.positions.len().max(1) as f64
    }

    /// Mean `[z, radius]` of the places that carry in the frame of a member, weighted with their forces; none without a place.
    pub fn centre(&self, member: usize) -> Option<[f64; 2]> {
        let places = || self.positions.iter().flat_map(|p| &p.places);
        let force: f64 = places().map(|p| p.force).sum();
        let mean = |k: usize| places().map(|p| p.force * p.at[member][k]).sum::<f64>() / force;
        (force > 0.0).then(|| [mean(0), mean(1)])
    }

    /// Share of the pinion's face and greatest line load over the positions, N/m, of every station that carries, from toe to heel.
    pub fn lengthwise(&self) -> Vec<[f64; 2]> {
        let places = self.positions.iter().flat_map(|p| &p.places);
        let mut all: Vec<[f64; 2]> = places.map(|p| [p.face, p.line_load]).collect();
        all.sort_by(|a, b| a[0].total_cmp(&b[0]).then(b[1].total_cmp(&a[1])));
        all.dedup_by(|a, b| a[0] == b[0]);
        all
    }

    /// Greatest moment in the root line of a member's tooth, whole and of a unit length; none of rigid teeth.
    pub fn root_moment(&self, member: usize) -> Option<RootMoment> {
        let moments = self.positions.iter().flat_map(|p| &p.root_moments);
        moments
            .map(|(_, of)| of[member])
            .reduce(|most, next| RootMoment {
                total: most.total.max(next.total),
                greatest: most.greatest.max(next.greatest),
            })
    }

    /// The position of the greatest pressure within the flanks.
    pub fn most_pressed(&self) -> Option<&FlankLoad> {
        let pressed = self.positions.iter().filter(|p| p.pressure.is_some());
        pressed.max_by(|a, b| {
            a.pressure
                .unwrap_or(0.0)
                .total_cmp(&b.pressure.unwrap_or(0.0))
        })
    }
}

impl FlankMeshResult {
    /// The pairs of teeth that carry at some torque and position, rising.
    pub fn pairs(&self) -> Vec<i32> {
        let loads = self.cycles.iter().flat_map(|c| &c.positions);
        let carrying = loads
            .flat_map(|p| &p.shares)
            .filter(|(_, share)| *share > 0.0);
        let mut pairs: Vec<i32> = carrying.map(|(pair, _)| *pair).collect();
        pairs.sort_unstable();
        pairs.dedup();
        pairs
    }
}
