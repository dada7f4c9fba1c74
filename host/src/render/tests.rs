//! Tests of pictures: one digest for every index and any number of threads, and values with closed forms.

use std::f32::consts::PI;
use std::sync::atomic::{AtomicU64, Ordering};

use arboleda::{IndexKind, Vec3};

use super::output::pfm_bytes;
use super::*;
use crate::density::fixtures::{Lit, lamp_over_floor, uniform_furnace};
use crate::density::{Domain, Estimator, Facing, Gather, Kernel, MapEstimator, TangentPlane};
use crate::photon::fixtures::{closed_box, sphere};
use crate::report::Camera;
use crate::scene::{AreaLight, FaceLight, LitSides, Model};

/// A coloured room with a ball and an emitting face.
fn room() -> Model {
    let mut model = Model::named("room");
    let mut walls = closed_box(Vec3::ZERO, Vec3::new(3.0, 2.0, 2.0));
    walls.extend(sphere(Vec3::new(1.7, 1.2, 0.5), 0.4, 2));
    let count = walls.len();
    model.add_object("room", walls, 0.6);
    model.colours =
        (0..count).map(|at| if at % 3 == 0 { [0.9, 0.6, 0.3] } else { [0.6; 3] }).collect();
    model.lights.push(AreaLight::facing_down(Vec3::new(1.5, 1.0, 1.9), 0.6, 0.6, 20.0));
    model.emitters.push(FaceLight {
        triangle: 3,
        radiance: [2.0, 1.0, 0.5],
        sides: LitSides::Both,
    });
    model
}

fn camera(size: (u32, u32)) -> Camera {
    let eye = Vec3::new(0.2, 0.3, 1.2);
    Camera::at(eye, Vec3::new(2.0, 1.2, 0.7), Vec3::Z, 80.0, size).unwrap()
}

fn map_estimator(gather: Gather, kernel: Kernel) -> Estimator {
    let facing = Facing::within_degrees(10.0);
    Estimator::PhotonMap(MapEstimator { gather, facing, kernel }, Domain::Disc)
}

fn visible_map_estimator(gather: Gather) -> Estimator {
    let (facing, kernel) = (Facing::within_degrees(10.0), Kernel::Constant);
    Estimator::PhotonMap(MapEstimator { gather, facing, kernel }, Domain::Visible)
}

fn plane(radius: f32, kernel: Kernel, domain: Domain) -> Estimator {
    Estimator::TangentPlane(TangentPlane { radius, beyond: 0.0, kernel, domain })
}

/// Counts calls; a picture is done when its passes are.
#[derive(Default)]
struct Counter {
    photons: AtomicU64,
    passes: AtomicU64,
}

impl Progress for Counter {
    fn photons(&self, photons: u64) {
        self.photons.fetch_add(photons, Ordering::Relaxed);
    }
    fn estimates(&self, _: u64) {}
    fn pass(&self, passes: u32, _: &Film, summary: &Summary) -> anyhow::Result<()> {
        assert_eq!(u64::from(passes), self.passes.fetch_add(1, Ordering::Relaxed) + 1);
        assert_eq!(summary.balance.emitted, summary.balance.ended(), "energy");
        Ok(())
    }
}

/// Picture to render: estimator, photons and passes, by indices of one kind over the triangles and over the discs.
struct PictureJob {
    estimator: Estimator,
    kind: IndexKind,
    photons: u64,
    final_gather: u32,
    passes: u32,
}

fn film_of(model: &Model, camera: Camera, job: &PictureJob) -> (Film, Summary) {
    let (counter, lit) = (Counter::default(), Lit::with(model.clone(), job.kind));
    let sampling = Sampling { side: 2, merged_within: 0.02 };
    let (film, summary) = rendered(&lit, camera, sampling, job, &counter).unwrap();
    assert_eq!(counter.passes.into_inner(), u64::from(job.passes));
    // Final gathering shoots the photons for direct light apart.
    let shots = if job.final_gather > 0 { 2 } else { 1 };
    assert_eq!(counter.photons.into_inner(), job.photons * u64::from(job.passes) * shots);
    (film, summary)
}

