//! Tests of clusters and their tree: equality with the oracles, which compare all pairs, and near-linear time.
//!
//! The small scenes are on a lattice, where many gaps are equal, so that every rule about ties matters. The large
//! scenes are those on which a search that is fast on average is known to become quadratic.

use std::time::{Duration, Instant};

use arboleda::clusters::{NodeId, TreeNode};
use arboleda::{
    Aabb, Block, IndexKind, Level, Options, Scene, Triangle, Vec3, clusters as cluster,
};
use arboleda_tests::build::Built;
use arboleda_tests::oracle::cluster_tree::joins;
use arboleda_tests::oracle::clusters::clusters;
use arboleda_tests::random::{Random, power_of_two};
use arboleda_tests::scenes;

const DEBUG: bool = cfg!(debug_assertions);
const SMALL_SCENES: u64 = if DEBUG { 200 } else { 2_000 };

fn found(scene: &Scene<'_>, options: &Options) -> Vec<Vec<u32>> {
    let length = cluster::scratch_capacity(scene.triangles().len());
    let mut scratch = vec![Block::ZERO; Block::count(length)];
    let clusters = cluster::find(scene, options, &mut Block::bytes(&mut scratch)[..length]);
    let clusters = clusters.expect("exactly enough scratch");
    assert_eq!(clusters.count(), clusters.classes().len());
    assert!(clusters.classes().iter().all(|&class| class < clusters.class_count()));
    assert!(clusters.class_count() <= options.size_classes);
    clusters.iter().map(<[u32]>::to_vec).collect()
}

/// Makes small boxes, tetrahedra and triangles on a lattice, some much larger than others.
fn small_scene(random: &mut Random) -> Vec<Triangle> {
    let mut triangles = Vec::new();
    let reach = random.pick(&[3, 10, 30]);
    for _ in 0..random.below(40) {
        let at = random.lattice(reach);
        let size = random.pick(&[1.0, 1.0, 1.0, 2.0, 40.0]);
        if random.once_in(2) {
            triangles.extend(scenes::cuboid(at, at + Vec3::splat(size)));
        } else {
            let (p, q) = (random.lattice(1) * size, random.lattice(1) * size);
            triangles.push(Triangle::new(at, at + p, at + q));
        }
    }
    triangles
}

fn some_options(random: &mut Random) -> Options {
    Options {
        proximity: random.pick(&[0.0, 0.25, 0.5, 1.0, 3.0]),
        size_classes: random.whole(1, 4) as u32,
        ..Options::default()
    }
}

#[test]
fn clusters_are_those_of_all_pairs() {
    let (mut several_classes, mut several_clusters) = (0, 0);
    for seed in 0..SMALL_SCENES {
        let mut random = Random::new(seed);
        let mut triangles = small_scene(&mut random);
        if seed % 3 == 0 {
            triangles = scenes::soup(random.below(200), seed);
        }
        let options = some_options(&mut random);
        let count = triangles.len();
        let expected = clusters(&triangles, None, &options);
        assert_eq!(found(&Scene::new(&triangles), &options), expected, "seed {seed} {options:?}");
        several_clusters += usize::from(expected.len() > 1);
        let one_class = Options { size_classes: 1, ..options };
        several_classes += usize::from(clusters(&triangles, None, &one_class) != expected);

        // Objects are whole boxes, or random sets of triangles.
        let boxes: Vec<u32> = (0..count as u32).map(|id| id / 12).collect();
        let thrown: Vec<u32> = (0..count).map(|_| random.below(count) as u32).collect();
        for objects in [boxes, thrown] {
            let scene = Scene::with_objects(&triangles, &objects);
            let expected = clusters(&triangles, Some(&objects), &options);
            assert_eq!(found(&scene, &options), expected, "seed {seed} with objects {options:?}");
        }
    }
    // The test is void if too few scenes have several classes.
    assert!(several_classes * 10 > SMALL_SCENES as usize, "{several_classes}");
    assert!(several_clusters * 3 > SMALL_SCENES as usize, "{several_clusters}");
}

#[test]
fn clusters_do_not_depend_on_the_order_of_triangles() {
    for seed in 0..SMALL_SCENES {
        let mut random = Random::new(seed ^ 0xabc);
        let triangles = small_scene(&mut random);
        let options = some_options(&mut random);
        let mut order: Vec<u32> = (0..triangles.len() as u32).collect();
        random.shuffle(&mut order);
        let shuffled: Vec<Triangle> = order.iter().map(|&id| triangles[id as usize]).collect();
        let mut renamed = found(&Scene::new(&shuffled), &options);
        for cluster in &mut renamed {
            cluster.iter_mut().for_each(|id| *id = order[*id as usize]);
            cluster.sort_unstable();
        }
        renamed.sort_unstable();
        assert_eq!(renamed, found(&Scene::new(&triangles), &options), "seed {seed}");
    }
}

