//! Mesh of a bevel pair of a gear file, as a model names it: directions at the reference contact and the unloaded transmission error.

use std::sync::Arc;

use super::bevel_file::{self, BevelFile, ContactSide};
use super::laws::Hand;
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::flags::Flags;
use crate::base::source_span::SourceFile;
use crate::gear::bevel::settings;
use crate::gear::contact::contact_path::PITCHES;
use crate::gear::contact::pair::FlankPair;
use crate::gear::contact::reference::ContactForces;

/// A bevel pair as a mesh of a model takes it from its gear file.
#[derive(Debug)]
pub struct BevelMesh {
    /// The file.
    pub source: Arc<SourceFile>,
    /// Tooth numbers of pinion and gear.
    pub teeth: [u32; 2],
    /// Hand of the pinion.
    pub hand: Hand,
    /// Pitch angles, rad.
    pub cone_angles: [f64; 2],
    /// Spiral angles of the contact normal at the reference contact, rad.
    pub spiral_angles: [f64; 2],
    /// Normal pressure angle at the reference contact, rad.
    pub pressure_angle: f64,
    /// Normal module whose lever `m_n z cos α_n/2` is that of the contact normal, m.
    pub module: f64,
    /// Unloaded transmission error along the normal over one mesh cycle, from the reference contact on, m.
    pub te: Vec<f64>,
    /// The coast flanks touch.
    pub is_coast: bool,
    /// Peak-to-peak of the transmission error, m.
    pub peak_to_peak: f64,
}

impl BevelMesh {
    /// The mesh of a file.
    ///
    /// # Errors
    /// Everything wrong in the file; flanks that do not touch at every angle.
    pub fn read(source: &Arc<SourceFile>) -> Result<BevelMesh, Errors> {
        let file = bevel_file::read(source, &Flags::default())?;
        Ok(BevelMesh::new(&file)?)
    }

    fn new(file: &BevelFile) -> Result<BevelMesh, Error> {
        let refused = |why: &str| {
            Error::new(Code::OutOfRange, why)
                .with_span(&file.span)
                .with_hint("`geardyn gear` on this file shows the contact and where it ends")
        };
        if file.is_conjugate() {
            return Err(refused(
                "straight teeth are conjugate and give a machine no transmission error: state the data of the mesh in the model",
            ));
        }
        let sides = file.contact.side.flanks();
        let flanks = [0, 1].map(|k| file.flank(k, sides[k]));
        let [Some(pinion), Some(gear)] = flanks else {
            return Err(refused("the flanks that touch are not both described"));
        };
        let teeth = file.members.each_ref().map(|m| m.teeth);
        let pair = FlankPair::new([pinion, gear], teeth, file.hand, &file.assembly());
        let first = pair.first_contact().filter(|c| pair.is_near_teeth(c));
        let first = first
            .ok_or_else(|| refused("the flanks do not touch near the middle of their teeth"))?;
        let positions = file.contact.positions;
        let path = pair.path(first, PITCHES.max(file.contact.pitches), positions);
        let reference = &path.reference;
        let forces = ContactForces::of(&pair, reference);
        let levers = forces.levers;
        // The cycle goes forward as the pinion pushes.
        let sense = forces.pinion_turn;
        let te: Option<Vec<f64>> = (0..positions)
            .map(|i| {
                let share = sense * i as f64 / positions as f64;
                let angle = reference.pinion_angle + share * pair.pitch();
                Some(levers[1] * pair.leading(&path, angle)?.te)
            })
            .collect();
        let te = te.ok_or_else(|| {
            refused("between two pairs of teeth there are angles at which none touches")
        })?;
        let extreme = |pick: fn(f64, f64) -> f64| te.iter().copied().reduce(pick).unwrap_or(0.0);
        let cone_angles = file.members.each_ref().map(|m| m.blank.pitch_angle);
        let [alpha, beta_1] = forces.angles(0, cone_angles[0]);
        let [_, beta_2] = forces.angles(1, cone_angles[1]);
        Ok(BevelMesh {
            source: file.source.clone(),
            teeth,
            hand: match file.hand {
                settings::Hand::Right => Hand::Right,
                settings::Hand::Left => Hand::Left,
            },
            cone_angles,
            spiral_angles: [beta_1, beta_2],
            pressure_angle: alpha,
            module: 2.0 * levers[0] / (f64::from(teeth[0]) * alpha.cos()),
            peak_to_peak: extreme(f64::max) - extreme(f64::min),
            is_coast: file.contact.side == ContactSide::Coast,
            te,
        })
    }
}
