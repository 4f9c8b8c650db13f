//! Checks across tables: duplicate names, unknown nodes, missing modules.

use std::collections::{HashMap, HashSet};

use super::model::{Axis, BranchDamping, BranchEnd, Model, Name, Planetary, ShaftBody};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::error_collector::ErrorCollector;
use crate::base::text::suggestion;

use crate::base::quantity::truncate;

/// Notes what is wrong between the tables of a model.
pub fn check(model: &Model, errors: &mut ErrorCollector) {
    duplicates(model, errors);
    let nodes = NodeTable::from_model(model);
    for name in references(model) {
        if errors.is_full() {
            return;
        }
        if !name.text.is_empty() && !nodes.has(&name.text) {
            errors.push(nodes.unknown(name));
        }
    }
    check_modules(model, errors);
    check_gear_files(model, errors);
}

/// Every element's name, table by table.
fn names(model: &Model) -> Vec<&Name> {
    let mut names: Vec<&Name> = model.inertias.iter().map(|e| &e.name).collect();
    names.extend(model.shafts.iter().map(|e| &e.name));
    names.extend(model.chains.iter().map(|e| &e.name));
    names.extend(model.gear_pairs.iter().map(|e| &e.name));
    names.extend(model.worm_pairs.iter().map(|e| &e.name));
    names.extend(model.planetaries.iter().map(|e| &e.name));
    names.extend(model.belts.iter().map(|e| &e.name));
    names.extend(model.slides.iter().map(|e| &e.name));
    names.extend(model.screws.iter().map(|e| &e.name));
    names.extend(model.couplings.iter().map(|e| &e.name));
    names.extend(model.bearings.iter().map(|e| &e.name));
    names.extend(model.dampers.iter().map(|e| &e.name));
    names.extend(model.motors.iter().map(|e| &e.name));
    names.extend(model.brakes.iter().map(|e| &e.name));
    names
}

/// Names used more than once, shown at each later use.
fn duplicates(model: &Model, errors: &mut ErrorCollector) {
    let mut names = names(model);
    names.retain(|name| !name.text.is_empty());
    names.sort_by_key(|name| name.span.span().start);
    let mut first: HashMap<&str, &Name> = HashMap::new();
    for name in names {
        let Some(earlier) = first.get(name.text.as_str()) else {
            first.insert(&name.text, name);
            continue;
        };
        if errors.is_full() {
            return;
        }
        let line = earlier.span.line();
        errors.push(
            Error::new(
                Code::DuplicateName,
                format!("the name \"{}\" is taken", truncate(&name.text)),
            )
            .with_span(&name.span)
            .with_label(format!("first used in line {line}"))
            .with_hint("names are unique over all tables, since results speak of elements by name"),
        );
    }
}

/// Every place of the model that names a node.
fn references(model: &Model) -> Vec<&Name> {
    let mut ends: Vec<&BranchEnd> = Vec::new();
    ends.extend(model.shafts.iter().flat_map(|e| &e.between));
    ends.extend(model.couplings.iter().flat_map(|e| &e.between));
    ends.extend(model.bearings.iter().flat_map(|e| &e.between));
    ends.extend(model.dampers.iter().flat_map(|e| &e.between));
    ends.extend(model.brakes.iter().flat_map(|e| &e.between));
    ends.extend(
        model
            .planetaries
            .iter()
            .flat_map(|p| [&p.sun, &p.ring, &p.carrier]),
    );
    let mut nodes: Vec<&Name> = ends
        .into_iter()
        .filter_map(|end| match end {
            BranchEnd::Node(name) => Some(name),
            BranchEnd::Ground => None,
        })
        .collect();
    nodes.extend(model.gear_pairs.iter().flat_map(|e| &e.between));
    nodes.extend(model.worm_pairs.iter().flat_map(|e| &e.between));
    nodes.extend(model.belts.iter().flat_map(|e| &e.between));
    nodes.extend(model.screws.iter().flat_map(|e| &e.between));
    nodes.extend(model.loads.iter().map(|e| &e.at));
    nodes.extend(model.motors.iter().map(|e| &e.at));
    // Others stand on elements; what is wrong with them is found when they are put in place.
    nodes.extend(
        (model.errors.iter())
            .filter(|e| !e.cause.is_on_non_gear())
            .map(|e| &e.on),
    );
    nodes.extend(model.speeds.iter().map(|e| &e.at));
    nodes
}

/// The nodes of a model: bodies, and what chains, cut shafts and planetary stages make.
struct NodeTable<'a> {
    bodies: HashSet<&'a str>,
    /// Elements that make nodes `name.1 …` or `name.planet_1 …`, with the number of the last.
    rows: HashMap<&'a str, (&'static str, usize)>,
    elements: HashSet<&'a str>,
    /// Names `stage.sun` and `stage.ring` of fixed members, for errors.
    standing: HashSet<String>,
}

