//! A checked machine model: `M q̈ + C q̇ + K q = f` by its elements, from a file, from text or from a builder.

use std::path::Path;

use super::builder::ModelBuilder;
use super::machine::Machine;
use crate::base::error::Errors;
use crate::scene::{self, Scene};

/// A machine model, read and checked value by value. A scene file is a model with initial conditions, loads and changes of its own.
///
/// ```
/// use geardyn::Model;
///
/// let model = Model::parse(
///     r#"
///     inertia = [{ name = "motor", J = "0.02 kg·m²" }, { name = "work", J = "0.05 kg·m²" }]
///     shaft = [{ name = "shaft", between = ["motor", "work"], k = "12000 N·m/rad" }]
///     "#,
/// )?;
/// let modes = model.machine()?.modes(&Default::default())?;
/// assert!((modes[1].frequency_hz - 145.9).abs() < 0.1);
/// # Ok::<(), geardyn::Errors>(())
/// ```
#[derive(Debug, Clone)]
pub struct Model {
    scene: Scene,
}

impl Model {
    /// Reads a model or scene file (TOML; docs/reference/model-files.md lists its keys).
    ///
    /// # Errors
    /// Every error in the file, each with line, key and remedy.
    pub fn open(path: impl AsRef<Path>) -> Result<Model, Errors> {
        scene::read(path.as_ref()).map(|scene| Model { scene })
    }

    /// Reads a model from the text of a model file.
    ///
    /// # Errors
    /// As [`Model::open`].
    pub fn parse(text: &str) -> Result<Model, Errors> {
        scene::read_text("model", text).map(|scene| Model { scene })
    }

    /// Starts a model without a file.
    pub fn builder() -> ModelBuilder {
        ModelBuilder::default()
    }

    /// The title of the model, empty where it has none.
    pub fn title(&self) -> &str {
        &self.scene.model.title
    }

    /// Assembles the machine and linearises it at its operating point.
    ///
    /// # Errors
    /// Unknown nodes, contradicting ratios, unconnected parts, missing masses.
    pub fn machine(&self) -> Result<Machine, Errors> {
        Machine::new(self.scene.clone())
    }
}

impl ModelBuilder {
    /// Checks the model.
    ///
    /// # Errors
    /// As [`Model::parse`]; lines are those of [`ModelBuilder::text`].
    pub fn build(&self) -> Result<Model, Errors> {
        Model::parse(self.text())
    }
}
