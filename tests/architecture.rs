//! Who may import whom: the layers of the crate, one way only, no two files in a circle, and Python
//! only in `src/python`.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// For each top-level module, the others that it may import, besides those for all.
const ALLOWED: [(&str, &[&str]); 21] = [
    ("error", &[]),
    ("diagnostic", &["chart"]),
    ("progress", &[]),
    ("worker_pool", &[]),
    ("memory", &[]),
    ("numeric", &[]),
    ("bytes", &[]),
    ("disjoint_sets", &[]),
    ("cloud", &[]),
    ("observe", &["cloud"]),
    ("som", &["cloud"]),
    ("chart", &["cloud", "observe", "som"]),
    ("nurbs", &[]),
    ("fit", &["nurbs"]),
    ("validate", &["cloud", "observe", "nurbs"]),
    ("brep", &["nurbs"]),
    ("trim", &["cloud", "nurbs", "brep"]),
    ("mesh", &["nurbs", "brep"]),
    ("export", &["nurbs", "brep", "mesh"]),
    (
        "pipeline",
        &[
            "cloud", "observe", "som", "chart", "nurbs", "fit", "validate", "brep", "trim", "mesh",
            "export",
        ],
    ),
    (
        "python",
        &[
            "cloud", "observe", "som", "chart", "nurbs", "fit", "validate", "brep", "trim", "mesh",
            "export", "pipeline",
        ],
    ),
];

const FOR_ALL: [&str; 8] = [
    "error",
    "diagnostic",
    "progress",
    "worker_pool",
    "memory",
    "numeric",
    "bytes",
    "disjoint_sets",
];

fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let files = entries.flat_map(|path| if path.is_dir() { sources(&path) } else { vec![path] });
    files.filter(|path| path.extension().is_some_and(|suffix| suffix == "rs")).collect()
}

/// The top-level module that a source file belongs to.
fn module(path: &Path) -> String {
    let first = path.components().next().unwrap();
    Path::new(&first).file_stem().unwrap().to_str().unwrap().to_string()
}

/// The names that follow `crate::` in code, groups `crate::{a, b}` taken apart; comments and the
/// crate's root do not count.
fn imports(code: &str) -> Vec<String> {
    let code: Vec<&str> =
        code.lines().filter(|line| !line.trim_start().starts_with("//")).collect();
    let code = code.join("\n");
    let after = code.split("crate::").skip(1);
    let names = after.flat_map(|rest| match rest.strip_prefix('{') {
        Some(group) => members(group),
        None => vec![rest.to_string()],
    });
    let first = |name: String| {
        let end = name.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(name.len());
        name[..end].to_string()
    };
    names.map(first).filter(|name| !name.is_empty()).collect()
}

/// The members of a group of imports `a::{b, c}, d}`, up to its end.
fn members(group: &str) -> Vec<String> {
    let (mut depth, mut names) = (0, vec![String::new()]);
    for c in group.chars() {
        match c {
            '{' => depth += 1,
            '}' if depth == 0 => break,
            '}' => depth -= 1,
            ',' if depth == 0 => names.push(String::new()),
            _ if depth == 0 && !c.is_whitespace() => names.last_mut().unwrap().push(c),
            _ => {}
        }
    }
    names
}

fn checked_sources() -> Vec<(PathBuf, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let files = sources(&root).into_iter().map(|path| {
        let code = fs::read_to_string(&path).unwrap();
        (path.strip_prefix(&root).unwrap().to_path_buf(), code)
    });
    files.filter(|(path, _)| path != Path::new("lib.rs")).collect()
}

/// A path of modules below the crate's root.
type Place = Vec<String>;

/// Source files by their place among the modules.
struct Tree {
    files: BTreeMap<Place, Source>,
}

/// What a file says about paths.
struct Source {
    /// Path without `.rs`.
    name: String,
    /// Paths that it re-exports, by the last name.
    reexports: BTreeMap<String, Place>,
    /// Other paths in it, imported or not.
    uses: Vec<Place>,
}

