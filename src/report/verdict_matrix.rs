//! Verdicts of a stability study as a picture: cases by methods, coloured, with the word and the energy-balance error.

use super::stability_table::{cases_and_methods, find_case, verdict_text};
use super::svg::{
    Anchor, BLACK, BLUE, Canvas, Colour, LABEL_SIZE, LIGHT_GREY, ORANGE, WIDTH, lighten,
    render_svg, widest,
};
use crate::study::stability::stress_test::{CaseVerdict, MAX_ENERGY_ERROR, StressCase};

/// Height of a row.
const ROW: f64 = 22.0;

/// Largest width of a column.
const MAX_COLUMN: f64 = 130.0;

/// Draws the matrix; absent where no case ran.
pub fn draw(title: &str, cases: &[StressCase]) -> Option<String> {
    let (names, methods) = cases_and_methods(cases);
    if names.is_empty() {
        return None;
    }
    let left = 24.0 + widest(&names, LABEL_SIZE, 60.0) + 10.0;
    let column = ((WIDTH - left - 24.0) / methods.len() as f64).min(MAX_COLUMN);
    let top = 92.0;
    let svg = render_svg(WIDTH, top + names.len() as f64 * ROW + 20.0, |canvas| {
        canvas.title(&format!("{title}: verdicts"), 24.0);
        key(canvas);
        for (j, method) in methods.iter().enumerate() {
            let x = left + (j as f64 + 0.5) * column;
            // Long names stand in two rows.
            let y = top - 10.0 - 14.0 * (j % 2) as f64;
            canvas.label(method, (x, y), Anchor::Middle);
        }
        for (i, name) in names.iter().enumerate() {
            let y = top + i as f64 * ROW;
            canvas.label(name, (left - 10.0, y + 0.5 * ROW), Anchor::End);
            for (j, method) in methods.iter().enumerate() {
                let x = left + j as f64 * column;
                let (low, high) = ((x + 1.0, y + 1.0), (x + column - 1.0, y + ROW - 1.0));
                match find_case(cases, name, method) {
                    Some(case) => {
                        canvas.fill_rect(low, high, ink(case.verdict));
                        let middle = (x + 0.5 * column, y + 0.5 * ROW);
                        canvas.text(
                            &verdict_text(case),
                            middle,
                            LABEL_SIZE,
                            BLACK,
                            Anchor::Middle,
                        );
                    }
                    None => canvas.stroke_rect(low, high, LIGHT_GREY, 0.6),
                }
            }
        }
    });
    Some(svg)
}

/// Colour of a verdict; grey print keeps fail the darkest.
fn ink(verdict: CaseVerdict) -> Colour {
    match verdict {
        CaseVerdict::Pass => lighten(lighten(BLUE)),
        CaseVerdict::Refused => LIGHT_GREY,
        CaseVerdict::Fail => lighten(ORANGE),
    }
}

fn key(canvas: &mut Canvas) {
    let entries = [
        (CaseVerdict::Pass, "energy balance satisfied"),
        (CaseVerdict::Refused, "no result, reason in the table"),
        (CaseVerdict::Fail, "impossible result"),
    ];
    let mut x = 24.0;
    for (verdict, meaning) in entries {
        canvas.fill_rect((x, 36.0), (x + 12.0, 48.0), ink(verdict));
        let text = format!("{}: {meaning}", verdict.name());
        canvas.label(&text, (x + 18.0, 42.0), Anchor::Start);
        x += 18.0 + widest([&text], LABEL_SIZE, 0.0) + 20.0;
    }
    let limit = format!("number: energy-balance error, limit {MAX_ENERGY_ERROR:.0e}");
    canvas.note(&limit, (WIDTH - 24.0, 16.0), Anchor::End);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cell in the colour of each verdict with its word and error, a frame where a method had no such case, one more of each colour in the key.
    #[test]
    fn exact_cells_of_verdicts() {
        let case = |name: &str, method, verdict, energy_error| StressCase {
            name: name.into(),
            method,
            verdict,
            energy_error,
            reason: None,
        };
        let cases = [
            case("as it is", "rk4", CaseVerdict::Pass, Some(2e-9)),
            case("as it is", "radau5", CaseVerdict::Pass, Some(3e-12)),
            case("no damping", "rk4", CaseVerdict::Fail, Some(0.7)),
            case("no play", "radau5", CaseVerdict::Refused, None),
        ];
        let svg = draw("gear pair", &cases).unwrap();
        let cells = |colour: &str| {
            let fill = format!("fill=\"{colour}\" stroke=\"none\"");
            svg.matches(&fill).count() - 1
        };
        assert_eq!(["#BFD5E7", "#E7B47F", "#D8D8D8"].map(cells), [2, 1, 1]);
        let texts: Vec<&str> = svg.lines().map(str::trim).collect();
        for text in ["as it is", "no damping", "no play", "rk4", "radau5"] {
            let times = texts.iter().filter(|t| **t == text).count();
            assert_eq!(times, 1, "{text}");
        }
        for text in ["pass 2e-9", "pass 3e-12", "fail 7e-1", "refused"] {
            assert!(texts.contains(&text), "{text}");
        }
        assert!(draw("gear pair", &[]).is_none());
    }
}
