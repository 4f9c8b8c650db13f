//! Reads a gear file of non-circular gears: `pair`, `ratio`, `rack`, `pinion`, `gear`.

use std::f64::consts::FRAC_PI_2;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::csv_table::CsvTable;
use super::gear_member::rack;
use super::shared_keys::{DEFAULT_PRESSURE_ANGLE, PRESSURE_ANGLE_RANGE};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::error_collector::ValueRange;
use crate::base::flags::Flags;
use crate::base::quantity_kind::QuantityKind;
use crate::base::source_span::{SourceFile, SourceSpan};
use crate::base::table_reader::{TableReader, Word};
use crate::base::tables::{read_file, read_heading, read_table};
use crate::base::toml;
use crate::gear::cylindrical::basic_rack::BasicRack;
use crate::gear::plane::centrodes::Mate;
use crate::gear::plane::conjugate_flank::ConjugateRoute;
use crate::gear::plane::pitch_curve::PitchCurve;
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
    /// Flanks of the gear.
    pub gear_profile: GearProfile,
    /// Place of `pair`.
    pub span: SourceSpan,
    /// Place of `ratio`.
    pub ratio_span: SourceSpan,
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
    /// Pitch curve of the pinion in a CSV file.
    PitchCurve,
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
        (
            "pitch-curve",
            RatioKind::PitchCurve,
            "pitch curve of the pinion from a file",
        ),
    ];
}

/// Flanks of the pinion.
#[derive(Debug, Clone)]
pub enum PinionProfile {
    /// Cut by a rack.
    Rack(RackCutter),
    /// Drawn by a curve that a circle carries as it rolls on the centrode (Camus).
    Rolling {
        /// Radius of the circle, m, positive outside the pinion.
        radius: f64,
        /// The curve in the frame of the circle, in which the pitch point lies at −radius on the x axis.
        curve: Shape,
    },
    /// A curve of the pinion's frame, in which the pitch point lies on the x axis at φ₁ = 0.
    Curve(Shape),
}

