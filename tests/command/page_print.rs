//! Pages on paper and in both themes, drawings whose texts stay apart.

use std::path::Path;
use std::process::Command;

use serde_json::{Value, json};

use super::chromium::Browser;

/// Runs a command with further arguments; its standard output.
fn run(line: &str, more: &[&str]) -> Vec<u8> {
    let found = Command::new(env!("CARGO_BIN_EXE_geardyn"))
        .args(line.split(' '))
        .args(more)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap();
    let message = String::from_utf8_lossy(&found.stderr);
    assert!(found.status.code() < Some(2), "{line}: {message}");
    found.stdout
}

/// Opens the page of a command.
fn open(browser: &mut Browser, folder: &Path, line: &str) {
    let page = folder.join("page.html");
    run(line, &["--html", page.to_str().unwrap()]);
    browser.open(&format!("file://{}", page.display()));
}

/// On paper narrower than the screen, as a browser lays it out without calling for new sizes, every picture, table and line of text is whole,
/// pictures keep their proportions, and the page is light, pictures in space as well.
#[test]
#[cfg_attr(not(chromium), ignore = "needs chromium on the PATH")]
fn law_print_is_whole_and_light() {
    let folder = tempfile::tempdir().unwrap();
    let mut browser = Browser::start(folder.path());
    for line in [
        "simulate examples/linear_chain.toml",
        "modes models/geared_damped.toml",
        "measure data/index_gear.toml",
        "gear models/gears/bevel_12_36.toml",
    ] {
        open(&mut browser, folder.path(), line);
        if browser.value("document.documentElement.classList.contains('dark')") == json!(false) {
            browser.press("t");
        }
        browser.value("(G.players.forEach((p) => p.set(false)), document.querySelectorAll('details').forEach((d) => { d.open = true; }), dispatchEvent(new Event('beforeprint')), document.body.style.width = '680px', 0)");
        browser.call("Emulation.setEmulatedMedia", json!({ "media": "print" }));
        let cut = "[...document.querySelectorAll('main *')].filter((e) => e.getBoundingClientRect().right > document.body.getBoundingClientRect().right + 1).map((e) => e.tagName + ' ' + e.className)";
        assert_eq!(browser.value(cut), json!([]), "{line}: cut");
        let stretched = "[...document.querySelectorAll('canvas')].filter((c) => c.clientWidth && Math.abs((c.clientHeight / c.clientWidth) / (c.height / c.width) - 1) > 0.02).length";
        assert_eq!(browser.value(stretched), json!(0), "{line}: stretched");
        let corners = "[...document.querySelectorAll('.printed')].map((c) => [...c.getContext('2d').getImageData(2, 2, 1, 1).data])";
        let corners = browser.value(corners);
        assert_eq!(
            corners.as_array().unwrap().is_empty(),
            !line.starts_with("gear ")
        );
        for corner in corners.as_array().unwrap() {
            assert_eq!(corner, &json!([255, 255, 255, 255]), "{line}");
        }
        browser.call("Emulation.setEmulatedMedia", json!({ "media": "" }));
        let after = "(dispatchEvent(new Event('afterprint')), [document.documentElement.classList.contains('dark'), document.querySelectorAll('.printed').length])";
        assert_eq!(browser.value(after), json!([true, 0]), "{line}");
    }
}

/// Drawings take the inks of the theme, and tables on a page six digits.
#[test]
#[cfg_attr(not(chromium), ignore = "needs chromium on the PATH")]
fn law_drawings_follow_the_theme() {
    let folder = tempfile::tempdir().unwrap();
    let mut browser = Browser::start(folder.path());
    open(
        &mut browser,
        folder.path(),
        "modes models/geared_damped.toml",
    );
    let inks = "[['text', 2, 100], ['rect', 2, 0]].map(([name, series, share]) => { const probe = document.createElement('p'); document.body.append(probe); probe.style.color = `color-mix(in srgb, var(--series-${series}) ${share}%, var(--paper))`; const wanted = getComputedStyle(probe).color; probe.remove(); return [getComputedStyle(document.querySelector('.drawing ' + name)).fill, wanted]; })";
    let both = [(); 2].map(|()| {
        let found = browser.value(inks);
        for pair in found.as_array().unwrap() {
            assert_eq!(pair[0], pair[1]);
        }
        browser.press("t");
        found
    });
    assert_ne!(both[0], both[1]);
    let longest = "Math.max(...[...document.querySelectorAll('details td')].map((c) => c.textContent).filter((t) => Number.isFinite(Number(t.replace('−', '-')))).map((t) => t.length))";
    let longest = browser.value(longest).as_u64().unwrap();
    assert!((6..=12).contains(&longest), "{longest} characters");
}

