//! Teeth of a bevel pair as plates: middle plane, thickness and the direction of the normal force from both flanks.
//!
//! At a place `[z, radius]` of the section both flanks have the azimuth between them and their normals; the middle plane is normal to the
//! difference m of these. The thickness is the arc times m's part along it, the depth below the loaded flank half of it over n·m. A force
//! acts where its line crosses the middle plane. Flanks go down to the root cone as the straight blades would cut them: the root line
//! stands for the fillet. Below the end of a flank (undercut limit) the tooth is as thick as at the end.

use super::contact_line::ToothLoad;
use super::flank_position::ToothBending;
use super::material::Material;
use super::tooth_plate::{PlateShape, RootMoment, ToothPlate};
use crate::base::error::Error;
use crate::gear::bevel::tooth::BevelTooth;
use crate::gear::bevel::tooth_section::ToothSection;
use crate::gear::kernel::vector::Vector;

/// Nodes of a tooth's table along face and height.
const NODES: usize = 9;
/// Least thickness of the plate over its greatest: a pointed tip.
const THINNEST: f64 = 0.02;

/// Teeth of pinion and gear.
#[derive(Debug, Clone)]
pub struct BevelTeeth {
    members: [PlateMember; 2],
}

/// A tooth with its plate.
#[derive(Debug, Clone)]
struct PlateMember {
    section: ToothSection,
    plate: ToothPlate,
    /// By face, each by height.
    table: Vec<ToothPlace>,
}

/// A tooth at a place of its section.
#[derive(Debug, Clone, Copy)]
struct ToothPlace {
    /// Thickness normal to the middle plane, m.
    thickness: f64,
    /// Cosine of the loaded flank's normal with that of the middle plane.
    cosine: f64,
    /// Parts of the loaded flank's normal along z and radius.
    normal: [f64; 2],
    /// Cosine of the spiral angle of the middle plane.
    spiral: f64,
}

impl BevelTeeth {
    /// Teeth whose flanks `loaded` (of pinion and gear: 0 concave, 1 convex) carry; none where a flank does not exist over the whole face.
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
    fn at(&self, member: usize, place: [f64; 2]) -> Option<ToothLoad> {
        let of = &self.members[member];
        let here = of.at(of.section.shares(place)?);
        let depth = 0.5 * here.thickness / here.cosine;
        // Where the line of the force crosses the middle plane.
        let crossing = [0, 1].map(|k| place[k] - depth * here.normal[k]);
        let (shape, response) = of.plate.load(of.section.shares(crossing)?, here.cosine);
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
        let column = |face: usize| -> Option<[ToothPlace; NODES]> {
            let at =
                |height: usize| tooth_place(tooth, loaded, &section, [share(face), share(height)]);
            let places: [Option<ToothPlace>; NODES] = std::array::from_fn(at);
            let lowest = places.iter().position(Option::is_some)?;
            let filled: Option<Vec<ToothPlace>> =
                (0..NODES).map(|j| places[j.max(lowest)]).collect();
            filled?.try_into().ok()
        };
        let columns: Option<Vec<[ToothPlace; NODES]>> = (0..NODES).map(column).collect();
        let Some(mut table) = columns.map(|columns| columns.concat()) else {
            return Ok(None);
        };
        let thickest = table.iter().map(|p| p.thickness).fold(0.0, f64::max);
        table
            .iter_mut()
            .for_each(|p| p.thickness = p.thickness.max(THINNEST * thickest));
        let spiral = interpolated(&table, [0.5, 0.5]).spiral;
        let shape = PlateShape {
            corners: unrolled(&section, spiral),
            material,
        };
        let plate = ToothPlate::new(&shape, |at| interpolated(&table, at).thickness)?;
        Ok(Some(PlateMember {
            section,
            plate,
            table,
        }))
    }

    fn at(&self, at: [f64; 2]) -> ToothPlace {
        interpolated(&self.table, at)
    }
}

/// A tooth at shares of face and height; none where a flank does not exist there.
fn tooth_place(
    tooth: &BevelTooth,
    loaded: usize,
    section: &ToothSection,
    [face, height]: [f64; 2],
) -> Option<ToothPlace> {
    let place = section.at(face, height);
    let [low, high] = tooth.by_azimuth();
    let (of_low, of_high) = (
        tooth.blade_point(low, place)?,
        tooth.blade_point(high, place)?,
    );
    let [n_low, n_high] =
        [&of_low.0, &of_high.0].map(|p| cylindrical(p.point.coordinates, p.normal.components));
    let m = (n_high - n_low).unit()?;
    let n = if loaded == high { n_high } else { n_low };
    let section_line = along_face(section);
    let along = m.x * section_line[1] + m.z * section_line[0];
    Some(ToothPlace {
        thickness: place[1] * (of_high.1 - of_low.1) * m.y.abs(),
        cosine: n.dot(m).abs(),
        normal: [n.z, n.x],
        spiral: m.y.abs() / m.y.hypot(along),
    })
}

/// Parts of a vector at a point along radius, arc and z.
fn cylindrical(point: Vector, vector: Vector) -> Vector {
    let rho = f64::hypot(point.x, point.y);
    let (cos, sin) = (point.x / rho, point.y / rho);
    Vector::new(
        vector.x * cos + vector.y * sin,
        vector.y * cos - vector.x * sin,
        vector.z,
    )
}

/// Unit vector `[z, radius]` along the root from toe to heel.
fn along_face(section: &ToothSection) -> [f64; 2] {
    let [[toe, _], [heel, _]] = section.corners;
    let (dz, dr) = (heel[0] - toe[0], heel[1] - toe[1]);
    let length = f64::hypot(dz, dr);
    [dz / length, dr / length]
}

/// Corners of the middle plane: along the root, lengthened by the spiral angle, and up from it.
fn unrolled(section: &ToothSection, spiral: f64) -> [[[f64; 2]; 2]; 2] {
    let [z, r] = along_face(section);
    let origin = section.corners[0][0];
    section.corners.map(|side| {
        side.map(|corner| {
            let off = [corner[0] - origin[0], corner[1] - origin[1]];
            [
                (off[0] * z + off[1] * r) / spiral,
                (off[1] * z - off[0] * r).abs(),
            ]
        })
    })
}

/// Bilinear interpolation of a table at shares of face and height, constant beyond its ends.
fn interpolated(table: &[ToothPlace], at: [f64; 2]) -> ToothPlace {
    let cells = (NODES - 1) as f64;
    let [(i, s), (j, t)] = at.map(|share| {
        let x = share.clamp(0.0, 1.0) * cells;
        let cell = x.floor().min(cells - 1.0);
        (cell as usize, x - cell)
    });
    let node = |di: usize, dj: usize| &table[(i + di) * NODES + j + dj];
    let mean = |of: fn(&ToothPlace) -> f64| {
        (1.0 - s) * ((1.0 - t) * of(node(0, 0)) + t * of(node(0, 1)))
            + s * ((1.0 - t) * of(node(1, 0)) + t * of(node(1, 1)))
    };
    ToothPlace {
        thickness: mean(|p| p.thickness),
        cosine: mean(|p| p.cosine),
        normal: [mean(|p| p.normal[0]), mean(|p| p.normal[1])],
        spiral: mean(|p| p.spiral),
    }
}
