//! Wrong model and scene files: each is refused with the code, the line and the words that help.

use std::fs::{self, File};
use std::path::Path;
use std::time::{Duration, Instant};

use geardyn::base::code::Code;
use geardyn::base::error::{Error, Errors};
use geardyn::scene::{read, read_text};

/// A model without fault; its lines are counted in the cases below.
const GOOD: &str = r#"title = "Motor, gear pair, roll"
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

fn refused(text: &str) -> Errors {
    read_text("m.toml", text).expect_err("a refusal")
}

/// The good model with one line in place of another, and the one error it then has.
fn changed(from: &str, to: &str) -> Error {
    assert!(GOOD.contains(from), "{from}");
    let errors = refused(&GOOD.replacen(from, to, 1));
    assert_eq!(errors.list().len(), 1, "{errors}");
    errors.list()[0].clone()
}

fn line(error: &Error) -> usize {
    error.place.as_ref().expect("a place").line()
}

fn hint(error: &Error) -> &str {
    error.hint.as_deref().unwrap_or_default()
}

#[test]
fn exact_the_good_model_is_good() {
    read_text("m.toml", GOOD).unwrap_or_else(|e| panic!("{e}"));
}

/// Each row: what is replaced, by what, the code, the line, what the message and the hint say.
#[test]
fn refuses_wrong_lines() {
    use Code::{
        Conflict, MissingKey, MissingUnit, OutOfRange, UnknownKey, UnknownNode, WrongType,
        WrongUnit,
    };
    #[rustfmt::skip]
    let cases: &[(&str, &str, Code, usize, &str, &str)] = &[
        ("k = \"420 N/µm\"", "stifness = \"420 N/µm\"", UnknownKey, 21, "unknown key `stifness`", "did you mean `k`? it takes N/m, N/µm, kN/mm"),
        ("backlash", "backlsh", UnknownKey, 22, "`backlsh`", "did you mean `backlash`? it takes m, mm, µm"),
        ("\"80 µm\"", "\"1e-40 m\"", OutOfRange, 22, "less than any play", "leave it out, or write 0"),
        ("\"80 µm\"", "\"1e-300 m\"", OutOfRange, 22, "`backlash` is below 1e-50 in SI units", "write 0 or leave it out"),
        ("\"80 µm\"", "\"1e300 m\"", OutOfRange, 22, "`backlash` must not exceed 1e50 in SI units", "m, mm"),
        ("\"80 µm\"", "\"1e9 m\"", OutOfRange, 22, "must not exceed 1 m: the deflection of the contact", "look at its unit"),
        ("\"0.3 kg·m²\"", "\"1e300 kg·m²\"", OutOfRange, 10, "`J` must not exceed 1e50", "kg·m²"),
        ("\"0.3 kg·m²\"", "\"1e-300 kg·m²\"", OutOfRange, 10, "`J` is below 1e-50", "write 0"),
        ("\"8.5 kN·m/rad\"", "\"1e300 N·m/rad\"", OutOfRange, 14, "`k` must not exceed 1e50", "N·m/rad"),
        ("\"420 N/µm\"", "\"1e-300 N/m\"", OutOfRange, 21, "`k` is below 1e-50", "write 0"),
        ("\"3 mm\"", "\"1e-300 mm\"", OutOfRange, 20, "`module` is below 1e-50", "write 0"),
        ("\"3 mm\"", "\"1e300 mm\"", OutOfRange, 20, "`module` must not exceed 1e50", "m, mm"),
        ("damping_ratio = 0.01", "damping_ratio = 1e300", OutOfRange, 15, "`damping_ratio` must not exceed 1e50", "bare number"),
        ("backlash = \"80 µm\"", "k_wave = { kind = \"rectangular\", high = 1.0, low = 0.0, share = 0.5 }", OutOfRange, 22, "`low` lets the wave go down to zero", "nothing carries though teeth are in mesh"),
        ("backlash = \"80 µm\"", "k_wave = { kind = \"rectangular\", high = 0.0, low = 1.0, share = 0.5 }", OutOfRange, 22, "`high` lets the wave go down to zero", "above zero"),
        ("backlash = \"80 µm\"", "k_wave = { kind = \"table\", values = [0, 0] }", OutOfRange, 22, "`values` lets the wave go down to zero", "above zero"),
        ("backlash = \"80 µm\"", "k_wave = { kind = \"fourier\", amplitudes = [0.5, 0.5] }", OutOfRange, 22, "`amplitudes` lets the wave go down to zero", "below the mean"),
        ("title", "tilte", UnknownKey, 1, "`tilte`", "`title`"),
        ("\"pinion\", \"wheel\"", "\"pinoin\", \"wheel\"", UnknownNode, 18, "no node `pinoin`", "did you mean `pinion`?"),
        ("\"pinion\", \"wheel\"", "\"motor_shaft\", \"wheel\"", UnknownNode, 18, "no node `motor_shaft`", "not a body"),
        ("name = \"wheel\"\nJ", "name = \"wheel\"\nname_ = 1\nJ", UnknownKey, 10, "`name_`", "`name`"),
        ("\"0.3 kg·m²\"", "0.3", MissingUnit, 10, "`J` has no unit", "write \"0.3 kg·m²\""),
        ("\"0.3 kg·m²\"", "\"0.3\"", MissingUnit, 10, "`J` has no unit", "kg·m², kg·cm²"),
        ("8.5 kN·m/rad", "8.5 kN/mm", WrongUnit, 14, "kN/mm measures translational stiffness", "`k` takes N·m/rad, kN·m/rad"),
        ("8.5 kN·m/rad", "8.5 foo", WrongUnit, 14, "\"foo\" is not a unit", "`k` takes N·m/rad"),
        ("\"0.3 kg·m²\"", "\"-0.3 kg·m²\"", OutOfRange, 10, "`J` must not be negative", "kg·m²"),
        ("\"0.3 kg·m²\"", "\"nan kg·m²\"", OutOfRange, 10, "not a finite number", "finite"),
        ("\"0.3 kg·m²\"", "nan", OutOfRange, 10, "must be a finite number", "kg·m²"),
        ("\"0.3 kg·m²\"", "1e400", OutOfRange, 10, "must be a finite number", "kg·m²"),
        ("\"0.3 kg·m²\"", "\"1e400 kg·m²\"", OutOfRange, 10, "beyond the largest number", "finite"),
        ("\"0.3 kg·m²\"", "inf", OutOfRange, 10, "must be a finite number", "kg·m²"),
        ("\"0.3 kg·m²\"", "true", WrongType, 10, "`J` is true or false", "kg·m²"),
        ("\"0.3 kg·m²\"", "1979-05-27", WrongType, 10, "`J` is a date", "kg·m²"),
        ("J = \"0.3 kg·m²\"", "", MissingKey, 8, "has no `J`", "kg·m²"),
        ("[21, 63]", "[0, 63]", OutOfRange, 19, "`teeth` cannot be 0", "whole numbers from 1"),
        ("[21, 63]", "[21, 63.5]", OutOfRange, 19, "`teeth` cannot be 63.5", "whole numbers"),
        ("[21, 63]", "[21]", WrongType, 19, "`teeth` has 1 values", "a list of 2"),
        ("[21, 63]", "[99999999999999999999, 63]", OutOfRange, 19, "cannot be 99999999999999999999", "whole numbers"),
        ("\"10 mm\"", "\"40 mm\"", OutOfRange, 28, "the bore of 40 mm", "inner diameter"),
        ("[21, 63]", "[21, 63]\nhelix_angle = \"90 deg\"", OutOfRange, 20, "below 90°", "deg"),
        ("[21, 63]", "[21, 63]\npressure_angle = \"45 deg\"", OutOfRange, 20, "below 45°", "deg"),
        ("[21, 63]", "[21, 21]\ninternal = true", OutOfRange, 19, "ring of 21", "second gear"),
        ("\"420 N/µm\"", "\"-420 N/µm\"", OutOfRange, 21, "`k` must not be negative", "N/m"),
        ("damping_ratio = 0.01", "damping_ratio = -0.01", OutOfRange, 15, "must not be negative", "bare number"),
        ("damping_ratio = 0.01", "damping_ratio = \"1 %\"", WrongType, 15, "is text", "bare number"),
        ("damping_ratio = 0.01", "damping_ratio = 0.01\nloss_factor = 0.1", Conflict, 16, "exclude each other", "leave one"),
        ("k = \"8.5 kN·m/rad\"", "", Conflict, 15, "rigid element", "give `k`"),
        ("length = \"1 m\"", "length = \"1 m\"\nk = \"1 N·m/rad\"", Conflict, 27, "`k` is given, and follows from `length`", "alone"),
        ("module = \"3 mm\"", "", MissingKey, 16, "has no `module`", "`module` takes m, mm"),
        ("\"motor\", \"pinion\"", "\"motor\", \"motor\"", Conflict, 13, "both ends are `motor`", "two nodes"),
        ("\"motor\", \"pinion\"", "\"ground\", \"ground\"", Conflict, 13, "both ends are `ground`", "two nodes"),
        ("\"motor\", \"pinion\"", "\"motor\"", WrongType, 13, "`between` has 1 names", "two nodes"),
        ("\"pinion\", \"wheel\"", "\"ground\", \"wheel\"", Conflict, 18, "`ground` cannot turn", "[[coupling]]"),
        ("\"steel\"", "\"steal\"", OutOfRange, 29, "cannot be \"steal\"", "did you mean \"steel\"?"),
        ("name = \"motor\"", "name = \"mo.tor\"", UnknownNode, 13, "no node `motor`", ""),
        ("[[shaft]]\nname = \"bar\"", "[shafts]\nname = \"bar\"", UnknownKey, 23, "`shafts`", "did you mean `shaft`?"),
    ];
    for (from, to, code, at, message, advice) in cases {
        if *code == UnknownNode && to.contains("mo.tor") {
            let errors = refused(&GOOD.replacen(from, to, 1));
            assert_eq!(errors.list().len(), 2, "{errors}");
            assert_eq!(errors.list()[0].code, OutOfRange);
            continue;
        }
        let error = changed(from, to);
        assert_eq!((error.code, line(&error)), (*code, *at), "{to}: {error}");
        assert!(error.message.contains(message), "{to}: {error}");
        assert!(hint(&error).contains(advice), "{to}: {error}");
    }
}

