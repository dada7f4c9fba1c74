//! Tests that are the same for all formats.

use super::*;

/// Reads companion files as if there were none.
pub(super) fn nothing_beside(_: &Path) -> io::Result<Vec<u8>> {
    Err(io::ErrorKind::NotFound.into())
}

/// Calls `read` with every prefix of a file, and with `count` copies in which one to three bytes are changed.
pub(super) fn for_each_damaged(good: &[u8], count: usize, mut read: impl FnMut(&[u8])) {
    let mut state = 1_u64;
    let mut draw = |below: usize| {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    for end in 0..good.len() {
        read(&good[..end]);
    }
    for _ in 0..count {
        let mut bytes = good.to_vec();
        for _ in 0..=draw(3) {
            let offset = draw(bytes.len());
            bytes[offset] = if draw(2) == 0 { b'0' + draw(10) as u8 } else { draw(256) as u8 };
        }
        read(&bytes);
    }
}

fn place(bytes: &[u8], name: &str) -> Result<Model, SceneError> {
    let surface = read(bytes, Path::new(name), &nothing_beside)?;
    surface.place(Origin::Unchanged).map(|import| import.model)
}

/// Makes files with the same triangle in each format, with their names.
fn samples() -> Vec<(&'static str, Vec<u8>)> {
    let mut stl = vec![b' '; 80];
    stl.extend(1_u32.to_le_bytes());
    let numbers = [0.0_f32, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    stl.extend(numbers.iter().flat_map(|x| x.to_le_bytes()));
    stl.extend([0; 2]);
    let ply = |format: &str| {
        format!(
            "ply\nformat {format} 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
             property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
        )
        .into_bytes()
    };
    let mut binary_ply = ply("binary_little_endian");
    binary_ply.extend(numbers[3..].iter().flat_map(|x| x.to_le_bytes()));
    binary_ply.push(3);
    binary_ply.extend([0_i32, 1, 2].iter().flat_map(|x| x.to_le_bytes()));
    let gltf = r#"{"asset":{"version":"2.0"},"nodes":[{"mesh":0}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}],
        "bufferViews":[{"buffer":0,"byteLength":36}],
        "buffers":[{"byteLength":36,"uri":"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]}"#;
    vec![
        ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".to_vec()),
        ("a.ply", [ply("ascii"), b"0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n".to_vec()].concat()),
        ("a.ply", binary_ply),
        (
            "a.stl",
            b"solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n\
                    endloop\nendfacet\nendsolid\n"
                .to_vec(),
        ),
        ("a.stl", stl),
        ("a.gltf", gltf.as_bytes().to_vec()),
    ]
}

#[test]
fn all_formats_give_the_same_triangle_by_ending_or_first_bytes() {
    let expected =
        [arboleda::Triangle::new(arboleda::Vec3::ZERO, arboleda::Vec3::X, arboleda::Vec3::Y)];
    for (name, bytes) in samples() {
        let model = place(&bytes, name).unwrap();
        assert_eq!(
            (model.name.as_str(), model.triangles.as_slice()),
            ("a", &expected[..]),
            "{name}"
        );
        assert_eq!(place(&bytes, &name.to_ascii_uppercase()).unwrap().triangles, expected);
        assert_eq!(
            place(&bytes, "download").unwrap().triangles,
            expected,
            "{name} without an ending"
        );
    }
}

#[test]
fn other_files_are_named_with_the_cure() {
    for (bytes, message) in [
        (&b"\x1f\x8b\x08"[..], "a.obj: it is compressed by gzip; unpack it first, with `gunzip`"),
        (b"PK\x03\x04", "a.obj: it is a ZIP archive; unpack it first, with `unzip`"),
        (
            b"\xff\xfev\0 \0",
            "a.obj: it is text in UTF-16; save it as UTF-8, as by `iconv -f UTF-16 -t UTF-8`",
        ),
        (b"\x93NUMPY\x01\0", "a.obj: it is a NumPy array; rays are given to `cast` by `--rays`"),
    ] {
        assert_eq!(place(bytes, "a.obj").unwrap_err().to_string(), message);
    }
    let error = load(Path::new("no-such-file.obj"), Origin::Unchanged).unwrap_err();
    // The message leaves the cause to the source, so the cause is printed once.
    assert_eq!(error.to_string(), "cannot read no-such-file.obj");
    assert!(std::error::Error::source(&error).is_some());
}

#[test]
fn damaged_files_are_errors_or_scenes_but_never_panics() {
    for (name, good) in samples() {
        for_each_damaged(&good, 5_000, |bytes| drop(place(bytes, name)));
    }
}

#[cfg(target_os = "linux")]
#[test]
fn devices_that_a_scene_names_are_not_read() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        fs::write(&path, text).unwrap();
        path
    };
    let obj = write("a.obj", "mtllib /dev/zero\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let import = read_file(&obj).unwrap().place(Origin::Unchanged).unwrap();
    let expected = "cannot read the material file /dev/zero: it is not a regular file";
    assert!(import.warnings.iter().any(|it| it.contains(expected)), "{:?}", import.warnings);
    let gltf = write(
        "a.gltf",
        r#"{"asset":{"version":"2.0"},"buffers":[{"byteLength":36,"uri":"/dev/zero"}]}"#,
    );
    let error = read_file(&gltf).err().unwrap().to_string();
    assert!(error.ends_with("cannot read /dev/zero: it is not a regular file"), "{error}");
}
