//! Checks an OBJ text line by line, and reduces it to what is read of it.
//!
//! All vertices come first in the reduced text and faces name them by positive numbers, so that it
//! does not matter where in the file a vertex stands.

use std::collections::{BTreeSet, HashMap};
use std::fmt::Write;

use crate::scene::LineProblem;
use crate::scene::formats::lines::lines;

/// An OBJ text with nothing wrong in it.
pub(super) struct Reduced {
    /// `v`, `f`, `o`, `mtllib` and `usemtl` lines; `o` lines name an object by its place in `names`.
    pub text: String,
    /// The names of objects, by first occurrence of a face in them.
    pub names: Vec<String>,
    /// Every material that a `usemtl` line names.
    pub materials_used: BTreeSet<String>,
    pub vertex_count: usize,
    /// Faces of three corners or more.
    pub face_count: usize,
    /// Points and lines.
    pub element_count: usize,
    /// Faces of one or two corners.
    pub short_face_count: usize,
    /// Whether an `mtllib` line stands in the file.
    pub names_library: bool,
}

/// A name that no material has: it would end at the zero.
const NO_MATERIAL: &str = "\0";

/// The line, from 1, and what is wrong with it.
type Complaint = (usize, LineProblem);

/// Checks and reduces a text.
pub(super) fn reduce(source: &str) -> Result<Reduced, Complaint> {
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

/// What stands before the backslash of a line that the next one continues. Blanks may follow the
/// backslash; in a comment it is none.
fn continued(line: &str) -> Option<&str> {
    let begun = line.trim_end().strip_suffix('\\')?;
    (!begun.contains('#')).then_some(begun)
}

/// Names may end in a backslash: `g C:\models\`.
fn holds_a_name(line: &str) -> bool {
    let keyword = line.split_whitespace().next().unwrap_or_default();
    matches!(keyword, "g" | "o" | "usemtl" | "mtllib")
}

/// A coordinate whose nearest `f64` lies halfway between two `f32`, and would be rounded to the wrong one:
/// the `f64` beside it, which is rounded to the `f32` nearest to the decimal. None for all others.
fn corrected(text: &str) -> Result<Option<f64>, std::num::ParseFloatError> {
    let value: f64 = text.parse()?;
    // Halfway means one bit more than a f32 has, so the last 28 of 52 are zero.
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
    /// Whether a name was given since the last `o` line was written.
    name_pending: bool,
    numbers: HashMap<String, usize>,
    names: Vec<String>,
    materials_used: BTreeSet<String>,
    vertex_count: usize,
    face_count: usize,
    element_count: usize,
    short_face_count: usize,
    names_library: bool,
    /// The highest vertex number in any face so far, and the lines where it rose above the vertices
    /// known then: the first line with a number too high is among them.
    highest: usize,
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

    /// Three coordinates, finite or not; a weight or a colour may follow and does not matter.
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
        // Written at the first face: a name without faces is no object.
        if arguments.split_whitespace().nth(2).is_none() {
            for corner in arguments.split_whitespace() {
                self.vertex_number(corner)?;
            }
            self.short_face_count += 1;
            return Ok(());
        }
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

    /// The vertex that a corner such as `3`, `-1/2` or `3//1` names, counted from 1.
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
            // Two houses may each have a roof.
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

    fn finish(mut self) -> Result<Reduced, Complaint> {
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

/// Names may hold a `#`, numbers not.
fn without_comment(arguments: &str) -> &str {
    arguments.split_once('#').map_or(arguments, |(before, _)| before)
}
