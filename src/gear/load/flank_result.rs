//! Loaded contact of flanks over one pitch: transmission error, stiffness, shares, pressure and places by torque and position.

/// A cell that carries.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadedPlace {
    /// The pair of teeth.
    pub pair: i32,
    /// `[z, radius]` in the frames of pinion and gear, m.
    pub at: [[f64; 2]; 2],
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
    /// Greatest pressure within the flanks, Pa; none where edges carry all.
    pub pressure: Option<f64>,
    /// Share of the torque on edges, whose pressure has no bound.
    pub edge_share: f64,
    /// Depth, m, and size, Pa, of the greatest shear below the place of that pressure.
    pub shear: Option<[f64; 2]>,
    /// Largest half width of the contact over the length of its cell.
    pub coarse: f64,
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
    /// Most cells that one pair of teeth carries on.
    pub fn longest_contact(&self) -> usize {
        let of = |pair: i32| self.places.iter().filter(|p| p.pair == pair).count();
        self.shares
            .iter()
            .map(|(pair, _)| of(*pair))
            .max()
            .unwrap_or(0)
    }

    /// Pairs of teeth that carry.
    pub fn carrying(&self) -> usize {
        self.shares.iter().filter(|(_, share)| *share > 0.0).count()
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
