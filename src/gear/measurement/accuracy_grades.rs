//! Accuracy grades as written: `7`, `8-7-7`, `8-7-7 Dc` (JB 179-60).

use super::deviation::ToleranceGroup;
use crate::base::code::Code;
use crate::base::error::Error;

/// Class of guaranteed backlash of JB 179-60.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BacklashClass {
    /// `D`
    None,
    /// `Db`
    Reduced,
    /// `Dc`
    Normal,
    /// `De`
    Enlarged,
}

impl BacklashClass {
    const ALL: [(BacklashClass, &'static str, &'static str); 4] = [
        (BacklashClass::None, "D", "no backlash guaranteed"),
        (BacklashClass::Reduced, "Db", "reduced backlash"),
        (BacklashClass::Normal, "Dc", "normal backlash"),
        (BacklashClass::Enlarged, "De", "enlarged backlash"),
    ];

    /// Meaning of the class: the backlash it guarantees.
    pub fn meaning(self) -> &'static str {
        let found = BacklashClass::ALL.iter().find(|b| b.0 == self);
        found.map_or("", |b| b.2)
    }
}

/// Grades of the three groups, and the required backlash.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AccuracyGrades {
    /// Passing on motion over a turn.
    pub motion: u32,
    /// Smoothness from tooth to tooth.
    pub smoothness: u32,
    /// Bearing of the flanks.
    pub contact: u32,
    /// The kind of backlash.
    pub backlash: Option<BacklashClass>,
}

/// The coarsest grade there is.
const MAX_GRADE: u32 = 12;

impl AccuracyGrades {
    /// One grade for all groups.
    pub fn uniform(grade: u32) -> AccuracyGrades {
        AccuracyGrades {
            motion: grade,
            smoothness: grade,
            contact: grade,
            backlash: None,
        }
    }

    /// Reads a notation. Three grades must fit together as JB 179-60 asks: smoothness at most two grades finer or one coarser than
    /// motion, contact not coarser than smoothness.
    ///
    /// # Errors
    /// `OutOfRange`: not a notation, a grade above 12, a combination not allowed.
    pub fn parse(text: &str) -> Result<AccuracyGrades, Error> {
        let refuse =
            |why: String, hint: &str| Err(Error::new(Code::OutOfRange, why).with_hint(hint));
        const FORM: &str = "write 7, 8-7-7, 7-Dc or 8-7-7 Dc: motion, smoothness, contact, kind of backlash D, Db, Dc or De";
        let shown = crate::base::quantity::truncate(text);
        let parts: Vec<&str> = text
            .split(['-', '–', ' '])
            .filter(|part| !part.is_empty())
            .collect();
        let is_kind = |part: &&&str| BacklashClass::ALL.iter().any(|b| b.1 == **part);
        let backlash = parts.last().filter(is_kind).and_then(|part| {
            let kind = BacklashClass::ALL.iter().find(|b| b.1 == *part);
            kind.map(|b| b.0)
        });
        let digits = &parts[..parts.len() - usize::from(backlash.is_some())];
        let grades: Option<Vec<u32>> = digits.iter().map(|part| part.parse().ok()).collect();
        let signed = text.trim_start().starts_with(['-', '–']);
        let (motion, smoothness, contact) = match grades.as_deref().filter(|_| !signed) {
            Some(&[grade]) => (grade, grade, grade),
            Some(&[motion, smoothness, contact]) => (motion, smoothness, contact),
            _ => return refuse(format!("\"{shown}\" is not a notation of grades"), FORM),
        };
        if [motion, smoothness, contact].iter().any(|&g| g > MAX_GRADE) {
            return refuse(format!("\"{shown}\" has a grade above {MAX_GRADE}"), FORM);
        }
        if smoothness + 2 < motion || smoothness > motion + 1 {
            let why = format!("\"{shown}\" joins smoothness {smoothness} with motion {motion}");
            return refuse(
                why,
                "smoothness may be at most two grades finer or one coarser than motion (JB 179-60)",
            );
        }
        if contact > smoothness {
            let why = format!("\"{shown}\" joins contact {contact} with smoothness {smoothness}");
            return refuse(
                why,
                "contact may not be coarser than smoothness (JB 179-60)",
            );
        }
        Ok(AccuracyGrades {
            motion,
            smoothness,
            contact,
            backlash,
        })
    }

    /// Required grade of a group.
    pub fn grade(&self, group: ToleranceGroup) -> u32 {
        match group {
            ToleranceGroup::Motion => self.motion,
            ToleranceGroup::Smoothness => self.smoothness,
            ToleranceGroup::Contact => self.contact,
        }
    }

    /// Description of the requirement, as text.
    pub fn describe(&self) -> String {
        let grades = match (self.motion, self.smoothness, self.contact) {
            (m, s, c) if m == s && s == c => format!("grade {m}"),
            (m, s, c) => format!("grade {m} in motion, {s} in smoothness, {c} in contact"),
        };
        match self.backlash {
            None => grades,
            Some(kind) => format!("{grades}, {}", kind.meaning()),
        }
    }
}
