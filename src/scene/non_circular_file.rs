//! Reads a gear file of non-circular gears: `pair`, `ratio`, `rack`, `pinion`, `gear`.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::gear_file::rack;
use super::number_table::NumberTable;
use super::shared_keys::{DEFAULT_PRESSURE_ANGLE, PRESSURE_ANGLE_RANGE};
use super::tables::{read_heading, read_table};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::error_collector::{ErrorCollector, ValueRange};
use crate::base::flags::Flags;
use crate::base::quantity_kind::QuantityKind;
use crate::base::source_span::{SourceFile, SourceSpan};
use crate::base::table_reader::{TableReader, Word};
use crate::base::toml;
use crate::gear::cylindrical::basic_rack::BasicRack;
use crate::gear::plane::centrodes::Mate;
use crate::gear::plane::profile::Shape;
use crate::gear::plane::rack_cutter::RackCutter;
use crate::gear::plane::ratio_law::RatioLaw;
use crate::numeric::Complex;

/// Gears of a varying ratio as their file describes them.
#[derive(Debug, Clone)]
pub struct NonCircularFile {
    /// Title in the file.
    pub title: String,
    /// Kind of the ratio.
    pub ratio: RatioKind,
    /// Ratio function `i₁₂(φ₁)`.
    pub law: RatioLaw,
    /// Centre distance, m.
    pub centre_distance: f64,
    /// Kind of the mate.
    pub mate: Mate,
    /// Numbers of teeth of pinion and gear; outlines need both.
    pub teeth: Option<[u32; 2]>,
    /// Flanks of the pinion.
    pub profile: PinionProfile,
    /// Route from the pinion's flanks to the gear's.
    pub route: ConjugateRoute,
    /// Place of `pair`.
    pub span: SourceSpan,
    /// Place of the pinion's profile.
    pub profile_span: SourceSpan,
    /// The file, and the tables it names.
    pub sources: Vec<Arc<SourceFile>>,
}

/// Kind of a ratio function.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RatioKind {
    /// The same ratio at all angles.
    Constant,
    /// From one ratio to another over an angle.
    Linear,
    /// Two equal ellipses about foci.
    Elliptic,
    /// A mean and an amplitude.
    Sine,
    /// Angles of both gears in a CSV file.
    Table,
}

impl Word for RatioKind {
    const WORDS: &'static [(&'static str, RatioKind, &'static str)] = &[
        ("constant", RatioKind::Constant, "i₁₂ = ratio"),
        (
            "linear",
            RatioKind::Linear,
            "from first to last over an angle",
        ),
        (
            "elliptic",
            RatioKind::Elliptic,
            "two equal ellipses about foci",
        ),
        ("sine", RatioKind::Sine, "mean + amplitude sin(cycles φ₁)"),
        (
            "table",
            RatioKind::Table,
            "angles of both gears from a file",
        ),
    ];
}

/// Flanks of the pinion.
#[derive(Debug, Clone)]
pub enum PinionProfile {
    /// Cut by a rack.
    Rack(RackCutter),
    /// Drawn by a point of a circle that rolls on the centrode: its radius (m, positive outside the pinion), and the arcs rolled (m).
    Rolling {
        /// Radius, m.
        radius: f64,
        /// First and last arc, m.
        arcs: [f64; 2],
    },
    /// A curve of the pinion's frame, in which the pitch point lies on the x axis at φ₁ = 0.
    Curve(Shape),
}

/// Routes to a conjugate profile.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ConjugateRoute {
    /// Willis' law: the normal passes through the pitch point.
    Normals,
    /// The kernel's equation of meshing.
    Envelope,
    /// Points of the path of contact, integrated.
    LineOfAction,
}

impl Word for ConjugateRoute {
    const WORDS: &'static [(&'static str, ConjugateRoute, &'static str)] = &[
        (
            "normals",
            ConjugateRoute::Normals,
            "normals through the pitch point",
        ),
        ("envelope", ConjugateRoute::Envelope, "equation of meshing"),
        (
            "line-of-action",
            ConjugateRoute::LineOfAction,
            "integral along the path of contact",
        ),
    ];
}

