//! Machines from a seed: described once, written in SI or in workshop units, scaled, changed, in any order.

/// A small generator, the same on every computer (Vigna's splitmix64).
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Random {
        Random(seed)
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Log-uniform between two positive numbers, four digits.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        let x = low * (high / low).powf(self.unit());
        format!("{x:.3e}").parse().unwrap_or(x)
    }

    pub fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }

    fn shuffle<T>(&mut self, list: &mut [T]) {
        for i in (1..list.len()).rev() {
            list.swap(i, self.below(i + 1));
        }
    }
}

/// What a number measures.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Unit {
    Inertia,
    Mass,
    Torsion,
    Line,
    Length,
    TurningLoss,
    LineLoss,
}

impl Unit {
    fn workshop(self) -> (f64, &'static str) {
        match self {
            Unit::Inertia => (1e6, "kg·mm²"),
            Unit::Mass => (1e3, "g"),
            Unit::Torsion => (1e3, "N·mm/rad"),
            Unit::Line => (1e-6, "N/µm"),
            Unit::Length => (1e3, "mm"),
            Unit::TurningLoss => (1e3, "N·mm·s/rad"),
            Unit::LineLoss => (1e-3, "kN·s/m"),
        }
    }

    pub fn is_stiffness(self) -> bool {
        matches!(self, Unit::Torsion | Unit::Line)
    }

    pub fn is_inertia(self) -> bool {
        matches!(self, Unit::Inertia | Unit::Mass)
    }
}

#[derive(Clone)]
enum Entry {
    Words(String),
    Number(f64, Unit),
}

/// One table of a model.
#[derive(Clone)]
pub struct Part {
    table: &'static str,
    pub name: String,
    keys: Vec<(&'static str, Entry)>,
}

impl Part {
    fn words(mut self, key: &'static str, words: impl ToString) -> Part {
        self.keys.push((key, Entry::Words(words.to_string())));
        self
    }

    fn number(mut self, key: &'static str, value: f64, unit: Unit) -> Part {
        self.keys.push((key, Entry::Number(value, unit)));
        self
    }
}

fn part(table: &'static str, name: impl ToString) -> Part {
    Part {
        table,
        name: name.to_string(),
        keys: Vec::new(),
    }
}

fn body(name: impl ToString, inertia: f64) -> Part {
    part("inertia", name).number("J", inertia, Unit::Inertia)
}

fn join(table: &'static str, name: impl ToString, one: &str, two: &str) -> Part {
    part(table, name).words("between", format!("[\"{one}\", \"{two}\"]"))
}

/// A machine, and how many ways it moves as a rigid body.
#[derive(Clone)]
pub struct Description {
    pub family: &'static str,
    pub parts: Vec<Part>,
    pub n_rigid: usize,
}

impl Description {
    /// In SI.
    pub fn text(&self) -> String {
        self.write(false)
    }

    /// In millimetres, grams, newtons per micrometre.
    pub fn workshop_text(&self) -> String {
        self.write(true)
    }

    fn write(&self, workshop: bool) -> String {
        let mut text = String::from("title = \"from a seed\"\nsource = \"a test\"\n");
        if !workshop {
            text += "units = \"SI\"\n";
        }
        for part in &self.parts {
            text += &format!("[[{}]]\nname = \"{}\"\n", part.table, part.name);
            for (key, entry) in &part.keys {
                text += &match entry {
                    Entry::Words(words) => format!("{key} = {words}\n"),
                    Entry::Number(value, unit) if workshop => {
                        let (factor, unit) = unit.workshop();
                        format!("{key} = \"{:e} {unit}\"\n", value * factor)
                    }
                    Entry::Number(value, _) => format!("{key} = {value:?}\n"),
                };
            }
        }
        text
    }

    /// Numbers of some kind times a factor, in one element or in all.
    pub fn changed(
        &self,
        element: Option<&str>,
        which: fn(Unit) -> bool,
        factor: f64,
    ) -> Description {
        let mut changed = self.clone();
        for part in &mut changed.parts {
            if element.is_none_or(|name| name == part.name) {
                for (_, entry) in &mut part.keys {
                    if let Entry::Number(value, unit) = entry
                        && which(*unit)
                    {
                        *value *= factor;
                    }
                }
            }
        }
        changed
    }

    /// The same machine told in another order.
    pub fn shuffled(&self, random: &mut Random) -> Description {
        let mut other = self.clone();
        random.shuffle(&mut other.parts);
        other
    }

