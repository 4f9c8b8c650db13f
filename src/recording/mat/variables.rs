//! Numeric MATLAB variables by full path: `x`, `run.x`, `runs(2).x`, `c{3}`.

use crate::base::mat5::read::{Array, Contents};

/// Part of a name before the last dot: fields of one structure share it.
pub(super) fn parent(name: &str) -> &str {
    name.rsplit_once('.').map_or("", |(parent, _)| parent)
}

/// Numbers with a name.
#[derive(Debug)]
pub(super) struct Variable {
    /// Full path by which MATLAB would reach it.
    pub name: String,
    /// Rows; all dimensions but the first are taken as columns.
    pub rows: usize,
    /// Columns.
    pub columns: usize,
    /// Real parts by columns.
    pub re: Vec<f64>,
    /// Imaginary parts by columns, where the numbers are complex.
    pub im: Option<Vec<f64>>,
    /// Spacing of numbers near 1 as stored.
    pub epsilon: f64,
}

impl Variable {
    /// The structure it is a field of.
    pub fn parent_path(&self) -> &str {
        parent(&self.name)
    }

    /// The last part of the name, small letters and digits alone: `Time_Sample_Rate` is `timesamplerate`.
    pub fn normalized_name(&self) -> String {
        let last = self.name.rsplit('.').next().unwrap_or_default();
        let letters = last.chars().filter(|c| c.is_alphanumeric());
        letters.flat_map(char::to_lowercase).collect()
    }

    /// One row or one column.
    pub fn is_vector(&self) -> bool {
        self.rows.min(self.columns) == 1
    }

    /// The longer side.
    pub fn length(&self) -> usize {
        self.rows.max(self.columns)
    }

    /// Size as text: `5 × 54000`.
    pub fn size_text(&self) -> String {
        format!("{} × {}", self.rows, self.columns)
    }

    /// The series of `length` numbers it holds, its columns before its rows: start and step of each; none where no side fits.
    pub fn series(&self, length: usize) -> Vec<(usize, usize)> {
        match (self.rows == length, self.columns == length) {
            (true, _) => (0..self.columns).map(|j| (j * self.rows, 1)).collect(),
            (false, true) => (0..self.rows).map(|i| (i, self.rows)).collect(),
            _ => Vec::new(),
        }
    }

    /// The name of series `at` of `element_count`, counted from 1.
    pub fn series_name(&self, at: usize, count: usize) -> String {
        match count {
            1 => self.name.clone(),
            _ => format!("{} {}", self.name, at + 1),
        }
    }
}

/// Contents of a file, flat.
#[derive(Default)]
pub(super) struct Variables {
    pub numbers: Vec<Variable>,
    /// Texts of one row.
    pub texts: Vec<(String, String)>,
    /// Variables that are not read: name and kind.
    pub others: Vec<(String, String)>,
}

impl Variables {
    /// Walks variables, structures and cells.
    pub fn flatten(&mut self, name: String, array: Array) {
        let Array {
            dimensions,
            contents,
            ..
        } = array;
        let rows = dimensions.first().copied().unwrap_or(0);
        let columns = element_count(dimensions.get(1..).unwrap_or_default());
        match contents {
            Contents::Real { values, .. } if values.is_empty() => {}
            Contents::Real { values, epsilon } => self.numbers.push(Variable {
                name,
                rows,
                columns,
                re: values,
                im: None,
                epsilon,
            }),
            Contents::Complex { re, .. } if re.is_empty() => {}
            Contents::Complex { re, im } => self.numbers.push(Variable {
                name,
                rows,
                columns,
                re,
                im: Some(im),
                epsilon: f64::EPSILON,
            }),
            Contents::Text(lines) => {
                if let [line] = lines.as_slice() {
                    self.texts.push((name, line.trim().to_string()));
                }
            }
            Contents::Cells(cells) => {
                for (at, cell) in cells.into_iter().enumerate() {
                    self.flatten(format!("{name}{{{}}}", at + 1), cell);
                }
            }
            Contents::Structure(fields) => {
                let structures = element_count(&dimensions);
                let per_structure = (fields.len() / structures.max(1)).max(1);
                for (at, field) in fields.into_iter().enumerate() {
                    let place = match structures {
                        1 => String::new(),
                        _ => format!("({})", at / per_structure + 1),
                    };
                    self.flatten(format!("{name}{place}.{}", field.name), field);
                }
            }
            Contents::Other(what) => self.others.push((name, what)),
        }
    }
}

/// Elements of an array; of an empty one the other dimensions may be any.
fn element_count(dimensions: &[usize]) -> usize {
    dimensions.iter().fold(1, |n, &d| n.saturating_mul(d))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An empty array may have other dimensions whose product is beyond any number.
    #[test]
    fn survives_empty_arrays_of_any_size() {
        assert_eq!(element_count(&[3, 4, 5]), 60);
        let mut flat = Variables::default();
        let array = Array {
            name: "x".to_string(),
            dimensions: vec![0, usize::MAX, 3],
            contents: Contents::Real {
                values: Vec::new(),
                epsilon: f64::EPSILON,
            },
        };
        flat.flatten("x".to_string(), array);
        assert!(flat.numbers.is_empty());
    }
}
