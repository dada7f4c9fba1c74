//! Tests that a newcomer finds their way: no folder and no file is too large to be surveyed, no name stands for two types,
//! and the core's folders stand one above the other, as `core/ARCHITECTURE.md` draws them.
//!
//! Sources are read as they are formatted: an item of several lines ends at a bracket below its first letter.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Most rooms of a folder: source files and folders of them, without the file that lists the others.
const MOST_ROOMS: usize = 10;
/// Most lines of a source file.
const MOST_LINES: usize = 400;
/// Fewer files are a sign that they were looked for in the wrong place.
const FEWEST_FILES: usize = 500;
/// Most lines of the front page.
const MOST_LINES_OF_FRONT_PAGE: usize = 120;
/// Endings of sources.
const SOURCES: [&str; 8] = ["rs", "py", "ts", "js", "mjs", "sh", "c", "cpp"];
/// Folders of what is generated or downloaded, beside those whose names begin with a dot.
const NOT_OURS: [&str; 6] = ["target", "node_modules", "dist", "corpus", "artifacts", "coverage"];
/// Files that list the other rooms of their folder.
const LISTS: [&str; 3] = ["mod.rs", "lib.rs", "main.rs"];

/// The repository's folder.
fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("a folder above")
}

/// Returns a path as it is written from the repository's folder.
fn shown(path: &Path) -> String {
    path.strip_prefix(root()).expect("a path inside").display().to_string()
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn name_of(path: &Path) -> String {
    path.file_name().expect("a name").to_string_lossy().into_owned()
}

fn is_source(path: &Path) -> bool {
    path.extension().is_some_and(|ending| SOURCES.iter().any(|source| ending == *source))
}

/// Lists a folder's source files and its folders, sorted.
fn entries(folder: &Path) -> Vec<PathBuf> {
    let entries =
        fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.expect("an entry").path()).collect();
    paths.retain(|path| {
        let name = name_of(path);
        let is_ours = !name.starts_with('.') && !NOT_OURS.contains(&name.as_str());
        is_ours && (is_source(path) || path.is_dir())
    });
    paths.sort();
    paths
}

/// Lists all source files below a folder.
fn files(folder: &Path) -> Vec<PathBuf> {
    let below = |path: PathBuf| if path.is_dir() { files(&path) } else { vec![path] };
    entries(folder).into_iter().flat_map(below).collect()
}

fn check_rooms(folder: &Path, crowded: &mut Vec<String>) {
    let is_room = |path: &&PathBuf| match path.is_dir() {
        true => !files(path).is_empty(),
        false => !LISTS.contains(&name_of(path).as_str()),
    };
    let entries = entries(folder);
    let count = entries.iter().filter(is_room).count();
    if count > MOST_ROOMS {
        crowded.push(format!("{} has {count} rooms, more than {MOST_ROOMS}", shown(folder)));
    }
    entries.iter().filter(|path| path.is_dir()).for_each(|path| check_rooms(path, crowded));
}

#[test]
fn no_folder_has_more_than_ten_rooms() {
    let mut crowded = Vec::new();
    check_rooms(root(), &mut crowded);
    assert!(crowded.is_empty(), "{crowded:#?}");
}

#[test]
fn no_file_has_more_than_400_lines() {
    let mut pages = vec![(root().join("README.md"), MOST_LINES_OF_FRONT_PAGE)];
    pages.extend(files(root()).into_iter().map(|path| (path, MOST_LINES)));
    let count = pages.len();
    assert!(count > FEWEST_FILES, "only {count} files were found");
    let too_long = pages.iter().filter_map(|(path, most)| {
        let count = read(path).lines().count();
        let text = format!("{} has {count} lines, more than {most}", shown(path));
        (count > *most).then_some(text)
    });
    let too_long: Vec<_> = too_long.collect();
    assert!(too_long.is_empty(), "{too_long:#?}");
}

