//! What sections of the page are made of.

use maud::{Markup, html};

/// A section with its heading; `id` is unique on the page.
pub(super) fn section(id: &str, heading: &str, body: &Markup) -> Markup {
    let heading_id = format!("{id}-heading");
    html! {
        section id=(id) aria-labelledby=(heading_id) { h2 id=(heading_id) { (heading) } (body) }
    }
}

/// A table. Its columns are told as `text` or `>number`, which is set to the right; the first cell of a row names it.
pub(super) fn table(caption: &str, columns: &[String], rows: &[Vec<Markup>]) -> Markup {
    let class = |index: usize| columns.get(index).filter(|column| column.starts_with('>')).map(|_| "number");
    html! {
        div.wide tabindex="0" role="region" aria-label=(caption) {
            table {
                caption { (caption) }
                thead { tr {
                    @for (index, column) in columns.iter().enumerate() {
                        th scope="col" class=[class(index)] { (column.trim_start_matches('>')) }
                    }
                } }
                tbody {
                    @for row in rows { tr {
                        @for (index, cell) in row.iter().enumerate() {
                            @if index == 0 {
                                th scope="row" class=[class(index)] { (cell) }
                            } @else {
                                td class=[class(index)] { (cell) }
                            }
                        }
                    } }
                }
            }
        }
    }
}

/// Columns of a table, as [`table`] takes them.
pub(super) fn columns<const N: usize>(columns: [&str; N]) -> Vec<String> {
    columns.map(str::to_owned).to_vec()
}

/// A cell of text.
pub(super) fn cell(text: impl AsRef<str>) -> Markup {
    html! { (text.as_ref()) }
}

/// The user's own name of something, which may run in either direction.
pub(super) fn name(text: &str) -> Markup {
    html! { bdi { (text) } }
}

/// A text to take away as it is, with a button that copies it.
pub(super) fn literal(what: &str, text: &str) -> Markup {
    html! {
        div.literal {
            pre tabindex="0" { (text) }
            button.copy type="button" aria-label={ "copy " (what) } hidden[true] { "copy" }
        }
    }
}
