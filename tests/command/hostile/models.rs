//! Wrong model files and scenes.

use super::Row;

/// A model without fault; the rows count its lines.
pub const GOOD: &str = r#"title = "Motor, gear pair, roll"
[[inertia]]
name = "motor"
J = "0.0095 kg·m²"
[[inertia]]
name = "pinion"
J = "0.002 kg·m²"
[[inertia]]
name = "wheel"
J = "0.3 kg·m²"
[[shaft]]
name = "motor_shaft"
between = ["motor", "pinion"]
k = "8.5 kN·m/rad"
damping_ratio = 0.01
[[gear_pair]]
name = "first_pair"
between = ["pinion", "wheel"]
teeth = [21, 63]
module = "3 mm"
k = "420 N/µm"
backlash = "80 µm"
[[shaft]]
name = "bar"
between = ["wheel", "ground"]
length = "1 m"
diameter = "40 mm"
bore = "10 mm"
material = "steel"
"#;

/// The good model with one text in place of another, and what `check` names.
#[rustfmt::skip]
const CHANGED: &[(&str, &str, &str)] = &[
    ("k = \"420 N/µm\"", "stifness = \"420 N/µm\"", "[unknown-key] | m.toml:21: | unknown key `stifness` | did you mean `k`? it takes N/m, N/µm, kN/mm"),
    ("backlash", "backlsh", "[unknown-key] | m.toml:22: | `backlsh` | did you mean `backlash`? it takes m, mm, µm, in"),
    ("\"80 µm\"", "\"1e-40 m\"", "[out-of-range] | m.toml:22: | below any physical backlash | omit it, or write 0"),
    ("\"80 µm\"", "\"1e-300 m\"", "[out-of-range] | m.toml:22: | `backlash` is below 1e-50 in SI units | for none write 0 or omit it"),
    ("\"80 µm\"", "\"1e300 m\"", "[out-of-range] | m.toml:22: | `backlash` must not exceed 1e50 in SI units | m, mm"),
    ("\"80 µm\"", "\"1e9 m\"", "[out-of-range] | m.toml:22: | must not exceed 1 m: the deflection of the contact | check its unit"),
    ("\"0.3 kg·m²\"", "\"1e300 kg·m²\"", "[out-of-range] | m.toml:10: | `J` must not exceed 1e50 | kg·m²"),
    ("\"0.3 kg·m²\"", "\"1e-300 kg·m²\"", "[out-of-range] | m.toml:10: | `J` is below 1e-50 | write 0"),
    ("\"8.5 kN·m/rad\"", "\"1e300 N·m/rad\"", "[out-of-range] | m.toml:14: | `k` must not exceed 1e50 | N·m/rad"),
    ("\"420 N/µm\"", "\"1e-300 N/m\"", "[out-of-range] | m.toml:21: | `k` is below 1e-50 | write 0"),
    ("\"3 mm\"", "\"1e-300 mm\"", "[out-of-range] | m.toml:20: | `module` is below 1e-50 | write 0"),
    ("\"3 mm\"", "\"1e300 mm\"", "[out-of-range] | m.toml:20: | `module` must not exceed 1e50 | m, mm"),
    ("damping_ratio = 0.01", "damping_ratio = 1e300", "[out-of-range] | m.toml:15: | `damping_ratio` must not exceed 1e50 | number without unit"),
    ("backlash = \"80 µm\"", "k_wave = { kind = \"rectangular\", high = 1.0, low = 0.0, share = 0.5 }", "[out-of-range] | m.toml:22: | `low` makes the wave zero or negative | mesh stiffness must be positive"),
    ("backlash = \"80 µm\"", "k_wave = { kind = \"rectangular\", high = 0.0, low = 1.0, share = 0.5 }", "[out-of-range] | m.toml:22: | `high` makes the wave zero or negative | above zero"),
    ("backlash = \"80 µm\"", "k_wave = { kind = \"table\", values = [0, 0] }", "[out-of-range] | m.toml:22: | `values` makes the wave zero or negative | above zero"),
    ("backlash = \"80 µm\"", "k_wave = { kind = \"fourier\", amplitudes = [0.5, 0.5] }", "[out-of-range] | m.toml:22: | `amplitudes` makes the wave zero or negative | below the mean"),
    ("name = \"wheel\"\nJ", "name = \"wh\\neel\"\nJ", "[out-of-range] | m.toml:9: | a name cannot contain | a line end"),
    ("title", "tilte", "[unknown-key] | m.toml:1: | `tilte` | `title`"),
    ("\"pinion\", \"wheel\"", "\"pinoin\", \"wheel\"", "[unknown-node] | m.toml:18: | no node `pinoin` | did you mean `pinion`?"),
    ("\"pinion\", \"wheel\"", "\"motor_shaft\", \"wheel\"", "[unknown-node] | m.toml:18: | no node `motor_shaft` | not a body"),
    ("name = \"wheel\"\nJ", "name = \"wheel\"\nname_ = 1\nJ", "[unknown-key] | m.toml:10: | `name_` | `name`"),
    ("\"0.3 kg·m²\"", "0.3", "[missing-unit] | m.toml:10: | `J` has no unit | write \"0.3 kg·m²\""),
    ("\"0.3 kg·m²\"", "\"0.3\"", "[missing-unit] | m.toml:10: | `J` has no unit | kg·m², kg·cm²"),
    ("8.5 kN·m/rad", "8.5 kN/mm", "[wrong-unit] | m.toml:14: | kN/mm measures translational stiffness | `k` takes N·m/rad, kN·m/rad"),
    ("8.5 kN·m/rad", "8.5 foo", "[wrong-unit] | m.toml:14: | \"foo\" is not a known unit | `k` takes N·m/rad"),
    ("\"0.3 kg·m²\"", "\"-0.3 kg·m²\"", "[out-of-range] | m.toml:10: | `J` must not be negative | kg·m²"),
    ("\"0.3 kg·m²\"", "\"nan kg·m²\"", "[out-of-range] | m.toml:10: | not a finite number | finite"),
    ("\"0.3 kg·m²\"", "nan", "[out-of-range] | m.toml:10: | must be a finite number | kg·m²"),
    ("\"0.3 kg·m²\"", "1e400", "[out-of-range] | m.toml:10: | must be a finite number | kg·m²"),
    ("\"0.3 kg·m²\"", "\"1e400 kg·m²\"", "[out-of-range] | m.toml:10: | exceeds the largest double | finite"),
    ("\"0.3 kg·m²\"", "inf", "[out-of-range] | m.toml:10: | must be a finite number | kg·m²"),
    ("\"0.3 kg·m²\"", "true", "[wrong-type] | m.toml:10: | `J` is true or false | kg·m²"),
    ("\"0.3 kg·m²\"", "1979-05-27", "[wrong-type] | m.toml:10: | `J` is a date | kg·m²"),
    ("J = \"0.3 kg·m²\"", "", "[missing-key] | m.toml:8: | has no `J` | kg·m²"),
    ("[21, 63]", "[0, 63]", "[out-of-range] | m.toml:19: | `teeth` cannot be 0 | whole numbers from 1"),
    ("[21, 63]", "[21, 63.5]", "[out-of-range] | m.toml:19: | `teeth` cannot be 63.5 | whole numbers"),
    ("[21, 63]", "[21]", "[wrong-type] | m.toml:19: | `teeth` has 1 values | a list of 2"),
    ("[21, 63]", "[99999999999999999999, 63]", "[out-of-range] | m.toml:19: | cannot be 99999999999999999999 | whole numbers"),
    ("\"10 mm\"", "\"40 mm\"", "[out-of-range] | m.toml:28: | the bore of 40 mm | inner diameter"),
    ("[21, 63]", "[21, 63]\nhelix_angle = \"90 deg\"", "[out-of-range] | m.toml:20: | below 90° | deg"),
    ("[21, 63]", "[21, 63]\npressure_angle = \"45 deg\"", "[out-of-range] | m.toml:20: | below 45° | deg"),
    ("[21, 63]", "[21, 21]\ninternal = true", "[out-of-range] | m.toml:19: | ring of 21 | second gear"),
    ("\"420 N/µm\"", "\"-420 N/µm\"", "[out-of-range] | m.toml:21: | `k` must not be negative | N/m"),
    ("damping_ratio = 0.01", "damping_ratio = -0.01", "[out-of-range] | m.toml:15: | must not be negative | number without unit"),
    ("damping_ratio = 0.01", "damping_ratio = \"1 %\"", "[wrong-type] | m.toml:15: | is text | number without unit"),
    ("damping_ratio = 0.01", "damping_ratio = 0.01\nloss_factor = 0.1", "[conflict] | m.toml:16: | exclude each other | omit `"),
    ("k = \"8.5 kN·m/rad\"", "", "[conflict] | m.toml:15: | rigid element | give `k`"),
    ("length = \"1 m\"", "length = \"1 m\"\nk = \"1 N·m/rad\"", "[conflict] | m.toml:27: | `k` is given, but is also determined by `length` | only"),
    ("module = \"3 mm\"", "", "[missing-key] | m.toml:16: | has no `module` | `module` takes m, mm"),
    ("\"motor\", \"pinion\"", "\"motor\", \"motor\"", "[conflict] | m.toml:13: | both ends are `motor` | two nodes"),
    ("\"motor\", \"pinion\"", "\"ground\", \"ground\"", "[conflict] | m.toml:13: | both ends are `ground` | two nodes"),
    ("\"motor\", \"pinion\"", "\"motor\"", "[wrong-type] | m.toml:13: | `between` has 1 names | two nodes"),
    ("\"pinion\", \"wheel\"", "\"ground\", \"wheel\"", "[conflict] | m.toml:18: | `ground` cannot turn | [[coupling]]"),
    ("\"steel\"", "\"steal\"", "[out-of-range] | m.toml:29: | cannot be \"steal\" | did you mean \"steel\"?"),
    ("name = \"motor\"", "name = \"mo.tor\"", "[unknown-node] | m.toml:13: | no node `motor`"),
    ("[[shaft]]\nname = \"bar\"", "[shafts]\nname = \"bar\"", "[unknown-key] | m.toml:23: | `shafts` | did you mean `shaft`?"),
    ("name = \"bar\"", "name = \"pinion\"", "[duplicate-name] | m.toml:24: | first used in line 6"),
    ("J = \"0.3 kg·m²\"\n", "J = 0.3\nteeth = [1, 2\n", "[missing-unit] | m.toml:10: | [syntax]"),
    ("title", "title = \"a\"\ntitle", "[syntax] | m.toml:2:"),
];

