//! Tolerances of both editions of ISO 1328 and the grades read from them; grades as JB 179-60 wrote them.

use crate::support::verification::printed;
use GearDeviation::*;
use geardyn::internals::gear::measurement::accuracy_grades::{AccuracyGrades, BacklashClass};
use geardyn::internals::gear::measurement::deviation::{GearDeviation, ToleranceGroup};
use geardyn::internals::gear::measurement::iso1328::{
    Edition, GearSize, is_within, round_tolerance,
};

fn size(module_mm: f64, teeth: u32, width_mm: f64) -> GearSize {
    GearSize {
        teeth,
        module: 1e-3 * module_mm,
        diameter: 1e-3 * module_mm * f64::from(teeth),
        face_width: 1e-3 * width_mm,
        helix: 0.0,
        contact_ratio: None,
        designed_short_wave: None,
    }
}

fn micro(found: Option<f64>) -> f64 {
    1e6 * found.unwrap()
}

/// m 3, z 40, b 30, grade 6 of the newer edition, unrounded: three public programs agree on these digits.
/// Source: ISO 1328-1:2013; three public programs agree.
#[test]
fn ref_newer_edition_to_its_digits() {
    let gear = size(3.0, 40, 30.0);
    for (quantity, expected) in [
        (SinglePitch, 8.937829714),
        (CumulativePitch, 28.800385846),
        (ProfileSlope, 7.523616152),
        (ProfileForm, 9.40452019),
        (ProfileTotal, 12.043662234),
        (HelixSlope, 9.142539261),
        (HelixForm, 10.226974598),
        (HelixTotal, 13.717763432),
        (Runout, 25.920347261),
    ] {
        let found = micro(Edition::Y2013.unrounded_tolerance(quantity, &gear, 6));
        printed(
            &format!("{quantity:?}, unrounded"),
            "µm",
            expected,
            found,
            6e-10,
        );
    }
    for (quantity, expected) in [
        (SinglePitch, 9.0),
        (CumulativePitch, 29.0),
        (ProfileTotal, 12.0),
    ] {
        let found = micro(Edition::Y2013.tolerance(quantity, &gear, 6));
        printed(
            &format!("{quantity:?}, rounded"),
            "µm",
            expected,
            found,
            1e-12,
        );
    }
    // Over a quarter of the teeth the tolerance is that of all of them.
    let quarter = micro(Edition::Y2013.unrounded_tolerance(OverPitches(10), &gear, 6));
    assert!((quarter - 28.800385846).abs() < 1e-9);
}

/// Tolerances are rounded as the standard rounds them.
/// Source: ISO 1328-1:2013.
#[test]
fn ref_rounding() {
    for (exact, expected) in [
        (12.49, 12.0),
        (10.4, 10.0),
        (7.3, 7.5),
        (7.2, 7.0),
        (4.96, 5.0),
        (4.94, 4.9),
    ] {
        assert_eq!(round_tolerance(exact, false), expected, "{exact}");
    }
    assert_eq!(round_tolerance(1.2, true), 1.0);
    assert_eq!(round_tolerance(1.2, false), 1.2);
}

