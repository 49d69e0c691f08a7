//! The command line, run as its user runs it.

use std::fs;
use std::process::{Command, Output};

use crate::support::{naoisis, text};

#[test]
fn a_match_runs_from_any_folder_and_prints_its_result() {
    let folder = tempfile::tempdir().unwrap();
    let output = naoisis(folder.path(), &["run", "kick_right_straight"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("blue 0 : 0 pink"));
    let output = naoisis(folder.path(), &["run", "kick_right_straight", "--quiet"]);
    assert!(output.status.success() && output.stdout.is_empty() && output.stderr.is_empty());
}

#[test]
fn beliefs_are_summed_up_for_each_robot_and_for_all_and_the_table_says_how_real_the_match_was() {
    let folder = tempfile::tempdir().unwrap();
    let line = "run match3v3 --duration 20 --set kicks.speed_sd=0.1 --beliefs b.csv";
    let output = naoisis(folder.path(), &line.split(' ').collect::<Vec<_>>());
    assert!(output.status.success(), "{}", text(&output.stderr));
    let said = text(&output.stdout);
    let rows: Vec<Vec<&str>> = said.lines().map(|line| line.split_whitespace().collect()).collect();
    let row = |robot: &str| rows.iter().find(|row| row.first() == Some(&robot)).unwrap();
    // The largest error of all is that of one of them: position, its 90 %, the most.
    let most = |robot: &str| row(robot)[3].parse::<f64>().unwrap();
    let robots = ["blue1", "blue2", "blue3", "pink1", "pink2", "pink3"].map(most);
    assert_eq!(most("all"), robots.into_iter().fold(0.0, f64::max));
    let table = fs::read_to_string(folder.path().join("b.csv")).unwrap();
    let mut lines = table.lines();
    assert!(lines.next().unwrap().ends_with(",realism"));
    assert!(lines.all(|line| line.ends_with(",\"paper but for kicks\"")), "{table}");
}

#[test]
fn a_trace_has_a_header_the_start_every_cycle_and_an_end() {
    let folder = tempfile::tempdir().unwrap();
    let output = naoisis(folder.path(), &["run", "match3v3", "--duration", "2", "--seed", "9", "--trace", "-"]);
    assert!(output.status.success());
    let lines: Vec<serde_json::Value> =
        text(&output.stdout).lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(lines.len(), 1 + 61 + 1);
    assert_eq!(lines[0]["format"], "naoisis-trace");
    assert_eq!(lines[0]["seed"], 9);
    for (cycle, line) in lines[1..=61].iter().enumerate() {
        assert_eq!((line["type"].as_str(), line["cycle"].as_u64()), (Some("cycle"), Some(cycle as u64)));
        assert_eq!(line["robots"].as_array().unwrap().len(), 6);
    }
    assert_eq!(lines[62]["type"], "end");
    assert_eq!(lines[62]["cycles"], 60);
    assert!(lines[62]["messages"]["blue"]["sent"].as_u64().unwrap() > 0);
    // What the command has to say goes to standard error.
    assert!(text(&output.stderr).contains("times real time"));
}

#[test]
fn a_trace_is_compressed_by_its_name() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["plain.jsonl", "small.jsonl.zst"] {
        let output = naoisis(folder.path(), &["run", "match3v3", "--duration", "1", "--trace", name, "--quiet"]);
        assert!(output.status.success(), "{}", text(&output.stderr));
    }
    let plain = fs::read(folder.path().join("plain.jsonl")).unwrap();
    let small = fs::read(folder.path().join("small.jsonl.zst")).unwrap();
    assert!(small.len() < plain.len());
    assert!(zstd::decode_all(small.as_slice()).unwrap() == plain);
}

