//! Second contact: a point of a generated profile contacts the generating profile at the arc at which it was generated and again at the
//! arc at which its normal passes through the pitch point a second time.
//!
//! The second envelope is the curve of these points in the frame of the tool; both contacts coincide where the normal lies along the
//! common tangent, at the limit of the second kind.

use super::conjugate::ConjugateProfile;
use super::contact::Contact;
use super::contact_arcs::ArcGrid;
use super::pitch_curve::out_of_range;
use super::profile::Profile;
use super::rolling::Centrode;
use crate::base::error::Error;
use crate::numeric::Complex;

/// Relative distance of arcs below which two roots count as one: the square root of rounding, the accuracy of a double root.
const SAME_ROOT: f64 = 1e-7;

/// Point of a generated profile with its two contacts.
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

/// Second contacts of a generated profile over one turn of the work, in the order of its contacts; points without a second contact are omitted.
///
/// # Errors
/// `OutOfRange` if no point has a second contact, as for a rack: its normals intersect the pitch line once.
pub fn second_contacts<P: Profile>(
    generated: &ConjugateProfile<P>,
) -> Result<Vec<SecondContact>, Error> {
    let reversed = generated.rolling().reversed();
    let grid = ArcGrid::new(&reversed.tool);
    let turn = reversed.tool.arc_of_turn();
    let to_contact = |first: &Contact| {
        let jet = generated.jet(first.parameter)?;
        let offset = |arc: f64| match turn {
            Some(turn) => {
                let fraction = (arc - first.arc) / turn;
                fraction - fraction.round()
            }
            None => arc - first.arc,
        };
        let arcs = grid.contact_arcs(&reversed.tool, &jet).into_iter();
        let other_arcs = arcs.filter(|arc| offset(*arc).abs() > SAME_ROOT);
        let arc = other_arcs.min_by(|a, b| offset(*a).abs().total_cmp(&offset(*b).abs()))?;
        let arc = match (turn, &reversed.tool) {
            (Some(turn), Centrode::Circle { .. }) => first.arc + offset(arc) * turn,
            _ => arc,
        };
        let contact = Contact::new(&reversed, first.parameter, &jet, arc)?;
        Some(SecondContact {
            first: *first,
            arc,
            tool_point: contact.work_point,
            path_point: contact.path_point,
            tool_curvature: contact.work_curvature,
        })
    };
    let contacts: Vec<_> = generated.contacts().iter().filter_map(to_contact).collect();
    if contacts.is_empty() {
        return Err(out_of_range(
            "the generated profile has no second contact with its generator".into(),
        ));
    }
    Ok(contacts)
}
