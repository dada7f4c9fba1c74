//! Tests of scene files through the library and the command line: concave polygons, coordinates far from the origin.

use arboleda::{IndexKind, Options, Ray, Vec3};
use arboleda_host::TimedIndex;
use arboleda_host::scene::{self, Model, Origin};

mod program;

use program::{failure, folder, run_in, success, write_rays};

fn load(text: &str, name: &str) -> Model {
    let folder = folder();
    let path = folder.path().join(name);
    std::fs::write(&path, text).unwrap();
    scene::load(&path, Origin::Unchanged).unwrap()
}

/// Counts wrong hits and wrong misses of rays straight down, at points of a grid that lie on no edge.
fn wrong_hits(model: &Model, outline: &[[f64; 2]]) -> (usize, usize) {
    let owned =
        TimedIndex::build(IndexKind::Bvh, &model.scene(), &Options::default()).expect("an index");
    let index = owned.index();
    let index = index.as_ray_index();
    let bounds = model.bounds();
    let (mut phantoms, mut leaks) = (0, 0);
    for step in 0..2_500 {
        let at = |lo: f32, hi: f32, step: i32| lo + (hi - lo) * (step as f32 + 0.503) / 50.0;
        let x = at(bounds.lo.x, bounds.hi.x, step % 50);
        let y = at(bounds.lo.y, bounds.hi.y, step / 50);
        let inside = outline.iter().zip(outline.iter().cycle().skip(1)).filter(|(a, b)| {
            let (x, y) = (f64::from(x), f64::from(y));
            (a[1] > y) != (b[1] > y) && x < a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
        });
        let inside = inside.count() % 2 == 1;
        let hit = index.occluded(&Ray::new(Vec3::new(x, y, 1.0), -Vec3::Z).unwrap());
        phantoms += usize::from(hit && !inside);
        leaks += usize::from(inside && !hit);
    }
    (phantoms, leaks)
}

#[test]
fn concave_polygons_are_hit_where_they_are() {
    let letter: [[f64; 2]; 8] = [
        [0.0, 0.0],
        [4.0, 0.0],
        [4.0, 4.0],
        [3.0, 4.0],
        [3.0, 1.0],
        [1.0, 1.0],
        [1.0, 4.0],
        [0.0, 4.0],
    ];
    let dart = [[0.0, 0.0], [4.0, 2.0], [0.0, 4.0], [1.0, 2.0]];
    for outline in [&letter[..], &dart] {
        let vertices: String = outline.iter().map(|[x, y]| format!("v {x} {y} 0\n")).collect();
        for start in 0..outline.len() {
            let face: String = (0..outline.len())
                .map(|at| format!(" {}", (start + at) % outline.len() + 1))
                .collect();
            let model = load(&format!("{vertices}f{face}\n"), &format!("concave-{start}.obj"));
            assert_eq!(model.triangles.len(), outline.len() - 2);
            assert_eq!(wrong_hits(&model, outline), (0, 0), "from corner {start}");
        }
    }
}

#[test]
fn a_comb_is_hit_where_it_is() {
    let text = include_str!("files/comb.obj");
    let outline: Vec<[f64; 2]> = text
        .lines()
        .filter_map(|line| line.strip_prefix("v "))
        .map(|line| {
            let mut numbers = line.split(' ').map(|word| word.parse().unwrap());
            [numbers.next().unwrap(), numbers.next().unwrap()]
        })
        .collect();
    let model = load(text, "comb.obj");
    assert_eq!(model.triangles.len(), outline.len() - 2);
    assert_eq!(wrong_hits(&model, &outline), (0, 0));
}

#[test]
fn rays_in_the_coordinates_of_a_file_far_away() {
    let folder = folder();
    let folder = folder.path();
    // A tile of 10 cm, with rays above its middle and just beside it on both sides.
    let tile = "v 500000.1 4649776.1 7\nv 500000.2 4649776.1 7\nv 500000.2 4649776.2 7\n\
                v 500000.1 4649776.2 7\nf 1 2 3 4\n";
    std::fs::write(folder.join("tile.obj"), tile).unwrap();
    let rays = [500_000.16, 500_000.21, 500_000.09_f64];
    let rays = rays.map(|x| [x, 4_649_776.15, 9.0, 0.0, 0.0, -1.0]);
    write_rays(&folder.join("rays.npy"), &rays);
    let cast = |origin: &[&str]| {
        let usual = [
            "cast",
            "tile.obj",
            "--rays",
            "rays.npy",
            "--hits",
            "hits.npy",
            "--points",
            "points.npy",
            "--index",
            "bvh",
        ];
        success(&run_in(folder, &[&usual, origin].concat())).1
    };

    let before = cast(&[]);
    assert!(
        before.contains("warning: tile.obj: rounded to 32 bits, 4 of 4 vertices move"),
        "{before}"
    );
    assert!(
        before.contains("`--origin auto`, or `--origin 500000.15,4649776.15,7`, keeps"),
        "{before}"
    );
    assert_eq!(before.matches("float64").count(), 1, "{before}");
    for origin in [["--origin", "auto"], ["--origin", "500000,4649776,0"]] {
        let after = cast(&origin);
        assert!(!after.contains("warning"), "{after}");
        assert!(after.contains("subtracted; add it to printed positions"), "{after}");
        assert!(after.contains("bvh: 1 hits of 3 rays"), "{after}");
        let hits = std::fs::read(folder.join("hits.npy")).unwrap();
        let records = &hits[hits.len() - 3 * 16..];
        let first = |record: usize| {
            let bytes = &records[record * 16..record * 16 + 4];
            u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])
        };
        assert_eq!([first(0), first(1), first(2)], [0, u32::MAX, u32::MAX]);
        // Points are in the coordinates of the file, in 64 bits.
        let points = std::fs::read(folder.join("points.npy")).unwrap();
        let row = &points[points.len() - 9 * 8..];
        let coordinate =
            |at: usize| f64::from_le_bytes(row[8 * at..8 * at + 8].try_into().unwrap());
        for (at, expected) in [500_000.16, 4_649_776.15, 7.0].into_iter().enumerate() {
            assert!((coordinate(at) - expected).abs() < 1e-7, "{}", coordinate(at));
        }
        assert!(coordinate(3).is_nan());
    }
}

#[test]
fn errors_tell_their_cause_once() {
    let folder = folder();
    let message = failure(&run_in(folder.path(), &["inspect", "no-such-file.obj"]));
    assert!(message.starts_with("error: cannot read no-such-file.obj: "), "{message}");
    assert_eq!(message.matches("os error").count(), 1, "{message}");
    // Built-in scenes take no origin.
    failure(&run_in(folder.path(), &["inspect", "--scene", "fig2", "--origin", "auto"]));
}
