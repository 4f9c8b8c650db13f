//! Loaded contact in space: elliptic Hertz, half spaces of a spiral bevel pair, unloaded limit, convergence.

use geardyn::internals::base::flags::Flags;
use geardyn::internals::base::load;
use geardyn::internals::gear::contact::contact_path::{ContactPath, PITCHES};
use geardyn::internals::gear::contact::pair::FlankPair;
use geardyn::internals::gear::load::bevel_teeth::BevelTeeth;
use geardyn::internals::gear::load::contact_line::{ContactCell, ContactLine};
use geardyn::internals::gear::load::elliptic_contact::{EllipticContact, greatest_shear};
use geardyn::internals::gear::load::flank_mesh::{FlankMesh, FlankMeshOptions};
use geardyn::internals::gear::load::flank_position::ToothBending;
use geardyn::internals::gear::load::flank_result::FlankMeshResult;
use geardyn::internals::gear::load::loaded_lines::{LineLoads, LoadedLines};
use geardyn::internals::gear::load::material::Material;
use geardyn::internals::gear::load::tooth_plate::{PlateShape, ToothPlate};
use geardyn::internals::numeric::statistics::peak_to_peak;
use geardyn::internals::plan::gear::bevel;
use geardyn::internals::scene::bevel_file;

use crate::contact::pair;
use crate::verification::within;

pub const STEEL: [Material; 2] = [Material {
    young: 206e9,
    poisson: 0.3,
}; 2];

/// Curvatures 1/mm, force N; semi-axes mm, greatest pressure N/mm², approach µm.
const ELLIPTIC: [[f64; 7]; 6] = [
    [
        0.02,
        0.05,
        1000.0,
        0.796072623,
        0.433167587,
        1384.626838,
        11.0281702,
    ],
    [
        0.01,
        0.05,
        1000.0,
        1.095884119,
        0.379174904,
        1149.045344,
        9.5991502,
    ],
    [
        0.004,
        0.08,
        1000.0,
        1.705893475,
        0.246207537,
        1136.810652,
        8.2448712,
    ],
    [
        0.0006,
        0.0645,
        1000.0,
        3.606334760,
        0.190071558,
        696.559492,
        5.0667972,
    ],
    [
        0.0002,
        0.08,
        1000.0,
        5.566281855,
        0.137569457,
        623.525428,
        3.8553636,
    ],
    [
        0.00002,
        0.08,
        1000.0,
        13.136846032,
        0.089592697,
        405.674460,
        2.0468413,
    ],
];

/// Elliptic contact of steel at six aspect ratios.
/// Source: Johnson, Contact Mechanics, 1985, eq. 4.26, evaluated with elliptic integrals to 9 digits.
#[test]
fn ref_elliptic_contact() {
    for [k1, k2, force, a, b, p0, approach] in ELLIPTIC {
        let found = EllipticContact::new([1e3 * k1, 1e3 * k2], force, &STEEL).unwrap();
        let [long, short] = found.semi_axes.map(|x| 1e3 * x);
        within(
            "semi-axes",
            (long / a - 1.0).abs().max((short / b - 1.0).abs()),
            1e-8,
        );
        within(
            "greatest pressure",
            (1e-6 * found.pressure / p0 - 1.0).abs(),
            1e-8,
        );
        within(
            "approach",
            (1e6 * found.approach / approach - 1.0).abs(),
            1e-8,
        );
    }
}

/// A line of cells along the longer axis of an elliptic contact.
fn strip(k1: f64, k2: f64, half: usize, length: f64) -> LoadedLines {
    let n = 2 * half + 1;
    let cell = |i: usize| {
        let along = (i as f64 - half as f64) * length;
        ContactCell {
            along,
            length,
            gap: 0.5 * k1 * along * along,
            arm: 1.0,
            curvature: k2,
            on_edge: false,
            ellipse: None,
            teeth: None,
        }
    };
    let line = ContactLine {
        pair: 0,
        cells: (0..n).map(cell).collect(),
    };
    LoadedLines::new(vec![line], STEEL)
}