/// Nodes of an ease-off without a value are no corner of a triangle.
#[test]
#[cfg_attr(not(chromium), ignore = "needs chromium on the PATH")]
fn exact_surface_has_its_holes() {
    let line = "gear models/gears/bevel_12_36.toml";
    let document: Value = serde_json::from_slice(&run(line, &["--json"])).unwrap();
    let rows = document["ease_off"]["grid_um"].as_array().unwrap();
    let values: Vec<&Value> = rows
        .iter()
        .flat_map(|row| row.as_array().unwrap())
        .collect();
    let holes: Vec<usize> = (0..values.len()).filter(|&k| values[k].is_null()).collect();
    assert!(!holes.is_empty() && holes.len() < 20, "{holes:?}");
    let folder = tempfile::tempdir().unwrap();
    let mut browser = Browser::start(folder.path());
    open(&mut browser, folder.path(), line);
    let corners = browser.value("[...new Set(G.spaces.at(-1).items[0].mesh.triangles)]");
    let mut corners: Vec<usize> = (corners.as_array().unwrap().iter())
        .map(|k| k.as_u64().unwrap() as usize)
        .collect();
    corners.sort_unstable();
    let whole: Vec<usize> = (0..values.len()).filter(|k| !holes.contains(k)).collect();
    assert_eq!(corners, whole);
}

/// No text of a drawing lies over another or leaves the drawing.
#[test]
#[cfg_attr(not(chromium), ignore = "needs chromium on the PATH")]
fn law_texts_of_drawings_are_apart() {
    let folder = tempfile::tempdir().unwrap();
    let mut browser = Browser::start(folder.path());
    let drawing = folder.path().join("drawing.svg");
    for line in [
        "modes models/stiff_chain.toml",
        "modes models/extreme_chain.toml",
        "modes models/overhung_rotor.toml --campbell 0:12000:21",
        "simulate examples/linear_chain.toml",
        "te models/three_stage_chain.toml --output spindle",
        "gear models/gears/bevel_12_36.toml",
    ] {
        run(line, &["--svg", drawing.to_str().unwrap(), "--quiet"]);
        for file in std::fs::read_dir(folder.path()).unwrap() {
            let file = file.unwrap().path();
            if file.extension().is_none_or(|e| e != "svg") {
                continue;
            }
            let page = folder.path().join("drawing.html");
            let svg = std::fs::read_to_string(&file).unwrap();
            let html = format!(
                "<!doctype html><html data-ready='1'><meta charset='utf-8'><body style='margin: 0'>{svg}"
            );
            std::fs::write(&page, html).unwrap();
            browser.open(&format!("file://{}", page.display()));
            let clashes = "(() => { const frame = document.querySelector('svg').getBoundingClientRect(), all = [...document.querySelectorAll('text')].map((e) => { const b = e.getBoundingClientRect(), up = /rotate/.test(e.getAttribute('transform') ?? ''); const [w, h] = up ? [0.2 * b.width, 0] : [0, 0.2 * b.height]; return [e.textContent.trim(), b.left + w, b.top + h, b.right - w, b.bottom - h]; }); return all.flatMap(([text, l, t, r, b], i) => [...(l < frame.left || t < frame.top || r > frame.right || b > frame.bottom ? [text + ' leaves'] : []), ...all.slice(0, i).filter(([, x, y, z, w]) => l + 1 < z && x + 1 < r && t + 1 < w && y + 1 < b).map((o) => text + ' over ' + o[0])]); })()";
            assert_eq!(
                browser.value(clashes),
                json!([]),
                "{line}: {}",
                file.display()
            );
            std::fs::remove_file(&file).unwrap();
        }
    }
}
