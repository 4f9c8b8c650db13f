//! Conjugate profiles as envelopes: the kernel's equation of meshing `n·v = 0` for a rolling motion and a profile.

use super::pitch_curve::out_of_range;
use super::profile::Profile;
use super::rolling::{Centrode, Rolling};
use crate::base::error::Error;
use crate::gear::kernel::law::Law;
use crate::gear::kernel::motion::Motion;
use crate::gear::kernel::plane::{PlaneEnvelope, plane_envelope};
use crate::gear::kernel::pose::Pose;
use crate::gear::kernel::tool::Curve;
use crate::gear::kernel::twist::Twist;
use crate::gear::kernel::vector::Vector;
use crate::numeric::Complex;

/// Frame of the body whose profile is given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToolFrame;

/// Frame of the body whose profile is generated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WorkFrame;

/// Frame of the pitch point of lines and circles: y along the common tangent.
#[derive(Debug, Clone, Copy, PartialEq)]
struct PitchFrame;

/// A plane profile as a curve of the kernel.
#[derive(Debug, Clone)]
pub struct ProfileCurve<P>(P);

impl<P: Profile> Curve for ProfileCurve<P> {
    fn at(&self, u: f64) -> [Vector; 3] {
        let nowhere = Vector::new(f64::NAN, f64::NAN, f64::NAN);
        let vector = |z: Complex| Vector::new(z.re, z.im, 0.0);
        self.0.jet(u).map_or([nowhere; 3], |jet| {
            // The kernel takes only the part of the second derivative across the tangent.
            let bend = Complex::new(0.0, jet.speed * jet.turn) * jet.tangent;
            [jet.point, jet.tangent * jet.speed, bend].map(vector)
        })
    }

    fn range(&self) -> [f64; 2] {
        self.0.range()
    }
}

/// The envelope of a tool's profile over a range of the motion's parameter: the arc s (m) for lines and circles, φ₁ (rad) for the two bodies
/// of a pair.
///
/// # Errors
/// `OutOfRange` for a tool that rolls on a centrode of another pair: its conjugate is found by normals.
pub fn envelope<P: Profile>(
    rolling: &Rolling,
    tool: P,
    range: [f64; 2],
) -> Result<PlaneEnvelope<ProfileCurve<P>, WorkFrame, ToolFrame>, Error> {
    Ok(plane_envelope(ProfileCurve(tool), motion(rolling)?, range))
}

fn motion(rolling: &Rolling) -> Result<Motion<WorkFrame, ToolFrame>, Error> {
    let is_member = |centrode: &Centrode| matches!(centrode, Centrode::Member { .. });
    if is_member(&rolling.tool) != is_member(&rolling.work) {
        return Err(out_of_range(
            "the envelope is computed for lines and circles, or the two bodies of one pair, only"
                .into(),
        )
        .with_hint("use the conjugate by normals"));
    }
    let work: Motion<PitchFrame, WorkFrame> = to_pitch(&rolling.work);
    Ok(to_pitch(&rolling.tool).followed_by(work.inverse()))
}

/// Motion of a body in the frame of the pitch point; of a body of a pair in the fixed frame.
fn to_pitch<Body>(centrode: &Centrode) -> Motion<PitchFrame, Body> {
    let start = Motion::<Body, Body>::identity();
    let axis = Twist::turn(Vector::Z, Vector::ZERO);
    let shift = |x: f64| Pose::<PitchFrame, Body>::shifted(Vector::new(x, 0.0, 0.0));
    match centrode {
        Centrode::Line => start
            .joint(Twist::slide(Vector::Y), Law::linear(-1.0))
            .then(shift(0.0)),
        Centrode::Circle { radius } => start
            .joint(axis, Law::linear(-radius.recip()))
            .then(shift(-radius)),
        Centrode::Member { pair, member } => {
            let (pair, member) = (pair.clone(), *member);
            let (origin, screw) = match pair.mate_axis(member) {
                Some(x) => (x, axis),
                None => (0.0, Twist::slide(Vector::Y)),
            };
            let law = move |angle| pair.displacement(member, angle).unwrap_or([f64::NAN; 3]);
            start.joint(screw, Law::function(law)).then(shift(origin))
        }
    }
}
