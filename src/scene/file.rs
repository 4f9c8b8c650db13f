//! Reads a model or scene file into a checked `Scene`.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::initial_conditions::{self, InitialConditions};
use super::model::{Brake, DeclaredError, GeneratorWork, Load, Model, Motor};
use super::study::Study;
use super::{
    bodies, consistency, declared_errors, gears, generator_work, loads_and_motors, overrides,
    planetary, screws, shafts, study, supports,
};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::error_collector::ErrorCollector;
use crate::base::load;
use crate::base::source_span::{SourceFile, SourceSpan};
use crate::base::table_reader::TableReader;
use crate::base::tables::{read_table, read_tables};
use crate::base::toml::{self, Document};

/// Model with the requested studies; a model file alone gives a scene without studies.
#[derive(Debug, Clone)]
pub struct Scene {
    /// Model of the machine, with the changes of the scene.
    pub model: Model,
    /// Path of the model file.
    pub model_path: PathBuf,
    /// Initial conditions of the motion.
    pub start: InitialConditions,
    /// Requested studies, in the order of the file.
    pub studies: Vec<Study>,
    /// Files read, the file passed to [`read`] first; a hash of the input covers their texts.
    pub sources: Vec<Arc<SourceFile>>,
    /// Paths of the files that state bare numbers in SI.
    pub(super) bare_si: Vec<String>,
}

impl Scene {
    /// Paths of the files read.
    pub fn files(&self) -> Vec<PathBuf> {
        let path = |source: &Arc<SourceFile>| PathBuf::from(&source.path);
        self.sources.iter().map(path).collect()
    }
}

/// Reads a model file, or a scene file and the model it names.
pub fn read(path: &Path) -> Result<Scene, Errors> {
    read_source(load::load(path)?)
}

/// Reads the text of a model or a scene as the content of the file `path`.
pub fn read_text(path: &str, text: &str) -> Result<Scene, Errors> {
    read_source(load::source_from_text(path.to_string(), text))
}

/// Top-level keys that only a scene file has.
const SCENE_KEYS: [&str; 4] = ["study", "start", "set", "model_loads"];

fn read_source(source: Arc<SourceFile>) -> Result<Scene, Errors> {
    let document = toml::parse(&source);
    let mut errors = ErrorCollector::default();
    errors.record_units(&document);
    if document.root.get("model").is_some() {
        return read_scene(document, errors);
    }
    if let Some(entry) = document.root.get("measured_gear") {
        let message = "this file describes a measured gear, not a machine";
        let error = Error::new(Code::Usage, message).with_span(&entry.key_span);
        let gear = document.root.table("measured_gear").map(|(gear, _)| gear);
        let is_unknown =
            gear.is_some_and(|gear| gear.get("spans").is_some() && gear.get("module").is_none());
        let path = &source.path;
        let hint = match is_unknown {
            true => format!("`geardyn gear reverse {path}` finds the possible gears"),
            false => format!("`geardyn measure {path}` evaluates it"),
        };
        return Err(error.with_hint(hint).into());
    }
    if let Some(entry) = document.root.get("pair") {
        let message = "this file describes gears, not a machine";
        let error = Error::new(Code::Usage, message).with_span(&entry.key_span);
        return Err(error
            .with_hint(format!("`geardyn gear {}` computes them", source.path))
            .into());
    }
    let has_key = |key: &&str| document.root.get(key).is_some();
    if let (Some(key), None) = (SCENE_KEYS.into_iter().find(has_key), &document.syntax_error) {
        let span = SourceSpan::new(source.clone(), 0..0);
        let error = Error::new(
            Code::MissingKey,
            format!("`{key}` belongs to a scene, and a scene must name its model"),
        );
        return Err(error
            .with_span(&span)
            .with_hint("write model = \"path of the model\" at the top")
            .into());
    }
    let model = read_model(&document, SceneAdditions::default(), &mut errors);
    let bare_si = errors.bare_si.clone();
    finish(errors, document.syntax_error, || Scene {
        sources: [source.clone()]
            .into_iter()
            .chain(model.gear_files())
            .collect(),
        model,
        bare_si,
        model_path: PathBuf::from(&source.path),
        start: InitialConditions::default(),
        studies: Vec::new(),
    })
}