/// Builds the cluster tree of a scene. Returns its nodes, the number of clusters, and the depth.
fn tree(triangles: &[Triangle], options: &Options) -> (Vec<TreeNode>, usize, u32) {
    let built = Built::new(IndexKind::OctreeHierarchy, &Scene::new(triangles), options);
    let built = built.expect("an ordinary scene");
    let index = built.index();
    let tree = index.cluster_tree();
    (tree.iter().collect(), tree.cluster_count() as usize, tree.depth())
}

/// Computes `ceil(log2(count))`; 0 for a count of 0.
fn balanced_depth(count: usize) -> u32 {
    count.next_power_of_two().trailing_zeros()
}

#[test]
fn the_cluster_tree_is_that_of_all_pairs() {
    let mut largest = 0;
    let mut ties = 0;
    for seed in 0..SMALL_SCENES / 4 {
        let mut random = Random::new(seed ^ 0xdef);
        let mut triangles = small_scene(&mut random);
        if seed % 2 == 0 {
            // The scene has many equal boxes at equal gaps.
            let mut cells: Vec<i32> = (0..216).collect();
            random.shuffle(&mut cells);
            for cell in cells.into_iter().take(random.below(100)) {
                let lo =
                    Vec3::new((cell % 6) as f32, (cell / 6 % 6) as f32, (cell / 36) as f32) * 3.0;
                triangles.extend(scenes::cuboid(lo, lo + Vec3::ONE));
            }
        }
        let options = Options { level: Level::AtMost(1), ..some_options(&mut random) };
        let (nodes, count, depth) = tree(&triangles, &options);
        let leaves: Vec<Aabb> = nodes.iter().take(count).map(|leaf| leaf.bounds).collect();
        let expected = joins(&leaves);
        assert_eq!(nodes.len(), count + expected.len(), "seed {seed}");
        for (node, join) in nodes.iter().skip(count).zip(&expected) {
            let mut links = node.children.expect("a join").map(|child| child.0);
            links.sort_unstable();
            assert_eq!((links, node.bounds), (join.links, join.bounds), "seed {seed}");
        }
        for (id, join) in (count as u32..).zip(&expected) {
            for link in join.links {
                assert_eq!(nodes[link as usize].parent, Some(NodeId(id)), "seed {seed}");
            }
        }
        assert_eq!(depth, balanced_depth(count), "seed {seed}");
        largest = largest.max(count);
        let overlapping = leaves
            .iter()
            .enumerate()
            .any(|(place, p)| leaves.iter().skip(place + 1).any(|q| p.gap_squared(q) == 0.0));
        ties += usize::from(overlapping);
    }
    assert!(largest > 60, "the largest tree has {largest} leaves only");
    assert!(ties > 10, "clusters overlap in {ties} scenes only");
}

const BOXES: usize = if DEBUG { 4_000 } else { 50_000 };

/// Longest time of a test. A test takes a second or two on a free core; a quadratic search would take many minutes.
const BOUND: Duration = Duration::from_secs(60);

/// Finds and joins clusters of boxes. Checks the time and the number of clusters.
fn in_time(name: &str, boxes: &[(Vec3, Vec3)], proximity: f32, expected: Option<usize>) {
    let triangles: Vec<Triangle> =
        boxes.iter().flat_map(|&(lo, hi)| scenes::cuboid(lo, hi)).collect();
    // At level 0 the octrees are trivial, so the time is that of the clusters.
    let options = Options { level: Level::AtMost(0), proximity, ..Options::default() };
    let start = Instant::now();
    let (_, count, depth) = tree(&triangles, &options);
    let elapsed = start.elapsed();
    println!(
        "{name}: {} triangles, {count} clusters, {elapsed:.2?} for two builds",
        triangles.len()
    );
    assert!(elapsed < BOUND, "{name} took {elapsed:?}");
    assert!(expected.is_none_or(|expected| count == expected), "{name}: {count} clusters");
    assert_eq!(depth, balanced_depth(count), "{name}");
}