fn largest_pressure(lines: &LoadedLines, loads: &LineLoads) -> f64 {
    let pressures = lines.lines.iter().enumerate().flat_map(|(k, line)| {
        let cells = line.cells.iter().enumerate();
        cells.map(move |(i, cell)| {
            LoadedLines::pressure(cell, loads.forces[k][i], loads.widths[k][i])
        })
    });
    pressures.fold(0.0, f64::max)
}

/// Strips of half spaces with cells of 1.2 half widths against the elliptic contact: approach and greatest pressure from a/b 2.9 on.
/// Source: Johnson, Contact Mechanics, 1985, eq. 4.26.
#[test]
fn ref_strips_reach_elliptic_contact() {
    // A contact of a/b 2.9 has five cells: half a cell of place moves the approach by 1 %, the pressure by 2 %.
    let limits = [
        [0.018, 0.013],
        [0.003, 0.012],
        [0.002, 0.002],
        [0.002, 0.002],
        [0.002, 0.002],
    ];
    for ([k1, k2, force, a, b, p0, approach], [of_approach, of_pressure]) in
        ELLIPTIC[1..].iter().zip(limits)
    {
        let length = 1.2e-3 * b;
        let half = (1.5e-3 * a / length).ceil() as usize;
        let lines = strip(1e3 * k1, 1e3 * k2, half, length);
        let loads = lines.solve(*force, None).unwrap();
        let pressure = 1e-6 * largest_pressure(&lines, &loads) / p0 - 1.0;
        let turn = 1e6 * loads.turn / approach - 1.0;
        println!(
            "a/b {:.2}: approach {turn:.5}, pressure {pressure:.5}, sweeps {}",
            a / b,
            loads.sweeps
        );
        within(
            &format!("approach at a/b {:.1}", a / b),
            turn.abs(),
            of_approach,
        );
        within(
            &format!("greatest pressure at a/b {:.1}", a / b),
            pressure.abs(),
            of_pressure,
        );
    }
}

/// Inches in place of metres: the pair of the case has its lengths in inches.
const PER_INCH: f64 = 0.0254;

/// The drive pair with its path, lengths in inches.
fn drive() -> (FlankPair, ContactPath) {
    let pair = pair([0.0, 0.02, 0.0, 0.0]);
    let path = pair.path(pair.first_contact().unwrap(), PITCHES, 60);
    (pair, path)
}

/// Steel for lengths in inches: Pa becomes N/in².
fn options(stations: usize) -> FlankMeshOptions {
    let young = 206e9 * PER_INCH * PER_INCH;
    FlankMeshOptions {
        materials: [Material {
            young,
            poisson: 0.3,
        }; 2],
        stations,
        ..FlankMeshOptions::default()
    }
}

fn arcsec(te: f64) -> f64 {
    te.to_degrees() * 3600.0
}

/// The 12/36 pair on half spaces: turn of the gear, greatest pressure and shares over the torque.
/// Source: strips along the ridge by another program, checked against elliptic contact, data/reference/gear/c28_ltca_half_space_12_36.json.
#[test]
fn ref_half_space_contact_of_spiral_bevel_pair() {
    let (pair, path) = drive();
    let mesh = FlankMesh::new(&pair, &path, options(48), None);
    let position = mesh.position(0.022204143253384).unwrap();
    for [torque, turn, pressure, before, middle, after] in C28 {
        let loads = position.lines.solve(3.0 * torque / PER_INCH, None).unwrap();
        let mut most = 0f64;
        let mut shares = [0.0; 3];
        for (k, line) in position.lines.lines.iter().enumerate() {
            for (i, cell) in line.cells.iter().enumerate() {
                let (force, width) = (loads.forces[k][i], loads.widths[k][i]);
                if !cell.on_edge {
                    most = most.max(LoadedLines::pressure(cell, force, width));
                }
                if let Some(share) = shares.get_mut((line.pair + 1) as usize) {
                    *share += force * cell.arm / (3.0 * torque / PER_INCH);
                }
            }
        }
        let most = 1e-6 * most / (PER_INCH * PER_INCH);
        println!(
            "{torque}: {:.3} {turn}, {most:.1} {pressure}, {shares:.3?} {before} {middle} {after} sweeps {}",
            arcsec(loads.turn),
            loads.sweeps
        );
        within(
            "turn of the gear",
            (arcsec(loads.turn) / turn - 1.0).abs(),
            0.004,
        );
        // At the largest torque the case counts edges, whose pressure has no bound.
        if torque < 400.0 {
            within("greatest pressure", (most / pressure - 1.0).abs(), 0.002);
        }
        for (share, expected) in shares.iter().zip([before, middle, after]) {
            within("share of a pair", (share - expected).abs(), 0.002);
        }
    }
}

