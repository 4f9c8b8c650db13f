//! Tables of results: columns with name, unit and values, rendered as terminal text and as CSV.

use std::borrow::Cow;
use std::io::{self, Write};

use unicode_width::UnicodeWidthStr;

use super::number_format::with_minus_signs;

/// A table of columns. Terminal text has separate rows for names and units, CSV has heads `name [unit]`.
#[derive(Debug, Clone, Default)]
pub struct Table<'a> {
    columns: Vec<Column<'a>>,
    words: WordColumns,
    extra_word_columns: &'static [usize],
}

#[derive(Debug, Clone)]
struct Column<'a> {
    name: String,
    unit: String,
    cells: Cells<'a>,
}

#[derive(Debug, Clone)]
enum Cells<'a> {
    Text(Vec<String>),
    Numbers(Cow<'a, [f64]>, NumberText),
}

/// Function that formats a number with all its digits.
pub type NumberText = fn(f64) -> String;

/// Selection of the columns of words, which are aligned left; numbers are aligned right.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
enum WordColumns {
    #[default]
    Last,
    First,
    All,
    None,
}

impl<'a> Table<'a> {
    /// Table with columns `name [unit]|name|…`: words in the last, numbers in the others.
    pub fn new(columns: &str) -> Table<'a> {
        Table::default().columns(columns)
    }

    /// Table with words in the first column and numbers in the others.
    pub fn named(columns: &str) -> Table<'a> {
        Table::with_words(WordColumns::First, columns)
    }

    /// Table with words in all columns.
    pub fn texts(columns: &str) -> Table<'a> {
        Table::with_words(WordColumns::All, columns)
    }

    /// Table with numbers in all columns.
    pub fn numeric(columns: &str) -> Table<'a> {
        Table::with_words(WordColumns::None, columns)
    }

    fn with_words(words: WordColumns, columns: &str) -> Table<'a> {
        let table = Table {
            words,
            ..Table::default()
        };
        table.columns(columns)
    }

    /// Marks further columns, by index, as columns of words.
    pub fn words(mut self, columns: &'static [usize]) -> Table<'a> {
        self.extra_word_columns = columns;
        self
    }

    /// Adds columns `name [unit]|name|…`.
    pub fn columns(self, columns: &str) -> Table<'a> {
        columns.split('|').fold(self, |table, head| {
            let unit = head.strip_suffix(']').and_then(|head| head.split_once('['));
            let (name, unit) = unit.unwrap_or((head, ""));
            table.column(name.trim_end(), unit)
        })
    }

    /// Adds columns if `shown`.
    pub fn columns_if(self, shown: bool, columns: &str) -> Table<'a> {
        match shown {
            true => self.columns(columns),
            false => self,
        }
    }

    /// Adds a column; its name may contain any character.
    pub fn column(mut self, name: &str, unit: &str) -> Table<'a> {
        self.push(name, unit, Cells::Text(Vec::new()));
        self
    }

    /// Adds a column with its values; NaN is a blank cell.
    pub fn numbers(
        mut self,
        name: &str,
        unit: &str,
        values: impl Into<Cow<'a, [f64]>>,
        text: NumberText,
    ) -> Table<'a> {
        self.push(name, unit, Cells::Numbers(values.into(), text));
        self
    }

    fn push(&mut self, name: &str, unit: &str, cells: Cells<'a>) {
        let (name, unit) = (name.to_string(), unit.to_string());
        self.columns.push(Column { name, unit, cells });
    }

    /// Adds a row of texts, one for each column.
    pub fn row<T: Into<String>>(&mut self, cells: impl IntoIterator<Item = T>) {
        for (column, cell) in self.columns.iter_mut().zip(cells) {
            if let Cells::Text(texts) = &mut column.cells {
                texts.push(cell.into());
            }
        }
    }

    /// Number of rows.
    pub fn row_count(&self) -> usize {
        let rows = |column: &Column| match &column.cells {
            Cells::Text(texts) => texts.len(),
            Cells::Numbers(values, _) => values.len(),
        };
        self.columns.iter().map(rows).max().unwrap_or(0)
    }

    /// Text for a terminal, without trailing blanks; rows of names and units are omitted if empty.
    pub fn text(&self) -> String {
        let rows = self.row_count();
        let (last, mut lines) = (self.columns.len().saturating_sub(1), Vec::new());
        for (at, column) in self.columns.iter().enumerate() {
            let heads = [&column.name, &column.unit].map(|head| Cow::Borrowed(head.as_str()));
            let cells = heads.into_iter().chain((0..rows).map(|k| column.cell(k)));
            let cells: Vec<String> = cells.map(|cell| cell.replace('\n', " ")).collect();
            // An empty column is one blank wide between its margins.
            let width = cells.iter().map(|cell| cell.width()).fold(1, usize::max);
            let align_left = match self.words {
                WordColumns::Last => at == last,
                WordColumns::First => at == 0,
                WordColumns::All => true,
                WordColumns::None => false,
            } || self.extra_word_columns.contains(&at);
            lines.resize(cells.len(), String::new());
            for (line, cell) in lines.iter_mut().zip(cells) {
                let blanks = " ".repeat(width - cell.width());
                *line += &match align_left {
                    true => format!(" {cell}{blanks} "),
                    false => format!(" {blanks}{cell} "),
                };
            }
        }
        let is_head = |at: usize| at < 2;
        let lines = lines.into_iter().enumerate();
        let shown = lines.filter(|(at, line)| !is_head(*at) || !line.trim().is_empty());
        let text: String = shown.map(|(_, line)| line + "\n").collect();
        let signed = with_minus_signs(&text);
        signed
            .lines()
            .map(|l| l.trim_end().to_string() + "\n")
            .collect()
    }

    /// CSV text of the table.
    pub fn csv(&self) -> String {
        let mut bytes = Vec::new();
        // Writing to memory cannot fail.
        let _ = self.write_csv(&mut bytes);
        String::from_utf8(bytes).unwrap_or_default()
    }

    /// Writes the table as CSV: a line of heads, then a line for each row.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn write_csv(&self, to: &mut dyn Write) -> io::Result<()> {
        let head = |column: &Column| match column.unit.is_empty() {
            true => quote(&column.name).into_owned(),
            false => quote(&format!("{} [{}]", column.name, column.unit)).into_owned(),
        };
        let heads: Vec<String> = self.columns.iter().map(head).collect();
        writeln!(to, "{}", heads.join(","))?;
        for k in 0..self.row_count() {
            for (at, column) in self.columns.iter().enumerate() {
                let comma = if at > 0 { "," } else { "" };
                write!(to, "{comma}{}", quote(&column.cell(k)))?;
            }
            writeln!(to)?;
        }
        Ok(())
    }
}