impl<'a> NodeTable<'a> {
    fn from_model(model: &'a Model) -> NodeTable<'a> {
        let mut rows = HashMap::new();
        for chain in &model.chains {
            rows.insert(chain.name.text.as_str(), ("", chain.count));
        }
        for shaft in &model.shafts {
            if let Some(ShaftBody::Bar { segments, .. }) = shaft.body {
                rows.insert(shaft.name.text.as_str(), ("", segments.saturating_sub(1)));
            }
        }
        for stage in &model.planetaries {
            rows.insert(stage.name.text.as_str(), ("planet_", stage.positions.len()));
        }
        for coupling in model.couplings.iter().filter(|c| !c.maxwell.is_empty()) {
            rows.insert(
                coupling.name.text.as_str(),
                ("maxwell_", coupling.maxwell.len()),
            );
        }
        let bodies = model.inertias.iter().map(|body| &body.name);
        let bodies = bodies.chain(model.slides.iter().map(|slide| &slide.name));
        NodeTable {
            bodies: bodies.map(|name| name.text.as_str()).collect(),
            rows,
            elements: names(model).iter().map(|n| n.text.as_str()).collect(),
            standing: model.planetaries.iter().flat_map(fixed_members).collect(),
        }
    }

    fn has(&self, node: &str) -> bool {
        self.bodies.contains(node)
            || self.is_generated_node(node).is_some()
            || self.standing.contains(node)
    }

    /// The node is one of those an element makes.
    fn is_generated_node(&self, node: &str) -> Option<()> {
        let (element, number) = node.rsplit_once('.')?;
        let (prefix, last) = self.rows.get(element)?;
        let digits = number.strip_prefix(prefix)?;
        let n: usize = digits.parse().ok()?;
        ((1..=*last).contains(&n) && n.to_string() == digits).then_some(())
    }

    fn unknown(&self, name: &Name) -> Error {
        let node = &name.text;
        let element = node.rsplit_once('.').map_or(node.as_str(), |(e, _)| e);
        let hint = if let Some((prefix, last)) = self.rows.get(element) {
            format!(
                "the nodes of `{element}` are `{element}.{prefix}1` to `{element}.{prefix}{last}`"
            )
        } else if self.elements.contains(node.as_str()) {
            format!("`{node}` is an element, not a body; name one of the bodies it joins")
        } else {
            let mut known: Vec<&str> = self.bodies.iter().copied().chain(["ground"]).collect();
            known.sort_unstable();
            match suggestion(node, known.into_iter()) {
                Some(meant) => format!("did you mean `{meant}`?"),
                None => {
                    "a body is declared by an [[inertia]]; J = \"0 kg·m²\" makes it massless".into()
                }
            }
        };
        Error::new(Code::UnknownNode, format!("no node `{}`", truncate(node)))
            .with_span(&name.span)
            .with_hint(hint)
    }
}

/// Names of what of a stage is fixed to ground and has errors all the same.
fn fixed_members(stage: &Planetary) -> impl Iterator<Item = String> + '_ {
    let members = [("sun", &stage.sun), ("ring", &stage.ring)];
    let fixed = members
        .into_iter()
        .filter(|(_, end)| matches!(end, BranchEnd::Ground));
    fixed.map(|(word, _)| format!("{}.{word}", stage.name.text))
}

/// Notes what contradicts gear files, which determine a stiffness as soon as a torque is known.
fn check_gear_files(model: &Model, errors: &mut ErrorCollector) {
    for (name, mesh, contact) in model.gear_meshes() {
        let mesh = mesh.file();
        let file = &mesh.source.path;
        let torque = match (mesh.torque, model.loads.is_empty()) {
            (Some(_), _) => Some(format!("{file} states a torque")),
            (None, false) => Some("the model has loads".to_string()),
            (None, true) => None,
        };
        match (&mesh.stated_stiffness, torque) {
            (Some((key, span)), Some(why)) => {
                let line = mesh.place.line();
                let message = format!(
                    "`{key}` is determined by the gear file {file}, line {line}, since {why}"
                );
                errors.push(
                    Error::new(Code::Conflict, message)
                        .with_span(span)
                        .with_hint(format!("leave `{key}` out")),
                );
            }
            (None, None) if contact.loss != BranchDamping::None => {
                let message = format!(
                    "`{}` has losses and no stiffness: no load is stated, and {file} has no torque",
                    name.text
                );
                errors.push(
                    Error::new(Code::MissingKey, message)
                        .with_span(&name.span)
                        .with_hint("add a [[load]], `torque` in [mesh] of the gear file, or `k`"),
                );
            }
            _ => {}
        }
    }
}

/// Notes pairs without a module on bodies that move sideways, where the size of the gears counts.
fn check_modules(model: &Model, errors: &mut ErrorCollector) {
    let mut lateral: HashSet<&str> = HashSet::new();
    for bearing in &model.bearings {
        let sideways = |terms: &[(Axis, Axis, f64)]| terms.iter().any(|t| t.0 != Axis::Theta);
        if sideways(&bearing.stiffness) {
            for end in &bearing.between {
                if let BranchEnd::Node(name) = end {
                    lateral.insert(&name.text);
                }
            }
        }
    }
    let gears = model.gear_pairs.iter();
    let gears = gears.map(|p| (&p.name, &p.between, p.module, p.contact.stiffness));
    let worms = model.worm_pairs.iter();
    let worms = worms.map(|p| (&p.name, &p.between, p.module, p.contact.stiffness));
    for (name, between, module, stiffness) in gears.chain(worms) {
        let moves = between.iter().find(|n| lateral.contains(n.text.as_str()));
        if let (None, None, Some(body)) = (module, stiffness, moves) {
            let message = format!(
                "\"{}\" has no `module`, and `{}` moves sideways",
                name.text, body.text
            );
            errors.push(
                Error::new(Code::MissingKey, message)
                    .with_span(&name.span)
                    .with_hint("the module gives the lever arm of the tooth force"),
            );
        }
    }
}
