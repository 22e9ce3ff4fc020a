//! Pictures: every pixel of a slice has the colour of its cell, every pixel of a view that of the first cell behind it, and the commands.

use hexcast::control::Control;
use hexcast::job::Job;
use hexcast::mesh::Mesh;
use hexcast::picture::{Cut, Look, Picture, Place, Slices, View, slices, view};
use hexcast::pipeline::Engine;

use super::cli::{Folder, SPOT, done, hexcast};
use super::models;
use super::open_surfaces::meshed;
use super::strangers::fails;

/// Three bodies of different sizes along each axis, none where another is mirrored.
fn bodies() -> Mesh {
    let parts = [
        models::cuboid([0.0; 3], [3.0, 2.0, 1.0]),
        models::cuboid([3.0, 0.0, 0.0], [5.0, 1.0, 4.0]),
        models::cuboid([0.0, 3.0, 1.0], [1.0, 4.0, 3.0]),
    ];
    let job = set!(Job { dims: Some([10, 8, 8]), domain: Some([0.0, 0.0, 0.0, 5.0, 4.0, 4.0]), ..Job::default() });
    meshed(&parts, &job, 1, &mut Engine::cpu()).expect("a mesh").0
}

/// A picture of some planes.
fn planes(mesh: &Mesh, cuts: &[Cut], size: u32) -> hexcast::Result<Picture> {
    slices(mesh, &Slices::new(cuts.to_vec()).with_look(Look::default().with_size(size)), &Control::default())
}

/// The colour that slices have for each flag, from the legend of all.
fn colours(mesh: &Mesh) -> Vec<[u8; 3]> {
    let cell_of = |flag: u8| {
        let [nx, ny, nz] = mesh.dims();
        let mut cells = (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])));
        cells.find(|&cell| mesh.flag(cell).unwrap() == flag).expect("every flag has cells")
    };
    (0..4)
        .map(|flag| {
            let [x, y, z] = cell_of(flag);
            let picture = planes(mesh, &[Cut { axis: 2, index: z }], 400).unwrap();
            pixel_of(&picture, [x, y], 8)
        })
        .collect()
}

/// The middle of a cell in a picture of one slice with 40 pixels a cell, under 12 + 20 pixels.
fn pixel_of(picture: &Picture, [i, j]: [u32; 2], n_up: u32) -> [u8; 3] {
    picture.pixel(12 + 40 * i + 20, 12 + 20 + 40 * (n_up - 1 - j) + 20)
}

#[test]
fn every_pixel_of_a_slice_has_the_colour_of_its_cell() {
    let mesh = bodies();
    let colours = colours(&mesh);
    assert!((0..4).all(|one| (0..one).all(|other| colours[one] != colours[other])), "{colours:?}");
    for axis in 0..3 {
        let across = [[1, 2], [0, 2], [0, 1]][axis];
        let [n_right, n_up] = across.map(|axis| mesh.dims()[axis]);
        for index in 0..mesh.dims()[axis] {
            let picture = planes(&mesh, &[Cut { axis, index }], 400).unwrap();
            for (i, j) in (0..n_right).flat_map(|i| (0..n_up).map(move |j| (i, j))) {
                let mut cell = [index; 3];
                (cell[across[0]], cell[across[1]]) = (i, j);
                let flag = usize::from(mesh.flag(cell).unwrap());
                assert_eq!(pixel_of(&picture, [i, j], n_up), colours[flag], "cell {cell:?} of axis {axis}");
            }
        }
    }
}