#[test]
fn refuses_a_name_used_twice_showing_the_first() {
    let errors = refused(&GOOD.replacen("name = \"bar\"", "name = \"pinion\"", 1));
    let error = &errors.list()[0];
    assert_eq!((error.code, line(error)), (Code::DuplicateName, 24));
    assert_eq!(error.label.as_deref(), Some("first used in line 6"));
}

#[test]
fn refuses_an_empty_file() {
    for text in ["", "\n\n", "\u{feff}", "# nothing\n", "title = \"a\"\n"] {
        let errors = refused(text);
        let error = &errors.list()[0];
        assert_eq!((error.code, line(error)), (Code::EmptyMachine, 1));
        assert!(hint(error).contains("geardyn new"));
    }
}

#[test]
fn refuses_syntax_and_nothing_behind_it() {
    let text = GOOD
        .replacen("J = \"0.3 kg·m²\"", "J = 0.3", 1)
        .replacen("teeth = [21, 63]", "teeth = [21, 63", 1)
        .replacen("\"10 mm\"", "\"40 mm\"", 1);
    let errors = refused(&text);
    let codes: Vec<(Code, usize)> = errors.list().iter().map(|e| (e.code, line(e))).collect();
    assert_eq!(codes.len(), 2, "{errors}");
    assert_eq!(codes[0], (Code::MissingUnit, 10));
    assert_eq!(codes[1].0, Code::Syntax);
    assert!((19..=20).contains(&codes[1].1), "{errors}");
    let doubled = refused(&GOOD.replacen("title", "title = \"a\"\ntitle", 1));
    assert_eq!(
        (doubled.list()[0].code, line(&doubled.list()[0])),
        (Code::Syntax, 2)
    );
}

