//! Wrong measured gears and charts.

use super::Row;

/// A measured gear without fault; its chart is `chart.csv`.
pub const GEAR: &str = r#"title = "Pinion of eight teeth"
source = "test"
[measured_gear]
teeth = 8
module = "3 mm"
pressure_angle = "20 deg"
face_width = "30 mm"
standard = "ISO 1328-1:2013"
accuracy = 6
[[chart]]
kind = "pitch"
method = "index"
file = "chart.csv"
left = "left"
right = "right"
uncertainty = "0.3 µm"
"#;

/// Its chart.
pub const CHART: &str =
    "tooth,left [µm],right [µm]\n1,0,0\n2,1,2\n3,-1,1\n4,2,0\n5,0,1\n6,1,-1\n7,-2,0\n8,1,1\n";

/// The gear with one text in place of another, and what `measure` names.
#[rustfmt::skip]
const GEARS: &[(&str, &str, &str)] = &[
    ("teeth = 8", "teeth = 0", "[out-of-range] | gear.toml:4: | teeth"),
    ("teeth = 8", "teeth = 9", "[out-of-range] | gear.toml:10: | 8 pitch readings for 9 teeth"),
    ("teeth = 8", "teeth = 99999999999", "gear.toml:4: | teeth"),
    ("teeth = 8", "teeth = 8.5", "gear.toml:4: | teeth"),
    ("teeth = 8", "", "[missing-key] | teeth"),
    ("\"3 mm\"", "\"0 mm\"", "gear.toml:5: | module"),
    ("\"3 mm\"", "\"1e300 mm\"", "[out-of-range] | gear.toml:5: | module"),
    ("\"3 mm\"", "3", "[missing-unit] | gear.toml:5: | module"),
    ("\"20 deg\"", "\"90 deg\"", "gear.toml:6: | pressure_angle"),
    ("\"20 deg\"", "\"20 mm\"", "[wrong-unit] | gear.toml:6:"),
    ("\"30 mm\"", "\"-30 mm\"", "gear.toml:7: | face_width"),
    ("ISO 1328-1:2013", "ISO 9999", "gear.toml:8: | ISO 9999"),
    ("accuracy = 6", "accuracy = -1", "[out-of-range] | gear.toml:9: | not a notation of grades"),
    ("accuracy = 6", "accuracy = 99", "gear.toml:9: | accuracy"),
    ("\"pitch\"", "\"pich\"", "[out-of-range] | gear.toml:11: | did you mean \"pitch\"?"),
    ("\"index\"", "\"guess\"", "[out-of-range] | gear.toml:12:"),
    ("chart.csv", "none.csv", "[file-missing] | none.csv"),
    ("chart.csv", ".", "[file-missing]"),
    ("chart.csv", "gear.toml", "[empty-log] | gear.toml:1:"),
    ("\"left\"", "\"lift\"", "[no-channel] | lift"),
    ("\"0.3 µm\"", "\"-1 µm\"", "gear.toml:16: | uncertainty"),
    ("\"0.3 µm\"", "\"nan µm\"", "gear.toml:16:"),
    ("[measured_gear]", "[measured_gears]", "[missing-key] | [measured_gear]"),
    ("[[chart]]", "[chart]", "gear.toml:10:"),
];

/// The chart, and what `measure` names.
#[rustfmt::skip]
const CHARTS: &[(&str, &str)] = &[
    ("", "[empty-log] | chart.csv"),
    ("tooth,left [µm],right [µm]\n", "[empty-log] | chart.csv"),
    ("tooth,left [µm],right [µm]\n1,0,0\n", "[out-of-range] | gear.toml:10: | 1 pitch readings for 8 teeth"),
    ("tooth,left [µm],right [µm]\n1,0,0\n2,1\n3,1,1\n", "[ragged-row] | chart.csv:3:"),
    ("tooth,left [µm],right [µm]\n1,0,0\n2,x,1\n3,1,1\n", "[not-a-number] | chart.csv:3:"),
    ("tooth,left [kg],right [µm]\n1,0,0\n2,1,2\n3,1,1\n4,0,0\n5,1,2\n6,1,1\n7,0,0\n8,1,1\n", "kg"),
    ("tooth,left [µm],right [µm]\n1,0,0\n2,NaN,2\n3,1,1\n4,0,0\n5,1,2\n6,1,1\n7,0,0\n8,1,1\n", "[not-a-number] | reading 2"),
    ("tooth,left [µm],right [µm]\n1,0,0\n2,1e300,2\n3,1,1\n4,0,0\n5,1,2\n6,1,1\n7,0,0\n8,1,1\n", "[out-of-range] | reading 2 | left"),
];

/// The rows of this table.
pub fn rows() -> Vec<Row> {
    let gears = GEARS.iter().map(|(from, to, says)| {
        assert!(GEAR.contains(from), "{from}");
        Row::new(
            "gear.toml",
            GEAR.replacen(from, to, 1),
            "measure FILE",
            2,
            says,
        )
    });
    let charts = CHARTS
        .iter()
        .map(|(text, says)| Row::new("chart.csv", *text, "measure gear.toml", 2, says));
    let good = Row::new("chart.csv", CHART, "measure gear.toml", 0, "pitch");
    gears.chain(charts).chain([good]).collect()
}
