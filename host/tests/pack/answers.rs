//! Tests of `pack`, and of `cast` and `inspect` on the files that it writes.

use std::fs;

use crate::program::{failure, folder, run_in, success, write_rays};

#[test]
fn a_packed_index_answers_as_a_built_one() {
    let folder = folder();
    let at = folder.path();
    let rays: Vec<[f32; 6]> = (0..500)
        .map(|number| {
            let x = number as f32 * 0.07 - 17.0;
            [x, -x * 0.3, 9.0, 0.1, x * 0.01, -1.0]
        })
        .collect();
    write_rays(&at.join("rays.npy"), &rays);
    let cast = |scene: &[&str], more: &[&str]| {
        let line = [&["cast"], scene, &["--rays", "rays.npy", "--hits", "hits.npy"], more].concat();
        success(&run_in(at, &line));
        fs::read(at.join("hits.npy")).unwrap()
    };
    for name in arboleda_host::kind_names() {
        let line = ["pack", "--scene", "fig4b", "--index", name, "-o", "a.arb"];
        let (packed, _) = success(&run_in(at, &line));
        let (inspected, _) = success(&run_in(at, &["inspect", "a.arb"]));
        assert_eq!(packed, inspected);
        assert!(packed.contains(name) && packed.contains("30,560 triangles"), "{packed}");
        let hash = blake3::hash(&fs::read(at.join("a.arb")).unwrap());
        assert!(packed.contains(&format!("BLAKE3 {hash}")), "{packed}");
        let scene = ["--scene", "fig4b", "--index", "wide-bvh"];
        for query in ["closest", "occluded", "all"] {
            let more = ["--query", query];
            assert_eq!(cast(&["a.arb"], &more), cast(&scene, &more), "{name} {query}");
        }
    }
}

#[test]
fn what_an_index_cannot_do_is_said() {
    let folder = folder();
    let at = folder.path();
    success(&run_in(at, &["pack", "--scene", "fig2", "--index", "bvh", "--out", "a.arb"]));
    let bytes = fs::read(at.join("a.arb")).unwrap();
    fs::write(at.join("torn.arb"), &bytes[..bytes.len() - 64]).unwrap();
    fs::write(at.join("text.arb"), "v 0 0 0").unwrap();
    fs::write(at.join("renamed.obj"), &bytes).unwrap();
    write_rays(&at.join("rays.npy"), &[[0.0_f32, 0.0, 9.0, 0.0, 0.0, -1.0]]);
    for (line, problem) in [
        ("inspect torn.arb", "torn.arb: the bytes of the index are cut short"),
        ("inspect text.arb", "text.arb: "),
        ("inspect none.arb", "none.arb: cannot be read"),
        ("inspect a.arb --picture a.png", "not of an index"),
        ("inspect renamed.obj", "it is an index"),
        ("shoot a.arb", "it is an index"),
        ("pack a.arb -o b.arb", "it is an index"),
        ("pack --scene fig2 --index all -o b.arb", "--index all"),
        ("pack --scene fig2 -o b.bin", "must end in .arb"),
        ("cast a.arb --rays rays.npy --points p.npy", "need the scene"),
        ("cast a.arb --rays rays.npy --hits h.npy --origin 1,2,3", "is an index already"),
        ("inspect a.arb --level 3", "is an index already"),
        ("cast a.arb --rays rays.npy --hits h.npy --index octree", "is the index bvh"),
    ] {
        let said = failure(&run_in(at, &line.split(' ').collect::<Vec<_>>()));
        assert!(said.contains(problem), "{line}: {said}");
    }
    success(&run_in(
        at,
        &["cast", "a.arb", "--rays", "rays.npy", "--hits", "h.npy", "--index", "bvh"],
    ));
}