#[test]
fn slices_are_where_they_are_asked_for_and_nowhere_else() {
    let mesh = bodies();
    let at = |axis, at| Cut::at(&mesh, axis, Place::Coordinate(at));
    assert_eq!(at(0, 1.3).unwrap(), Cut { axis: 0, index: 2 });
    assert_eq!(at(0, 1.5).unwrap(), Cut { axis: 0, index: 3 }, "a line belongs to the cell above");
    assert_eq!(at(0, 5.0).unwrap(), Cut { axis: 0, index: 9 });
    for (axis, place) in [(0, 5.01), (1, -0.1), (3, 0.0), (2, f64::NAN)] {
        assert_eq!(at(axis, place).unwrap_err().code(), "job-value");
    }
    let cut = |axis, index| Cut { axis, index };
    assert_eq!(Slices::at(&mesh, &[], &[]).unwrap().cuts, [cut(0, 5), cut(1, 4), cut(2, 4)]);
    let places = ["0%", "100%", "2.6"].map(|text| text.parse::<Place>().unwrap());
    assert_eq!(Slices::at(&mesh, &[1], &places).unwrap().cuts, [cut(1, 0), cut(1, 7), cut(1, 5)]);
    for wrong in ["101%", "-1%", "1e400", "middle", ""] {
        assert_eq!(wrong.parse::<Place>().unwrap_err().code(), "job-value", "{wrong}");
    }
    assert_eq!(planes(&mesh, &[], 100).unwrap_err().code(), "job-value");
    assert_eq!(planes(&mesh, &[Cut { axis: 1, index: 8 }], 100).unwrap_err().code(), "job-value");
    for size in [0, 40_000, u32::MAX] {
        assert_eq!(planes(&mesh, &[Cut { axis: 1, index: 0 }], size).unwrap_err().code(), "job-value");
        let wanted = View::default().with_look(Look::default().with_size(size));
        assert_eq!(view(&mesh, &wanted, &Control::default()).unwrap_err().code(), "job-value");
    }
}

#[test]
fn pictures_keep_to_the_memory_that_is_allowed_and_can_be_cancelled() {
    let mesh = bodies();
    let stopped = Control::default();
    stopped.cancel.cancel();
    let all = Slices::at(&mesh, &[], &[]).unwrap();
    assert_eq!(slices(&mesh, &all, &stopped).unwrap_err(), hexcast::Error::Cancelled);
    assert_eq!(view(&mesh, &View::default(), &stopped).unwrap_err(), hexcast::Error::Cancelled);
    for (n_bytes, fits) in [(0, false), (100_000, false), (20_000_000, true)] {
        let look = Look::default().with_max_bytes(n_bytes);
        let of_slices = slices(&mesh, &all.clone().with_look(look.clone()), &Control::default());
        let of_view = view(&mesh, &View::default().with_look(look), &Control::default());
        for made in [of_slices, of_view] {
            assert_eq!(made.as_ref().map_err(hexcast::Error::code).err(), (!fits).then_some("memory"), "{made:?}");
        }
    }
}

#[test]
fn flags_that_are_not_shown_are_white_and_colours_are_those_asked_for() {
    let mesh = bodies();
    let own = colours(&mesh);
    let plane = Slices::new(vec![Cut { axis: 2, index: 1 }]);
    let look = Look::default().with_size(400).with_flags(vec![0, 2]).with_colour(2, [1, 2, 3]);
    let picture = slices(&mesh, &plane.with_look(look), &Control::default()).unwrap();
    let mut seen = [0; 4];
    for (i, j) in (0..10).flat_map(|i| (0..8).map(move |j| (i, j))) {
        let flag = usize::from(mesh.flag([i, j, 1]).unwrap());
        assert_eq!(pixel_of(&picture, [i, j], 8), [own[0], [255; 3], [1, 2, 3], [255; 3]][flag]);
        seen[flag] += 1;
    }
    assert!(seen[0] > 0 && seen[1] > 0 && seen[2] > 0, "{seen:?}");
    // a line within a cell's pixels: none is drawn where none is asked for
    let at = [12 + 40, 12 + 20 + 20];
    let drawn = |has_lines| {
        let plane = Slices::new(vec![Cut { axis: 2, index: 1 }]).with_lines(has_lines);
        slices(&mesh, &plane.with_look(Look::default().with_size(400)), &Control::default())
            .unwrap()
            .pixel(at[0], at[1])
    };
    assert!(own.contains(&drawn(false)) && !own.contains(&drawn(true)));
    let nothing = View::default().with_look(Look::default().with_flags(vec![9]));
    let error = view(&mesh, &nothing, &Control::default()).unwrap_err();
    assert!(error.code() == "job-value" && error.to_string().contains("flags [9]"), "{error}");
}

/// Which of the colours of flags, made darker, a pixel has; 0 where it is white.
fn flag_of(pixel: [u8; 3], colours: &[[u8; 3]]) -> usize {
    let away = |colour: &[u8; 3]| {
        let bright =
            pixel.iter().map(|&c| f64::from(c)).sum::<f64>() / colour.iter().map(|&c| f64::from(c)).sum::<f64>();
        (0..3).map(|k| (f64::from(pixel[k]) - bright * f64::from(colour[k])).abs()).sum::<f64>()
    };
    if pixel == [255; 3] {
        return 0;
    }
    (1..colours.len()).min_by(|&one, &other| away(&colours[one]).total_cmp(&away(&colours[other]))).unwrap()
}

