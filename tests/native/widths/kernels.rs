//! Ranges of all numbers with a sign on the way from snapped corners to hits and tiles: none wraps around, and q changes by less than
//! 2^30 within a bin.
//!
//! Corners and rays are anywhere within [`hull`], as the frame says; nothing else is known of them.

use std::cell::RefCell;

use hexcast_core::grid::frame::{MAX_CELLS_PER_AXIS, MIN_FRACTION_BITS, SPAN_BITS};
use naga::{Module, TypeInner};

use super::interpret::{Interpreter, Value, signed, unsigned};
use super::ranges::{Range, Ranges, is_within};
use super::{changed, kernel};

type Number<'a> = Value<Ranges<'a>>;

/// Units that corners and centres span: one cell to spare beyond both ends is part of the 2^26 units; both ends are rounded by half a
/// unit at most.
pub(super) fn hull(span_bits: u32, fraction_bits: u32) -> i128 {
    (1 << span_bits) - (2 << fraction_bits) + 1
}

pub(super) struct Prover<'a> {
    pub(super) shader: Interpreter<'a, Ranges<'a>>,
    fraction_bits: u32,
    /// Units of corners and rays.
    pub(super) places: Range,
}

impl<'a> Prover<'a> {
    fn new(module: &'a Module, domain: &'a Ranges<'a>, fraction_bits: u32, axis: u32, places: Range) -> Prover<'a> {
        let mut shader = Interpreter::new(module, domain);
        let TypeInner::Struct { members, .. } =
            &module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some("Params")).expect("Params").1.inner
        else {
            panic!("Params is no struct")
        };
        let most = i128::from(MAX_CELLS_PER_AXIS);
        let params = members.iter().map(|member| match member.name.as_deref().expect("members have names") {
            "fraction_bits" => unsigned((fraction_bits.into(), fraction_bits.into())),
            "axis" => unsigned((axis.into(), axis.into())),
            "depth" | "n_i" | "first_row" | "end_row" | "n_across" => unsigned((0, most)),
            _ => unsigned((0, u32::MAX.into())),
        });
        shader.globals.insert("params", Value::Many(params.collect()));
        let corner = Value::Many(vec![signed(places); 4]);
        shader.globals.insert("corners", Value::Every(Box::new(corner)));
        Prover { shader, fraction_bits, places }
    }

    pub(super) fn facet(&self) -> Number<'a> {
        // three times its number
        self.shader.call("load_facet", vec![unsigned((0, (1 << 30) - 1))])
    }

    /// The first ray of a bin: one of the domain.
    fn ray(&self) -> Number<'a> {
        let cells = (self.places.0 >> self.fraction_bits, self.places.1 >> self.fraction_bits);
        Value::Many(vec![signed((cells.0.max(0), cells.1.max(0))); 2])
    }
}

/// A part of a struct, by its name.
pub(super) fn part<'v, 'a>(module: &Module, kind: &str, value: &'v Number<'a>, name: &str) -> &'v Number<'a> {
    let (_, ty) = module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some(kind)).expect("a struct");
    let TypeInner::Struct { members, .. } = &ty.inner else { panic!("{kind} is no struct") };
    let at = members.iter().position(|member| member.name.as_deref() == Some(name)).expect("a part");
    &value.parts()[at]
}

/// The part of the rays' axis where the frame begins: at cell 0, or as far before it as the span allows.
pub(super) fn on_all_frames(module: &Module, span_bits: u32, check: impl Fn(&Prover, &Module)) -> Vec<String> {
    let faults = RefCell::new(Vec::new());
    let domain = Ranges::new(&faults);
    for fraction_bits in MIN_FRACTION_BITS..SPAN_BITS {
        let hull = hull(span_bits, fraction_bits);
        for places in [(0, hull), (-hull, 0), (-hull / 2, hull / 2)] {
            for axis in 0..3 {
                check(&Prover::new(module, &domain, fraction_bits, axis, places), module);
            }
        }
    }
    let mut faults = faults.into_inner();
    faults.dedup();
    faults
}

