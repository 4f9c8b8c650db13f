//! Channel names and units from UFF headers.

use super::DataSet58;
use super::codes;
use super::header::{AxisRecord, DofLabel, UffHeader};
use crate::recording::frequency_responses::ChannelLabel;

/// Maximum length of an entity name, characters.
const ENTITY_LEN: usize = 10;

/// Names of the points of a file; node and direction distinguish points that share an entity name.
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
                if !points.iter().any(|(label, _)| label == point) {
                    points.push((point.clone(), base_name(header, point, end)));
                }
            }
        }
        let is_shared = |name: &str| points.iter().filter(|(_, other)| other == name).count() > 1;
        let unique = points.iter().map(|(point, name)| {
            let place = point.text();
            match is_shared(name) && !place.is_empty() && *name != place {
                true => (point.clone(), format!("{name} {place}")),
                false => (point.clone(), name.clone()),
            }
        });
        PointNames {
            points: unique.collect(),
        }
    }

    /// Name of a point; empty if the file states none.
    pub fn point_name(&self, point: &DofLabel) -> String {
        let entry = self.points.iter().find(|(label, _)| label == point);
        entry.map(|(_, name)| name.clone()).unwrap_or_default()
    }

    /// Name of the response channel: point name, else label of the ordinate axis, else first line of the header.
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

    /// Excitation channel of a response; `None` if the file does not state it.
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

/// Entity name, else node and direction. A name that fills its columns may be truncated; the first line, `output` or
/// `output / input`, may contain it in full.
fn base_name(header: &UffHeader, point: &DofLabel, end: usize) -> String {
    if point.entity.is_empty() {
        return point.text();
    }
    let full_name = header.ids[0]
        .split(" / ")
        .nth(end)
        .unwrap_or(&header.ids[0]);
    match point.entity.chars().count() == ENTITY_LEN && full_name.starts_with(&point.entity) {
        true => full_name.to_string(),
        false => point.entity.clone(),
    }
}

/// Unit as written, else the SI unit of the data type if the file is in SI.
pub(super) fn axis_unit(axis: &AxisRecord, is_si: bool) -> String {
    match (axis.unit.is_empty(), is_si) {
        (false, _) => axis.unit.clone(),
        (true, true) => codes::si_unit(axis.data_type).to_string(),
        (true, false) => String::new(),
    }
}

/// Unit of the response channel: the ordinate unit, without `/input` if the file states the unit of the quotient.
pub(super) fn response_unit(header: &UffHeader, is_si: bool) -> String {
    let (ordinate_unit, input_unit) = (
        axis_unit(&header.ordinate, is_si),
        axis_unit(&header.denominator, is_si),
    );
    let output_unit = ordinate_unit
        .strip_suffix(&input_unit)
        .and_then(|rest| rest.strip_suffix('/'));
    match (output_unit, input_unit.is_empty()) {
        (Some(output_unit), false) => output_unit.to_string(),
        _ => ordinate_unit,
    }
}
