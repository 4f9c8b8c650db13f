//! Loads and clutches that are products of functions of time.

use std::f64::consts::TAU;

use geardyn::internals::base::time_budget::CancelToken;
use geardyn::internals::motion::product::product;
use geardyn::internals::motion::signal::Signal;
use geardyn::internals::plan::motion::method_choice;
use geardyn::internals::plan::motion::run;
use geardyn::internals::plan::motion::simulation_setup::SimulationSetup;
use geardyn::internals::plan::prepared_machine::PreparedMachine;
use geardyn::internals::scene;
use geardyn::internals::scene::study::SimulateStudy;

const HEAD: &str = "title = \"t\"\nsource = \"t\"\nunits = \"SI\"\n";

/// Speed of `a` at 51 instants of a second, and the method.
fn speeds(text: &str, method: Option<&str>) -> (Vec<f64>, &'static str) {
    let scene = scene::read_text("test.toml", &format!("{HEAD}{text}")).unwrap();
    let study = SimulateStudy {
        end_time: Some(1.0),
        outputs: vec!["a.theta.speed".to_string()],
        samples: Some(50),
        tolerance: Some(1e-11),
        method: method.map(str::to_string),
        ..SimulateStudy::default()
    };
    let ready = SimulationSetup::new(
        &PreparedMachine::new(&scene.model).unwrap(),
        &scene.start,
        &study,
    )
    .unwrap();
    let choice = method_choice::choose_method(&ready.model.model, &study).unwrap();
    let motion = run::run(&ready, &choice, false, &CancelToken::default()).unwrap();
    (motion.values[0].clone(), choice.method.name)
}

/// A sine of 30 Hz switched on at 0.2 s turns a free disc of 2 kg·m² by `ω = (T/Jw) (1 − cos w(t − t₀))`.
#[test]
fn exact_sine_switched_on() {
    let text = r#"
inertia = [{ name = "a", J = 2.0 }]
load = [{ at = "a", kind = "product", torque = 5.0, factors = [
  { kind = "step", time = 0.2 },
  { kind = "harmonic", frequency = 30.0, phase = -1.5707963267948966 },
] }]
"#;
    let w = 30.0 * TAU;
    let (found, method) = speeds(text, None);
    assert_eq!(method, "dop853-events");
    for method in [None, Some("radau5")] {
        let (found, _) = speeds(text, method);
        for (k, x) in found.iter().enumerate() {
            let since = k as f64 / 50.0 - 0.2;
            // The phase of the sine counts from time zero: 0.2 s are six periods.
            let exact = match since > 0.0 {
                true => 5.0 / (2.0 * w) * (1.0 - (w * since).cos()),
                false => 0.0,
            };
            assert!((x - exact).abs() < 1e-8, "{method:?} {since}: {x} {exact}");
        }
    }
    assert_eq!(found.len(), 51);
}

/// A beat is two harmonics, for the exact method.
#[test]
fn exact_beat_stays_exact() {
    let product = r#"
inertia = [{ name = "a", J = 2.0 }]
load = [{ at = "a", kind = "product", torque = 5.0, factors = [
  { kind = "harmonic", frequency = 30.0 }, { kind = "harmonic", frequency = 4.0, mean = 0.5 },
] }]
"#;
    let sum = r#"
inertia = [{ name = "a", J = 2.0 }]
load = [
  { at = "a", kind = "harmonic", torque = 2.5, frequency = 34.0 },
  { at = "a", kind = "harmonic", torque = 2.5, frequency = 26.0 },
  { at = "a", kind = "harmonic", torque = 2.5, frequency = 30.0 },
]
"#;
    let ((a, one), (b, two)) = (speeds(product, None), speeds(sum, None));
    assert_eq!((one, two), ("exact", "exact"));
    assert!(a.iter().zip(&b).all(|(x, y)| (x - y).abs() < 1e-12));
}

/// A clutch whose pressure pulsates carries what a table of its capacity carries; what jumps or pulls is refused.
#[test]
fn law_clutch_takes_factors() {
    let clutch = |keys: &str| {
        format!(
            "inertia = [{{ name = \"a\", J = 2.0 }}]\nload = [{{ at = \"a\", torque = 40.0 }}]\nclutch = [{{ name = \"c\", at = \"a\", {keys} }}]\n"
        )
    };
    let factors = "torque = 10.0, factors = [{ kind = \"ramp\", value = 2.0, between = [0.1, 0.6] }, { value = 1.5 }]";
    let (a, _) = speeds(&clutch(factors), None);
    let (b, _) = speeds(&clutch("times = [0.1, 0.6], torques = [0.0, 30.0]"), None);
    assert!(
        a.iter().zip(&b).all(|(x, y)| (x - y).abs() < 1e-9),
        "{a:?} {b:?}"
    );
    for (keys, said) in [
        (
            "torque = 10.0, factors = [{ kind = \"step\", time = 0.1 }]",
            "jumps",
        ),
        (
            "torque = 10.0, factors = [{ kind = \"harmonic\", frequency = 3.0 }]",
            "below zero",
        ),
        ("torque = 10.0, factors = []", "is empty"),
    ] {
        let errors = scene::read_text("test.toml", &format!("{HEAD}{}", clutch(keys))).unwrap_err();
        assert!(errors.to_string().contains(said), "{errors}");
    }
}

/// Value, slope and curvature of products of three are those of the factors, on every piece.
#[test]
fn exact_products() {
    let sine = Signal::harmonic(2.0, 30.0, 0.4).plus(&Signal::constant(0.5));
    let beat = Signal::harmonic(1.0, 33.0, -0.2);
    let step = Signal::step(3.0, 0.2);
    let ramp = Signal::ramp(0.0, 2.0, [0.1, 0.5]);
    let lists: [&[&Signal]; 6] = [
        &[&sine, &step],
        &[&sine, &ramp],
        &[&sine, &beat],
        &[&sine, &beat, &step],
        &[&ramp, &ramp, &step],
        &[&beat, &step, &ramp],
    ];
    for factors in lists {
        let made = factors[1..]
            .iter()
            .try_fold(factors[0].clone(), |x, y| product(&x, y));
        let made = made.unwrap();
        for k in 0..200 {
            let t = -0.1 + 0.0043 * f64::from(k);
            let of = |s: &Signal| {
                [
                    s.value(t, s.piece(t)),
                    s.slope(t, s.piece(t)),
                    s.curvature(t, s.piece(t)),
                ]
            };
            let exact = factors.iter().map(|s| of(s)).reduce(|x, y| {
                [
                    x[0] * y[0],
                    x[1] * y[0] + x[0] * y[1],
                    x[2] * y[0] + 2.0 * x[1] * y[1] + x[0] * y[2],
                ]
            });
            for (x, y) in of(&made).iter().zip(exact.unwrap()) {
                assert!((x - y).abs() < 1e-11 * (1.0 + y.abs()), "{t}: {x} {y}");
            }
        }
    }
    // What lasts always stays exact for the methods that know harmonics.
    assert!(product(&sine, &beat).unwrap().is_piecewise_linear());
    assert!(!product(&sine, &step).unwrap().is_piecewise_linear());
    assert!(product(&product(&ramp, &ramp).unwrap(), &sine).is_err());
}
