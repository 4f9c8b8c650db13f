//! A model or scene file from the first byte to a checked `Scene`.

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

/// A model with what a scene asks of it; a model file alone is a scene without studies.
#[derive(Debug, Clone)]
pub struct Scene {
    /// The machine, with the scene's changes made.
    pub model: Model,
    /// The model file.
    pub model_path: PathBuf,
    /// Initial conditions of the motion.
    pub start: InitialConditions,
    /// Requested studies, in their order.
    pub studies: Vec<Study>,
    /// Every file read, the one named first at the front; their texts are what a hash of the input covers.
    pub sources: Vec<Arc<SourceFile>>,
    /// Paths of the files that state bare numbers in SI.
    pub(super) bare_si: Vec<String>,
}

impl Scene {
    /// Path of each of these files.
    pub fn files(&self) -> Vec<PathBuf> {
        let path = |source: &Arc<SourceFile>| PathBuf::from(&source.path);
        self.sources.iter().map(path).collect()
    }
}

/// Reads a model or a scene, and the model the scene names.
pub fn read(path: &Path) -> Result<Scene, Errors> {
    read_source(load::load(path)?)
}

/// Reads the text of a model or a scene as if it stood in the file `path`.
pub fn read_text(path: &str, text: &str) -> Result<Scene, Errors> {
    read_source(load::source_from_text(path.to_string(), text))
}

/// Tables a model file does not have.
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
        let error = Error::new(Code::Usage, message).with_span(&entry.key_place);
        let gear = document.root.table("measured_gear").map(|(gear, _)| gear);
        let is_unknown =
            gear.is_some_and(|gear| gear.get("spans").is_some() && gear.get("module").is_none());
        let path = &source.path;
        let hint = match is_unknown {
            true => format!("`geardyn gear reverse {path}` finds the gears it may be"),
            false => format!("`geardyn measure {path}` evaluates it"),
        };
        return Err(error.with_hint(hint).into());
    }
    if let Some(entry) = document.root.get("pair") {
        let message = "this file describes gears, not a machine";
        let error = Error::new(Code::Usage, message).with_span(&entry.key_place);
        return Err(error
            .with_hint(format!("`geardyn gear {}` computes them", source.path))
            .into());
    }
    let belongs = |key: &&str| document.root.get(key).is_some();
    if let (Some(key), None) = (SCENE_KEYS.into_iter().find(belongs), &document.syntax_error) {
        let span = SourceSpan::new(source.clone(), 0..0);
        let error = Error::new(
            Code::MissingKey,
            format!("`{key}` belongs to a scene, and a scene names its model"),
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

/// All errors, or the value. Behind a syntax error nothing was read, so what seems to be missing may stand there.
fn finish<T>(
    mut errors: ErrorCollector,
    broken: Option<Error>,
    value: impl FnOnce() -> T,
) -> Result<T, Errors> {
    if let Some(broken) = broken {
        errors.errors.retain(|error| {
            !matches!(
                error.code,
                Code::MissingKey | Code::UnknownNode | Code::EmptyMachine
            )
        });
        errors.push(broken);
    }
    Errors::into_result(errors.errors, value)
}

fn read_scene(document: Document, mut notes: ErrorCollector) -> Result<Scene, Errors> {
    let span = SourceSpan::new(document.source.clone(), 0..0);
    let mut f = TableReader::new(&document.root, span, "the scene", &mut notes);
    let (title, _) = heading(&mut f);
    let named = f.optional_text("model");
    let added = SceneAdditions {
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
    let at = f.span_of("model").clone();
    f.finish();
    let whole = document.syntax_error.is_none();
    let found = named
        .filter(|_| whole)
        .and_then(|named| model_of(&document, named, &at, added, &mut notes));
    // Without a model an error has been noted, and the scene below is not made.
    let (mut model, model_path, source, broken) = match found {
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
    let bare_si = notes.bare_si.clone();
    finish(notes, broken, || Scene {
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

/// The model a scene names, changed as the scene says.
fn model_of(
    scene: &Document,
    named: &str,
    at: &SourceSpan,
    added: SceneAdditions,
    errors: &mut ErrorCollector,
) -> Option<(Model, PathBuf, Document)> {
    let folder = Path::new(&scene.source.path).parent();
    let path = folder.unwrap_or(Path::new("")).join(named);
    let source = match load::load(&path) {
        Ok(source) => source,
        Err(error) if error.code == Code::NotText => {
            errors.push(error);
            return None;
        }
        Err(error) => {
            let error = error.with_span(at).with_label("in the scene");
            errors.push(error.with_hint("the path starts from the scene's folder"));
            return None;
        }
    };
    let mut file = toml::parse(&source);
    errors.record_units(&file);
    if file.root.get("model").is_some() {
        let error = Error::new(Code::Conflict, "the model is itself a scene");
        errors.push(
            error
                .with_span(at)
                .with_hint("name the model file of that scene"),
        );
        return None;
    }
    if let (Some(set), None) = (scene.root.get("set"), &file.syntax_error) {
        overrides::apply(set, &mut file.root, errors);
    }
    let model = read_model(&file, added, errors);
    Some((model, path, file))
}

/// Keys both kinds of file have at their top.
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
    /// The model's own loads are left out.
    without_model_loads: bool,
}

/// Brakes, then clutches: friction of one kind.
fn brakes(f: &mut TableReader) -> Vec<Brake> {
    let mut all = read_tables(f, "brake", loads_and_motors::brake);
    all.extend(read_tables(f, "clutch", loads_and_motors::clutch));
    all
}

/// The tables of a model file; what a scene adds comes after its own.
fn read_model(file: &Document, added: SceneAdditions, notes: &mut ErrorCollector) -> Model {
    let span = SourceSpan::new(file.source.clone(), 0..0);
    let mut f = TableReader::new(&file.root, span.clone(), "the model", notes);
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
    if added.without_model_loads {
        model.loads.clear();
    }
    model.loads.extend(added.loads);
    model.motors.extend(added.motors);
    model.brakes.extend(added.brakes);
    model.errors.extend(added.errors);
    model.work = added.work.or(model.work);
    let empty = !["inertia", "chain", "planetary"]
        .iter()
        .any(|key| f.has(key));
    f.finish();
    // A misspelt [[inertia]] has been noted as such.
    if empty && notes.errors.is_empty() {
        let what = match file.source.text.trim().is_empty() {
            true => "the file is empty",
            false => "the model has no [[inertia]], so nothing can move",
        };
        let error = Error::new(Code::EmptyMachine, what).with_span(&span);
        notes.push(error.with_hint("`geardyn new FILE` writes a model to start from"));
    }
    consistency::check(&model, notes);
    model
}
