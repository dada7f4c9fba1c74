//! Random material files, and files of photon maps of the scene that has those materials.
//!
//! Workload: the input up to the first NUL byte is the material file of a box whose faces have one material each; what
//! follows replaces a part of the bytes of a good photon map. Its first two bytes tell where, modulo the map's length;
//! without a third byte the map is cut off there.
//!
//! Constraints: the scene's lights have a finite flux of at least 0, photons end, and the good map is read as it was
//! written. The other map is refused or answers searches and estimates with finite numbers. Memory in proportion to the
//! input, which libFuzzer's limits check.
#![no_main]

use std::path::Path;

use arboleda::{IndexKind, Options, OwnedIndex, Vec3};
use arboleda_host::density::{
    Bounces, Estimate, Facing, Gather, Kernel, MapEstimator, Neighbourhood, PhotonMap,
    PhotonSource, Receiver,
};
use arboleda_host::photon::Emitter;
use arboleda_host::scene::formats::obj;
use arboleda_host::scene::{Model, Origin, UpAxis};
use libfuzzer_sys::fuzz_target;

/// A box that is open in front, with a sliver without area.
const SCENE: &[u8] = b"mtllib m.mtl
v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 0 0 2\nv 2 0 2\nv 2 2 2\nv 0 2 2
usemtl a\nf 1 2 3 4
usemtl b\nf 8 7 6 5
usemtl c\nf 1 4 8 5
usemtl d\nf 2 6 7 3
usemtl e\nf 4 3 7 8
usemtl f\nf 1 2 1
";
const PHOTONS: u64 = 64;

fuzz_target!(|bytes: &[u8]| {
    let split = bytes.iter().position(|&byte| byte == 0).unwrap_or(bytes.len());
    let (materials, damage) = bytes.split_at(split);
    let companions = |_: &Path| Ok(materials.to_vec());
    // The box is in order, so only its materials can be an error.
    let Ok(surface) = obj::read(SCENE, Path::new("box.obj"), &companions) else { return };
    let model = surface.place(Origin::Unchanged).expect("finite corners").model;
    let model = model.with_default_light(UpAxis::Z).with_two_sided_lights();
    assert!(model.reflectance.iter().all(|share| (0.0..=1.0).contains(share)));
    assert!(model.colours.as_flattened().iter().all(|share| (0.0..=1.0).contains(share)));
    let flux = Emitter::of(&model).total_flux();
    assert!(flux >= 0.0 && flux.is_finite(), "{flux}");

    let map = shot(&model);
    let balance = map.balance();
    assert_eq!(balance.emitted, balance.ended());
    let mut file = Vec::new();
    map.write(&mut file, &model).expect("memory");
    let read = PhotonMap::read(&file, Path::new("map"), &model).expect("it was just written");
    assert_eq!((read.len(), read.balance()), (map.len(), balance));
    ask(&read);

    if let [_, low, high, rest @ ..] = damage {
        let at = usize::from(u16::from_le_bytes([*low, *high])) % file.len();
        if rest.is_empty() {
            file.truncate(at);
        }
        for (byte, damaged) in file[at..].iter_mut().zip(rest) {
            *byte = *damaged;
        }
        if let Ok(map) = PhotonMap::read(&file, Path::new("map"), &model) {
            ask(&map);
        }
    }
});

fn shot(model: &Model) -> PhotonMap {
    let built = OwnedIndex::build(IndexKind::Linear, &model.scene(), &Options::DEFAULT);
    let built = built.expect("a few finite triangles");
    let index = built.index();
    let source = PhotonSource {
        model,
        index: index.as_ray_index(),
        photons: 0..PHOTONS,
        seed: 1,
        max_bounces: 8,
        bounces: Bounces::All,
    };
    PhotonMap::shoot(&source, &|_| {}).expect("a few hits")
}

/// Searches a map, and estimates by it.
fn ask(map: &PhotonMap) {
    let mut found = Vec::new();
    for (position, normal) in
        [(Vec3::ONE, Vec3::Z), (Vec3::new(1.0, 1.0, 0.0), Vec3::Z), (Vec3::X, Vec3::ONE)]
    {
        let receiver = &Receiver::new(position, normal).expect("a valid receiver");
        for gather in
            [Gather::Nearest { k: 5, max_radius: 9.0 }, Gather::Within { radius: f32::MAX }]
        {
            for kernel in [Kernel::Constant, Kernel::Epanechnikov] {
                let estimator =
                    MapEstimator { gather, facing: Facing::within_degrees(60.0), kernel };
                let estimate = estimator.estimate(map, receiver, None, &mut found);
                let Estimate { irradiance, count, radius, standard_error } = estimate;
                let all = irradiance.into_iter().chain([radius, standard_error]);
                assert!(all.into_iter().all(|x| x >= 0.0 && x.is_finite()), "{estimate:?}");
                assert!(count as usize <= map.len());
            }
        }
        let all = map.within(&Neighbourhood { receiver, facing: None, radius: 1e9 });
        assert!(all.len() <= map.len() && all.is_sorted());
    }
}
