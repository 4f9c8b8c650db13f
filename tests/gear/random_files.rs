//! Random files of gears in space: an answer without NaN or a refusal, never a panic.

use std::sync::Arc;
use std::time::{Duration, Instant};

use geardyn::internals::base::flags::Flags;
use geardyn::internals::base::source_span::SourceFile;
use geardyn::internals::plan::gear::{bevel, space};
use geardyn::internals::report::bevel::BevelReport;
use geardyn::internals::report::presentation::Presentation;
use geardyn::internals::scene::bevel_file;
use geardyn::internals::scene::gear_kind::{PairKind, pair_kind};

/// The shipped files of gears in space.
const SPACE: [&str; 5] = [
    "worm_zi_2_40",
    "worm_plane_1_40",
    "crossed_15_24",
    "hob_za_30",
    "worm_zk_grinding",
];

/// The shipped files of bevel gears.
const BEVEL: [&str; 3] = ["straight_20_40", "bevel_12_36", "hypoid_13_42"];

/// The text with some of its numbers scaled or drawn anew.
fn mutated(text: &str) -> String {
    let mut found = String::new();
    let mut rest = text;
    while let Some(start) = rest.find(|c: char| c.is_ascii_digit()) {
        let number = &rest[start..];
        let end = number
            .find(|c: char| !c.is_ascii_digit() && c != '.')
            .unwrap_or(number.len());
        found += &rest[..start];
        let value = number[..end].parse::<f64>();
        match (fastrand::u8(..8), value) {
            (0, Ok(value)) => {
                found += &format!("{}", value * 10f64.powf(4.0 * fastrand::f64() - 2.0))
            }
            (1, Ok(value)) => found += &format!("{}", (value * 3.0 * fastrand::f64()).round()),
            (2, Ok(value)) => found += &format!("{:.4}", value * (0.8 + 0.4 * fastrand::f64())),
            _ => found += &number[..end],
        }
        rest = &number[end..];
    }
    found + rest
}

/// Answers one file; whether there was an answer.
fn answered(text: &str) -> bool {
    let source = Arc::new(SourceFile {
        path: "random.toml".into(),
        text: text.into(),
        first_line: 1,
    });
    let flags = Flags::default();
    let shown = match pair_kind(&source) {
        Err(error) => Err(error.into()),
        Ok(PairKind::Bevel) => bevel_file::read(&source, &flags).and_then(|file| {
            let result = bevel::run(&file)?;
            let file = &file;
            Ok(BevelReport { file, result }.text())
        }),
        Ok(kind) => space::run(kind, &source, &flags).map(|sheet| sheet.text()),
    };
    match shown {
        Ok(text) => {
            assert!(!text.contains("NaN") && !text.contains(" inf"), "{text}");
            true
        }
        Err(_) => false,
    }
}

/// Answers of random files made from shipped ones, and the longest time of one.
fn answers(count: u32, files: &[&str]) -> (u32, Duration) {
    let texts: Vec<String> = (files.iter())
        .map(|name| {
            let text = std::fs::read_to_string(format!("models/gears/{name}.toml")).unwrap();
            let data = text
                .lines()
                .filter(|l| !l.starts_with("title") && !l.starts_with("source"));
            data.collect::<Vec<_>>().join("\n")
        })
        .collect();
    let (mut found, mut longest) = (0, Duration::ZERO);
    for k in 0..count {
        let text = mutated(&texts[k as usize % texts.len()]);
        let start = Instant::now();
        found += u32::from(answered(&text));
        if start.elapsed() > longest {
            longest = start.elapsed();
            println!("{longest:?} of\n{text}\n");
        }
    }
    (found, longest)
}

/// 2 000 random files of worms, crossed gears, hobs and disk tools.
#[test]
fn survives_random_files_of_gears_in_space() {
    fastrand::seed(22);
    let (found, _) = answers(2_000, &SPACE);
    assert!(found > 100, "{found}");
}

/// Random files of straight and spiral bevel gears.
#[test]
fn survives_random_files_of_bevel_gears() {
    fastrand::seed(23);
    let (found, _) = answers(12, &BEVEL);
    assert!(found > 0, "{found}");
}

/// 100 000 random files, 2 000 of them of bevel gears; none takes a second. Runs by request.
#[test]
#[ignore = "minutes: cargo test --release --test gear random_files -- --ignored"]
fn survives_many_random_files_of_gears_in_space() {
    fastrand::seed(24);
    let runs = [answers(98_000, &SPACE), answers(2_000, &BEVEL)];
    for (found, longest) in runs {
        assert!(found > 0);
        assert!(longest < Duration::from_secs(1), "{longest:?}");
    }
}
