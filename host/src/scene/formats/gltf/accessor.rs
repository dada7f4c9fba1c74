//! Accessors: numbers in buffers, whose bounds are checked before they are read.

use gltf::Accessor;
use gltf::accessor::{DataType, Dimensions, Item, Iter};
use gltf::buffer::View;

use super::buffers::Buffers;

/// Reads positions: three `f32` each.
pub(super) fn positions(
    accessor: Accessor<'_>,
    buffers: &Buffers<'_>,
) -> Result<Vec<[f32; 3]>, String> {
    if accessor.data_type() != DataType::F32 || accessor.dimensions() != Dimensions::Vec3 {
        return Err(
            "its positions are not three 32-bit floats each; quantised meshes are not read".into(),
        );
    }
    read(accessor, buffers)
}

/// Reads indices of 8, 16 or 32 bits.
pub(super) fn indices(accessor: Accessor<'_>, buffers: &Buffers<'_>) -> Result<Vec<u32>, String> {
    let widened = |indices: Vec<u16>| indices.into_iter().map(u32::from).collect();
    match (accessor.data_type(), accessor.dimensions()) {
        (DataType::U8, Dimensions::Scalar) => {
            let indices: Vec<u8> = read(accessor, buffers)?;
            Ok(indices.into_iter().map(u32::from).collect())
        }
        (DataType::U16, Dimensions::Scalar) => read(accessor, buffers).map(widened),
        (DataType::U32, Dimensions::Scalar) => read(accessor, buffers),
        _ => Err("its indices are not unsigned numbers of 8, 16 or 32 bits".into()),
    }
}

fn read<T: Item>(accessor: Accessor<'_>, buffers: &Buffers<'_>) -> Result<Vec<T>, String> {
    let number = accessor.index();
    if accessor.count() == 0 {
        return Ok(Vec::new());
    }
    // The ranges of all numbers are checked first, so a count is never larger than the file.
    let view = accessor.view().ok_or_else(|| {
        let cause = match accessor.sparse() {
            Some(_) => "numbers that are all sparse",
            None => "compressed meshes (Draco, meshopt)",
        };
        format!("accessor {number} has no buffer view; {cause} are not read")
    })?;
    check(&view, accessor.offset(), accessor.count(), size_of::<T>(), buffers)
        .ok_or_else(|| format!("accessor {number} reaches beyond its buffer view"))?;
    if let Some(sparse) = accessor.sparse() {
        let (indices, values, count) = (sparse.indices(), sparse.values(), sparse.count());
        let index_size = indices.index_type().size();
        (count > 0)
            .then(|| check(&indices.view(), indices.offset(), count, index_size, buffers))
            .flatten()
            .and_then(|()| check(&values.view(), values.offset(), count, size_of::<T>(), buffers))
            .ok_or_else(|| {
                format!("the sparse part of accessor {number} reaches beyond its buffer view")
            })?;
    }
    let numbers = Iter::new(accessor, |buffer| buffers.get(&buffer));
    numbers
        .map(Iterator::collect)
        .ok_or_else(|| format!("accessor {number} reaches beyond its buffer"))
}

/// Checks that `count` elements of `size` bytes lie in the view and the view in its buffer; `None` if they do not.
fn check(
    view: &View<'_>,
    offset: usize,
    count: usize,
    size: usize,
    buffers: &Buffers<'_>,
) -> Option<()> {
    let stride = view.stride().unwrap_or(size);
    let end = stride.checked_mul(count - 1)?.checked_add(size)?.checked_add(offset)?;
    let view_end = view.offset().checked_add(view.length())?;
    let buffer = buffers.get(&view.buffer())?;
    (stride >= size && end <= view.length() && view_end <= buffer.len()).then_some(())
}
