//! Compliance of a tooth pair for a unit face width, by one of two methods: potential energy along the flank, or the constant c′ of ISO 6336-1.
//!
//! Energy: `1/k = Σ (bending + shear + axial + body) + contact`, in the transverse section; displacement and force along the base tangent.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::gear::cylindrical::member::MEMBERS;
use crate::gear::cylindrical::pair::Pair;

use super::body::Body;
use super::contact_path::ContactPath;
use super::hertz::{ContactModel, FlankContact};
use super::iso6336::{IsoStiffness, Web};
use super::material::Material;
use super::tooth::ToothSection;

/// Intervals of Simpson's rule over the path of contact; 64 and 128 differ by less than 1e-8 of the mean.
const INTERVALS: usize = 64;

/// Least relative radius for the width of a contact, as a share of the sum of both lengths of roll: at a base circle it would vanish.
const LEAST_RADIUS: f64 = 1e-4;

/// Method for the stiffness of a tooth pair.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StiffnessMethod {
    /// Potential energy of the teeth on bodies of a named model.
    Energy {
        /// Body of each gear.
        bodies: [Body; 2],
        /// Contact of the flanks.
        contact: ContactModel,
    },
    /// c′ of ISO 6336-1:2006, the same along the flank.
    Iso6336 {
        /// Web of each gear, `None` of a solid disc.
        webs: [Option<Web>; 2],
    },
}

impl Default for StiffnessMethod {
    fn default() -> StiffnessMethod {
        StiffnessMethod::Energy {
            bodies: [Body::default(); 2],
            contact: ContactModel::default(),
        }
    }
}

impl StiffnessMethod {
    /// Name in files and results.
    pub fn name(&self) -> &'static str {
        match self {
            StiffnessMethod::Energy { .. } => "energy",
            StiffnessMethod::Iso6336 { .. } => "iso-6336",
        }
    }

    /// Names of the models of the bodies.
    pub fn bodies(&self) -> [&'static str; 2] {
        match self {
            StiffnessMethod::Energy { bodies, .. } => bodies.map(|b| b.name()),
            StiffnessMethod::Iso6336 { webs } => webs.map(|w| match w {
                Some(_) => "web (C_R)",
                None => "solid disc (C_M)",
            }),
        }
    }

    /// Effects that the method leaves out.
    pub fn left_out(&self) -> &'static [&'static str] {
        match self {
            StiffnessMethod::Energy { .. } => &[
                "coupling of slices along the width and of neighbouring teeth through the body",
                "change of the contact's width with the load",
                "friction, and the axial force of helical teeth",
                "web, rim and shaft unless the body model has them",
            ],
            StiffnessMethod::Iso6336 { .. } => &[
                "change of the stiffness along the flank",
                "change with load (fitted for F_t K_A/b of 100 N/mm and more)",
                "friction, and coupling of slices along the width",
                "fillets other than those of the basic rack",
            ],
        }
    }
}

/// Compliance of a tooth pair.
#[derive(Debug, Clone)]
pub enum PairCompliance {
    /// Two teeth on their bodies.
    Energy {
        /// Teeth.
        teeth: Box<[ToothSection; 2]>,
        /// Bodies.
        bodies: [Body; 2],
        /// Contact of the flanks.
        contact: ContactModel,
        /// +1 external, −1 internal second gear: the sign of its curvature.
        sense: f64,
    },
    /// c′ by ISO 6336-1.
    Iso6336(Box<IsoStiffness>),
}

impl PairCompliance {
    /// The compliance of a pair.
    ///
    /// # Errors
    /// `OutOfRange`: teeth whose flanks meet below the tip, a bore off the range of its model. `Conflict`: the model of a ring on a shaft for an internal gear.
    pub fn new(
        pair: &Pair,
        method: &StiffnessMethod,
        materials: &[Material; 2],
    ) -> Result<PairCompliance, Error> {
        match *method {
            StiffnessMethod::Iso6336 { webs } => Ok(PairCompliance::Iso6336(Box::new(
                IsoStiffness::new(pair, materials, webs),
            ))),
            StiffnessMethod::Energy { bodies, contact } => {
                if pair.outlines[1].internal && matches!(bodies[1], Body::Ring { .. }) {
                    let message =
                        "the elastic ring model is for gears on a shaft, not for an internal gear";
                    return Err(Error::new(Code::Conflict, message)
                        .with_key("body")
                        .with_hint("use the half plane for an internal gear"));
                }
                let section = |i: usize| {
                    let outline = &pair.outlines[i];
                    let body = bodies[i].check(outline.root_radius);
                    let tooth = body.and_then(|()| ToothSection::new(outline, materials[i]));
                    tooth.map_err(|error| error.with_part(MEMBERS[i]))
                };
                let teeth = [section(0)?, section(1)?];
                Ok(PairCompliance::Energy {
                    teeth: Box::new(teeth),
                    bodies,
                    contact,
                    sense: if pair.outlines[1].internal { -1.0 } else { 1.0 },
                })
            }
        }
    }

