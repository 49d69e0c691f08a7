//! Pages of matches for a browser, and traces that are written again in another format.

use std::fs;
use std::path::Path;

use naoisis::record::page::TEMPLATE;

use crate::support::{naoisis, text};

const TRACE: &str = "t.jsonl.zst";

/// A folder with a trace and a page of one match.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let line = "run match3v3 --duration 5 --html p.html --trace t.jsonl.zst";
    let output = naoisis(folder.path(), &line.split(' ').collect::<Vec<_>>());
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("page   p.html, 0."), "{}", text(&output.stdout));
    folder
}

fn convert(folder: &Path, file: &str) -> (Option<i32>, String) {
    let output = naoisis(folder, &["convert", TRACE, file]);
    (output.status.code(), text(&output.stderr))
}

#[test]
fn a_page_is_the_same_in_every_run_and_changes_no_trace() {
    let [one, other] = [folder(), folder()];
    let read = |folder: &tempfile::TempDir, name: &str| fs::read(folder.path().join(name)).unwrap();
    let page = read(&one, "p.html");
    assert!(page == read(&other, "p.html"));
    assert!(page.starts_with(TEMPLATE.as_bytes()));
    let output =
        naoisis(other.path(), &["run", "match3v3", "--duration", "5", "--quiet", "--trace", "alone.jsonl.zst"]);
    assert!(output.status.success());
    assert!(read(&one, TRACE) == read(&other, "alone.jsonl.zst"));
}

#[test]
fn a_trace_becomes_what_the_ending_says() {
    let folder = folder();
    let folder = folder.path();
    assert_eq!(convert(folder, "c.html"), (Some(0), String::new()));
    assert!(fs::read_to_string(folder.join("c.html")).unwrap().starts_with(TEMPLATE));
    // A trace of a trace is the same trace.
    assert_eq!(convert(folder, "c.jsonl.zst"), (Some(0), String::new()));
    assert!(fs::read(folder.join("c.jsonl.zst")).unwrap() == fs::read(folder.join(TRACE)).unwrap());
    let output = naoisis(folder, &["replay", TRACE, "r.html"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(fs::read(folder.join("r.html")).unwrap() == fs::read(folder.join("c.html")).unwrap());
    assert_eq!(naoisis(folder, &["replay", TRACE, "r.html"]).status.code(), Some(2));
    assert!(naoisis(folder, &["replay", TRACE, "r.html", "--force"]).status.success());
    let (status, words) = convert(folder, "nowhere/c.html");
    assert!(
        status == Some(2) && words.starts_with("error: nowhere/c.html: there is no folder nowhere; expected"),
        "{words}"
    );
    for (file, said) in [
        ("c.html", "error: FILE: c.html: the file exists already; expected another name, or --force to replace it"),
        ("c.gif", "error: c.gif: no format has this ending; expected one of .html, "),
        (TRACE, "error: FILE: t.jsonl.zst: this would replace t.jsonl.zst, which the command reads"),
    ] {
        let (status, words) = convert(folder, file);
        assert!(status == Some(2) && words.starts_with(said), "{file}: {words}");
    }
}

#[test]
fn nothing_is_left_of_the_conversion_of_a_damaged_trace() {
    let folder = folder();
    let folder = folder.path();
    assert_eq!(convert(folder, "plain.jsonl").0, Some(0));
    let mut damaged = fs::read(folder.join("plain.jsonl")).unwrap();
    let middle = damaged.len() / 2;
    let line = middle + damaged[middle..].iter().position(|byte| *byte == b'\n').unwrap();
    damaged[line + 1] = b'x';
    fs::write(folder.join("damaged.jsonl"), damaged).unwrap();
    for file in ["new.html", "new.mcap", "new.jsonl"] {
        let output = naoisis(folder, &["convert", "damaged.jsonl", file]);
        assert_eq!(output.status.code(), Some(2), "{file}: {}", text(&output.stderr));
        assert!(!folder.join(file).exists(), "{file}");
    }
}

#[test]
fn a_trace_that_breaks_off_is_converted_as_far_as_it_goes() {
    let folder = folder();
    let folder = folder.path();
    assert_eq!(convert(folder, "plain.jsonl").0, Some(0));
    let whole = fs::read(folder.join("plain.jsonl")).unwrap();
    fs::write(folder.join(TRACE), "").unwrap();
    fs::write(folder.join("cut.jsonl"), &whole[..whole.len() / 2]).unwrap();
    let output = naoisis(folder, &["convert", "cut.jsonl", "cut.html"]);
    assert!(output.status.success());
    assert!(text(&output.stderr).contains("the trace is incomplete: it is converted as far as it goes"));
    let header = whole.split(|byte| *byte == b'\n').next().unwrap();
    fs::write(folder.join("head.jsonl"), [header, b"\n"].concat()).unwrap();
    let output = naoisis(folder, &["convert", "head.jsonl", "head.html"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        text(&output.stderr).contains("head.jsonl: the trace has no cycle after its header"),
        "{}",
        text(&output.stderr)
    );
    assert!(!folder.join("head.html").exists());
}