/// Whole files, and what `check` names.
#[rustfmt::skip]
const WHOLE: &[(&str, &str)] = &[
    ("", "[empty-machine] | geardyn new"),
    ("\n\n", "[empty-machine] | geardyn new"),
    ("\u{feff}", "[empty-machine] | geardyn new"),
    ("# nothing\n", "[empty-machine] | geardyn new"),
    ("title = \"a\"\n", "[empty-machine] | geardyn new"),
];

/// What follows a scene's `model` line, and what `check` names.
#[rustfmt::skip]
const SCENES: &[(&str, &str)] = &[
    ("[set]\n\"motr_shaft.k\" = \"1 N·m/rad\"", "[unknown-key] | s.toml:3: | no element `motr_shaft` | `motor_shaft`"),
    ("[set]\n\"motor_shaft.kk\" = \"1 N·m/rad\"", "[unknown-key] | s.toml:3: | unknown key | `k`"),
    ("[set]\n\"motor_shaft.k\" = \"1 N/m\"", "[wrong-unit] | s.toml:3: | translational | N·m/rad"),
    ("[set]\nfirst_pair.teeth = [0, 1]", "[out-of-range] | s.toml:3: | cannot be 0"),
    ("[set]\nk = 1", "[unknown-key] | s.toml:3: | names no key | element.key"),
    ("set = 1", "[wrong-type] | s.toml:2: | `set` is a number | [set]"),
    ("[[load]]\nat = \"whel\"\ntorque = \"1 N·m\"", "[unknown-node] | s.toml:3: | no node `whel` | `wheel`"),
    ("[[study]]\nkind = \"mode\"", "[out-of-range] | s.toml:3: | cannot be \"mode\" | \"modes\""),
    ("[[study]]\nkind = \"modes\"\ncampbell = \"3:1\"", "[out-of-range] | s.toml:4: | range of speeds | first:last"),
    ("[[shaft]]\nname = \"x\"", "[unknown-key] | s.toml:2: | unknown key `shaft`"),
];

