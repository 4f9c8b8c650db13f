//! The library's surface: the example programs run, and a model is the same from a file, from text and from the builder.

#[path = "../../examples/gear_mesh.rs"]
mod gear_mesh;
#[path = "../../examples/identify.rs"]
mod identify;
#[path = "../../examples/modes.rs"]
mod modes;
#[path = "../../examples/parameter_study.rs"]
mod parameter_study;
#[path = "../../examples/response.rs"]
mod response;
#[path = "../../examples/simulate.rs"]
mod simulate;
#[path = "../../examples/transmission_error.rs"]
mod transmission_error;

use geardyn::prelude::*;

#[test]
fn examples_run() {
    gear_mesh::main().unwrap();
    identify::main().unwrap();
    modes::main().unwrap();
    parameter_study::main().unwrap();
    response::main().unwrap();
    simulate::main().unwrap();
    transmission_error::main().unwrap();
}

const TWO_DISCS: &str = r#"
inertia = [{ name = "motor", J = "0.02 kg·m²" }, { name = "work", J = "0.05 kg·m²" }]
shaft = [{ name = "shaft_1", between = ["motor", "work"], k = "12000 N·m/rad" }]
"#;

fn two_discs() -> ModelBuilder {
    Model::builder()
        .inertia("motor", 0.02)
        .inertia("work", 0.05)
        .shaft("motor", "work", 1.2e4)
}

fn frequencies(model: &Model) -> Vec<f64> {
    let modes = model.machine().unwrap().modes(&ModesStudy::default());
    modes.unwrap().iter().map(|m| m.frequency_hz).collect()
}

/// Two discs on a shaft: `ω² = k (1/J₁ + 1/J₂)`, from text and from the builder.
#[test]
fn exact_two_discs_built_and_parsed() {
    let exact = (1.2e4_f64 * (1.0 / 0.02 + 1.0 / 0.05)).sqrt() / std::f64::consts::TAU;
    let built = frequencies(&two_discs().build().unwrap());
    assert_eq!(built, frequencies(&Model::parse(TWO_DISCS).unwrap()));
    let error = (built[1] / exact - 1.0).abs();
    crate::support::within("frequency", error, 1e-14);
}

/// Results name degrees of freedom and elements.
#[test]
fn results_own_their_names() {
    let machine = two_discs().build().unwrap().machine().unwrap();
    let modes = machine.modes(&ModesStudy::default()).unwrap();
    assert_eq!(modes.dofs, machine.dofs());
    let ratio =
        modes.component(1, "work.theta").unwrap() / modes.component(1, "motor.theta").unwrap();
    assert!((ratio.re + 0.4).abs() < 1e-12, "{ratio}");
    assert_eq!(modes.component(1, "nobody.theta"), None);
    assert!(modes[1].dominant_element().is_some());
}

/// A wrong value in the builder is refused as in a file.
#[test]
fn the_builder_is_checked_by_the_reader() {
    let errors = two_discs()
        .shaft("motor", "nobody", 1.0)
        .build()
        .and_then(|m| m.machine().map(|_| ()));
    let text = errors.unwrap_err().to_string();
    assert!(text.contains("nobody"), "{text}");
    let errors = Model::builder().inertia("a\"b", -1.0).build().unwrap_err();
    assert!(errors.to_string().contains('J'), "{errors}");
}

/// Two channels of arrays: wrong shapes are refused, a tone is found.
#[test]
fn recordings_from_arrays() {
    let tone: Vec<f64> = (0..8192).map(|k| (0.1 * f64::from(k)).sin()).collect();
    let recording = Recording::from_arrays(1000.0, &[("ax", "m/s²", &tone)]).unwrap();
    let spectrum = recording.spectrum(&SpectrumStudy::default()).unwrap();
    let curve = &spectrum.channel_spectra[0];
    assert_eq!(curve.value.len(), spectrum.abscissa.len());
    for channels in [
        vec![("a", "", &tone[..]), ("b", "", &tone[1..])],
        vec![("a", "", &tone[..]), ("a", "", &tone[..])],
        vec![("a", "", &[f64::NAN][..])],
        vec![],
    ] {
        assert!(Recording::from_arrays(1000.0, &channels).is_err());
    }
    assert!(Recording::from_arrays(0.0, &[("ax", "", &tone)]).is_err());
}

/// A log whose sidecar lists the files of a test is refused, as by the command.
#[test]
fn refuses_a_log_of_a_list() {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("hit.csv");
    std::fs::write(&log, "t,f\n0,1\n1,2\n2,1\n").unwrap();
    let list = "[log]\nfiles = [\"hit.csv\", \"other.csv\"]\n";
    std::fs::write(folder.path().join("hit.toml"), list).unwrap();
    let errors = Recording::open(&log).unwrap_err();
    assert!(errors.to_string().contains("lists 2 files"), "{errors}");
}