/// Torque at the pinion N·m; turn arcsec, greatest pressure N/mm², shares of pairs −1, 0, 1.
const C28: [[f64; 6]; 7] = [
    [5.0, 6.992, 438.9, 0.000, 1.000, 0.000],
    [10.0, 11.084, 552.6, 0.000, 1.000, 0.000],
    [25.0, 20.437, 750.5, 0.000, 1.000, 0.000],
    [50.0, 32.427, 945.4, 0.000, 1.000, 0.000],
    [100.0, 51.519, 1197.3, 0.000, 1.000, 0.000],
    [200.0, 81.391, 1510.4, 0.000, 0.992, 0.008],
    [400.0, 122.993, 2041.3, 0.000, 0.921, 0.079],
];

/// Without load the highest place of the ridges is the unloaded contact, edges and hand-over included: no station lies above it, and half a
/// cell below it the gap is that of the ridge's curvature.
#[test]
fn law_no_load_is_the_unloaded_contact() {
    let (pair, path) = drive();
    let mut largest = Vec::new();
    for stations in [24, 96] {
        let mesh = FlankMesh::new(&pair, &path, options(stations), None);
        let mut apart = 0f64;
        for i in 0..24 {
            let angle = path.reference.pinion_angle + pair.pitch() * f64::from(i) / 24.0;
            let position = mesh.position(angle).unwrap();
            let unloaded = pair.leading(&path, angle).unwrap().te;
            let all = position.ridges.iter().flatten().map(|p| p.te);
            let highest = all.fold(f64::NEG_INFINITY, f64::max);
            assert!(
                arcsec(highest - unloaded) < 1e-3,
                "a station lies above the unloaded contact"
            );
            let light = position.lines.solve(1e-6, None).unwrap();
            assert!((arcsec(light.turn) - arcsec(unloaded - highest)).abs() < 1e-3);
            apart = apart.max(arcsec(light.turn));
        }
        largest.push(apart);
    }
    println!("unloaded contact missed by {largest:?} arcsec with 24 and 96 stations");
    assert!(largest[1] < 0.25 * largest[0] && largest[1] < 0.5);
}

/// Shares of the pairs sum to 1, and the tangent stiffness is the difference quotient of the torque over the turn.
#[test]
fn law_shares_and_tangent() {
    let (pair, path) = drive();
    let mesh = FlankMesh::new(&pair, &path, options(48), None);
    for i in [0, 7, 15] {
        let position = mesh
            .position(path.reference.pinion_angle + pair.pitch() * f64::from(i) / 24.0)
            .unwrap();
        for torque in [30.0, 300.0].map(|t| 3.0 * t / PER_INCH) {
            let at = |t: f64| position.lines.solve(t, None).unwrap();
            let loads = at(torque);
            let total: f64 = position
                .lines
                .cells()
                .zip(loads.forces.iter().flatten())
                .map(|(c, f)| c.arm * f)
                .sum();
            assert!((total / torque - 1.0).abs() < 1e-9);
            let step = 1e-3 * torque;
            let quotient = 2.0 * step / (at(torque + step).turn - at(torque - step).turn);
            println!("tangent {:.5}", loads.tangent / quotient - 1.0);
            // The largest width of a line sets the kernel of all its cells, which the tangent takes as fixed.
            assert!(
                (loads.tangent / quotient - 1.0).abs() < 0.02,
                "tangent {} quotient {quotient}",
                loads.tangent
            );
        }
    }
}

