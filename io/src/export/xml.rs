//! A document of elements, put together first and written at once.

use std::{borrow::Cow, io};

use quick_xml::{
    Writer,
    events::{BytesDecl, BytesStart, BytesText, Event},
};

/// An element: attributes, then elements or text.
#[derive(Debug, Clone)]
pub(super) struct Element {
    name: Cow<'static, str>,
    attributes: Vec<(&'static str, String)>,
    text: Option<String>,
    children: Vec<Element>,
}

impl Element {
    /// An element of these.
    pub(super) fn of(name: impl Into<Cow<'static, str>>, children: impl IntoIterator<Item = Self>) -> Self {
        let children = children.into_iter().collect();
        Self { name: name.into(), attributes: Vec::new(), text: None, children }
    }

    /// The same, its attribute `n` telling how many they are.
    pub(super) fn list(name: &'static str, children: impl IntoIterator<Item = Self>) -> Self {
        let list = Self::of(name, children);
        let count = list.children.len();
        list.with("n", count)
    }

    /// An element with text.
    #[expect(clippy::needless_pass_by_value, reason = "numbers, words and texts are told alike")]
    pub(super) fn text(name: impl Into<Cow<'static, str>>, text: impl ToString) -> Self {
        Self { text: Some(legal(&text.to_string())), ..Self::of(name, []) }
    }

    /// Adds an attribute.
    #[expect(clippy::needless_pass_by_value, reason = "numbers, words and texts are told alike")]
    pub(super) fn with(mut self, name: &'static str, value: impl ToString) -> Self {
        self.attributes.push((name, legal(&value.to_string())));
        self
    }

    /// The bytes of a document of which it is the root.
    pub(super) fn document(&self) -> io::Result<Vec<u8>> {
        let mut writer = Writer::new_with_indent(Vec::new(), b' ', 2);
        writer.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
        self.write(&mut writer)?;
        let mut bytes = writer.into_inner();
        bytes.push(b'\n');
        Ok(bytes)
    }

    fn write(&self, writer: &mut Writer<Vec<u8>>) -> io::Result<()> {
        let mut start = BytesStart::new(self.name.as_ref());
        start.extend_attributes(self.attributes.iter().map(|(name, value)| (*name, value.as_str())));
        if self.children.is_empty() && self.text.is_none() {
            return writer.write_event(Event::Empty(start));
        }
        let end = start.to_end().into_owned();
        writer.write_event(Event::Start(start))?;
        if let Some(text) = &self.text {
            writer.write_event(Event::Text(BytesText::new(text)))?;
        }
        self.children.iter().try_for_each(|child| child.write(writer))?;
        writer.write_event(Event::End(end))
    }
}

/// The text with a sign in the place of each character that no XML may hold.
fn legal(text: &str) -> String {
    let is_legal = |c: char| matches!(c, '\t' | '\n' | '\r' | '\u{20}'..='\u{fffd}' | '\u{1_0000}'..);
    text.chars().map(|c| if is_legal(c) { c } else { char::REPLACEMENT_CHARACTER }).collect()
}
