//! Checks the tests that docs/systems.md names: each file exists, and contains each test.
//!
//! The last cell of a row has files, each by its path or by its name beside the file before it,
//! followed by the beginnings of tests' names.

use std::fs;
use std::path::{Path, PathBuf};

/// The file of a path of the page.
fn place(root: &Path, name: &str) -> PathBuf {
    match name.strip_prefix("rig/") {
        Some(rest) => root.join("firmware/rig").join(rest),
        None => root.join("crates").join(name),
    }
}

/// The fault of a row's last cell.
fn fault(root: &Path, cell: &str) -> Option<String> {
    let mut last: Option<PathBuf> = None;
    for name in cell.split('`').skip(1).step_by(2) {
        if name.ends_with(".rs") || name.ends_with('/') {
            let beside = last.as_ref().and_then(|last| last.parent()).map(|dir| dir.join(name));
            let path = if name.contains('/') { place(root, name) } else { beside? };
            if !path.exists() {
                return Some(format!("there is no {name}"));
            }
            last = Some(path);
            continue;
        }
        let Some(file) = &last else { return Some(format!("{name} is in no file")) };
        let text = fs::read_to_string(file).unwrap_or_default();
        let (begin, whole) = match name.strip_suffix('…') {
            Some(begin) => (begin, ""),
            None => (name, "("),
        };
        if !text.contains(&format!("fn {begin}{whole}")) {
            return Some(format!("{} has no test {name}", file.display()));
        }
    }
    None
}

#[test]
fn every_feature_has_its_test() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the checkout");
    let page = fs::read_to_string(root.join("docs/systems.md")).expect("the page");
    let mut rows = 0;
    for line in page.lines().filter(|line| line.starts_with('|') && !line.starts_with("| ---")) {
        let cells: Vec<_> = line.trim_matches('|').split('|').map(str::trim).collect();
        let [feature, _, _, tests] = cells[..] else { continue };
        if tests == "test" {
            continue;
        }
        rows += 1;
        let named = !tests.is_empty() && !tests.contains("not yet") && !line.contains("not yet");
        assert!(named, "{feature}: no test");
        let fault = fault(root, tests);
        assert!(fault.is_none(), "{feature}: {}", fault.unwrap_or_default());
    }
    assert!(rows > 40, "{rows} rows");
}

#[test]
fn a_test_that_is_not_there_is_seen() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the checkout");
    let fault = |cell| fault(root, cell);
    assert_eq!(fault("`rig/tests/cycles.rs` `calibrations…`; `cycle.rs`"), None);
    assert_eq!(fault("`rig/tests/nowhere.rs`").unwrap(), "there is no rig/tests/nowhere.rs");
    assert!(fault("`rig/tests/cycles.rs` `calibrations`").unwrap().contains("has no test"));
    assert!(fault("`calibrations…`").unwrap().contains("in no file"));
}
