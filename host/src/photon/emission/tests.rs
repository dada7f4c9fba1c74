//! Tests of emission: shares of lights, points and directions.

use super::*;

fn light(corner: Vec3, edge_u: Vec3, edge_v: Vec3, flux: f32) -> AreaLight {
    AreaLight { corner, edge_u, edge_v, flux }
}

#[test]
fn lights_are_chosen_in_proportion_to_their_flux() {
    let at = |x: f32, flux| light(Vec3::new(x, 0.0, 0.0), Vec3::X, Vec3::Y, flux);
    let dark = [at(1.0, 0.0), at(1.0, -1.0), at(1.0, f32::NAN), at(f32::NAN, 1.0)];
    let flat = light(Vec3::ZERO, Vec3::X, Vec3::X, 5.0);
    let lights =
        [dark[0], at(0.0, 1.0), dark[1], dark[2], at(2.0, 6.0), flat, dark[3], at(4.0, 3.0)];
    let emitter = Emitter::new(&lights);
    assert_eq!(emitter.total_flux(), 10.0);
    let count = 100_000;
    let mut counts = [0_u32; 8];
    for photon in 0..count {
        let emission = emitter.emit(&mut PhotonRandom::new(1, photon)).unwrap();
        counts[emission.light as usize] += 1;
    }
    for (light, share) in [(1, 0.1), (4, 0.6), (7, 0.3)] {
        let sigma = (count as f64 * share * (1.0 - share)).sqrt();
        assert!((f64::from(counts[light]) - count as f64 * share).abs() < 4.0 * sigma);
    }
    assert_eq!(u64::from(counts[1] + counts[4] + counts[7]), count);
}

#[test]
fn photons_begin_inside_the_parallelogram_and_in_front_of_it() {
    for scale in [1e-30_f32, 1e-3, 1.0, 1e6, 1e30] {
        let corner = Vec3::new(3.0, -1.0, 0.5) * scale;
        let (edge_u, edge_v) =
            (Vec3::new(1.0, 2.0, 0.1) * scale, Vec3::new(-0.5, 1.0, 3.0) * scale);
        let emitter = Emitter::new(&[light(corner, edge_u, edge_v, 1.0)]);
        let [exact_u, exact_v] = [edge_u, edge_v].map(Vector64::from);
        let normal = exact_u.cross(exact_v);
        let mut cosines = 0.0;
        let count = 20_000_u32;
        for photon in 0..count {
            let emission = emitter.emit(&mut PhotonRandom::new(2, u64::from(photon))).unwrap();
            let from_corner = Vector64::from(emission.origin) - Vector64::from(corner);
            let square = normal.dot(normal);
            let u = from_corner.cross(exact_v).dot(normal) / square;
            let v = exact_u.cross(from_corner).dot(normal) / square;
            assert!((0.0..=1.0).contains(&u) && (0.0..=1.0).contains(&v), "{u} {v}");
            assert!(from_corner.dot(normal) > 0.0);
            cosines += Vector64::from(emission.direction).dot(normal) / square.sqrt();
        }
        let sigma = (1.0 / 18.0 / f64::from(count)).sqrt();
        assert!((cosines / f64::from(count) - 2.0 / 3.0).abs() < 4.0 * sigma);
    }
}

#[test]
fn without_a_light_nothing_is_emitted() {
    let emitter = Emitter::new(&[]);
    assert!(emitter.is_dark());
    assert_eq!(emitter.emit(&mut PhotonRandom::new(0, 0)), None);
}

#[test]
fn emitting_triangles_have_the_flux_of_their_radiance_on_each_side() {
    let mut model = Model::default();
    let square = crate::photon::fixtures::quad(Vec3::ZERO, Vec3::X, Vec3::Y);
    model.add_object("square", square, 0.5);
    model.add_object("no area", [Triangle::new(Vec3::ZERO, Vec3::X, Vec3::X)], 0.5);
    let face = |triangle, radiance| FaceLight { triangle, radiance, sides: LitSides::Front };
    let white = [1.0; 3];
    model.emitters = vec![face(0, white), face(1, white), face(2, white), face(9, white)];
    model.emitters.extend([
        face(0, [f32::NAN, 1.0, 1.0]),
        face(0, [-1.0, 1.0, 1.0]),
        face(0, [0.0; 3]),
    ]);
    let emitter = Emitter::of(&model);
    assert!((emitter.total_flux() - PI).abs() < 1e-12);
    let both = Emitter::of(&model.clone().with_two_sided_lights());
    assert!((both.total_flux() - 2.0 * PI).abs() < 1e-12);
    let (mut sum, mut up, count) = (Vector64::ZERO, 0, 20_000_u32);
    for photon in 0..count {
        let photon = u64::from(photon);
        let emission = emitter.emit(&mut PhotonRandom::new(3, photon)).unwrap();
        assert!(emission.origin.z > 0.0 && emission.direction.z > 0.0);
        assert_eq!(emission.weight, [1.0; 3]);
        sum = sum + emission.origin.into();
        let either = both.emit(&mut PhotonRandom::new(3, photon)).unwrap();
        assert!(either.origin.z * either.direction.z > 0.0);
        up += u32::from(either.direction.z > 0.0);
    }
    // A coordinate uniform in 0 to 1 has variance 1/12.
    let sigma = (f64::from(count) / 12.0).sqrt();
    let middle = 0.5 * f64::from(count);
    assert!((sum.x - middle).abs() < 4.0 * sigma && (sum.y - middle).abs() < 4.0 * sigma);
    assert!((f64::from(up) - middle).abs() < 4.0 * 0.5 * f64::from(count).sqrt());
}

#[test]
fn points_are_uniform_in_a_triangle() {
    let mut model = Model::default();
    model.add_object("one", [Triangle::new(Vec3::ZERO, Vec3::X, Vec3::Y)], 0.5);
    let radiance = [17.0, 12.0, 4.0];
    model.emitters.push(FaceLight { triangle: 0, radiance, sides: LitSides::Front });
    let emitter = Emitter::of(&model);
    assert!((emitter.total_flux() - 5.5 * PI).abs() < 1e-12);
    // Of the four similar triangles of half the size, each gets a quarter.
    let (mut counts, count) = ([0_u32; 4], 20_000);
    for photon in 0..count {
        let emission = emitter.emit(&mut PhotonRandom::new(4, photon)).unwrap();
        let Vec3 { x, y, .. } = emission.origin;
        let part = if x > 0.5 {
            0
        } else if y > 0.5 {
            1
        } else {
            2 + usize::from(x + y > 0.5)
        };
        counts[part] += 1;
        let mean = emission.weight.iter().sum::<f32>() / 3.0;
        assert!((mean - 1.0).abs() < 1e-6 && emission.weight[0] > 1.5);
    }
    let sigma = (count as f64 * 0.25 * 0.75).sqrt();
    for part in counts {
        assert!((f64::from(part) - count as f64 / 4.0).abs() < 4.0 * sigma, "{counts:?}");
    }
}
