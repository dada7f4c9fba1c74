//! Reader of glTF 2.0 files, by the crate `gltf`: `.gltf` with its buffers beside it or embedded, and `.glb`.
//!
//! ```text
//! nodes of the scene -> their transforms multiplied in f64 -> primitives of their meshes -> Surface
//!                                                    accessors, checked first ---/
//! ```
//! The crate does not check counts and offsets of accessors, so this module checks them before the crate reads them.
//! Buffers are resolved here, so that the caller's function reads the files beside the document.
//!
//! # Source
//! Khronos Group, *glTF 2.0 Specification*. Textures, skins, morph targets, animations, cameras and punctual lights are
//! ignored. Compressed and quantised meshes are refused by name.

mod accessor;
mod buffers;
mod transform;

use gltf::json::validation::{Error as Problem, Validate};
use gltf::json::{Path, Root};
use gltf::mesh::Mode;
use gltf::{Document, Gltf, Mesh, Node, Primitive};

use super::Companions;
use crate::scene::SceneError;
use crate::scene::surface::{Material, Surface};
use buffers::Buffers;
use transform::Matrix;

/// Reads the bytes of a glTF file. Each node with a mesh is an object, named after the node or else the mesh.
///
/// # Errors
/// [`SceneError::Malformed`], [`SceneError::NoFaces`].
pub fn read(
    bytes: &[u8],
    name: &std::path::Path,
    companions: &Companions,
) -> Result<Surface, SceneError> {
    let mut surface = Surface::new(name);
    // 1. The document and its buffers.
    let Gltf { document, mut blob } = parse(bytes, &surface)?;
    let buffers = Buffers::load(&document, &mut blob, name, companions)
        .map_err(|(place, problem)| surface.malformed(place, problem))?;

    // 2. The nodes, depth first from the roots. The format allows each node one parent.
    let mut left_out = LeftOut::default();
    let mut seen = vec![false; document.nodes().len()];
    let mut waiting: Vec<(Node<'_>, Matrix)> = roots(&document);
    while let Some((node, parent)) = waiting.pop() {
        if std::mem::replace(&mut seen[node.index()], true) {
            return Err(surface.malformed(
                format!("node {}", node.index()),
                "it is the child of two nodes, or below itself",
            ));
        }
        let transform = parent.times(&Matrix::of(&node.transform()));
        if let Some(mesh) = node.mesh() {
            left_out.skins += usize::from(node.skin().is_some());
            let unnamed = format!("node {}", node.index());
            let called = node.name().or(mesh.name()).unwrap_or(&unnamed);
            add_mesh(&mut surface, &mesh, called, &transform, &buffers, &mut left_out)?;
        }
        // The stack returns the last child first, so children are pushed in reverse.
        let first_child = waiting.len();
        waiting.extend(node.children().map(|child| (child, transform)));
        waiting[first_child..].reverse();
    }

    // 3. Warnings about parts of the document that the surface lacks.
    if surface.face_count() == 0 {
        return Err(SceneError::NoFaces {
            file: name.into(),
            vertex_count: surface.vertex_count(),
            ignored_count: left_out.points_and_lines,
            hint: "is there a node with a mesh in its scene?",
        });
    }
    for (count, what) in [
        (left_out.points_and_lines, "primitives of points and lines ignored"),
        (left_out.skins, "meshes with skins are read in their bind pose"),
        (left_out.morphs, "primitives with morph targets are read in their basic shape"),
    ] {
        if count > 0 {
            surface.warn(format_args!("{count} {what}"));
        }
    }
    Ok(surface)
}

/// The bytes of the files beside a document that its buffers are in; 0 if it cannot be read.
pub fn bytes_beside(file: &std::path::Path) -> u64 {
    let document =
        std::fs::read(file).ok().and_then(|bytes| parse(&bytes, &Surface::new(file)).ok());
    document.map_or(0, |gltf| buffers::bytes_beside(&gltf.document, file))
}

/// Counts of parts of a document that are ignored.
#[derive(Default)]
struct LeftOut {
    points_and_lines: usize,
    skins: usize,
    morphs: usize,
}

fn parse(bytes: &[u8], surface: &Surface) -> Result<Gltf, SceneError> {
    // The crate subtracts the heading's size from the length in the heading, which would underflow.
    const HEADING: u32 = 12;
    let length = bytes.get(8..12).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    if bytes.starts_with(b"glTF") && length.is_none_or(|length| length < HEADING) {
        return Err(surface.malformed("heading", "it is cut off"));
    }
    let gltf = Gltf::from_slice_without_validation(bytes)
        .map_err(|error| surface.malformed("JSON", error))?;
    validate(gltf.document.as_json())
        .map_err(|(place, problem)| surface.malformed(place, problem))?;
    Ok(gltf)
}

/// Prefixes of extensions that affect appearance only, not geometry.
const OF_LOOKS: [&str; 6] =
    ["KHR_materials_", "KHR_texture_", "EXT_texture_", "MSFT_texture_", "KHR_lights_", "KHR_xmp"];

/// Checks that every index of the document names an existing element, on which the crate relies.
fn validate(root: &Root) -> Result<(), (String, String)> {
    // The crate's validation reads the accessor of positions before it checks that it exists, so it is checked here
    // first.
    let position = gltf::json::validation::Checked::Valid(gltf::Semantic::Positions);
    for (mesh, primitive) in (0..)
        .zip(&root.meshes)
        .flat_map(|(mesh, of)| of.primitives.iter().map(move |primitive| (mesh, primitive)))
    {
        let accessor = primitive.attributes.get(&position).map(gltf::json::Index::value);
        if accessor.is_some_and(|accessor| accessor >= root.accessors.len()) {
            return Err((
                format!("mesh {mesh}"),
                "it names an accessor that does not exist".into(),
            ));
        }
    }
    let is_of_looks = |name: &String| OF_LOOKS.iter().any(|prefix| name.starts_with(prefix));
    let required = root.extensions_required.iter().filter(|name| !is_of_looks(name));
    let required: Vec<&str> = required.map(String::as_str).collect();
    if !required.is_empty() {
        let problem = format!(
            "{} is not read; write the file again without it, \
             as by `gltf-transform copy in.glb out.glb`",
            required.join(", ")
        );
        return Err(("extensionsRequired".into(), problem));
    }
    let mut first = None;
    root.validate(root, Path::new, &mut |place, kind| {
        let place = place().to_string();
        // Tolerated: missing bounds of accessors, which are not used; missing buffer views, which `accessor` checks;
        // and unsupported extensions, which were checked above.
        let bearable = match kind {
            Problem::Missing => {
                [".min", ".max", ".bufferView"].iter().any(|end| place.ends_with(end))
            }
            Problem::Unsupported => true,
            _ => false,
        };
        if !bearable && first.is_none() {
            first = Some((place, kind.to_string()));
        }
    });
    first.map_or(Ok(()), |(place, kind)| Err((format!("JSON, {place}"), kind)))
}

/// Lists the root nodes of the default scene, else of the first scene. Without scenes, lists all nodes without a
/// parent.
fn roots(document: &Document) -> Vec<(Node<'_>, Matrix)> {
    let scene = document.default_scene().or(document.scenes().next());
    let mut roots: Vec<Node<'_>> = if let Some(scene) = scene {
        scene.nodes().collect()
    } else {
        let mut is_child = vec![false; document.nodes().len()];
        for child in document.nodes().flat_map(|node| node.children()) {
            is_child[child.index()] = true;
        }
        document.nodes().filter(|node| !is_child[node.index()]).collect()
    };
    roots.reverse();
    roots.into_iter().map(|node| (node, Matrix::IDENTITY)).collect()
}

