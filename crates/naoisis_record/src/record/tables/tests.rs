use super::*;
use crate::record::convert::convert;
use crate::record::read::TraceReader;
use naoisis_core::behaviour::BehaviourRegistry;
use naoisis_core::communication::{ReceivedMessage, TeamMessage};
use naoisis_core::events::MatchEvent;
use naoisis_core::team::{RobotId, Team};
use naoisis_sensing::belief::{BallBelief, Belief};
use naoisis_sim::interface::cycle_record::RobotRecord;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use std::borrow::Cow;
use std::fs;
use std::path::Path;

const HOSTILE: &str = "=1+1,\"x\"\n<script>\u{0}";

/// Returns a record whose robot has percepts, a belief and a received message.
fn record(cycle: u64) -> CycleRecord {
    let id = RobotId::new(Team::Pink, 2);
    let ball = BallBelief { position_m: bevy::math::Vec2::new(1.0, -0.5), age_s: 0.25, ..Default::default() };
    let belief = Belief { ball: Some(ball), ..Default::default() };
    let say = TeamMessage { intention: Some(Cow::Borrowed(HOSTILE)), ..Default::default() };
    let message = ReceivedMessage { from: RobotId::new(Team::Pink, 1), sent_cycle: cycle, say };
    let robot = RobotRecord { belief: Some(belief), inbox: vec![message], ..RobotRecord::new(id) };
    CycleRecord {
        cycle,
        time_s: cycle as f64 / 30.0,
        robots: vec![robot],
        events: vec![MatchEvent::GotUp { robot: id }],
        ..Default::default()
    }
}

/// Writes the tables of these records.
fn write(folder: &Path, format: TableFormat, records: &[CycleRecord]) {
    let trace = folder.join("t.jsonl");
    let mut lines = vec![
        serde_json::json!({
            "type": "header", "format": "naoisis-trace", "version": 1, "seed": 1,
            "scenario": naoisis_sim::scenario::Scenario::default(),
        })
        .to_string(),
    ];
    lines.extend(records.iter().map(|record| serde_json::to_string(record).unwrap()));
    fs::write(&trace, lines.join("\n") + "\n").unwrap();
    let mut reader = TraceReader::open(&trace).unwrap();
    let create = || {
        let fields = Fields::default();
        TablesRecorder::create(&folder.join("tables"), format, fields).map(|recorder| Box::new(recorder) as _)
    };
    convert(&mut reader, &BehaviourRegistry::default(), create, |_| core::ops::ControlFlow::Continue(())).unwrap();
}

/// Returns the values of a column of a Parquet file.
fn parquet_column(file: &Path, name: &str) -> Vec<Field> {
    let reader = SerializedFileReader::new(fs::File::open(file).unwrap()).unwrap();
    let row = |row: parquet::record::Row| {
        row.get_column_iter().find(|(column, _)| *column == name).map(|(_, field)| field.clone()).unwrap()
    };
    reader.get_row_iter(None).unwrap().map(|read| row(read.unwrap())).collect()
}

#[test]
fn names_of_columns_are_unique_and_described() {
    for table in &TABLES {
        let mut names: Vec<&str> = table.columns.iter().map(|column| column.name).collect();
        assert!(table.columns.iter().all(|column| column.description.ends_with('.')), "{}", table.name);
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), table.columns.len(), "{}", table.name);
    }
}

#[test]
fn csv_and_parquet_say_the_same_and_texts_are_only_texts() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let records = [record(0), record(1), record(2)];
    write(folder, TableFormat::Csv, &records);
    write(folder, TableFormat::Parquet, &records);
    let tables = folder.join("tables");
    for table in &TABLES {
        let mut csv = csv::Reader::from_path(tables.join(table.name).with_extension("csv")).unwrap();
        let header: Vec<String> = csv.headers().unwrap().iter().map(str::to_owned).collect();
        let rows: Vec<csv::StringRecord> = csv.records().map(Result::unwrap).collect();
        assert!(header.iter().eq(table.columns.iter().map(|column| column.name)));
        for (index, column) in table.columns.iter().enumerate() {
            let fields = parquet_column(&tables.join(table.name).with_extension("parquet"), column.name);
            assert_eq!(fields.len(), rows.len());
            for (row, field) in rows.iter().zip(fields) {
                let same = match &field {
                    Field::Null => row[index].is_empty(),
                    Field::Long(value) => row[index].parse() == Ok(*value),
                    Field::Float(value) => row[index].parse() == Ok(*value),
                    Field::Double(value) => row[index].parse() == Ok(*value),
                    Field::Str(value) => row[index] == *value,
                    other => panic!("{other}"),
                };
                assert!(same, "{} {}: {} is not {field}", table.name, column.name, &row[index]);
            }
        }
    }
    let intentions = parquet_column(&tables.join("messages.parquet"), "intention");
    assert_eq!(intentions, vec![Field::Str(HOSTILE.to_owned()); 3]);
}

#[test]
fn beliefs_are_in_the_frames_of_team_and_pitch() {
    let mut tables = Tables::new(Fields::default());
    tables.push(&record(0));
    let beliefs = tables.of("beliefs").unwrap();
    let column = |name: &str| {
        let index = beliefs.definition().columns.iter().position(|column| column.name == name).unwrap();
        beliefs.columns()[index].cells.clone()
    };
    // A robot and the ball. Pink defends the positive end.
    assert_eq!(column("x_m"), Cells::Single(vec![0.0, 1.0]));
    assert_eq!(column("pitch_x_m"), Cells::Single(vec![-0.0, -1.0]));
    assert_eq!(column("pitch_y_m"), Cells::Single(vec![-0.0, 0.5]));
}

#[test]
fn what_a_trace_does_not_have_is_missing() {
    let fields: Fields = "ball,robots.pose".parse().unwrap();
    let mut tables = Tables::new(fields);
    tables.push(&record(0));
    let robots = tables.of("robots").unwrap();
    let is_present = |name: &str| {
        let index = robots.definition().columns.iter().position(|column| column.name == name).unwrap();
        robots.columns()[index].presence[0] == 1
    };
    assert!(is_present("x_m") && is_present("robot"));
    assert!(!is_present("vx_mps") && !is_present("odometry_x_m") && !is_present("posture"));
}

#[test]
fn tables_that_are_not_complete_have_no_name() {
    let folder = tempfile::tempdir().unwrap();
    let tables = folder.path().join("tables");
    let mut recorder = TablesRecorder::create(&tables, TableFormat::Parquet, Fields::default()).unwrap();
    let mut world = bevy::prelude::World::new();
    let scenario = naoisis_sim::scenario::Scenario::default();
    crate::record::recorder::Recorder::start(&mut recorder, &scenario, &record(0), &mut world);
    drop(recorder);
    assert_eq!(fs::read_dir(&tables).unwrap().count(), 0);
}