/// A line from the eye through each of some pixels meets the cells, in small steps.
#[test]
fn every_pixel_of_a_view_shows_the_first_cell_behind_it() {
    let mesh = bodies();
    let colours = colours(&mesh);
    for from in [[-60.0, 25.0], [20.0, 40.0], [135.0, -30.0], [250.0, 5.0]] {
        let mut wanted = View::default();
        (wanted.direction, wanted.look) = (from, Look::default().with_size(500));
        let picture = view(&mesh, &wanted, &Control::default()).unwrap();
        let (s, c) = libm::sincos(f64::to_radians(from[0]));
        let (t, d) = libm::sincos(f64::to_radians(from[1]));
        let [right, up, near] = [[-s, c, 0.0], [-t * c, -t * s, d], [d * c, d * s, t]];
        let dot = |a: [f64; 3], b: [f64; 3]| (0..3).map(|k| a[k] * b[k]).sum::<f64>();
        // the corners of flagged cells bound the picture
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        let [nx, ny, nz] = mesh.dims();
        for cell in (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z]))) {
            for corner in (0..8u32).filter(|_| mesh.flag(cell).unwrap() != 0) {
                let at = [0, 1, 2].map(|k| 0.5 * f64::from(cell[k] + (corner >> k & 1)));
                for (k, axis) in [right, up].into_iter().enumerate() {
                    low[k] = low[k].min(dot(at, axis));
                    high[k] = high[k].max(dot(at, axis));
                }
            }
        }
        let pixels = 500.0 / (high[0] - low[0]).max(high[1] - low[1]);
        let (mut n_wrong, mut seen) = (0, [0; 4]);
        for (x, y) in (0..50).flat_map(|x| (0..50).map(move |y| (10 * x + 5, 10 * y + 5))) {
            let [a, b] = [low[0] + (f64::from(x) + 0.5) / pixels, high[1] - (f64::from(y) + 0.5) / pixels];
            if a >= high[0] || b <= low[1] {
                continue;
            }
            let first = (0..4000).find_map(|step| {
                let depth = 8.0 - 0.004 * f64::from(step);
                let at = [0, 1, 2].map(|k| a * right[k] + b * up[k] + depth * near[k]);
                let is_inside = (0..3).all(|k| at[k] >= 0.0 && at[k] < 0.5 * f64::from(mesh.dims()[k]));
                let flag = if is_inside { mesh.flag(at.map(|c| (2.0 * c) as u32)).unwrap() } else { 0 };
                (flag != 0).then_some(usize::from(flag))
            });
            let expected = first.unwrap_or(0);
            seen[expected] += 1;
            n_wrong += usize::from(flag_of(picture.pixel(12 + x, 12 + y), &colours) != expected);
        }
        let n: usize = seen.iter().sum();
        // pixels at the edges of bodies are mixed
        assert!(n_wrong * 50 <= n, "from {from:?}: {n_wrong} of {n} pixels");
        assert!(seen.iter().filter(|&&n| n > 20).count() >= 3, "from {from:?}: {seen:?}");
    }
}

#[test]
fn commands_draw_what_is_asked_for() {
    let folder = Folder::new();
    let mesh = folder.path("mesh.hxc");
    done(&["mesh", SPOT, "--cells", "20", "--backend", "cpu", "-q", "-o", &mesh]);
    for command in ["slice", "view"] {
        let picture = folder.path(&format!("{command}.png"));
        let text = done(&[command, &mesh, "-o", &picture]);
        assert!(text.contains("pixels"), "{text}");
        let decoder = png::Decoder::new(std::io::Cursor::new(folder.bytes(&format!("{command}.png"))));
        let mut reader = decoder.read_info().expect("a PNG");
        let mut pixels = vec![0; reader.output_buffer_size().expect("a size")];
        let info = reader.next_frame(&mut pixels).expect("pixels");
        assert!(info.width > 300 && info.height > 300, "{command}: {} x {}", info.width, info.height);
        assert!(text.contains(&format!("{} x {} pixels", info.width, info.height)), "{text}");
    }
    let other = folder.path("other.txt");
    assert!(fails(&["slice", &mesh, "-o", &other], 4).contains("pictures are written to .png only"));
    assert!(fails(&["slice", &mesh, "--at", "9", "-o", &folder.path("a.png")], 4).contains("is not within the mesh"));
    assert!(fails(&["slice", &mesh, "--at", "101%", "-o", &folder.path("a.png")], 2).contains("0% to 100%"));
    for wrong in ["1", "1=red", "256=ff0000", "1=+f0000", "1=ff00000"] {
        let said = fails(&["view", &mesh, "--colours", wrong, "-o", &folder.path("a.png")], 2);
        assert!(said.contains("six hexadecimal digits"), "{wrong}: {said}");
    }
}