/// A published report of a planetary stage (m 21, z 18 and 36, b 550, grade 6 of 1995 and 1997) by a commercial program.
/// Source: KISSsoft 03/2017 report of a planetary stage.
#[test]
fn ref_older_edition_against_a_report() {
    let (mut sun, mut planet) = (size(21.0, 18, 550.0), size(21.0, 36, 550.0));
    sun.contact_ratio = Some(1.37);
    planet.contact_ratio = Some(1.37);
    for (quantity, expected) in [
        (SinglePitch, [18.0, 19.0]),
        (ProfileForm, [21.0, 23.0]),
        (ProfileSlope, [17.0, 19.0]),
        (ProfileTotal, [27.0, 30.0]),
        (HelixForm, [21.0, 21.0]),
        (HelixTotal, [29.0, 30.0]),
        (CumulativePitch, [54.0, 67.0]),
        (Runout, [43.0, 53.0]),
        (DoubleFlankTotal, [133.0, 143.0]),
        (DoubleFlankTooth, [89.0, 89.0]),
    ] {
        let gears = [("sun", &sun), ("planet", &planet)];
        for ((name, gear), expected) in gears.into_iter().zip(expected) {
            let found = micro(Edition::Y1995.tolerance(quantity, gear, 6));
            printed(
                &format!("{quantity:?}, {name}"),
                "µm",
                expected,
                found,
                1e-9,
            );
        }
    }
    // Over k = z/8 pitches; single-flank with the contact ratio of the sun's mesh.
    for (gear, k, expected) in [(&sun, 2, 28.0), (&planet, 4, 36.0)] {
        let found = micro(Edition::Y1995.tolerance(OverPitches(k), gear, 6));
        printed(&format!("over {k} pitches"), "µm", expected, found, 1e-9);
    }
    for (quantity, expected) in [(SingleFlankTooth, 40.0), (SingleFlankTotal, 94.0)] {
        let found = micro(Edition::Y1995.tolerance(quantity, &sun, 6));
        printed(&format!("{quantity:?}, sun"), "µm", expected, found, 1e-9);
    }
}

/// All grades: each is √2 of the one before, the finest that holds a value is found, and one that no grade holds has none.
#[test]
fn law_grades_grow_and_are_found_again() {
    for edition in Edition::ALL {
        for quantity in GearDeviation::LIMITED {
            let mut gear = size(4.0, 31, 25.0);
            gear.contact_ratio = Some(1.6);
            let grades = edition.grades(quantity);
            let Some(limits) = grades
                .clone()
                .map(|grade| edition.tolerance(quantity, &gear, grade))
                .collect::<Option<Vec<f64>>>()
            else {
                continue;
            };
            for (pair, grade) in limits.windows(2).zip(grades.clone()) {
                let exact = |g| edition.unrounded_tolerance(quantity, &gear, g).unwrap();
                assert!((exact(grade + 1) / exact(grade) - 2f64.sqrt()).abs() < 1e-12);
                assert!(pair[1] > pair[0], "{quantity:?} {grade}");
                // Exactly at the limit keeps it, a little above does not.
                assert_eq!(edition.grade_of(quantity, &gear, -pair[0]), Some(grade));
                let above = pair[0] + 1e-9;
                assert_eq!(edition.grade_of(quantity, &gear, above), Some(grade + 1));
            }
            let last = *limits.last().unwrap();
            assert_eq!(edition.grade_of(quantity, &gear, 1.01 * last), None);
            assert_eq!(
                edition.grade_of(quantity, &gear, 0.0),
                grades.clone().next()
            );
        }
    }
    assert!(is_within(9.0 * 1e-6, 9e-6) && !is_within(9.001e-6, 9e-6));
}

/// Steps of the older edition: the gear's own size does not matter within a range of the tables, the newer edition's does.
#[test]
fn law_older_edition_steps_newer_is_smooth() {
    let (one, other) = (size(2.5, 22, 15.0), size(3.4, 36, 18.0));
    let both = |edition: Edition| {
        [&one, &other].map(|gear| {
            edition
                .unrounded_tolerance(CumulativePitch, gear, 7)
                .unwrap()
        })
    };
    let [a, b] = both(Edition::Y1995);
    assert_eq!(a, b);
    let [a, b] = both(Edition::Y2013);
    assert!(b > 1.1 * a);
}

/// Single-flank tolerances of 2013 lie about what the design itself has, which does not grow with the grade.
#[test]
fn exact_designed_short_wave() {
    let mut gear = size(3.0, 40, 30.0);
    assert_eq!(Edition::Y2013.tolerance(SingleFlankShort, &gear, 6), None);
    gear.designed_short_wave = Some(4e-6);
    let at = |grade| micro(Edition::Y2013.unrounded_tolerance(SingleFlankShort, &gear, grade));
    assert!((at(5) - (4.0 + 6.125)).abs() < 1e-12);
    assert!((at(7) - (4.0 + 12.25)).abs() < 1e-12);
}

