//! Bevel teeth as plates: middle plane, thickness and direction of the normal force from both flanks.
//!
//! At a position `[z, radius]` of the section, the unit vector m along the difference of the normals of both flanks is normal to the middle
//! plane. The thickness is the arc between the flanks times the component of m along it, the depth of the middle plane below the loaded
//! flank half the thickness over n·m. A force acts where its line intersects the middle plane. Flanks are extended to the root cone by the
//! straight blades, which replaces the fillet. Below the end of a flank (undercut limit) the thickness is constant.

use super::contact_line::ToothLoad;
use super::flank_position::ToothBending;
use super::material::Material;
use super::tooth_plate::{PlateShape, RootMoment, ToothPlate};
use crate::base::error::Error;
use crate::gear::bevel::tooth::BevelTooth;
use crate::gear::bevel::tooth_section::ToothSection;
use crate::gear::kernel::vector::Vector;

/// Nodes of the table of a tooth along face and along height.
const NODES: usize = 9;
/// Minimum plate thickness relative to the maximum, for a pointed tip.
const MIN_THICKNESS: f64 = 0.02;

/// Plate models of the teeth of pinion and gear.
#[derive(Debug, Clone)]
pub struct BevelTeeth {
    members: [PlateMember; 2],
}

/// Tooth of a member with its plate.
#[derive(Debug, Clone)]
struct PlateMember {
    section: ToothSection,
    plate: ToothPlate,
    /// Nodes by face, each column by height.
    table: Vec<ToothNode>,
}

/// Tooth at a position of its section.
#[derive(Debug, Clone, Copy)]
struct ToothNode {
    /// Thickness normal to the middle plane, m.
    thickness: f64,
    /// Cosine of the angle between the normals of loaded flank and middle plane.
    cosine: f64,
    /// Components of the unit normal of the loaded flank along z and radius.
    normal: [f64; 2],
    /// Cosine of the spiral angle of the middle plane.
    spiral: f64,
}

impl BevelTeeth {
    /// Teeth with the loaded flanks of pinion and gear (0 concave, 1 convex); `None` where a flank does not exist over the full face.
    ///
    /// # Errors
    /// As `ToothPlate::new`.
    pub fn new(
        teeth: [&BevelTooth; 2],
        loaded: [usize; 2],
        materials: &[Material; 2],
    ) -> Result<Option<BevelTeeth>, Error> {
        let mut members = Vec::with_capacity(2);
        for k in 0..2 {
            let Some(member) = PlateMember::new(teeth[k], loaded[k], materials[k])? else {
                return Ok(None);
            };
            members.push(member);
        }
        Ok(members
            .try_into()
            .ok()
            .map(|members| BevelTeeth { members }))
    }
}

impl ToothBending for BevelTeeth {
    fn at(&self, member: usize, position: [f64; 2]) -> Option<ToothLoad> {
        let tooth = &self.members[member];
        let node = tooth.at(tooth.section.shares(position)?);
        let depth = 0.5 * node.thickness / node.cosine;
        // Intersection of the line of the force with the middle plane.
        let point = [0, 1].map(|k| position[k] - depth * node.normal[k]);
        let (shape, response) = tooth.plate.load(tooth.section.shares(point)?, node.cosine);
        Some(ToothLoad {
            depth,
            shape,
            response,
        })
    }

    fn root_moment(&self, member: usize, loading: &[f64]) -> RootMoment {
        self.members[member].plate.root_moment(loading)
    }
}

impl PlateMember {
    fn new(
        tooth: &BevelTooth,
        loaded: usize,
        material: Material,
    ) -> Result<Option<PlateMember>, Error> {
        let section = tooth.flanks[0].section;
        let share = |i: usize| i as f64 / (NODES - 1) as f64;
        let column = |face: usize| -> Option<[ToothNode; NODES]> {
            let at =
                |height: usize| tooth_node(tooth, loaded, &section, [share(face), share(height)]);
            let nodes: [Option<ToothNode>; NODES] = std::array::from_fn(at);
            let lowest = nodes.iter().position(Option::is_some)?;
            let filled: Option<Vec<ToothNode>> = (0..NODES).map(|j| nodes[j.max(lowest)]).collect();
            filled?.try_into().ok()
        };
        let columns: Option<Vec<[ToothNode; NODES]>> = (0..NODES).map(column).collect();
        let Some(mut table) = columns.map(|columns| columns.concat()) else {
            return Ok(None);
        };
        let max_thickness = table.iter().map(|p| p.thickness).fold(0.0, f64::max);
        table
            .iter_mut()
            .for_each(|p| p.thickness = p.thickness.max(MIN_THICKNESS * max_thickness));
        let spiral = interpolate(&table, [0.5, 0.5]).spiral;
        let shape = PlateShape {
            corners: plane_corners(&section, spiral),
            material,
        };
        let plate = ToothPlate::new(&shape, |shares| interpolate(&table, shares).thickness)?;
        Ok(Some(PlateMember {
            section,
            plate,
            table,
        }))
    }

