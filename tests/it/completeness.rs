//! Additions are documented: examples and commands are in the README and the guide, and the guide has a page on each area.

use std::path::{Path, PathBuf};

use crate::support::{naoisis, text};

fn of_package(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

fn read(path: &str) -> String {
    std::fs::read_to_string(of_package(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// The names of the files of a folder that end so, without that, sorted.
fn files(folder: &str, end: &str) -> Vec<String> {
    let entries = of_package(folder).read_dir().unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<String> = names.filter_map(|name| name.strip_suffix(end).map(str::to_owned)).collect();
    names.sort();
    names
}

/// The first cells of a text's table rows that are set in code.
fn rows(text: &str) -> Vec<String> {
    let cell = |line: &str| {
        let row = line.trim_start_matches("//! ").strip_prefix("| `")?;
        row.split_once("` |").map(|(cell, _)| cell.to_owned())
    };
    text.lines().filter_map(cell).collect()
}

#[test]
fn every_example_has_a_row_in_the_readme_and_in_the_guide() {
    for path in ["README.md", "src/guide/mod.rs"] {
        let rows = rows(&read(path));
        for example in files("examples", ".rs") {
            assert!(rows.contains(&example), "{path} has no row `{example}` in its table of examples");
        }
    }
}

#[test]
fn every_command_is_in_the_readme() {
    let folder = tempfile::tempdir().unwrap();
    let help = text(&naoisis(folder.path(), &["--help"]).stdout);
    let commands: Vec<&str> = help
        .lines()
        .skip_while(|line| *line != "Commands:")
        .skip(1)
        .take_while(|line| line.starts_with("  "))
        .filter_map(|line| line.split_whitespace().next())
        .filter(|command| *command != "help")
        .collect();
    assert!(commands.contains(&"run") && commands.len() >= 8, "{help}");
    let readme = read("README.md");
    for command in commands {
        assert!(readme.contains(&format!("`naoisis {command}")), "the README says nothing of `naoisis {command}`");
    }
}

#[test]
fn every_page_of_the_guide_is_shown_and_led_to() {
    let guide = read("src/guide/mod.rs");
    for page in files("src/guide", ".md") {
        assert!(guide.contains(&format!("include_str!(\"{page}.md\")")), "{page}.md is not shown");
        assert!(guide.contains(&format!("]({page})")), "nothing leads to {page}.md");
    }
    let extending = read("src/guide/extending.md");
    for page in files("src/guide/extending", ".md") {
        assert!(guide.contains(&format!("include_str!(\"extending/{page}.md\")")), "extending/{page}.md is not shown");
        assert!(extending.contains(&format!("](extending::{page}")), "nothing leads to extending/{page}.md");
    }
}
