//! Reduction of a material file to names, diffuse colours and radiances of three components.
//!
//! The format allows a colour of one component, to which the others are equal. `tobj` panics on such a colour.

use std::fmt::Write;
use std::path::Path;

use crate::scene::surface::DEFAULT_REFLECTANCE;

/// Largest component of a diffuse colour, far above any. The sum of three components cannot overflow.
const MOST_DIFFUSE: f32 = 1e6;
/// Largest radiance: ten thousand times that of the sun's disc, in W/(m2 sr).
const MOST_RADIANCE: f32 = 1e12;

/// Numbers of materials with properties that are not simulated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Ignored {
    highlights: usize,
    transparent: usize,
    textures: usize,
}

impl Ignored {
    /// Adds the numbers of another file.
    pub fn join(&mut self, other: &Self) {
        self.highlights += other.highlights;
        self.transparent += other.transparent;
        self.textures += other.textures;
    }

    /// Lists one warning for each property that some material has.
    pub fn warnings(self) -> impl Iterator<Item = String> {
        let warning = |count: usize, text: &str| {
            let verb = if count == 1 { "material has" } else { "materials have" };
            (count > 0).then(|| format!("{count} {verb} {text}"))
        };
        [
            warning(self.highlights, "a highlight (Ks), which is not simulated: only Kd is reflected"),
            warning(
                self.transparent,
                "transparency (d, Tr or illum), which is not simulated: treated as opaque",
            ),
            warning(
                self.textures,
                "textures, which are not read: only Kd is reflected, which is often 1 beside a texture",
            ),
        ]
        .into_iter()
        .flatten()
    }
}

/// Properties of one material that are not simulated.
#[derive(Clone, Copy, Default)]
struct Unsupported {
    highlight: bool,
    transparent: bool,
    texture: bool,
}

impl Unsupported {
    fn note(&mut self, keyword: &str, arguments: &str) {
        let numbers = without_comment(arguments).split_whitespace().map(str::parse::<f32>);
        let any = |is: &dyn Fn(f32) -> bool| numbers.clone().any(|number| number.is_ok_and(is));
        match keyword {
            "Ks" => self.highlight |= any(&|number| number > 0.0),
            "d" => self.transparent |= any(&|number| number < 1.0),
            "Tr" => self.transparent |= any(&|number| number > 0.0),
            // Models of light with refraction or glass.
            "illum" => self.transparent |= any(&|number| [4.0, 6.0, 7.0, 9.0].contains(&number)),
            "bump" | "disp" | "decal" | "refl" | "norm" => self.texture = true,
            map => self.texture |= map.starts_with("map_"),
        }
    }

    fn count(self, ignored: &mut Ignored) {
        ignored.highlights += usize::from(self.highlight);
        ignored.transparent += usize::from(self.transparent);
        ignored.textures += usize::from(self.texture);
    }
}

/// Appends the names, diffuse colours and radiances of a material file to `reduced`, in the format of material files. A
/// colour that is not valid gives a warning. Returns what the file has beside.
pub(super) fn reduce(
    text: &str,
    file: &Path,
    reduced: &mut String,
    warnings: &mut Vec<String>,
) -> Ignored {
    let mut ignored = Ignored::default();
    let mut material: Option<Unsupported> = None;
    for (number, line) in (1..).zip(text.lines()) {
        let line = line.trim();
        let (keyword, arguments) =
            line.split_once(char::is_whitespace).map_or((line, ""), |(k, a)| (k, a.trim()));
        let mut refuse = |kind: &str, range: &str, instead: &str| {
            let file = file.display();
            warnings.push(format!(
                "{file}, line {number}: `{line}` is not a {kind} of 1 or 3 numbers {range}; {instead}"
            ));
            Ok(())
        };
        let written = match (keyword, &mut material) {
            ("newmtl", _) if !arguments.is_empty() => {
                material.replace(Unsupported::default()).unwrap_or_default().count(&mut ignored);
                writeln!(reduced, "newmtl {arguments}")
            }
            ("Kd", Some(_)) => match colour(arguments, -MOST_DIFFUSE, MOST_DIFFUSE) {
                Some([red, green, blue]) => writeln!(reduced, "Kd {red} {green} {blue}"),
                None => refuse(
                    "colour",
                    &format!("from -{MOST_DIFFUSE:e} to {MOST_DIFFUSE:e}"),
                    &format!("reflectance {DEFAULT_REFLECTANCE} instead"),
                ),
            },
            ("Ke", Some(_)) => match colour(arguments, 0.0, MOST_RADIANCE) {
                Some([red, green, blue]) => writeln!(reduced, "Ke {red} {green} {blue}"),
                None => {
                    refuse("radiance", &format!("from 0 to {MOST_RADIANCE:e}"), "it emits nothing")
                }
            },
            (_, Some(material)) => {
                material.note(keyword, arguments);
                Ok(())
            }
            _ => Ok(()),
        };
        debug_assert!(written.is_ok(), "writing to a string cannot fail");
    }
    material.unwrap_or_default().count(&mut ignored);
    ignored
}

fn colour(arguments: &str, least: f32, most: f32) -> Option<[f32; 3]> {
    let components: Vec<f32> = without_comment(arguments)
        .split_whitespace()
        .map(str::parse)
        .collect::<Result<_, _>>()
        .ok()?;
    let sensible = components.iter().all(|component| (least..=most).contains(component));
    match components[..] {
        [grey] if sensible => Some([grey; 3]),
        [red, green, blue] if sensible => Some([red, green, blue]),
        _ => None,
    }
}

/// Removes the comment after numbers.
fn without_comment(arguments: &str) -> &str {
    arguments.split_once('#').map_or(arguments, |(before, _)| before)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn properties_that_are_not_simulated_are_counted_by_material() {
        let text = "newmtl a\nKs 0.5 0.5 0.5\nKs 0.1\nmap_Kd wood.png\nnewmtl b\nKs 0 0 0\nNi 1.45\nd 1\nillum 2\n\
                    newmtl c\nd 0.3 # glass\nillum 7\nbump x\nnewmtl d\nTr 0.9\nKd 1\nnewmtl e\n";
        let (mut reduced, mut warnings) = (String::new(), Vec::new());
        let ignored = reduce(text, Path::new("x.mtl"), &mut reduced, &mut warnings);
        assert_eq!(ignored, Ignored { highlights: 1, transparent: 2, textures: 2 });
        assert!(warnings.is_empty());
        let said: Vec<String> = ignored.warnings().collect();
        assert_eq!(said.len(), 3);
        assert!(said[0].starts_with("1 material has a highlight (Ks)"), "{said:?}");
        assert!(said[1].starts_with("2 materials have transparency"), "{said:?}");
        assert_eq!(Ignored::default().warnings().count(), 0);
    }

    #[test]
    fn colours_that_are_none_are_refused_by_line() {
        let text = "Ke 9 9 9\nnewmtl a\nKe 1 2\nKe nan\nKe -1\nKe inf\nKe 1e13\nKe spectral x\nKe\nKe 1\nKd 1 2\n";
        let (mut reduced, mut warnings) = (String::new(), Vec::new());
        reduce(text, Path::new("x.mtl"), &mut reduced, &mut warnings);
        assert_eq!(reduced, "newmtl a\nKe 1 1 1\n");
        assert_eq!(warnings.len(), 8);
        assert_eq!(
            warnings[0],
            "x.mtl, line 3: `Ke 1 2` is not a radiance of 1 or 3 numbers from 0 to 1e12; it emits nothing"
        );
    }
}
