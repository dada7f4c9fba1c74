//! One table for the terminal and for Markdown, with cells that stand out.

use comfy_table::presets::UTF8_HORIZONTAL_ONLY;
use comfy_table::{CellAlignment, Table, TableComponent};

/// Reason why a cell stands out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mark {
    /// It does not.
    #[default]
    Plain,
    /// The fastest.
    Best,
    /// Ours, and worse than what it is compared with.
    Loses,
}

/// Text of a cell, and how it stands out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Cell {
    /// Its text.
    pub text: String,
    /// The way in which it stands out.
    pub mark: Mark,
}

impl Cell {
    /// Makes a plain cell.
    pub fn new(text: impl Into<String>) -> Self {
        Self { text: text.into(), mark: Mark::Plain }
    }

    /// Makes a cell for what is not known.
    pub fn unknown() -> Self {
        Self::new("-")
    }

    /// Makes a cell of a number, or that it is not known.
    pub fn number(value: Option<f64>, places: usize) -> Self {
        value.map_or_else(Self::unknown, |value| Self::new(format!("{value:.places$}")))
    }

    /// Marks the cell.
    #[must_use]
    pub fn marked(self, mark: Mark) -> Self {
        Self { mark, ..self }
    }
}

/// Table by columns with headings; the first are text, the others numbers.
pub struct Grid {
    /// One for each column.
    pub headings: Vec<String>,
    /// Number of the columns that are text.
    pub text_columns: usize,
    /// Rows of as many cells as there are columns.
    pub lines: Vec<Vec<Cell>>,
}

impl Grid {
    /// Draws the table for a terminal: `*` before the best, `!` before what loses.
    pub fn terminal(&self) -> Table {
        let mut table = terminal_table(&self.headings, self.text_columns);
        for line in &self.lines {
            table.add_row(line.iter().map(|Cell { text, mark }| match mark {
                Mark::Plain => text.clone(),
                Mark::Best => format!("*{text}"),
                Mark::Loses => format!("!{text}"),
            }));
        }
        table
    }

    /// Writes the table as Markdown: the best in bold, "(loses)" after what loses.
    pub fn markdown(&self) -> String {
        let mut text = String::new();
        let mut line = |cells: Vec<String>| {
            text.push_str("| ");
            text.push_str(&cells.join(" | "));
            text.push_str(" |\n");
        };
        line(self.headings.clone());
        let rule = |at| if at < self.text_columns { "---" } else { "---:" }.to_owned();
        line((0..self.headings.len()).map(rule).collect());
        for cells in &self.lines {
            let shown = cells.iter().map(|Cell { text, mark }| match mark {
                Mark::Plain => text.clone(),
                Mark::Best => format!("**{text}**"),
                Mark::Loses => format!("{text} (loses)"),
            });
            line(shown.collect());
        }
        text
    }
}

/// Makes an empty table for a terminal, whose first columns are text and the others numbers.
pub fn terminal_table<T: ToString>(headings: &[T], text_columns: usize) -> Table {
    let mut table = Table::new();
    table.load_preset(UTF8_HORIZONTAL_ONLY).set_header(headings.iter().map(T::to_string));
    table.remove_style(TableComponent::HorizontalLines);
    table.remove_style(TableComponent::MiddleIntersections);
    for column in table.column_iter_mut().skip(text_columns) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_are_seen_in_both_forms() {
        let grid = Grid {
            headings: vec!["who".into(), "speed".into()],
            text_columns: 1,
            lines: vec![
                vec![Cell::new("we"), Cell::number(Some(0.5), 2).marked(Mark::Loses)],
                vec![Cell::new("they"), Cell::number(Some(1.0), 2).marked(Mark::Best)],
                vec![Cell::new("nobody"), Cell::number(None, 2)],
            ],
        };
        assert_eq!(
            grid.markdown(),
            "| who | speed |\n| --- | ---: |\n| we | 0.50 (loses) |\n| they | **1.00** |\n\
             | nobody | - |\n"
        );
        let terminal = grid.terminal().to_string();
        assert!(terminal.contains("!0.50") && terminal.contains("*1.00"), "{terminal}");
    }
}
