//! Pages of reports in browsers: no request, no message, ink in every plot and view, zoom, group, address, keys, CSV, light and dark, names with markup, sizes.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::{Value, json};

use super::chromium::Browser;
use super::firefox::Firefox;

/// A page of every kind of answer: the arguments without `--html`.
const KINDS: &[&str] = &[
    "modes models/geared_damped.toml",
    "modes models/lin_parker_n3.toml",
    "modes models/overhung_rotor.toml --campbell 0:12000:21",
    "response models/geared_damped.toml --input disc_1 --output disc_4 --band 1:400",
    "response models/geared_chain.toml --run-up 50:3000:12",
    "response examples/backlash_jumps.toml --harmonic-balance 2000:2600:3",
    "simulate examples/linear_chain.toml",
    "accuracy models/geared_damped.toml --of modes",
    "stability models/geared_damped.toml",
    "te models/three_stage_chain.toml --output spindle",
    "te examples/y2250_pinion.toml",
    "te data/y2250_te.csv --input index_gear_1 --output work_spindle --teeth 30:37,54:36,1:90 --lines 10000,36000",
    "identify data/spindle_impact.csv --input force --output ax",
    "spectrum data/spindle_impact.csv --channel ax",
    "spectrum data/spindle_impact.csv --channel ax --kind spectrogram",
    "spectrum data/run_up.csv --channel ax --kind spectrogram --tacho tacho",
    "measure data/index_gear.toml",
    "gear models/gears/fzg_c.toml",
    "gear models/gears/helical.toml",
    "gear reverse data/unknown_gear.toml",
    "gear models/gears/bevel_12_36.toml --vh",
    "gear models/gears/straight_20_40.toml",
    "gear models/gears/hypoid_13_42.toml",
    "gear models/gears/worm_zi_2_40.toml",
    "gear models/gears/worm_plane_1_40.toml",
    "gear models/gears/crossed_15_24.toml",
    "gear cut models/gears/bevel_12_36.toml",
    "run examples/y2250_te.toml",
];

/// Pages that a second browser opens.
const SECOND: &[&str] = &[
    "modes models/geared_damped.toml",
    "gear models/gears/bevel_12_36.toml",
    "simulate examples/linear_chain.toml",
    "gear models/gears/fzg_c.toml",
    "gear models/gears/worm_zi_2_40.toml",
];

/// Largest page but for its data, bytes.
const FIXED: usize = 120_000;

/// Largest ordinary page, bytes.
const ORDINARY: usize = 350_000;

/// Largest page of a million points in two outputs, bytes.
const MILLION: usize = 5_000_000;

/// The name of a channel that would be markup.
const HOSTILE: &str = "</script><img/src=x/onerror=alert(1)>";

/// Colours inside the axes of each plot and of each moving view.
const INK: &str = "[...G.plots.map((p) => [p.u.ctx, p.u.bbox.left + 2, p.u.bbox.top + 2, p.u.bbox.width - 4, p.u.bbox.height - 4]), ...[...document.querySelectorAll('.moving canvas, .turning canvas')].map((canvas) => [{ canvas }, 0, 0, canvas.width, canvas.height])].map(([ctx, left, top, width, height]) => { const copy = new OffscreenCanvas(width, height).getContext('2d', { willReadFrequently: true }); copy.drawImage(ctx.canvas, -left, -top); const d = copy.getImageData(0, 0, width, height).data; const colours = new Set(); for (let i = 0; i < d.length; i += 4) if (d[i + 3] > 200) colours.add((d[i] << 16) + (d[i + 1] << 8) + d[i + 2]); return colours.size; })";

/// Ranges of all plots.
const SHOWN: &str = "G.plots.map((p) => [p.shown.x, p.shown.y])";

/// Writes the page of a command.
fn write_page(arguments: &[&str], page: &Path) {
    let found = Command::new(env!("CARGO_BIN_EXE_geardyn"))
        .args(arguments)
        .arg("--html")
        .arg(page)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap();
    let message = String::from_utf8_lossy(&found.stderr);
    assert!(found.status.code() < Some(2), "{arguments:?}: {message}");
    assert!(page.is_file(), "{arguments:?}: {message}");
}

/// A log whose channels have names of markup.
fn hostile_log(folder: &Path) -> PathBuf {
    let path = folder.join("log.csv");
    let mut text = format!("time [s];{HOSTILE} [m/s²];<!--<script>\u{2028} [V]\n");
    let mut rng = fastrand::Rng::with_seed(3);
    for i in 0..4000 {
        let t = 1e-3 * f64::from(i);
        let wave = (6.0 * 7.0 * t).sin() + 0.1 * rng.f64();
        text += &format!("{t:.3};{wave:.6};{:.6}\n", rng.f64());
    }
    std::fs::write(&path, text).unwrap();
    path
}

