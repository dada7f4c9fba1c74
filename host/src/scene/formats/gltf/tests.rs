//! Tests of documents with embedded buffers, with buffers beside them, and in binary files.

use std::path::Path;

use super::*;
use crate::scene::formats::tests::{for_each_damaged, nothing_beside};
use crate::scene::{Import, Model, Origin};

fn import(bytes: &[u8]) -> Result<Import, SceneError> {
    read(bytes, Path::new("test.gltf"), &nothing_beside)?.place(Origin::Unchanged)
}

fn refusal(text: &str) -> String {
    let error = import(text.as_bytes()).unwrap_err().to_string();
    error.strip_prefix("test.gltf, ").unwrap_or(&error).to_owned()
}

/// Makes the buffer of a square of two triangles: four positions (48 bytes) and six 16-bit indices (12 bytes).
fn buffer() -> Vec<u8> {
    let positions = [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let mut bytes: Vec<u8> = positions.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    bytes.extend([0_u16, 1, 2, 0, 2, 3].iter().flat_map(|index| index.to_le_bytes()));
    bytes
}

/// Makes a document with a node turned by 90 degrees about z, inside a node moved by 10 along x.
fn document(source: &str) -> String {
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[1,2]}}],
        "nodes":[{{"mesh":0,"name":"inner","rotation":[0,0,0.70710678,0.70710678],"scale":[2,2,2]}},
                 {{"children":[0],"translation":[10,0,0]}},
                 {{"mesh":0,"matrix":[1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,5,1]}}],
        "meshes":[{{"name":"square","primitives":[
            {{"attributes":{{"POSITION":0}},"indices":1,"material":0}},
            {{"attributes":{{"POSITION":0}},"mode":0}}]}}],
        "materials":[{{"pbrMetallicRoughness":{{"baseColorFactor":[0.9,0.6,0.3,1]}}}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}},
                     {{"bufferView":1,"componentType":5123,"count":6,"type":"SCALAR"}}],
        "bufferViews":[{{"buffer":0,"byteLength":48}},{{"buffer":0,"byteOffset":48,"byteLength":12}}],
        "buffers":[{{{source}"byteLength":60}}]}}"#
    )
}

