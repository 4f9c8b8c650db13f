//! A model built element by element. The builder writes the text of a model file, so that one reader checks every model.

use std::fmt::Write as _;

/// Builds a [`Model`](crate::Model) without a file; quantities are in SI units. Elements between two nodes are called `shaft_1`, `gear_pair_2` and so
/// on, by their kind and their place among such elements.
///
/// ```
/// use geardyn::Model;
///
/// let machine = Model::builder()
///     .inertia("motor", 0.02)
///     .inertia("work", 0.05)
///     .shaft("motor", "work", 1.2e4)
///     .build()?
///     .machine()?;
/// assert_eq!(machine.dofs(), ["motor.theta", "work.theta"]);
/// # Ok::<(), geardyn::Errors>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct ModelBuilder {
    text: String,
    elements: usize,
}

impl ModelBuilder {
    /// Adds a body that turns: its name is a node; moment of inertia, kg·m².
    #[must_use]
    pub fn inertia(self, name: &str, inertia: f64) -> ModelBuilder {
        self.element(
            "inertia",
            &[("name", text(name)), ("J", quantity(inertia, "kg·m²"))],
        )
    }

    /// Adds a massless shaft between two nodes; torsional stiffness, N·m/rad.
    #[must_use]
    pub fn shaft(self, from: &str, to: &str, stiffness: f64) -> ModelBuilder {
        let k = quantity(stiffness, "N·m/rad");
        self.between("shaft", [from, to], &[("k", k)])
    }

    /// Adds a rotational damper between two nodes; viscous coefficient, N·m·s/rad.
    #[must_use]
    pub fn damper(self, from: &str, to: &str, coefficient: f64) -> ModelBuilder {
        let c = quantity(coefficient, "N·m·s/rad");
        self.between("damper", [from, to], &[("c", c)])
    }

    /// Adds a spur gear pair between two nodes: numbers of teeth, module in m, mesh stiffness along the line of action in N/m.
    #[must_use]
    pub fn gear_pair(
        self,
        between: [&str; 2],
        teeth: [u32; 2],
        module: f64,
        stiffness: f64,
    ) -> ModelBuilder {
        let [first, second] = teeth;
        let keys = [
            ("teeth", format!("[{first}, {second}]")),
            ("module", quantity(module, "m")),
            ("k", quantity(stiffness, "N/m")),
        ];
        self.between("gear_pair", between, &keys)
    }

    /// Adds an element between two nodes, named by its kind and its number among the elements: `shaft_3`.
    fn between(mut self, table: &str, nodes: [&str; 2], keys: &[(&str, String)]) -> ModelBuilder {
        self.elements += 1;
        let name = format!("{table}_{}", self.elements);
        let ends = [("name", text(&name)), ("between", texts(&nodes))];
        self.element(table, &[&ends, keys].concat())
    }

    /// Adds any element of a model file: its table, and its keys with their values as the file writes them (`"\"a text\""`, `"[1, 2]"`).
    #[must_use]
    pub fn element(mut self, table: &str, keys: &[(&str, String)]) -> ModelBuilder {
        let _ = writeln!(self.text, "[[{table}]]");
        for (key, value) in keys {
            let _ = writeln!(self.text, "{key} = {value}");
        }
        self
    }

    /// The model as the text of a model file.
    pub fn text(&self) -> &str {
        &self.text
    }
}

/// A number with its unit as a model file writes it; every digit is kept.
fn quantity(value: f64, unit: &str) -> String {
    format!("\"{value:e} {unit}\"")
}

/// A text as a model file writes it.
fn text(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

fn texts(list: &[&str]) -> String {
    let list: Vec<String> = list.iter().map(|entry| text(entry)).collect();
    format!("[{}]", list.join(", "))
}
