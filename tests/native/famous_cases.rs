//! Cases that broke other meshers, each with the report it comes from (project#number on GitHub). The facts are theirs, the
//! expected cells ours: counted by hand or by a formula, never by the code under test.

use hexcast::columns;
use hexcast::geometry::{Facet, Geometry, Placing};
use hexcast_core::stages::map::Rule;

use super::backends::{Backend, cpu_flags, flags, mesh};
use super::cases::{Case, lines, one, several, unit_cells};
use super::compare::assert_same;
use super::models::{self, Facets, cube, cuboid, flipped, joined, sphere, tetrahedron};
use super::soups::{self, Random};

fn with_rule(case: Case, rule: Rule) -> Case {
    Case { rule, ..case }
}

fn n_inside(flags: &[u8]) -> usize {
    flags.iter().filter(|&&flag| flag != 0).count()
}

/// Flags from a formula of the cell.
fn expected(dims: [u32; 3], flag: impl Fn([u32; 3]) -> u8) -> Vec<u8> {
    let [nx, ny, nz] = dims;
    let mut flags = Vec::new();
    for z in 0..nz {
        for y in 0..ny {
            flags.extend((0..nx).map(|x| flag([x, y, z])));
        }
    }
    flags
}

/// Meshes along all three axes, checks every cell against a formula and that no ray is odd.
#[track_caller]
fn check(case: &Case, flag: impl Fn([u32; 3]) -> u8) {
    let expected = expected(case.lines.dims(), flag);
    for axis in 0..3 {
        let columns = mesh(Backend::Cpu, case, axis);
        assert_same(&format!("{}, axis {axis}", case.name), &expected, &flags(&columns), case.lines.dims());
        assert_eq!(columns.odd_rays(), 0, "{}, axis {axis}", case.name);
    }
}

/// Checks that a case fills its domain.
#[track_caller]
fn check_full(case: &Case) {
    check(case, |_| 1);
}

/// Whether a cell lies within first ..= last on every axis.
fn within(cell: [u32; 3], first: u32, last: u32) -> bool {
    cell.iter().all(|index| (first..=last).contains(index))
}

/// Forceflow/cuda_voxelizer#64: a cube on a grid of 8 came out as 8 x 8 x 7.
#[test]
fn a_unit_cube_on_8_cells_has_512() {
    check_full(&one("unit cube", "", lines([0.0; 3], [0.125; 3], [8; 3]), cube([0.0; 3], 1.0)));
}

/// Forceflow/cuda_voxelizer#64, first report: grids of 32, 64 and 100 worked, 50 did not.
#[test]
fn a_cube_fills_grids_of_32_50_64_and_100() {
    for n in [32u32, 50, 64, 100] {
        let cells = lines([-1.0; 3], [2.0 / f64::from(n); 3], [n; 3]);
        check_full(&one(&format!("cube on {n}"), "", cells, cube([-1.0; 3], 2.0)));
    }
}

/// cpederkoff/stl-to-voxel#51: a cube at resolution 10 came out with holes on its boundary.
#[test]
fn a_cube_on_10_cells_is_full_wherever_it_stands() {
    for (low, size) in [(0.0f32, 1.0f32), (-1.0, 2.0), (0.1, 0.7), (-12.3, 45.6), (1000.1, 3.3), (-1e-3, 1e-3)] {
        let body = cube([low; 3], size);
        let high = low + size;
        let spacing = (f64::from(high) - f64::from(low)) / 10.0;
        let cells = lines([f64::from(low); 3], [spacing; 3], [10; 3]);
        check_full(&one(&format!("cube from {low} to {high}"), "", cells, body));
    }
}