    /// Compliance at lengths of roll of both flanks, m²/N.
    pub fn at(&self, rolls: [f64; 2]) -> f64 {
        match self {
            PairCompliance::Iso6336(iso) => iso.single.recip(),
            PairCompliance::Energy {
                teeth,
                bodies,
                contact,
                sense,
            } => {
                let tooth = |i: usize| {
                    let tooth: &ToothSection = &teeth[i];
                    let body = bodies[i].compliance(&tooth.foot_load(rolls[i]), tooth.material());
                    tooth.compliance(rolls[i]).total() + body
                };
                let curvature = rolls[0].recip() + sense * rolls[1].recip();
                let least = LEAST_RADIUS * (rolls[0] + rolls[1]);
                let flanks = FlankContact {
                    radius: curvature.recip().max(least),
                    depths: [0, 1].map(|i| teeth[i].depth(rolls[i])),
                };
                let materials = [0, 1].map(|i| *teeth[i].material());
                tooth(0) + tooth(1) + contact.compliance(&flanks, &materials)
            }
        }
    }

    /// Statements of the quantities outside the ranges of the method.
    pub fn outside_range(&self) -> Vec<String> {
        match self {
            PairCompliance::Iso6336(iso) => iso.outside_range.clone(),
            PairCompliance::Energy { teeth, bodies, .. } => {
                let feet = teeth.iter().zip(bodies);
                feet.filter_map(|(tooth, body)| {
                    let foot = tooth.foot_load(0.0);
                    body.outside_range(foot.root_radius, foot.root_half_angle)
                })
                .collect()
            }
        }
    }
}

/// Stiffness of a pair by one method, for a table of several.
#[derive(Debug, Clone, PartialEq)]
pub struct StiffnessRow {
    /// Name of the method.
    pub method: &'static str,
    /// Body model of each gear.
    pub bodies: [&'static str; 2],
    /// Stiffness of one tooth pair at the pitch point, for a unit width, Pa.
    pub at_pitch_point: f64,
    /// Greatest stiffness of one tooth pair along the path: c′ of ISO 6336-1, Pa.
    pub single: f64,
    /// Mean mesh stiffness of unmodified flanks under full contact: c_γα of ISO 6336-1, Pa.
    pub mesh: f64,
    /// Effects that the method leaves out.
    pub left_out: &'static [&'static str],
    /// Statements of the quantities outside the ranges of the method.
    pub outside_range: Vec<String>,
}

/// The stiffness of a pair by several methods side by side.
///
/// # Errors
/// As `PairCompliance::new`.
pub fn compare_methods(
    pair: &Pair,
    methods: &[StiffnessMethod],
    materials: &[Material; 2],
) -> Result<Vec<StiffnessRow>, Error> {
    let path = ContactPath::new(pair);
    let row = |method: &StiffnessMethod| {
        let compliance = PairCompliance::new(pair, method, materials)?;
        let [start, end] = path.ends;
        let step = (end - start) / INTERVALS as f64;
        let along = (0..=INTERVALS).map(|i| start + step * i as f64);
        let stiffness = along.filter_map(|roll| path.place(roll));
        let values: Vec<f64> = stiffness.map(|p| compliance.at(p.rolls).recip()).collect();
        // Simpson: 1 4 2 4 … 4 1.
        let weight = |i: usize| match i {
            0 | INTERVALS => 1.0,
            _ if i % 2 == 1 => 4.0,
            _ => 2.0,
        };
        let integral: f64 = values.iter().enumerate().map(|(i, k)| weight(i) * k).sum();
        let mesh = match &compliance {
            PairCompliance::Iso6336(iso) => iso.mesh,
            PairCompliance::Energy { .. } => integral * step / 3.0 / path.base_pitch,
        };
        Ok(StiffnessRow {
            method: method.name(),
            bodies: method.bodies(),
            at_pitch_point: compliance.at(path.pitch_rolls).recip(),
            single: values.iter().fold(0.0, |most, k| k.max(most)),
            mesh,
            left_out: method.left_out(),
            outside_range: compliance.outside_range(),
        })
    };
    methods.iter().map(row).collect()
}
