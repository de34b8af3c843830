//! A sheet of text: headings, prose and tables.

use anstyle::{AnsiColor, Style};
use comfy_table::{
    CellAlignment, ColumnConstraint, ContentArrangement, LineStyle, Table, TableStyle, Width, presets,
};

use super::Look;

/// Text as it grows.
#[derive(Debug)]
pub(super) struct Sheet {
    look: Look,
    text: String,
}

pub(super) const GOOD: Style = AnsiColor::Green.on_default().bold();
pub(super) const BAD: Style = AnsiColor::Red.on_default().bold();
/// A rule under the header, and no more.
const RULED: TableStyle = TableStyle::new().header_separator(LineStyle::none().fill('─').junction('─'));
const HEADING: Style = Style::new().bold();
/// Blanks on either side of a cell.
const PADDING: usize = 2;
/// What a column takes beside its content: these, and what separates it from the next.
const BESIDE: usize = PADDING + 1;

impl Sheet {
    pub(super) fn new(look: Look) -> Self {
        Self { look, text: String::new() }
    }

    /// Leaves a line blank, except at the top.
    pub(super) fn gap(&mut self) {
        if !self.text.is_empty() {
            self.text.push('\n');
        }
    }

    /// A heading on a line of its own, a blank line before it.
    pub(super) fn heading(&mut self, heading: &str) {
        self.gap();
        for line in self.wrapped(heading, "").lines() {
            self.styled_line(HEADING, line);
        }
    }

    /// Prose, its first words styled.
    pub(super) fn verdict(&mut self, style: Style, verdict: &str, rest: &str) {
        let wrapped = self.wrapped(&format!("{verdict} {rest}"), "");
        let (style_on, style_off) = (style.render(), style.render_reset());
        // Wrapping may have broken the verdict itself, on a narrow terminal: then it stays unstyled.
        let styled = match wrapped.strip_prefix(verdict) {
            Some(rest) => format!("{style_on}{verdict}{style_off}{rest}"),
            None => wrapped,
        };
        self.text.push_str(&styled);
        self.text.push('\n');
    }

    /// Prose; each of its lines is wrapped.
    pub(super) fn prose(&mut self, prose: &str) {
        let wrapped = self.wrapped(prose, "  ");
        self.text.push_str(&wrapped);
        self.text.push('\n');
    }

    /// Text kept as it is, indented.
    pub(super) fn verbatim(&mut self, text: &str) {
        for line in text.trim_matches('\n').lines() {
            let line = format!("  {line}");
            self.text.push_str(line.trim_end());
            self.text.push('\n');
        }
    }

    /// Text to copy: kept as it is, lines at the margin.
    pub(super) fn exact(&mut self, text: &str) {
        self.text.push_str(text);
        self.text.push('\n');
    }

    /// A table; columns listed in `right` are aligned to the right. Where a terminal is too narrow for it, a list: no number
    /// is broken.
    pub(super) fn table(&mut self, header: &[String], rows: Vec<Vec<String>>, right: &[usize]) {
        let least = least_widths(header, &rows);
        if self.look.terminal && least.iter().map(|width| width + BESIDE).sum::<usize>() > self.look.width {
            self.list(header, &rows);
            return;
        }
        let mut table = Table::new();
        table.load_style(if self.look.unicode { RULED } else { presets::NOTHING });
        if self.look.terminal {
            table.set_content_arrangement(ContentArrangement::Dynamic);
            table.set_width(u16::try_from(self.look.width.saturating_sub(2)).unwrap_or(u16::MAX));
        } else {
            table.set_content_arrangement(ContentArrangement::Disabled);
        }
        if !header.is_empty() {
            table.set_header(header);
        }
        table.add_rows(rows);
        for (column, width) in least.into_iter().enumerate() {
            if let Some(column) = table.column_mut(column) {
                let width = u16::try_from(width + PADDING).unwrap_or(u16::MAX);
                column.set_constraint(ColumnConstraint::LowerBoundary(Width::Fixed(width)));
            }
        }
        for &column in right {
            if let Some(column) = table.column_mut(column) {
                column.set_cell_alignment(CellAlignment::Right);
            }
        }
        self.verbatim(&table.to_string());
    }

    /// The rows of a table below each other, what the header says before each cell.
    fn list(&mut self, header: &[String], rows: &[Vec<String>]) {
        for row in rows {
            let cells = row.iter().enumerate().filter(|(_, cell)| !cell.trim().is_empty());
            for (line, (column, cell)) in cells.enumerate() {
                let indent = if line == 0 { "  " } else { "    " };
                let told = match header.get(column).filter(|name| !name.is_empty()) {
                    Some(name) => format!("{name}: {}", cell.trim()),
                    None => cell.trim().to_owned(),
                };
                let options = textwrap::Options::new(self.look.width).initial_indent(indent);
                let wrapped = textwrap::fill(&told, options.subsequent_indent("      "));
                self.text.push_str(&wrapped);
                self.text.push('\n');
            }
        }
    }

    /// A sign for plus and minus.
    pub(super) fn plus_minus(&self) -> &'static str {
        if self.look.unicode { "±" } else { "+-" }
    }

    pub(super) fn finish(self) -> String {
        self.text
    }

    fn styled_line(&mut self, style: Style, text: &str) {
        let line = format!("{}{text}{}\n", style.render(), style.render_reset());
        self.text.push_str(&line);
    }

    fn wrapped(&self, prose: &str, indent: &str) -> String {
        let options =
            textwrap::Options::new(self.look.width).initial_indent(indent).subsequent_indent(indent);
        textwrap::fill(prose.trim(), options)
    }
}

/// Width of the longest word of each column: what is narrower breaks it.
fn least_widths(header: &[String], rows: &[Vec<String>]) -> Vec<usize> {
    let columns = rows.iter().map(Vec::len).chain([header.len()]).max().unwrap_or(0);
    let cells =
        |column: usize| rows.iter().map(Vec::as_slice).chain([header]).filter_map(move |row| row.get(column));
    let longest = |column| {
        cells(column).flat_map(|cell| cell.split_whitespace()).map(textwrap::core::display_width).max()
    };
    (0..columns).map(|column| longest(column).unwrap_or(0)).collect()
}