/// Forceflow/cuda_voxelizer#61: this very cube (its vertices and faces) had glitches along the diagonals of its sides.
#[test]
fn a_cube_from_150_to_550_has_no_glitch_along_its_diagonals() {
    // the same f32 as the file's 150.100006, 550.099976, 400.100006 and 800.099976
    let (a, b, c, d) = (150.1f32, 550.1f32, 400.1f32, 800.1f32);
    let vertices = [[a, c, b], [b, c, b], [a, d, b], [b, d, b], [a, d, a], [b, d, a], [a, c, a], [b, c, a]];
    let faces = [
        [1, 2, 4],
        [1, 4, 3],
        [3, 4, 6],
        [3, 6, 5],
        [5, 6, 8],
        [5, 8, 7],
        [7, 8, 2],
        [7, 2, 1],
        [2, 8, 6],
        [2, 6, 4],
        [7, 1, 3],
        [7, 3, 5],
    ];
    let body: Vec<Facet> = faces.iter().map(|face| face.map(|vertex: usize| vertices[vertex - 1])).collect();
    // centres 155, 165, ... 545 along x and z, 405 ... 795 along y
    let inside = |[x, y, z]: [u32; 3]| (15..55).contains(&x) && (40..80).contains(&y) && (15..55).contains(&z);
    check(&one("in a domain", "", lines([0.0; 3], [10.0; 3], [60, 90, 60]), body.clone()), |cell| {
        u8::from(inside(cell))
    });
    let origin = [a, c, a].map(f64::from);
    let spacing = [(a, b), (c, d), (a, b)].map(|(low, high)| (f64::from(high) - f64::from(low)) / 64.0);
    check_full(&one("in its box", "", lines(origin, spacing, [64; 3]), body));
}

/// ProjectPhysX/FluidX3D#323: a terrain from a height map, its vertices on the rays, got vertical slices through it.
#[test]
fn a_terrain_with_vertices_on_rays_has_no_slices() {
    const N: usize = 40;
    let mut random = Random::new(323);
    // quarters that are not halves: no vertex on a centre's height, so the height of a ray is that of its vertex
    let heights: Vec<f32> = (0..(N + 1) * (N + 1)).map(|_| random.between(4, 15) as f32 + 0.25).collect();
    let body = models::terrain([N, N], 1.0, 0.25, |i, j| heights[j * (N + 1) + i]);
    // vertex (i, j) on the ray (i, j); centre k at height k + 1/2; columns at the low sides belong to the outside
    let cells = lines([-0.5, -0.5, 0.0], [1.0; 3], [N as u32 + 1, N as u32 + 1, 18]);
    check(&one("terrain", "", cells, body), |[x, y, z]| {
        let height = heights[y as usize * (N + 1) + x as usize];
        u8::from(x > 0 && y > 0 && z as f32 + 0.5 <= height)
    });
}

/// ProjectPhysX/FluidX3D#281: a model seen at a rotation of 30 degrees vanished at 0, 90 and 180.
#[test]
fn quarter_turns_turn_the_cells() {
    let dims = [12; 3];
    let body = joined([cuboid([-5.2, -3.3, -4.4], [4.1, 1.2, 3.6]), cuboid([1.3, 1.2, -0.7], [2.2, 5.1, 2.8])]);
    let cells = lines([-6.0; 3], [1.0; 3], dims);
    let turned = |degrees: [f64; 3]| {
        let place = Placing::new([1.0; 3], degrees, [0.0; 3]).unwrap();
        several(
            "turned",
            "",
            cells.clone(),
            vec![set!(Geometry { world_from_file: place, ..Geometry::new("body", 1, body.clone()).unwrap() })],
        )
    };
    let upright = cpu_flags(&turned([0.0; 3]), 0);
    // centres -4.5 to 3.5, -2.5 to 0.5, -3.5 to 3.5, and in the fin 1.5, 1.5 to 4.5, -0.5 to 2.5
    assert_eq!(n_inside(&upright), 9 * 4 * 8 + 4 * 4);
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let mut from = upright.clone();
        for quarter in 1..=4 {
            // a quarter turn takes (u, v) to (-v, u); the cell at (u, v) came from (v, 11 - u)
            from = expected(dims, |cell| {
                let mut source = cell;
                (source[u], source[v]) = (cell[v], 11 - cell[u]);
                from[(source[0] + 12 * (source[1] + 12 * source[2])) as usize]
            });
            let mut degrees = [0.0; 3];
            degrees[axis] = 90.0 * f64::from(quarter);
            check(&turned(degrees), |[x, y, z]| from[(x + 12 * (y + 12 * z)) as usize]);
        }
    }
}

