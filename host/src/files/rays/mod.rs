//! Rays from `NumPy` files.
//!
//! Each row is a ray: origin, direction, and optionally `t_min` and `t_max`. The scene's origin is subtracted from the
//! ray's origin in `f64`, before `float64` values are rounded.

mod error;

use std::path::Path;
use std::{fs, io};

use arboleda::{Ray, RayError, Vec3};
use npyz::{DType, NpyFile, NpyHeader, Order, TypeChar};

use crate::files::signature::Signature;
pub use error::{RaysError, RaysProblem};

/// Columns that a file may have, and their names for messages.
#[derive(Clone, Copy, Debug)]
pub struct Layout {
    columns: &'static [u64],
    /// What a row is: "rays".
    name: &'static str,
    /// Shapes that are read: "(N, 6) or (N, 8)".
    shapes: &'static str,
}

/// Rays: origin, direction, and optionally `t_min` and `t_max`.
pub const RAYS: Layout = Layout { columns: &[6, 8], name: "rays", shapes: "(N, 6) or (N, 8)" };
/// Points: position, normal.
pub const POINTS: Layout = Layout { columns: &[6], name: "points", shapes: "(N, 6)" };

/// Most bytes of a header, which is `NumPy`'s limit too.
const LONGEST_HEADER: usize = 10_000;
/// Most opening brackets in a header. A valid header has two: that of the dictionary and that of the shape.
const MOST_BRACKETS: usize = 16;
/// Most brackets inside each other: the dictionary, a list of fields, a field, its shape. The crate `npyz` takes several
/// times as long for each.
const MOST_NESTED: usize = 4;

/// Numbers of a file of rays, before rounding.
#[derive(Clone, Debug, PartialEq)]
pub struct RayTable {
    columns: usize,
    values: Floats,
}

#[derive(Clone, Debug, PartialEq)]
enum Floats {
    Single(Vec<f32>),
    Double(Vec<f64>),
}

/// Loads a file of rays.
///
/// # Errors
/// [`RaysProblem::Unreadable`], and those of [`read`].
pub fn load(path: &Path) -> Result<RayTable, RaysError> {
    load_as(path, &RAYS)
}

/// Loads a file of a layout.
///
/// # Errors
/// [`RaysProblem::Unreadable`], and those of [`read`].
pub fn load_as(path: &Path, layout: &Layout) -> Result<RayTable, RaysError> {
    let bytes = fs::read(path).map_err(RaysProblem::Unreadable);
    bytes
        .and_then(|bytes| read_as(&bytes, layout))
        .map_err(|problem| RaysError { file: path.into(), problem })
}

/// Reads the bytes of a `.npy` file of rays: float32 or float64, of shape (N, 6) or (N, 8).
///
/// # Errors
/// [`RaysProblem`], for anything else.
pub fn read(bytes: &[u8]) -> Result<RayTable, RaysProblem> {
    read_as(bytes, &RAYS)
}

/// Reads the bytes of a `.npy` file of a layout: float32 or float64.
///
/// # Errors
/// [`RaysProblem`], for anything else.
pub fn read_as(bytes: &[u8], layout: &Layout) -> Result<RayTable, RaysProblem> {
    let name = layout.name;
    // 1. Checks that the crate `npyz` leaves to its callers.
    match Signature::of(bytes) {
        Some(Signature::Npy) => {}
        Some(signature) => {
            let cure = match signature {
                Signature::Gzip => "unpack it first, with `gunzip`",
                Signature::Zip => "if it is .npz, save the one array with numpy.save instead",
                _ => "save the numbers with numpy.save",
            };
            return Err(RaysProblem::Foreign { kind: signature.kind(), cure });
        }
        None => return Err(RaysProblem::NotNpy { name }),
    }
    check_header(bytes)?;

    // 2. The header.
    let mut rest = bytes;
    let header = NpyHeader::from_reader(&mut rest)
        .map_err(|error: io::Error| RaysProblem::Header(error.to_string()))?;
    let shape = header.shape().to_vec();
    let wrong = |shape| Err(RaysProblem::Shape { shape, name, shapes: layout.shapes });
    let [count, columns] = shape[..] else { return wrong(shape) };
    if !layout.columns.contains(&columns) {
        return wrong(shape);
    }
    if header.order() == Order::Fortran && count > 1 {
        return Err(RaysProblem::FortranOrder);
    }
    let bytes_each = match header.dtype() {
        DType::Plain(kind) if kind.type_char() == TypeChar::Float => kind.size_field(),
        _ => 0,
    };
    if !matches!(bytes_each, 4 | 8) {
        return Err(RaysProblem::Element { found: header.dtype().descr(), name });
    }
    let needed =
        u128::from(count) * u128::from(columns * bytes_each) + (bytes.len() - rest.len()) as u128;
    if needed > bytes.len() as u128 {
        return Err(RaysProblem::CutOff { shape, needed, found: bytes.len() });
    }

    // 3. The numbers.
    let file = NpyFile::with_header(header, rest);
    let numbers = if bytes_each == 4 {
        file.into_vec().map(Floats::Single)
    } else {
        file.into_vec().map(Floats::Double)
    };
    let values = numbers.map_err(|error| RaysProblem::Header(error.to_string()))?;
    Ok(RayTable { columns: columns as usize, values })
}

