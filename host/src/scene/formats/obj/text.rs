//! Checks of an OBJ text line by line, and its reduction to the lines that are read.
//!
//! In the reduced text, all vertices precede all faces, and faces name vertices by positive numbers. So the position of
//! a vertex in the file does not matter.

use std::collections::{BTreeSet, HashMap};
use std::fmt::Write;

use crate::scene::LineProblem;
use crate::scene::formats::lines::lines;

/// Valid OBJ text, reduced to the lines that are read.
pub(super) struct Reduced {
    /// Lines `v`, `f`, `o`, `mtllib` and `usemtl`. An `o` line names an object by its index in `names`.
    pub text: String,
    /// Names of objects, in the order of their first faces.
    pub names: Vec<String>,
    /// Materials that `usemtl` lines name.
    pub materials_used: BTreeSet<String>,
    pub vertex_count: usize,
    /// Number of faces of three corners or more.
    pub face_count: usize,
    /// Number of points and lines.
    pub element_count: usize,
    /// Number of faces of one or two corners.
    pub short_face_count: usize,
    /// True if the file has an `mtllib` line.
    pub names_library: bool,
}

/// Name that no material file defines, because a name cannot contain a zero byte.
const NO_MATERIAL: &str = "\0";

/// Number of a line, from 1, and its problem.
type BadLine = (usize, LineProblem);

/// Checks and reduces a text.
pub(super) fn reduce(source: &str) -> Result<Reduced, BadLine> {
    let mut reducer = Reducer::default();
    // Some editors begin files with a byte order mark.
    let source = source.strip_prefix('\u{feff}').unwrap_or(source);
    let mut numbered = (1..).zip(lines(source));
    let mut joined = String::new();
    while let Some((number, first)) = numbered.next() {
        let line = match continued(first).filter(|_| !holds_a_name(first)) {
            None => first,
            Some(begun) => {
                begun.clone_into(&mut joined);
                for (_, next) in numbered.by_ref() {
                    joined.push(' ');
                    let part = continued(next);
                    joined.push_str(part.unwrap_or(next));
                    if part.is_none() {
                        break;
                    }
                }
                &joined
            }
        };
        reducer.line(line).map_err(|problem| (number, problem))?;
        reducer.note_highest(number);
    }
    reducer.finish()
}

/// Returns the part before the backslash of a line that the next line continues; `None` if the line is complete. Blanks
/// may follow the backslash. A comment is never continued.
fn continued(line: &str) -> Option<&str> {
    let begun = line.trim_end().strip_suffix('\\')?;
    (!begun.contains('#')).then_some(begun)
}

/// Tells whether a line ends in a name, which may end in a backslash, as in `g C:\models\`.
fn holds_a_name(line: &str) -> bool {
    let keyword = line.split_whitespace().next().unwrap_or_default();
    matches!(keyword, "g" | "o" | "usemtl" | "mtllib")
}

/// Corrects a coordinate that rounding through `f64` would round to the wrong `f32`. That happens if the nearest `f64`
/// lies halfway between two `f32`. Returns the adjacent `f64`, which rounds to the `f32` nearest to the decimal; `None`
/// if no correction is needed.
fn corrected(text: &str) -> Result<Option<f64>, std::num::ParseFloatError> {
    let value: f64 = text.parse()?;
    // A value halfway between two f32 has one bit more than an f32, so the last 28 of its 52 bits are 0.
    if value.to_bits().trailing_zeros() < 28 || f64::from(value as f32) == value {
        return Ok(None);
    }
    let nearest = f64::from(text.parse::<f32>()?);
    let beside = if nearest > value { value.next_up() } else { value.next_down() };
    Ok((f64::from(value as f32) != nearest && value.is_finite()).then_some(beside))
}

#[derive(Default)]
struct Reducer {
    vertices: String,
    rest: String,
    object: String,
    group: String,
    /// True if a name was read since the last `o` line was written.
    name_pending: bool,
    numbers: HashMap<String, usize>,
    names: Vec<String>,
    materials_used: BTreeSet<String>,
    vertex_count: usize,
    face_count: usize,
    element_count: usize,
    short_face_count: usize,
    names_library: bool,
    /// Highest vertex number in any face so far.
    highest: usize,
    /// Lines at which `highest` rose above the number of vertices known then, with its value. If a number turns out to
    /// be too high, the first line with such a number is in this list.
    rises: Vec<(usize, usize)>,
}

