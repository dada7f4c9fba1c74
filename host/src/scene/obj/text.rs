//! Checks an OBJ text line by line, and reduces it to what is read of it.
//!
//! All vertices come first in the reduced text and faces name them by positive numbers, so that it
//! does not matter where in the file a vertex stands.

use std::borrow::Cow;
use std::collections::{BTreeSet, HashMap};
use std::fmt::Write;

use crate::scene::LineProblem;

/// An OBJ text with nothing wrong in it.
pub(super) struct Reduced {
    /// `v`, `f`, `o`, `mtllib` and `usemtl` lines; `o` lines name an object by its place in `names`.
    pub text: String,
    /// The names of objects, by first occurrence of a face in them.
    pub names: Vec<String>,
    /// Every material that a `usemtl` line names.
    pub materials_used: BTreeSet<String>,
    pub vertex_count: usize,
    /// After polygons are divided.
    pub triangle_count: usize,
    /// Points, lines, and faces of one or two corners.
    pub ignored_count: usize,
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
    let mut lines = (1..).zip(source.lines());
    while let Some((number, first)) = lines.next() {
        // A backslash at the end continues a line.
        let mut line = Cow::Borrowed(first);
        while let Some(continued) = line.strip_suffix('\\') {
            let next = lines.next().map_or("", |(_, next)| next);
            line = Cow::Owned(format!("{continued} {next}"));
        }
        reducer.line(&line).map_err(|problem| (number, problem))?;
        reducer.note_highest(number);
    }
    reducer.finish()
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
    triangle_count: usize,
    ignored_count: usize,
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
            "p" | "l" => self.ignored_count += 1,
            "o" => {
                arguments.clone_into(&mut self.object);
                self.group.clear();
                self.name_pending = true;
            }
            "g" => {
                arguments.clone_into(&mut self.group);
                self.name_pending = true;
            }
            "mtllib" => self.write_rest(format_args!("mtllib {arguments}\n")),
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

    /// Three coordinates; a weight or a colour may follow and does not matter.
    fn vertex(&mut self, arguments: &str) -> Result<(), LineProblem> {
        self.vertices.push('v');
        let mut given = 0;
        for text in arguments.split_whitespace().take(3) {
            given += 1;
            match text.parse::<f32>() {
                Err(_) => return Err(LineProblem::NotANumber { text: text.into() }),
                Ok(value) if !value.is_finite() => {
                    return Err(LineProblem::NotFinite { text: text.into() });
                }
                Ok(_) => {}
            }
            self.vertices.push(' ');
            self.vertices.push_str(text);
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
            self.ignored_count += 1;
            return Ok(());
        }
        if self.name_pending || self.names.is_empty() {
            self.write_name();
        }
        self.rest.push('f');
        let mut corner_count = 0;
        for corner in arguments.split_whitespace() {
            let number = self.vertex_number(corner)?;
            self.write_rest(format_args!(" {number}"));
            corner_count += 1;
        }
        self.rest.push('\n');
        self.triangle_count += corner_count - 2;
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
            triangle_count: self.triangle_count,
            ignored_count: self.ignored_count,
        })
    }
}

/// Names may hold a `#`, numbers not.
fn without_comment(arguments: &str) -> &str {
    arguments.split_once('#').map_or(arguments, |(before, _)| before)
}
