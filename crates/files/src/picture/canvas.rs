//! The canvas: pixels, rectangles, text, and PNG.

use std::convert::Infallible;

use embedded_graphics::Drawable;
use embedded_graphics::Pixel;
use embedded_graphics::draw_target::DrawTarget;
use embedded_graphics::geometry::{OriginDimensions, Point, Size};
use embedded_graphics::mono_font::iso_8859_1::FONT_9X15;
use embedded_graphics::mono_font::{MonoFont, MonoTextStyle};
use embedded_graphics::pixelcolor::{Rgb888, RgbColor};
use embedded_graphics::text::{Baseline, Text};

use super::png::png;
use super::{MARGIN, check_memory};
use hexcast_core::base::control::{Control, at_once};
use hexcast_core::base::error::{Error, Result};

/// Most pixels on a side.
const MAX_SIDE: u32 = 32_768;
/// Bytes of a pixel: its colour, and twice as much for the file at its worst while it grows.
pub(super) const PIXEL_BYTES: u64 = 9;
const FONT: MonoFont = FONT_9X15;
/// Pixels from a line of text to the next.
pub(super) const LINE: u32 = FONT.character_size.height + 5;
pub(super) const WHITE: [u8; 3] = [255; 3];
pub(super) const TEXT: [u8; 3] = [38, 44, 52];
/// Pixels, red, green and blue of one byte each, row after row from the top.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    width: u32,
    height: u32,
    rgb: Vec<u8>,
}

impl Picture {
    /// An empty picture, with its file in at most so many bytes.
    ///
    /// # Errors
    /// `job-value` where a side has no pixel or more than 32,768; `memory` where it takes more than is allowed.
    pub(super) fn new(width: u32, height: u32, max_bytes: u64) -> Result<Picture> {
        check_sides([width, height])?;
        let what = format!("a picture of {width} x {height} pixels");
        check_memory(&what, PIXEL_BYTES * u64::from(width) * u64::from(height), max_bytes)?;
        let rgb = WHITE.repeat(width as usize * height as usize);
        Ok(Picture { width, height, rgb })
    }

    /// Bytes of its pixels.
    pub(super) fn n_bytes(&self) -> u64 {
        self.rgb.len() as u64
    }

    /// Adds white rows below.
    ///
    /// # Errors
    /// `job-value` where these are too many.
    pub(super) fn grow(&mut self, rows: u32) -> Result<()> {
        check_sides([self.width, self.height + rows])?;
        self.height += rows;
        self.rgb.resize(3 * self.width as usize * self.height as usize, 255);
        Ok(())
    }

    /// Pixels along x.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Pixels along y.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Red, green and blue of a pixel, counted from the left and from the top; white beyond the picture.
    pub fn pixel(&self, x: u32, y: u32) -> [u8; 3] {
        let at = 3 * (y as usize * self.width as usize + x as usize);
        let is_inside = x < self.width && y < self.height;
        if is_inside { [self.rgb[at], self.rgb[at + 1], self.rgb[at + 2]] } else { WHITE }
    }

    /// The file, PNG of 8 bits a channel.
    ///
    /// # Errors
    /// `io` where it cannot be compressed.
    pub fn png(&self) -> Result<Vec<u8>> {
        at_once(self.png_with_rests(&Control::default()))
    }

    /// Like [`Picture::png`], with a rest every some rows ([`Control::rest`]).
    ///
    /// # Errors
    /// Those of [`Picture::png`]; `cancelled`.
    #[doc(hidden)]
    pub async fn png_with_rests(&self, control: &Control) -> Result<Vec<u8>> {
        png(self.width, self.height, &self.rgb, control).await
    }

    /// Sets a pixel, if the picture has it.
    pub(super) fn set(&mut self, x: u32, y: u32, rgb: [u8; 3]) {
        if x < self.width && y < self.height {
            let at = 3 * (y as usize * self.width as usize + x as usize);
            self.rgb[at..at + 3].copy_from_slice(&rgb);
        }
    }

    /// Fills a rectangle from a corner.
    pub(super) fn fill(&mut self, [x, y]: [u32; 2], [width, height]: [u32; 2], rgb: [u8; 3]) {
        for (x, y) in (y..y + height).flat_map(|y| (x..x + width).map(move |x| (x, y))) {
            self.set(x, y, rgb);
        }
    }

    /// Writes a line of text below a corner, in at most so many pixels.
    pub(super) fn text(&mut self, [x, y]: [u32; 2], text: &str, width: u32) {
        let most = (width / FONT.character_size.width) as usize;
        // the font has the letters of Latin-1
        let known = text.chars().map(|c| if c.is_control() || u32::from(c) > 0xff { '?' } else { c });
        let mut shown: String = known.collect();
        if shown.chars().count() > most {
            shown = shown.chars().take(most.saturating_sub(2)).chain("..".chars()).collect();
        }
        let style = MonoTextStyle::new(&FONT, Rgb888::new(TEXT[0], TEXT[1], TEXT[2]));
        let Ok(_) = Text::with_baseline(&shown, Point::new(x as i32, y as i32), style, Baseline::Top).draw(self);
    }

    /// Draws a legend into a width, from a height on.
    pub(super) fn legend(&mut self, top: u32, entries: &[([u8; 3], String)]) {
        let (columns, width) = legend_columns(self.width, entries);
        for (index, (rgb, text)) in (0..).zip(entries) {
            let (x, y) = (MARGIN + index % columns * width, top + index / columns * LINE);
            self.fill([x, y], [LINE - 5, LINE - 5], [150; 3]);
            self.fill([x + 1, y + 1], [LINE - 7, LINE - 7], *rgb);
            self.text([x + LINE, y], text, width - LINE);
        }
    }
}

/// Refuses sides of no pixel, and those of more than a picture has.
///
/// # Errors
/// `job-value`.
pub(super) fn check_sides([width, height]: [u32; 2]) -> Result<()> {
    if (1..=MAX_SIDE).contains(&width) && (1..=MAX_SIDE).contains(&height) {
        return Ok(());
    }
    let message = format!("a picture of {width} x {height} pixels; a side has 1 to {MAX_SIDE}");
    Err(Error::new("job-value", message, "ask for a smaller picture, or for fewer slices at once"))
}

/// Pixels that a legend takes down in a picture so wide.
pub(super) fn legend_height(width: u32, entries: &[([u8; 3], String)]) -> u32 {
    (entries.len() as u32).div_ceil(legend_columns(width, entries).0) * LINE
}

/// Entries side by side in a picture so wide, and the width of each.
fn legend_columns(width: u32, entries: &[([u8; 3], String)]) -> (u32, u32) {
    let longest = entries.iter().map(|(_, text)| text.chars().count()).max().unwrap_or(0).min(40) as u32;
    let wanted = LINE + (longest + 2) * FONT.character_size.width;
    let inner = width.saturating_sub(2 * MARGIN).max(1);
    ((inner / wanted).max(1), wanted.min(inner.max(LINE)))
}

impl OriginDimensions for Picture {
    fn size(&self) -> Size {
        Size::new(self.width, self.height)
    }
}

impl DrawTarget for Picture {
    type Color = Rgb888;
    type Error = Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<Rgb888>>>(&mut self, pixels: I) -> std::result::Result<(), Infallible> {
        for Pixel(Point { x, y }, colour) in pixels {
            if let (Ok(x), Ok(y)) = (u32::try_from(x), u32::try_from(y)) {
                self.set(x, y, [colour.r(), colour.g(), colour.b()]);
            }
        }
        Ok(())
    }
}
