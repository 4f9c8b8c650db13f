//! Graph of the drive train: nodes with their positions in a schematic, links, planetary stages.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use serde_json::{Value, json};

use super::train_layout::{GridPlace, LinkSide, Neighbours, place_parts};
use crate::machine::components::Machine;
use crate::plan::prepared_machine::PreparedMachine;
use crate::scene::model::{Axis, BranchEnd, Model, Planetary, PlanetaryGeometry};

/// Smallest rotation of a rigid-body motion relative to the first node; smaller ones are rounding.
const ROUNDING: f64 = 1e-9;

/// Width and height of a planetary stage, grid cells.
const STAGE_CELLS: i64 = 3;

/// Radius of a body and largest radius of a gear, grid cells.
const RADII: (f64, f64) = (0.3, 0.46);

/// JSON graph of a machine: `dofs`, `nodes`, `links`, `stages`.
pub fn train(prepared: &PreparedMachine, model: &Model) -> Value {
    let machine = &prepared.machine;
    let links = links(machine);
    let stages = stages(machine, &model.planetaries);
    let parts = Parts::new(machine.nodes.len(), &stages);
    let places = parts.places(&links);
    let radii = radii(machine, model);
    let ratios = ratios(prepared);
    let mut node_dofs = vec![serde_json::Map::new(); machine.nodes.len()];
    for (i, dof) in machine.dofs.iter().enumerate() {
        node_dofs[dof.node].insert(dof.axis.name().to_string(), json!(i));
    }
    let node = |n: usize| {
        let dofs = &node_dofs[n];
        let kind = machine.elements[machine.nodes[n].element].kind;
        json!({
            "name": machine.nodes[n].name,
            "kind": kind,
            "place": places[parts.part_of[n]],
            "radius": radii[n],
            "ratio": ratios.as_ref().map(|r| r[n]),
            "dofs": dofs,
        })
    };
    let name = |n: &usize| machine.nodes[*n].name.as_str();
    let link = |link: &Link| {
        json!({
            "element": machine.elements[link.element].name,
            "kind": machine.elements[link.element].kind,
            "mesh": link.is_mesh(machine),
            "nodes": link.nodes.iter().map(name).collect::<Vec<_>>(),
        })
    };
    let stage = |(k, stage): (usize, &Stage)| {
        json!({
            "name": stage.planetary.name.text,
            "place": places[k],
            "sun": stage.members[0].as_ref().map(name),
            "ring": stage.members[1].as_ref().map(name),
            "carrier": stage.members[2].as_ref().map(name),
            "planets": stage.planets.iter().map(name).collect::<Vec<_>>(),
            "positions_rad": stage.planetary.positions,
            "radii": pitch_radii(&stage.planetary.size),
            "lateral": stage.planetary.lateral,
        })
    };
    json!({
        "dofs": machine.dof_names(),
        "nodes": (0..machine.nodes.len()).map(node).collect::<Vec<_>>(),
        "links": links.iter().map(link).collect::<Vec<_>>(),
        "stages": stages.iter().enumerate().map(stage).collect::<Vec<_>>(),
    })
}

/// Element between nodes, or between a node and ground.
struct Link {
    element: usize,
    nodes: Vec<usize>,
    /// Whether both ends rotate equally in the unstrained state, as on one shaft.
    coaxial: bool,
}

impl Link {
    fn is_mesh(&self, machine: &Machine) -> bool {
        ["gear_pair", "worm_pair"].contains(&machine.elements[self.element].kind)
    }
}

/// Links in the order of the branches, one per pair of nodes of an element; none for planetary stages.
fn links(machine: &Machine) -> Vec<Link> {
    let mut links: Vec<Link> = Vec::new();
    let mut index_of: HashMap<(usize, Vec<usize>), usize> = HashMap::new();
    for branch in &machine.branches {
        if machine.elements[branch.element].kind == "planetary" {
            continue;
        }
        let dofs = branch.direction.terms.iter().map(|t| machine.dofs[t.0]);
        let mut nodes: Vec<usize> = dofs.map(|d| d.node).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let coaxial = match branch.direction.terms[..] {
            [(_, a), (_, b)] => a == -b,
            _ => false,
        };
        match index_of.entry((branch.element, nodes.clone())) {
            Entry::Occupied(link) => links[*link.get()].coaxial |= coaxial,
            Entry::Vacant(place) => {
                place.insert(links.len());
                links.push(Link {
                    element: branch.element,
                    nodes,
                    coaxial,
                });
            }
        }
    }
    links
}

/// Planetary stage with its nodes.
struct Stage<'a> {
    planetary: &'a Planetary,
    /// Nodes of sun, ring and carrier; `None` for a fixed member.
    members: [Option<usize>; 3],
    planets: Vec<usize>,
}

