//! The number that a store has for each cell.

use serde_json::{Value, json};

use hexcast_core::base::error::Result;
use hexcast_core::cells::columns::Columns;
use hexcast_core::cells::flags::CellBox;

/// The array of flags.
pub(super) const FLAG: &str = "flag";

/// A number for each cell.
pub(crate) struct OfCells<'a> {
    pub(crate) name: &'static str,
    /// Type, the number that is not stored, bytes of a number.
    pub(crate) numbers: (&'static str, Value, usize),
    /// Rays of a cell, of fractions.
    pub(crate) rays: Option<u32>,
    pub(crate) of_box: OfBox<'a>,
}

/// Makes the numbers of a box of cells.
type Numbers<'a> = dyn Fn(&Columns, &CellBox) -> Result<Vec<u8>> + Sync + 'a;

/// Where the numbers of a box of cells come from.
pub(crate) enum OfBox<'a> {
    Flags,
    /// What they are, x fastest, little-endian.
    Numbers(Box<Numbers<'a>>),
}

impl<'a> OfCells<'a> {
    /// The flags.
    pub(crate) fn flags() -> OfCells<'a> {
        OfCells { name: FLAG, numbers: ("uint8", json!(0), 1), rays: None, of_box: OfBox::Flags }
    }
}