/// The name and inertia of a body.
type Body = (&'static str, &'static str);

/// The name, the ends and the stiffness of a coupling.
type Coupling = (&'static str, &'static str, &'static str, &'static str);

type Machine = (
    &'static [Body],
    &'static [Coupling],
    &'static str,
    &'static str,
    i32,
    &'static str,
);

/// Bodies `name J`, couplings `name end end k` and further text of a model in SI units; the arguments, the exit code, what is named.
#[rustfmt::skip]
const MACHINES: &[Machine] = &[
    (&[("a", "1"), ("b", "1"), ("alone", "1")], &[("s", "a", "b", "1e3")], "", "modes FILE", 2, "[disconnected] | `alone` | m.toml:11:"),
    (&[("a", "1"), ("light", "0")], &[], "[[damper]]\nname = \"d\"\nbetween = [\"a\", \"light\"]\nc = 1.0\n", "modes FILE", 2, "[disconnected] | light.theta"),
    (&[("a", "1")], &[("s", "a", "ground", "1e3")], "", "modes FILE --speed 10", 2, "[no-speed]"),
    (&[("a", "1"), ("b", "1"), ("c", "1"), ("d", "1")], &[("x", "a", "b", "1e3"), ("y", "c", "d", "1e3")], "[speed]\na = 100.0\n", "modes FILE --speed 10", 2, "[no-speed] | c"),
    (&[("a", "1"), ("b", "1")], &[("s", "a", "b", "0")], "", "modes FILE", 0, "rigid body"),
    (&[("a", "0"), ("b", "0")], &[("s", "a", "b", "1")], "", "modes FILE", 2, "[disconnected] | b.theta"),
    (&[("a", "1e50"), ("b", "1e50")], &[("s", "a", "b", "1e-50")], "", "modes FILE", 0, "rigid body"),
    (&[("a", "1e51"), ("b", "1")], &[("s", "a", "b", "1")], "", "modes FILE", 2, "[out-of-range] | m.toml:6:"),
    (&[("ground", "1"), ("b", "1")], &[("s", "ground", "b", "1")], "", "modes FILE", 2, "ground"),
    (&[("a", "1"), ("b", "1")], &[("s", "a", "b", "1")], "[[load]]\nat = \"a\"\ntorque = 1e300\n", "simulate FILE --until 1", 2, "[out-of-range] | torque"),
    (&[("a", "1"), ("b", "1")], &[("s", "a", "b", "1")], "[start]\nstate = \"nonsense\"\n", "simulate FILE --until 1", 2, "[missing-key] | m.toml:1:"),
    (&[("a", "1"), ("b", "1")], &[("s", "a", "b", "1")], "[speed]\nnowhere = 1.0\n", "modes FILE", 2, "nowhere | m.toml:"),
    (&[("a", "1"), ("b", "1")], &[("s", "a", "b", "1")], "[speed]\na = nan\n", "modes FILE", 2, "m.toml:15:"),
];

