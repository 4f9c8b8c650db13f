//! Results of loaded flank contact over one pitch: transmission error, stiffness, load sharing, pressure and loaded cells.

use std::collections::BTreeMap;

use super::tooth_plate::RootMoment;

/// Change of the set of loaded strips as the torque increases.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StripChange {
    /// Torque at the pinion, N·m.
    pub torque: f64,
    /// Number of the tooth pair.
    pub pair: i32,
    /// Position along the face of the pinion, 0 at the toe to 1 at the heel.
    pub face: f64,
    /// True if the strip becomes loaded, false if it becomes unloaded.
    pub begins: bool,
}

impl StripChange {
    /// Lowest torque, N·m, at which `pairs` tooth pairs are loaded on a path from zero; `None` if never or from the start.
    pub fn onset_torque(path: &[StripChange], pairs: usize) -> Option<f64> {
        let mut strips: BTreeMap<i32, i64> = BTreeMap::new();
        let first = path.iter().find(|change| {
            *strips.entry(change.pair).or_default() += if change.begins { 1 } else { -1 };
            strips.values().filter(|n| **n > 0).count() == pairs
        });
        first.map(|change| change.torque)
    }
}

/// Loaded cell of a contact line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadedCell {
    /// Number of the tooth pair.
    pub pair: i32,
    /// Position `[z, radius]` in the frames of pinion and gear, m.
    pub at: [[f64; 2]; 2],
    /// Position along the face of the pinion, 0 at the toe to 1 at the heel.
    pub face: f64,
    /// Normal force, N.
    pub force: f64,
    /// Force per unit length, N/m: half width times pressure times π/2, for an ellipse the maximum.
    pub line_load: f64,
    /// Maximum pressure, Pa.
    pub pressure: f64,
    /// Half width of the contact, m.
    pub width: f64,
    /// True for a cell on an edge.
    pub on_edge: bool,
}

/// Loaded flank contact at one position under one torque.
#[derive(Debug, Clone, PartialEq)]
pub struct FlankLoad {
    /// Transmission error, rad at the gear, positive for a leading gear.
    pub te: f64,
    /// Secant stiffness T/Δ from zero load, N·m/rad at the gear.
    pub secant: f64,
    /// Tangent stiffness dT/dΔ, N·m/rad at the gear.
    pub tangent: f64,
    /// Tooth pairs in the range of contact, each with its share of the torque.
    pub shares: Vec<(i32, f64)>,
    /// Maximum pressure within the flanks, away from loaded edges, Pa; `None` without a loaded cell there.
    pub pressure: Option<f64>,
    /// Share of the torque on edges, where the pressure is singular.
    pub edge_share: f64,
    /// Depth, m, and value, Pa, of the maximum shear stress below the cell of maximum pressure.
    pub shear: Option<[f64; 2]>,
    /// Maximum ratio of contact half width to cell length.
    pub cell_width_ratio: f64,
    /// Number of contacts computed by the closed form of an ellipse.
    pub ellipses: usize,
    /// Maximum ratio of the major semi-axis of these to its distance from the end of the teeth.
    pub overhang: f64,
    /// Tooth pairs with the moments in the root lines of pinion and gear; empty for rigid teeth.
    pub root_moments: Vec<(i32, [RootMoment; 2])>,
    /// Loaded cells.
    pub places: Vec<LoadedCell>,
}

/// Loaded flank contact over one pitch at one torque.
#[derive(Debug, Clone, PartialEq)]
pub struct FlankCycle {
    /// Torque at the pinion, N·m.
    pub torque: f64,
    /// Results by position.
    pub positions: Vec<FlankLoad>,
}

/// Loaded flank contact over one pitch at several torques.
#[derive(Debug, Clone, PartialEq)]
pub struct FlankMeshResult {
    /// Angles of the pinion by position, rad.
    pub pinion_angles: Vec<f64>,
    /// Angular pitch of the pinion, rad.
    pub pitch: f64,
    /// Transmission error without load, by position, rad.
    pub unloaded_te: Vec<f64>,
    /// Results by torque.
    pub cycles: Vec<FlankCycle>,
}

