//! Scenes of the paper's figures 2, 3 and 4. z is up; a unit may be a decimetre.
//!
//! # Source
//! N. Aguilera, J. Revelles, M. Lastra, R. Montes, R. J. García, *Representaciones Espaciales Para Escenas
//! Constituidas Mediante Agrupaciones de Objetos*. The paper gives counts and pictures but no coordinates. The
//! coordinates here are ours, chosen so that the counts are the paper's.

use arboleda::{Aabb, Triangle, Vec3};

use super::shapes;
use super::teapot::{PAPER_DIVISIONS, Placement, placed, teapot};
use crate::scene::model::DEFAULT_FLUX;
use crate::scene::{AreaLight, Model};

/// Reflectance of the floor: white paint.
const FLOOR_REFLECTANCE: f32 = 0.7;
/// Reflectance of all objects but the floor: grey paint.
const OBJECT_REFLECTANCE: f32 = 0.5;

/// Makes figure 2: six groups of four objects each; every group is a cluster.
///
/// Boxes and balls are divided so that all triangles have similar sizes and form one size class. The objects of a group
/// touch each other.
pub fn fig2() -> Model {
    let mut model = Model::named("fig2");
    for group in 0..6_u8 {
        let (column, row) = (f32::from(group % 3), f32::from(group / 3));
        let base = Vec3::new(column * 8.0 - 8.0, row * 8.0 - 4.0, 0.0);
        let mut block = |name: &str, lo: [f32; 3], hi: [f32; 3]| {
            let bounds = Aabb::new(base + Vec3::from_array(lo), base + Vec3::from_array(hi));
            model.add_object(
                format!("group {} {name}", group + 1),
                shapes::cuboid(bounds, 4),
                OBJECT_REFLECTANCE,
            );
        };
        let height = 1.0 + 0.25 * f32::from(group);
        block("box", [-1.0, -0.5, 0.0], [0.0, 0.5, 1.0]);
        block("tower", [0.0, -0.5, 0.0], [1.0, 0.5, height]);
        for (name, centre) in
            [("ball", [-0.5, 0.0, 1.5]), ("raised ball", [0.5, 0.0, height + 0.5])]
        {
            model.add_object(
                format!("group {} {name}", group + 1),
                shapes::sphere_at(base + Vec3::from_array(centre), 0.5, 2),
                OBJECT_REFLECTANCE,
            );
        }
    }
    model.lights.push(AreaLight::facing_down(Vec3::Z * 8.0, 8.0, 8.0, DEFAULT_FLUX));
    model
}

/// Makes figure 3: two clusters far apart along x, each of 8 x 8 x 8 cubes of 12 triangles, and a light above each.
///
/// With leaves of at most 12 triangles, the octree hierarchy has level 3 and a single octree level 7:
///
/// - Hierarchy: cubes have side 1 and gaps of 1/8, so a cluster has side 71/8 and its cells at level 3 have side 71/64.
///   Cube `i` along an axis spans `9i/8` to `9i/8 + 1`. It lies in cell `i`, which begins at `71i/64`. Each cell of
///   level 3 holds one cube, 12 triangles; each cell of level 2 holds 8 cubes.
/// - Single octree: the root cell is 100 x 71/8 x 71/8. The default halves its length alone until it is at most three
///   times its height. The cells of level 7 are 0.78 long and 0.28 high: they reach into two cubes along x at most, of
///   which each has fewer than 12 triangles in them.
pub fn fig3() -> Model {
    const PITCH: f32 = 1.125;
    const SIDE: f32 = 7.0 * PITCH + 1.0;
    const LENGTH: f32 = 100.0;
    let mut model = Model::named("fig3");
    for (cluster, start) in [("left", 0.0), ("right", LENGTH - SIDE)] {
        for number in 0..512_u16 {
            let step = |shift: u16| f32::from(number >> shift & 7) * PITCH;
            let lo = Vec3::new(start + step(0), step(3), step(6));
            let cube = shapes::cuboid(Aabb::new(lo, lo + Vec3::ONE), 1);
            model.add_object(format!("{cluster} cube {number}"), cube, OBJECT_REFLECTANCE);
        }
        let centre = Vec3::new(start + SIDE * 0.5, SIDE * 0.5, SIDE + 1.0);
        model.lights.push(AreaLight::facing_down(centre, SIDE, SIDE, DEFAULT_FLUX * 0.5));
    }
    model
}