#[test]
fn the_match_report_says_what_was_decided_why_and_what_would_have_changed_it() {
    let folder = tempfile::tempdir().unwrap();
    let goal = r#"{ "name": "a goal", "duration_s": 2, "ball": { "position_m": [2.5, 0.2], "velocity_mps": [2, 0] },
        "robots": [{ "number": 2, "pose": [-1, 1, 0] }],
        "interventions": [{ "at_s": 1.5, "do": { "penalise": { "robot": "blue2" } } }] }"#;
    fs::write(folder.path().join("goal.json"), goal).unwrap();
    let output = naoisis(folder.path(), &["run", "goal.json", "--explain"]);
    let report = text(&output.stdout);
    let lines: Vec<&str> = report.lines().collect();
    assert_eq!(lines[0], "a goal. Rules naoisis, realism paper, seed 1.");
    assert_eq!(lines[1].split_whitespace().collect::<Vec<_>>(), ["time", "to", "play", "decision"]);
    // x = 2.5 + 4 (1 - exp(-0.5 t)) passes 3.025 + 0.03 after 0.298 s, in the ninth cycle of 1/30 s.
    let goal = lines.iter().position(|line| line.ends_with("Goal for blue.")).unwrap();
    assert_eq!(lines[goal].trim_start(), "0:00.30    9:59.70  Goal for blue.");
    for (line, start) in lines[goal + 1..].iter().zip(["Rule: ", "At (3.06, 0.20)", "Measured: ", "Otherwise: "]) {
        assert!(line.trim_start().starts_with(start), "{line}");
    }
    assert!(report.contains("blue2 is penalised"), "{report}");
    let tally = lines.iter().find(|line| line.trim_start().starts_with("decided ")).unwrap();
    assert!(tally.contains("1 goal") && tally.contains("1 kick off") && tally.contains("1 penalty"), "{tally}");
    assert!(report.contains("blue 1 : 0 pink"));
    // Without it, none of that.
    let short = text(&naoisis(folder.path(), &["run", "goal.json"]).stdout);
    assert!(!short.contains("Rule: ") && !short.contains("decided"), "{short}");
}

#[test]
fn what_is_wrong_is_said_with_exit_status_2() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("typo.json"), "{\n  \"sede\": 3,\n  \"bal\": 1\n}\n").unwrap();
    fs::write(folder.path().join("team.json"), r#"{ "teams": { "blue": "dragons" } }"#).unwrap();
    for (arguments, expected) in [
        (&["run", "nowhere.json"][..], "nowhere.json"),
        (&["run", "match3v4"], "match3v3"),
        (&["run", "typo.json"], "typo.json:2:3"),
        (&["run", "typo.json"], "typo.json:3:3"),
        (&["play", "typo.json"], "typo.json:3:3"),
        (&["batch", "typo.json", "--matches", "1"], "typo.json:3:3"),
        (&["vision", "typo.json"], "typo.json:3:3"),
        (&["check", "typo.json"], "seed"),
        (&["run", "team.json"], "chasers"),
        (&["run", "match3v3", "--duration", "-1"], "positive"),
        (&["run", "match3v3", "--seed", "x"], "--seed"),
        (&["run", "match3v3", "--trace", "no/such/folder/t.jsonl"], "no/such/folder"),
        (&["run", "match3v3", "--cameras", "film"], "software"),
        (&["run", "match3v3_images", "--cameras", "off"], "robots see by their images"),
        (&["run"], "SCENARIO"),
        (&["list", "dragons"], "scenarios"),
    ] {
        let output = naoisis(folder.path(), arguments);
        let said = text(&output.stderr) + &text(&output.stdout);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
        assert!(said.contains(expected), "{arguments:?}: {said}");
        assert!(!said.contains("panicked"), "{arguments:?}: {said}");
    }
}

#[test]
fn lists_name_what_there_is() {
    let folder = tempfile::tempdir().unwrap();
    for (what, expected) in [
        ("scenarios", "match3v3"),
        ("teams", "chasers"),
        ("behaviours", "striker"),
        ("fields", "spl2025"),
        ("rules", "naoisis"),
        ("challenges", "ScoreEmptyGoal"),
    ] {
        let output = naoisis(folder.path(), &["list", what]);
        assert!(output.status.success() && text(&output.stdout).contains(expected), "{}", text(&output.stdout));
    }
}

