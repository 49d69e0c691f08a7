//! `naoisis leaderboard`: a table from files of results.

use clap::Args;
use core::fmt::Write;
use serde_json::{json, to_string_pretty};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use super::challenge::{read_results, verify, write};
use super::interrupt::Interrupt;
use super::outputs::{Output, check_files};
use super::report::{CommandResult, OrReport};
use super::terminal::Printer;
use super::{Program, report};
use naoisis_agents::environment::challenge::{CHALLENGES, IMAGES, RECORD_SEED, UNSEEN};
use naoisis_agents::environment::results::{ChallengeResult, MethodScore, ResultFile, interactions_in_words};
use naoisis_core::replace_file::replace_file;

/// Arguments of `naoisis leaderboard`.
#[derive(Args, Debug, Clone)]
pub struct LeaderboardArguments {
    /// Folder with files of results, of `naoisis challenge --out`
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Play every result again, and leave out files of which something comes out otherwise
    #[arg(long)]
    verify: bool,
    /// Start the programs that files of results name, for --verify, instead of playing their recorded commands; they can do whatever you can do
    #[arg(long, requires = "verify")]
    programs: bool,
    /// Write the table as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write the table as a page
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Number of threads of --verify [default: one per core]
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Replace existing files
    #[arg(long)]
    force: bool,
}

/// A result with the name of its file.
struct Row {
    file: String,
    result: ChallengeResult,
}

/// Runs the command.
pub fn leaderboard(program: Program, arguments: &LeaderboardArguments) -> CommandResult {
    let outputs = [("--json", &arguments.json), ("--html", &arguments.html)];
    let outputs = outputs.into_iter().filter_map(|(option, path)| Some(Output { option, path: path.clone()? }));
    let outputs: Vec<Output> = outputs.collect();
    check_files(Path::new(""), &outputs, arguments.force).or_usage_error()?;
    let files = files_of(&arguments.folder).or_usage_error()?;
    if files.is_empty() {
        let message = "there are no files of results in it; expected those of `naoisis challenge --out`";
        return Err(report::usage_error(&format!("{}: {message}", arguments.folder.display())));
    }
    // A table of before is no result, and may be replaced.
    let mut results = files.iter().filter(|path| read_results(path).is_ok());
    results.try_for_each(|path| check_files(path, &outputs, arguments.force)).or_usage_error()?;
    let interrupt = Interrupt::finish_running().or_failure()?;
    let mut printer = Printer::default();
    let mut status = ExitCode::SUCCESS;
    let mut rows = Vec::new();
    for path in files {
        if interrupt.is_stopped() {
            break;
        }
        let read = read_results(&path).and_then(|file| {
            if !arguments.verify
                || verify(program, &file, (arguments.threads, arguments.programs), &interrupt, &mut printer)
                    == Ok(ExitCode::SUCCESS)
            {
                return Ok(file);
            }
            let why = if interrupt.is_stopped() { "it is not verified" } else { "it is not confirmed" };
            Err(format!("{}: {why}", path.display()))
        });
        match read {
            Ok(ResultFile { results }) => {
                let file = path.file_name().unwrap_or_default().to_string_lossy();
                for result in results {
                    match rows.iter().find(|row: &&Row| row.result == result) {
                        Some(row) => report::note(&format!("left out: {}: {} has the same", path.display(), row.file)),
                        None => rows.push(Row { file: file.clone().into_owned(), result }),
                    }
                }
            }
            Err(message) => status = report::failure(&format!("left out: {message}")),
        }
    }
    sort(&mut rows);
    printer.print(table(&rows));
    if let Some(path) = &arguments.json {
        write(path, "--json", to_string_pretty(&rows.iter().map(as_json).collect::<Vec<_>>())).or_failure()?;
    }
    if let Some(path) = &arguments.html {
        let written = replace_file(path, |mut file| std::io::Write::write_all(&mut file, page(&rows).as_bytes()));
        written.map_err(|problem| format!("--html: {}: {problem}", path.display())).or_failure()?;
    }
    Ok(interrupt.finish(printer.finish(status)))
}

/// The JSON files of a folder, sorted by name.
fn files_of(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let with_name = |error| format!("{}: {error}", folder.display());
    let files: Result<Vec<PathBuf>, _> =
        fs::read_dir(folder).map_err(with_name)?.map(|entry| entry.map(|entry| entry.path())).collect();
    let mut files = files.map_err(with_name)?;
    files.retain(|path| path.extension().is_some_and(|ending| ending == "json"));
    files.sort();
    Ok(files)
}

/// Sorts by challenge, realism and robot; then the most successful and the fastest player is first.
fn sort(rows: &mut [Row]) {
    let share = |row: &Row| row.result.rate.share().map_or(0.0, |share| share.value);
    let time_s = |row: &Row| row.result.rate.mean_time_s.unwrap_or(f64::INFINITY);
    rows.sort_by(|one, other| {
        group(one)
            .cmp(&group(other))
            .then(share(other).total_cmp(&share(one)))
            .then(time_s(one).total_cmp(&time_s(other)))
            .then_with(|| one.result.player.cmp(&other.result.player))
    });
}

