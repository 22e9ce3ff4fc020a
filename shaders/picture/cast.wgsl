// Casts a ray a pixel through the runs of a mesh and colours the first cell that is seen: the page's 3-D view.
// A ray walks over the columns across the runs (Amanatides and Woo, A Fast Voxel Traversal Algorithm for Ray Tracing, 1987); in each it
// looks for the run at its place by a search in halves. Tiles of 64 and of 8 columns, with the range of their cells along the runs, let
// it pass what is empty. Places are in lengths of the box: cells where cells are equal, else lengths from the first line.
// Reads: frame; words, rows of 2^row_shift numbers, of which each part begins a row:
//   offsets[n_u * n_v + 1], the first run of column u + n_u * v, and the end; runs, cell << 8 | flag, ascending in each column;
//   tiles of 8, then of 64 columns: two numbers each, the first cell that has a flag and the end of the last, first >= end where none has;
//   lines of u, v and w, as bits of floats, n + 1 each, where cells differ in size; colours[256], alpha << 24 | blue << 16 | green << 8 |
//   red, with alpha 0 for what is hidden and for 0.
// Writes: the colour; the cell (u, v, w) and flag | face << 8, where face is the axis, plus 3 for a face that looks up it, or 6 for the cut.
// Bound: 3 steps a column and tile that a ray crosses, 2^14 at most; 20 steps of a search each.
// Translated to GLSL ES 3.00 by naga: crates/gpu/src/kernels/tests/picture.rs holds the translation to this text.

struct Frame {
    // the eye, and what is added to a ray for the middle of the picture, to its right and its upper edge: a ray's length is its depth
    eye: vec3f,
    // depth in the buffer is depth_scale / t + depth_offset
    depth_scale: f32,
    ahead: vec3f,
    depth_offset: f32,
    right: vec3f,
    // of half the picture
    pixels_x: f32,
    up: vec3f,
    pixels_y: f32,
    // what is left of the box by the cut
    low: vec3f,
    // whether cells differ in size
    is_graded: u32,
    high: vec3f,
    // face of the box that the cut makes: axis, plus 3 for the upper; 6 for none
    cut: u32,
    // cells of u, v and w
    cells: vec3u,
    row_shift: u32,
    // light of the faces that look down and up each axis
    light_down: vec3f,
    // 1 for the picture at rest: with soft shadows in corners
    is_fine: u32,
    light_up: vec3f,
    // of a pixel, in pixels
    jitter_x: f32,
    // rows at which the parts begin
    offsets: u32,
    runs: u32,
    tiles_8: u32,
    tiles_64: u32,
    lines: u32,
    colours: u32,
    jitter_y: f32,
}

struct Corner {
    @builtin(position) position: vec4f,
    @location(0) place: vec2f,
}

struct Seen {
    @location(0) colour: vec4f,
    @location(1) cell: vec4u,
    @builtin(frag_depth) depth: f32,
}