#[test]
fn a_saved_match_goes_on_as_if_it_had_never_stopped_or_branches_off() {
    let folder = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| {
        let output = naoisis(folder.path(), &[&["run"], arguments].concat());
        assert!(output.status.success(), "{}", text(&output.stderr));
        text(&output.stdout)
    };
    let last_cycle = |trace: &str| {
        let lines: Vec<&str> = trace.lines().collect();
        lines[lines.len() - 2].to_owned()
    };
    let whole = run(&["match3v3", "--duration", "4", "--trace", "-", "--save", "half.naoisis", "--save-at", "2"]);
    let rest = run(&["half.naoisis", "--duration", "4", "--trace", "-"]);
    assert_eq!(rest.lines().count(), 1 + 61 + 1);
    assert_eq!(last_cycle(&whole), last_cycle(&rest));
    let branch = run(&["half.naoisis", "--duration", "4", "--trace", "-", "--set", "messages.loss=1"]);
    assert_ne!(last_cycle(&whole), last_cycle(&branch));
    assert!(last_cycle(&branch).contains("\"inbox\":[]"));

    for (arguments, words) in [
        (&["half.naoisis", "--seed", "3"][..], "--seed: a saved match"),
        (&["half.naoisis", "--set", "field.length_m=7"], "--set field.length_m=7: `field.length_m` cannot change"),
        (&["half.naoisis", "--set", "messages.loss=2"], "--set messages.loss=2: `loss` is 2"),
        (&["half.naoisis", "--duration", "2"], "half.naoisis: the match is over after 2.0 s"),
        (&["nowhere.naoisis"], "nowhere.naoisis: "),
        (&["match3v3", "--save", "half.json"], "--save: half.json: expected a file name that ends in .naoisis"),
        (&["half.naoisis", "--trace", "half.naoisis"], "--trace: half.naoisis: this would replace half.naoisis"),
    ] {
        let output = naoisis(folder.path(), &[&["run"], arguments].concat());
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(text(&output.stderr).contains(words), "{}", text(&output.stderr));
    }
}

#[test]
fn the_parts_of_a_batch_merge_to_the_table_and_the_summary_of_one_machine() {
    let folder = tempfile::tempdir().unwrap();
    let batch = |more: &[&str]| {
        let arguments = ["batch", "match3v3", "--matches", "4", "--duration", "1", "--set", "messages.loss=0,0.5"];
        naoisis(folder.path(), &[&arguments, more].concat())
    };
    assert!(batch(&["--csv", "whole.csv"]).status.success());
    for shard in ["3/3", "1/3", "2/3"] {
        let file = format!("part{}.csv", &shard[..1]);
        assert!(batch(&["--shard", shard, "--csv", &file]).status.success());
        // A part that is there already is gone on with.
        assert!(batch(&["--shard", shard, "--csv", &file, "--threads", "1"]).status.success());
    }
    let merged = batch(&["--csv", "merged.csv", "--merge", "part2.csv", "part3.csv", "part1.csv"]);
    assert!(merged.status.success());
    let read = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap();
    assert_eq!(read("merged.csv"), read("whole.csv"));
    let summary = |output: &Output| text(&output.stdout).split("\n8 ").next().unwrap().to_owned();
    let again = batch(&["--csv", "whole.csv"]);
    assert_eq!(summary(&merged), summary(&again));
    let missing = batch(&["--merge", "part1.csv", "part3.csv"]);
    assert_eq!(missing.status.code(), Some(2));
    let words = "of 8 matches 3 are in none of the tables: 3 to 5; expected all of them";
    assert!(text(&missing.stderr).contains(words), "{}", text(&missing.stderr));
    for wrong in ["0/3", "4/3", "1", "a/b", "1/0"] {
        let refused = batch(&["--shard", wrong]);
        assert_eq!(refused.status.code(), Some(2));
        assert!(text(&refused.stderr).contains("from 1/4 to 4/4"), "{}", text(&refused.stderr));
    }
}

