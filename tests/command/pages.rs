//! Pages of reports in a browser: no request, no message, ink in every plot, zoom, address, keys, CSV, names with markup.

use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use serde_json::{Value, json};

/// A page of every kind of answer: the arguments without `--html`.
const KINDS: &[&str] = &[
    "modes models/geared_damped.toml",
    "modes models/overhung_rotor.toml --campbell 0:12000:61",
    "response models/y2250.toml --input index_drive.te --output workpiece --hold motor --band 1:400",
    "response models/y2250.toml --run-up 50:3000:40",
    "response examples/backlash_jumps.toml --harmonic-balance 2000:7000:30",
    "simulate examples/linear_chain.toml",
    "accuracy models/y2250.toml --of modes",
    "stability models/geared_damped.toml",
    "te models/three_stage_chain.toml --output spindle",
    "te data/y2250_te.csv --input index_gear_1 --output work_spindle --teeth 30:37,54:36,1:90 --lines 10000,36000",
    "identify data/spindle_impact.csv --input force --output ax,ay",
    "spectrum data/spindle_impact.csv --channel ax",
    "spectrum data/spindle_impact.csv --channel ax --kind spectrogram",
    "measure data/index_gear.toml",
    "gear models/gears/fzg_c.toml --torques 50:500:4",
    "gear reverse data/unknown_gear.toml",
    "gear cut models/gears/bevel_12_36.toml",
    "run examples/y2250_te.toml",
];

/// The name of a channel that would be markup.
const HOSTILE: &str = "</script><img/src=x/onerror=alert(1)>";

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
    assert!(text.len() < 350_000, "{} bytes", text.len());
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

/// Every kind of page in a browser: what a user does works, and nothing is requested or complained of.
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
        browser.check(kind, &page);
    }
}

