//! Tiles from end to end: `write_tile` of `intersect` and `cross_row` of `map`, run as they ship on numbers that were chosen to be near a
//! centre, against quotients of whole numbers.

use naga::Module;

use super::interpret::{Interpreter, Value, signed, unsigned};
use super::small::Small;
use super::{changed, kernel};
use crate::soups::Random;

/// A plane over a bin: heights `first + i * step[0] + j * step[1]` over the area, above cell `base`.
#[derive(Debug)]
struct Plane {
    area: i128,
    first: i128,
    steps: [i128; 2],
    base: i32,
    tie_is_above: bool,
}

const DEPTH: i128 = 1000;
/// A crossing's label: rank and direction.
const LABEL: u64 = 0x155;

/// A plane whose height at some ray of the bin is some 2^-32 of a cell beside a centre.
fn near_a_centre(random: &mut Random) -> Plane {
    let bits = 2 + random.below(51);
    let area = i128::from(random.below(1 << bits)) + 1;
    // area and steps have 54 bits
    let any_step = |random: &mut Random| {
        let most = 1 << random.below(15.min(54 - bits));
        area * (i128::from(random.below(2 * most)) - i128::from(most)) + i128::from(random.below(area as u64))
    };
    let steps = [any_step(random), any_step(random)];
    let ray = [random.below(8), random.below(8)].map(i128::from);
    let off = ((i128::from(random.below(41)) - 20) * area) >> 32;
    let near = i128::from(random.below(900)) * area + off + i128::from(random.below(3)) - 1;
    Plane {
        area,
        first: near - ray[0] * steps[0] - ray[1] * steps[1],
        steps,
        base: random.below(200) as i32 - 100,
        tie_is_above: random.below(2) == 1,
    }
}

/// A plane that is too steep for the numbers of a tile along one axis, and crosses the domain.
fn steep(random: &mut Random) -> Plane {
    let area = i128::from(random.below(1 << 30)) + 1;
    let steep = area * (16_000 + i128::from(random.below(200_000))) * if random.below(2) == 0 { 1 } else { -1 };
    let steps = if random.below(2) == 0 { [steep, 0] } else { [0, steep] };
    let ray = i128::from(random.below(8));
    Plane { area, first: 10 * area - ray * steep, steps, base: 0, tie_is_above: false }
}

/// What map makes of a row of a tile: whether it leaves the row, and the cell of each ray.
fn crossed<'a>(shaders: &[Interpreter<'a, Small<'a>>; 2], plane: &Plane, row: u64) -> Result<Vec<u64>, String> {
    let [intersect, map] = shaders;
    let domain = intersect.domain;
    let wide = |number: i128, n_words: u32| domain.limbs(number as u128, n_words);
    let word = |number: u64| unsigned(number);
    let tag = u64::from(plane.tie_is_above) << 9 | LABEL;
    let base = signed(u64::from(plane.base as u32));
    let slopes = plane.steps.map(|step| wide(step, 2));
    let [slope_i, slope_j] = slopes;
    let of_plane = Value::Many(vec![wide(plane.first, 3), base, slope_i, slope_j, word(tag)]);
    let all = Value::Many(vec![word(0xffff_ffff); 2]);
    let nothing = Value::Many(vec![word(0); 4]);
    let list = Value::Many(vec![Value::Many(vec![word(0xffff_ffff); 4]); 2]);
    let of_row = [Value::Many(vec![list; 8])].into_iter().chain(vec![word(0); 7]);
    let mut heap = vec![Value::Many(vec![nothing; 2]), Value::Many(of_row.collect())];
    intersect.call_on(&mut heap, "write_tile", vec![word(0), all, wide(plane.area, 2), of_plane]);
    map.call_on(&mut heap, "cross_row", vec![word(0), word(row), word(0xff), Value::Pointer(1, Vec::new())]);
    let parts = heap[1].parts();
    if *parts[4].word() != 0 {
        return Err("undecided".into());
    }
    let event_of = |list: &Value<Small<'a>>| *list.parts()[0].parts()[0].word();
    Ok(parts[0].parts().iter().map(event_of).collect())
}

/// The rows that were decided, and the first ray that is wrong, of planes.
fn check(module_of: [&Module; 2], planes: &[Plane]) -> Result<usize, String> {
    let exact = |value: f64, by: f64| value / by;
    let domain = &Small::guessing(&exact);
    let mut shaders = module_of.map(|module| Interpreter::new(module, domain));
    for shader in &mut shaders {
        shader.globals.insert("tiles", Value::Pointer(0, Vec::new()));
        // depth is the third of the parameters
        let params = (0..17).map(|at| unsigned(if at == 2 { DEPTH as u64 } else { 0 }));
        shader.globals.insert("params", Value::Many(params.collect()));
    }
    let mut n_decided = 0;
    for plane in planes {
        for row in [0, 3, 7] {
            let Ok(events) = crossed(&shaders, plane, row) else { continue };
            n_decided += 1;
            for (ray, event) in (0..).zip(events) {
                let height = plane.first + ray * plane.steps[0] + i128::from(row) * plane.steps[1];
                let is_at_centre = height.rem_euclid(plane.area) == 0 && plane.tie_is_above;
                let above = height.div_euclid(plane.area) + i128::from(plane.base) + i128::from(!is_at_centre);
                let expected = (above.clamp(0, DEPTH) as u64) << 9 | LABEL;
                if event != expected {
                    return Err(format!("{plane:?}: ray {ray} of row {row}: {event:x}, {expected:x}"));
                }
            }
        }
    }
    Ok(n_decided)
}

fn some(make: fn(&mut Random) -> Plane, n: usize) -> Vec<Plane> {
    let mut random = Random::new(32);
    (0..n).map(|_| make(&mut random)).collect()
}

#[test]
fn tiles_near_a_centre_are_decided_right_or_left() {
    let planes = some(near_a_centre, 400);
    let found = check([&kernel("intersect"), &kernel("map")], &planes).unwrap();
    assert!(found > 900 && found < 1200, "{found} of 1200 rows are decided");
}

#[test]
fn tiles_that_are_too_steep_are_left() {
    assert_eq!(check([&kernel("intersect"), &kernel("map")], &some(steep, 40)), Ok(0));
}

#[test]
fn a_margin_that_is_too_small_and_numbers_that_are_too_large_are_found() {
    let (intersect, map) = (kernel("intersect"), kernel("map"));
    let planes = some(near_a_centre, 400);
    for (from, to) in [
        ("select(16u + (plane.tag >> 9u), 0u, is_exact)", "select(12u + (plane.tag >> 9u), 0u, is_exact)"),
        ("select(16u + (plane.tag >> 9u), 0u, is_exact)", "select(16u, 0u, is_exact)"),
        ("height.is_exact && step_i.is_exact && step_j.is_exact", "height.is_exact"),
    ] {
        assert!(check([&changed("intersect", &[[from, to]]), &map], &planes).is_err(), "{to}");
    }
    let flat = changed("intersect", &[["16000.0", "1000000.0"]]);
    assert!(check([&flat, &map], &some(steep, 40)).is_err());
    let unsigned_step = ["bitcast<u32>(bitcast<i32>(steps.x << 16u) >> 16u)", "steps.x & 0xffffu"];
    assert!(check([&intersect, &changed("map", &[unsigned_step])], &planes).is_err());
}
