//! Loss factors: `K (1 + iη)` above the real axis, whatever their size and however many freedoms there are.

use crate::support::verification::within;
use geardyn::internals::modes::mode::Mode;
use geardyn::internals::numeric::Complex;
use geardyn::internals::plan::modes_run::run;
use geardyn::internals::plan::prepared_machine::PreparedMachine;
use geardyn::internals::plan::stages::ModesPlan;
use geardyn::internals::scene;
use geardyn::internals::scene::study::ModesStudy;

const HEAD: &str = "title = \"t\"\nsource = \"test\"\nunits = \"SI\"\n";

fn body(name: &str) -> String {
    format!("[[inertia]]\nname = \"{name}\"\nJ = 1.0\n")
}

fn spring(name: &str, ends: [&str; 2], k: f64, eta: f64) -> String {
    let [a, b] = ends;
    format!(
        "[[coupling]]\nname = \"{name}\"\nbetween = [\"{a}\", \"{b}\"]\nk = {k:?}\nloss_factor = {eta:?}\n"
    )
}

fn damped(text: &str) -> Vec<Mode> {
    let scene =
        scene::read_text("test.toml", &(HEAD.to_string() + text)).unwrap_or_else(|e| panic!("{e}"));
    let machine = PreparedMachine::new(&scene.model).unwrap_or_else(|e| panic!("{e}"));
    let study = ModesStudy {
        damped: true,
        ..Default::default()
    };
    run(&machine, &study, &ModesPlan::plan_modes(&machine, &study))
        .unwrap_or_else(|e| panic!("{e}"))
        .modes
}

/// `λ = √(−ω² (1 + iη))` above the real axis.
fn root(squared: f64, eta: f64) -> Complex {
    let root = Complex::new(-squared, -eta * squared).sqrt();
    if root.im > 0.0 { root } else { -root }
}

fn assert_holds(modes: &[Mode], exact: Complex) {
    let near = modes
        .iter()
        .map(|m| (m.eigenvalue - exact).norm() / exact.norm())
        .fold(f64::INFINITY, f64::min);
    within("eigenvalues", near, 1e-12);
}

/// Two modes of one frequency and different loss factors are two, not one shown twice.
#[test]
fn exact_equal_frequencies_with_different_losses() {
    let text = [
        body("a"),
        body("b"),
        spring("x", ["a", "ground"], 1000.0, 0.02),
        spring("y", ["b", "ground"], 1000.0, 0.05),
    ];
    let modes = damped(&text.concat());
    assert_eq!(modes.len(), 2);
    assert_holds(&modes, root(1000.0, 0.02));
    assert_holds(&modes, root(1000.0, 0.05));
}

/// A hub with four branches, one of which loses more: three damped alike, none lost.
#[test]
fn law_no_root_is_lost_at_a_hub() {
    let mut text = body("hub") + &spring("h", ["hub", "ground"], 500.0, 0.0);
    for (k, eta) in [0.3, 0.1, 0.1, 0.1].into_iter().enumerate() {
        let name = format!("b{k}");
        text += &(body(&name) + &spring(&format!("s{k}"), ["hub", &name], 1000.0, eta));
    }
    let modes = damped(&text);
    assert_eq!(modes.len(), 5);
    // Two of the three equal branches move against each other with the hub at rest.
    let still = modes
        .iter()
        .filter(|m| (m.eigenvalue - root(1000.0, 0.1)).norm() < 1e-9)
        .count();
    assert_eq!(still, 2);
    let sum: Complex = modes.iter().map(|m| m.eigenvalue * m.eigenvalue).sum();
    // −Σλ² is the trace of K(1 + iη).
    let trace = Complex::new(500.0 + 8.0 * 1000.0, 2.0 * 1000.0 * 0.6);
    assert!((sum + trace).norm() < 1e-9 * trace.norm(), "{sum} {trace}");
}

/// Large loss factors are solved, not dropped.
#[test]
fn exact_large_loss_factors() {
    for eta in [0.5, 1.5, 2.0, 10.0] {
        let modes = damped(&[body("a"), body("b"), spring("x", ["a", "b"], 1000.0, eta)].concat());
        assert_eq!(modes.len(), 2);
        assert_holds(&modes, root(2000.0, eta));
        assert!(modes[1].residual < 1e-12);
    }
}

/// Beyond the order that is polished the losses still count.
#[test]
fn exact_long_chain_with_a_loss_factor() {
    let n = 170;
    let text =
        format!("[[chain]]\nname = \"c\"\ncount = {n}\nJ = 1.0\nk = 1000.0\nloss_factor = 0.1\n");
    let modes = damped(&text);
    assert_eq!(modes.len(), n);
    for (k, mode) in modes.iter().enumerate().skip(1) {
        let omega =
            2.0 * 1000f64.sqrt() * (k as f64 * std::f64::consts::PI / (2.0 * n as f64)).sin();
        let exact = root(omega * omega, 0.1);
        let error = (mode.eigenvalue - exact).norm() / exact.norm();
        within("eigenvalues", error, 1e-9);
        assert!(
            error < 3.0 * 10f64.powf(-mode.trusted_digits),
            "{k}: {error:.1e}, {} digits",
            mode.trusted_digits
        );
    }
}

/// A damper of absurd size is refused, not taken for a time constant of minus infinity.
#[test]
fn refuses_absurd_damping() {
    let text = [
        body("a"),
        body("b"),
        "[[coupling]]\nname = \"x\"\nbetween = [\"a\", \"b\"]\nk = 1000.0\nc = 1e300\n".to_string(),
    ];
    let errors = scene::read_text("test.toml", &(HEAD.to_string() + &text.concat())).unwrap_err();
    assert!(
        errors.as_slice()[0].message.contains("`c` must not exceed"),
        "{errors}"
    );
}