/// AMReX-Codes/amrex#5789: absolute tolerances on lengths cubed, so that a part of 5 mm in metres fell to pieces.
#[test]
fn scales_from_a_millionth_to_a_thousand_give_the_same_cells() {
    let skew = [[0.3, 0.4, 0.2], [11.4, 1.3, 2.1], [2.6, 11.2, 1.4], [1.7, 3.1, 11.6]];
    let body = joined([tetrahedron(skew), sphere([8.13, 8.27, 8.41], 3.3, 24)]);
    let original = cpu_flags(&with_rule(one("scale 1", "", unit_cells([12; 3]), body.clone()), Rule::Nonzero), 0);
    assert!(n_inside(&original) > 300);
    for power in -6..=3 {
        let scale = libm::pow(10.0, f64::from(power));
        let scaled = models::mapped(&body, |corner| corner.map(|x| (f64::from(x) * scale) as f32));
        let case = one(&format!("scale 1e{power}"), "", lines([0.0; 3], [scale; 3], [12; 3]), scaled);
        check(&with_rule(case, Rule::Nonzero), |[x, y, z]| original[(x + 12 * (y + 12 * z)) as usize]);
    }
}

/// ProjectPhysX/FluidX3D#59: no artefacts at a resolution of 671, false geometry at 672.
#[test]
fn sizes_671_and_672_are_alike() {
    for n in [671u32, 672] {
        // a ball that fills the box's length, its silhouette between and on rays
        let radius = 0.5f32;
        let cells = lines([-0.5, -0.25, -0.5], [1.0 / f64::from(n); 3], [n, n / 2, n]);
        let columns = mesh(Backend::Cpu, &one(&format!("ball on {n}"), "", cells, sphere([0.0; 3], radius, 64)), 1);
        assert_eq!(columns.odd_rays(), 0, "{n}");
        let mut length = 0;
        for ray in 0..columns.rays().n_rays() {
            // a convex body has one run along any ray; streaks would be more, or longer than the ball is wide there
            let flags: Vec<u32> = columns.ray(ray).unwrap().iter().map(|run| run & 0xff).collect();
            assert!(matches!(flags[..], [] | [1] | [1, 0]), "{n}: ray {ray} has runs {flags:?}");
            length += u64::from(!flags.is_empty());
        }
        let disc = std::f64::consts::PI * 0.25 * f64::from(n) * f64::from(n);
        assert!((length as f64 / disc - 1.0).abs() < 0.01, "{n}: {length} rays meet the ball, its disc has {disc:.0}");
        // a ball cut by two planes at half its radius: pi (r^2 h - h^3 / 12), h = 1/2
        let volume = std::f64::consts::PI * (0.25 * 0.5 - 0.125 / 12.0) * f64::from(n).powi(3);
        let n_cells = columns.cells_per_flag()[1] as f64;
        assert!((n_cells / volume - 1.0).abs() < 0.01, "{n}: {n_cells} cells, {volume:.0} expected");
    }
}

/// thliebig/CSXCAD#59: conductors meshed right from a file each, wrong when joined in one file.
#[test]
fn two_touching_cubes_are_the_same_in_one_file_and_in_two() {
    // the common side on a line, on centres, and between
    for middle in [4.0f32, 4.5, 4.3] {
        let halves = [cuboid([1.5, 1.0, 1.2], [middle, 6.0, 6.5]), cuboid([middle, 1.0, 1.2], [7.5, 6.0, 6.5])];
        let cells = unit_cells([9, 8, 8]);
        // (low, high]: x centres 2.5 to 7.5, y 1.5 to 5.5, z 1.5 to 6.5
        let inside =
            |[x, y, z]: [u32; 3]| u8::from((2..=7).contains(&x) && (1..=5).contains(&y) && (1..=6).contains(&z));
        for rule in [Rule::Parity, Rule::Nonzero] {
            let files = halves.iter().map(|half| Geometry::new("half", 1, half.clone()).unwrap()).collect();
            check(&with_rule(several("two files", "", cells.clone(), files), rule), inside);
            check(&with_rule(one("one file", "", cells.clone(), halves.concat()), rule), inside);
        }
    }
}

/// Shells within shells: a hole under parity, one body under winding numbers, a hole again if turned inwards.
#[test]
fn nested_shells_follow_the_rule() {
    let cells = unit_cells([10; 3]);
    let [outer, inner] = [cube([1.0; 3], 8.0), cube([3.0; 3], 4.0)];
    let hole = |cell| u8::from(within(cell, 1, 8) && !within(cell, 3, 6));
    let solid = |cell| u8::from(within(cell, 1, 8));
    let same = || one("same way", "", cells.clone(), joined([outer.clone(), inner.clone()]));
    let opposite = || one("opposite ways", "", cells.clone(), joined([outer.clone(), flipped(inner.clone())]));
    check(&with_rule(same(), Rule::Parity), hole);
    check(&with_rule(same(), Rule::Nonzero), solid);
    check(&with_rule(opposite(), Rule::Parity), hole);
    check(&with_rule(opposite(), Rule::Nonzero), hole);
}