impl Column<'_> {
    fn cell(&self, k: usize) -> Cow<'_, str> {
        match &self.cells {
            Cells::Text(texts) => Cow::Borrowed(texts.get(k).map_or("", String::as_str)),
            Cells::Numbers(values, text) => {
                let value = values.get(k).filter(|x| !x.is_nan());
                Cow::Owned(value.map_or(String::new(), |x| text(*x)))
            }
        }
    }
}

/// Quotes a field that contains a comma, a quote or a line end (RFC 4180, sec. 2).
fn quote(field: &str) -> Cow<'_, str> {
    match field.contains([',', '"', '\n', '\r']) {
        true => Cow::Owned(format!("\"{}\"", field.replace('"', "\"\""))),
        false => Cow::Borrowed(field),
    }
}

/// Shortest decimal that parses to the same number: `0.0000001`.
pub fn decimal(x: f64) -> String {
    format!("{x}")
}

/// Shortest text that parses to the same number, with an exponent if that is shorter and a decimal point for integers: `1e-7`, `2.0`.
pub fn exact(x: f64) -> String {
    format!("{x:?}")
}

/// Shortest text with an exponent that parses to the same number: `1e-7`, `2e0`.
pub fn power(x: f64) -> String {
    format!("{x:e}")
}

/// Text of a value; blank for `None`.
pub fn or_blank<T>(value: Option<T>, text: impl Fn(T) -> String) -> String {
    value.map_or(String::new(), text)
}

/// Text of a value; a dash for `None`.
pub fn or_dash<T>(value: Option<T>, text: impl Fn(T) -> String) -> String {
    value.map_or("–".to_string(), text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_look_of_a_table() {
        let mut table = Table::new("mode|frequency [Hz]|dominant element");
        table.row(["1", "0.000", "rigid body"]);
        table.row(["2", "-41.8307", "λ, \"shaft\""]);
        let expected = " mode  frequency  dominant element\n              Hz\n    1      0.000  rigid body\n    2   −41.8307  λ, \"shaft\"\n";
        assert_eq!(table.text(), expected);
        let csv = "mode,frequency [Hz],dominant element\n1,0.000,rigid body\n2,-41.8307,\"λ, \"\"shaft\"\"\"\n";
        assert_eq!(table.csv(), csv);
    }

    #[test]
    fn exact_columns_of_numbers() {
        let values = [1.0, 1e-7];
        let table = Table::default()
            .numbers("time", "s", &values[..], decimal)
            .numbers("x_m", "", vec![2.0], exact)
            .numbers("y", "", vec![f64::NAN, 3.0], decimal);
        assert_eq!(table.csv(), "time [s],x_m,y\n1,2.0,\n0.0000001,,3\n");
        assert_eq!(Table::texts("|").text(), "");
    }
}