/// Most teeth: each is cut by itself.
const MAX_CUT_TEETH: u32 = 1000;

/// Reads one; no flag of a load applies.
///
/// # Errors
/// Everything wrong in it, in its tables and in the flags.
pub fn read(source: &Arc<SourceFile>, flags: &Flags) -> Result<NonCircularFile, Errors> {
    flags.read("a non-circular pair", None, &[], |_| ())?;
    let document = toml::parse(source);
    let mut errors = ErrorCollector::default();
    errors.record_units(&document);
    let span = SourceSpan::new(source.clone(), 0..0);
    let mut f = TableReader::new(&document.root, span, "the gear file", &mut errors);
    let title = read_heading(&mut f);
    let (span, ratio_span) = (f.span_of("pair").clone(), f.span_of("ratio").clone());
    let profile_span = f.span_of("pinion").clone();
    let centre_distance = read_table(&mut f, "pair", pair).flatten();
    let ratio = read_table(&mut f, "ratio", ratio).flatten();
    f.require("ratio");
    let rack_table = read_table(&mut f, "rack", rack);
    let first = read_table(&mut f, "pinion", pinion);
    let second = read_table(&mut f, "gear", gear).unwrap_or_default();
    f.finish();
    let mut errors = errors.errors;
    errors.extend(document.syntax_error);
    Errors::into_result(errors, || ())?;
    let missing = || Error::new(Code::MissingKey, "the gears are not described").with_span(&span);
    let ratio = ratio.ok_or_else(missing)?;
    let folder = Path::new(&source.path).parent().unwrap_or(Path::new(""));
    let mut sources = vec![source.clone()];
    let law = match &ratio {
        RatioTable::Table(path) => {
            let names = ["angle_1", "angle_2"];
            let table = NumberTable::read(&folder.join(path), &names, QuantityKind::Angle)?;
            sources.push(table.source.clone());
            RatioLaw::table(&table.columns[0], &table.columns[1]).map_err(|e| table.locate(e))?
        }
        other => other.law().map_err(|e| e.with_span(&ratio_span))?,
    };
    let first = first.unwrap_or_default();
    let profile = match first
        .profile
        .unwrap_or(ProfileTable::Rack(DEFAULT_PRESSURE_ANGLE))
    {
        ProfileTable::Rack(pressure_angle) => {
            PinionProfile::Rack(cutter(rack_table, pressure_angle, source)?)
        }
        ProfileTable::Rolling { radius, arcs } => PinionProfile::Rolling { radius, arcs },
        ProfileTable::Points(path) => {
            let table = NumberTable::read(&folder.join(path), &["x", "y"], QuantityKind::Length)?;
            sources.push(table.source.clone());
            let points = table.columns[0].iter().zip(&table.columns[1]);
            let points: Vec<Complex> = points.map(|(x, y)| Complex::new(*x, *y)).collect();
            PinionProfile::Curve(Shape::points(&points).map_err(|e| table.locate(e))?)
        }
        ProfileTable::Arc {
            radius,
            centre: [x, y],
            directions,
        } => {
            let shape = Shape::arc(Complex::new(x, y), radius, directions);
            PinionProfile::Curve(shape.map_err(|e| e.with_span(&profile_span))?)
        }
        ProfileTable::Cycloid { radius, angles } => {
            let RatioTable::Constant(i12) = ratio else {
                let message = "a cycloid belongs to a circular gear, and the ratio varies";
                return Err(Error::new(Code::Conflict, message)
                    .with_span(&profile_span)
                    .with_hint("take kind = \"rolling\", whose circle rolls on any centrode")
                    .into());
            };
            let sense = if second.internal { -1.0 } else { 1.0 };
            let pitch_radius = centre_distance.unwrap_or(f64::NAN) / (i12 + sense);
            let shape = Shape::cycloid(pitch_radius, radius, 0.0, angles);
            PinionProfile::Curve(shape.map_err(|e| e.with_span(&profile_span))?)
        }
    };
    Ok(NonCircularFile {
        title,
        ratio: ratio.kind(),
        law,
        centre_distance: centre_distance.ok_or_else(missing)?,
        mate: match second.internal {
            true => Mate::Internal,
            false => Mate::External,
        },
        teeth: first.teeth.zip(second.teeth).map(|(a, b)| [a, b]),
        profile,
        route: second.route.unwrap_or(ConjugateRoute::Normals),
        span,
        profile_span,
        sources,
    })
}