/// The shipped pair with its teeth: settings in SI, both flanks, thickness.
fn shipped() -> (FlankPair, ContactPath, BevelTeeth) {
    let source = load::load(std::path::Path::new("models/gears/bevel_12_36.toml")).unwrap();
    let file = bevel_file::read(&source, &Flags::default()).unwrap();
    let result = bevel::run(&file).unwrap();
    let [pinion, gear] = result.members.each_ref().map(|m| m.tooth.as_ref().unwrap());
    let teeth = BevelTeeth::new([pinion, gear], [0, 1], &STEEL)
        .unwrap()
        .unwrap();
    let contact = result.contact.unwrap();
    (contact.pair, contact.path, teeth)
}

/// Loaded transmission error of the shipped pair with bending teeth settles over the stations, and its teeth soften the contact.
///
/// What is left with 32 stations are contacts on edges that cover two to four of them: half a cell of place moves the approach of such a
/// contact by 1 to 2 %. With 64 stations at 300 N·m these cells are shorter than that contact is wide, which the answer warns of.
#[test]
fn law_stations_converge() {
    let (pair, path, teeth) = shipped();
    let map = |stations: usize, teeth: Option<&dyn ToothBending>| {
        let options = FlankMeshOptions {
            stations,
            positions: 16,
            ..FlankMeshOptions::default()
        };
        let mesh = FlankMesh::new(&pair, &path, options, teeth);
        mesh.map(&[100.0, 300.0]).unwrap()
    };
    let te = |result: &FlankMeshResult, k: usize| result.cycles[k].of(|p| arcsec(p.te));
    let finest = map(48, Some(&teeth));
    let coarse = |k: usize, result: &FlankMeshResult| {
        let of = result.cycles[k].of(|p| p.cell_width_ratio);
        of.into_iter().fold(0.0, f64::max)
    };
    println!("half widths in a cell {:.3}", coarse(1, &finest));
    let fine = map(32, Some(&teeth));
    for k in 0..2 {
        let end = te(&finest, k);
        let mut before = f64::INFINITY;
        for (stations, result) in [(16, &map(16, Some(&teeth))), (32, &fine)] {
            let own = te(result, k);
            let off: Vec<f64> = own.iter().zip(&end).map(|(a, b)| a - b).collect();
            let rms = (off.iter().map(|d| d * d).sum::<f64>() / off.len() as f64).sqrt();
            println!(
                "{stations} stations: te off by {rms:.3} arcsec rms, {:.3} at most, of {:.1}; peak to peak {:.3} of {:.3}",
                off.iter().fold(0f64, |m, d| m.max(d.abs())),
                end.iter().fold(0f64, |m, e| m.max(e.abs())),
                peak_to_peak(&own),
                peak_to_peak(&end),
            );
            assert!(rms < 0.5 * before, "{stations} stations");
            before = rms;
        }
        assert!(before < 0.3);
    }
    let short = map(64, Some(&teeth));
    assert!(coarse(1, &short) > 1.5 * coarse(1, &finest));
    let rigid = map(32, None);
    let softer = rigid.cycles[0].of(|p| arcsec(p.te));
    assert!(
        softer
            .iter()
            .zip(&te(&fine, 0))
            .all(|(rigid, bent)| bent < rigid)
    );
}