fn add_mesh(
    surface: &mut Surface,
    mesh: &Mesh<'_>,
    name: &str,
    transform: &Matrix,
    buffers: &Buffers<'_>,
    left_out: &mut LeftOut,
) -> Result<(), SceneError> {
    // The object is added at the first primitive with faces.
    let mut object = None;
    for primitive in mesh.primitives() {
        if !matches!(primitive.mode(), Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
            left_out.points_and_lines += 1;
            continue;
        }
        left_out.morphs += usize::from(primitive.morph_targets().next().is_some());
        let object = *object.get_or_insert_with(|| surface.add_object(name));
        surface.begin_part(object, material(&primitive));
        add_primitive(surface, &primitive, transform, buffers).map_err(|problem| {
            let place = format!("mesh {}, primitive {}", mesh.index(), primitive.index());
            surface.malformed(place, problem)
        })?;
    }
    Ok(())
}

fn add_primitive(
    surface: &mut Surface,
    primitive: &Primitive<'_>,
    transform: &Matrix,
    buffers: &Buffers<'_>,
) -> Result<(), String> {
    let positions = primitive.get(&gltf::Semantic::Positions).ok_or("it has no positions")?;
    let first = u32::try_from(surface.vertex_count()).map_err(|_| "too many vertices")?;
    let positions = accessor::positions(positions, buffers)?;
    for position in positions {
        surface.add_vertex(transform.apply(position.map(f64::from)));
    }
    let last = u32::try_from(surface.vertex_count()).map_err(|_| "too many vertices")?;
    let count = last - first;
    let indices: Vec<u32> = match primitive.indices() {
        Some(indices) => accessor::indices(indices, buffers)?,
        None => (0..count).collect(),
    };
    if let Some(index) = indices.iter().find(|&&index| index >= count) {
        return Err(format!("it names vertex {index}, but there are {count} vertices"));
    }
    let mut add = |corners: [u32; 3]| surface.add_face(corners.map(|corner| first + corner));
    match primitive.mode() {
        Mode::TriangleStrip => {
            for (number, corners) in indices.windows(3).enumerate() {
                let [a, b, c] = [corners[0], corners[1], corners[2]];
                add(if number % 2 == 0 { [a, b, c] } else { [b, a, c] });
            }
        }
        Mode::TriangleFan => {
            for corners in indices.get(1..).unwrap_or_default().windows(2) {
                add([indices[0], corners[0], corners[1]]);
            }
        }
        _ => indices.chunks_exact(3).for_each(|corners| add([corners[0], corners[1], corners[2]])),
    }
    Ok(())
}

/// Makes the material: the base colour. With a texture, which may have any colour, it is the default. Emission is
/// ignored, because its unit is not that of a radiance.
fn material(primitive: &Primitive<'_>) -> Material {
    let material = primitive.material();
    let surface = material.pbr_metallic_roughness();
    if material.index().is_none() || surface.base_color_texture().is_some() {
        return Material::DEFAULT;
    }
    let [red, green, blue, _] = surface.base_color_factor();
    Material::of_colour([red, green, blue])
}

#[cfg(test)]
mod tests;