impl Reducer {
    fn line(&mut self, line: &str) -> Result<(), LineProblem> {
        let line = line.trim();
        let (keyword, arguments) =
            line.split_once(char::is_whitespace).map_or((line, ""), |(k, a)| (k, a.trim()));
        match keyword {
            "v" => return self.vertex(without_comment(arguments)),
            "f" => return self.face(without_comment(arguments)),
            "p" | "l" => self.element_count += 1,
            "o" => {
                arguments.clone_into(&mut self.object);
                self.group.clear();
                self.name_pending = true;
            }
            "g" => {
                arguments.clone_into(&mut self.group);
                self.name_pending = true;
            }
            "mtllib" => {
                self.names_library = true;
                self.write_rest(format_args!("mtllib {arguments}\n"));
            }
            "usemtl" if arguments.is_empty() => {
                self.write_rest(format_args!("usemtl {NO_MATERIAL}\n"));
            }
            "usemtl" => {
                self.write_rest(format_args!("usemtl {arguments}\n"));
                if !self.materials_used.contains(arguments) {
                    self.materials_used.insert(arguments.into());
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// Reads three coordinates, finite or not. A weight or a colour may follow and is ignored.
    fn vertex(&mut self, arguments: &str) -> Result<(), LineProblem> {
        self.vertices.push('v');
        let mut given = 0;
        for text in arguments.split_whitespace().take(3) {
            given += 1;
            self.vertices.push(' ');
            match corrected(text) {
                Err(_) => return Err(LineProblem::NotANumber { text: text.into() }),
                Ok(None) => self.vertices.push_str(text),
                Ok(Some(value)) => self.vertices.push_str(&value.to_string()),
            }
        }
        self.vertices.push('\n');
        self.vertex_count += 1;
        if given < 3 { Err(LineProblem::FewCoordinates { given }) } else { Ok(()) }
    }

    fn face(&mut self, arguments: &str) -> Result<(), LineProblem> {
        if arguments.split_whitespace().nth(2).is_none() {
            for corner in arguments.split_whitespace() {
                self.vertex_number(corner)?;
            }
            self.short_face_count += 1;
            return Ok(());
        }
        // The name is written before its first face, because a name without faces is not an object.
        if self.name_pending || self.names.is_empty() {
            self.write_name();
        }
        self.rest.push('f');
        for corner in arguments.split_whitespace() {
            let number = self.vertex_number(corner)?;
            self.write_rest(format_args!(" {number}"));
        }
        self.rest.push('\n');
        self.face_count += 1;
        Ok(())
    }

    /// Returns the number, from 1, of the vertex that a corner such as `3`, `-1/2` or `3//1` names.
    fn vertex_number(&mut self, corner: &str) -> Result<usize, LineProblem> {
        let position = corner.split_once('/').map_or(corner, |(position, _)| position);
        let index = position
            .parse::<i64>()
            .ok()
            .filter(|&index| index != 0)
            .ok_or_else(|| LineProblem::NotAnIndex { text: corner.into() })?;
        let vertex_count = self.vertex_count;
        let back = usize::try_from(index.unsigned_abs()).unwrap_or(usize::MAX);
        if index > 0 {
            self.highest = self.highest.max(back);
            return Ok(back);
        }
        let place = "above it";
        let problem = LineProblem::OutOfRange { index, vertex_count, place };
        vertex_count.checked_sub(back).map(|before| before + 1).ok_or(problem)
    }

    fn note_highest(&mut self, line: usize) {
        let known =
            self.rises.last().map_or(self.vertex_count, |rise| rise.1.max(self.vertex_count));
        if self.highest > known {
            self.rises.push((line, self.highest));
        }
    }

    fn write_name(&mut self) {
        let name = match (self.object.as_str(), self.group.as_str()) {
            ("", "") => "unnamed".to_owned(),
            ("", name) | (name, "") => name.to_owned(),
            // Groups of the same name in different objects are different.
            (object, group) => format!("{object}/{group}"),
        };
        let next = self.names.len();
        let number = *self.numbers.entry(name).or_insert_with_key(|name| {
            self.names.push(name.clone());
            next
        });
        self.write_rest(format_args!("o {number}\n"));
        self.name_pending = false;
    }

    fn write_rest(&mut self, line: std::fmt::Arguments<'_>) {
        let written = self.rest.write_fmt(line);
        debug_assert!(written.is_ok(), "writing to a string cannot fail");
    }

    fn finish(mut self) -> Result<Reduced, BadLine> {
        let vertex_count = self.vertex_count;
        if let Some(&(line, index)) = self.rises.iter().find(|rise| rise.1 > vertex_count) {
            let index = i64::try_from(index).unwrap_or(i64::MAX);
            let place = "in the file";
            return Err((line, LineProblem::OutOfRange { index, vertex_count, place }));
        }
        self.vertices.push_str(&self.rest);
        Ok(Reduced {
            text: self.vertices,
            names: self.names,
            materials_used: self.materials_used,
            vertex_count,
            face_count: self.face_count,
            element_count: self.element_count,
            short_face_count: self.short_face_count,
            names_library: self.names_library,
        })
    }
}

/// Removes the comment after numbers. Not for names, which may contain `#`.
fn without_comment(arguments: &str) -> &str {
    arguments.split_once('#').map_or(arguments, |(before, _)| before)
}