#[test]
fn refuses_several_errors_in_the_order_of_the_file() {
    let text = GOOD
        .replacen("J = \"0.002 kg·m²\"", "J = 1", 1)
        .replacen("\"10 mm\"", "\"50 mm\"", 1)
        .replacen("\"motor\", \"pinion\"", "\"motr\", \"pinion\"", 1)
        .replacen("teeth = [21, 63]", "teeth = [21, 0]", 1);
    let errors = refused(&text);
    let lines: Vec<usize> = errors.list().iter().map(line).collect();
    assert_eq!(lines, [7, 13, 19, 28], "{errors}");
}

#[test]
fn refuses_deep_nesting() {
    for text in [
        format!("a = {}", "[".repeat(100_000)),
        format!("a = {}", "{a = ".repeat(100_000)),
        format!("a{} = 1", ".a".repeat(100_000)),
        format!("[[a{}]]", ".a".repeat(100_000)),
    ] {
        let errors = refused(&text);
        assert_eq!(
            (errors.list()[0].code, line(&errors.list()[0])),
            (Code::Syntax, 1)
        );
    }
}

fn refused_file(path: &Path) -> Error {
    let errors = read(path).expect_err("a refusal");
    assert_eq!(errors.list().len(), 1);
    errors.list()[0].clone()
}

