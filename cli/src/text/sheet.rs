//! A sheet of text: headings, prose and tables.

use anstyle::{AnsiColor, Style};
use comfy_table::{CellAlignment, ContentArrangement, LineStyle, Table, TableStyle, presets};

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
        self.styled_line(HEADING, heading);
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

    /// A table; columns listed in `right` are aligned to the right.
    pub(super) fn table(&mut self, header: &[String], rows: Vec<Vec<String>>, right: &[usize]) {
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
        for &column in right {
            if let Some(column) = table.column_mut(column) {
                column.set_cell_alignment(CellAlignment::Right);
            }
        }
        self.verbatim(&table.to_string());
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