#[test]
fn pictures_reach_over_a_halo_beyond_the_box_and_places_are_numbers() {
    let folder = Folder::new();
    let [mesh, drawn, alone] = ["mesh.hxc", "drawn.png", "alone.png"].map(|name| folder.path(name));
    let window = ["--domain", "0,0,0,8,8,8", "--cells", "8", "--window", "0,0,0,4,4,4", "--halo", "2", "-q"];
    let asked = format!("{drawn}:axis=x,at=-0.5");
    done(&[&["mesh", SPOT, "--backend", "cpu", "-o", &mesh, "--slice", &asked], &window[..]].concat());
    done(&["slice", &mesh, "--axis=x", "--at=-0.5", "-o", &alone, "-q"]);
    assert!(folder.bytes("drawn.png") == folder.bytes("alone.png"));

    let job = folder.path("job.toml");
    let spot = std::path::absolute(SPOT).expect("a path");
    let text =
        format!("cells = 8\nslice = {{ at = nan, output = \"a.png\" }}\n[[geometries]]\nfile = '{}'\n", spot.display());
    std::fs::write(&job, text).expect("written");
    let output = hexcast(&["mesh", "--job", &job, "--backend", "cpu"]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(4) && said.contains("a coordinate, or a text such as"), "{said}");
}

#[test]
fn pictures_of_a_job_are_those_of_the_commands() {
    let folder = Folder::new();
    let spot = std::path::absolute(SPOT).expect("a path");
    let text = format!(
        "output = \"mesh.hxc\"\ncells = 24\nbackend = \"cpu\"\nquiet = true\nunit = \"mm\"\n\
         slice = [{{ axis = [\"z\", \"x\"], at = [\"25%\", 0.1], size = 90, flags = [0, 3], colours = {{ 3 = \"#d98324\" }}, \
         lines = false, output = \"slice.png\" }}, {{ output = \"all.png\" }}]\n\
         view = {{ direction = [30, -20], size = 150, window = [0, 3, 2, 9, 20, 21], output = \"view.png\" }}\n\
         [[geometries]]\nfile = '{}'\nflag = 3\nname = \"cow\"\n",
        spot.display()
    );
    let job = folder.path("job.toml");
    std::fs::write(&job, text).expect("written");
    assert_eq!(done(&["mesh", "--job", &job]), "");
    assert_eq!(folder.names(), ["all.png", "job.toml", "mesh.hxc", "slice.png", "view.png"]);
    let mesh = folder.path("mesh.hxc");
    let commands: [(&str, &[&str]); 3] = [
        (
            "slice.png",
            &["slice", "--axis=z,x", "--at=25%,0.1", "--size=90", "--flags=0,3", "--colours=3=d98324", "--no-lines"],
        ),
        ("all.png", &["slice"]),
        ("view.png", &["view", "--direction=30,-20", "--size=150", "--window=0,3,2,9,20,21"]),
    ];
    let alone = folder.path("alone.png");
    for (name, words) in commands {
        done(&[words, &[&mesh, "-o", &alone, "-q"]].concat());
        assert!(folder.bytes(name) == folder.bytes("alone.png"), "{name}");
    }
    // the same as options, and of a job in which these are written down
    let [dumped, slice, view] = ["job.json", "s.png", "v.png"].map(|name| folder.path(name));
    let file = format!("{SPOT}:flag=3,name=cow");
    let slice_of = format!("{slice}:axis=z/x,at=25%/0.1,size=90,flags=0/3,colours=3=d98324,lines=false");
    let view_of = format!("{view}:direction=30/-20,size=150,window=0/3/2/9/20/21");
    let options =
        ["mesh", &file, "--cells=24", "--unit=mm", "--backend=cpu", "-q", "--slice", &slice_of, "--view", &view_of];
    for arguments in [&options[..], &["mesh", "--job", &dumped]] {
        if arguments.len() == 3 {
            done(&[&options[..], &["--dump-job", &dumped]].concat());
        }
        done(arguments);
        assert!(folder.bytes("s.png") == folder.bytes("slice.png"), "{arguments:?}");
        assert!(folder.bytes("v.png") == folder.bytes("view.png"), "{arguments:?}");
        [&slice, &view].iter().for_each(|path| std::fs::remove_file(path).expect("it was drawn"));
    }
}

