//! Readings in the order of their teeth, by the column that numbers them.

use super::ChartEvaluation;
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::scene::measured_gear::MeasuredChart;

impl ChartEvaluation<'_> {
    /// One reading a tooth in the order of the column `tooth`, where the file has one; in their own order without it.
    ///
    /// # Errors
    /// The file cannot be read; the column does not name every tooth once.
    pub(super) fn sorted_by_tooth(
        &mut self,
        chart: &MeasuredChart,
        values: Vec<f64>,
    ) -> Result<Vec<f64>, Errors> {
        let Some(numbers) = self.chart_files.tooth_numbers(chart)? else {
            return Ok(values);
        };
        let teeth = self.gear.gear.teeth as usize;
        let counted_from_zero = first_number(&numbers, teeth) == 0.0;
        let ordered = tooth_order(&values, &numbers, teeth).map_err(|message| {
            Error::new(Code::Conflict, message)
                .with_span(&chart.span)
                .with_hint("number every tooth once, from 1 on; rename the column if it is not the number of the tooth")
        })?;
        let file = chart.file.display();
        let mut note = |text: String| {
            if !self.results.notes.contains(&text) {
                self.results.notes.push(text);
            }
        };
        if counted_from_zero {
            note(format!(
                "{file}: teeth are numbered from 0; tooth 0 of the file is tooth 1 here"
            ));
        }
        let Some(ordered) = ordered else {
            return Ok(values);
        };
        note(format!(
            "{file}: readings put in the order of the column of tooth numbers"
        ));
        Ok(ordered)
    }
}

/// The number of the first tooth: 0 where a row has it, else 1.
fn first_number(numbers: &[f64], teeth: usize) -> f64 {
    match numbers.iter().take(teeth).any(|n| *n == 0.0) {
        true => 0.0,
        false => 1.0,
    }
}

/// Readings by rising tooth number; `None` where they are in that order, or where their count is for the evaluation to refuse.
fn tooth_order(values: &[f64], numbers: &[f64], teeth: usize) -> Result<Option<Vec<f64>>, String> {
    let returns = values.len() == teeth + 1 && numbers.get(teeth) == numbers.first();
    if values.len() != teeth && !returns {
        return Ok(None);
    }
    let first = first_number(numbers, teeth);
    let mut rows: Vec<Option<usize>> = vec![None; teeth];
    for row in 0..teeth {
        let number = numbers.get(row).copied().unwrap_or(f64::NAN);
        let place = number - first;
        if place.fract() != 0.0 || !(0.0..teeth as f64).contains(&place) {
            return Err(format!(
                "row {} has tooth number {number}, but a gear of {teeth} teeth has {first} to {}",
                row + 1,
                first + teeth as f64 - 1.0
            ));
        }
        if let Some(earlier) = rows[place as usize].replace(row) {
            return Err(format!(
                "tooth {number} is in rows {} and {}",
                earlier + 1,
                row + 1
            ));
        }
    }
    let rows: Vec<usize> = rows.into_iter().flatten().collect();
    if rows.iter().enumerate().all(|(place, row)| place == *row) {
        return Ok(None);
    }
    // The drift until the first flank is read again passes evenly over the rows, as they were measured.
    let drift = match returns {
        true => (values[teeth] - values[0]) / teeth as f64,
        false => 0.0,
    };
    let ordered = rows.iter().map(|&row| values[row] - drift * row as f64);
    Ok(Some(ordered.collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reversed and turned rows give the same readings; a drift is taken off in the order measured.
    #[test]
    fn exact_order_by_tooth_number() {
        let order = |values: &[f64], numbers: &[f64]| tooth_order(values, numbers, 3);
        assert_eq!(order(&[1.0, 2.0, 3.0], &[1.0, 2.0, 3.0]), Ok(None));
        assert_eq!(
            order(&[3.0, 2.0, 1.0], &[3.0, 2.0, 1.0]),
            Ok(Some(vec![1.0, 2.0, 3.0]))
        );
        assert_eq!(
            order(&[2.0, 3.0, 1.0], &[1.0, 2.0, 0.0]),
            Ok(Some(vec![1.0, 2.0, 3.0]))
        );
        let drifted = order(&[3.0, 2.1, 1.2, 3.3], &[3.0, 2.0, 1.0, 3.0])
            .unwrap()
            .unwrap();
        let expected = [1.0, 2.0, 3.0];
        assert!(
            drifted
                .iter()
                .zip(expected)
                .all(|(x, y)| (x - y).abs() < 1e-12)
        );
        assert!(
            order(&[1.0; 3], &[1.0, 1.0, 2.0])
                .unwrap_err()
                .contains("rows 1 and 2")
        );
        assert!(
            order(&[1.0; 3], &[1.0, 2.0, 4.0])
                .unwrap_err()
                .contains("row 3")
        );
        assert!(order(&[1.0; 3], &[1.0, 2.0]).is_err());
    }
}