#[test]
fn a_batch_goes_on_where_it_was_and_reports_what_fails() {
    let folder = tempfile::tempdir().unwrap();
    let batch = |matches: &str, threads: &str| {
        let sweep = "messages.loss=0,1";
        let arguments = ["batch", "match3v3", "--duration", "2", "--csv", "table.csv", "--set", sweep];
        naoisis(folder.path(), &[&arguments[..], &["--matches", matches, "--threads", threads]].concat())
    };
    assert!(batch("1", "1").status.success());
    let first = fs::read_to_string(folder.path().join("table.csv")).unwrap();
    let output = batch("3", "2");
    assert!(output.status.success());
    assert!(text(&output.stdout).contains("6 of 6 matches, 2 of them played earlier"), "{}", text(&output.stdout));
    let table = fs::read_to_string(folder.path().join("table.csv")).unwrap();
    assert!(table.starts_with(&first) && table.lines().count() == 7, "{table}");
    let output = naoisis(folder.path(), &["batch", "match3v3", "--matches", "1", "--csv", "table.csv"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("table.csv:1: the table has `messages.loss`, which this batch has not"));
    let output = naoisis(
        folder.path(),
        &["batch", "match3v3", "--matches", "1", "--csv", "table.csv", "--set", "messages.loss=0,1"],
    );
    assert_eq!(output.status.code(), Some(2));
    let words = "table.csv:2: the duration is 2 s, and not given in this batch";
    assert!(text(&output.stderr).contains(words), "{}", text(&output.stderr));
}

#[test]
fn a_batch_finds_the_mistakes_of_all_its_matches_and_goes_on_with_them() {
    let folder = tempfile::tempdir().unwrap();
    let batch = |more: &[&str]| {
        let arguments = ["batch", "match3v3", "--duration", "20", "--pairs", "chasers,roles"];
        naoisis(folder.path(), &[&arguments, more].concat())
    };
    let read = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap();
    let whole = batch(&["--matches", "4", "--mistakes", "whole.csv"]);
    assert!(whole.status.success(), "{}", text(&whole.stderr));
    assert!(read("whole.csv").starts_with("match,seed,teams.blue,teams.pink,kind,robot,other,from_s,until_s,x_m,"));
    assert!(read("whole.csv").lines().skip(1).all(|line| line.ends_with(",paper")));
    // A setting that is called like another column has another name, as in the table of matches.
    let swept = batch(&["--matches", "2", "--realism", "paper,ideal", "--mistakes", "swept.csv"]);
    assert!(swept.status.success(), "{}", text(&swept.stderr));
    assert!(read("swept.csv").starts_with("match,seed,set.realism,teams.blue,"), "{}", read("swept.csv"));
    // What stands in the table is what `run` finds.
    let first = "run match3v3 --duration 20 --seed 1 --blue chasers --pink roles --quiet --mistakes run.json";
    assert!(naoisis(folder.path(), &first.split(' ').collect::<Vec<_>>()).status.success());
    let run: serde_json::Value = serde_json::from_str(&read("run.json")).unwrap();
    let of_first = read("whole.csv").lines().filter(|line| line.starts_with("1,")).count();
    assert_eq!(run["realism"], "paper");
    assert_eq!(run["mistakes"].as_array().unwrap().len(), of_first);
    assert!(of_first > 0);
    // In two goes it is the same, and so is what is said of it.
    let files = ["--csv", "table.csv", "--mistakes", "mistakes.csv"];
    assert!(batch(&[&files[..], &["--matches", "2"]].concat()).status.success());
    let again = batch(&[&files[..], &["--matches", "4"]].concat());
    assert_eq!(read("mistakes.csv"), read("whole.csv"));
    let counts = |output: &Output| text(&output.stdout).split("mistakes a match").nth(1).unwrap()[..60].to_owned();
    assert_eq!(counts(&again), counts(&whole));
    for (arguments, words) in [
        (&["--mistakes", "whole.csv"][..], "whole.csv: the file exists already"),
        (&["--csv", "table.csv", "--mistakes", "new.csv"], "new.csv: there is no such file, and 4 of the matches"),
        (&["--csv", "same.csv", "--mistakes", "same.csv"], "same.csv: --csv writes this file already"),
        (&["--csv", "other.csv", "--mistakes", "table.csv"], "table.csv:1: this is no table of this batch's mistakes"),
    ] {
        let output = batch(&[arguments, &["--matches", "4"]].concat());
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(text(&output.stderr).contains(words), "{}", text(&output.stderr));
    }
}

#[test]
fn a_model_that_errs_as_its_images_do_is_a_model_like_any_other() {
    let folder = tempfile::tempdir().unwrap();
    let fitted = naoisis(folder.path(), &["vision", "spl2025", "--scenes", "30", "--fit"]);
    assert!(fitted.status.success(), "{}", text(&fitted.stderr));
    assert!(text(&fitted.stderr).contains("vision.noise.ball.pixel_sd"), "{}", text(&fitted.stderr));
    fs::write(folder.path().join("mine.ron"), &fitted.stdout).unwrap();
    let checked = naoisis(folder.path(), &["check", "mine.ron"]);
    assert!(checked.status.success(), "{}", text(&checked.stderr));
    let seen =
        ["vision", "spl2025", "--set", "model=mine.ron", "--realism", "realistic", "--geometric", "--scenes", "3"];
    assert!(naoisis(folder.path(), &seen).status.success());
    let both = naoisis(folder.path(), &["vision", "spl2025", "--fit", "--geometric"]);
    assert_eq!(both.status.code(), Some(2));
}

#[test]
fn all_pairs_of_teams_play_in_both_colours_and_go_on_where_they_were() {
    let folder = tempfile::tempdir().unwrap();
    let pairs = |teams: &str, matches: &str| {
        let arguments = ["batch", "match3v3", "--duration", "1", "--csv", "pairs.csv", "--pairs", teams];
        naoisis(folder.path(), &[&arguments[..], &["--matches", matches]].concat())
    };
    assert!(pairs("all", "2").status.success());
    let output = pairs("all", "4");
    let words = text(&output.stdout);
    assert!(output.status.success() && words.contains("40 of 40 matches, 20 of them played earlier"), "{words}");
    assert!(words.contains("against passers") && words.contains("no difference that is sure"), "{words}");
    let table = fs::read_to_string(folder.path().join("pairs.csv")).unwrap();
    assert!(table.lines().next().unwrap().contains("teams.blue") && table.lines().count() == 41, "{table}");
    for (teams, matches, wrong) in [
        ("roles", "2", "two teams"),
        ("roles,nobody", "2", "`nobody`"),
        ("roles,roles", "2", "twice"),
        ("all", "3", "even"),
    ] {
        let output = pairs(teams, matches);
        assert_eq!(output.status.code(), Some(2));
        assert!(text(&output.stderr).contains(wrong), "{}", text(&output.stderr));
    }
}

/// A folder with `one.json`: a robot with small images, and no referee.
fn folder_with_one_robot() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let scenario = r#"{ "rules": "free", "robots": [{ "number": 1 }], "cameras": { "width": 64, "height": 48 } }"#;
    fs::write(folder.path().join("one.json"), scenario).unwrap();
    folder
}