#[test]
fn refuses_sizes_outside_the_editions() {
    let outside = |edition: Edition, quantity, gear: &GearSize| {
        let why = edition.out_of_scope(quantity, gear);
        assert_eq!(
            why.is_some(),
            edition.tolerance(quantity, gear, 6).is_none()
        );
        why.unwrap_or_default()
    };
    let gear = size(3.0, 40, 30.0);
    assert_eq!(outside(Edition::Y2013, SinglePitch, &gear), "");
    assert!(outside(Edition::Y2013, SinglePitch, &size(0.4, 40, 30.0)).contains("module"));
    assert!(outside(Edition::Y2013, SinglePitch, &size(3.0, 4, 30.0)).contains("teeth"));
    assert!(outside(Edition::Y1995, SinglePitch, &size(30.0, 400, 30.0)).contains("diameter"));
    assert_eq!(
        outside(Edition::Y2013, SinglePitch, &size(30.0, 400, 30.0)),
        ""
    );
    // The face width matters where it is in the formula.
    let narrow = size(3.0, 40, 3.0);
    assert_eq!(outside(Edition::Y1995, SinglePitch, &narrow), "");
    assert!(outside(Edition::Y1995, HelixTotal, &narrow).contains("face width"));
    // Fine modules belong to part 2 alone.
    assert_eq!(
        outside(Edition::Y1995, DoubleFlankTotal, &size(0.3, 40, 5.0)),
        ""
    );
    let steep = GearSize { helix: 0.8, ..gear };
    assert!(outside(Edition::Y2013, Runout, &steep).contains("helix"));
    assert_eq!(Edition::Y2013.tolerance(SinglePitch, &gear, 12), None);
    assert_eq!(Edition::Y1995.tolerance(DoubleFlankTotal, &gear, 3), None);
}

/// Grades are written as the standard writes them.
#[test]
fn exact_notation() {
    let read = |text: &str| AccuracyGrades::parse(text).unwrap();
    assert_eq!(read("7"), AccuracyGrades::uniform(7));
    let one = read("7-Dc");
    assert_eq!(
        (one.motion, one.contact, one.backlash),
        (7, 7, Some(BacklashClass::Normal))
    );
    let all = read("8-7-7 Dc");
    assert_eq!(
        [
            ToleranceGroup::Motion,
            ToleranceGroup::Smoothness,
            ToleranceGroup::Contact
        ]
        .map(|g| all.grade(g)),
        [8, 7, 7]
    );
    assert_eq!(
        all.describe(),
        "grade 8 in motion, 7 in smoothness, 7 in contact, normal backlash"
    );
    assert_eq!(read("6-D").backlash, Some(BacklashClass::None));
    for allowed in ["8-7-7", "8-6-6", "7-8-8", "8-7-6 De", "7-7-7-Db"] {
        read(allowed);
    }
    for (refused, why) in [
        ("8-5-5", "smoothness"),
        ("6-8-8", "smoothness"),
        ("8-7-8", "contact"),
        ("8-7", "notation"),
        ("", "notation"),
        ("Dc", "notation"),
        ("7 Dx", "notation"),
        ("-7", "notation"),
        ("13", "above"),
        ("7.5", "notation"),
    ] {
        match AccuracyGrades::parse(refused) {
            Err(error) => assert!(error.message.contains(why), "{refused}: {}", error.message),
            Ok(read) => assert_eq!(read.describe(), why, "{refused}"),
        }
    }
}

/// Every key leads back to its quantity, today's and the old one, and no two share one.
#[test]
fn law_keys_are_unique() {
    let mut keys = Vec::new();
    for quantity in GearDeviation::LIMITED {
        keys.push(quantity.key());
        assert_eq!(GearDeviation::from_key(quantity.key()), Some(quantity));
        if let Some(old) = quantity.jb179_name() {
            keys.push(old.key);
            assert_eq!(GearDeviation::from_key(old.key), Some(quantity));
        }
    }
    let all = keys.len();
    keys.sort_unstable();
    keys.dedup();
    assert_eq!((keys.len(), all), (29, 29));
}