/// A model of bodies and couplings in SI units.
fn machine(bodies: &[Body], couplings: &[Coupling], more: &str) -> String {
    let mut text = "title = \"t\"\nsource = \"test\"\nunits = \"SI\"\n".to_string();
    for (name, inertia) in bodies {
        text += &format!("[[inertia]]\nname = \"{name}\"\nJ = {inertia}\n");
    }
    for (name, a, b, k) in couplings {
        text +=
            &format!("[[coupling]]\nname = \"{name}\"\nbetween = [\"{a}\", \"{b}\"]\nk = {k}\n");
    }
    text + more
}

/// A node without inertia at which 2100 couplings meet.
fn star() -> String {
    const ARMS: usize = 2100;
    let arms: Vec<String> = (0..ARMS).map(|k| format!("a{k}")).collect();
    let bodies = arms
        .iter()
        .map(|a| format!("{{ name = \"{a}\", J = 1.0 }}, "));
    let arms = arms
        .iter()
        .enumerate()
        .map(|(k, a)| format!("{{ name = \"s{k}\", between = [\"hub\", \"{a}\"], k = 1e3 }}, "));
    let head = "title = \"t\"\nsource = \"test\"\nunits = \"SI\"\n";
    format!(
        "{head}inertia = [{}{{ name = \"hub\", J = 0.0 }}]\ncoupling = [{}]\n",
        bodies.collect::<String>(),
        arms.collect::<String>()
    )
}

