//! Keys of the `cutter` of a bevel gear or flank, and refusals of blades whose parts do not join.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::error_collector::ValueRange;
use crate::base::quantity_kind::QuantityKind;
use crate::base::source_span::SourceSpan;
use crate::base::table_reader::TableReader;
use crate::gear::bevel::cutter::{Blade, BladeFault, Cutter, Toprem};

/// Keys of a cutter as written; none where left out.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct CutterTable {
    point_radius: Option<f64>,
    blade_angle: Option<f64>,
    edge_radius: Option<f64>,
    profile_radius: Option<f64>,
    profile_height: Option<f64>,
    toprem_angle: Option<f64>,
    toprem_depth: Option<f64>,
}

const BLADE_ANGLE: ValueRange = ValueRange::Open(0.0, 1.2, "above 0° and below 68°");
const TOPREM_ANGLE: ValueRange = ValueRange::Open(0.0, 0.5, "above 0° and below 28°");

/// Reads the keys of a cutter.
pub(super) fn cutter(f: &mut TableReader) -> CutterTable {
    let length =
        |f: &mut TableReader, key, range| f.optional_quantity(key, QuantityKind::Length, range);
    let angle =
        |f: &mut TableReader, key, range| f.optional_quantity(key, QuantityKind::Angle, range);
    let table = CutterTable {
        point_radius: length(f, "point_radius", ValueRange::Positive),
        blade_angle: angle(f, "blade_angle", BLADE_ANGLE),
        edge_radius: length(f, "edge_radius", ValueRange::NotNegative),
        profile_radius: length(f, "profile_radius", ValueRange::Any),
        profile_height: length(f, "profile_height", ValueRange::NotNegative),
        toprem_angle: angle(f, "toprem_angle", TOPREM_ANGLE),
        toprem_depth: length(f, "toprem_depth", ValueRange::Positive),
    };
    if table.profile_radius == Some(0.0) {
        let hint = "give a concave blade a radius above zero, a convex one below; omit `profile_radius` and `profile_height` for a straight one";
        f.report_key(
            Code::OutOfRange,
            "profile_radius",
            "`profile_radius` must not be 0",
            hint,
        );
    }
    table
}

impl CutterTable {
    /// These keys over those of the gear.
    pub(super) fn over(self, gear: CutterTable) -> CutterTable {
        CutterTable {
            point_radius: self.point_radius.or(gear.point_radius),
            blade_angle: self.blade_angle.or(gear.blade_angle),
            edge_radius: self.edge_radius.or(gear.edge_radius),
            profile_radius: self.profile_radius.or(gear.profile_radius),
            profile_height: self.profile_height.or(gear.profile_height),
            toprem_angle: self.toprem_angle.or(gear.toprem_angle),
            toprem_depth: self.toprem_depth.or(gear.toprem_depth),
        }
    }

    /// The cutter of a flank; keys that are missing are noted in the table being read.
    pub(super) fn of_flank(&self, f: &mut TableReader, side: &str) -> Option<Cutter> {
        let mut need = |value: Option<f64>, key: &str, hint: &str| {
            if value.is_none() {
                let span = f.span.clone();
                let message = format!("the {side} flank of {} has no `{key}`", f.title);
                f.report(Code::MissingKey, message, &span, hint);
            }
            value
        };
        let in_cutter = "give it in `cutter` of the flank or of the gear";
        let point_radius = need(self.point_radius, "point_radius", in_cutter);
        let blade_angle = need(self.blade_angle, "blade_angle", in_cutter);
        let mut pair = |values: [Option<f64>; 2], keys: [&str; 2], hint: &str| match values {
            [None, None] => Some(None),
            [a, b] => Some(Some([need(a, keys[0], hint)?, need(b, keys[1], hint)?])),
        };
        let arc = pair(
            [self.profile_radius, self.profile_height],
            ["profile_radius", "profile_height"],
            "a curved blade needs `profile_radius` and the `profile_height` at which it has its blade angle",
        );
        let toprem = pair(
            [self.toprem_angle, self.toprem_depth],
            ["toprem_angle", "toprem_depth"],
            "a Toprem needs `toprem_angle` from the blade and `toprem_depth` from the tip plane",
        );
        let blade = match side {
            "concave" => Blade::Outside,
            _ => Blade::Inside,
        };
        let straight = Cutter::straight(blade, point_radius?, blade_angle?);
        let [radius, height] = arc?.unwrap_or([f64::INFINITY, 0.0]);
        Some(Cutter {
            edge_radius: self.edge_radius.unwrap_or(0.0),
            profile_curvature: 1.0 / radius,
            profile_height: height,
            toprem: toprem?.map(|[angle, depth]| Toprem { angle, depth }),
            ..straight
        })
    }
}

/// A blade whose parts do not join for teeth of a depth, m.
pub(super) fn check(
    cutter: &Cutter,
    depth: f64,
    (side, member): (&str, &str),
    span: &SourceSpan,
) -> Result<(), Error> {
    let Some(fault) = cutter.fault(depth) else {
        return Ok(());
    };
    let depth = 1e3 * depth;
    let (what, hint) = match fault {
        BladeFault::Turned { height } => (
            format!(
                "`profile_radius` {:.3} mm turns the blade through 0° or 82° at {:.3} mm above the tip plane",
                1e3 / cutter.profile_curvature,
                1e3 * height
            ),
            "take a larger profile_radius, or a profile_height near half the depth of the tooth",
        ),
        BladeFault::DeepToprem => (
            format!("`toprem_depth` exceeds the tooth depth of {depth:.3} mm"),
            "take a smaller toprem_depth",
        ),
        BladeFault::SteepToprem { blade_angle } => (
            format!(
                "`toprem_angle` is not below the angle of the blade at `toprem_depth`, {:.3}°",
                blade_angle.to_degrees()
            ),
            "take a smaller toprem_angle: the Toprem must still open away from the tip",
        ),
        BladeFault::LongEdge { height, limit } => (
            match height {
                Some(height) => format!(
                    "the edge radius ends {:.3} mm above the tip plane, not below {} at {:.3} mm",
                    1e3 * height,
                    if cutter.toprem.is_some() {
                        "the end of the Toprem"
                    } else {
                        "the tip of the tooth"
                    },
                    1e3 * limit
                ),
                None => "no edge of this `edge_radius` is tangent to the blade".into(),
            },
            "take a smaller edge_radius",
        ),
    };
    let message = format!("cutter of the {side} flank of `{member}`: {what}");
    Err(Error::new(Code::OutOfRange, message)
        .with_span(span)
        .with_hint(hint))
}