/// Refuses headers that claim more bytes or elements than can be counted, and headers nested so deep that parsing could
/// overflow the stack.
fn check_header(bytes: &[u8]) -> Result<(), RaysProblem> {
    let invalid = |what: &str| Err(RaysProblem::Header(what.into()));
    let (size, first) = match bytes {
        [_, _, _, _, _, _, 1, _, a, b, ..] => (usize::from(u16::from_le_bytes([*a, *b])), 10),
        [_, _, _, _, _, _, _, _, a, b, c, d, ..] => {
            (u32::from_le_bytes([*a, *b, *c, *d]) as usize, 12)
        }
        _ => return invalid("it is cut off"),
    };
    if size > LONGEST_HEADER {
        return invalid("it is longer than 10,000 bytes");
    }
    let Some(text) = bytes.get(first..first + size) else { return invalid("it is cut off") };
    let (mut brackets, mut open, mut most_open) = (0, 0_usize, 0);
    for byte in text {
        match byte {
            b'(' | b'[' | b'{' => (brackets, open) = (brackets + 1, open + 1),
            b')' | b']' | b'}' => open = open.saturating_sub(1),
            _ => {}
        }
        most_open = most_open.max(open);
    }
    if brackets > MOST_BRACKETS {
        return invalid("it has more brackets than an array of numbers needs");
    }
    if most_open > MOST_NESTED {
        return invalid("it has more brackets inside each other than an array of numbers needs");
    }
    // The product of all numbers in the header, among them those of the shape. Each counts as at least 2: so the product
    // is no less than their sum either, which Python may write instead of a number.
    let is_word = |byte: &u8| byte.is_ascii_alphanumeric() || *byte == b'_';
    let mut product: u64 = 1;
    for word in text.split(|byte| !is_word(byte)) {
        for number in numbers_of(word) {
            match number.and_then(|number| product.checked_mul(number.max(2))) {
                Some(next) => product = next,
                None => return invalid("it claims more elements than can be counted"),
            }
        }
    }
    Ok(())
}

/// Bounds the numbers in a word of letters, digits and underscores from above; `None` for one beyond `u64`.
///
/// A word that begins with a digit is one number, which Python may write as `1_000`, `0x3e8`, `0o1750` or
/// `0b1111101000`. Its digits, read in base 16, are no less than in the base that is meant. Other words are names and
/// types, whose decimal digits count.
fn numbers_of(word: &[u8]) -> Vec<Option<u64>> {
    let number = |digits: &[u8], base: u32| {
        let mut digits = digits.iter().filter_map(|&digit| char::from(digit).to_digit(base));
        digits.try_fold(0_u64, |number, digit| {
            number.checked_mul(u64::from(base))?.checked_add(u64::from(digit))
        })
    };
    let is_plain = word.iter().all(u8::is_ascii_digit);
    if word.first().is_some_and(u8::is_ascii_digit) && !is_plain {
        return vec![number(word, 16)];
    }
    let runs = word.split(|byte| !byte.is_ascii_digit()).filter(|digits| !digits.is_empty());
    runs.map(|digits| number(digits, 10)).collect()
}

impl RayTable {
    /// Returns the number of rays.
    pub fn len(&self) -> usize {
        let numbers = match &self.values {
            Floats::Single(values) => values.len(),
            Floats::Double(values) => values.len(),
        };
        numbers / self.columns
    }

    /// Tells whether there are no rays.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Tells whether the file has numbers of 64 bits, which rays round to `f32`.
    pub fn is_rounded(&self) -> bool {
        matches!(self.values, Floats::Double(_))
    }

    /// Makes the rays relative to the scene's origin. A row that is not a valid ray becomes an error.
    pub fn rays(&self, origin: [f64; 3]) -> Vec<Result<Ray, RayError>> {
        match &self.values {
            Floats::Single(values) => rays(values, self.columns, origin),
            Floats::Double(values) => rays(values, self.columns, origin),
        }
    }
}

impl RayTable {
    /// Makes points with normals relative to the scene's origin; each row is a position and a normal.
    pub fn points(&self, origin: [f64; 3]) -> Vec<(Vec3, Vec3)> {
        match &self.values {
            Floats::Single(values) => points(values, self.columns, origin),
            Floats::Double(values) => points(values, self.columns, origin),
        }
    }
}

fn points<T: Copy + Into<f64>>(
    values: &[T],
    columns: usize,
    origin: [f64; 3],
) -> Vec<(Vec3, Vec3)> {
    let to_point = |row: &[T]| {
        let at = |column: usize| -> f64 { row[column].into() };
        let position = [0, 1, 2].map(|axis| (at(axis) - origin[axis]) as f32);
        (Vec3::from_array(position), Vec3::from_array([3, 4, 5].map(|column| at(column) as f32)))
    };
    values.chunks_exact(columns).map(to_point).collect()
}

fn rays<T: Copy + Into<f64>>(
    values: &[T],
    columns: usize,
    origin: [f64; 3],
) -> Vec<Result<Ray, RayError>> {
    let to_ray = |row: &[T]| {
        let at = |column: usize| -> f64 { row[column].into() };
        let start = Vec3::from_array([0, 1, 2].map(|axis| (at(axis) - origin[axis]) as f32));
        let direction = Vec3::from_array([3, 4, 5].map(|column| at(column) as f32));
        if columns == 8 {
            Ray::with_interval(start, direction, at(6) as f32, at(7) as f32)
        } else {
            Ray::new(start, direction)
        }
    };
    values.chunks_exact(columns).map(to_ray).collect()
}

#[cfg(test)]
mod tests;