/// Returns the value, or all errors. Nothing is read after a syntax error, so reports of missing items are dropped there.
fn finish<T>(
    mut errors: ErrorCollector,
    syntax_error: Option<Error>,
    value: impl FnOnce() -> T,
) -> Result<T, Errors> {
    if let Some(syntax_error) = syntax_error {
        errors.errors.retain(|error| {
            !matches!(
                error.code,
                Code::MissingKey | Code::UnknownNode | Code::EmptyMachine
            )
        });
        errors.push(syntax_error);
    }
    Errors::into_result(errors.errors, value)
}

fn read_scene(document: Document, mut errors: ErrorCollector) -> Result<Scene, Errors> {
    let span = SourceSpan::new(document.source.clone(), 0..0);
    let mut f = TableReader::new(&document.root, span, "the scene", &mut errors);
    let (title, _) = heading(&mut f);
    let name = f.optional_text("model");
    let additions = SceneAdditions {
        loads: read_tables(&mut f, "load", loads_and_motors::load),
        motors: read_tables(&mut f, "motor", loads_and_motors::motor),
        brakes: brakes(&mut f),
        errors: read_tables(&mut f, "error", declared_errors::read_declared_error),
        work: read_table(&mut f, "work", generator_work::read).flatten(),
        without_model_loads: f.choice("model_loads", &[("kept", false), ("left out", true)])
            == Some(true),
    };
    let start = read_table(&mut f, "start", initial_conditions::read).unwrap_or_default();
    let studies = read_tables(&mut f, "study", study::read);
    f.item("set", "a table of \"element.key\" = value");
    let model_span = f.span_of("model").clone();
    f.finish();
    let is_complete = document.syntax_error.is_none();
    let named_model = name
        .filter(|_| is_complete)
        .and_then(|name| load_model(&document, name, &model_span, additions, &mut errors));
    // Without a model an error is already reported, and `finish` returns it.
    let (mut model, model_path, source, syntax_error) = match named_model {
        Some((model, path, file)) => (model, path, file.source, file.syntax_error),
        None => (
            Model::default(),
            PathBuf::new(),
            document.source.clone(),
            document.syntax_error,
        ),
    };
    if !title.is_empty() {
        model.title = title;
    }
    let bare_si = errors.bare_si.clone();
    finish(errors, syntax_error, || Scene {
        sources: [document.source.clone(), source]
            .into_iter()
            .chain(model.gear_files())
            .collect(),
        model,
        bare_si,
        model_path,
        start,
        studies: studies.into_iter().flatten().collect(),
    })
}

/// Reads the model that a scene names and applies the changes of the scene.
fn load_model(
    scene: &Document,
    name: &str,
    span: &SourceSpan,
    additions: SceneAdditions,
    errors: &mut ErrorCollector,
) -> Option<(Model, PathBuf, Document)> {
    let folder = Path::new(&scene.source.path).parent();
    let path = folder.unwrap_or(Path::new("")).join(name);
    let source = match load::load(&path) {
        Ok(source) => source,
        Err(error) if error.code == Code::NotText => {
            errors.push(error);
            return None;
        }
        Err(error) => {
            let error = error.with_span(span).with_label("in the scene");
            errors.push(error.with_hint("the path is relative to the scene's folder"));
            return None;
        }
    };
    let mut file = toml::parse(&source);
    errors.record_units(&file);
    if file.root.get("model").is_some() {
        let error = Error::new(Code::Conflict, "the model is itself a scene");
        errors.push(
            error
                .with_span(span)
                .with_hint("name the model file of that scene"),
        );
        return None;
    }
    if let (Some(set), None) = (scene.root.get("set"), &file.syntax_error) {
        overrides::apply(set, &mut file.root, errors);
    }
    let model = read_model(&file, additions, errors);
    Some((model, path, file))
}

