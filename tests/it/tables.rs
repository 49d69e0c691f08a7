//! Tables of a match: Parquet and CSV.

use std::fs;
use std::path::Path;

use naoisis::record::tables::TABLES;

use crate::support::{naoisis, text};

fn convert(folder: &Path, arguments: &str) -> (Option<i32>, String) {
    let arguments: Vec<&str> = format!("convert t.jsonl.zst {arguments}").leak().split(' ').collect();
    let output = naoisis(folder, &arguments);
    (output.status.code(), text(&output.stderr) + &text(&output.stdout))
}

#[test]
fn a_trace_becomes_tables_once_or_by_force() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let output = naoisis(folder, &["run", "match3v3", "--duration", "3", "--quiet", "--trace", "t.jsonl.zst"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let (status, words) = convert(folder, "--parquet p --csv c");
    assert_eq!(status, Some(0), "{words}");
    assert!(words.contains("tables p/*.parquet") && words.contains("tables c/*.csv"), "{words}");
    for table in &TABLES {
        assert!(folder.join("p").join(table.name).with_extension("parquet").is_file(), "{}", table.name);
    }
    let rows = |name: &str| fs::read_to_string(folder.join("c").join(name)).unwrap().lines().count() - 1;
    // The start and 90 cycles.
    assert_eq!((rows("cycles.csv"), rows("robots.csv")), (91, 6 * 91));
    assert!(rows("percepts.csv") > 500 && rows("beliefs.csv") > 6 * 91);
    let before = fs::read(folder.join("p/robots.parquet")).unwrap();
    let (status, words) = convert(folder, "--parquet p");
    assert!(status == Some(2) && words.starts_with("error: --parquet: p/cycles.parquet: the file exists"), "{words}");
    assert_eq!(convert(folder, "--parquet p --force").0, Some(0));
    assert!(fs::read(folder.join("p/robots.parquet")).unwrap() == before, "the same trace, the same bytes");
    let (status, words) = convert(folder, "--parquet nowhere/p");
    assert!(status == Some(2) && words.starts_with("error: nowhere/p: there is no folder nowhere"), "{words}");
    let (status, words) = convert(folder, "--csv t.jsonl.zst");
    assert!(status == Some(1) && words.starts_with("error: t.jsonl.zst: this is a file; expected a folder"), "{words}");
    assert_eq!(convert(folder, "").0, Some(2));
}

#[test]
fn the_guide_describes_every_column() {
    let guide = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("src/guide/tables.md")).unwrap();
    for table in &TABLES {
        let mut section =
            format!("\n## `{}`\n\n{}\n\n| column | what it is |\n|---|---|\n", table.name, table.description);
        for column in table.columns {
            section += &format!("| `{}` | {} |\n", column.name, column.description);
        }
        assert!(guide.contains(&section), "src/guide/tables.md lacks:\n{section}");
    }
}