impl Source {
    fn new(path: &Path, code: &str) -> Self {
        let (mut reexports, mut uses, mut rest) = (BTreeMap::new(), Vec::new(), String::new());
        let mut lines = code_lines(code).into_iter();
        while let Some(line) = lines.next() {
            let (visibility, import) = line.split_once("use ").unwrap_or(("no import", ""));
            let public = visibility.starts_with("pub") && visibility.ends_with(' ');
            if !(visibility.is_empty() || public) {
                rest.push_str(line);
                rest.push('\n');
                continue;
            }
            let mut statement = import.to_string();
            while !statement.contains(';') {
                statement.push_str(lines.next().expect("an import ends with a semicolon"));
            }
            for path in expanded(statement.trim_end_matches(';')) {
                if public {
                    reexports.insert(path.last().unwrap().clone(), path);
                } else {
                    uses.push(path);
                }
            }
        }
        uses.extend(paths(&rest));
        let words: BTreeSet<&str> =
            rest.split(|c: char| !c.is_alphanumeric() && c != '_').collect();
        let used = reexports.iter().filter(|(name, _)| words.contains(name.as_str()));
        uses.extend(used.map(|(_, path)| path.clone()).collect::<Vec<_>>());
        let name = path.with_extension("").to_str().unwrap().replace('\\', "/");
        Self { name, reexports, uses }
    }
}

/// The lines of code, trimmed, without comments and without unit tests at the end.
fn code_lines(code: &str) -> Vec<&str> {
    let lines: Vec<&str> =
        code.lines().map(str::trim).filter(|line| !line.starts_with("//")).collect();
    let tests = lines.windows(2).position(|pair| {
        pair[0] == "#[cfg(test)]" && pair[1].contains("mod ") && pair[1].ends_with('{')
    });
    lines[..tests.unwrap_or(lines.len())].to_vec()
}

/// The paths of an import, its groups taken apart and its new names left off.
fn expanded(import: &str) -> Vec<Place> {
    let Some((head, group)) = import.split_once('{') else {
        let path = import.split(" as ").next().unwrap();
        return vec![path.split("::").map(|part| part.trim().to_string()).collect()];
    };
    let group = &group[..group.rfind('}').unwrap()];
    let (mut depth, mut members) = (0, vec![String::new()]);
    for c in group.chars() {
        depth += i32::from(c == '{') - i32::from(c == '}');
        if c == ',' && depth == 0 {
            members.push(String::new());
        } else {
            members.last_mut().unwrap().push(c);
        }
    }
    let members = members.iter().filter(|member| !member.trim().is_empty());
    members.flat_map(|member| expanded(&format!("{head}{}", member.trim()))).collect()
}

/// The paths `a::b` in code.
fn paths(code: &str) -> Vec<Place> {
    let words = code.split(|c: char| !c.is_alphanumeric() && c != '_' && c != ':');
    let paths = words.filter(|word| word.contains("::") && !word.starts_with("::"));
    paths.map(|path| path.split("::").map(str::to_string).collect()).collect()
}

impl Tree {
    fn new(files: impl Iterator<Item = (PathBuf, String)>) -> Self {
        let place = |path: &Path| -> Place {
            let parts = path.with_extension("");
            let parts = parts.iter().map(|part| part.to_str().unwrap().to_string());
            parts.filter(|part| part != "mod").collect()
        };
        let files = files.map(|(path, code)| (place(&path), Source::new(&path, &code)));
        Self { files: files.collect() }
    }

    /// The file that defines what a path in the file at `here` names, through re-exports.
    fn definition(&self, here: &[String], path: &[String]) -> Option<Place> {
        let (mut at, mut path) = (here.to_vec(), path);
        let child = |at: &[String], name: &String| [at, std::slice::from_ref(name)].concat();
        match path.first()?.as_str() {
            "crate" => (at, path) = (Place::new(), &path[1..]),
            "self" => path = &path[1..],
            "super" => {}
            _ if self.files.contains_key(&child(&at, &path[0])) => {}
            _ => return None,
        }
        while path.first().is_some_and(|name| name == "super") {
            at.pop();
            path = &path[1..];
        }
        while let Some(name) = path.first() {
            let below = child(&at, name);
            if !self.files.contains_key(&below) {
                break;
            }
            (at, path) = (below, &path[1..]);
        }
        let source = self.files.get(&at)?;
        match path.first().and_then(|name| source.reexports.get(name)) {
            Some(reexported) => self.definition(&at, reexported),
            None => Some(at),
        }
    }