/// Makes unit boxes on a lattice with gaps of two, in random order.
fn separate_boxes(count: usize) -> Vec<(Vec3, Vec3)> {
    let side = (count as f64).cbrt().ceil() as usize;
    let at =
        |i: usize| Vec3::new((i % side) as f32, (i / side % side) as f32, (i / side / side) as f32);
    let mut boxes: Vec<_> = (0..count).map(|i| (at(i) * 3.0, at(i) * 3.0 + Vec3::ONE)).collect();
    Random::new(1).shuffle(&mut boxes);
    boxes
}

#[test]
fn many_separate_boxes_take_seconds() {
    in_time("separate boxes", &separate_boxes(BOXES), 0.5, Some(BOXES));
}

#[test]
fn boxes_in_one_place_take_seconds() {
    in_time("coincident boxes", &vec![(Vec3::ZERO, Vec3::ONE); BOXES], 0.5, Some(1));
}

#[test]
fn boxes_on_a_line_take_seconds() {
    let mut boxes: Vec<_> =
        (0..BOXES).map(|i| Vec3::X * (3 * i) as f32).map(|lo| (lo, lo + Vec3::ONE)).collect();
    in_time("a line, ascending", &boxes, 0.5, Some(BOXES));
    boxes.reverse();
    in_time("a line, descending", &boxes, 0.5, Some(BOXES));
    Random::new(2).shuffle(&mut boxes);
    in_time("a line, shuffled", &boxes, 0.5, Some(BOXES));
}

#[test]
fn boxes_inside_a_huge_one_take_seconds() {
    let mut boxes = separate_boxes(BOXES - 1);
    boxes.insert(BOXES / 2, (Vec3::splat(-500.0), Vec3::splat(500.0)));
    in_time("inside a huge box", &boxes, 0.5, None);
}

#[test]
fn nested_boxes_take_seconds() {
    let nested = |i: usize| {
        let radius = Vec3::splat(1.0 + i as f32);
        (-radius, radius)
    };
    let boxes: Vec<_> = (0..BOXES).map(nested).collect();
    in_time("nested boxes", &boxes, 0.5, None);
    in_time("nested boxes that must touch", &boxes, 0.0, None);
}

/// Half of the boxes lie in a part of the scene that is smaller than a cell of a grid over the whole scene.
#[test]
fn boxes_at_growing_gaps_take_seconds() {
    let mut boxes: Vec<_> = (0..BOXES)
        .map(|i| {
            let exponent = i as f64 / BOXES as f64 * 200.0 - 100.0;
            let whole = exponent.floor();
            let x = (power_of_two(whole as i32) * (1.0 + (exponent - whole))) as f32;
            let step = Vec3::splat(x * 1e-4);
            (Vec3::X * x, Vec3::X * x + step)
        })
        .collect();
    in_time("growing gaps", &boxes, 0.0, None);
    Random::new(3).shuffle(&mut boxes);
    in_time("growing gaps, shuffled", &boxes, 0.0, None);
}

/// A far box enlarges the scene, and must not make the search unable to separate the other boxes.
#[test]
fn boxes_beside_a_far_one_take_seconds() {
    let mut boxes = separate_boxes(BOXES - 1);
    boxes.push((Vec3::splat(1e12), Vec3::splat(1e12 + 1e6)));
    in_time("beside a far one", &boxes, 0.5, Some(BOXES));
}

/// Long sticks, half of them along x and half along y, in four layers: their boxes cross, but none is near another.
fn woven(count: usize) -> Vec<Triangle> {
    let long = 2.0 * count as f32;
    let stick = |number: usize| {
        let layer = (number % 2 + 2 * (number / 2 % 2)) as f32;
        let at = (2 * number) as f32;
        if number.is_multiple_of(2) {
            let a = Vec3::new(0.0, at, layer);
            Triangle::new(a, a + Vec3::X * long, a + Vec3::new(long, 0.01, 0.0))
        } else {
            let a = Vec3::new(at, 0.0, layer);
            Triangle::new(a, a + Vec3::Y * long, a + Vec3::new(0.01, long, 0.0))
        }
    };
    (0..count).map(stick).collect()
}

#[test]
fn a_search_that_would_compare_all_pairs_ends_at_its_bound() {
    let options = Options { proximity: 1e-6, ..Options::default() };
    for (count, is_cut_short) in [(2_000, false), (30_000, true)] {
        let triangles = woven(count);
        let mut scratch = vec![Block::ZERO; Block::count(cluster::scratch_capacity(count))];
        let scene = Scene::new(&triangles);
        let clusters = cluster::find(&scene, &options, Block::bytes(&mut scratch)).expect("memory");
        assert_eq!(clusters.is_cut_short(), is_cut_short, "{count}");
        // Those that it did not compare are apart, and so are those that it did.
        assert_eq!(clusters.count(), count);
    }
}
