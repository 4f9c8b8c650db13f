//! A model or scene file from the first byte to a checked `Scene`.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::model::{Brake, FormError, Load, Model, Motor};
use super::start::{self, Start};
use super::study::Study;
use super::tables::{each, one};
use super::{
    bodies, drives, form_errors, gears, nodes, overrides, planetary, screws, shafts, study,
    supports,
};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::fields::Fields;
use crate::base::load;
use crate::base::notes::Notes;
use crate::base::place::{Place, Source};
use crate::base::toml::{self, Document, Value};

/// A model with what a scene asks of it; a model file alone is a scene without studies.
#[derive(Debug, Clone)]
pub struct Scene {
    /// The machine, with the scene's changes made.
    pub model: Model,
    /// The model file.
    pub model_path: PathBuf,
    /// Where motion starts.
    pub start: Start,
    /// What is asked, in the order asked.
    pub studies: Vec<Study>,
    /// Every file read, the one named first at the front; their texts are what a hash of the input covers.
    pub sources: Vec<Arc<Source>>,
}

impl Scene {
    /// Where each of these files lies.
    pub fn files(&self) -> Vec<PathBuf> {
        let path = |source: &Arc<Source>| PathBuf::from(&source.path);
        self.sources.iter().map(path).collect()
    }
}

/// Reads a model or a scene, and the model the scene names.
pub fn read(path: &Path) -> Result<Scene, Errors> {
    read_source(load::load(path)?)
}

/// Reads the text of a model or a scene as if it stood in the file `path`.
pub fn read_text(path: &str, text: &str) -> Result<Scene, Errors> {
    read_source(load::source(path.to_string(), text))
}

/// Tables a model file does not have.
const SCENE_KEYS: [&str; 4] = ["study", "start", "set", "model_loads"];

fn read_source(source: Arc<Source>) -> Result<Scene, Errors> {
    let document = toml::parse(&source);
    let mut notes = Notes::default();
    note_units(&document, &mut notes);
    if document.root.get("model").is_some() {
        return read_scene(document, notes);
    }
    if let Some(entry) = document.root.get("measured_gear") {
        let message = "this file describes a measured gear, not a machine";
        let error = Error::new(Code::Usage, message).at(&entry.key_place);
        return Err(error
            .hint(format!("`geardyn measure {}` evaluates it", source.path))
            .into());
    }
    let belongs = |key: &&str| document.root.get(key).is_some();
    if let (Some(key), None) = (SCENE_KEYS.into_iter().find(belongs), &document.broken) {
        let place = Place::new(source.clone(), 0..0);
        let error = Error::new(
            Code::MissingKey,
            format!("`{key}` belongs to a scene, and a scene names its model"),
        );
        return Err(error
            .at(&place)
            .hint("write model = \"path of the model\" at the top")
            .into());
    }
    let model = read_model(&document, Added::default(), &mut notes);
    finish(notes, document.broken, || Scene {
        model,
        model_path: PathBuf::from(&source.path),
        start: Start::default(),
        studies: Vec::new(),
        sources: vec![source.clone()],
    })
}

/// Remembers a file that states bare numbers in SI.
fn note_units(document: &Document, notes: &mut Notes) {
    let units = document.root.get("units").map(|entry| &entry.item.value);
    if matches!(units, Some(Value::Text(text)) if text == "SI") {
        notes.bare_si.push(document.source.path.clone());
    }
}

/// All errors, or the value. Behind a syntax error nothing was read, so what seems to be missing may stand there.
fn finish<T>(
    mut notes: Notes,
    broken: Option<Error>,
    value: impl FnOnce() -> T,
) -> Result<T, Errors> {
    if let Some(broken) = broken {
        notes.errors.retain(|error| {
            !matches!(
                error.code,
                Code::MissingKey | Code::UnknownNode | Code::EmptyMachine
            )
        });
        notes.push(broken);
    }
    Errors::or(notes.errors, value)
}

fn read_scene(document: Document, mut notes: Notes) -> Result<Scene, Errors> {
    let place = Place::new(document.source.clone(), 0..0);
    let mut f = Fields::new(&document.root, place, "the scene", &mut notes);
    let (title, _) = heading(&mut f);
    let named = f.optional_text("model");
    let added = Added {
        loads: each(&mut f, "load", drives::load),
        motors: each(&mut f, "motor", drives::motor),
        brakes: brakes(&mut f),
        errors: each(&mut f, "error", form_errors::form_error),
        alone: f.choice("model_loads", &[("kept", false), ("left out", true)]) == Some(true),
    };
    let start = one(&mut f, "start", start::read).unwrap_or_default();
    let studies = each(&mut f, "study", study::read);
    f.item("set", "a table of \"element.key\" = value");
    let at = f.place_of("model").clone();
    f.ends();
    let whole = document.broken.is_none();
    let found = named
        .filter(|_| whole)
        .and_then(|named| model_of(&document, named, &at, added, &mut notes));
    // Without a model an error has been noted, and the scene below is not made.
    let (mut model, model_path, source, broken) = match found {
        Some((model, path, file)) => (model, path, file.source, file.broken),
        None => (
            Model::default(),
            PathBuf::new(),
            document.source.clone(),
            document.broken,
        ),
    };
    if !title.is_empty() {
        model.title = title;
    }
    finish(notes, broken, || Scene {
        model,
        model_path,
        start,
        studies: studies.into_iter().flatten().collect(),
        sources: vec![document.source.clone(), source],
    })
}