/// Reads `units`, `title` and `source`, which models and scenes share.
fn heading(f: &mut TableReader) -> (String, String) {
    f.choice("units", &[("SI", ())]);
    let mut text = |key| f.optional_text(key).unwrap_or_default().to_string();
    (text("title"), text("source"))
}

/// Additions of a scene to a machine.
#[derive(Default)]
struct SceneAdditions {
    loads: Vec<Load>,
    motors: Vec<Motor>,
    brakes: Vec<Brake>,
    errors: Vec<DeclaredError>,
    work: Option<Arc<GeneratorWork>>,
    /// True if the loads of the model file are omitted.
    without_model_loads: bool,
}

/// Reads brakes, then clutches, which share one friction model.
fn brakes(f: &mut TableReader) -> Vec<Brake> {
    let mut brakes = read_tables(f, "brake", loads_and_motors::brake);
    brakes.extend(read_tables(f, "clutch", loads_and_motors::clutch));
    brakes
}

/// Reads the tables of a model file and appends the additions of the scene.
fn read_model(file: &Document, additions: SceneAdditions, errors: &mut ErrorCollector) -> Model {
    let span = SourceSpan::new(file.source.clone(), 0..0);
    let mut f = TableReader::new(&file.root, span.clone(), "the model", errors);
    let (title, source) = heading(&mut f);
    let mut model = Model {
        title,
        source,
        inertias: read_tables(&mut f, "inertia", bodies::read_inertia),
        shafts: read_tables(&mut f, "shaft", shafts::shaft),
        chains: read_tables(&mut f, "chain", bodies::read_disc_chain),
        gear_pairs: read_tables(&mut f, "gear_pair", gears::gear_pair),
        worm_pairs: read_tables(&mut f, "worm_pair", gears::worm_pair),
        planetaries: read_tables(&mut f, "planetary", planetary::planetary),
        belts: read_tables(&mut f, "belt", gears::belt),
        slides: read_tables(&mut f, "slide", screws::slide),
        screws: read_tables(&mut f, "screw", screws::screw),
        couplings: read_tables(&mut f, "coupling", shafts::coupling),
        bearings: read_tables(&mut f, "bearing", supports::bearing),
        dampers: read_tables(&mut f, "damper", supports::damper),
        loads: read_tables(&mut f, "load", loads_and_motors::load),
        motors: read_tables(&mut f, "motor", loads_and_motors::motor),
        brakes: brakes(&mut f),
        errors: read_tables(&mut f, "error", declared_errors::read_declared_error),
        damping: read_table(&mut f, "damping", supports::damping).unwrap_or_default(),
        speeds: read_table(&mut f, "speed", supports::speeds).unwrap_or_default(),
        work: read_table(&mut f, "work", generator_work::read).flatten(),
    };
    if additions.without_model_loads {
        model.loads.clear();
    }
    model.loads.extend(additions.loads);
    model.motors.extend(additions.motors);
    model.brakes.extend(additions.brakes);
    model.errors.extend(additions.errors);
    model.work = additions.work.or(model.work);
    let is_empty = !["inertia", "chain", "planetary"]
        .iter()
        .any(|key| f.has(key));
    f.finish();
    // A misspelt [[inertia]] is already reported.
    if is_empty && errors.errors.is_empty() {
        let message = match file.source.text.trim().is_empty() {
            true => "the file is empty",
            false => "the model has no [[inertia]], so nothing can move",
        };
        let error = Error::new(Code::EmptyMachine, message).with_span(&span);
        errors.push(error.with_hint("`geardyn new FILE` writes a model to start from"));
    }
    consistency::check(&model, errors);
    model
}