fn rendered(
    lit: &Lit,
    camera: Camera,
    sampling: Sampling,
    job: &PictureJob,
    counter: &Counter,
) -> Result<(Film, Summary), RenderError> {
    let PictureJob { estimator, kind: disc_kind, photons, final_gather, passes } = *job;
    lit.shoot(photons, |source| {
        let source = source.clone();
        let passes = Passes {
            source,
            estimator,
            disc_kind,
            light: PictureLight::Shot,
            camera,
            sampling,
            final_gather,
            passes,
        };
        render(passes, counter)
    })
}

fn digest(film: &Film) -> String {
    let mut hasher = blake3::Hasher::new();
    for quantity in [Quantity::Radiance, Quantity::Irradiance] {
        hasher.update(&pfm_bytes(film, &Look { quantity, ..Look::default() }));
    }
    for pixel in film.pixels() {
        hasher.update(&pixel.count.to_le_bytes());
        hasher.update(&pixel.triangle.to_le_bytes());
        for value in [pixel.radius, pixel.depth, pixel.standard_error] {
            hasher.update(&value.to_le_bytes());
        }
    }
    hasher.finalize().to_hex()[..16].to_owned()
}

/// Digests of the room by each estimator. The same in debug and release builds, and on every target.
const GOLDEN: [(&str, &str); 6] = [
    ("nearest", "54d0bc1693256d3b"),
    ("radius", "221eee87dd9e461b"),
    ("disc", "2f36be2ae08bd170"),
    ("visible", "1dceb8c310d2a847"),
    ("disc, gathered", "50eddc1e069267d1"),
    ("nearest, gathered", "bd8a7a1d34c7c79a"),
];

#[test]
fn one_digest_for_every_index_and_any_number_of_threads() {
    let model = room();
    let nearest = Gather::Nearest { k: 40, max_radius: 0.3 };
    let nearest = map_estimator(nearest, Kernel::Epanechnikov);
    let disc = plane(0.15, Kernel::Constant, Domain::Disc);
    let estimators = [
        (nearest, 0),
        (map_estimator(Gather::Within { radius: 0.15 }, Kernel::Constant), 0),
        (disc, 0),
        (plane(0.15, Kernel::Epanechnikov, Domain::Visible), 0),
        (disc, 3),
        (nearest, 3),
    ];
    let size = (40, 28);
    let mut digests = Vec::new();
    for ((name, _), (estimator, final_gather)) in GOLDEN.into_iter().zip(estimators) {
        let mut first = None;
        for (number, &kind) in IndexKind::ALL.iter().enumerate() {
            let threads = [1, 2, 3, 8][number % 4];
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let job = PictureJob { estimator, kind, photons: 3_000, final_gather, passes: 2 };
            let (film, _) = pool.install(|| film_of(&model, camera(size), &job));
            assert!(
                film.pixels().iter().all(|pixel| pixel.radiance().iter().all(|x| x.is_finite()))
            );
            let digest = digest(&film);
            let expected = first.get_or_insert_with(|| digest.clone());
            assert_eq!(&digest, expected, "{name}: {} with {threads} threads", kind.name());
        }
        digests.push((name, first.unwrap()));
    }
    let golden: Vec<_> = GOLDEN.map(|(name, digest)| (name, digest.to_owned())).into();
    assert_eq!(digests, golden);
}

#[test]
fn a_furnace_is_as_bright_everywhere() {
    let model = uniform_furnace(0.5).model;
    let size = (64, 64);
    let eye = Vec3::new(0.3, 0.4, 0.5);
    let camera = Camera::at(eye, Vec3::ONE, Vec3::Z, 90.0, size).unwrap();
    let map = Gather::Within { radius: 0.1 };
    for (estimator, final_gather) in [
        (plane(0.1, Kernel::Epanechnikov, Domain::Visible), 0),
        (plane(0.1, Kernel::Constant, Domain::Visible), 0),
        (plane(0.1, Kernel::Constant, Domain::Visible), 8),
        (visible_map_estimator(map), 8),
    ] {
        let kind = IndexKind::WideBvh;
        let job = PictureJob { estimator, kind, photons: 300_000, final_gather, passes: 1 };
        let (film, summary) = film_of(&model, camera, &job);
        assert_eq!(summary.primary_rays, 64 * 64 * 4);
        // E = 2 W/m2, L = 0.5 * 2 / pi. 800 photons a disc; in the corners a quarter of them.
        for pixel in film.pixels() {
            let [red, green, blue] = pixel.radiance();
            assert_eq!((red, green), (green, blue));
            let sigma = pixel.standard_error / pixel.mean_irradiance();
            let error = (red * PI - 1.0).abs();
            assert!(error < 6.0 * sigma && sigma < 0.12, "{pixel:?}");
            assert_eq!(pixel.coverage, 1.0);
        }
        let mean: f32 = film.pixels().iter().map(|pixel| pixel.radiance()[0]).sum::<f32>() / 4096.0;
        assert!((mean * PI - 1.0).abs() < 0.02, "{mean}");
    }
}

