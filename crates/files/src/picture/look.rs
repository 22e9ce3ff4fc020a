//! How pictures look: their size, which flags they show, in which colours, and how much memory they may take.

use super::canvas::WHITE;
use crate::colours::colour;
use hexcast_derived::mesh::Mesh;

/// How a picture looks.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Look {
    /// Pixels of the longest side of the mesh in slices, of the longer side in a view; None for 600 in slices and 1000 in a view.
    pub size: Option<u32>,
    /// Flags that are shown; all if there is none. Slices leave the cells of others white, and say which.
    pub flags: Vec<u8>,
    /// Colours of flags, red, green and blue, in place of those that they have by themselves; of several of a flag the last.
    pub colours: Vec<(u8, [u8; 3])>,
    /// Most bytes of memory for what is drawn, besides the mesh.
    pub max_bytes: u64,
}

impl Default for Look {
    fn default() -> Look {
        Look { size: None, flags: Vec::new(), colours: Vec::new(), max_bytes: u64::MAX }
    }
}

impl Look {
    /// Takes so many pixels.
    pub fn with_size(mut self, size: u32) -> Look {
        self.size = Some(size);
        self
    }

    /// Shows some flags only.
    pub fn with_flags(mut self, flags: Vec<u8>) -> Look {
        self.flags = flags;
        self
    }

    /// Gives a flag a colour, red, green and blue.
    pub fn with_colour(mut self, flag: u8, rgb: [u8; 3]) -> Look {
        self.colours.push((flag, rgb));
        self
    }

    /// Takes at most so many bytes of memory.
    pub fn with_max_bytes(mut self, max_bytes: u64) -> Look {
        self.max_bytes = max_bytes;
        self
    }

    pub(super) fn shows(&self, flag: u8) -> bool {
        self.flags.is_empty() || self.flags.contains(&flag)
    }

    /// The colour of every flag; white of those that are not shown.
    pub(super) fn colours(&self) -> [[u8; 3]; 256] {
        let mut colours = std::array::from_fn(|flag| colour(flag as u8));
        self.colours.iter().for_each(|&(flag, rgb)| colours[usize::from(flag)] = rgb);
        (0..=255).filter(|&flag| !self.shows(flag)).for_each(|flag| colours[usize::from(flag)] = WHITE);
        colours
    }

    /// The legend of the flags that a picture has: colours, and numbers with names, ascending; those that are not shown come last.
    pub(super) fn legend(&self, mesh: &Mesh, has: &[bool; 256]) -> Vec<([u8; 3], String)> {
        let name = |flag: u8| mesh.names().iter().find(|named| named.flag == flag).map(|named| named.name.clone());
        let text = |flag: u8| match name(flag) {
            Some(name) => format!("{flag} {name}"),
            None if flag == 0 => "0 background".into(),
            None => flag.to_string(),
        };
        let (shown, others): (Vec<u8>, Vec<u8>) =
            (0..=255).filter(|&flag| has[usize::from(flag)]).partition(|&flag| self.shows(flag));
        let colours = self.colours();
        let mut legend: Vec<_> = shown.iter().map(|&flag| (colours[usize::from(flag)], text(flag))).collect();
        if !others.is_empty() {
            let numbers: Vec<String> = others.iter().map(u8::to_string).collect();
            legend.push((WHITE, format!("not shown: {}", numbers.join(", "))));
        }
        legend
    }
}