/// The model a scene names, changed as the scene says.
fn model_of(
    scene: &Document,
    named: &str,
    at: &Place,
    added: Added,
    notes: &mut Notes,
) -> Option<(Model, PathBuf, Document)> {
    let folder = Path::new(&scene.source.path).parent();
    let path = folder.unwrap_or(Path::new("")).join(named);
    let source = match load::load(&path) {
        Ok(source) => source,
        Err(error) if error.code == Code::NotText => {
            notes.push(error);
            return None;
        }
        Err(error) => {
            let error = error.at(at).label("in the scene");
            notes.push(error.hint("the path starts from the scene's folder"));
            return None;
        }
    };
    let mut file = toml::parse(&source);
    note_units(&file, notes);
    if file.root.get("model").is_some() {
        let error = Error::new(Code::Conflict, "the model is itself a scene");
        notes.push(error.at(at).hint("name the model file of that scene"));
        return None;
    }
    if let (Some(set), None) = (scene.root.get("set"), &file.broken) {
        overrides::apply(set, &mut file.root, notes);
    }
    let model = read_model(&file, added, notes);
    Some((model, path, file))
}

/// Keys both kinds of file have at their top.
fn heading(f: &mut Fields) -> (String, String) {
    f.choice("units", &[("SI", ())]);
    let mut text = |key| f.optional_text(key).unwrap_or_default().to_string();
    (text("title"), text("source"))
}

/// What a scene does to a machine.
#[derive(Default)]
struct Added {
    loads: Vec<Load>,
    motors: Vec<Motor>,
    brakes: Vec<Brake>,
    errors: Vec<FormError>,
    /// The model's own loads are left out.
    alone: bool,
}

/// Brakes, then clutches: friction of one kind.
fn brakes(f: &mut Fields) -> Vec<Brake> {
    let mut all = each(f, "brake", drives::brake);
    all.extend(each(f, "clutch", drives::clutch));
    all
}

/// The tables of a model file; what a scene adds comes after its own.
fn read_model(file: &Document, added: Added, notes: &mut Notes) -> Model {
    let place = Place::new(file.source.clone(), 0..0);
    let mut f = Fields::new(&file.root, place.clone(), "the model", notes);
    let (title, source) = heading(&mut f);
    let mut model = Model {
        title,
        source,
        inertias: each(&mut f, "inertia", bodies::inertia),
        shafts: each(&mut f, "shaft", shafts::shaft),
        chains: each(&mut f, "chain", bodies::chain),
        gear_pairs: each(&mut f, "gear_pair", gears::gear_pair),
        worm_pairs: each(&mut f, "worm_pair", gears::worm_pair),
        planetaries: each(&mut f, "planetary", planetary::planetary),
        belts: each(&mut f, "belt", gears::belt),
        slides: each(&mut f, "slide", screws::slide),
        screws: each(&mut f, "screw", screws::screw),
        couplings: each(&mut f, "coupling", shafts::coupling),
        bearings: each(&mut f, "bearing", supports::bearing),
        dampers: each(&mut f, "damper", supports::damper),
        loads: each(&mut f, "load", drives::load),
        motors: each(&mut f, "motor", drives::motor),
        brakes: brakes(&mut f),
        errors: each(&mut f, "error", form_errors::form_error),
        damping: one(&mut f, "damping", supports::damping).unwrap_or_default(),
        speeds: one(&mut f, "speed", supports::speeds).unwrap_or_default(),
    };
    if added.alone {
        model.loads.clear();
    }
    model.loads.extend(added.loads);
    model.motors.extend(added.motors);
    model.brakes.extend(added.brakes);
    model.errors.extend(added.errors);
    let empty = !["inertia", "chain", "planetary"]
        .iter()
        .any(|key| f.has(key));
    f.ends();
    // A misspelt [[inertia]] has been noted as such.
    if empty && notes.errors.is_empty() {
        let what = match file.source.text.trim().is_empty() {
            true => "the file is empty",
            false => "the model has no [[inertia]], so nothing can move",
        };
        let error = Error::new(Code::EmptyMachine, what).at(&place);
        notes.push(error.hint("`geardyn new FILE` writes a model to start from"));
    }
    nodes::check(&model, notes);
    model
}