fn pair(f: &mut TableReader) -> Option<f64> {
    f.choice("kind", &[("non-circular", ())]);
    let distance = f.optional_quantity(
        "centre_distance",
        QuantityKind::Length,
        ValueRange::Positive,
    );
    f.require("centre_distance");
    distance
}

/// `ratio` as written.
enum RatioTable {
    Constant(f64),
    Linear {
        first: f64,
        last: f64,
        over: f64,
    },
    Elliptic(f64),
    Sine {
        mean: f64,
        amplitude: f64,
        cycles: u32,
    },
    Table(PathBuf),
}

impl RatioTable {
    fn kind(&self) -> RatioKind {
        match self {
            RatioTable::Constant(_) => RatioKind::Constant,
            RatioTable::Linear { .. } => RatioKind::Linear,
            RatioTable::Elliptic(_) => RatioKind::Elliptic,
            RatioTable::Sine { .. } => RatioKind::Sine,
            RatioTable::Table(_) => RatioKind::Table,
        }
    }

    fn law(&self) -> Result<RatioLaw, Error> {
        match *self {
            RatioTable::Constant(ratio) => RatioLaw::constant(ratio),
            RatioTable::Linear { first, last, over } => RatioLaw::linear(first, last, over),
            RatioTable::Elliptic(eccentricity) => RatioLaw::elliptic(eccentricity),
            RatioTable::Sine {
                mean,
                amplitude,
                cycles,
            } => RatioLaw::sine(mean, amplitude, cycles),
            RatioTable::Table(_) => Err(Error::new(Code::MissingKey, "the table is not read")),
        }
    }
}

fn ratio(f: &mut TableReader) -> Option<RatioTable> {
    let number = |f: &mut TableReader, key: &str| {
        let value = f.optional_number(key, ValueRange::Any);
        f.require(key);
        value
    };
    let kind = f.word("kind");
    f.require("kind");
    Some(match kind? {
        RatioKind::Constant => RatioTable::Constant(number(f, "ratio")?),
        RatioKind::Elliptic => RatioTable::Elliptic(number(f, "eccentricity")?),
        RatioKind::Linear => {
            let (first, last) = (number(f, "first"), number(f, "last"));
            let over = f.optional_quantity("over", QuantityKind::Angle, ValueRange::Positive);
            f.require("over");
            RatioTable::Linear {
                first: first?,
                last: last?,
                over: over?,
            }
        }
        RatioKind::Sine => {
            let (mean, amplitude) = (number(f, "mean"), number(f, "amplitude"));
            let cycles = f.optional_count("cycles", 1, 1000);
            f.require("cycles");
            RatioTable::Sine {
                mean: mean?,
                amplitude: amplitude?,
                cycles: cycles?,
            }
        }
        RatioKind::Table => {
            let file = f.optional_text("file").map(PathBuf::from);
            f.require("file");
            RatioTable::Table(file?)
        }
    })
}

/// `pinion` as written.
#[derive(Default)]
struct PinionTable {
    teeth: Option<u32>,
    profile: Option<ProfileTable>,
}

/// `profile` of the pinion as written.
enum ProfileTable {
    Rack(f64),
    Rolling {
        radius: f64,
        arcs: [f64; 2],
    },
    Cycloid {
        radius: f64,
        angles: [f64; 2],
    },
    Arc {
        radius: f64,
        centre: [f64; 2],
        directions: [f64; 2],
    },
    Points(PathBuf),
}

fn pinion(f: &mut TableReader) -> PinionTable {
    PinionTable {
        teeth: f.optional_count("teeth", 3, MAX_CUT_TEETH),
        profile: read_table(f, "profile", profile).flatten(),
    }
}

