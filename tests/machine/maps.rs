//! Spectrograms as pictures: cells where there was signal, the colours of their levels, and no more of them than an eye can tell apart.

use geardyn::internals::report::figure::{Axis, Figure, LevelMap, Plot, PlotColumn};

/// Colours of the ends of the scale.
const LOWEST: &str = "#440154";
const HIGHEST: &str = "#FDE725";

fn count(svg: &str, what: &str) -> usize {
    svg.matches(what).count()
}

/// Ten columns of four lines, the last line the loudest by 60 dB.
fn map() -> LevelMap {
    LevelMap {
        label: "dB re 1 g²/Hz".into(),
        x: (0..10).map(f64::from).collect(),
        y: vec![0.0, 10.0, 20.0, 30.0],
        columns: vec![vec![-60.0, -60.0, -60.0, 0.0]; 10],
        sparse: false,
    }
}

/// The figure of a map.
fn draw(map: LevelMap) -> String {
    let plot = Plot {
        map: Some(map),
        ..Plot::new(Axis::linear("time, s"), Axis::linear("frequency, Hz"))
    };
    Figure::first(PlotColumn::one("log.csv: ax", plot)).svg()
}

/// A map of two levels has the cells that were put in.
#[test]
fn exact_cells_of_two_levels() {
    let svg = draw(map());
    assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"));
    assert!(!svg.contains("NaN") && !svg.contains("inf"));
    // Ten columns of one block on one ground, and the colours of the scale once.
    assert_eq!(count(&svg, HIGHEST), 10 + 1);
    assert_eq!(count(&svg, LOWEST), 1 + 1);
    for text in [
        "log.csv: ax",
        "dB re 1 g²/Hz",
        "frequency, Hz",
        "time, s",
        "−60",
    ] {
        assert!(svg.contains(text), "{text}");
    }
}

/// A long record of many lines stays drawable, and its loudest line visible.
#[test]
fn law_bounded_cells() {
    let lines = 4000;
    let row = |t: usize| -> Vec<f64> {
        (0..lines)
            .map(|k| {
                if k == t {
                    0.0
                } else {
                    10.0 * (1e-9 * (1 + (k + t) % 7) as f64).log10()
                }
            })
            .collect()
    };
    let long = LevelMap {
        x: (0..2000).map(|t| 0.1 * t as f64).collect(),
        y: (0..lines).map(|k| k as f64).collect(),
        columns: (0..2000).map(row).collect(),
        ..map()
    };
    let svg = draw(long);
    assert!(svg.len() < 6_000_000, "{} bytes", svg.len());
    assert!(count(&svg, HIGHEST) > 100);
}

/// Nothing is drawn where the record has a gap, and a record without power is no picture.
#[test]
fn survives_gaps_and_silence() {
    let whole = map();
    let gap = LevelMap {
        x: (0..10)
            .map(|t| if t < 5 { t } else { t + 20 })
            .map(f64::from)
            .collect(),
        ..map()
    };
    // The same blocks over three times the time: each a third as wide.
    let width = |svg: &str| {
        let at = svg.find(HIGHEST).unwrap();
        let tag = &svg[svg[..at].rfind('<').unwrap()..at];
        let text = tag.split(" width=\"").nth(1).unwrap();
        text.split('"').next().unwrap().parse::<f64>().unwrap()
    };
    let (one, other) = (draw(whole), draw(gap));
    assert!((width(&one) / width(&other) - 3.0).abs() < 0.1);
    for columns in [vec![vec![f64::NEG_INFINITY; 4]; 10], Vec::new()] {
        let x = (0..columns.len()).map(|t| t as f64).collect();
        let silent = LevelMap {
            columns,
            x,
            ..map()
        };
        assert!(draw(silent).contains("nothing to show"));
    }
}
