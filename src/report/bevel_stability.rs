//! Stability of the loaded contact of a bevel pair: table, JSON, figure of the centres of the pattern.

use serde_json::{Value, json};

use super::bevel_plot::{MARGIN, TOP, key};
use super::gear::ARCSEC;
use super::number_format::significant;
use super::svg::{
    Anchor, BLACK, BLUE, LABEL_SIZE, LIGHT_GREY, LineStyle, ORANGE, WIDTH, render_svg,
};
use super::table::{Table, or_dash};
use crate::gear::contact::pair::Assembly;
use crate::numeric::sorting::sort_ascending;
use crate::plan::gear::bevel_stability::{LoadedPattern, StabilityCase};

/// One row a case.
pub fn table(cases: &[StabilityCase]) -> Table<'static> {
    let mut table = Table::numeric(
        "axes|torque [N·m]|centre on the face [%]|on the height [%]|shift along the face [mm]|along the height [mm]|te peak to peak [arcsec]|pressure [N/mm²]|on edges [%]",
    );
    for case in cases {
        let state = case.contact;
        let cell = |of: &dyn Fn(LoadedPattern) -> String| or_dash(state, of);
        table.row([
            case.name.clone(),
            significant(case.torque),
            cell(&|s| format!("{:.1}", 100.0 * s.centre[0])),
            cell(&|s| format!("{:.1}", 100.0 * s.centre[1])),
            cell(&|s| format!("{:+.3}", 1e3 * s.shift[0] + 0.0)),
            cell(&|s| format!("{:+.3}", 1e3 * s.shift[1] + 0.0)),
            cell(&|s| format!("{:.3}", ARCSEC * s.peak_to_peak)),
            or_dash(state.and_then(|s| s.pressure), |p| {
                format!("{:.1}", 1e-6 * p)
            }),
            cell(&|s| format!("{:.1}", 100.0 * s.edge_share)),
        ]);
    }
    table
}

/// One object a case; `contact` is null where the flanks do not touch near the middle of their teeth.
pub fn stability_json(cases: &[StabilityCase]) -> Value {
    let contact = |s: &LoadedPattern| {
        json!({
            "centre": s.centre,
            "shift_m": s.shift,
            "peak_to_peak_arcsec": ARCSEC * s.peak_to_peak,
            "pressure_pa": s.pressure,
            "edge_share": s.edge_share,
        })
    };
    let case = |case: &StabilityCase| {
        json!({
            "axes": case.name,
            "offset_m": case.change.offset,
            "pinion_axial_m": case.change.pinion_axial,
            "gear_axial_m": case.change.gear_axial,
            "shaft_angle_error_rad": case.change.shaft_angle,
            "torque_nm": case.torque,
            "contact": case.contact.as_ref().map(contact),
        })
    };
    json!(cases.iter().map(case).collect::<Vec<_>>())
}

/// Half the side of the frame, px.
const HALF: f64 = 230.0;
/// Half the side of the frame in largest shifts: room for the names.
const ROOM: f64 = 1.25;
/// Height of a line of names, px.
const NAME_HEIGHT: f64 = 12.0;

/// Draws the shift of the pattern's centre on the pinion under each departure of the axes, at the least and the largest torque.
pub fn draw(title: &str, cases: &[StabilityCase]) -> String {
    let torques = cases.iter().map(|c| c.torque);
    let [least, largest] = [
        torques.clone().fold(f64::INFINITY, f64::min),
        torques.fold(0.0, f64::max),
    ];
    let moved = || {
        let moved = cases.iter().filter(|c| c.change != Assembly::default());
        moved.filter_map(|case| Some((case, case.contact?.shift)))
    };
    let far = moved().flat_map(|(_, shift)| shift.map(f64::abs));
    let range = ROOM * far.fold(1e-9, f64::max);
    let middle = (0.5 * WIDTH, TOP + 30.0 + HALF);
    let at = |[along, up]: [f64; 2]| {
        let scale = HALF / range;
        (middle.0 + scale * along, middle.1 - scale * up)
    };
    render_svg(WIDTH, middle.1 + HALF + MARGIN, |canvas| {
        canvas.title(
            &format!("{title}: shift of the pattern's centre on the pinion"),
            MARGIN,
        );
        let names = [least, largest].map(|torque| format!("at {torque} N·m"));
        match least < largest {
            true => key(canvas, &[(&names[0], ORANGE), (&names[1], BLUE)]),
            false => key(canvas, &[(&names[1], BLUE)]),
        }
        let square = [
            [-1.0, -1.0],
            [1.0, -1.0],
            [1.0, 1.0],
            [-1.0, 1.0],
            [-1.0, -1.0],
        ];
        let square = square.map(|corner| at(corner.map(|x| range * x)));
        canvas.polyline(&square, BLACK, 1.0, LineStyle::Solid);
        for axis in [[range, 0.0], [0.0, range]] {
            let line = [at(axis.map(|x| -x)), at(axis)];
            canvas.polyline(&line, LIGHT_GREY, 1.0, LineStyle::Solid);
        }
        let size = format!("{:.3} mm", 1e3 * range);
        canvas.note(
            &format!("to the heel {size}"),
            (square[1].0 + 6.0, middle.1),
            Anchor::Start,
        );
        canvas.note(
            &format!("to the tip {size}"),
            (middle.0, square[2].1 - 8.0),
            Anchor::Middle,
        );
        let mut names = Vec::new();
        for (case, shift) in moved() {
            let ink = if case.torque == largest { BLUE } else { ORANGE };
            let (from, to) = (at([0.0, 0.0]), at(shift));
            canvas.polyline(&[from, to], ink, 1.0, LineStyle::Solid);
            canvas.fill_circle(to, 2.5, ink);
            names.push((to, shift[0] < 0.0, &case.name, ink));
        }
        sort_ascending(&mut names, |(to, ..)| to.1);
        // Names on a side are a line apart.
        let mut last = [f64::NEG_INFINITY; 2];
        for (to, is_left, name, ink) in names {
            let last = &mut last[usize::from(is_left)];
            *last = to.1.max(*last + NAME_HEIGHT);
            let (off, anchor) = match is_left {
                true => (-12.0, Anchor::End),
                false => (12.0, Anchor::Start),
            };
            canvas.polyline(&[to, (to.0 + off, *last)], ink, 0.5, LineStyle::Solid);
            canvas.text(name, (to.0 + off, *last), LABEL_SIZE, ink, anchor);
        }
    })
}