    /// Groups of files that lead to each other by imports.
    fn circles(&self) -> Vec<Vec<String>> {
        let imports = |here: &Place| -> BTreeSet<Place> {
            let uses = self.files[here].uses.iter();
            let places = uses.filter_map(|path| self.definition(here, path));
            places.filter(|place| place != here).collect()
        };
        let imports: BTreeMap<&Place, BTreeSet<Place>> =
            self.files.keys().map(|place| (place, imports(place))).collect();
        let reached = |from: &Place| {
            let (mut reached, mut left) = (BTreeSet::new(), vec![from.clone()]);
            while let Some(place) = left.pop() {
                let next = imports[&place].iter();
                left.extend(next.filter(|place| reached.insert((*place).clone())).cloned());
            }
            reached
        };
        let reached: BTreeMap<&Place, BTreeSet<Place>> =
            self.files.keys().map(|place| (place, reached(place))).collect();
        let circles =
            reached.iter().filter(|(place, to)| to.contains(**place)).map(|(from, to)| {
                let both = to.iter().filter(|place| reached[place].contains(*from));
                both.map(|place| self.files[place].name.clone()).collect::<Vec<_>>()
            });
        circles.collect::<BTreeSet<_>>().into_iter().collect()
    }
}

#[test]
fn modules_import_only_what_lies_below_them() {
    let mut seen = 0;
    for (path, code) in checked_sources() {
        let own = module(&path);
        let (_, allowed) = ALLOWED
            .iter()
            .find(|(name, _)| *name == own)
            .unwrap_or_else(|| panic!("{} belongs to no known module", path.display()));
        for import in imports(&code) {
            // Imports name the module, not what the root re-exports: the latter hides the way.
            let known = ALLOWED.iter().any(|(name, _)| *name == import);
            assert!(known, "{}: what is crate::{import}?", path.display());
            let fine = import == own
                || FOR_ALL.contains(&import.as_str())
                || allowed.contains(&import.as_str());
            assert!(fine, "{} must not import crate::{import}", path.display());
            seen += 1;
        }
        for (other, _) in ALLOWED.iter().filter(|(name, _)| *name != own) {
            let around = format!("super::super::{other}::");
            assert!(!code.contains(&around), "{} goes around by {around}", path.display());
        }
    }
    assert!(seen > 20, "only {seen} imports were found: this test has lost its eyes");
}

#[test]
fn files_import_each_other_in_no_circle() {
    let circles = Tree::new(checked_sources().into_iter()).circles();
    assert!(circles.is_empty(), "files import each other in circles: {circles:?}");
}

/// So that no panic reaches a user.
#[test]
fn one_place_leaves_the_interpreter_and_catches_panics() {
    let places: Vec<_> = checked_sources()
        .into_iter()
        .filter(|(_, code)| code_lines(code).iter().any(|line| line.contains(".detach(")))
        .map(|(path, _)| path)
        .collect();
    assert_eq!(places, [Path::new("python/call.rs")]);
}

#[test]
fn python_stands_only_at_the_wall() {
    for (path, code) in checked_sources() {
        let inside = path.starts_with("python");
        let speaks_python = code.contains("pyo3") || code.contains("numpy::");
        assert!(inside || !speaks_python, "{} knows Python", path.display());
    }
}

#[test]
fn imports_are_found_in_groups_and_not_in_comments() {
    let code = "use crate::error::{Error, Result};\n// crate::som\n\
                use crate::{mesh::{A, B}, nurbs};";
    assert_eq!(imports(code), ["error", "mesh", "nurbs"]);
}

#[test]
fn circles_are_found_through_reexports_and_definitions_of_the_parent() {
    let circles = |files: &[(&str, &str)]| {
        let files = files.iter().map(|(path, code)| (PathBuf::from(path), (*code).to_string()));
        Tree::new(files).circles()
    };
    let reexport = ("m/mod.rs", "mod a;\nmod b;\npub use a::A;\nuse self::b::{\n    B,\n};");
    let used = ("m/a.rs", "use super::b::{B, C as D};\n#[cfg(test)]\nmod tests {\n}");
    assert_eq!(circles(&[reexport, used, ("m/b.rs", "fn f(a: &super::A) {}")]), [["m/a", "m/b"]]);
    let in_tests = "// super::A\n#[cfg(test)]\nmod tests {\n    use super::super::A;\n}";
    assert!(circles(&[reexport, used, ("m/b.rs", in_tests)]).is_empty());
    let defined = ("m/mod.rs", "mod a;\npub use a::f;\npub struct S;");
    let uses = ("m/a.rs", "use crate::m::S;");
    assert!(circles(&[defined, uses]).is_empty());
    let calls = ("m/mod.rs", "mod a;\npub struct S;\nfn g() {\n    a::f()\n}");
    assert_eq!(circles(&[calls, uses]), [["m/mod", "m/a"]]);
    let returns = ("m/mod.rs", "mod a;\npub use a::A;\npub struct S;\nfn g() -> A {\n}");
    assert_eq!(circles(&[returns, uses]), [["m/mod", "m/a"]]);
}
