//! Who may import whom: the layers of the crate, one way only, and Python nowhere but at the wall.

use std::fs;
use std::path::{Path, PathBuf};

/// For each top-level module, the others that it may import, beside those that are for all.
const ALLOWED: [(&str, &[&str]); 14] = [
    ("error", &[]),
    ("diagnostic", &["chart"]),
    ("progress", &[]),
    ("cloud", &[]),
    ("chart", &["cloud", "som"]),
    ("topology", &["cloud", "chart"]),
    ("som", &["cloud"]),
    ("nurbs", &[]),
    ("fit", &["nurbs"]),
    ("mesh", &["nurbs"]),
    ("export", &["nurbs", "mesh"]),
    ("validate", &["cloud", "nurbs"]),
    ("pipeline", &["cloud", "chart", "topology", "validate", "som", "nurbs", "fit", "mesh"]),
    (
        "python",
        &["cloud", "chart", "validate", "som", "nurbs", "fit", "mesh", "export", "pipeline"],
    ),
];

const FOR_ALL: [&str; 3] = ["error", "diagnostic", "progress"];

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