/// The challenge, realism and robot of a result.
fn group(row: &Row) -> (usize, &str, &'static str, &str) {
    let ChallengeResult { challenge, realism, robot, .. } = &row.result;
    let name = challenge.trim_end_matches(UNSEEN).trim_end_matches(IMAGES).trim_end_matches(UNSEEN);
    let index = CHALLENGES.iter().position(|(known, _)| *known == name);
    (index.unwrap_or(usize::MAX), challenge, realism.name(), robot.as_deref().unwrap_or_default())
}

fn title(row: &Row) -> String {
    let ChallengeResult { challenge, version, realism, robot, .. } = &row.result;
    let robot = robot.as_ref().map(|robot| format!(", robot {robot}")).unwrap_or_default();
    format!("{challenge}-v{version}, realism {realism}{robot}")
}

/// The scores of files with several policies in the rows of one challenge: each file has the policies of one training method.
fn scores(rows: &[Row]) -> Vec<String> {
    let mut files: Vec<&str> = rows.iter().map(|row| row.file.as_str()).collect();
    files.sort_unstable();
    files.dedup();
    let score = |file: &str| MethodScore::of(rows.iter().filter(|row| row.file == file).map(|row| &row.result));
    files.iter().filter_map(|file| Some(format!("{file}, {}", score(file)?))).collect()
}

/// Player, success with its interval, time, episodes and seeds, interactions, version and file.
fn cells(row: &Row) -> [String; 8] {
    let result = &row.result;
    let percent = |share: f64| format!("{:.1}", 100.0 * share);
    let share = result.rate.share();
    let first_seed = result.episodes.first().map_or(0, |attempt| attempt.seed);
    [
        result.player.clone(),
        share.map(|share| percent(share.value)).unwrap_or_default(),
        share.map(|share| format!("{} to {}", percent(share.low), percent(share.high))).unwrap_or_default(),
        result.rate.mean_time_s.map_or_else(|| "-".to_owned(), |time_s| format!("{time_s:.1}")),
        result.rate.episodes.to_string(),
        if first_seed == RECORD_SEED { "record".to_owned() } else { format!("from {first_seed}") },
        result.interactions.map(interactions_in_words).unwrap_or_default(),
        format!("{} ({})", row.file, result.naoisis),
    ]
}

/// The titles of the columns.
const COLUMNS: [&str; 8] =
    ["player", "success %", "95 % interval", "time s", "episodes", "seeds", "interactions", "file (naoisis)"];

fn table(rows: &[Row]) -> String {
    let mut text = String::new();
    let line = |text: &mut String, cells: [&str; 8]| {
        let [player, share, interval, time, episodes, seeds, interactions, file] = cells;
        let _ = write!(text, "{player:26} {share:>9} {interval:>14} {time:>7} {episodes:>8}  ");
        let _ = writeln!(text, "{seeds:12} {interactions:20} {file}");
    };
    for rows in rows.chunk_by(|one, other| group(one) == group(other)) {
        let _ = writeln!(text, "\n{}", rows.first().map(title).unwrap_or_default());
        line(&mut text, COLUMNS);
        for row in rows {
            line(&mut text, cells(row).each_ref().map(String::as_str));
        }
        for score in scores(rows) {
            let _ = writeln!(text, "{score}");
        }
    }
    text
}

fn as_json(row: &Row) -> serde_json::Value {
    let result = &row.result;
    let share = result.rate.share().map(|share| json!([share.value, share.low, share.high]));
    json!({
        "challenge": result.challenge, "version": result.version, "realism": result.realism, "robot": result.robot,
        "player": result.player, "interactions": result.interactions, "success": share, "rate": result.rate,
        "first_seed": result.episodes.first().map(|attempt| attempt.seed), "naoisis": result.naoisis, "file": row.file,
    })
}

/// The table as one page that loads nothing.
fn page(rows: &[Row]) -> String {
    let escaped = |text: &str| text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    let mut text = "<!doctype html>\n<html lang=\"en\"><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\">\
        <title>Challenges of naoisis</title>\n<style>body{font:16px sans-serif;max-width:60em;margin:auto;padding:1em}\
        table{border-collapse:collapse;width:100%}th,td{text-align:left;padding:.2em .6em;border-bottom:1px solid #ccc}</style>\n\
        <h1>Challenges of naoisis</h1>\n"
        .to_owned();
    for rows in rows.chunk_by(|one, other| group(one) == group(other)) {
        let _ = writeln!(text, "<h2>{}</h2>\n<table>", escaped(&rows.first().map(title).unwrap_or_default()));
        let _ = writeln!(text, "<tr>{}</tr>", COLUMNS.map(|column| format!("<th>{column}</th>")).concat());
        for row in rows {
            let cells = cells(row).map(|cell| format!("<td>{}</td>", escaped(&cell)));
            let _ = writeln!(text, "<tr>{}</tr>", cells.concat());
        }
        text.push_str("</table>\n");
        for score in scores(rows) {
            let _ = writeln!(text, "<p>{}</p>", escaped(&score));
        }
    }
    text
}