/// A file that no other names is not compiled, and its tests do not run.
#[test]
fn each_file_is_a_module() {
    let crates = [
        "core/src",
        "core/ffi/src",
        "core/wasm/src",
        "host/src",
        "host/tests",
        "tests/src",
        "tests/tests",
    ];
    for crate_folder in crates {
        for path in files(&root().join(crate_folder)) {
            let (folder, name) = (path.parent().expect("a folder"), name_of(&path));
            let (folder, module) = match name.strip_suffix(".rs").expect("a file of Rust") {
                "lib" | "main" => continue,
                "mod" => (folder.parent().expect("a folder above"), name_of(folder)),
                module => (folder, module.to_owned()),
            };
            let lists =
                LISTS.map(|list| folder.join(list)).into_iter().filter(|list| list.exists());
            let lists: Vec<String> = lists.map(|list| read(&list)).collect();
            // A program of tests of its own, or what such programs share.
            let is_program = lists.is_empty() && crate_folder == "host/tests";
            let line = format!("mod {module};");
            let is_listed = lists.iter().any(|list| list.contains(&line));
            let is_build_script = module == "build_facts";
            assert!(is_program || is_listed || is_build_script, "{} is no module", shown(&path));
        }
    }
}

/// Returns the code of a crate's files, by path: without comments, tests and files of tests.
fn code(folder: &Path) -> BTreeMap<PathBuf, String> {
    let mut code = BTreeMap::new();
    let mut of_tests = Vec::new();
    for path in files(folder) {
        let mut kept = String::new();
        let text = read(&path);
        let mut lines = text.lines();
        while let Some(line) = lines.next() {
            if line.trim() == "#[cfg(test)]" {
                let indentation = line.len() - line.trim_start().len();
                let item = lines.by_ref().find(|line| !line.trim_start().starts_with("#["));
                let item = item.expect("an item after its attribute");
                if !item.ends_with(';') {
                    let is_end = |end| ["}", "};", "];", ");"].contains(&end);
                    lines.by_ref().find(|line| line.get(indentation..).is_some_and(is_end));
                } else if let Some((_, module)) = item.split_once("mod ") {
                    let module = path.with_file_name(module.trim_end_matches(';'));
                    of_tests.extend([module.with_extension("rs"), module]);
                }
            } else {
                kept += line.split("//").next().expect("a line");
                kept.push('\n');
            }
        }
        code.insert(path, kept);
    }
    code.retain(|path, _| !of_tests.iter().any(|tests| path.starts_with(tests)));
    code
}

/// Tells whether a letter is none of a name.
fn ends_name(letter: char) -> bool {
    !letter.is_alphanumeric() && letter != '_'
}

/// Returns the name of the type that a line declares. Types of traits and of their implementations are indented, as
/// aliases never are.
fn declared(line: &str) -> Option<&str> {
    let item = line.trim_start().trim_start_matches("pub ");
    let item = match item.strip_prefix("pub(") {
        Some(item) => item.split_once(") ")?.1,
        None => item,
    };
    let (keyword, name) = item.trim_start_matches("unsafe ").split_once(' ')?;
    let is_type = ["struct", "enum", "trait", "union"].contains(&keyword);
    let is_alias = keyword == "type" && !line.starts_with(' ');
    let end = name.find(ends_name);
    let name = &name[..end.unwrap_or(name.len())];
    ((is_type || is_alias) && !name.is_empty()).then_some(name)
}

#[test]
fn no_type_is_named_twice_in_a_crate() {
    for crate_folder in ["core/src", "host/src"] {
        let mut places = BTreeMap::<String, Vec<String>>::new();
        for (path, text) in code(&root().join(crate_folder)) {
            for name in text.lines().filter_map(declared) {
                places.entry(name.to_owned()).or_default().push(shown(&path));
            }
        }
        assert!(places.len() > 100, "only {} types were found", places.len());
        places.retain(|_, places| places.len() > 1);
        assert!(places.is_empty(), "named twice: {places:#?}");
    }
}