/// Quads along each side of the floor of figure 4, which has 5,000 triangles.
///
/// A quad of the usual floor has side 0.72, so the bounding boxes of its triangles have a diagonal of 1.02. That is
/// more than twice the largest diagonal of a teapot triangle, 0.47. The floor therefore is a size class and a cluster
/// of its own, although the teapots stand on it. The floor of figure 4(d) is three times as wide, as its largest teapot
/// is.
const FLOOR_DIVISIONS: u32 = 50;
/// Side of the usual floor.
const USUAL_SIDE: f32 = 36.0;
/// Distance of the centres of teapots in a row. A teapot is 4 wide, so neighbours are 0.04 apart: less than the gap up
/// to which their triangles join one cluster.
const STEP: f32 = 4.04;

/// Makes figure 4(a): a floor and a pile of five teapots; 2 clusters.
///
/// Two teapots stand side by side, two lie across on their lids, and the fifth lies on the lids of these. A teapot's
/// body is round, so the heights at which the upper ones rest follow from its radius: with axes 2.83 apart bodies touch
/// at 2.43, with axes 2 apart at 2.80. The pile keeps 0.01 of distance, less than the gap up to which triangles join
/// one cluster.
///
/// The paper does not say where the teapots stand. With cells in proportion to the box of the cluster it matters
/// little: at levels 1 and 3 the octrees make exactly the tests of the grids, in every arrangement. Tests of the
/// octrees as a multiple of the grids' at levels 1, 3, 4 and 5, and the gain in percent (3,000 photons, fastest of
/// seven rounds, leaves of 1 triangle):
///
/// | arrangement | tests | gain |
/// |---|---|---|
/// | paper | | -7, -16, +3, +22 |
/// | this pile | 1.00, 1.00, 0.78, 0.56 | 0, -5, +3, 0 |
/// | a cross | 1.00, 1.00, 0.79, 0.55 | 0, +2, +3, +2 |
/// | a row | 1.00, 1.00, 0.80, 0.56 | 0, -3, -1, -12 |
///
/// A smaller floor would not be a cluster of its own: with a side of 20 its triangles are as large as a teapot's, and
/// it is in one cluster with the teapots.
pub fn fig4a() -> Model {
    const BESIDE: f32 = 2.005;
    const ACROSS: f32 = 2.44;
    const TOP: f32 = ACROSS + 2.81;
    let at =
        |x, y, z, quarter_turns| Placement { base: Vec3::new(x, y, z), scale: 1.0, quarter_turns };
    let pile = [
        at(0.0, -BESIDE, 0.0, 0),
        at(0.0, BESIDE, 0.0, 0),
        at(-BESIDE, 0.0, ACROSS, 1),
        at(BESIDE, 0.0, ACROSS, 1),
        at(0.0, 0.0, TOP, 0),
    ];
    on_floor("fig4a", USUAL_SIDE, pile)
}

/// Makes figure 4(b): a floor and five teapots in rows of three and two; 3 clusters.
pub fn fig4b() -> Model {
    on_floor("fig4b", USUAL_SIDE, rows([((-8.0, 0.0), 3), ((8.0, 0.0), 2)]))
}

/// Makes figure 4(c): a floor and five teapots in rows of two, two and one; 4 clusters.
pub fn fig4c() -> Model {
    on_floor("fig4c", USUAL_SIDE, rows(GROUPS_OF_C))
}

/// Row of teapots: the position of its middle, and the number of teapots.
type TeapotRow = ((f32, f32), u8);