/// A page is one file: no address, the policy against requests, the data, and no text of a log as markup.
#[test]
fn exact_page_is_one_file() {
    let folder = tempfile::tempdir().unwrap();
    let log = hostile_log(folder.path());
    let page = folder.path().join("page.html");
    write_page(
        &["spectrum", log.to_str().unwrap(), "--channel", HOSTILE],
        &page,
    );
    let text = std::fs::read_to_string(&page).unwrap();
    assert!(text.starts_with("<!doctype html>") && text.trim_end().ends_with("</html>"));
    assert!(text.contains("default-src 'none'"));
    assert!(!text.contains("<img") && !text.contains("{{data}}"));
    assert!(!text.contains(" src=\"http") && !text.contains("href=\"http"));
    assert_eq!(text.matches("id=\"data\"").count(), 1);
}

/// The figures of all studies of a scene in a folder, numbered by study.
#[test]
fn exact_run_draws_every_figure() {
    let folder = tempfile::tempdir().unwrap();
    let found = Command::new(env!("CARGO_BIN_EXE_geardyn"))
        .args(["run", "examples/y2250_te.toml", "--quiet", "--svg"])
        .arg(folder.path())
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap();
    assert!(found.status.code() < Some(2));
    let svg = std::fs::read_to_string(folder.path().join("1-te.svg")).unwrap();
    assert!(svg.starts_with("<svg"));
}

/// The flank that a generator cuts: one cell a node in the drawing, and on the page a surface with the extremes of the document, µm.
#[test]
fn exact_cut_flank_is_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let [page, svg] = ["page.html", "te.svg"].map(|name| folder.path().join(name));
    let line = ["te", "examples/y2250_pinion.toml", "--json", "--svg"];
    let found = Command::new(env!("CARGO_BIN_EXE_geardyn"))
        .args(line.map(String::from))
        .arg(&svg)
        .arg("--html")
        .arg(&page)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap();
    let document: Value = serde_json::from_slice(&found.stdout).unwrap();
    let surplus = document["works"][0]["surplus_um"].as_array().unwrap();
    let surplus: Vec<f64> = surplus.iter().filter_map(Value::as_f64).collect();
    let drawing = std::fs::read_to_string(folder.path().join("te-flank.svg")).unwrap();
    assert!(drawing.contains("pinion concave of bevel_12_36.toml") && drawing.contains("\nµm\n"));
    let text = std::fs::read_to_string(page).unwrap();
    let data = text.split("id=\"data\">").nth(1).unwrap();
    let data: Value = serde_json::from_str(data.split("</script>").next().unwrap()).unwrap();
    let view = &data["sections"][0]["views"][0];
    assert_eq!(view["kind"], json!("surface"));
    let surface = &view["data"]["surfaces"][0];
    let ends = [f64::min, f64::max].map(|of| surplus.iter().copied().reduce(of).unwrap());
    assert_eq!(surface["lowest_um"].as_f64(), Some(ends[0]));
    assert_eq!(surface["highest_um"].as_f64(), Some(ends[1]));
}