fn stages<'a>(machine: &Machine, planetaries: &'a [Planetary]) -> Vec<Stage<'a>> {
    let by_name: HashMap<&str, usize> = (machine.nodes.iter().enumerate())
        .map(|(n, node)| (node.name.as_str(), n))
        .collect();
    let member = |end: &BranchEnd| match end {
        BranchEnd::Node(name) => by_name.get(name.text.as_str()).copied(),
        BranchEnd::Ground => None,
    };
    let stage = |planetary: &'a Planetary| {
        let name = |k: usize| format!("{}.planet_{}", planetary.name.text, k + 1);
        let planets = (0..planetary.positions.len()).map(name);
        Stage {
            planetary,
            members: [&planetary.sun, &planetary.ring, &planetary.carrier].map(member),
            planets: planets
                .filter_map(|p| by_name.get(p.as_str()).copied())
                .collect(),
        }
    };
    planetaries.iter().map(stage).collect()
}

/// Radii of sun, planet, ring and carrier divided by the ring radius.
fn pitch_radii(size: &PlanetaryGeometry) -> [f64; 4] {
    let [sun, planet, ring] = match *size {
        PlanetaryGeometry::Teeth { teeth, .. } => teeth.map(f64::from),
        PlanetaryGeometry::Radii { base, .. } => base,
    };
    [sun, planet, ring, sun + planet].map(|r| r / ring)
}

/// Parts of the schematic: stages first, then nodes outside stages.
struct Parts {
    sizes: Vec<i64>,
    part_of: Vec<usize>,
    /// Pairs of parts with a common node.
    shared: Vec<[usize; 2]>,
}

impl Parts {
    fn new(n_nodes: usize, stages: &[Stage]) -> Parts {
        let mut sizes = vec![STAGE_CELLS; stages.len()];
        let mut owner: Vec<Option<usize>> = vec![None; n_nodes];
        let mut shared = Vec::new();
        for (k, stage) in stages.iter().enumerate() {
            let nodes = stage.members.iter().flatten().chain(&stage.planets);
            for &node in nodes {
                match owner[node] {
                    Some(other) => shared.push([other, k]),
                    None => owner[node] = Some(k),
                }
            }
        }
        let mut single = || {
            sizes.push(1);
            sizes.len() - 1
        };
        let part_of = owner
            .into_iter()
            .map(|p| p.unwrap_or_else(&mut single))
            .collect();
        Parts {
            sizes,
            part_of,
            shared,
        }
    }

    fn places(&self, links: &[Link]) -> Vec<GridPlace> {
        let mut neighbours: Vec<Neighbours> = vec![Vec::new(); self.sizes.len()];
        let mut connect = |a: usize, b: usize, side: LinkSide| {
            if a != b {
                neighbours[a].push((b, side));
                neighbours[b].push((a, side));
            }
        };
        for &[a, b] in &self.shared {
            connect(a, b, LinkSide::Along);
        }
        for link in links {
            let side = match link.coaxial {
                true => LinkSide::Along,
                false => LinkSide::Across,
            };
            if let [a, b] = link.nodes[..] {
                connect(self.part_of[a], self.part_of[b], side);
            }
        }
        place_parts(&self.sizes, &neighbours)
    }
}

/// Radius of each node, grid cells; gears by their share of the teeth of a pair.
fn radii(machine: &Machine, model: &Model) -> Vec<f64> {
    let mut radii = vec![RADII.0; machine.nodes.len()];
    for pair in &model.gear_pairs {
        let sum = f64::from(pair.teeth[0]) + f64::from(pair.teeth[1]);
        for (name, teeth) in pair.between.iter().zip(pair.teeth) {
            let share = (f64::from(teeth) / sum).clamp(RADII.0, RADII.1);
            let node = machine.nodes.iter().position(|n| n.name == name.text);
            if let Some(node) = node {
                radii[node] = share;
            }
        }
    }
    radii
}

/// Speed ratio of each node to the first rotating node; `None` unless a single rigid-body motion rotates all rotating nodes.
pub fn ratios(prepared: &PreparedMachine) -> Option<Vec<f64>> {
    let machine = &prepared.machine;
    let mut dof = vec![None; machine.nodes.len()];
    for (i, d) in machine.dofs.iter().enumerate() {
        if d.axis == Axis::Theta || machine.is_slide(i) {
            dof[d.node] = Some(i);
        }
    }
    let theta = |q: Vec<f64>| -> Vec<Option<f64>> { dof.iter().map(|d| d.map(|i| q[i])).collect() };
    let rotates = |t: &Vec<Option<f64>>| t.iter().flatten().any(|&x| x != 0.0);
    let motions = prepared.model.rigid.iter();
    let candidates = motions
        .map(|m| theta(prepared.model.expand(m)))
        .filter(rotates);
    let [theta] = &candidates.collect::<Vec<_>>()[..] else {
        return None;
    };
    let first = theta.iter().flatten().next()?;
    let all_rotate = theta
        .iter()
        .flatten()
        .all(|t| t.abs() > ROUNDING * first.abs());
    let ratio = |t: &Option<f64>| t.map_or(1.0, |t| t / first);
    all_rotate.then(|| theta.iter().map(ratio).collect())
}