const GROUPS_OF_C: [TeapotRow; 3] = [((-10.0, -7.0), 2), ((10.0, -7.0), 2), ((0.0, 12.0), 1)];

/// Makes figure 4(d): five teapots around a sixth that is three times as large; 5 clusters.
///
/// There are two size classes, the teapots and the floor. The sizes of the large teapot's triangles overlap with those
/// of the other teapots, so the large teapot is in their size class. It is a cluster of its own because it stands
/// apart.
pub fn fig4d() -> Model {
    let groups = [((-22.0, -12.0), 2), ((22.0, -12.0), 2), ((0.0, 24.0), 1)];
    with_sixth(on_floor("fig4d", 3.0 * USUAL_SIDE, rows(groups)), 3.0)
}

/// Makes figure 4(e): figure 4(c) with a sixth teapot in the middle, a fiftieth as large; 5 clusters.
///
/// The largest triangles of the small teapot are less than half as large as the smallest of the other teapots, so the
/// small teapot is a third size class. It would be a cluster of its own in any case, because it stands apart.
pub fn fig4e() -> Model {
    with_sixth(on_floor("fig4e", USUAL_SIDE, rows(GROUPS_OF_C)), 0.02)
}

fn with_sixth(mut model: Model, scale: f32) -> Model {
    let sixth = Placement { base: Vec3::ZERO, scale, quarter_turns: 0 };
    model.add_object("teapot 6", placed(&teapot(PAPER_DIVISIONS), sixth), OBJECT_REFLECTANCE);
    model
}

/// Places the teapots of rows along y.
fn rows<const N: usize>(rows: [TeapotRow; N]) -> impl Iterator<Item = Placement> {
    rows.into_iter().flat_map(|((x, y), length)| {
        (0..length).map(move |place| {
            let along = (f32::from(place) - f32::from(length - 1) * 0.5) * STEP;
            Placement { base: Vec3::new(x, y + along, 0.0), scale: 1.0, quarter_turns: 0 }
        })
    })
}

