//! Names of points and units of axes.

use super::Set;
use super::codes;
use super::header::{Axis, Header, Point};
use crate::recording::responses::Terminal;

/// Characters of an entity's name.
const ENTITY: usize = 10;

/// Names of the points of a file, told apart where entities share one.
pub(super) struct Names {
    points: Vec<(Point, String)>,
}

impl Names {
    pub fn of(sets: &[Set]) -> Names {
        let mut points: Vec<(Point, String)> = Vec::new();
        for header in sets.iter().map(|set| &set.header) {
            for (end, point) in [&header.response, &header.reference]
                .into_iter()
                .enumerate()
            {
                if !points.iter().any(|(known, _)| known == point) {
                    points.push((point.clone(), base(header, point, end)));
                }
            }
        }
        let shared = |name: &str| points.iter().filter(|(_, other)| other == name).count() > 1;
        let told = points.iter().map(|(point, name)| {
            let place = point.place();
            match shared(name) && !place.is_empty() && *name != place {
                true => (point.clone(), format!("{name} {place}")),
                false => (point.clone(), name.clone()),
            }
        });
        Names {
            points: told.collect(),
        }
    }

    /// The name of a point; empty where the file says nothing of it.
    pub fn of_point(&self, point: &Point) -> String {
        let known = self.points.iter().find(|(other, _)| other == point);
        known.map(|(_, name)| name.clone()).unwrap_or_default()
    }

    /// The name of what answers: that of its point, else the label of its axis, else the first line of the header.
    pub fn of_response(&self, header: &Header) -> String {
        let candidates = [
            self.of_point(&header.response),
            header.ordinate.label.clone(),
            header.ids[0].clone(),
        ];
        candidates
            .into_iter()
            .find(|name| !name.is_empty())
            .unwrap_or_default()
    }

    /// What drives a response; `None` where the file does not say.
    pub fn input(&self, header: &Header, is_si: bool) -> Option<Terminal> {
        let (name, unit) = (
            self.of_point(&header.reference),
            unit(&header.denominator, is_si),
        );
        (!name.is_empty() || !unit.is_empty()).then(|| Terminal {
            name: if name.is_empty() {
                header.denominator.label.clone()
            } else {
                name
            },
            unit,
        })
    }
}

/// The entity's name, else node and direction. A name that fills its columns was cut; the first line, `output` or
/// `output / input`, may have it whole.
fn base(header: &Header, point: &Point, end: usize) -> String {
    if point.entity.is_empty() {
        return point.place();
    }
    let whole = header.ids[0]
        .split(" / ")
        .nth(end)
        .unwrap_or(&header.ids[0]);
    match point.entity.chars().count() == ENTITY && whole.starts_with(&point.entity) {
        true => whole.to_string(),
        false => point.entity.clone(),
    }
}

/// The unit as written, else that of the type of data where the file is in SI.
pub(super) fn unit(axis: &Axis, is_si: bool) -> String {
    match (axis.unit.is_empty(), is_si) {
        (false, _) => axis.unit.clone(),
        (true, true) => codes::si_unit(axis.data_type).to_string(),
        (true, false) => String::new(),
    }
}

/// The unit of what answers: that of the ordinate without `/input` where the file writes the whole quotient.
pub(super) fn numerator(header: &Header, is_si: bool) -> String {
    let (whole, below) = (
        unit(&header.ordinate, is_si),
        unit(&header.denominator, is_si),
    );
    let above = whole
        .strip_suffix(&below)
        .and_then(|rest| rest.strip_suffix('/'));
    match (above, below.is_empty()) {
        (Some(above), false) => above.to_string(),
        _ => whole,
    }
}
