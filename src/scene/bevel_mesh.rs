//! Mesh of a bevel pair of a gear file, as a model names it: directions at the reference contact and the unloaded transmission error.
//!
//! Along the normal of the reference contact a turn of the gear counts its lever there. The mesh cycle goes forward as the pinion turns
//! about its axis from apex to heel by the right hand, in which sense its torque counts as well: a concave flank pushes forwards on a
//! right-hand pinion and backwards on a left-hand one.

use super::bevel_file::BevelFile;
use super::gear_mesh::MeshFile;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::gear::bevel::flank::BevelFlank;
use crate::gear::contact::contact_path::{ContactPath, PITCHES};
use crate::gear::contact::pair::FlankPair;
use crate::gear::contact::reference::ContactForces;
use crate::gear::hand::Hand;
use crate::numeric::statistics::peak_to_peak;

/// A bevel pair as a mesh of a model takes it from its gear file.
#[derive(Debug)]
pub struct BevelMesh {
    /// The file as the model names it.
    pub file: MeshFile,
    /// Content of the file.
    pub bevel: BevelFile,
    /// The flanks that touch.
    pub pair: FlankPair,
    /// Their path of contact.
    pub path: ContactPath,
    /// Hand of the pinion.
    pub hand: Hand,
    /// Spiral angles of the contact normal at the reference contact, rad.
    pub spiral_angles: [f64; 2],
    /// Normal pressure angle at the reference contact, rad.
    pub pressure_angle: f64,
    /// Normal module whose lever `m_n z cos α_n/2` is that of the contact normal, m.
    pub module: f64,
    /// Levers of the normal about both axes, m.
    pub levers: [f64; 2],
    /// The flank of the pinion pushes as it turns backwards, and carries a torque below zero.
    pub is_backward: bool,
    /// Unloaded transmission error along the normal over one mesh cycle, from the reference contact on, m.
    pub te: Vec<f64>,
    /// Peak-to-peak of the transmission error, m.
    pub peak_to_peak: f64,
}

impl BevelMesh {
    /// The mesh of a file.
    ///
    /// # Errors
    /// Straight teeth; flanks that do not touch at every angle.
    pub fn new(file: MeshFile, bevel: BevelFile) -> Result<BevelMesh, Error> {
        let refused = |why: &str| refused(&bevel, why);
        if bevel.is_conjugate() {
            let message = "straight teeth are conjugate and have no transmission error";
            return Err(Error::new(Code::OutOfRange, message)
                .with_span(&bevel.span)
                .with_hint(
                    "state teeth, cone_angles and k of the mesh in the model, in place of `gear`",
                ));
        }
        let sides = bevel.contact.side.flanks();
        let flanks = [0, 1].map(|k| bevel.flank(k, sides[k]));
        let [Some(pinion), Some(gear)] = flanks else {
            return Err(refused("the flanks that touch are not both described"));
        };
        BevelMesh::of_flanks(file, bevel, [pinion, gear])
    }

    /// The mesh of other flanks than those of the settings.
    ///
    /// # Errors
    /// Flanks that do not touch at every angle.
    pub fn of_flanks(
        file: MeshFile,
        bevel: BevelFile,
        flanks: [BevelFlank; 2],
    ) -> Result<BevelMesh, Error> {
        let refused = |why: &str| refused(&bevel, why);
        let teeth = bevel.members.each_ref().map(|m| m.teeth);
        let pair = FlankPair::new(flanks, teeth, bevel.hand, &bevel.assembly());
        let positions = bevel.contact.positions;
        let path = pair
            .path_near_teeth(PITCHES.max(bevel.contact.pitches), positions)
            .ok_or_else(|| refused("the flanks do not touch near the middle of their teeth"))?;
        if pair.removed_at(&path.reference).is_some() {
            return Err(refused("undercut removes a flank at the contact"));
        }
        let forces = ContactForces::of(&pair, &path.reference);
        let levers = forces.levers;
        let te: Option<Vec<f64>> = (0..positions)
            .map(|i| {
                let share = i as f64 / positions as f64;
                let angle = path.reference.pinion_angle + share * pair.pitch();
                Some(levers[1] * pair.leading(&path, angle)?.te)
            })
            .collect();
        let te =
            te.ok_or_else(|| refused("at some angles between two tooth pairs no teeth touch"))?;
        let cone_angles = bevel.members.each_ref().map(|m| m.blank.pitch_angle);
        let [alpha, beta_1] = forces.angles(0, cone_angles[0]);
        let [_, beta_2] = forces.angles(1, cone_angles[1]);
        Ok(BevelMesh {
            file,
            hand: bevel.hand,
            spiral_angles: [beta_1, beta_2],
            pressure_angle: alpha,
            module: 2.0 * levers[0] / (f64::from(teeth[0]) * alpha.cos()),
            levers,
            is_backward: forces.pinion_turn < 0.0,
            peak_to_peak: peak_to_peak(&te),
            te,
            bevel,
            pair,
            path,
        })
    }

    /// Tooth numbers of pinion and gear.
    pub fn teeth(&self) -> [u32; 2] {
        self.pair.teeth
    }

    /// Pitch angles, rad.
    pub fn cone_angles(&self) -> [f64; 2] {
        self.bevel.members.each_ref().map(|m| m.blank.pitch_angle)
    }
}

/// The error of flanks that give a machine no mesh.
fn refused(bevel: &BevelFile, why: &str) -> Error {
    Error::new(Code::OutOfRange, why)
        .with_span(&bevel.span)
        .with_hint("`geardyn gear` on this file shows the contact and where it ends")
}