/// A contact below a/b 2.9 as one cell: approach, greatest pressure and tangent `1.5 F/δ` are those of the ellipse.
/// Source: Johnson, Contact Mechanics, 1985, eq. 4.26.
#[test]
fn ref_short_ellipse_in_closed_form() {
    let [k1, k2, force, _, _, p0, approach] = ELLIPTIC[0];
    let unit = EllipticContact::new([1e3 * k1, 1e3 * k2], 1.0, &STEEL).unwrap();
    let cell = ContactCell {
        along: 0.0,
        length: 1e-3,
        gap: 0.0,
        arm: 1.0,
        curvature: 1e3 * k2,
        on_edge: false,
        ellipse: Some(unit),
        teeth: None,
    };
    let line = ContactLine {
        pair: 0,
        cells: vec![cell],
    };
    let lines = LoadedLines::new(vec![line], STEEL);
    let loads = lines.solve(force, None).unwrap();
    let pressure = 1e-6 * largest_pressure(&lines, &loads) / p0 - 1.0;
    within("greatest pressure", pressure.abs(), 1e-8);
    within("approach", (1e6 * loads.turn / approach - 1.0).abs(), 1e-8);
    let tangent = loads.tangent * loads.turn / (1.5 * force);
    within("tangent", (tangent - 1.0).abs(), 1e-8);
}

/// Three lines of half spaces share a torque about one axis: turn µrad, greatest pressure N/mm², shares.
/// Source: tools/loaded_lines_peer.py, the same cells with widths by plain repetition and forces by SciPy's nnls.
#[test]
fn ref_three_lines_share_a_torque() {
    let lines = [
        (0.6, 64.5, 0.0, 0.1),
        (0.8, 70.0, 3e-6, 0.095),
        (0.5, 60.0, 8e-6, 0.105),
    ];
    let line = |(k1, k2, gap, arm): (f64, f64, f64, f64)| {
        let cell = |i: usize| {
            let along = (i as f64 - 15.5) * 0.6e-3;
            ContactCell {
                along,
                length: 0.6e-3,
                gap: gap + 0.5 * k1 * along * along,
                arm,
                curvature: k2,
                on_edge: false,
                ellipse: None,
                teeth: None,
            }
        };
        ContactLine {
            pair: 0,
            cells: (0..32).map(cell).collect(),
        }
    };
    let lines = LoadedLines::new(lines.map(line).to_vec(), STEEL);
    for (torque, turn, pressure, shares) in [
        (50.0, 31.862534, 549.0634, [1.0, 0.0, 0.0]),
        (200.0, 67.357295, 800.2935, [0.768023, 0.231977, 0.0]),
        (600.0, 116.001298, 1051.2322, [0.578134, 0.279621, 0.142246]),
    ] {
        let loads = lines.solve(torque, None).unwrap();
        println!("{torque} N·m: {} sweeps", loads.sweeps);
        within("turn", (1e6 * loads.turn / turn - 1.0).abs(), 1e-7);
        let most = 1e-6 * largest_pressure(&lines, &loads);
        within("greatest pressure", (most / pressure - 1.0).abs(), 1e-6);
        for (k, share) in shares.into_iter().enumerate() {
            let arms = lines.lines[k].cells.iter().map(|c| c.arm);
            let own: f64 = arms.zip(&loads.forces[k]).map(|(a, f)| a * f).sum();
            within("share of a line", (own / torque - share).abs(), 1e-6);
        }
    }
}

/// Greatest shear below a line and a circle, and between: depth over the shorter semi-axis, size over the greatest pressure.
/// Source: Boussinesq's half space under the pressure of an ellipse, integrated on its axis with 200 × 200 points, ν = 0.3.
#[test]
fn ref_shear_below_an_ellipse() {
    for (ratio, depth, size) in [
        (1.0, 0.480, 0.3100),
        (0.8, 0.535, 0.3165),
        (0.6, 0.595, 0.3221),
        (0.4, 0.665, 0.3252),
        (0.345, 0.685, 0.3251),
        (0.2, 0.740, 0.3215),
        (0.1, 0.770, 0.3144),
    ] {
        let found = greatest_shear(ratio);
        within("depth", (found[0] - depth).abs(), 0.006);
        within("size", (found[1] - size).abs(), 0.004);
    }
}