#[derive(Clone, Copy)]
enum ProfileKind {
    Rack,
    Rolling,
    Cycloid,
    Arc,
    Points,
    Shaper,
}

fn profile(f: &mut TableReader) -> Option<ProfileTable> {
    let kinds = [
        ("rack", ProfileKind::Rack),
        ("rolling", ProfileKind::Rolling),
        ("cycloid", ProfileKind::Cycloid),
        ("circular-arc", ProfileKind::Arc),
        ("points", ProfileKind::Points),
        ("shaper", ProfileKind::Shaper),
    ];
    let kind = f.choice("kind", &kinds);
    f.require("kind");
    let two = |f: &mut TableReader, key: &str, kind: QuantityKind| -> Option<[f64; 2]> {
        let values = f.optional_quantities(key, kind, ValueRange::Any, Some(2));
        f.require(key);
        values?.try_into().ok()
    };
    Some(match kind? {
        ProfileKind::Rack => {
            let angle =
                f.optional_quantity("pressure_angle", QuantityKind::Angle, PRESSURE_ANGLE_RANGE);
            ProfileTable::Rack(angle.unwrap_or(DEFAULT_PRESSURE_ANGLE))
        }
        ProfileKind::Rolling => {
            let radius = f.quantity("radius", QuantityKind::Length, ValueRange::Any);
            let arcs = two(f, "arcs", QuantityKind::Length);
            ProfileTable::Rolling {
                radius,
                arcs: arcs?,
            }
        }
        ProfileKind::Cycloid => {
            let radius = f.quantity("rolling_radius", QuantityKind::Length, ValueRange::Any);
            let angles = two(f, "angles", QuantityKind::Angle);
            ProfileTable::Cycloid {
                radius,
                angles: angles?,
            }
        }
        ProfileKind::Arc => {
            let radius = f.quantity("radius", QuantityKind::Length, ValueRange::NotNegative);
            let centre = two(f, "centre", QuantityKind::Length);
            let directions = two(f, "directions", QuantityKind::Angle);
            ProfileTable::Arc {
                radius,
                centre: centre?,
                directions: directions?,
            }
        }
        ProfileKind::Points => {
            let file = f.optional_text("file").map(PathBuf::from);
            f.require("file");
            ProfileTable::Points(file?)
        }
        ProfileKind::Shaper => {
            let message = "a shaper is not taken: outlines are cut by a rack only";
            let hint = "take kind = \"rack\", or give the flank as points";
            f.report_key(Code::OutOfRange, "kind", message, hint);
            return None;
        }
    })
}

/// `gear` as written.
#[derive(Default)]
struct GearTable {
    teeth: Option<u32>,
    internal: bool,
    route: Option<ConjugateRoute>,
}

fn gear(f: &mut TableReader) -> GearTable {
    GearTable {
        teeth: f.optional_count("teeth", 3, MAX_CUT_TEETH),
        internal: f.flag("internal"),
        route: read_table(f, "profile", conjugate).flatten(),
    }
}

fn conjugate(f: &mut TableReader) -> Option<ConjugateRoute> {
    f.choice("kind", &[("conjugate", ())]);
    f.require("kind");
    f.word("by")
}

/// The rack as a cutter; a protuberance is refused.
fn cutter(
    rack: Option<BasicRack>,
    pressure_angle: f64,
    source: &Arc<SourceFile>,
) -> Result<RackCutter, Error> {
    let rack = rack.unwrap_or(BasicRack::PROFILE_A);
    if rack.protuberance != 0.0 {
        let message = "the rack of a non-circular pair has no protuberance";
        return Err(Error::new(Code::OutOfRange, message)
            .with_span(&SourceSpan::whole_file(&source.path))
            .with_hint("leave `protuberance` out of `rack`"));
    }
    Ok(RackCutter {
        pressure_angle,
        addendum: rack.addendum,
        dedendum: rack.dedendum,
        tip_radius: rack.tip_radius,
    })
}
