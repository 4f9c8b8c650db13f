//! Spectrum plots with labelled lines.

use super::axes::{draw_curve, draw_frame, draw_log_grid, extremes, linear_range, log_range};
use super::svg::{
    Anchor, BLACK, BLUE, Canvas, Colour, GREY, LIGHT_GREY, ORANGE, Panel, WIDTH, render_svg,
    text_width, ticks,
};

const MARGIN_LEFT: f64 = 70.0;

/// Left free at either side by labels, and between two of them.
const MARGIN: f64 = 8.0;

/// See [`MARGIN`].
const SPACING: f64 = 8.0;

const HEIGHT: f64 = 420.0;

/// One spectrum with the names of its lines.
#[derive(Debug, Clone, Default)]
pub struct SpectrumPlot {
    /// Above it.
    pub title: String,
    /// Name of the horizontal axis.
    pub across: String,
    /// Name of the vertical axis.
    pub up: String,
    /// Curves: label, places, values.
    pub curves: Vec<(String, Vec<f64>, Vec<f64>)>,
    /// Labelled peaks, the more important first: place, value, text. As many are shown as have room.
    pub labels: Vec<(f64, f64, String)>,
    /// The vertical axis is logarithmic.
    pub logarithmic: bool,
}

/// Draws spectra: power spectral densities, amplitudes, orders, envelopes, cepstra.
pub fn draw_spectra(shown: &SpectrumPlot) -> String {
    const COLOURS: [Colour; 4] = [BLUE, ORANGE, BLACK, GREY];
    let top = 76.0;
    render_svg(WIDTH, top + HEIGHT + 52.0, |canvas| {
        canvas.title(&shown.title, MARGIN_LEFT);
        let mut right = MARGIN_LEFT;
        for ((label, ..), ink) in shown.curves.iter().zip(COLOURS) {
            right = canvas.key_entry((right, 36.0), label, ink, 2.0) + 16.0;
        }
        let values = || shown.curves.iter().flat_map(|c| c.2.iter().copied());
        let y = if shown.logarithmic {
            log_range(values())
        } else {
            linear_range(values().chain([0.0]))
        };
        let places = || shown.curves.iter().flat_map(|c| c.1.iter().copied());
        let x = extremes(places());
        let (Some(y), true) = (y, x.0 < x.1) else {
            draw_empty_note(canvas, top + HEIGHT / 2.0);
            return;
        };
        let panel = Panel::new((MARGIN_LEFT, WIDTH - 24.0), (top, top + HEIGHT), x, y);
        match shown.logarithmic {
            true => draw_log_grid(&panel, canvas),
            false => panel.draw_y_grid(canvas, &ticks(y, 6)),
        }
        draw_frame(&panel, canvas, &shown.up, Some(&shown.across));
        let height = |v: f64| if shown.logarithmic { v.log10() } else { v };
        for ((_, places, values), ink) in shown.curves.iter().zip(COLOURS) {
            let points = places
                .iter()
                .copied()
                .zip(values.iter().map(|&v| height(v)));
            draw_curve(canvas, &panel, points, ink, 0.9);
        }
        let spot = |(x, y, text): &(f64, f64, String)| (*x, height(*y), text.clone());
        let labels: Vec<_> = shown.labels.iter().map(spot).collect();
        name_peaks(canvas, &panel, &labels);
    })
}

/// Says that there is nothing, at a height.
pub fn draw_empty_note(canvas: &mut Canvas, height: f64) {
    let spot = (WIDTH / 2.0, height);
    canvas.placeholder("nothing to show", spot);
}

/// Names peaks above a panel, the more important first: values of both axes, text. As many are named as have room.
pub fn name_peaks(canvas: &mut Canvas, panel: &Panel, labels: &[(f64, f64, String)]) {
    let top = panel.down.0;
    let wanted = |l: &(f64, f64, String)| (panel.canvas_x(l.0), text_width(&l.2, 9.0) + SPACING);
    let wanted: Vec<(f64, f64)> = labels.iter().map(wanted).collect();
    let spread = place_labels(&wanted, (MARGIN, WIDTH - MARGIN));
    for ((x, y, text), right) in labels.iter().zip(spread) {
        let spot = panel.to_canvas(*x, *y);
        canvas.line((right, top - 4.0), (spot.0, spot.1 - 3.0), LIGHT_GREY, 0.7);
        canvas.stroke_circle(spot, 2.6, BLACK, 1.0);
        canvas.text(text, (right, top - 11.0), 9.0, BLACK, Anchor::Middle);
    }
}

/// The middles of labels, from the places wanted and their widths: as many of the first as fit, side by side in their order.
fn place_labels(wanted: &[(f64, f64)], (low, high): (f64, f64)) -> Vec<f64> {
    let mut room = high - low;
    let mut fits = |(_, width): &&(f64, f64)| {
        room -= width;
        room >= 0.0
    };
    let kept: Vec<(f64, f64)> = wanted.iter().take_while(|w| fits(w)).copied().collect();
    let mut order: Vec<usize> = (0..kept.len()).collect();
    order.sort_by(|&a, &b| kept[a].0.total_cmp(&kept[b].0));
    let mut middles = vec![0.0; kept.len()];
    let mut from = low;
    for &i in &order {
        let (wanted, width) = kept[i];
        middles[i] = wanted.max(from + 0.5 * width);
        from = middles[i] + 0.5 * width;
    }
    let mut to = high;
    for &i in order.iter().rev() {
        let width = kept[i].1;
        middles[i] = middles[i].min(to - 0.5 * width);
        to = middles[i] - 0.5 * width;
    }
    middles
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Labels never overlap nor leave the plot; of too many the first stay.
    #[test]
    fn law_labels_have_room() {
        let mut rng = fastrand::Rng::with_seed(9);
        for _ in 0..200 {
            let count = rng.usize(0..30);
            let label = |_| (900.0 * rng.f64(), 10.0 + 200.0 * rng.f64());
            let wanted: Vec<(f64, f64)> = (0..count).map(label).collect();
            let middles = place_labels(&wanted, (8.0, 892.0));
            let ends = |i: usize| {
                (
                    middles[i] - 0.5 * wanted[i].1,
                    middles[i] + 0.5 * wanted[i].1,
                )
            };
            for i in 0..middles.len() {
                assert!(ends(i).0 > 8.0 - 1e-9 && ends(i).1 < 892.0 + 1e-9);
                let apart =
                    |j: usize| ends(i).1 <= ends(j).0 + 1e-9 || ends(j).1 <= ends(i).0 + 1e-9;
                assert!((0..i).all(apart));
            }
        }
    }
}