/// Chromium by its debugging protocol over two pipes.
struct Browser {
    child: Child,
    to: ChildStdin,
    from: BufReader<ChildStdout>,
    session: String,
    count: u64,
    events: Vec<Value>,
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Browser {
    /// A browser without a window and without a page; its profile lies in the folder.
    fn start(folder: &Path) -> Browser {
        let profile = folder.join("profile");
        let command = format!(
            "exec chromium --headless --no-sandbox --disable-gpu --no-first-run --window-size=1200,900 --user-data-dir='{}' --remote-debugging-pipe about:blank 3<&0 4>&1 0</dev/null 1>&2",
            profile.display()
        );
        let mut child = Command::new("sh")
            .args(["-c", &command])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let (to, from) = (child.stdin.take().unwrap(), child.stdout.take().unwrap());
        let mut browser = Browser {
            child,
            to,
            from: BufReader::new(from),
            session: String::new(),
            count: 0,
            events: Vec::new(),
        };
        let made = browser.call("Target.createTarget", json!({ "url": "about:blank" }));
        let target = json!({ "targetId": made["targetId"], "flatten": true });
        let attached = browser.call("Target.attachToTarget", target);
        browser.session = attached["sessionId"].as_str().unwrap().to_string();
        for domain in ["Page", "Runtime", "Network", "Log"] {
            browser.call(&format!("{domain}.enable"), json!({}));
        }
        browser
    }

    /// The result of a command; events that arrive before it are kept.
    fn call(&mut self, method: &str, params: Value) -> Value {
        self.count += 1;
        let id = self.count;
        let mut message = json!({ "id": id, "method": method, "params": params });
        if !self.session.is_empty() {
            message["sessionId"] = json!(self.session);
        }
        self.to.write_all(message.to_string().as_bytes()).unwrap();
        self.to.write_all(&[0]).unwrap();
        self.to.flush().unwrap();
        loop {
            let answer = self.read();
            if answer["id"] == json!(id) {
                assert!(answer["error"].is_null(), "{method}: {answer}");
                return answer["result"].clone();
            }
            self.events.push(answer);
        }
    }

    fn read(&mut self) -> Value {
        let mut bytes = Vec::new();
        let count = self.from.read_until(0, &mut bytes).unwrap();
        assert!(count > 0, "the browser ended");
        serde_json::from_slice(bytes.strip_suffix(&[0]).unwrap()).unwrap()
    }

    /// The value of an expression in the page.
    fn value(&mut self, expression: &str) -> Value {
        let params =
            json!({ "expression": expression, "returnByValue": true, "awaitPromise": true });
        let found = self.call("Runtime.evaluate", params);
        assert!(found["exceptionDetails"].is_null(), "{expression}: {found}");
        found["result"]["value"].clone()
    }

    /// Opens a page and waits until all is drawn.
    fn open(&mut self, address: &str) {
        self.call("Page.navigate", json!({ "url": "about:blank" }));
        self.events.clear();
        self.call("Page.navigate", json!({ "url": address }));
        let drawn = "new Promise((done) => { const look = () => document.documentElement?.dataset.ready ? done(true) : setTimeout(look, 5); look(); })";
        assert_eq!(self.value(drawn), json!(true), "{address}");
    }

    /// Presses and releases the mouse between two places of the window.
    fn drag(&mut self, from: (f64, f64), to: (f64, f64)) {
        let events = [
            ("mousePressed", from),
            ("mouseMoved", to),
            ("mouseReleased", to),
        ];
        for (kind, (x, y)) in [("mouseMoved", from)].into_iter().chain(events) {
            let params = json!({ "type": kind, "x": x, "y": y, "button": "left", "clickCount": 1 });
            self.call("Input.dispatchMouseEvent", params);
        }
    }

    fn press(&mut self, key: &str) {
        for kind in ["keyDown", "keyUp"] {
            let text = if kind == "keyDown" && key.len() == 1 {
                key
            } else {
                ""
            };
            let params = json!({ "type": kind, "key": key, "text": text });
            self.call("Input.dispatchKeyEvent", params);
        }
    }

    fn check(&mut self, kind: &str, page: &Path) {
        let address = format!("file://{}", page.display());
        self.open(&address);
        // Ink: pixels of a curve or a map inside the axes of each plot.
        let ink = self.value(
            "G.plots.map((p) => { const b = p.u.bbox; const d = p.u.ctx.getImageData(b.left + 2, b.top + 2, b.width - 4, b.height - 4).data; const colours = new Set(); for (let i = 0; i < d.length; i += 4) if (d[i + 3] > 200) colours.add((d[i] << 16) + (d[i + 1] << 8) + d[i + 2]); return colours.size; })",
        );
        for (k, colours) in ink.as_array().unwrap().iter().enumerate() {
            assert!(colours.as_u64() > Some(1), "{kind}: plot {k} has no ink");
        }
        let shown = "JSON.stringify(G.plots.map((p) => [p.shown.x, p.shown.y]))";
        let whole = self.value(shown);
        if !ink.as_array().unwrap().is_empty() {
            self.zoom(kind, &address, shown);
            assert_eq!(self.value(shown), whole, "{kind}: all is shown again");
            let csv = self.value("G.plots.map((p) => G.csv(p).split('\\n').length)");
            let rows = csv.as_array().unwrap();
            assert!(rows.iter().all(|n| n.as_u64() > Some(2)), "{kind}: {csv}");
        }
        let dark = "document.documentElement.classList.contains('dark')";
        let before = self.value(dark);
        self.press("t");
        assert_ne!(self.value(dark), before, "{kind}: key t");
        let text = self.value("document.querySelector('pre').textContent.length");
        assert!(text.as_u64() > Some(20), "{kind}: no text");
        for event in std::mem::take(&mut self.events) {
            let method = event["method"].as_str().unwrap_or_default();
            let complaint = [
                "Runtime.exceptionThrown",
                "Runtime.consoleAPICalled",
                "Log.entryAdded",
            ];
            assert!(!complaint.contains(&method), "{kind}: {event}");
            if method == "Network.requestWillBeSent" {
                let url = event["params"]["request"]["url"].as_str().unwrap();
                assert!(
                    url.starts_with(&address) || url.starts_with("about:"),
                    "{kind}: {url}"
                );
            }
        }
    }

    /// Zooms the first plot by the mouse, opens the address anew, and goes back by a key.
    fn zoom(&mut self, kind: &str, address: &str, shown: &str) {
        self.value("(G.plots[0].host.scrollIntoView({ block: 'center' }), 0)");
        let place = self.value(
            "(() => { const r = G.plots[0].u.over.getBoundingClientRect(); return [r.left, r.top, r.width, r.height]; })()",
        );
        let [left, top, width, height] = [0, 1, 2, 3].map(|k| place[k].as_f64().unwrap());
        let whole = self.value(shown);
        let at = |x: f64, y: f64| (left + x * width, top + y * height);
        self.drag(at(0.3, 0.2), at(0.6, 0.8));
        let zoomed = self.value(shown);
        assert_ne!(zoomed, whole, "{kind}: dragging zooms");
        let hash = self.value("location.hash");
        let hash = hash.as_str().unwrap();
        assert!(hash.len() > 5, "{kind}: the address holds the range");
        self.open(&format!("{address}{hash}"));
        let again = self.value(shown);
        let numbers = |v: &Value| -> Vec<f64> {
            let all: Vec<[[f64; 2]; 2]> = serde_json::from_str::<Value>(v.as_str().unwrap())
                .unwrap()
                .as_array()
                .unwrap()
                .iter()
                .map(|p| [0, 1].map(|i| [0, 1].map(|k| p[i][k].as_f64().unwrap())))
                .collect();
            all.as_flattened().as_flattened().to_vec()
        };
        for (a, b) in numbers(&again).iter().zip(numbers(&zoomed)) {
            assert!(
                (a - b).abs() <= 1e-5 * b.abs().max(1e-30),
                "{kind}: {a} {b}"
            );
        }
        self.value("(G.plots[0].host.focus(), 0)");
        self.press("+");
        assert_ne!(self.value(shown), again, "{kind}: key +");
        self.press("0");
    }
}
