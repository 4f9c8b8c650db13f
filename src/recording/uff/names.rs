//! Channel names and units from UFF headers.

use super::DataSet58;
use super::codes;
use super::header::{AxisRecord, DofLabel, UffHeader};
use crate::recording::frequency_responses::ChannelLabel;

/// Characters of an entity's name.
const ENTITY_LEN: usize = 10;

/// Names of the points of a file, distinguished where entities share one.
pub(super) struct PointNames {
    points: Vec<(DofLabel, String)>,
}

impl PointNames {
    pub fn new(data_sets: &[DataSet58]) -> PointNames {
        let mut points: Vec<(DofLabel, String)> = Vec::new();
        for header in data_sets.iter().map(|set| &set.header) {
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
            let place = point.text();
            match shared(name) && !place.is_empty() && *name != place {
                true => (point.clone(), format!("{name} {place}")),
                false => (point.clone(), name.clone()),
            }
        });
        PointNames {
            points: told.collect(),
        }
    }

    /// The name of a point; empty where the file says nothing of it.
    pub fn point_name(&self, point: &DofLabel) -> String {
        let known = self.points.iter().find(|(other, _)| other == point);
        known.map(|(_, name)| name.clone()).unwrap_or_default()
    }

    /// Name of the response channel: that of its point, else the label of its axis, else the first line of the header.
    pub fn response_name(&self, header: &UffHeader) -> String {
        let candidates = [
            self.point_name(&header.response),
            header.ordinate.label.clone(),
            header.ids[0].clone(),
        ];
        candidates
            .into_iter()
            .find(|name| !name.is_empty())
            .unwrap_or_default()
    }

    /// Excitation channel of a response; `None` where the file does not state it.
    pub fn input(&self, header: &UffHeader, is_si: bool) -> Option<ChannelLabel> {
        let (name, unit) = (
            self.point_name(&header.reference),
            axis_unit(&header.denominator, is_si),
        );
        (!name.is_empty() || !unit.is_empty()).then(|| ChannelLabel {
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
fn base(header: &UffHeader, point: &DofLabel, end: usize) -> String {
    if point.entity.is_empty() {
        return point.text();
    }
    let whole = header.ids[0]
        .split(" / ")
        .nth(end)
        .unwrap_or(&header.ids[0]);
    match point.entity.chars().count() == ENTITY_LEN && whole.starts_with(&point.entity) {
        true => whole.to_string(),
        false => point.entity.clone(),
    }
}

/// The unit as written, else that of the type of data where the file is in SI.
pub(super) fn axis_unit(axis: &AxisRecord, is_si: bool) -> String {
    match (axis.unit.is_empty(), is_si) {
        (false, _) => axis.unit.clone(),
        (true, true) => codes::si_unit(axis.data_type).to_string(),
        (true, false) => String::new(),
    }
}

/// Unit of the response channel: that of the ordinate without `/input` where the file writes the whole quotient.
pub(super) fn response_unit(header: &UffHeader, is_si: bool) -> String {
    let (whole, below) = (
        axis_unit(&header.ordinate, is_si),
        axis_unit(&header.denominator, is_si),
    );
    let above = whole
        .strip_suffix(&below)
        .and_then(|rest| rest.strip_suffix('/'));
    match (above, below.is_empty()) {
        (Some(above), false) => above.to_string(),
        _ => whole,
    }
}