/// Overlapping shells of one file: the common part is a hole under parity and inside under winding numbers.
#[test]
fn overlapping_shells_follow_the_rule() {
    let cells = unit_cells([10; 3]);
    let body = joined([cube([1.0; 3], 5.0), cube([4.0; 3], 5.0)]);
    let (first, second) = (|cell| within(cell, 1, 5), |cell| within(cell, 4, 8));
    check(&one("parity", "", cells.clone(), body.clone()), |cell| u8::from(first(cell) != second(cell)));
    check(&with_rule(one("nonzero", "", cells, body), Rule::Nonzero), |cell| u8::from(first(cell) || second(cell)));
}

/// A body in the octant where all coordinates are negative: rounding towards zero would shift it by a cell.
#[test]
fn an_all_negative_body_is_the_positive_one_moved() {
    let body =
        joined([tetrahedron([[0.5; 3], [9.25, 1.0, 1.5], [1.5, 9.5, 0.75], [2.0, 2.5, 9.0]]), cube([5.5; 3], 3.5)]);
    let positive = cpu_flags(&one("positive", "", unit_cells([10; 3]), body.clone()), 0);
    assert!(n_inside(&positive) > 100);
    let moved = models::moved(&body, [-16.0; 3]);
    check(&one("negative", "", lines([-16.0; 3], [1.0; 3], [10; 3]), moved), |[x, y, z]| {
        positive[(x + 10 * (y + 10 * z)) as usize]
    });
}

/// Facets in any order, starting anywhere, turned any way: files from the wild.
#[test]
fn shuffled_and_flipped_facets_are_the_same_body() {
    let mut random = Random::new(59);
    for round in 0..8 {
        let mut body: Facets = soups::shuffled(joined([cube([1.5; 3], 4.0), cube([4.0; 3], 5.0)]), &mut random);
        for facet in body.iter_mut().filter(|_| random.below(2) == 0) {
            facet.swap(0, 2);
        }
        check(&one(&format!("round {round}"), "", unit_cells([10; 3]), body), |cell| {
            u8::from(within(cell, 2, 5) != within(cell, 4, 8))
        });
    }
}

/// A facet given twice opens the surface there: exactly its rays are odd, and no other ray is disturbed.
#[test]
fn a_facet_given_twice_is_seen_by_its_rays_only() {
    let body = cuboid([1.0; 3], [7.0, 7.0, 7.0]);
    let top: Vec<usize> = (0..12).filter(|&facet| body[facet].iter().all(|corner| corner[2] == 7.0)).collect();
    assert_eq!(top.len(), 2);
    let mut twice = body.clone();
    twice.push(body[top[0]]);
    for rule in [Rule::Parity, Rule::Nonzero] {
        let case = with_rule(one("twice", "", unit_cells([8; 3]), twice.clone()), rule);
        let whole = expected([8; 3], |cell| u8::from(within(cell, 1, 6)));
        // rays along x and y run beside the facet
        for axis in 0..2 {
            let columns = mesh(Backend::Cpu, &case, axis);
            assert_eq!(columns.odd_rays(), 0);
            assert_same("beside the facet", &whole, &flags(&columns), [8; 3]);
        }
        let columns = mesh(Backend::Cpu, &case, 2);
        // the facet is half of 6 x 6 rays; the diagonal's 6 go to one of the halves
        assert!([15, 21].contains(&columns.odd_rays()), "{} odd rays", columns.odd_rays());
        // an odd ray cannot tell where the body ends; the others keep their cells 1 to 6
        let kept = [columns::run(1, 1), columns::run(7, 0)];
        let n_kept = (0..64).filter(|&ray| *columns.ray(ray).unwrap() == kept).count() as u64;
        let n_empty = (0..64).filter(|&ray| columns.ray(ray).unwrap().is_empty()).count() as u64;
        assert_eq!([n_kept, n_empty], [36 - columns.odd_rays(), 28 + columns.odd_rays()]);
    }
    // three times is once again, for parity
    twice.push(body[top[0]]);
    check(&one("three times", "", unit_cells([8; 3]), twice), |cell| u8::from(within(cell, 1, 6)));
}