#[test]
fn final_gathering_makes_indirect_light_smooth() {
    // A lamp that shines at the ceiling: the floor has indirect light only.
    let mut model = Model::named("room");
    model.add_object("room", closed_box(Vec3::ZERO, Vec3::splat(2.0)), 0.5);
    let (corner, edge_u, edge_v) = (Vec3::new(0.5, 0.5, 1.5), Vec3::X, Vec3::Y);
    model.lights.push(AreaLight { corner, edge_u, edge_v, flux: 10.0 });
    let camera =
        Camera::at(Vec3::new(1.0, 1.0, 1.4), Vec3::new(1.0, 1.0, 0.0), Vec3::Y, 40.0, (24, 24));
    let spread = |final_gather: u32| {
        let estimator = plane(0.05, Kernel::Constant, Domain::Disc);
        let job = PictureJob {
            estimator,
            kind: IndexKind::WideBvh,
            photons: 50_000,
            final_gather,
            passes: 1,
        };
        let (film, _) = film_of(&model, camera.unwrap(), &job);
        let values = film.pixels().iter().map(|pixel| f64::from(pixel.mean_irradiance()));
        let (mean, squares) = values.fold((0.0, 0.0), |(mean, squares), value| {
            (mean + value / 576.0, squares + value * value / 576.0)
        });
        (mean, (squares - mean * mean).sqrt() / mean)
    };
    let (plain, gathered) = (spread(0), spread(256));
    // Some 20 photons a disc; 256 rays see a room that is not as bright everywhere.
    assert!((gathered.0 / plain.0 - 1.0).abs() < 0.05, "{plain:?} {gathered:?}");
    assert!(plain.1 > 0.15 && gathered.1 < 0.07, "{plain:?} {gathered:?}");
}

#[test]
fn passes_make_the_error_smaller() {
    let model = lamp_over_floor().model;
    let size = (64, 64);
    let camera = Camera::at(Vec3::Z * 3.0, Vec3::ZERO, Vec3::Y, 40.0, size).unwrap();
    let error = |passes: u32| {
        let kind = IndexKind::WideBvh;
        let estimator = plane(0.2, Kernel::Constant, Domain::Disc);
        let (film, _) = film_of(
            &model,
            camera,
            &PictureJob { estimator, kind, photons: 50_000, final_gather: 0, passes },
        );
        // The middle of the floor is 23.945647 W/m2; the mean over a disc of 0.2 is 23.407470.
        let middle = film.pixels()[32 * 64 + 32];
        (middle.standard_error, middle.radius, middle.count)
    };
    let (one, many) = (error(1), error(8));
    assert!(many.0 < 0.6 * one.0, "{one:?} {many:?}");
    assert!(many.1 < 0.9 * one.1, "the radius shrinks");
    assert!(many.2 > 3 * one.2, "counts add up");
}

#[test]
fn without_photons_a_picture_is_black_and_emitters_glow() {
    let model = room();
    let size = (40, 28);
    for estimator in [
        plane(0.1, Kernel::Constant, Domain::Disc),
        map_estimator(Gather::Nearest { k: 3, max_radius: 0.1 }, Kernel::Constant),
    ] {
        let job =
            PictureJob { estimator, kind: IndexKind::Bvh, photons: 0, final_gather: 0, passes: 1 };
        let (film, _) = film_of(&model, camera(size), &job);
        let sums = film.pixels().iter().fold((0.0, 0.0), |(reflected, emitted), pixel| {
            (reflected + pixel.reflected[0], emitted + pixel.emitted[0])
        });
        assert_eq!(sums.0, 0.0);
        assert!(sums.1 > 0.0);
        assert_eq!(exposure_of(&film), 1.0);
        paint(&film, &Look::default());
        let range = Range { largest: None, decades: Some(2.0) };
        paint(&film, &Look { false_colour: Some(range), ..Look::default() });
    }
}