/// Returns the first names of the paths that follow `start` in a file: `a` and `b` of `crate::{a::A, b::B}`.
fn first_names<'t>(text: &'t str, start: &str) -> Vec<&'t str> {
    let mut names = Vec::new();
    for (at, _) in text.match_indices(start) {
        let path = &text[at + start.len()..];
        let mut depth = 0;
        let mut begins = true;
        for (at, letter) in path.char_indices() {
            if begins && (letter.is_alphabetic() || letter == '_') && depth <= 1 {
                let rest = &path[at..];
                let end = rest.find(ends_name);
                names.push(&rest[..end.unwrap_or(rest.len())]);
            }
            depth += i32::from(letter == '{') - i32::from(letter == '}');
            begins = matches!(letter, '{' | ',') || begins && letter.is_whitespace();
            if depth == 0 {
                break;
            }
        }
    }
    names
}

/// Returns the rooms of the floor plan in `core/ARCHITECTURE.md`, from the ground up, and the arrows that it argues for.
fn floor_plan() -> (Vec<String>, BTreeSet<(String, String)>) {
    let page = read(&root().join("core/ARCHITECTURE.md"));
    let plan = page.split("\ncore/src/\n").nth(1).expect("the floor plan");
    let (floors, rest) = plan.split_once("\n```").expect("an end of the floor plan");
    let floor = |line: &str| {
        let name = line.strip_prefix("  ")?.split(' ').next()?;
        let room = name.strip_suffix('/').or(name.strip_suffix(".rs"))?;
        (room != "lib").then(|| room.to_owned())
    };
    let argued = rest.split("\n## ").next().expect("the rest of the section");
    let arrows = argued.lines().filter(|line| line.starts_with("- `")).map(|line| {
        let words: Vec<&str> = line.split('`').collect();
        (words[1].to_owned(), words[3].to_owned())
    });
    (floors.lines().filter_map(floor).collect(), arrows.collect())
}

#[test]
fn the_core_uses_only_what_lies_below() {
    let folder = root().join("core/src");
    let (floors, argued) = floor_plan();
    let mut rooms: Vec<_> =
        entries(&folder).iter().map(|path| name_of(&path.with_extension(""))).collect();
    rooms.retain(|room| room != "lib");
    let planned: BTreeSet<_> = floors.iter().cloned().collect();
    assert_eq!(planned, rooms.into_iter().collect(), "the floor plan, and the folder");

    let code = code(&folder);
    // What `lib.rs` makes public is also used by its short name.
    let public = code[&folder.join("lib.rs")].split(';').filter_map(|item| {
        let (room, names) = item.rsplit_once("pub use ")?.1.split_once("::")?;
        floors.iter().find(|floor| *floor == room)?;
        Some(names.split(ends_name).map(move |name| (name, room)))
    });
    let public: BTreeMap<&str, &str> = public.flatten().collect();
    let mut up = BTreeMap::<(String, String), BTreeSet<String>>::new();
    let mut arrow_count = 0;
    for (path, text) in &code {
        let inside = path.strip_prefix(&folder).expect("a path inside").with_extension("");
        let mut modules: Vec<_> = inside.iter().map(|name| name.to_string_lossy()).collect();
        modules.pop_if(|last| last == "mod");
        let room = modules[0].clone().into_owned();
        let Some(floor) = floors.iter().position(|floor| *floor == room) else { continue };
        let mut names = first_names(text, "crate::");
        names.extend(first_names(text, &"super::".repeat(modules.len())));
        for name in names {
            // `Vec3` is of another crate, and `sealed` stands in `lib.rs`.
            let to = public.get(name).copied().unwrap_or(name);
            let other = floors.iter().position(|floor| floor == to);
            let Some(other) = other else {
                assert!(
                    ["Vec3", "sealed"].contains(&to),
                    "{} uses {to}, which is no floor",
                    shown(path)
                );
                continue;
            };
            arrow_count += usize::from(other != floor);
            if other > floor {
                up.entry((room.clone(), to.to_owned())).or_default().insert(shown(path));
            }
        }
    }
    assert!(arrow_count > 300, "only {arrow_count} arrows were found");
    for (arrow, files) in &up {
        assert!(
            argued.contains(arrow),
            "{} uses {}, which lies above, in {files:?}",
            arrow.0,
            arrow.1
        );
    }
    for arrow in &argued {
        assert!(up.contains_key(arrow), "{} does not use {} any more", arrow.0, arrow.1);
    }
}