/// Flanks of the gear.
#[derive(Debug, Clone)]
pub enum GearProfile {
    /// The conjugate of the pinion's.
    Conjugate(ConjugateRoute),
    /// A given curve of the gear's frame, which is parallel to the pinion's at φ₁ = 0: the pair is checked by the law of gearing.
    Given(Shape),
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
pub const MAX_CUT_TEETH: u32 = 1000;

/// Reads one; no flag of a load applies.
///
/// # Errors
/// Everything wrong in it, in its tables and in the flags.
pub fn read(source: &Arc<SourceFile>, flags: &Flags) -> Result<NonCircularFile, Errors> {
    flags.read("a non-circular pair", None, &[], |_| ())?;
    let (title, spans, tables) = read_file(source, "the gear file", |f| {
        let title = read_heading(f);
        let spans = ["pair", "ratio", "pinion"].map(|key| f.span_of(key).clone());
        let stated_distance = read_table(f, "pair", pair).flatten();
        let ratio = read_table(f, "ratio", ratio).flatten();
        f.require("ratio");
        let rack_table = read_table(f, "rack", rack);
        let first = read_table(f, "pinion", pinion);
        let second = read_table(f, "gear", gear).unwrap_or_default();
        (
            title,
            spans,
            (stated_distance, ratio, rack_table, first, second),
        )
    })?;
    let [span, ratio_span, profile_span] = spans;
    let (stated_distance, ratio, rack_table, first, second) = tables;
    let missing = || Error::new(Code::MissingKey, "the gears are not described").with_span(&span);
    let ratio = ratio.ok_or_else(missing)?;
    let folder = Path::new(&source.path).parent().unwrap_or(Path::new(""));
    let mut sources = vec![source.clone()];
    let mut closed_distance = None;
    let law = match &ratio {
        RatioTable::Table(path) => {
            let names = ["angle_1", "angle_2"].map(|name| (name, QuantityKind::Angle));
            let table = read_numbers(&folder.join(path), &names, &ratio_span)?;
            sources.push(table.source.clone());
            RatioLaw::table(&table.columns[0], &table.columns[1]).map_err(|e| table.locate(e))?
        }
        RatioTable::PitchCurve { path, lobes } => {
            let names = [
                ("angle_1", QuantityKind::Angle),
                ("radius_1", QuantityKind::Length),
            ];
            let table = read_numbers(&folder.join(path), &names, &ratio_span)?;
            sources.push(table.source.clone());
            let curve = PitchCurve::table(&table.columns[0], &table.columns[1]);
            let curve = curve.map_err(|e| table.locate(e))?;
            let closing = || curve.closing_centre_distance(*lobes);
            let distance = match stated_distance {
                Some(distance) => distance,
                None => closing().map_err(|e| e.with_span(&ratio_span))?,
            };
            closed_distance = Some(distance);
            RatioLaw::of_pitch_curve(&curve, distance).map_err(|e| e.with_span(&ratio_span))?
        }
        other => other.law().map_err(|e| e.with_span(&ratio_span))?,
    };
    let Some(centre_distance) = stated_distance.or(closed_distance) else {
        let message = "the pair has no `centre_distance`";
        return Err(Error::new(Code::MissingKey, message)
            .with_span(&span)
            .with_hint("give it, or a ratio of kind = \"pitch-curve\", whose mate closes at one")
            .into());
    };
    let first = first.unwrap_or_default();
    let mut read_curve = |table: CurveTable| match table {
        CurveTable::Points(path) => {
            let names = ["x", "y"].map(|name| (name, QuantityKind::Length));
            let table = read_numbers(&folder.join(path), &names, &profile_span)?;
            sources.push(table.source.clone());
            let points = table.columns[0].iter().zip(&table.columns[1]);
            let points: Vec<Complex> = points.map(|(x, y)| Complex::new(*x, *y)).collect();
            Ok::<Shape, Errors>(Shape::points(&points).map_err(|e| table.locate(e))?)
        }
        CurveTable::Arc {
            radius,
            centre: [x, y],
            directions,
        } => {
            let shape = Shape::arc(Complex::new(x, y), radius, directions);
            Ok(shape.map_err(|e| e.with_span(&profile_span))?)
        }
    };
    let profile = match first
        .profile
        .unwrap_or(ProfileTable::Rack(DEFAULT_PRESSURE_ANGLE))
    {
        ProfileTable::Rack(pressure_angle) => {
            PinionProfile::Rack(cutter(rack_table, pressure_angle, source)?)
        }
        ProfileTable::Rolling { radius, carried } => PinionProfile::Rolling {
            radius,
            curve: carried
                .curve(radius)
                .map_err(|e| e.with_span(&profile_span))?,
        },
        ProfileTable::Curve(table) => PinionProfile::Curve(read_curve(table)?),
        ProfileTable::Cycloid { radius, angles } => {
            let RatioTable::Constant(i12) = ratio else {
                let message = "a cycloid needs a circular gear, but the ratio varies";
                return Err(Error::new(Code::Conflict, message)
                    .with_span(&profile_span)
                    .with_hint("use kind = \"rolling\", whose circle rolls on any centrode")
                    .into());
            };
            let sense = if second.internal { -1.0 } else { 1.0 };
            let pitch_radius = centre_distance / (i12 + sense);
            let shape = Shape::cycloid(pitch_radius, radius, 0.0, angles);
            PinionProfile::Curve(shape.map_err(|e| e.with_span(&profile_span))?)
        }
    };
    let gear_profile = match second.profile {
        None => GearProfile::Conjugate(ConjugateRoute::Normals),
        Some(GearProfileTable::Conjugate(route)) => {
            GearProfile::Conjugate(route.unwrap_or(ConjugateRoute::Normals))
        }
        Some(GearProfileTable::Given(table)) => match profile {
            PinionProfile::Curve(_) => GearProfile::Given(read_curve(table)?),
            _ => {
                let message = "a given flank of the gear needs a given flank of the pinion";
                return Err(Error::new(Code::Conflict, message)
                    .with_span(&profile_span)
                    .with_hint("give the pinion's flank as points, circular-arc or cycloid")
                    .into());
            }
        },
    };
    Ok(NonCircularFile {
        title,
        ratio: ratio.kind(),
        law,
        centre_distance,
        mate: match second.internal {
            true => Mate::Internal,
            false => Mate::External,
        },
        teeth: first.teeth.zip(second.teeth).map(|(a, b)| [a, b]),
        profile,
        gear_profile,
        span,
        ratio_span,
        profile_span,
        sources,
    })
}

/// The columns of a file that a table of the gear file names at `span`; its path starts there.
fn read_numbers(
    path: &Path,
    names: &[(&str, QuantityKind)],
    span: &SourceSpan,
) -> Result<CsvTable, Errors> {
    if !path.is_file() {
        let message = format!("there is no file {}", path.display());
        let error = Error::new(Code::FileMissing, message).with_span(span);
        let hint = "`file` is relative to the folder of the gear file";
        return Err(error.with_hint(hint).into());
    }
    CsvTable::read(path, names)
}

fn pair(f: &mut TableReader) -> Option<f64> {
    f.choice("kind", &[("non-circular", ())]);
    f.optional_quantity(
        "centre_distance",
        QuantityKind::Length,
        ValueRange::Positive,
    )
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
    PitchCurve {
        path: PathBuf,
        lobes: u32,
    },
}

impl RatioTable {
    fn kind(&self) -> RatioKind {
        match self {
            RatioTable::Constant(_) => RatioKind::Constant,
            RatioTable::Linear { .. } => RatioKind::Linear,
            RatioTable::Elliptic(_) => RatioKind::Elliptic,
            RatioTable::Sine { .. } => RatioKind::Sine,
            RatioTable::Table(_) => RatioKind::Table,
            RatioTable::PitchCurve { .. } => RatioKind::PitchCurve,
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
            RatioTable::Table(_) | RatioTable::PitchCurve { .. } => {
                Err(Error::new(Code::MissingKey, "the table is not read"))
            }
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
        RatioKind::Elliptic => {
            let range = ValueRange::HalfOpen(0.0, 1.0, "at least 0 and below 1");
            let eccentricity = f.optional_number("eccentricity", range);
            f.require("eccentricity");
            RatioTable::Elliptic(eccentricity?)
        }
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
        RatioKind::PitchCurve => {
            let file = f.optional_text("file").map(PathBuf::from);
            f.require("file");
            let lobes = f.optional_count("lobes", 1, 1000);
            RatioTable::PitchCurve {
                path: file?,
                lobes: lobes.unwrap_or(1),
            }
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
    Rolling { radius: f64, carried: CarriedCurve },
    Cycloid { radius: f64, angles: [f64; 2] },
    Curve(CurveTable),
}

/// A curve of a gear's frame as written.
enum CurveTable {
    Arc {
        radius: f64,
        centre: [f64; 2],
        directions: [f64; 2],
    },
    Points(PathBuf),
}

/// Curve of a rolling circle: its point at the pitch point over arcs, or an arc about a point of its frame.
enum CarriedCurve {
    Point {
        arcs: [f64; 2],
    },
    Arc {
        radius: f64,
        centre_radius: f64,
        directions: [f64; 2],
    },
}

impl CarriedCurve {
    /// The curve in the frame of a circle of a radius (m).
    fn curve(&self, circle: f64) -> Result<Shape, Error> {
        match *self {
            CarriedCurve::Point { arcs } => {
                // The point starts at the pitch point; its normal turns by half the angle of the circle.
                let [from, to] = arcs.map(|arc| FRAC_PI_2 - 0.5 * arc / circle);
                let start = Complex::new(-circle, 0.0);
                Shape::arc(start, 0.0, [from.min(to), from.max(to)])
            }
            CarriedCurve::Arc {
                radius,
                centre_radius,
                directions,
            } => {
                let centre = Complex::new(-circle.signum() * centre_radius, 0.0);
                Shape::arc(centre, radius, directions)
            }
        }
    }
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
    Conjugate,
}

/// Two values of a key.
fn two(f: &mut TableReader, key: &str, kind: QuantityKind) -> Option<[f64; 2]> {
    let values = f.optional_quantities(key, kind, ValueRange::Any, Some(2));
    f.require(key);
    values?.try_into().ok()
}

fn arc(f: &mut TableReader) -> Option<CurveTable> {
    let radius = f.quantity("radius", QuantityKind::Length, ValueRange::NotNegative);
    let centre = two(f, "centre", QuantityKind::Length);
    let directions = two(f, "directions", QuantityKind::Angle);
    Some(CurveTable::Arc {
        radius,
        centre: centre?,
        directions: directions?,
    })
}

fn points(f: &mut TableReader) -> Option<CurveTable> {
    let file = f.optional_text("file").map(PathBuf::from);
    f.require("file");
    file.map(CurveTable::Points)
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
    Some(match kind? {
        ProfileKind::Rack => {
            let angle =
                f.optional_quantity("pressure_angle", QuantityKind::Angle, PRESSURE_ANGLE_RANGE);
            ProfileTable::Rack(angle.unwrap_or(DEFAULT_PRESSURE_ANGLE))
        }
        ProfileKind::Rolling => {
            let radius = f.quantity("radius", QuantityKind::Length, ValueRange::Any);
            if radius == 0.0 {
                let message = "`radius` of the rolling circle is 0";
                let hint = "give a positive radius outside the pinion, a negative one inside";
                f.report_key(Code::OutOfRange, "radius", message, hint);
            }
            f.exclusive("arcs", "arc_radius");
            let carried = match f.has("arc_radius") {
                false => {
                    let arcs = two(f, "arcs", QuantityKind::Length);
                    CarriedCurve::Point { arcs: arcs? }
                }
                true => {
                    let length = |f: &mut TableReader, key, range| {
                        f.quantity(key, QuantityKind::Length, range)
                    };
                    let arc = length(f, "arc_radius", ValueRange::NotNegative);
                    let centre_radius = length(f, "centre_radius", ValueRange::Positive);
                    let directions = two(f, "directions", QuantityKind::Angle);
                    CarriedCurve::Arc {
                        radius: arc,
                        centre_radius,
                        directions: directions?,
                    }
                }
            };
            ProfileTable::Rolling { radius, carried }
        }
        ProfileKind::Cycloid => {
            let radius = f.quantity("rolling_radius", QuantityKind::Length, ValueRange::Any);
            let angles = two(f, "angles", QuantityKind::Angle);
            ProfileTable::Cycloid {
                radius,
                angles: angles?,
            }
        }
        ProfileKind::Arc => ProfileTable::Curve(arc(f)?),
        ProfileKind::Points => ProfileTable::Curve(points(f)?),
        ProfileKind::Shaper | ProfileKind::Conjugate => {
            let message = "a shaper is not supported: outlines are cut by a rack only";
            let hint = "use kind = \"rack\", or give the flank as points";
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
    profile: Option<GearProfileTable>,
}

/// `profile` of the gear as written.
enum GearProfileTable {
    Conjugate(Option<ConjugateRoute>),
    Given(CurveTable),
}

fn gear(f: &mut TableReader) -> GearTable {
    GearTable {
        teeth: f.optional_count("teeth", 3, MAX_CUT_TEETH),
        internal: f.flag("internal"),
        profile: read_table(f, "profile", gear_profile).flatten(),
    }
}

fn gear_profile(f: &mut TableReader) -> Option<GearProfileTable> {
    let kinds = [
        ("conjugate", ProfileKind::Conjugate),
        ("circular-arc", ProfileKind::Arc),
        ("points", ProfileKind::Points),
    ];
    let kind = f.choice("kind", &kinds);
    f.require("kind");
    Some(match kind? {
        ProfileKind::Arc => GearProfileTable::Given(arc(f)?),
        ProfileKind::Points => GearProfileTable::Given(points(f)?),
        _ => GearProfileTable::Conjugate(f.word("by")),
    })
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
            .with_span(
                (toml::parse(source).root.place("rack.protuberance"))
                    .unwrap_or(&SourceSpan::whole_file(&source.path)),
            )
            .with_hint("omit `protuberance` of `rack`"));
    }
    Ok(RackCutter {
        pressure_angle,
        addendum: rack.addendum,
        dedendum: rack.dedendum,
        tip_radius: rack.tip_radius,
    })
}