    /// The same machine with a viscous loss on every spring that may have one.
    pub fn with_losses(&self, random: &mut Random) -> Description {
        let mut lossy = self.clone();
        for part in &mut lossy.parts {
            let add = part.keys.iter().find_map(|(key, entry)| match entry {
                Entry::Number(k, Unit::Torsion) if *key == "k" => {
                    Some(("c", k * random.between(1e-5, 1e-3), Unit::TurningLoss))
                }
                Entry::Number(k, Unit::Line) if *key == "k" => {
                    Some(("c", k * random.between(1e-6, 1e-4), Unit::LineLoss))
                }
                Entry::Number(k, Unit::Line) if *key == "k_radial" => {
                    Some(("c_x", k * random.between(1e-6, 1e-4), Unit::LineLoss))
                }
                _ => None,
            });
            if let Some((key, value, unit)) = add {
                part.keys.push((key, Entry::Number(value, unit)));
            }
        }
        lossy
    }

    fn add(&mut self, part: Part) {
        self.parts.push(part);
    }
}

fn empty(family: &'static str, n_rigid: usize) -> Description {
    Description {
        family,
        parts: Vec::new(),
        n_rigid,
    }
}

/// Twelve discs in a row, free or held at one end.
pub fn chain(seed: u64) -> Description {
    let random = &mut Random::new(seed);
    let held = random.below(2) == 1;
    let mut d = empty("chain", usize::from(!held));
    for i in 0..12 {
        d.add(body(format!("n{i}"), random.between(0.01, 1.0)));
    }
    for i in 1..12 {
        let (one, two) = (format!("n{}", i - 1), format!("n{i}"));
        let k = random.between(1e3, 1e5);
        d.add(join("shaft", format!("s{i}"), &one, &two).number("k", k, Unit::Torsion));
    }
    if held {
        let k = random.between(1e3, 1e5);
        d.add(join("coupling", "hold", "ground", "n3").number("k", k, Unit::Torsion));
    }
    d
}

/// A link of nodes that turn at `speeds`, so that loops can always turn; `None`: rigid.
fn link(
    d: &mut Description,
    name: String,
    at: [usize; 2],
    speeds: &[i64],
    elastic: Option<&mut Random>,
) {
    let mut at = at;
    let same_way = speeds[at[0]] * speeds[at[1]] > 0;
    if same_way && speeds[at[0]].abs() < speeds[at[1]].abs() {
        at.swap(0, 1);
    }
    let [p, q] = at.map(|i| speeds[i].abs());
    let [one, two] = at.map(|i| format!("n{i}"));
    if same_way && p == q {
        let shaft = join("shaft", name, &one, &two);
        d.add(match elastic {
            Some(random) => shaft.number("k", random.between(1e3, 1e5), Unit::Torsion),
            None => shaft,
        });
        return;
    }
    let pair = join("gear_pair", name, &one, &two)
        .words("teeth", format!("[{}, {}]", 11 * q, 11 * p))
        .words("internal", same_way)
        .number("module", 0.003, Unit::Length);
    d.add(match elastic {
        Some(random) => pair.number("k", random.between(1e7, 1e9), Unit::Line),
        None => pair,
    });
}

/// A tree of shafts and gear pairs, some rigid, with one massless node, and `loops` more links that close it.
fn geared(family: &'static str, seed: u64, loops: usize) -> Description {
    let random = &mut Random::new(seed);
    let n = 10 + random.below(4);
    let mut d = empty(family, 1);
    let speeds: Vec<i64> = (0..n)
        .map(|_| [1, 1, 2, 3, 5][random.below(5)] * [1, -1][random.below(2)])
        .collect();
    for i in 0..n {
        d.add(body(format!("n{i}"), random.between(0.01, 1.0)));
    }
    for i in 1..n {
        let parent = i - 1 - random.below(3.min(i));
        let rigid = random.below(4) == 0;
        link(
            &mut d,
            format!("b{i}"),
            [parent, i],
            &speeds,
            (!rigid).then_some(&mut *random),
        );
    }
    for l in 0..loops {
        let one = random.below(n);
        let two = (one + 1 + random.below(n - 1)) % n;
        link(
            &mut d,
            format!("l{l}"),
            [one, two],
            &speeds,
            Some(&mut *random),
        );
    }
    d.add(body("light", 0.0));
    for (name, node) in [("to_light", "n0"), ("from_light", "n1")] {
        let k = random.between(1e3, 1e5);
        d.add(join("shaft", name, node, "light").number("k", k, Unit::Torsion));
        if loops == 0 {
            break;
        }
        if speeds[0] != speeds[1] {
            break;
        }
    }
    d
}

pub fn tree(seed: u64) -> Description {
    geared("geared tree", seed, 0)
}

pub fn loops(seed: u64) -> Description {
    geared("geared loops", seed, 4)
}

/// Motor, planetary stage with a held ring, load.
pub fn planetary(seed: u64) -> Description {
    let random = &mut Random::new(seed);
    let mut d = empty("planetary", 1);
    for name in ["motor", "sun", "ring", "carrier", "load"] {
        d.add(body(name, random.between(0.003, 1.0)));
    }
    let (sun, planet) = (18 + random.below(10), 20 + random.below(15));
    let (k_sun, k_ring) = (random.between(1e8, 1e9), random.between(1e8, 1e9));
    let planets = 3 + random.below(3);
    d.add(
        part("planetary", "stage")
            .words("sun", "\"sun\"")
            .words("ring", "\"ring\"")
            .words("carrier", "\"carrier\"")
            .words("teeth", format!("[{sun}, {planet}, {}]", sun + 2 * planet))
            .words("planets", planets)
            .number("module", 0.004, Unit::Length)
            .number("planet_J", random.between(0.001, 0.01), Unit::Inertia)
            .number("k_sun", k_sun, Unit::Line)
            .number("k_ring", k_ring, Unit::Line),
    );
    for (name, one, two) in [
        ("input", "motor", "sun"),
        ("output", "carrier", "load"),
        ("housing", "ring", "ground"),
    ] {
        let k = random.between(1e4, 1e6);
        d.add(join("coupling", name, one, two).number("k", k, Unit::Torsion));
    }
    d
}

/// A planetary stage whose bodies move sideways too; planets unequally spaced in every other one.
pub fn planetary_lateral(seed: u64) -> Description {
    let random = &mut Random::new(seed);
    let mut d = empty("planetary, lateral", 1);
    for name in ["sun", "ring", "carrier"] {
        let (inertia, mass) = (random.between(0.001, 0.1), random.between(0.3, 6.0));
        d.add(body(name, inertia).number("mass", mass, Unit::Mass));
        let k = random.between(3e7, 3e8);
        d.add(
            part("bearing", format!("{name}_support"))
                .words("at", format!("\"{name}\""))
                .number("k_radial", k, Unit::Line),
        );
    }
    let (k_sun, k_ring) = (random.between(1e8, 1e9), random.between(1e8, 1e9));
    let (k_bearing, mass) = (random.between(5e7, 5e8), random.between(0.3, 1.0));
    let stage = part("planetary", "stage")
        .words("sun", "\"sun\"")
        .words("ring", "\"ring\"")
        .words("carrier", "\"carrier\"")
        .words("teeth", "[27, 35, 99]")
        .number("module", 0.003, Unit::Length)
        .number("planet_J", random.between(0.0005, 0.002), Unit::Inertia)
        .number("planet_mass", mass, Unit::Mass)
        .number("k_sun", k_sun, Unit::Line)
        .number("k_ring", k_ring, Unit::Line)
        .number("k_bearing", k_bearing, Unit::Line)
        .words("lateral", true);
    d.add(if seed.is_multiple_of(2) {
        stage.words("planets", 4)
    } else {
        stage.words("positions", "[\"0 deg\", \"121 deg\", \"239 deg\"]")
    });
    d.add(join("coupling", "housing", "ring", "ground").number(
        "k",
        random.between(1e5, 1e7),
        Unit::Torsion,
    ));
    d
}

/// Motor, helical pair in bearings that give way in five directions, load.
pub fn helical(seed: u64) -> Description {
    let random = &mut Random::new(seed);
    let mut d = empty("helical, lateral", 1);
    d.add(body("motor", random.between(0.005, 0.05)));
    d.add(body("load", random.between(0.1, 2.0)));
    for (name, bearing) in [("pinion", "front"), ("wheel", "rear")] {
        let inertia = random.between(0.001, 0.05);
        d.add(
            body(name, inertia)
                .number("mass", random.between(1.0, 20.0), Unit::Mass)
                .number("J_diametral", 0.6 * inertia, Unit::Inertia),
        );
        d.add(
            part("bearing", bearing)
                .words("at", format!("\"{name}\""))
                .number("k_radial", random.between(5e7, 5e8), Unit::Line)
                .number("k_z", random.between(3e7, 3e8), Unit::Line)
                .number("k_tilt", random.between(1e5, 1e6), Unit::Torsion),
        );
    }
    d.add(
        join("gear_pair", "pair", "pinion", "wheel")
            .words("teeth", "[23, 61]")
            .words("helix_angle", format!("\"{} deg\"", 5 + random.below(25)))
            .words("hand", ["\"left\"", "\"right\""][random.below(2)])
            .number("module", 0.003, Unit::Length)
            .number("k", random.between(1e8, 1e9), Unit::Line),
    );
    for (name, one, two) in [("input", "motor", "pinion"), ("output", "wheel", "load")] {
        let k = random.between(1e4, 1e6);
        d.add(join("shaft", name, one, two).number("k", k, Unit::Torsion));
    }
    d
}

/// Three machines of every family.
pub fn all() -> Vec<Description> {
    let families = [chain, tree, loops, planetary, planetary_lateral, helical];
    let seeds = 1..=3;
    families
        .iter()
        .flat_map(|family| seeds.clone().map(family))
        .collect()
}
