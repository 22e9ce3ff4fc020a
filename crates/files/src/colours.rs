//! The colours of flags, wherever hexcast draws them.

/// Cells of the background.
const BACKGROUND: [u8; 3] = [238, 241, 245];
/// Colours that differ in hue and lightness, also for the colour-blind (after Okabe and Ito): those of the page.
const PALETTE: [[u8; 3]; 10] = [
    [217, 131, 36],
    [58, 143, 201],
    [47, 158, 119],
    [201, 89, 154],
    [138, 111, 209],
    [184, 165, 30],
    [209, 88, 74],
    [93, 127, 153],
    [125, 155, 60],
    [169, 116, 79],
];

/// The colour of a flag, red, green, blue.
pub(crate) fn colour(flag: u8) -> [u8; 3] {
    if flag == 0 { BACKGROUND } else { PALETTE[usize::from(flag - 1) % PALETTE.len()] }
}
