//! XML, element after element.

use std::io::Write;

use quick_xml::events::{BytesDecl, BytesEnd, BytesStart, BytesText, Event};
use quick_xml::writer::Writer;

use super::output::failed;
use hexcast_core::base::error::Result;

/// Attributes of an element: names and values.
pub(super) type Attributes<'a> = &'a [(&'a str, &'a str)];

/// A document being written.
pub(super) struct Xml<W: Write> {
    writer: Writer<W>,
}

impl<W: Write> Xml<W> {
    /// Begins a document.
    pub(super) fn new(out: W) -> Result<Xml<W>> {
        let mut xml = Xml { writer: Writer::new_with_indent(out, b' ', 1) };
        xml.put(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
        Ok(xml)
    }

    /// An element with others, or text, in it; [`Xml::close`] ends it.
    pub(super) fn open(&mut self, name: &str, attributes: Attributes) -> Result<()> {
        self.put(Event::Start(start(name, attributes)))
    }

    pub(super) fn close(&mut self, name: &str) -> Result<()> {
        self.put(Event::End(BytesEnd::new(name)))
    }

    /// An element without content.
    pub(super) fn empty(&mut self, name: &str, attributes: Attributes) -> Result<()> {
        self.put(Event::Empty(start(name, attributes)))
    }

    /// An element with text alone.
    pub(super) fn text(&mut self, name: &str, attributes: Attributes, text: &str) -> Result<()> {
        self.open(name, attributes)?;
        self.more(text)?;
        self.close(name)
    }

    /// Text in the element that is open.
    pub(super) fn more(&mut self, text: &str) -> Result<()> {
        self.put(Event::Text(BytesText::new(text)))
    }

    fn put(&mut self, event: Event) -> Result<()> {
        self.writer.write_event(event).map_err(failed)
    }
}

fn start<'a>(name: &'a str, attributes: Attributes<'a>) -> BytesStart<'a> {
    BytesStart::new(name).with_attributes(attributes.iter().copied())
}