#[test]
fn without_a_display_a_recorded_match_is_frames_of_the_field() {
    let folder = folder_with_one_robot();
    let scenario = r#"{ "rules": "free", "robots": [{ "number": 1 }], "duration_s": 0.1 }"#;
    fs::write(folder.path().join("one.json"), scenario).unwrap();
    let play = || {
        let mut command = Command::new(env!("CARGO_BIN_EXE_naoisis"));
        command.current_dir(folder.path()).env_remove("DISPLAY").args(["play", "one.json", "--record", "film"]);
        command.output().unwrap()
    };
    let output = play();
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(folder.path().join("film/field/000003.png").exists());
    let output = play();
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("not empty"), "{}", text(&output.stderr));
}

#[test]
fn frames_are_numbered_by_cycle_and_nothing_is_written_over() {
    let folder = folder_with_one_robot();
    let arguments = ["run", "one.json", "--duration", "0.2", "--frames", "frames", "--every", "3", "--quiet"];
    let output = naoisis(folder.path(), &[&arguments[..], &["--cameras", "software"]].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    let names = |name: &str| {
        let entries = fs::read_dir(folder.path().join("frames").join(name)).unwrap();
        let mut names: Vec<String> =
            entries.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    };
    assert_eq!(names(""), ["blue1_bottom", "blue1_top", "field"]);
    assert_eq!(names("field"), ["000000.png", "000003.png", "000006.png"]);
    assert_eq!(names("blue1_top"), ["000003.png", "000006.png"]);
    let output = naoisis(folder.path(), &arguments);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("the folder is not empty"), "{}", text(&output.stderr));
    let learning = ["run", "one.json", "--duration", "0.1", "--frames", "learning", "--cameras", "software", "--quiet"];
    let layers = ["--set", "cameras.labels=true", "--set", "cameras.depth=true", "--set", "cameras.which=top"];
    assert!(naoisis(folder.path(), &[&learning[..], &layers].concat()).status.success());
    for name in ["blue1_top", "blue1_top_labels", "blue1_top_depth"] {
        assert!(folder.path().join("learning").join(name).join("000002.png").exists(), "{name}");
    }
    // Late images have the number of the cycle in which they were taken, and there is one a cycle.
    let late = ["run", "one.json", "--duration", "0.2", "--frames", "late", "--cameras", "software", "--quiet"];
    let output = naoisis(folder.path(), &[&late[..], &["--set", "latency.image_s=0.067"]].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    let count = fs::read_dir(folder.path().join("late/blue1_top")).unwrap().count();
    assert_eq!((count, folder.path().join("late/blue1_top/000004.png").exists()), (4, true));
    // Chosen views are drawn whether or not the match renders images; those of robots that do not play cannot be.
    let arguments = ["run", "one.json", "--duration", "0.1", "--frames", "chosen", "--quiet", "--views"];
    assert!(naoisis(folder.path(), &[&arguments[..], &["blue1.bottom"]].concat()).status.success());
    let chosen = fs::read_dir(folder.path().join("chosen")).unwrap();
    assert_eq!(chosen.map(|entry| entry.unwrap().file_name()).collect::<Vec<_>>(), ["blue1_bottom"]);
    let output = naoisis(folder.path(), &[&arguments[..], &["pink1.top"]].concat());
    assert_eq!(output.status.code(), Some(2));
    assert!(
        text(&output.stderr).contains("there is no such robot in the match; expected one of blue1"),
        "{}",
        text(&output.stderr)
    );
    // Recording changes nothing of the match.
    let trace = |more: &[&str]| {
        let arguments = ["run", "match3v3", "--duration", "1", "--trace", "-", "--quiet"];
        text(&naoisis(folder.path(), &[&arguments[..], more].concat()).stdout)
    };
    assert!(trace(&[]) == trace(&["--frames", "others", "--every", "30"]));
}

#[test]
fn a_video_and_a_contact_sheet_come_of_a_match_and_nothing_is_written_over() {
    let folder = folder_with_one_robot();
    let arguments = ["run", "one.json", "--duration", "0.4", "--video", "match.mp4", "--sheet", "sheet.png", "--quiet"];
    let output = naoisis(folder.path(), &[&arguments[..], &["--views", "field,blue1.top", "--every", "4"]].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    let video = fs::read(folder.path().join("match.mp4")).unwrap();
    assert_eq!(&video[4..8], b"ftyp");
    // The video is as wide as the field's 960 pixels and a camera's 720 beside it: the track's header says so, in 16.16.
    let size: Vec<u8> = [960u32 + 720, 540].iter().flat_map(|size| (size << 16).to_be_bytes()).collect();
    assert!(video.windows(8).any(|bytes| bytes == size), "the size of the video");
    let sheet = fs::read(folder.path().join("sheet.png")).unwrap();
    assert_eq!(&sheet[1..4], b"PNG");
    for (more, message) in [
        (&["--video", "match.mp4"][..], "--video: match.mp4: the file exists already"),
        (&["--sheet", "sheet.png"], "--sheet: sheet.png: the file exists already"),
        (&["--video", "match.avi"], "ends in .mp4"),
        (&["--video", "no/match.mp4"], "--video: no/match.mp4"),
        (&["--views", "field"], "--views: expected --frames DIR"),
        (&["--every", "2"], "--every: expected --frames DIR or --video FILE"),
        (
            &["--video", "other.mp4", "--views", "blue1.left"],
            "--views: blue1.left: the robot has no such camera; expected blue1.top or blue1.bottom",
        ),
    ] {
        let output = naoisis(folder.path(), &[&["run", "one.json", "--duration", "0.1"], more].concat());
        assert_eq!(output.status.code(), Some(2), "{more:?}");
        assert!(text(&output.stderr).contains(message), "{more:?}: {}", text(&output.stderr));
    }
    assert_eq!(fs::read(folder.path().join("match.mp4")).unwrap(), video);
    assert!(!folder.path().join("other.mp4").exists());
}

#[test]
fn the_accuracy_of_image_vision_is_a_table_of_every_kind_of_thing() {
    let folder = tempfile::tempdir().unwrap();
    let output = naoisis(folder.path(), &["vision", "--scenes", "4", "--seed", "3", "--design", "nao"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let table = text(&output.stdout);
    assert!(table.starts_with("match3v3, realism paper: 4 looks; 8 images"), "{table}");
    for kind in ["ball", "goal posts", "robots"] {
        let row = table.lines().find(|line| line.starts_with(kind)).unwrap_or_else(|| panic!("{table}"));
        let numbers: Vec<f32> = row[11..].split_whitespace().filter_map(|word| word.parse().ok()).collect();
        let [visible, found_percent, false_in_100, ..] = numbers[..] else { panic!("{row}") };
        // Of so few, each is a share that can be counted.
        let found = found_percent * visible / 100.0;
        assert!(visible >= 1.0 && found <= visible && (found - found.round()).abs() < 0.01, "{row}");
        assert!((false_in_100 / 25.0).fract() == 0.0, "one of four looks: {row}");
    }
    let output = naoisis(folder.path(), &["vision", "--scenes", "0"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("--scenes"));
}