/// The moment in the root line of a plate is the force times its height above that line.
#[test]
fn exact_root_moment() {
    let [width, height] = [0.04, 0.012];
    let shape = PlateShape {
        corners: [
            [[0.0, 0.0], [0.002, height]],
            [[width, 0.0], [width, 0.8 * height]],
        ],
        material: STEEL[0],
    };
    let plate = ToothPlate::new(&shape, |[face, up]| 0.01 - 0.004 * up + 0.001 * face).unwrap();
    for ([face, up], cosine) in [([0.3, 0.6], 0.9), ([0.9, 1.0], 1.0)] {
        let (loading, _) = plate.load([face, up], cosine);
        let moment = plate.root_moment(&loading);
        let arm = up * height * (1.0 - 0.2 * face);
        within(
            "moment of 1 N",
            (moment.total / (cosine * arm) - 1.0).abs(),
            1e-9,
        );
        assert!(moment.greatest > moment.total / width);
    }
}

/// At the torques of change the set of strips that carry changes, and nowhere between; there the turn is all but affine in the torque.
#[test]
fn law_affine_between_changes() {
    let (pair, path, teeth) = shipped();
    let options = FlankMeshOptions {
        stations: 20,
        ..FlankMeshOptions::default()
    };
    let mesh = FlankMesh::new(&pair, &path, options, Some(&teeth));
    let position = mesh.position(mesh.angle(9)).unwrap();
    let lines = &position.lines;
    let changes = lines.changes(900.0).unwrap();
    assert!(changes.len() > 8 && changes.iter().any(|c| lines.lines[c.line].pair != 0));
    let place = |line: usize, cell: usize| {
        let before: usize = lines.lines[..line].iter().map(|l| l.cells.len()).sum();
        before + cell
    };
    let at = |torque: f64| lines.solve(torque, None).unwrap();
    let mut bent = 0f64;
    for two in changes
        .windows(2)
        .filter(|w| w[1].torque > 1.06 * w[0].torque)
    {
        let [from, to] = [two[0].torque * 1.002, two[1].torque * 0.998];
        let (low, middle, high) = (at(from), at(0.5 * (from + to)), at(to));
        assert_eq!(
            low.active, middle.active,
            "a change between {from} and {to} N·m"
        );
        assert_eq!(
            middle.active, high.active,
            "a change between {from} and {to} N·m"
        );
        let rise = high.turn - low.turn;
        let off = middle.turn - 0.5 * (low.turn + high.turn);
        bent = bent.max((off / rise).abs());
        let after = at(two[1].torque * 1.002);
        let cell = place(two[1].line, two[1].cell);
        assert_eq!(after.active[cell], two[1].begins);
        assert_eq!(high.active[cell], !two[1].begins);
    }
    println!(
        "{} changes, off a straight line by {bent:.5} of the rise",
        changes.len()
    );
    // The widths grow with the force and enter by their logarithm.
    within("bend of the turn between changes", bent, 0.02);
}

/// A pair whose gear is cut by a head of a third of the radius: its ellipse is short, and its pressure is that of the closed form.
#[test]
fn law_short_ellipses_of_a_crowned_pair() {
    let text = std::fs::read_to_string("models/gears/bevel_12_36.toml").unwrap();
    let of_shipped =
        "convex  = { cutter = { point_radius = \"2.9675 in\", blade_angle = \"22 deg\" } }";
    let crowned = "convex = { cutter = { point_radius = \"0.9675 in\", blade_angle = \"22 deg\" }, radial_distance = \"2.736 in\", cradle_angle = \"17.42 deg\" }";
    assert!(text.contains(of_shipped));
    let source = load::source_from_text("crowned.toml".into(), &text.replace(of_shipped, crowned));
    let file = bevel_file::read(&source, &Flags::default()).unwrap();
    let contact = bevel::run(&file).unwrap().contact.unwrap();
    let options = FlankMeshOptions {
        positions: 6,
        ..FlankMeshOptions::default()
    };
    let mesh = FlankMesh::new(&contact.pair, &contact.path, options, None);
    let result = mesh.map(&[5.0]).unwrap();
    let at_reference = &result.cycles[0].positions[0];
    let ellipse = contact.pair.ellipse(&contact.path.reference, 1e-6).unwrap();
    let [long, short] = ellipse.semi_axes;
    // Semi-axes of an offset are √(2 offset/κ).
    let curvatures = [long, short].map(|axis| 2e-6 / (axis * axis));
    let force = at_reference.places[0].force;
    let exact = EllipticContact::new(curvatures, force, &STEEL).unwrap();
    println!(
        "a/b {:.3}, {} places",
        exact.aspect(),
        at_reference.places.len()
    );
    assert_eq!(at_reference.ellipses, 1);
    within(
        "greatest pressure",
        (at_reference.pressure.unwrap() / exact.pressure - 1.0).abs(),
        0.01,
    );
}