#[test]
fn refuses_what_is_not_a_model_file() {
    let folder = tempfile::tempdir().unwrap();
    let error = refused_file(folder.path());
    assert_eq!(error.code, Code::FileMissing);
    assert!(error.message.contains("is a folder"));
    assert_eq!(
        refused_file(&folder.path().join("none.toml")).code,
        Code::FileMissing
    );

    let large = folder.path().join("large.toml");
    File::create(&large).unwrap().set_len(1 << 30).unwrap();
    let start = Instant::now();
    let error = refused_file(&large);
    assert_eq!(error.code, Code::FileTooLarge);
    assert!(error.message.contains("1024 MB"), "{error}");
    assert!(start.elapsed() < Duration::from_secs(1));

    let latin = folder.path().join("latin.toml");
    fs::write(&latin, b"title = \"a\"\nsource = \"Stra\xdfe\"\n").unwrap();
    let error = refused_file(&latin);
    assert_eq!((error.code, line(&error)), (Code::NotText, 2));
    assert!(error.message.contains("byte 26"), "{error}");
}

#[test]
fn refuses_wrong_scenes() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.toml"), GOOD).unwrap();
    let path = folder.path().join("s.toml");
    #[rustfmt::skip]
    let cases: &[(&str, Code, usize, &str, &str)] = &[
        ("[set]\n\"motr_shaft.k\" = \"1 N·m/rad\"", Code::UnknownKey, 3, "no element `motr_shaft`", "`motor_shaft`"),
        ("[set]\n\"motor_shaft.kk\" = \"1 N·m/rad\"", Code::UnknownKey, 3, "unknown key", "`k`"),
        ("[set]\n\"motor_shaft.k\" = \"1 N/m\"", Code::WrongUnit, 3, "translational", "N·m/rad"),
        ("[set]\nfirst_pair.teeth = [0, 1]", Code::OutOfRange, 3, "cannot be 0", ""),
        ("[set]\nk = 1", Code::UnknownKey, 3, "names no key", "element.key"),
        ("set = 1", Code::WrongType, 2, "`set` is a number", "[set]"),
        ("[[load]]\nat = \"whel\"\ntorque = \"1 N·m\"", Code::UnknownNode, 3, "no node `whel`", "`wheel`"),
        ("[[study]]\nkind = \"mode\"", Code::OutOfRange, 3, "cannot be \"mode\"", "\"modes\""),
        ("[[study]]\nkind = \"modes\"\ncampbell = \"3:1\"", Code::OutOfRange, 4, "range of speeds", "first:last"),
        ("[[shaft]]\nname = \"x\"", Code::UnknownKey, 2, "unknown key `shaft`", ""),
    ];
    for (text, code, at, message, advice) in cases {
        fs::write(&path, format!("model = \"m.toml\"\n{text}\n")).unwrap();
        let error = refused_file(&path);
        assert_eq!((error.code, line(&error)), (*code, *at), "{text}: {error}");
        assert!(
            error
                .place
                .as_ref()
                .unwrap()
                .source()
                .path
                .ends_with("s.toml")
        );
        assert!(error.message.contains(message), "{text}: {error}");
        assert!(hint(&error).contains(advice), "{text}: {error}");
    }
    for (model, code) in [
        ("none.toml", Code::FileMissing),
        (".", Code::FileMissing),
        ("s.toml", Code::Conflict),
    ] {
        fs::write(&path, format!("model = \"{model}\"\n")).unwrap();
        let error = refused_file(&path);
        assert_eq!((error.code, line(&error)), (code, 1), "{error}");
    }
}
