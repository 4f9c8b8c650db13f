//! What the tests of whole machines share: from text to an answer, random machines, comparisons.
#![allow(dead_code, reason = "each test file uses its part")]

use std::path::Path;

use geardyn::internals::plan::modes_run::{ModesResult, run};
use geardyn::internals::plan::prepared_machine::PreparedMachine;
use geardyn::internals::plan::stages::ModesPlan;
use geardyn::internals::scene;
use geardyn::internals::scene::model::Model;
use geardyn::internals::scene::study::ModesStudy;
use serde_json::Value;

/// The command as a test calls it.
#[cfg(feature = "cli")]
pub mod command;

/// Machines from a seed.
pub mod machines;

/// Machines in motion, written by hand.
pub mod moving;

/// Normal random numbers.
pub mod noise;

/// Arrays in NumPy's format.
pub mod npy;

/// Figures of the verification manual.
pub mod verification;

#[allow(unused_imports, reason = "each test file uses its part")]
pub use verification::within;

/// A machine with what was asked of it.
pub struct Solved {
    pub prepared: PreparedMachine,
    pub plan: ModesPlan,
    pub answer: ModesResult,
}

impl Solved {
    pub fn omega(&self) -> Vec<f64> {
        self.answer.modes.iter().map(|mode| mode.omega()).collect()
    }

    pub fn hertz(&self) -> Vec<f64> {
        self.answer
            .modes
            .iter()
            .map(|mode| mode.frequency_hz())
            .collect()
    }

    pub fn n_rigid(&self) -> usize {
        self.answer.modes.iter().filter(|mode| mode.rigid).count()
    }
}

/// Nothing but undamped modes.
pub fn plain() -> ModesStudy {
    ModesStudy::default()
}

pub fn damped() -> ModesStudy {
    ModesStudy {
        damped: true,
        ..plain()
    }
}

pub fn lowest(count: u32) -> ModesStudy {
    ModesStudy {
        lowest: Some(count),
        ..plain()
    }
}

/// The model of a text; a scene's text names models from the folder `models`.
pub fn model(text: &str) -> Model {
    match scene::read_text("models/test.toml", text) {
        Ok(scene) => scene.model,
        Err(errors) => panic!("{errors}\n{text}"),
    }
}

pub fn solve(text: &str, study: &ModesStudy) -> Solved {
    solve_model(&model(text), study).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

pub fn solve_file(name: &str, study: &ModesStudy) -> Solved {
    let scene = scene::read(Path::new(&format!("models/{name}.toml")))
        .unwrap_or_else(|errors| panic!("{errors}"));
    solve_model(&scene.model, study).unwrap_or_else(|error| panic!("{name}: {error}"))
}

pub fn solve_model(
    model: &Model,
    study: &ModesStudy,
) -> Result<Solved, geardyn::internals::base::error::Error> {
    let machine = PreparedMachine::new(model)?;
    let plan = ModesPlan::plan_modes(&machine, study);
    let result = run(&machine, study, &plan)?;
    Ok(Solved {
        prepared: machine,
        plan,
        answer: result,
    })
}

/// A file of `data/reference`.
pub fn reference(name: &str) -> Value {
    let text = std::fs::read_to_string(format!("data/reference/{name}.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

pub fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value}"))
}

pub fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(number).collect()
}

/// The largest relative error; zeros of the reference must be exact, and no value may be missing.
pub fn worst(found: &[f64], exact: &[f64]) -> f64 {
    assert_eq!(found.len(), exact.len(), "{found:?}\n{exact:?}");
    let error = |(f, e): (&f64, &f64)| {
        if *e == 0.0 {
            if *f == 0.0 { 0.0 } else { f64::INFINITY }
        } else {
            (f / e - 1.0).abs()
        }
    };
    found.iter().zip(exact).map(error).fold(0.0, f64::max)
}
