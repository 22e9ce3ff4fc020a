// Crossings of deep rows, as the kernels that cast them write them, row by row.
// Reads and writes: next_event[row], where the next crossing of a deep row goes, counted up; with event_capacity 0 it only counts.
// Writes: events[next_event ..] = ray of the row << 27 | cell << 9 | rank << 1 | direction, in no order within a row; if wanted, the
// facet of each goes to the same place of the second half of the buffer, from event_capacity on.

@group(0) @binding(3) var<storage, read_write> next_event: array<atomic<u32>>;
@group(0) @binding(4) var<storage, read_write> events: array<u32>;

// The rays of a row of a bin that a facet hits, a bit each.
fn hits_of_row(hits: vec2<u32>, row: u32) -> u32 {
    return (select(hits.y, hits.x, row < 4u) >> (8u * (row % 4u))) & 0xffu;
}

// Writes a crossing of a ray of a row to a place below event_capacity.
fn write_event(place: u32, ray: u32, cell: u32, tag: u32, facet: u32) {
    events[place] = (ray << 27u) | (cell << 9u) | (tag & 0x1ffu);
    if params.with_facets == 1u {
        events[params.event_capacity + place] = params.first_facet + facet;
    }
}