impl FlankLoad {
    /// Maximum number of loaded strips of a tooth pair; `None` with a contact ellipse.
    pub fn longest_contact(&self) -> Option<usize> {
        let strips = |pair: i32| self.places.iter().filter(|p| p.pair == pair).count();
        let longest = self.shares.iter().map(|(pair, _)| strips(*pair)).max();
        longest.filter(|_| self.ellipses == 0)
    }

    /// Number of loaded tooth pairs.
    pub fn loaded_pairs(&self) -> usize {
        self.shares.iter().filter(|(_, share)| *share > 0.0).count()
    }

    /// Moments in the root lines of a tooth pair; `None` for rigid teeth.
    pub fn root_moments(&self, pair: i32) -> Option<[RootMoment; 2]> {
        let entry = self.root_moments.iter().find(|(number, _)| *number == pair);
        entry.map(|(_, moments)| *moments)
    }

    /// Share of the torque on a tooth pair.
    pub fn share(&self, pair: i32) -> f64 {
        let entry = self.shares.iter().find(|(number, _)| *number == pair);
        entry.map_or(0.0, |(_, share)| *share)
    }
}

impl FlankCycle {
    pub(super) fn new(torque: f64) -> FlankCycle {
        FlankCycle {
            torque,
            positions: Vec::new(),
        }
    }

    /// Values of a quantity by position.
    pub fn of(&self, value: impl Fn(&FlankLoad) -> f64) -> Vec<f64> {
        self.positions.iter().map(value).collect()
    }

    /// Effective contact ratio: mean number of loaded tooth pairs.
    pub fn contact_ratio(&self) -> f64 {
        let total: usize = self.positions.iter().map(FlankLoad::loaded_pairs).sum();
        total as f64 / self.positions.len().max(1) as f64
    }

    /// Force-weighted mean `[z, radius]` of the loaded cells in the frame of a member, m; `None` without a loaded cell.
    pub fn centre(&self, member: usize) -> Option<[f64; 2]> {
        let places = || self.positions.iter().flat_map(|p| &p.places);
        let force: f64 = places().map(|p| p.force).sum();
        let mean = |k: usize| places().map(|p| p.force * p.at[member][k]).sum::<f64>() / force;
        (force > 0.0).then(|| [mean(0), mean(1)])
    }

    /// Position along the face and maximum line load over all positions, N/m, of every loaded station, from toe to heel.
    pub fn lengthwise(&self) -> Vec<[f64; 2]> {
        let places = self.positions.iter().flat_map(|p| &p.places);
        let mut stations: Vec<[f64; 2]> = places.map(|p| [p.face, p.line_load]).collect();
        stations.sort_by(|a, b| a[0].total_cmp(&b[0]).then(b[1].total_cmp(&a[1])));
        stations.dedup_by(|a, b| a[0] == b[0]);
        stations
    }

    /// Maxima over the positions of total moment and moment per unit length in the root line of a member; `None` for rigid teeth.
    pub fn root_moment(&self, member: usize) -> Option<RootMoment> {
        let moments = self.positions.iter().flat_map(|p| &p.root_moments);
        moments
            .map(|(_, of_members)| of_members[member])
            .reduce(|max, moment| RootMoment {
                total: max.total.max(moment.total),
                greatest: max.greatest.max(moment.greatest),
            })
    }

    /// Results at the position of maximum pressure within the flanks.
    pub fn max_pressure_position(&self) -> Option<&FlankLoad> {
        let candidates = self.positions.iter().filter(|p| p.pressure.is_some());
        candidates.max_by(|a, b| {
            a.pressure
                .unwrap_or(0.0)
                .total_cmp(&b.pressure.unwrap_or(0.0))
        })
    }
}

impl FlankMeshResult {
    /// Numbers of the tooth pairs loaded at any torque and position, ascending.
    pub fn pairs(&self) -> Vec<i32> {
        let loads = self.cycles.iter().flat_map(|c| &c.positions);
        let loaded = loads
            .flat_map(|p| &p.shares)
            .filter(|(_, share)| *share > 0.0);
        let mut pairs: Vec<i32> = loaded.map(|(pair, _)| *pair).collect();
        pairs.sort_unstable();
        pairs.dedup();
        pairs
    }
}