/// The surface of a cut flank is drawn in the colours of its values: both ends of the scale are seen, each about as often as among the nodes.
#[test]
#[cfg_attr(not(chromium), ignore = "needs chromium on the PATH")]
fn law_cut_flank_has_its_colours() {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("page.html");
    write_page(&["te", "examples/y2250_pinion.toml"], &page);
    let text = std::fs::read_to_string(&page).unwrap();
    let mut browser = Browser::start(folder.path());
    browser.open(&format!("file://{}", page.display()));
    assert!(text.contains("\"surface\""));
    // Seen along the normal, each node has its share of the picture; light keeps the ratios of a colour.
    let seen = "(() => { Object.assign(G.spaces[0], { tilt: 1.5 }); for (const show of G.redraws) show(); const c = G.spaces[0].canvas, copy = new OffscreenCanvas(c.width, c.height).getContext('2d'); copy.drawImage(c, 0, 0); const d = copy.getImageData(0, 0, c.width, c.height).data, paper = [d[0], d[1], d[2]]; const counts = [0, 0, 0]; for (let i = 0; i < d.length; i += 4) { const [r, g, b] = [d[i], d[i + 1], d[i + 2]]; if (paper.every((v, k) => Math.abs(v - d[i + k]) < 3)) continue; counts[0]++; if (b > g) counts[1]++; if (g > 1.15 * b) counts[2]++; } return counts; })()";
    let seen = browser.value(seen);
    let [all, low, high] = [0, 1, 2].map(|k| seen[k].as_f64().unwrap());
    // Viridis turns from more blue to more green at half of the scale.
    let document = Command::new(env!("CARGO_BIN_EXE_geardyn"))
        .args(["te", "examples/y2250_pinion.toml", "--json"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap();
    let document: Value = serde_json::from_slice(&document.stdout).unwrap();
    let values = document["works"][0]["surplus_um"].as_array().unwrap();
    let values: Vec<f64> = values.iter().filter_map(Value::as_f64).collect();
    let ends = [f64::min, f64::max].map(|of| values.iter().copied().reduce(of).unwrap());
    let below = values
        .iter()
        .filter(|v| **v < 0.5 * (ends[0] + ends[1]))
        .count();
    let share = below as f64 / values.len() as f64;
    assert!(all > 5000.0 && low > 0.0 && high > 0.0, "{seen}");
    assert!((low / all - share).abs() < 0.1, "{seen}: {share}");
}

/// The train of a planetary stage in the document: nodes by name, their coordinates, planets at their angles, a place for each.
#[test]
fn exact_document_holds_the_train() {
    let found = Command::new(env!("CARGO_BIN_EXE_geardyn"))
        .args(["modes", "models/lin_parker_n3.toml", "--json"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap();
    let document: Value = serde_json::from_slice(&found.stdout).unwrap();
    let train = &document["train"];
    let (nodes, dofs) = (
        train["nodes"].as_array().unwrap(),
        train["dofs"].as_array().unwrap(),
    );
    assert_eq!((nodes.len(), dofs.len()), (6, 18));
    for node in nodes {
        let name = node["name"].as_str().unwrap();
        for (axis, index) in node["dofs"].as_object().unwrap() {
            let dof = &dofs[index.as_u64().unwrap() as usize];
            assert_eq!(dof, &json!(format!("{name}.{axis}")));
        }
    }
    let stage = &train["stages"][0];
    assert_eq!(
        stage["planets"],
        json!(["stage.planet_1", "stage.planet_2", "stage.planet_3"])
    );
    assert_eq!(stage["sun"], json!("sun"));
    let second = stage["positions_rad"][1].as_f64().unwrap();
    assert!((second - std::f64::consts::TAU / 3.0).abs() < 1e-12);
    let supports = train["links"].as_array().unwrap().iter();
    assert_eq!(
        supports
            .filter(|l| l["nodes"].as_array().unwrap().len() == 1)
            .count(),
        3
    );
}

/// Sizes of a page: the whole, and without data and columns.
fn sizes(page: &Path) -> (usize, usize) {
    let text = std::fs::read_to_string(page).unwrap();
    let data = text.split("<script type=\"").skip(1);
    let length = |part: &str| part.find("</script>").unwrap();
    (text.len(), text.len() - data.map(length).sum::<usize>())
}

/// Every kind of page: what a user does works, and nothing is requested or complained of.
#[test]
#[cfg_attr(not(chromium), ignore = "needs chromium on the PATH")]
fn law_pages_work_in_a_browser() {
    let folder = tempfile::tempdir().unwrap();
    let log = hostile_log(folder.path());
    let hostile = format!("spectrum {} --channel {HOSTILE}", log.display());
    let mut browser = Browser::start(folder.path());
    for (k, kind) in KINDS.iter().copied().chain([hostile.as_str()]).enumerate() {
        let page = folder.path().join(format!("page{k}.html"));
        write_page(&kind.split(' ').collect::<Vec<_>>(), &page);
        let (whole, fixed) = sizes(&page);
        assert!(
            fixed <= FIXED && whole <= ORDINARY,
            "{kind}: {fixed} of {whole} bytes"
        );
        check(&mut browser, kind, &format!("file://{}", page.display()));
    }
}

/// Identified shapes move on the points of a test; keys turn the structure.
#[test]
#[cfg_attr(not(chromium), ignore = "needs chromium on the PATH")]
fn law_measured_shapes_move() {
    let folder = tempfile::tempdir().unwrap();
    let log = super::measured_shapes::test_in(folder.path());
    let page = folder.path().join("page.html");
    write_page(&["identify", &log, "--method", "plscf"], &page);
    let (_, fixed) = sizes(&page);
    assert!(fixed <= FIXED, "{fixed} bytes");
    let mut browser = Browser::start(folder.path());
    let address = format!("file://{}", page.display());
    check(&mut browser, "measured shapes", &address);
    browser.value("(G.players[0].playing && G.players[0].button.click(), document.querySelector('.moving canvas').focus(), 0)");
    let picture = "document.querySelector('.moving canvas').toDataURL()";
    let before = browser.value(picture);
    browser.press("ArrowRight");
    assert_ne!(browser.value(picture), before, "key →");
    browser.press("ArrowLeft");
    assert_eq!(browser.value(picture), before, "key ←");
    complaints(&mut browser, "measured shapes", &address);
}

/// What holds of every page.
fn check(browser: &mut Browser, kind: &str, address: &str) {
    browser.open(address);
    for (k, colours) in browser.value(INK).as_array().unwrap().iter().enumerate() {
        assert!(colours.as_u64() > Some(1), "{kind}: plot {k} has no ink");
    }
    let whole = browser.value(SHOWN);
    if !whole.as_array().unwrap().is_empty() {
        zoom(browser, kind, address);
        assert_eq!(browser.value(SHOWN), whole, "{kind}: all is shown again");
        save(browser, kind);
    }
    if kind.starts_with("identify") {
        let along = "G.plots.flatMap((p) => p.curves).filter((c) => c.along).map((c) => [c.along.label, c.along.values.length === c.x.length])";
        let expected = json!([["frequency, Hz", true]]);
        assert_eq!(
            browser.value(along),
            expected,
            "{kind}: frequencies in the plane"
        );
    }
    if browser.value("G.players.length") != json!(0) {
        play(browser, kind);
    }
    if browser.value("document.querySelector('.chooser') !== null") == json!(true) {
        choose(browser, kind);
    }
    let dark = "document.documentElement.classList.contains('dark')";
    let before = browser.value(dark);
    browser.press("t");
    assert_ne!(browser.value(dark), before, "{kind}: key t");
    for colours in browser.value(INK).as_array().unwrap() {
        assert!(colours.as_u64() > Some(1), "{kind}: no ink after key t");
    }
    let text = browser.value("document.querySelector('pre').textContent.length");
    assert!(text.as_u64() > Some(20), "{kind}: no text");
    complaints(browser, kind, address);
}

/// No exception, no message on the console, no request but the page itself.
fn complaints(browser: &mut Browser, kind: &str, address: &str) {
    for event in std::mem::take(&mut browser.events) {
        let method = event["method"].as_str().unwrap_or_default();
        let complaint = [
            "Runtime.exceptionThrown",
            "Runtime.consoleAPICalled",
            "Log.entryAdded",
        ];
        // What the driver says of its own speed is no complaint of the page.
        let is_driver = event["params"]["entry"]["source"] == json!("rendering");
        assert!(is_driver || !complaint.contains(&method), "{kind}: {event}");
        if method == "Network.requestWillBeSent" {
            let url = event["params"]["request"]["url"].as_str().unwrap();
            let own = ["about:", "blob:"].iter().any(|s| url.starts_with(s));
            assert!(own || url.starts_with(address), "{kind}: {url}");
        }
    }
}

/// Zooms the first plot by the mouse, opens the address anew, and goes back by a key; plots of its group follow, others do not.
fn zoom(browser: &mut Browser, kind: &str, address: &str) {
    browser.value("(G.plots[0].host.scrollIntoView({ block: 'center' }), 0)");
    let place = browser.value(
        "(() => { const r = G.plots[0].u.over.getBoundingClientRect(); return [r.left, r.top, r.width, r.height]; })()",
    );
    let [left, top, width, height] = [0, 1, 2, 3].map(|k| place[k].as_f64().unwrap());
    let at = |x: f64, y: f64| (left + x * width, top + y * height);
    let whole = numbers(&browser.value(SHOWN));
    browser.drag(at(0.3, 0.2), at(0.6, 0.8));
    let zoomed = numbers(&browser.value(SHOWN));
    assert_ne!(zoomed, whole, "{kind}: dragging zooms");
    let groups =
        browser.value("G.plots.map((p) => p.group !== null && p.group === G.plots[0].group)");
    for (k, follows) in groups.as_array().unwrap().iter().enumerate().skip(1) {
        let expected = if follows == &json!(true) {
            &zoomed[0]
        } else {
            &whole[k]
        };
        assert_eq!(zoomed[k][..2], expected[..2], "{kind}: group of plot {k}");
    }
    let hash = browser.value("location.hash");
    let hash = hash.as_str().unwrap();
    assert!(hash.len() > 5, "{kind}: the address holds the range");
    browser.open(&format!("{address}{hash}"));
    let again = numbers(&browser.value(SHOWN));
    for (a, b) in again.as_flattened().iter().zip(zoomed.as_flattened()) {
        // The address holds eight digits.
        assert!(
            (a - b).abs() <= 1e-5 * b.abs().max(1e-30),
            "{kind}: {a} {b}"
        );
    }
    browser.value("(G.plots[0].host.focus(), 0)");
    for key in ["+", "ArrowRight"] {
        let before = browser.value(SHOWN);
        browser.press(key);
        assert_ne!(browser.value(SHOWN), before, "{kind}: key {key}");
    }
    browser.press("0");
}

/// The ranges of all plots: x, x, y, y.
fn numbers(shown: &Value) -> Vec<[f64; 4]> {
    let range =
        |plot: &Value| [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(i, k)| plot[i][k].as_f64().unwrap());
    shown.as_array().unwrap().iter().map(range).collect()
}

/// The CSV button of each plot saves its points.
fn save(browser: &mut Browser, kind: &str) {
    let rows = browser.value(
        "(async () => { const make = URL.createObjectURL; const rows = []; for (const plot of G.plots) { let blob; URL.createObjectURL = (b) => { blob = b; return make.call(URL, b); }; plot.host.querySelector('.tools button:last-child').click(); rows.push((await blob.text()).split('\\n').length); } URL.createObjectURL = make; return rows; })()",
    );
    let rows = rows.as_array().unwrap();
    assert!(
        rows.iter().all(|n| n.as_u64() > Some(2)),
        "{kind}: {rows:?}"
    );
}

/// A moving view moves while it is visible and plays, and stands still otherwise.
fn play(browser: &mut Browser, kind: &str) {
    let frames = "G.players[0].frames";
    let moves = "new Promise((done) => { const from = G.players[0].frames; const look = () => G.players[0].frames > from + 2 ? done(true) : setTimeout(look, 5); look(); })";
    // Ten of the least intervals between frames.
    let later = "new Promise((done) => setTimeout(() => done(G.players[0].frames), 340))";
    browser.value("(document.querySelector('.moving canvas, .turning canvas').scrollIntoView({ block: 'center' }), 0)");
    assert_eq!(browser.value(moves), json!(true), "{kind}: it moves");
    browser.value("(G.players[0].button.click(), 0)");
    let before = browser.value(frames);
    assert_eq!(browser.value(later), before, "{kind}: pause");
    browser.value("(G.players[0].button.click(), 0)");
    assert_eq!(browser.value(moves), json!(true), "{kind}: play");
    let hide = "(document.querySelector('.moving, .turning').style.display = 'none', document.querySelector('.moving, .turning').parentElement.style.display = 'none', new Promise((done) => { const look = () => G.players[0].visible ? setTimeout(look, 5) : done(true); look(); }))";
    assert_eq!(browser.value(hide), json!(true), "{kind}: out of sight");
    let before = browser.value(frames);
    assert_eq!(browser.value(later), before, "{kind}: still out of sight");
    browser.value("(document.querySelector('.moving, .turning').style.display = '', document.querySelector('.moving, .turning').parentElement.style.display = '', 0)");
}

/// A row is chosen by a click and by keys.
fn choose(browser: &mut Browser, kind: &str) {
    let chosen =
        "[...document.querySelectorAll('.chooser tr')].findIndex((r) => r.ariaSelected === 'true')";
    browser.value("(document.querySelectorAll('.chooser tr')[1].click(), document.querySelector('.chooser').focus(), 0)");
    assert_eq!(browser.value(chosen), json!(1), "{kind}: click");
    for (key, row) in [("ArrowDown", 2), ("ArrowDown", 3), ("ArrowUp", 2)] {
        browser.press(key);
        assert_eq!(browser.value(chosen), json!(row), "{kind}: {key}");
    }
    let caption = browser.value("document.querySelector('.moving .note, .main .note').textContent");
    let expected = match kind.starts_with("gear") {
        true => "pinion concave, error 2",
        false => "Mode 2",
    };
    assert!(caption.as_str().unwrap().starts_with(expected), "{caption}");
}

/// A pair in space: the drawn flanks touch where the contact is marked, at every V and H that is shown; mouse and keys turn the view,
/// which needs no WebGL to be drawn.
#[test]
#[cfg_attr(not(chromium), ignore = "needs chromium on the PATH")]
fn law_gears_turn_in_space() {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("page.html");
    write_page(&["gear", "models/gears/bevel_12_36.toml", "--vh"], &page);
    let address = format!("file://{}", page.display());
    let mut browser = Browser::start(folder.path());
    browser.open(&address);
    browser.value("(G.players[0].set(false), document.querySelector('.space').scrollIntoView({ block: 'center' }), 0)");
    // Marks lie on chords between nodes and positions: 0.1 mm of a tooth of 7 mm.
    let gap = "Math.max(...Array.from({ length: 9 }, (_, k) => G.players[0].touching(k / 8)).map(([a, b]) => Math.hypot(...a.map((v, n) => v - b[n]))))";
    let place = "(v, h) => { const [, a, b] = document.querySelectorAll('.pair input[type=range]'); [a.value, b.value] = [v, h]; a.dispatchEvent(new Event('input')); return document.querySelector('.pair > .note').textContent; }";
    let mut texts = Vec::new();
    for (v, h) in [(3, 3), (3, 2), (4, 2)] {
        let text = browser.value(&format!("({place})({v}, {h})"));
        texts.push(text.as_str().unwrap().to_string());
        let gap = browser.value(gap).as_f64().unwrap();
        assert!(gap < 1e-4, "V {v}, H {h}: {gap} m");
    }
    assert!(texts[0] != texts[1] && texts[1] != texts[2], "{texts:?}");
    let text = browser.value(&format!("({place})(6, 6)"));
    assert!(text.as_str().unwrap().contains("do not touch"), "{text}");

    let camera = "[G.spaces[0].yaw, G.spaces[0].tilt, G.spaces[0].zoom]";
    let home = browser.value(camera);
    let place = browser.value("(() => { const r = document.querySelector('.space').getBoundingClientRect(); return [r.left + 0.5 * r.width, r.top + 0.5 * r.height]; })()");
    let [x, y] = [0, 1].map(|k| place[k].as_f64().unwrap());
    browser.drag((x, y), (x + 60.0, y + 40.0));
    let turned = browser.value(camera);
    assert!(
        turned[0] != home[0] && turned[1] != home[1],
        "the mouse turns"
    );
    browser.value("(document.querySelector('.space').focus(), 0)");
    for (key, part) in [("ArrowLeft", 0), ("ArrowDown", 1), ("+", 2)] {
        let before = browser.value(camera);
        browser.press(key);
        assert_ne!(browser.value(camera)[part], before[part], "{key}");
    }
    browser.press("0");
    assert_eq!(browser.value(camera), home, "0 goes back");

    let without = "const make = HTMLCanvasElement.prototype.getContext; HTMLCanvasElement.prototype.getContext = function (kind, ...more) { return kind === 'webgl2' ? null : make.call(this, kind, ...more); };";
    browser.call(
        "Page.addScriptToEvaluateOnNewDocument",
        json!({ "source": without }),
    );
    browser.open(&address);
    assert_eq!(
        browser.value("[G.spaces[0].still, G.players[0].playing]"),
        json!([true, false])
    );
    for colours in browser.value(INK).as_array().unwrap() {
        assert!(colours.as_u64() > Some(1), "no ink without WebGL");
    }
    complaints(&mut browser, "without WebGL", &address);
}

/// Worms and crossed gears in space: the contact of the moment is drawn in its colour through the gear, it moves with the angle, the camera
/// goes near it, and keys turn the view.
#[test]
#[cfg_attr(not(chromium), ignore = "needs chromium on the PATH")]
fn law_worms_turn_in_space() {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("page.html");
    let mut browser = Browser::start(folder.path());
    for (name, contact) in [
        ("worm_zi_2_40", "lines of contact"),
        ("worm_plane_1_40", "lines of contact"),
        ("crossed_15_24", "of contact"),
    ] {
        write_page(&["gear", &format!("models/gears/{name}.toml")], &page);
        let address = format!("file://{}", page.display());
        browser.open(&address);
        browser.value("(G.players[0].set(false), document.querySelector('.space').scrollIntoView({ block: 'center' }), 0)");
        let shown = "(phase) => { const a = document.querySelector('.pair input[type=range]'); a.value = phase; a.dispatchEvent(new Event('input')); return document.querySelector('.pair > .note').textContent; }";
        let text = browser.value(&format!("({shown})(0.25)"));
        assert!(text.as_str().unwrap().contains(contact), "{name}: {text}");
        browser.value("(document.querySelectorAll('.pair input[type=checkbox]')[1].click(), 0)");
        // The contact is the only green of the picture.
        let green = "(() => { const c = document.querySelector('.space'), copy = new OffscreenCanvas(c.width, c.height).getContext('2d'); copy.drawImage(c, 0, 0); const d = copy.getImageData(0, 0, c.width, c.height).data; let count = 0; for (let i = 0; i < d.length; i += 4) if (d[i + 1] > d[i] + 25 && d[i + 1] > d[i + 2] + 25) count++; return count; })()";
        let near = browser.value(green).as_u64().unwrap();
        assert!(near > 50, "{name}: {near} pixels of contact");
        let picture = "document.querySelector('.space').toDataURL()";
        let before = browser.value(picture);
        browser.value(&format!("({shown})(0.4)"));
        assert_ne!(browser.value(picture), before, "{name}: the angle");
        browser.value("(document.querySelector('.space').focus(), 0)");
        let before = browser.value(picture);
        browser.press("ArrowLeft");
        assert_ne!(browser.value(picture), before, "{name}: key ←");
        browser.press("ArrowRight");
        assert_eq!(browser.value(picture), before, "{name}: key →");
        complaints(&mut browser, name, &address);
    }
}

/// The spectrum of a shown range: a sine on a line has its amplitude there and nothing three lines on; the button follows the zoom.
#[test]
#[cfg_attr(not(chromium), ignore = "needs chromium on the PATH")]
fn exact_spectrum_of_what_is_shown() {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("page.html");
    write_page(&["simulate", "examples/linear_chain.toml"], &page);
    let mut browser = Browser::start(folder.path());
    browser.open(&format!("file://{}", page.display()));
    let sine = "(() => { const x = Float64Array.from({ length: 8193 }, (_, i) => i / 8192); const found = G.amplitudes(x, x.map((t) => 3 + 2 * Math.sin(100 * Math.PI * t)), [0, 1]); return [found.x[49], found.y[49], found.y[52], found.x.length]; })()";
    let found = browser.value(sine);
    let [at, line, next] = [0, 1, 2].map(|k| found[k].as_f64().unwrap());
    assert!(
        (at - 50.0).abs() < 1e-9 && (line - 2.0).abs() < 1e-4 && next < 1e-4,
        "{found}"
    );
    assert_eq!(found[3], json!(4096));
    // The extremes are marked where they were found, between the samples as well.
    let marks = browser.value("G.plots[0].labels.map((l) => [l.text, l.x, l.y])");
    assert_eq!(marks[0][0], json!("greatest"));
    assert!(
        (marks[0][1].as_f64().unwrap() - 0.2626).abs() < 1e-4,
        "{marks}"
    );
    let count = browser.value("G.plots.length").as_u64().unwrap();
    browser.value("([...document.querySelectorAll('.tools button')].find((b) => b.textContent === 'spectrum').click(), 0)");
    let lines = "G.plots.at(-1).curves[0].x.length";
    assert_eq!(browser.value("G.plots.length"), json!(count + 1));
    let whole = browser.value(lines).as_u64().unwrap();
    browser.value("(G.plots[0].host.focus(), 0)");
    browser.press("+");
    assert!(
        browser.value(lines).as_u64().unwrap() < whole,
        "it follows the zoom"
    );
    assert_eq!(browser.value("G.plots[0].y.label"), json!("mrad"));
}

/// Events of a motion are ticks at the foot of every plot: the pointer names them with their element and instant, the CSV holds them,
/// and the SVG file has a tick for each that has room.
#[test]
#[cfg_attr(not(chromium), ignore = "needs chromium on the PATH")]
fn law_events_are_marked() {
    let folder = tempfile::tempdir().unwrap();
    let [page, svg] = ["page.html", "plot.svg"].map(|name| folder.path().join(name));
    let line = "simulate examples/backlash_pair.toml --until 5e-3 --samples 500 --svg";
    let mut arguments: Vec<&str> = line.split(' ').collect();
    arguments.push(svg.to_str().unwrap());
    write_page(&arguments, &page);
    let mut browser = Browser::start(folder.path());
    browser.open(&format!("file://{}", page.display()));
    let kinds = browser.value("G.plots[1].events.map((e) => e.x.length)");
    let [lost, made] = [0, 1].map(|k| kinds[k].as_u64().unwrap());
    assert!(lost > 5 && lost.abs_diff(made) <= 1, "{kinds}");
    // Below the middle of each row of ticks.
    for (row, name) in ["contact loss", "impact"].iter().enumerate() {
        let hover = format!(
            "(() => {{ const p = G.plots[1], u = p.u, r = u.over.getBoundingClientRect(); u.over.dispatchEvent(new MouseEvent('mousemove', {{ clientX: r.left + u.valToPos(p.events[{row}].x[3], 'x') + 0.1, clientY: r.bottom - 8 * {row} - 4 }})); return [document.getElementById('tip').textContent, p.events[{row}].x[3]]; }})()"
        );
        let found = browser.value(&hover);
        let text = found[0].as_str().unwrap();
        assert!(
            text.starts_with(&format!("{name} of pair\ntime, ")),
            "{text}"
        );
        let shown = text.rsplit(' ').next().unwrap().parse::<f64>().unwrap();
        let exact = found[1].as_f64().unwrap();
        assert!((shown - exact).abs() < 1e-5 * exact, "{text}: {exact}");
    }
    // Of a row of ticks on white, in whatever share of a pixel: events without ink near their instant, and columns of its ink far from every event.
    let pixels = "[0, 1].map((row) => { const p = G.plots[1], u = p.u, d = devicePixelRatio, { left, top, width, height } = u.bbox, { x, ink } = p.events[row], hex = getComputedStyle(document.documentElement).getPropertyValue('--series-' + ink).trim(), rgb = [1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16)), data = u.ctx.getImageData(left, Math.round(top + height - (8 * row + 7) * d), width, 6).data, inked = (i) => [0, 1, 2, 3, 4, 5].some((j) => { const n = 4 * (j * width + i); const far = (of) => rgb.reduce((sum, v, k) => sum + Math.abs(v - of(k)), 0); return data[n + 3] > 60 && far((k) => data[n + k]) < 0.65 * far(() => 255); }), at = Array.from(x, (v) => u.valToPos(v, 'x') * d), near = (i) => at.some((a) => Math.abs(a - i) < 2.5); let [missing, stray] = [[], []]; for (const a of at) if (a > 2 && a < width - 2 && ![-1, 0, 1].some((k) => inked(Math.round(a) + k))) missing.push(a); for (let i = 0; i < width; i++) if (inked(i) && !near(i)) stray.push(i); return [missing, stray, at.length]; })";
    for row in browser.value(pixels).as_array().unwrap() {
        assert_eq!(
            row.as_array().unwrap()[..2],
            [json!([]), json!([])],
            "{row}"
        );
    }
    let csv = browser.value("G.csv(G.plots[0])");
    let rows = |text: &str, name: &str| text.lines().filter(|l| l.starts_with(name)).count() as u64;
    assert_eq!(rows(csv.as_str().unwrap(), "impact of pair"), made);
    let drawing = std::fs::read_to_string(svg).unwrap();
    for (name, count) in [("contact loss", lost), ("impact", made)] {
        assert!(drawing.contains(&format!("{name}: {count}")), "{name}");
    }
}

/// Without a history there is no plot, and the page says so.
#[test]
fn keeps_no_empty_plots() {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("page.html");
    let line = "simulate examples/linear_chain.toml --no-history";
    write_page(&line.split(' ').collect::<Vec<_>>(), &page);
    let text = std::fs::read_to_string(&page).unwrap();
    assert!(text.contains("\"figures\":[]"));
    assert!(text.contains("left out plots over time: the study has no history"));
}

/// A million points in two outputs: the size of the page; the times to its last stroke and of a zoom step are printed.
#[test]
#[ignore = "a study of half a minute: cargo test --test command million -- --ignored --nocapture"]
fn law_page_of_a_million_points() {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("page.html");
    let line = "simulate examples/linear_chain.toml --samples 1e6 --output chain.20.theta,chain.1.theta --no-sensitivity";
    write_page(&line.split(' ').collect::<Vec<_>>(), &page);
    let (whole, _) = sizes(&page);
    assert!(whole <= MILLION, "{whole} bytes");
    let mut browser = Browser::start(folder.path());
    browser.open(&format!("file://{}", page.display()));
    let ready = browser.value("document.documentElement.dataset.ready");
    browser.value("(G.plots[0].host.focus(), 0)");
    let step = "(async () => { const times = []; for (let k = 0; k < 12; k++) { const from = performance.now(); G.plots[0].host.dispatchEvent(new KeyboardEvent('keydown', { key: '+' })); await null; times.push(performance.now() - from); } return times; })()";
    println!(
        "{whole} bytes, ready after {ready} ms, zoom steps {} ms",
        browser.value(step)
    );
}

/// `--open` hands the page to the opener of the desktop, and is refused before any work where there is none.
#[test]
#[cfg(target_os = "linux")]
fn exact_open_calls_the_opener() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let (page, note) = (folder.path().join("page.html"), folder.path().join("note"));
    let run = |path: &Path| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_geardyn"));
        command
            .args([
                "modes",
                "models/two_disc.toml",
                "--quiet",
                "--open",
                "--html",
            ])
            .arg(&page)
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .env("PATH", path);
        command.output().unwrap()
    };
    let found = run(&folder.path().join("nowhere"));
    let message = String::from_utf8_lossy(&found.stderr);
    assert_eq!(found.status.code(), Some(2), "{message}");
    assert!(message.contains("xdg-open") && !page.exists(), "{message}");
    let opener = folder.path().join("xdg-open");
    let script = format!(
        "#!/bin/sh\necho \"$1\" > '{0}.part'; /bin/mv '{0}.part' '{0}'\n",
        note.display()
    );
    std::fs::write(&opener, script).unwrap();
    std::fs::set_permissions(&opener, std::fs::Permissions::from_mode(0o755)).unwrap();
    assert_eq!(run(folder.path()).status.code(), Some(0));
    // The command does not wait for the opener.
    while !note.exists() {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let opened = std::fs::read_to_string(&note).unwrap();
    assert_eq!(opened.trim_end(), page.to_str().unwrap());
}

/// Where reduced motion is requested, nothing moves unless it is played.
#[test]
#[cfg_attr(not(chromium), ignore = "needs chromium on the PATH")]
fn law_reduced_motion_is_obeyed() {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("page.html");
    write_page(&["modes", "models/two_disc.toml"], &page);
    let mut browser = Browser::start(folder.path());
    let features = json!([{ "name": "prefers-reduced-motion", "value": "reduce" }]);
    browser.call(
        "Emulation.setEmulatedMedia",
        json!({ "features": features }),
    );
    browser.open(&format!("file://{}", page.display()));
    let playing = browser.value("G.players.map((p) => p.playing)");
    assert_eq!(playing, json!([false]));
    let before = browser.value("G.players[0].frames");
    let later = "new Promise((done) => setTimeout(() => done(G.players[0].frames), 340))";
    assert_eq!(browser.value(later), before);
}

/// A second browser draws the same pages and opens a zoomed address.
#[test]
#[cfg_attr(not(firefox), ignore = "needs firefox on the PATH")]
fn law_pages_work_in_a_second_browser() {
    let folder = tempfile::tempdir().unwrap();
    let mut browser = Firefox::start(folder.path());
    for (k, kind) in SECOND.iter().enumerate() {
        let page = folder.path().join(format!("page{k}.html"));
        write_page(&kind.split(' ').collect::<Vec<_>>(), &page);
        let address = format!("file://{}", page.display());
        browser.open(&address);
        for (k, colours) in browser.value(INK).as_array().unwrap().iter().enumerate() {
            assert!(colours.as_u64() > Some(1), "{kind}: plot {k} has no ink");
        }
        if browser.value("G.plots.length") == json!(0) {
            continue;
        }
        let name = browser.value("G.plots[0].name");
        let whole = numbers(&browser.value(SHOWN))[0];
        let part = |a: f64, b: f64, share: f64| a + share * (b - a);
        let [x0, x1, y0, y1] = whole;
        let zoomed = [part(x0, x1, 0.25), part(x0, x1, 0.5), y0, y1];
        let range = zoomed.map(|v| v.to_string()).join(":");
        browser.open(&format!("{address}#{}={range}", name.as_str().unwrap()));
        let again = numbers(&browser.value(SHOWN))[0];
        for (a, b) in again.iter().zip(zoomed) {
            // The last digit may change on the way through text.
            assert!((a - b).abs() <= 1e-14 * b.abs(), "{kind}: {a} {b}");
        }
    }
}
