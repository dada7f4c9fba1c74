//! glTF documents whose accessors, views and buffers disagree.
//!
//! Workload: a document of the right form with any numbers for lengths, offsets, strides and counts, dense and sparse.
//! Random bytes, as in the target `gltf`, seldom change one number of a document and leave the rest in order.
//!
//! Constraints: an error, or a surface that passes [`becomes_triangles`]. What is not checked before it is read ends in
//! a slice out of range.
#![no_main]

use std::fmt;
use std::path::Path;

use arbitrary::Arbitrary;
use arboleda_fuzz::surfaces::becomes_triangles;
use arboleda_host::scene::formats::gltf;
use libfuzzer_sys::fuzz_target;

/// Number as documents have it, small more often than not.
#[derive(Arbitrary, Clone, Copy, Debug)]
enum Number {
    Small(u8),
    Large(u32),
    Largest(u64),
}

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Small(number) => write!(f, "{number}"),
            Self::Large(number) => write!(f, "{number}"),
            Self::Largest(number) => write!(f, "{number}"),
        }
    }
}

#[derive(Arbitrary, Debug)]
struct View {
    offset: Option<Number>,
    length: Number,
    stride: Option<u8>,
}

#[derive(Arbitrary, Debug)]
struct Sparse {
    count: Number,
    index_type: u8,
    indices: (u8, Option<Number>),
    values: (u8, Option<Number>),
}

#[derive(Arbitrary, Debug)]
struct Accessor {
    view: u8,
    offset: Option<Number>,
    count: Number,
    sparse: Option<Sparse>,
}

#[derive(Arbitrary, Debug)]
struct Document {
    /// Length that the document claims for its buffer, if not that of the bytes.
    claimed: Option<Number>,
    views: [View; 3],
    positions: Accessor,
    indices: Option<(u8, Accessor)>,
    mode: u8,
    bytes: Vec<u8>,
}

/// Writes a field, if it is there.
fn field(name: &str, value: Option<impl fmt::Display>) -> String {
    value.map_or(String::new(), |value| format!(r#","{name}":{value}"#))
}

/// Component type of an index: 8, 16 or 32 bits.
fn index_type(choice: u8) -> u32 {
    [5121, 5123, 5125][usize::from(choice % 3)]
}

fn accessor(accessor: &Accessor, element: &str) -> String {
    let Accessor { view, offset, count, sparse } = accessor;
    let sparse = sparse.as_ref().map(|Sparse { count, index_type: kind, indices, values }| {
        format!(
            r#"{{"count":{count},"indices":{{"bufferView":{},"componentType":{}{}}},"values":{{"bufferView":{}{}}}}}"#,
            indices.0 % 3,
            index_type(*kind),
            field("byteOffset", indices.1),
            values.0 % 3,
            field("byteOffset", values.1),
        )
    });
    let (offset, sparse) = (field("byteOffset", *offset), field("sparse", sparse));
    format!(r#"{{"bufferView":{}{offset},"count":{count}{sparse},{element}}}"#, view % 3)
}

fn text(document: &Document) -> String {
    let Document { claimed, views, positions, indices, mode, bytes } = document;
    let views = views.each_ref().map(|View { offset, length, stride }| {
        let (offset, stride) = (field("byteOffset", *offset), field("byteStride", *stride));
        format!(r#"{{"buffer":0,"byteLength":{length}{offset}{stride}}}"#)
    });
    let mut accessors = vec![accessor(
        positions,
        r#""componentType":5126,"type":"VEC3","min":[0,0,0],"max":[1,1,1]"#,
    )];
    if let Some((kind, indices)) = indices {
        let element = format!(r#""componentType":{},"type":"SCALAR""#, index_type(*kind));
        accessors.push(accessor(indices, &element));
    }
    let length = claimed.map_or(bytes.len().to_string(), |claimed| claimed.to_string());
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}{},"mode":{}}}]}}],"accessors":[{}],"bufferViews":[{}],"buffers":[{{"uri":"a.bin","byteLength":{length}}}]}}"#,
        field("indices", indices.as_ref().map(|_| 1)),
        mode % 7,
        accessors.join(","),
        views.join(","),
    )
}

fuzz_target!(|document: Document| {
    let text = text(&document);
    let companions = |_: &Path| Ok(document.bytes.clone());
    if let Ok(surface) = gltf::read(text.as_bytes(), Path::new("input.gltf"), &companions) {
        becomes_triangles(&surface);
    }
});
