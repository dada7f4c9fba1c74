//! Column of a model: a value for each triangle, in memory or in a file that is mapped.

use std::fmt;
use std::marker::PhantomData;
use std::ops::{Deref, DerefMut, Range};
use std::slice;
use std::sync::Arc;

use bytemuck::Pod;

use crate::files::MappedFile;

/// Values in the order of triangles. It is used as a slice.
///
/// The values are those of a vector, or lie in a file that is mapped, so that processes share them. Those of a file are
/// copied when they are changed.
///
/// # Examples
/// ```
/// use arboleda_host::scene::Column;
///
/// let mut column = Column::from(vec![0.5, 0.25]);
/// column.to_mut().push(1.0);
/// assert_eq!(column[1..], [0.25, 1.0]);
/// ```
#[derive(Clone)]
pub struct Column<T>(Values<T>);

#[derive(Clone)]
enum Values<T> {
    Own(Vec<T>),
    Mapped { file: Arc<MappedFile>, bytes: Range<usize>, of: PhantomData<T> },
}

impl<T: Pod> Column<T> {
    /// The values that lie in some bytes of a file, in this machine's byte order; `None` if the file has no such bytes,
    /// or if they are no whole number of values, or not aligned for them.
    pub(crate) fn mapped(file: &Arc<MappedFile>, bytes: Range<usize>) -> Option<Self> {
        bytemuck::try_cast_slice::<u8, T>(file.bytes().get(bytes.clone())?).ok()?;
        Some(Self(Values::Mapped { file: Arc::clone(file), bytes, of: PhantomData }))
    }

    /// Tells whether the values lie in a file.
    pub(crate) fn is_mapped(&self) -> bool {
        matches!(self.0, Values::Mapped { .. })
    }

    /// Returns the values.
    #[inline]
    pub fn as_slice(&self) -> &[T] {
        match &self.0 {
            Values::Own(values) => values,
            // The bytes were cast before.
            Values::Mapped { file, bytes, .. } => file
                .bytes()
                .get(bytes.clone())
                .and_then(|bytes| bytemuck::try_cast_slice(bytes).ok())
                .unwrap_or_default(),
        }
    }

    /// Returns the values as a vector of its own, to change them.
    pub fn to_mut(&mut self) -> &mut Vec<T> {
        if self.is_mapped() {
            self.0 = Values::Own(self.to_vec());
        }
        match &mut self.0 {
            Values::Own(values) => values,
            Values::Mapped { .. } => unreachable!("the values were copied"),
        }
    }
}

impl<T> From<Vec<T>> for Column<T> {
    fn from(values: Vec<T>) -> Self {
        Self(Values::Own(values))
    }
}

impl<T> FromIterator<T> for Column<T> {
    fn from_iter<I: IntoIterator<Item = T>>(values: I) -> Self {
        Self::from(Vec::from_iter(values))
    }
}

impl<T> Default for Column<T> {
    fn default() -> Self {
        Self::from(Vec::new())
    }
}

impl<T: Pod> Deref for Column<T> {
    type Target = [T];

    #[inline]
    fn deref(&self) -> &[T] {
        self.as_slice()
    }
}

impl<T: Pod> DerefMut for Column<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        self.to_mut()
    }
}

impl<'c, T: Pod> IntoIterator for &'c Column<T> {
    type Item = &'c T;
    type IntoIter = slice::Iter<'c, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl<'c, T: Pod> IntoIterator for &'c mut Column<T> {
    type Item = &'c mut T;
    type IntoIter = slice::IterMut<'c, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter_mut()
    }
}

impl<T: Pod + fmt::Debug> fmt::Debug for Column<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.as_slice().fmt(f)
    }
}

impl<T: Pod + PartialEq> PartialEq for Column<T> {
    fn eq(&self, other: &Self) -> bool {
        self.as_slice() == other.as_slice()
    }
}

impl<T: Pod + PartialEq, const COUNT: usize> PartialEq<[T; COUNT]> for Column<T> {
    fn eq(&self, other: &[T; COUNT]) -> bool {
        self.as_slice() == other
    }
}

impl<T: Pod + PartialEq> PartialEq<Vec<T>> for Column<T> {
    fn eq(&self, other: &Vec<T>) -> bool {
        self.as_slice() == other
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_of_a_file_are_shared_until_they_are_changed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("values");
        std::fs::write(&path, bytemuck::cast_slice(&[1_u32, 2, 3, 4])).unwrap();
        let file = Arc::new(MappedFile::open(&path).unwrap());
        let column = Column::<u32>::mapped(&file, 4..16).unwrap();
        assert_eq!(column, [2, 3, 4]);
        assert_eq!(column.as_ptr().addr(), file.bytes().as_ptr().addr() + 4);
        let mut changed = column.clone();
        assert_eq!(changed.as_ptr(), column.as_ptr());
        changed[0] = 7;
        assert_eq!((&column[..], &changed[..]), (&[2, 3, 4][..], &[7, 3, 4][..]));
        assert!(column.is_mapped() && !changed.is_mapped());
    }

    #[test]
    fn bytes_that_are_no_values_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("values");
        std::fs::write(&path, [0; 16]).unwrap();
        let file = Arc::new(MappedFile::open(&path).unwrap());
        for bytes in [0..17, 0..3, 1..5, 20..24, usize::MAX - 3..usize::MAX] {
            assert!(Column::<u32>::mapped(&file, bytes.clone()).is_none(), "{bytes:?}");
        }
        assert!(Column::<u32>::mapped(&file, 16..16).is_some_and(|none| none.is_empty()));
    }
}