/// Texts that nest beyond all bounds.
fn deep() -> [String; 4] {
    const DEPTH: usize = 100_000;
    [
        format!("a = {}", "[".repeat(DEPTH)),
        format!("a = {}", "{a = ".repeat(DEPTH)),
        format!("a{} = 1", ".a".repeat(DEPTH)),
        format!("[[a{}]]", ".a".repeat(DEPTH)),
    ]
}

/// The good model with four faults.
fn four_faults() -> String {
    GOOD.replacen("J = \"0.002 kg·m²\"", "J = 1", 1)
        .replacen("\"10 mm\"", "\"50 mm\"", 1)
        .replacen("\"motor\", \"pinion\"", "\"motr\", \"pinion\"", 1)
        .replacen("teeth = [21, 63]", "teeth = [21, 0]", 1)
}

/// The rows of this table.
pub fn rows() -> Vec<Row> {
    let changed = CHANGED.iter().map(|(from, to, says)| {
        assert!(GOOD.contains(from), "{from}");
        Row::new("m.toml", GOOD.replacen(from, to, 1), "check FILE", 2, says)
    });
    let whole = WHOLE
        .iter()
        .map(|(text, says)| Row::new("m.toml", *text, "check FILE", 2, says));
    let scenes = SCENES.iter().map(|(text, says)| {
        let text = format!("model = \"good.toml\"\n{text}\n");
        Row::new("s.toml", text, "check FILE", 2, says)
    });
    let machines = MACHINES
        .iter()
        .map(|&(bodies, couplings, more, line, exit, says)| {
            Row::new("m.toml", machine(bodies, couplings, more), line, exit, says)
        });
    let deep = deep()
        .into_iter()
        .map(|text| Row::new("m.toml", text, "check FILE", 2, "[syntax] | m.toml:1:"));
    let latin = *b"title = \"a\"\nsource = \"Stra\xdfe\"\n";
    let bytes = [
        Row::new(
            "m.toml",
            latin,
            "check FILE",
            2,
            "[not-text] | m.toml:2: | byte 26",
        ),
        Row::new("m.toml", *b"\xff\xfe[\x00", "check FILE", 2, "[not-text]"),
        Row::new(
            "m.toml",
            *b"title = \"a\x00b\"\n",
            "check FILE",
            2,
            "[syntax] | m.toml:1:",
        ),
        Row::new(
            "m.toml",
            star(),
            "simulate FILE --until 1",
            3,
            "[budget-exceeded] | hub.theta has no inertia and joins 2100 branches | 4e6 terms (limit 4e6)",
        ),
        Row::new("", "", "check good.toml", 0, "good.toml"),
        Row::new(
            "m.toml",
            four_faults(),
            "check FILE",
            2,
            "m.toml:7: | m.toml:13: | m.toml:19: | and 1 more error",
        ),
        Row::new(
            "m.toml",
            four_faults(),
            "check FILE --json",
            2,
            "\"line\": 7 | \"line\": 13 | \"line\": 19 | \"line\": 28",
        ),
        Row::new(
            "s.toml",
            "model = \"none.toml\"\n",
            "check FILE",
            2,
            "[file-missing] | s.toml:1:",
        ),
        Row::new(
            "s.toml",
            "model = \".\"\n",
            "check FILE",
            2,
            "[file-missing] | s.toml:1:",
        ),
        Row::new(
            "s.toml",
            "model = \"s.toml\"\n",
            "check FILE",
            2,
            "[conflict] | s.toml:1:",
        ),
        Row::new("s.toml", "model = \"\"\n", "check FILE", 2, "s.toml:1:"),
        Row::new(
            "s.toml",
            "model = \"/dev/zero\"\n",
            "check FILE",
            2,
            "[file-missing] | s.toml:1:",
        ),
    ];
    changed
        .chain(whole)
        .chain(scenes)
        .chain(machines)
        .chain(deep)
        .chain(bytes)
        .collect()
}