struct Hit {
    cell: vec3i,
    flag: u32,
    // axis of the face
    axis: i32,
    t: f32,
    is_start: bool,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var words: texture_2d<u32>;

const MOST_STEPS: u32 = 16384u;
// Cells around a place that tell how its surface lies.
const REACH: f32 = 2.6;

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Corner {
    let place = vec2f(f32(index & 1u), f32(index >> 1u)) * 4.0 - 1.0;
    return Corner(vec4f(place, 0.0, 1.0), place);
}

@fragment
fn fragment(@location(0) place: vec2f) -> Seen {
    let at = place + vec2f(frame.jitter_x / frame.pixels_x, frame.jitter_y / frame.pixels_y);
    let way = direction(at);
    let hit = first_seen(frame.eye, way);
    if hit.flag == 0u {
        discard;
    }
    let up = way[hit.axis] < 0.0;
    let is_cut = hit.is_start && frame.cut != 6u && hit.axis == i32(frame.cut % 3u) && up == (frame.cut >= 3u);
    let colour = unpack4x8unorm(word(frame.colours, hit.flag)).rgb;
    let face = select(u32(hit.axis) + select(0u, 3u, up), 6u, is_cut);
    let shade = shade(hit, way, up, is_cut);
    let depth = frame.depth_scale / hit.t + frame.depth_offset;
    return Seen(vec4f(colour * shade, 1.0), vec4u(vec3u(hit.cell), hit.flag | (face << 8u)), depth);
}

// The ray of a place of the picture, from -1 to 1 each way.
fn direction(place: vec2f) -> vec3f {
    let way = frame.ahead + frame.right * place.x + frame.up * place.y;
    // nowhere along a face
    return select(way, vec3f(1e-12), abs(way) < vec3f(1e-12));
}

fn word(row: u32, at: u32) -> u32 {
    return textureLoad(words, vec2u(at & ((1u << frame.row_shift) - 1u), row + (at >> frame.row_shift)), 0).x;
}

// Where a line is.
fn line(axis: i32, at: i32) -> f32 {
    if frame.is_graded == 0u {
        return f32(at);
    }
    let before = select(0u, frame.cells.x + 1u, axis > 0) + select(0u, frame.cells.y + 1u, axis > 1);
    return bitcast<f32>(word(frame.lines, before + u32(at)));
}

// The cell that holds a place along an axis, of those from `first` to before `end`.
fn cell_at(axis: i32, place: f32, first: i32, end: i32) -> i32 {
    if frame.is_graded == 0u {
        return clamp(i32(floor(place)), first, end - 1);
    }
    var low = first;
    var high = end;
    while high - low > 1 {
        let middle = (low + high) / 2;
        if line(axis, middle) <= place {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

fn run(at: u32) -> u32 {
    return word(frame.runs, at);
}

fn is_seen(flag: u32) -> bool {
    return flag != 0u && (word(frame.colours, flag) >> 24u) != 0u;
}

// The first cell along a ray that is seen; its flag is 0 where there is none.
fn first_seen(eye: vec3f, way: vec3f) -> Hit {
    let none = Hit(vec3i(0), 0u, 0, 0.0, false);
    let inverse = 1.0 / way;
    let to_low = (frame.low - eye) * inverse;
    let to_high = (frame.high - eye) * inverse;
    let near = min(to_low, to_high);
    let far = max(to_low, to_high);
    let start = max(max(near.x, max(near.y, near.z)), 0.0);
    let length = min(far.x, min(far.y, far.z)) - start;
    if length <= 0.0 {
        return none;
    }
    var axis = select(select(2, 1, near.y > near.z), 0, near.x > max(near.y, near.z));
    // from here on places are exact to a small part of a cell
    var origin = eye + way * start;
    origin = select(origin, select(frame.high, frame.low, way > vec3f(0.0)), near >= vec3f(start));
    let n = vec3i(frame.cells);
    let goes_up = way.xy > vec2f(0.0);
    var column = vec2i(cell_at(0, origin.x, 0, n.x), cell_at(1, origin.y, 0, n.y));
    var t = 0.0;
    var shift = 6u;
    for (var step = 0u; step < MOST_STEPS; step++) {
        let first = (column >> vec2u(shift)) << vec2u(shift);
        let end = min(first + vec2i(1 << shift), n.xy);
        let out_u = (line(0, select(first.x, end.x, goes_up.x)) - origin.x) * inverse.x;
        let out_v = (line(1, select(first.y, end.y, goes_up.y)) - origin.y) * inverse.y;
        let out = min(min(out_u, out_v), length);
        let w_in = origin.z + way.z * t;
        if shift > 0u {
            let range = tile(column, shift);
            let w_out = origin.z + way.z * out;
            if range.x < range.y && line(2, range.x) <= max(w_in, w_out) && line(2, range.y) >= min(w_in, w_out) {
                shift -= 3u;
                continue;
            }
        } else {
            var hit = in_column(column, w_in, origin.z, way.z, vec2f(t, out), axis);
            if hit.flag != 0u {
                hit.is_start = hit.t <= 0.0;
                hit.t += start;
                return hit;
            }
        }
        if out >= length {
            break;
        }
        t = max(t, out);
        var next = column;
        if out_u < out_v {
            axis = 0;
            next.x = select(first.x - 1, end.x, goes_up.x);
            next.y = cell_at(1, origin.y + way.y * t, first.y, end.y);
        } else {
            axis = 1;
            next.x = cell_at(0, origin.x + way.x * t, first.x, end.x);
            next.y = select(first.y - 1, end.y, goes_up.y);
        }
        if any(next < vec2i(0)) || any(next >= n.xy) {
            break;
        }
        let crossed = (column.x ^ next.x) | (column.y ^ next.y);
        shift = select(select(0u, 3u, (crossed >> 3u) != 0), 6u, (crossed >> 6u) != 0);
        column = next;
    }
    return none;
}

// The range of cells with flags in the tile of a column.
fn tile(column: vec2i, shift: u32) -> vec2i {
    let at = vec2u(column >> vec2u(shift));
    let across = (frame.cells.x + (1u << shift) - 1u) >> shift;
    let entry = 2u * (at.x + across * at.y);
    let row = select(frame.tiles_8, frame.tiles_64, shift == 6u);
    return vec2i(vec2u(word(row, entry), word(row, entry + 1u)));
}

// The first run from `first` to before `end` that begins beyond a place, or at it.
fn beyond(first: u32, end: u32, place: f32, or_at: bool) -> u32 {
    var least = first;
    var most = end;
    while least < most {
        let middle = (least + most) / 2u;
        let begins = line(2, i32(run(middle) >> 8u));
        if begins > place || (or_at && begins == place) {
            most = middle;
        } else {
            least = middle + 1u;
        }
    }
    return least;
}

// What is first seen in a column, which the ray enters at `span.x` through a face across `axis` and leaves at `span.y`; w is `zero` at 0.
fn in_column(column: vec2i, w_in: f32, zero: f32, way: f32, span: vec2f, axis: i32) -> Hit {
    let none = Hit(vec3i(0), 0u, 0, 0.0, false);
    let k = u32(column.x) + frame.cells.x * u32(column.y);
    let first = word(frame.offsets, k);
    let end = word(frame.offsets, k + 1u);
    if first >= end {
        return none;
    }
    // the run after the one that holds the place; before the first there is none
    let entered = beyond(first, end, w_in, way < 0.0);
    var after = entered;
    var t = span.x;
    while t <= span.y {
        if after > first {
            let here = run(after - 1u);
            if is_seen(here & 255u) {
                let begin = i32(here >> 8u);
                let stop = i32(end_of(after - 1u, end));
                var w = select(stop - 1, begin, way > 0.0);
                if after == entered {
                    w = cell_at(2, w_in, begin, stop);
                }
                return Hit(vec3i(column, w), here & 255u, select(2, axis, after == entered), t, false);
            }
        }
        if way > 0.0 {
            if after >= end {
                break;
            }
            t = (line(2, i32(run(after) >> 8u)) - zero) / way;
            after++;
        } else {
            if after <= first {
                break;
            }
            after--;
            t = (line(2, i32(run(after) >> 8u)) - zero) / way;
        }
    }
    return none;
}

// The cell after the last of a run; `end` is the run after the last of its column.
fn end_of(at: u32, end: u32) -> u32 {
    if at + 1u < end {
        return run(at + 1u) >> 8u;
    }
    return frame.cells.z;
}

// How bright a face is: by its direction, darker in corners, with lines where cells are large.
fn shade(hit: Hit, way: vec3f, up: bool, is_cut: bool) -> f32 {
    let place = frame.eye + way * hit.t;
    let low = vec3f(line(0, hit.cell.x), line(1, hit.cell.y), line(2, hit.cell.z));
    let size = vec3f(line(0, hit.cell.x + 1), line(1, hit.cell.y + 1), line(2, hit.cell.z + 1)) - low;
    // cells a pixel: a place on the face moves with the ray
    let right = hit.t * (frame.right - way * (frame.right[hit.axis] / way[hit.axis])) / frame.pixels_x;
    let above = hit.t * (frame.up - way * (frame.up[hit.axis] / way[hit.axis])) / frame.pixels_y;
    let per_pixel = max((abs(right) + abs(above)) / size, vec3f(1e-6));
    let within = clamp((place - low) / size, vec3f(0.0), vec3f(1.0));
    let to_line = min(within, 1.0 - within) / per_pixel;
    var drawn = (1.0 - smoothstep(vec3f(0.3), vec3f(1.1), to_line)) * (1.0 - smoothstep(vec3f(0.07), vec3f(0.1667), per_pixel));
    drawn[hit.axis] = 0.0;
    let edge = max(drawn.x, max(drawn.y, drawn.z));
    var light = select(frame.light_down[hit.axis], frame.light_up[hit.axis], up);
    if is_cut {
        light = 1.0;
    } else if frame.is_fine != 0u {
        // 1 where cells are large enough to be told apart
        let large = 1.0 - smoothstep(0.1, 0.3, max(per_pixel.x, max(per_pixel.y, per_pixel.z)));
        light *= mix(1.0, corner_light(hit, within, up), large);
        if large < 1.0 {
            light = mix(round_light(hit, within, up), light, large);
        }
    }
    return light * (1.0 - 0.34 * edge);
}

// The light of the smooth surface that small cells stand for: its normal is where most of the cells around are open.
fn round_light(hit: Hit, within: vec3f, up: bool) -> f32 {
    var place = vec3f(hit.cell) + within;
    // a little before the face: rounding would put some places behind it
    place[hit.axis] = f32(hit.cell[hit.axis]) + select(-0.01, 1.01, up);
    var normal = vec3f(0.0);
    var open = 0.0;
    for (var at = 0; at < 27; at++) {
        if at == 13 {
            continue;
        }
        let way = vec3f(f32(at % 3), f32((at / 3) % 3), f32(at / 9)) - 1.0;
        let one = is_open(vec3i(floor(place + way * (REACH / sqrt(dot(way, way))))));
        normal += way * (one / dot(way, way));
        open += one;
    }
    if dot(normal, normal) == 0.0 {
        return 0.5;
    }
    normal = normalize(normal);
    let light = max(normal, vec3f(0.0)) * frame.light_up + max(-normal, vec3f(0.0)) * frame.light_down;
    let tone = dot(light, abs(normal));
    return tone * (0.72 + 0.28 * smoothstep(0.2, 0.55, open / 26.0));
}

// Whether the cell of a place beside a face lets light through, 1 or 0.
fn is_open(cell: vec3i) -> f32 {
    if any(cell < vec3i(0)) || any(cell >= vec3i(frame.cells)) {
        return 1.0;
    }
    let k = u32(cell.x) + frame.cells.x * u32(cell.y);
    let first = word(frame.offsets, k);
    let end = word(frame.offsets, k + 1u);
    if first >= end {
        return 1.0;
    }
    let after = beyond(first, end, line(2, cell.z), false);
    if after == first {
        return 1.0;
    }
    return select(1.0, 0.0, is_seen(run(after - 1u) & 255u));
}

// The light that the eight cells around the one before a face leave to it, between its corners by the place within.
fn corner_light(hit: Hit, within: vec3f, up: bool) -> f32 {
    let a = (hit.axis + 1) % 3;
    let b = (hit.axis + 2) % 3;
    var before = hit.cell;
    before[hit.axis] += select(-1, 1, up);
    var one = vec3i(0);
    var other = vec3i(0);
    one[a] = 1;
    other[b] = 1;
    let left = is_open(before - one);
    let right = is_open(before + one);
    let below = is_open(before - other);
    let above = is_open(before + other);
    let c00 = corner(left, below, is_open(before - one - other));
    let c10 = corner(right, below, is_open(before + one - other));
    let c01 = corner(left, above, is_open(before - one + other));
    let c11 = corner(right, above, is_open(before + one + other));
    return mix(mix(c00, c10, within[a]), mix(c01, c11, within[a]), within[b]);
}

fn corner(side: f32, other: f32, between: f32) -> f32 {
    return 0.58 + 0.14 * (side + other + select(between, 0.0, side + other == 0.0));
}