#[test]
fn pictures_that_cannot_be_drawn_are_refused_before_the_mesh() {
    let folder = Folder::new();
    let [hxc, png] = ["a.hxc", "a.png"].map(|name| folder.path(name));
    let mesh = ["mesh", SPOT, "--cells", "12", "--backend", "cpu", "-q", "-o", &hxc];
    let cases = [
        ("--slice", "at=9", 4, "a.png: 9 is not within the mesh, which reaches from"),
        ("--slice", "axis=w", 4, "a.png: axis: \"w\" is not an axis: x, y or z is needed"),
        ("--slice", "at=110%", 4, "0% to 100%"),
        ("--slice", "size=0", 4, "a side has 1 to 32768"),
        ("--slice", "size=20000", 4, "a side has 1 to 32768"),
        ("--slice", "colours=1=red", 4, "\"1=red\" is not a flag from 0 to 255 and a colour"),
        ("--slice", "scale=3", 2, "there is no key \"scale\"; keys are axis, at, lines"),
        (
            "--view",
            "window=0/0/0/99/9/9",
            4,
            "the box from cell 0,0,0 to 99,9,9 is not inside the mesh of 7 x 12 x 12 cells",
        ),
        ("--view", "direction=nan/0", 4, "give two finite angles"),
        ("--view", "direction=30", 2, "2 numbers joined by / are needed, as in 30/20"),
    ];
    for (option, setting, code, says) in cases {
        let said = fails(&[&mesh[..], &[option, &format!("{png}:{setting}")]].concat(), code);
        assert!(said.contains(says), "{option} {setting}: {said}");
        assert!(folder.names().is_empty(), "{option} {setting}: {:?}", folder.names());
    }
    for (given, says) in
        [(&folder.path("a.jpg"), "pictures are written to .png only"), (&String::new(), "without the name of its file")]
    {
        let said = fails(&[&mesh[..], &["--view", given]].concat(), 4);
        assert!(said.contains(says) && folder.names().is_empty(), "{said}");
    }
    let said = fails(&[&mesh[..], &["--view", &png, "--slice", &png]].concat(), 4);
    assert!(said.contains("is written twice") && folder.names().is_empty(), "{said}");
    // what only the mesh shows costs the picture alone
    let output =
        hexcast(&[&mesh[..], &["--view", &format!("{png}:flags=7"), "--slice", &folder.path("b.png")]].concat());
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(
        output.status.success() && said.contains("a.png is not written: no cell has one of the flags [7]"),
        "{said}"
    );
    assert_eq!(folder.names(), ["a.hxc", "b.png"]);
    let strict = hexcast(&[&mesh[..], &["--view", &format!("{png}:flags=7"), "--strict"]].concat());
    assert_eq!(strict.status.code(), Some(8));
}

#[test]
fn cells_that_differ_are_counted_and_masked_by_the_command() {
    let folder = Folder::new();
    let [one, other, mask] = ["one.hxc", "other.hxc", "mask.raw"].map(|name| folder.path(name));
    let size = ["--dims", "20,21,22", "--domain=-1,-1,-1,1,1,1.2", "--backend", "cpu", "-q"];
    done(&[&["mesh", &format!("{SPOT}:name=cow"), "-o", &one, "--axis", "x"], &size[..]].concat());
    done(&[&["mesh", &format!("{SPOT}:translate=0.1/0/0,flag=3"), "-o", &other, "--axis", "z"], &size[..]].concat());
    let output = hexcast(&["diff", &one, &other, "-o", &mask]);
    assert_eq!(output.status.code(), Some(1));
    let text = String::from_utf8(output.stdout).expect("UTF-8");
    assert!(text.contains("1 \"cow\" -> 0 background") && text.contains("1 \"cow\" -> 3 \"spot\""), "{text}");
    let n = folder.bytes("mask.raw").iter().filter(|cell| **cell == 1).count();
    assert!(text.contains(&format!("{n} of 9,240 cells")) && n > 100, "{n}: {text}");
    assert!(done(&["diff", &one, &one]).contains("all 9,240 cells have the same flags"));
    let json: serde_json::Value = serde_json::from_str(&done(&["diff", &one, &one, "--json"])).unwrap();
    assert_eq!((&json["cells"], &json["are_lines_equal"]), (&0.into(), &true.into()));
}