/// The deflection of a housing at a torque is an error of assembly of that size, and departures of nothing move nothing.
#[test]
fn law_housing_is_an_error_of_assembly() {
    let text = std::fs::read_to_string("models/gears/bevel_12_36.toml").unwrap();
    let with = |more: &str| {
        let text =
            format!("{text}\n[mesh]\npositions = 6\nstations = 12\ntorque = \"100 N·m\"\n{more}");
        let source = load::source_from_text("housing.toml".into(), &text);
        let file = bevel_file::read(&source, &Flags::default()).unwrap();
        bevel::run(&file).unwrap()
    };
    let found = with(
        "[tolerance]\npinion_axial = \"30 µm\"\n[housing]\ntorque = \"50 N·m\"\noffset = \"10 µm\"\npinion_axial = \"15 µm\"\n",
    );
    let state = |k: usize| found.studies.stability[k].contact.unwrap();
    assert_eq!(found.studies.stability.len(), 4);
    assert_eq!(state(0).shift, [0.0, 0.0]);
    let peak = peak_to_peak(&found.mesh.unwrap().mesh.cycles[0].of(|p| p.te));
    assert!((state(0).peak_to_peak / peak - 1.0).abs() < 1e-12);
    // Both ways move the pattern against each other.
    assert!(state(1).shift[0] * state(2).shift[0] < 0.0);
    let moved = with("[tolerance]\noffset = \"20 µm\"\n");
    assert_ne!(
        moved.studies.stability[1].contact,
        found.studies.stability[3].contact
    );
    let text = text.replace(
        "pinion_axial = \"0.02 in\"",
        "pinion_axial = \"0.538 mm\", offset = \"20 µm\"",
    );
    let source = load::source_from_text(
        "moved.toml".into(),
        &format!("{text}\n[mesh]\npositions = 6\nstations = 12\ntorque = \"100 N·m\"\n"),
    );
    let file = bevel_file::read(&source, &Flags::default()).unwrap();
    let mesh = bevel::run(&file).unwrap().mesh.unwrap().mesh;
    let peak = peak_to_peak(&mesh.cycles[0].of(|p| p.te));
    assert!((state(3).peak_to_peak / peak - 1.0).abs() < 1e-6);
}

/// A housing without its torque.
#[test]
fn refuses_a_housing_without_torque() {
    let text = std::fs::read_to_string("models/gears/bevel_12_36.toml").unwrap();
    let source = load::source_from_text(
        "housing.toml".into(),
        &format!("{text}\n[housing]\noffset = \"10 µm\"\n"),
    );
    let errors = bevel_file::read(&source, &Flags::default()).unwrap_err();
    assert!(format!("{errors:?}").contains("torque"));
}

/// Time of a loaded position with 32 stations.
#[test]
#[ignore = "prints a time of a release build"]
fn loaded_position_time() {
    let (pair, path, teeth) = shipped();
    let options = FlankMeshOptions {
        positions: 20,
        ..FlankMeshOptions::default()
    };
    let mesh = FlankMesh::new(&pair, &path, options, Some(&teeth));
    for count in [1, 20] {
        let torques: Vec<f64> = (1..=count).map(|i| 15.0 * f64::from(i)).collect();
        let started = std::time::Instant::now();
        mesh.map(&torques).unwrap();
        println!("{count} torques: {:?} a position", started.elapsed() / 20);
    }
}
