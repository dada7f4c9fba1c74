//! Reduction of a material file to names and diffuse colours of three components.
//!
//! The format allows a colour of one component, to which the others are equal. `tobj` panics on such a colour.

use std::fmt::Write;
use std::path::Path;

use crate::scene::surface::DEFAULT_REFLECTANCE;

/// Appends the names and diffuse colours of a material file to `reduced`, in the format of material files. A colour
/// that is not valid gives a warning.
pub(super) fn reduce(text: &str, file: &Path, reduced: &mut String, warnings: &mut Vec<String>) {
    let mut named = false;
    for (number, line) in (1..).zip(text.lines()) {
        let line = line.trim();
        let (keyword, arguments) =
            line.split_once(char::is_whitespace).map_or((line, ""), |(k, a)| (k, a.trim()));
        let written = match keyword {
            "newmtl" if !arguments.is_empty() => {
                named = true;
                writeln!(reduced, "newmtl {arguments}")
            }
            "Kd" if named => {
                if let Some([red, green, blue]) = colour(arguments) {
                    writeln!(reduced, "Kd {red} {green} {blue}")
                } else {
                    warnings.push(format!(
                        "{}, line {number}: `{line}` is not a colour of 1 or 3 numbers; \
                         reflectance {} instead",
                        file.display(),
                        DEFAULT_REFLECTANCE
                    ));
                    Ok(())
                }
            }
            _ => Ok(()),
        };
        debug_assert!(written.is_ok(), "writing to a string cannot fail");
    }
}

fn colour(arguments: &str) -> Option<[f32; 3]> {
    let numbers = arguments.split_once('#').map_or(arguments, |(before, _)| before);
    let components: Vec<f32> =
        numbers.split_whitespace().map(str::parse).collect::<Result<_, _>>().ok()?;
    // The limit is far above any colour, and the sum of three components cannot overflow.
    let sensible = components.iter().all(|component| component.abs() <= 1e6);
    match components[..] {
        [grey] if sensible => Some([grey; 3]),
        [red, green, blue] if sensible => Some([red, green, blue]),
        _ => None,
    }
}
