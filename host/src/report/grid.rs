//! One table for the terminal and for Markdown, with cells that stand out.

use comfy_table::presets::UTF8_HORIZONTAL_ONLY;
use comfy_table::{CellAlignment, Table, TableComponent};

/// Why a cell stands out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Mark {
    /// It does not.
    #[default]
    Plain,
    /// The fastest.
    Best,
    /// Ours, and worse than what it is compared with.
    Loses,
}

/// A cell.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Cell {
    pub(crate) text: String,
    pub(crate) mark: Mark,
}

impl Cell {
    pub(crate) fn new(text: impl Into<String>) -> Self {
        Self { text: text.into(), mark: Mark::Plain }
    }

    /// What is not known.
    pub(crate) fn unknown() -> Self {
        Self::new("-")
    }

    /// A number, or that it is not known.
    pub(crate) fn number(value: Option<f64>, places: usize) -> Self {
        value.map_or_else(Self::unknown, |value| Self::new(format!("{value:.places$}")))
    }

    pub(crate) fn marked(self, mark: Mark) -> Self {
        Self { mark, ..self }
    }
}

/// Columns with headings; the first are text, the others numbers.
pub(crate) struct Grid {
    pub(crate) headings: Vec<String>,
    pub(crate) text_columns: usize,
    pub(crate) lines: Vec<Vec<Cell>>,
}

impl Grid {
    /// For a terminal: `*` before the best, `!` before what loses.
    pub(crate) fn terminal(&self) -> Table {
        let mut table = Table::new();
        table.load_preset(UTF8_HORIZONTAL_ONLY).set_header(&self.headings);
        table.remove_style(TableComponent::HorizontalLines);
        table.remove_style(TableComponent::MiddleIntersections);
        for column in table.column_iter_mut().skip(self.text_columns) {
            column.set_cell_alignment(CellAlignment::Right);
        }
        for line in &self.lines {
            table.add_row(line.iter().map(|Cell { text, mark }| match mark {
                Mark::Plain => text.clone(),
                Mark::Best => format!("*{text}"),
                Mark::Loses => format!("!{text}"),
            }));
        }
        table
    }

    /// For a page: the best in bold, "(loses)" after what loses.
    pub(crate) fn markdown(&self) -> String {
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
