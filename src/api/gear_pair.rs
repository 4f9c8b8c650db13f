//! A pair of cylindrical gears: limits, geometry, transmission error and stiffness under load.

use std::path::Path;
use std::sync::Arc;

use crate::base::error::{Diagnostic, Errors};
use crate::base::flags::Flags;
use crate::base::load;
use crate::base::source_span::SourceFile;
use crate::gear::load::mesh_result::LoadedCycle;
use crate::plan::gear::run::{self, GearResult};
use crate::scene::gear_file::{self, GearFile};
use crate::scene::mesh_table::MeshStudy;

/// A pair of cylindrical gears, read from a gear file and checked.
///
/// ```
/// use geardyn::{GearPair, MeshStudy};
///
/// let pair = GearPair::open("models/gears/fzg_c.toml")?;
/// assert!((pair.contact_ratio() - 1.4375).abs() < 1e-4);
/// let mesh = pair.mesh(&MeshStudy { torques: vec![100.0, 300.0], ..pair.study().clone() })?;
/// assert!(mesh.cycles[1].peak_to_peak() > mesh.cycles[0].peak_to_peak());
/// # Ok::<(), geardyn::Errors>(())
/// ```
#[derive(Debug, Clone)]
pub struct GearPair {
    file: GearFile,
    unloaded: GearResult,
}

/// Loaded transmission error and stiffness over one pitch.
#[derive(Debug, Clone, PartialEq)]
pub struct GearMesh {
    /// Pinion angles, rad; 0 where a pair touches at the pitch point.
    pub pinion_angles: Vec<f64>,
    /// Transmission error without load along the line of action, by position, m.
    pub unloaded_te: Vec<f64>,
    /// The pitch at each torque.
    pub cycles: Vec<LoadedCycle>,
    /// Base radius of the driven gear, m: transmission error over it is its angle.
    pub driven_base_radius: f64,
    /// Warnings on the gears and the ranges of the method.
    pub diagnostics: Vec<Diagnostic>,
}

impl GearPair {
    /// Reads a gear file of cylindrical gears (TOML; docs/reference/gear-files.md lists its keys).
    ///
    /// # Errors
    /// Every error in the file, each with line, key and remedy; gears that cannot be made or cannot mesh.
    pub fn open(path: impl AsRef<Path>) -> Result<GearPair, Errors> {
        GearPair::read(load::load(path.as_ref())?)
    }

    /// Reads a pair from the text of a gear file.
    ///
    /// # Errors
    /// As [`GearPair::open`].
    pub fn parse(text: &str) -> Result<GearPair, Errors> {
        GearPair::read(load::source_from_text("gears".into(), text))
    }

    fn read(source: Arc<SourceFile>) -> Result<GearPair, Errors> {
        let file = gear_file::read(&source, &Flags::default())?;
        let mut plain = file.clone();
        plain.mesh.torques.clear();
        let unloaded = run::run(&plain)?;
        Ok(GearPair { file, unloaded })
    }

    /// The title of the file, empty where it has none.
    pub fn title(&self) -> &str {
        &self.file.title
    }

    /// Transverse contact ratio ε_α.
    pub fn contact_ratio(&self) -> f64 {
        self.unloaded.pair.contact_ratios().transverse
    }

    /// Base radii of pinion and gear, m.
    pub fn base_radii(&self) -> [f64; 2] {
        let radius = |k: usize| 0.5 * self.unloaded.pair.members[k].gear.base_diameter();
        [radius(0), radius(1)]
    }

    /// Centre distance, m.
    pub fn centre_distance(&self) -> f64 {
        self.unloaded.pair.centre_distance
    }

    /// Limits that the pair meets, each with the nearest value that avoids it.
    pub fn diagnostics(&self) -> &[Diagnostic] {
        &self.unloaded.diagnostics
    }

    /// Load and grid of the file: torques of `[mesh]`, 60 positions and 40 slices for each axial pitch by default.
    pub fn study(&self) -> &MeshStudy {
        &self.file.mesh
    }

    /// Shares the load between the teeth over one pitch.
    ///
    /// # Errors
    /// No torque; a torque that is not positive; gears that do not touch.
    pub fn mesh(&self, study: &MeshStudy) -> Result<GearMesh, Errors> {
        let mut file = self.file.clone();
        file.mesh = study.clone();
        let result = run::run(&file)?;
        let mesh = result.mesh.ok_or_else(|| file.missing_torque_error())?;
        Ok(GearMesh {
            pinion_angles: mesh.pinion_angles,
            unloaded_te: mesh.unloaded_te,
            cycles: mesh.cycles,
            driven_base_radius: mesh.driven_base_radius,
            diagnostics: result.diagnostics,
        })
    }
}