#[test]
fn emitters_glow_on_the_sides_that_emit() {
    let mut model = Model::named("lamp");
    let square = crate::photon::fixtures::quad(Vec3::ZERO, Vec3::X, Vec3::Y);
    model.add_object("square", square, 0.5);
    let radiance = [3.0, 2.0, 1.0];
    for (sides, below) in [(LitSides::Front, [0.0; 3]), (LitSides::Both, radiance)] {
        model.emitters = (0..2).map(|triangle| FaceLight { triangle, radiance, sides }).collect();
        for (z, expected) in [(1.0, radiance), (-1.0, below)] {
            let middle = Vec3::new(0.5, 0.5, 0.0);
            let camera = Camera::at(middle + Vec3::Z * z, middle, Vec3::Y, 40.0, (16, 16)).unwrap();
            let estimator = plane(0.1, Kernel::Constant, Domain::Disc);
            let job = PictureJob {
                estimator,
                kind: IndexKind::Bvh,
                photons: 0,
                final_gather: 0,
                passes: 1,
            };
            let (film, _) = film_of(&model, camera, &job);
            for pixel in film.pixels() {
                for (seen, expected) in pixel.radiance().into_iter().zip(expected) {
                    assert!((seen - expected).abs() < 1e-5, "{sides:?} {z}: {pixel:?}");
                }
            }
        }
    }
}

#[test]
fn extreme_radii_give_finite_values() {
    let lit = Lit::with(room(), IndexKind::Bvh);
    let size = (24, 16);
    for radius in [f32::from_bits(1), f32::MIN_POSITIVE, 1e-20, 50.0, 1e15, f32::MAX] {
        for estimator in [
            plane(radius, Kernel::Epanechnikov, Domain::Disc),
            plane(radius, Kernel::Constant, Domain::Visible),
            map_estimator(Gather::Within { radius }, Kernel::Epanechnikov),
            map_estimator(Gather::Nearest { k: 1_000_000, max_radius: radius }, Kernel::Constant),
        ] {
            let sampling = Sampling { side: 1, merged_within: 0.0 };
            let job = PictureJob {
                estimator,
                kind: IndexKind::Bvh,
                photons: 200,
                final_gather: 0,
                passes: 2,
            };
            // A disc beyond the range of f32 is an error.
            match rendered(&lit, camera(size), sampling, &job, &Counter::default()) {
                Ok((film, _)) => assert!(film.pixels().iter().all(|pixel| {
                    pixel.irradiance.iter().all(|x| x.is_finite())
                        && pixel.standard_error.is_finite()
                })),
                Err(error) => assert!(radius > 1e30, "{radius}: {error}"),
            }
        }
    }
}

#[test]
fn wrong_options_are_refused_by_name() {
    let nearest =
        |k, max_radius| map_estimator(Gather::Nearest { k, max_radius }, Kernel::Constant);
    let disc = |radius| plane(radius, Kernel::Constant, Domain::Disc);
    for (estimator, message) in [
        (disc(0.0), "the radius is 0;"),
        (disc(-1.0), "the radius is -1;"),
        (disc(f32::NAN), "the radius is NaN;"),
        (disc(f32::INFINITY), "the radius is inf;"),
        (nearest(2, 1.0), "k is 2;"),
        (nearest(9, f32::NAN), "the radius is NaN;"),
    ] {
        let error = estimator.check().unwrap_err().to_string();
        assert!(error.starts_with(message), "{error}");
    }
}

#[test]
fn the_camera_is_where_light_is_seen() {
    // A box that is open in front: from above, its ceiling hides all light.
    let mut walls = closed_box(Vec3::splat(-1.0), Vec3::ONE);
    walls.retain(|triangle| triangle.a.z + triangle.b.z + triangle.c.z < 3.0);
    let mut model = Model::named("open box");
    model.add_object("walls", walls, 0.5);
    let down = AreaLight {
        corner: Vec3::Y * 0.9,
        edge_u: Vec3::X * 0.2,
        edge_v: Vec3::Z * 0.2,
        flux: 1.0,
    };
    model.lights.push(down);
    let lit = Lit::with(model, IndexKind::Bvh);
    let camera = lit.shoot(1000, |source| viewpoint(source, Vec3::Y, (64, 48)));
    assert_eq!(camera.forward(), Vec3::NEG_Z);
    assert!(camera.eye().z > 1.0);
}