fn embedded() -> String {
    use base64::Engine;
    let text = base64::engine::general_purpose::STANDARD.encode(buffer());
    document(&format!(r#""uri":"data:application/octet-stream;base64,{text}","#))
}

fn binary(json: &str, buffer: &[u8]) -> Vec<u8> {
    let mut json = json.as_bytes().to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend(((12 + 8 + json.len() + 8 + buffer.len()) as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", json.as_slice()), (b"BIN\0", buffer)] {
        bytes.extend((chunk.len() as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(chunk);
    }
    bytes
}

fn check(model: &Model) {
    assert_eq!(model.object_names, ["inner", "square"]);
    assert_eq!(model.objects, [0, 0, 1, 1]);
    assert_eq!(model.reflectance, [0.6; 4]);
    let near = |a: arboleda::Vec3, b: [f32; 3]| (a - arboleda::Vec3::from_array(b)).length() < 1e-6;
    // The corner (1, 1, 0) doubled, turned and moved; then its copy lifted by 5.
    assert!(near(model.triangles[0].c, [8.0, 2.0, 0.0]), "{:?}", model.triangles[0]);
    assert!(near(model.triangles[2].c, [1.0, 1.0, 5.0]));
}

#[test]
fn buffers_inside_beside_and_binary() {
    let inside = import(embedded().as_bytes()).unwrap();
    check(&inside.model);
    assert_eq!(inside.warnings, ["test.gltf: 2 primitives of points and lines ignored"]);

    check(&import(&binary(&document(""), &buffer())).unwrap().model);

    let text = document(r#""uri":"my%20buffer.bin","#);
    let beside = |path: &Path| {
        if path == Path::new("folder/my buffer.bin") { Ok(buffer()) } else { nothing_beside(path) }
    };
    let surface = read(text.as_bytes(), Path::new("folder/a.gltf"), &beside).unwrap();
    check(&surface.place(Origin::Unchanged).unwrap().model);
    assert!(
        refusal(&text).starts_with("buffer 0: cannot read my buffer.bin: "),
        "{}",
        refusal(&text)
    );
}

#[test]
fn strips_and_fans() {
    let triangles = |mode: u32| {
        let text = embedded().replace(r#""indices":1,"#, &format!(r#""mode":{mode},"#));
        let model = import(text.as_bytes()).unwrap().model;
        let corners = [model.triangles[2], model.triangles[3]];
        corners.map(|triangle| {
            [triangle.a, triangle.b, triangle.c].map(|at| (at.x + 2.0 * at.y) as u32)
        })
    };
    // Corners are identified by x + 2 y, which is 0, 1, 3, 2 for the corners 0 to 3.
    assert_eq!(triangles(5), [[0, 1, 3], [3, 1, 2]]);
    assert_eq!(triangles(6), [[0, 1, 3], [0, 3, 2]]);
}

#[test]
fn transforms_are_applied_in_64_bits() {
    // A city far from the origin: the node's translation fits 32 bits, and `--origin` subtracts it again.
    let text =
        embedded().replace("[10,0,0]", "[4649776,500000,0]").replace("[2,2,2]", "[0.1,0.1,0.1]");
    let surface = read(text.as_bytes(), Path::new("a.gltf"), &nothing_beside).unwrap();
    let model = surface.place(Origin::At([4_649_776.0, 500_000.0, 0.0])).unwrap().model;
    let corner = model.triangles[0].c;
    assert!((corner - arboleda::Vec3::new(-0.1, 0.1, 0.0)).length() < 1e-7, "{corner}");
}

#[test]
fn what_is_not_read_is_named() {
    let draco = r#""extensionsUsed":["KHR_draco_mesh_compression"],
        "extensionsRequired":["KHR_draco_mesh_compression"],"asset""#;
    assert!(
        refusal(&embedded().replace(r#""asset""#, draco))
            .starts_with("extensionsRequired: KHR_draco_mesh_compression is not read; write")
    );
    for (from, to, message) in [
        (
            r#""bufferView":0,"componentType""#,
            r#""componentType""#,
            "mesh 0, primitive 0: accessor 0 has no buffer view; compressed meshes (Draco, meshopt) are not read",
        ),
        ("5126", "5122", "mesh 0, primitive 0: its positions are not three 32-bit floats each"),
        ("5123", "5126", "mesh 0, primitive 0: its indices are not unsigned numbers"),
        (
            r#""count":6"#,
            r#""count":4000000000"#,
            "mesh 0, primitive 0: accessor 1 reaches beyond its buffer view",
        ),
        (
            r#""count":4,"#,
            r#""count":3,"#,
            "mesh 0, primitive 0: it names vertex 3, but there are 3 vertices",
        ),
        (
            r#""byteLength":60"#,
            r#""byteLength":99"#,
            "buffer 0: it is cut off: it needs 99 bytes, but has 60",
        ),
        (
            r#""byteLength":12}"#,
            r#""byteLength":14}"#,
            "mesh 0, primitive 0: accessor 1 reaches beyond",
        ),
        (
            r#""children":[0]"#,
            r#""children":[0,1]"#,
            "node 1: it is the child of two nodes, or below itself",
        ),
        (r#""nodes":[1,2]"#, r#""nodes":[1,77]"#, "JSON, scenes[0].nodes[1]: "),
        (r#""POSITION":0"#, r#""POSITION":9"#, "mesh 0: it names an accessor that does not exist"),
        (r#""scene":0"#, r#""scene":"#, "JSON: "),
    ] {
        let text = embedded().replace(from, to);
        assert!(refusal(&text).starts_with(message), "{}", refusal(&text));
    }
    assert!(
        refusal(r#"{"asset":{"version":"2.0"}}"#)
            .contains("no faces of three or more corners found")
    );
}

#[test]
fn what_does_not_matter_to_rays_is_let_pass() {
    let looks = r#""extensionsUsed":["KHR_materials_unlit"],"extensionsRequired":["KHR_materials_unlit"],"asset""#;
    let text =
        embedded().replace(r#","min":[0,0,0],"max":[1,1,0]"#, "").replace(r#""asset""#, looks);
    check(&import(text.as_bytes()).unwrap().model);
}

#[test]
fn damaged_files_are_errors_or_scenes_but_never_panics() {
    let good = binary(&document(""), &buffer());
    for_each_damaged(&good, 20_000, |bytes| drop(import(bytes)));
}