/// Whether a facet hits the rays of a bin: the walk.
fn check_hits(prover: &Prover, module: &Module) {
    let f = prover.facet();
    let number = |name: &str| part(module, "Facet", &f, name).clone();
    let [a, b] = ["edge_a", "edge_b"].map(|name| prover.shader.call(name, vec![f.clone()]));
    let [a0, b0] = [&a, &b].map(|steps| steps.parts()[0].clone());
    let [x, y] = ["x", "y"].map(|name| number(name).parts()[0].clone());
    let q = prover.shader.call("edge_q", vec![a0, b0, x, y, prover.ray()]);
    let TypeInner::Struct { members, .. } =
        &module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some("Walk")).expect("Walk").1.inner
    else {
        panic!("Walk is no struct")
    };
    // what start_walk makes of them
    let most = |steps: &Number| (0, steps.parts()[0].word().1.max(0));
    let reach = [most(&a), most(&b)].map(|(_, most)| 7 * most).iter().sum::<i128>();
    let walk = members.iter().map(|member| match member.name.as_deref().expect("members have names") {
        "a" => a.clone(),
        "b" => b.clone(),
        "reach" => Value::Many(vec![signed((0, reach)); 3]),
        "q0" | "q1" | "q2" => q.clone(),
        "row" => unsigned((0, u32::MAX.into())),
        _ => signed((0, i128::from(MAX_CELLS_PER_AXIS) / 8)),
    });
    let mut heap = vec![Value::Many(walk.collect())];
    prover.shader.call_on(&mut heap, "next_hits", vec![Value::Pointer(0, Vec::new())]);
}

/// The plane of a facet.
fn check_plane(prover: &Prover, _module: &Module) {
    prover.shader.call("plane_of", vec![prover.facet(), prover.ray()]);
}

/// Bits of a number with a sign.
fn width(range: &Range) -> u32 {
    129 - range.0.unsigned_abs().max(range.1.unsigned_abs()).leading_zeros()
}

#[test]
fn no_number_of_the_walk_wraps_around() {
    assert_eq!(on_all_frames(&kernel("lattice"), SPAN_BITS, check_hits), Vec::<String>::new());
}

#[test]
fn no_number_of_a_plane_wraps_around() {
    assert_eq!(on_all_frames(&kernel("intersect"), SPAN_BITS, check_plane), Vec::<String>::new());
}

#[test]
fn a_span_of_27_bits_or_larger_bins_do_not_fit_the_walk() {
    let faults = on_all_frames(&kernel("lattice"), SPAN_BITS + 1, check_hits);
    assert!(faults.iter().any(|fault| fault.contains("in 32 bits")), "{faults:?}");
    let wider = changed("lattice", &[["const BIN: u32 = 8u;", "const BIN: u32 = 16u;"]]);
    assert!(!on_all_frames(&wider, SPAN_BITS, check_hits).is_empty());
}

#[test]
fn a_span_of_31_bits_does_not_fit_the_plane() {
    let faults = on_all_frames(&kernel("intersect"), 31, check_plane);
    assert!(faults.iter().any(|fault| fault.contains("in 96 bits")), "{faults:?}");
}

/// What `facet.rs` says: area and slopes 54 bits, the numerator of the height 82.
#[test]
fn area_slopes_and_height_have_the_widths_that_facet_rs_says() {
    let is_so = |prover: &Prover, module: &Module| {
        let f = prover.facet();
        let plane = prover.shader.call("plane_of", vec![f.clone(), prover.ray()]);
        let of_plane = |name: &str| width(part(module, "Plane", &plane, name).word());
        let area = width(part(module, "Facet", &f, "area").word());
        let found = [area, of_plane("slope_i"), of_plane("slope_j"), of_plane("height") + prover.fraction_bits];
        assert!(found.iter().zip([54, 54, 54, 82]).all(|(found, said)| *found <= said), "{found:?}");
    };
    assert_eq!(on_all_frames(&kernel("intersect"), SPAN_BITS, is_so), Vec::<String>::new());
}

/// q is clamped to +-2^30 at the first ray of a bin. All of its rays are within 7 steps of both kinds.
#[test]
fn a_bin_changes_q_by_less_than_2_30() {
    let changes = |span_bits: u32, bin: i128| 2 * (bin - 1) * hull(span_bits, MIN_FRACTION_BITS);
    assert!(is_within((0, changes(SPAN_BITS, hexcast_core::stages::cast::BIN.into())), (0, (1 << 30) - 1)));
    assert!(!is_within((0, changes(SPAN_BITS, 16)), (0, (1 << 30) - 1)));
    assert!(!is_within((0, changes(SPAN_BITS + 1, 8)), (0, (1 << 30) - 1)));
}