    fn at(&self, shares: [f64; 2]) -> ToothNode {
        interpolate(&self.table, shares)
    }
}

/// Tooth at shares of face and height; `None` where a flank does not exist there.
fn tooth_node(
    tooth: &BevelTooth,
    loaded: usize,
    section: &ToothSection,
    [face, height]: [f64; 2],
) -> Option<ToothNode> {
    let position = section.at(face, height);
    let [low, high] = tooth.by_azimuth();
    let (lower, upper) = (
        tooth.blade_point(low, position)?,
        tooth.blade_point(high, position)?,
    );
    let [n_low, n_high] =
        [&lower.0, &upper.0].map(|p| cylindrical(p.point.coordinates, p.normal.components));
    let m = (n_high - n_low).unit()?;
    let n = if loaded == high { n_high } else { n_low };
    let section_line = along_face(section);
    let face_component = m.x * section_line[1] + m.z * section_line[0];
    Some(ToothNode {
        thickness: position[1] * (upper.1 - lower.1) * m.y.abs(),
        cosine: n.dot(m).abs(),
        normal: [n.z, n.x],
        spiral: m.y.abs() / m.y.hypot(face_component),
    })
}

/// Components of a vector at a point along radius, arc and z.
fn cylindrical(point: Vector, vector: Vector) -> Vector {
    let rho = f64::hypot(point.x, point.y);
    let (cos, sin) = (point.x / rho, point.y / rho);
    Vector::new(
        vector.x * cos + vector.y * sin,
        vector.y * cos - vector.x * sin,
        vector.z,
    )
}

/// Unit vector `[z, radius]` along the root line from toe to heel.
fn along_face(section: &ToothSection) -> [f64; 2] {
    let [[toe, _], [heel, _]] = section.corners;
    let (dz, dr) = (heel[0] - toe[0], heel[1] - toe[1]);
    let length = f64::hypot(dz, dr);
    [dz / length, dr / length]
}

/// Corners of the middle plane, m: coordinates along the root line, lengthened by the spiral angle, and perpendicular to it.
fn plane_corners(section: &ToothSection, spiral: f64) -> [[[f64; 2]; 2]; 2] {
    let [z, r] = along_face(section);
    let origin = section.corners[0][0];
    section.corners.map(|side| {
        side.map(|corner| {
            let offset = [corner[0] - origin[0], corner[1] - origin[1]];
            [
                (offset[0] * z + offset[1] * r) / spiral,
                (offset[1] * z - offset[0] * r).abs(),
            ]
        })
    })
}

/// Bilinear interpolation of a table at shares of face and height, constant outside.
fn interpolate(table: &[ToothNode], shares: [f64; 2]) -> ToothNode {
    let cells = (NODES - 1) as f64;
    let [(i, s), (j, t)] = shares.map(|share| {
        let x = share.clamp(0.0, 1.0) * cells;
        let cell = x.floor().min(cells - 1.0);
        (cell as usize, x - cell)
    });
    let node = |di: usize, dj: usize| &table[(i + di) * NODES + j + dj];
    let mean = |quantity: fn(&ToothNode) -> f64| {
        (1.0 - s) * ((1.0 - t) * quantity(node(0, 0)) + t * quantity(node(0, 1)))
            + s * ((1.0 - t) * quantity(node(1, 0)) + t * quantity(node(1, 1)))
    };
    ToothNode {
        thickness: mean(|p| p.thickness),
        cosine: mean(|p| p.cosine),
        normal: [mean(|p| p.normal[0]), mean(|p| p.normal[1])],
        spiral: mean(|p| p.spiral),
    }
}