/// Makes a floor around the origin, teapots, and a light above them, half as wide as the floor.
fn on_floor(name: &str, side: f32, teapots: impl IntoIterator<Item = Placement>) -> Model {
    let mut model = Model::named(name);
    let floor = shapes::floor(Vec3::ZERO, side, FLOOR_DIVISIONS);
    model.add_object("floor", floor, FLOOR_REFLECTANCE);
    let teapot: Vec<Triangle> = teapot(PAPER_DIVISIONS);
    for (number, placement) in (1..).zip(teapots) {
        model.add_object(
            format!("teapot {number}"),
            placed(&teapot, placement),
            OBJECT_REFLECTANCE,
        );
    }
    let (height, width) = (Vec3::Z * side * 0.3, side * 0.5);
    model.lights.push(AreaLight::facing_down(height, width, width, DEFAULT_FLUX));
    model
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::test_support::cluster_counts;
    use arboleda::kinds::{Clustered, Octree, Representation};
    use arboleda::{Block, Index, IndexKind, Level, Options, Ray};

    fn check(model: &Model, triangles: usize, objects: usize, clusters: (usize, u32)) {
        assert_eq!(model.triangles.len(), triangles, "{}", model.name);
        assert_eq!(model.objects.len(), triangles);
        assert_eq!(model.reflectance.len(), triangles);
        assert_eq!(model.object_names.len(), objects);
        let flux: f32 = model.lights.iter().map(|light| light.flux).sum();
        assert_eq!(flux, 100.0);
        // The counts have a margin: half and double the default proximity give the same.
        for proximity in [0.25, 0.5, 1.0] {
            let options = Options { proximity, ..Options::default() };
            assert_eq!(cluster_counts(&model.scene(), &options), clusters, "{}", model.name);
        }
    }

    #[test]
    fn figure_2_has_six_clusters() {
        check(&fig2(), 6 * (2 * 192 + 2 * 320), 24, (6, 1));
    }

    #[test]
    fn figure_3_has_two_clusters() {
        check(&fig3(), 12_288, 1_024, (2, 1));
    }

    #[test]
    fn figure_4_has_the_papers_clusters() {
        let five = 5_000 + 5 * 5_112;
        check(&fig4a(), five, 6, (2, 2));
        check(&fig4b(), five, 6, (3, 2));
        check(&fig4c(), five, 6, (4, 2));
        check(&fig4d(), five + 5_112, 7, (5, 2));
        check(&fig4e(), five + 5_112, 7, (5, 3));
    }

    /// Every edge of a teapot is cast as a ray that ends where the edge does, at the other teapots.
    #[test]
    fn the_piled_teapots_do_not_pass_through_each_other() {
        let model = fig4a();
        let teapots: Vec<&[Triangle]> = model.triangles[5_000..].chunks(5_112).collect();
        for (number, teapot) in teapots.iter().enumerate() {
            let others = teapots.iter().enumerate().filter(|(other, _)| *other != number);
            let others: Vec<Triangle> = others.flat_map(|(_, t)| t.iter().copied()).collect();
            let scene = arboleda::Scene::new(&others);
            let owned =
                arboleda::OwnedIndex::build(IndexKind::Bvh, &scene, &Options::DEFAULT).unwrap();
            for t in *teapot {
                for (from, to) in [(t.a, t.b), (t.b, t.c), (t.c, t.a)] {
                    let edge = Ray::with_interval(from, to - from, 0.0, 1.0).unwrap();
                    assert!(!owned.index().occluded(&edge), "teapot {number} at {from:?}");
                }
            }
        }
    }

    #[test]
    fn clusters_of_figure_4_are_whole_objects() {
        for model in [fig4a(), fig4b(), fig4c(), fig4d(), fig4e()] {
            let bytes = arboleda::clusters::scratch_capacity(model.triangles.len());
            let mut scratch = vec![Block::ZERO; Block::count(bytes)];
            let scratch = Block::bytes(&mut scratch);
            let found =
                arboleda::clusters::find(&model.scene(), &Options::default(), scratch).unwrap();
            let mut home = vec![None; model.object_names.len()];
            for (number, ids) in found.iter().enumerate() {
                for &id in ids {
                    let object = model.objects[id as usize] as usize;
                    assert_eq!(*home[object].get_or_insert(number), number, "{}", model.name);
                }
            }
            let floor = home[0];
            assert!(home[1..].iter().all(|&cluster| cluster != floor));
        }
    }

    /// Returns the deepest level and the largest leaf of an index with leaves of 12 and levels up to `level`.
    fn levels<R: Representation>(model: &Model, level: u32) -> (u32, u32) {
        let options = Options { level: Level::AtMost(level), ..Options::default() };
        let scene = model.scene();
        let bytes = Index::<R>::scratch_capacity(model.triangles.len(), &options);
        let mut scratch = vec![Block::ZERO; Block::count(bytes)];
        let scratch = Block::bytes(&mut scratch);
        let capacity = Index::<R>::capacity(&scene, &options, scratch).unwrap();
        let mut arena = vec![Block::ZERO; Block::count(capacity.index)];
        let index = Index::<R>::build(&scene, &options, Block::bytes(&mut arena), scratch).unwrap();
        let statistics = index.check().unwrap();
        (statistics.deepest_level, statistics.largest_leaf)
    }

    #[test]
    fn figure_3_needs_level_3_in_clusters_and_7_in_one_octree() {
        let model = fig3();
        assert_eq!(levels::<Clustered<Octree>>(&model, 20), (3, 12));
        assert_eq!(levels::<Octree>(&model, 20), (7, 12));
        // One level less leaves cells with more than 12 triangles.
        assert!(levels::<Clustered<Octree>>(&model, 2).1 > 12);
        assert!(levels::<Octree>(&model, 6).1 > 12);
    }
}
