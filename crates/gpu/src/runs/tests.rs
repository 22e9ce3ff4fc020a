//! What a device may return, and what it may not.

use hexcast_core::set;

use super::*;

/// Two rows of 10 rays: chunks of 8 and 2 rays, in another order than that of the rays; the second linked, the third deep.
fn band(chunks: &[[u32; 2]], places: &[u32], deep: DeepRows) -> Result<Band, Fault> {
    let raw = Raw { chunks, places, n_lost: 3, n_unused: 0, n_hits: Some(20), deep: &deep };
    Returned { params: &params(), raw: &raw, cast_again: &[], flags: &[0, 1, 2] }.band()
}

fn params() -> Params {
    Params { n_i: 10, n_across: 2, first_row: 4, end_row: 6, depth: 100, ..bytemuck::Zeroable::zeroed() }
}

const CHUNKS: [[u32; 2]; 4] = [[4, 0x2000_0001], [LINKED | 1 << PLACE_BITS | 2, 0x10], [0, DEEP], [7, 0x50]];

#[rustfmt::skip]
const PLACES: [u32; 36] = [
    0x101, 0x200, 9, 9,  0x102, 9, 9, 9,  // the first segment of the second chunk
    0, 0x12, 0, 0,  0x301, 9, 9, 9,       // the second, with its link
    0x001, 9, 9, 9,  0x102, 0x201, 9, 9,
    9, 9, 9, 9, // of nobody
    0x001, 0x102, 0x201, 0x302,  0x401, 9, 9, 9,
];

fn deep() -> DeepRows {
    let rows = vec![0, 0, 0, 2, 2, 2, 2, 2, 0, 0, 2, 0, 0, 0, 0, 1];
    DeepRows { offsets: vec![0, 5], rows, events: vec![0x101, 0x302, 0x001, 9, 9], buffers: None }
}

fn without_nobody() -> Vec<u32> {
    [&PLACES[..24], &PLACES[28..]].concat()
}

#[test]
fn runs_come_out_in_the_order_of_the_rays() {
    let places = without_nobody();
    let mut chunks = CHUNKS;
    chunks[3][0] = 6;
    let band = band(&chunks, &places, deep()).expect("all is possible");
    assert_eq!(band.runs[..6], [0x001, 0x102, 0x201, 0x101, 0x200, 0x102]);
    assert_eq!(band.runs[6..], [0x301, 0x101, 0x302, 0x001, 0x001, 0x102, 0x201, 0x302, 0x401]);
    assert_eq!(band.ends[..10], [1, 1, 1, 1, 1, 1, 1, 3, 5, 7]);
    assert_eq!(band.ends[10..], [7, 7, 9, 9, 9, 9, 9, 10, 10, 15]);
    assert_eq!((band.odd_rays, band.n_crossings, band.first_ray), (1, 3 + 12 + 5, 40));
}

#[test]
fn what_cannot_be_is_a_fault() {
    let places = without_nobody();
    let mut chunks = CHUNKS;
    chunks[3][0] = 6;
    let fault = |chunks: &[[u32; 2]], places: &[u32], deep| band(chunks, places, deep).expect_err("a fault");
    let changed = |chunk: usize, word: usize, to: u32| {
        let mut changed = chunks;
        changed[chunk][word] = to;
        changed
    };
    assert!(fault(&changed(0, 0, 99), &places, deep()).contains("place 99"), "beyond the places");
    assert!(fault(&changed(0, 1, 0x9), &places, deep()).contains("0x9"), "nine runs of a ray");
    assert!(fault(&changed(0, 1, 0), &places, deep()).contains("places of runs are used"), "a chunk dropped");
    assert!(fault(&changed(0, 0, 4 | 9 << PLACE_BITS), &places, deep()).contains("9 odd rays"));
    assert!(fault(&changed(2, 0, 1), &places, deep()).contains("deep row 1 of 1"));
    let mut ring = places.clone();
    ring[8] = LINKED | 2;
    assert!(fault(&chunks, &ring, deep()).contains("chunk 1"), "segments in a ring");
    for wrong in [0x6401, 3, 0, 0x102] {
        let mut places = places.clone();
        places[17 + 4] = wrong;
        assert!(fault(&chunks, &places, deep()).contains("chunk 0 has the runs"), "{wrong:x}");
    }
    for (word, to) in [(8, 6), (7, 6), (0, 9)] {
        let mut deep = deep();
        deep.rows[word] = to;
        assert!(fault(&chunks, &places, deep).contains("deep row 0"), "{word}");
    }
}

#[test]
fn equal_flags_are_joined() {
    let mut band = set!(Band { ends: vec![3, 3, 4], runs: vec![0x101, 0x201, 0x300, 0x101], ..Band::default() });
    join_equal(&mut band);
    assert_eq!((band.ends, band.runs), (vec![2, 2, 3], vec![0x101, 0x300, 0x101]));
    assert!(has_twice(&[0, 4, 4]) && !has_twice(&[0, 4, 5]));
}

#[test]
fn counts_are_four_bits_each() {
    assert_eq!((sum_of_counts(0x8888_8888), sum_of_counts(0x8000_0001)), (64, 9));
    assert_eq!((n_places(0x8888_8888), n_places(0x5000_0041)), (16, 4));
    assert!(are_too_many(0x0900_0000) && are_too_many(0xf) && !are_too_many(0x8888_7070));
}
