//! Second contact: a generated profile, carried by the same motion, touches its generator at the arc of its making and where its normal
//! passes through the pitch point again.
//!
//! The second envelope is the curve of these points on the body of the tool; both contacts meet where the normal lies along the common
//! tangent, at the limit of the second kind.

use super::conjugate::ConjugateProfile;
use super::contact::Contact;
use super::contact_arcs::ArcGrid;
use super::pitch_curve::out_of_range;
use super::profile::Profile;
use super::rolling::Centrode;
use crate::base::error::Error;
use crate::numeric::Complex;

/// Relative distance of arcs below which two roots are one: the square root of rounding, as of a double root.
const SAME_ROOT: f64 = 1e-7;

/// Point of a generated profile with both its contacts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SecondContact {
    /// The contact that generated the point.
    pub first: Contact,
    /// Arc of the second contact, m.
    pub arc: f64,
    /// Point of the second envelope, in the frame of the tool, m.
    pub tool_point: Complex,
    /// Point of the second line of action, in the pitch frame, m.
    pub path_point: Complex,
    /// Curvature of the second envelope, 1/m.
    pub tool_curvature: f64,
}

/// Second contacts of a generated profile over one turn of the work, in the order of its contacts; points with none are left out.
///
/// # Errors
/// `OutOfRange` where no point has a second contact, as with a rack: its normals meet the pitch line once.
pub fn second_contacts<P: Profile>(
    generated: &ConjugateProfile<P>,
) -> Result<Vec<SecondContact>, Error> {
    let back = generated.rolling().reversed();
    let grid = ArcGrid::new(&back.tool);
    let turn = back.tool.arc_of_turn();
    let of = |first: &Contact| {
        let jet = generated.jet(first.parameter)?;
        let apart = |arc: f64| match turn {
            Some(turn) => {
                let rest = (arc - first.arc) / turn;
                rest - rest.round()
            }
            None => arc - first.arc,
        };
        let arcs = grid.contact_arcs(&back.tool, &jet).into_iter();
        let others = arcs.filter(|arc| apart(*arc).abs() > SAME_ROOT);
        let arc = others.min_by(|a, b| apart(*a).abs().total_cmp(&apart(*b).abs()))?;
        let arc = match (turn, &back.tool) {
            (Some(turn), Centrode::Circle { .. }) => first.arc + apart(arc) * turn,
            _ => arc,
        };
        let contact = Contact::new(&back, first.parameter, &jet, arc)?;
        Some(SecondContact {
            first: *first,
            arc,
            tool_point: contact.work_point,
            path_point: contact.path_point,
            tool_curvature: contact.work_curvature,
        })
    };
    let contacts: Vec<_> = generated.contacts().iter().filter_map(of).collect();
    if contacts.is_empty() {
        return Err(out_of_range(
            "no point of the generated profile touches its generator a second time".into(),
        ));
    }
    Ok(contacts)
}
