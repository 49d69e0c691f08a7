use super::columns::tests::unpacked;
use super::*;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use miniz_oxide::inflate::decompress_to_vec_zlib;
use naoisis_core::communication::TeamMessage;
use naoisis_core::events::MatchEvent;
use naoisis_core::game::{Evidence, Score};
use naoisis_core::geometry::Pose;
use naoisis_core::team::{RobotId, Team};
use naoisis_sim::interface::cycle_record::{BallRecord, RobotRecord};
use naoisis_sim::interface::fields::Fields;
use naoisis_sim::interface::vocabulary::RobotCommand;
use serde_json::Value;

const OPENING: &str = "<script type=\"application/octet-stream\">";

/// Returns the blocks of a page: JSON, and columns by name.
fn blocks(page: &str) -> Vec<(Value, Vec<(String, Vec<i32>)>)> {
    let data = page.strip_prefix(TEMPLATE).unwrap();
    data.split_terminator("</script>\n")
        .map(|block| {
            let raw = decompress_to_vec_zlib(
                &STANDARD.decode(block.strip_prefix(OPENING).and_then(|text| text.strip_suffix('.')).unwrap()).unwrap(),
            )
            .unwrap();
            let (length, rest) = raw.split_at(4);
            let (json, mut bytes) = rest.split_at(u32::from_le_bytes(length.try_into().unwrap()) as usize);
            let json: Value = serde_json::from_slice(json).unwrap();
            let mut columns = Vec::new();
            for column in json["columns"].as_array().unwrap() {
                let (these, others) = bytes.split_at(column[1].as_u64().unwrap() as usize);
                columns.push((column[0].as_str().unwrap().to_owned(), unpacked(these, column[2] == 1)));
                bytes = others;
            }
            assert!(bytes.is_empty());
            (json, columns)
        })
        .collect()
}

fn column<'a>(columns: &'a [(String, Vec<i32>)], name: &str) -> &'a [i32] {
    &columns.iter().find(|(other, _)| other == name).unwrap_or_else(|| panic!("{name} is there")).1
}

/// Returns the records of one robot that walks along x by a centimetre per cycle.
fn records(cycles: u64) -> impl Iterator<Item = CycleRecord> {
    (0..=cycles).map(|cycle| {
        let x = 0.01 * cycle as f32;
        let say = TeamMessage { intention: Some("</script><script>alert(1)</script>".into()), ..default() };
        let robot = RobotRecord {
            pose: Pose::new(x, -0.5, 0.1 * x),
            command: Some(RobotCommand { say: Some(say), ..default() }),
            ..RobotRecord::new(RobotId::new(Team::Pink, 2))
        };
        let mut record = CycleRecord {
            cycle,
            time_s: cycle as f64 / 30.0,
            ball: Some(BallRecord { position_m: Vec3::new(-x, 0.2, 0.03), velocity_mps: Vec3::ZERO }),
            robots: vec![robot],
            ..default()
        };
        record.game.score = Score { blue: 0, pink: u32::from(cycle >= 7) };
        if cycle == 7 {
            let evidence = Evidence { rule: "<b>A rule</b>.".into(), ..default() };
            record.events.push(MatchEvent::Goal { team: Team::Pink, scorer: None, own_goal: false, evidence });
        }
        record
    })
}

fn page_of(scenario: &Scenario, records: impl IntoIterator<Item = CycleRecord>) -> String {
    let mut records = records.into_iter();
    let mut last = records.next().unwrap();
    let (mut writer, mut page) = PageWriter::begin(scenario, &last, Fields::default());
    for record in records {
        page.extend(writer.record(&record));
        last = record;
    }
    page + &writer.finish(&MatchEnd { score: last.game.score, ..default() }, &last)
}

#[test]
fn a_page_has_the_match_in_whole_numbers() {
    let scenario = Scenario { name: "a & b".to_owned(), ..default() };
    let page = page_of(&scenario, records(10));
    let blocks = blocks(&page);
    let [(head, _), (part, columns), (end, _)] = blocks.as_slice() else { panic!("three blocks") };
    assert_eq!((&head["name"], &head["robots"][0]["id"]), (&"a & b".into(), &"pink2".into()));
    assert_eq!(head["robots"][0]["cameras"].as_array().map(Vec::len), Some(2));
    assert_eq!(column(columns, "cycle"), (0..=10).collect::<Vec<_>>());
    assert_eq!(column(columns, "pink2.x"), (0..=10).map(|cycle| 2 * cycle).collect::<Vec<_>>());
    assert_eq!(column(columns, "ball.x")[10], -20);
    assert_eq!(column(columns, "pink"), [0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1]);
    assert_eq!(column(columns, "sense"), [0, 3, 6, 9]);
    assert_eq!(column(columns, "pink2.i"), [1, 1, 1, 1]);
    let goal = &part["events"][0];
    assert_eq!(
        (&goal[0], &goal[1], &goal[2], &goal[3]),
        (&7.into(), &"goal".into(), &"Goal for pink.".into(), &"pink".into())
    );
    assert_eq!(goal[5][0], "Rule: <b>A rule</b>.");
    assert_eq!((&end["end"], &end["score"]["pink"]), (&"duration".into(), &1.into()));
}

#[test]
fn the_same_match_makes_the_same_bytes_and_nothing_of_it_is_markup() {
    let scenario = Scenario { name: "<script>alert(1)</script>".to_owned(), ..default() };
    let page = page_of(&scenario, records(400));
    assert!(page == page_of(&scenario, records(400)));
    assert!(!page[TEMPLATE.len()..].contains("alert"));
    assert_eq!(page.matches("<script").count() - TEMPLATE.matches("<script").count(), blocks(&page).len());
}

#[test]
fn a_page_that_breaks_off_has_the_parts_that_were_written() {
    let (mut writer, mut page) =
        PageWriter::begin(&Scenario::default(), &records(0).next().unwrap(), Fields::default());
    page.extend(records(9000).skip(1).filter_map(|record| writer.record(&record)));
    let blocks = blocks(&page);
    // Blocks of whole cycles: 7.5, 15, 30, 60 and then 120 s each. The last block is incomplete, so it is lost.
    assert_eq!(blocks.len(), 1 + 5);
    let begins: Vec<i32> = blocks[1..].iter().map(|(_, columns)| column(columns, "cycle")[0]).collect();
    assert_eq!(begins, [0, 225, 675, 1575, 3375]);
    // At 60 Hz, a sample of every second cycle, and the last cycle.
    let scenario = Scenario { cycle_s: 1.0 / 60.0, ..default() };
    let page = page_of(&scenario, records(9));
    assert_eq!(column(&self::blocks(&page)[1].1, "cycle"), [0, 2, 4, 6, 8, 9]);
}

#[test]
fn a_page_that_would_grow_too_large_leaves_out_and_says_so() {
    // As if the match took a year.
    let scenario = Scenario { duration_s: Some(3e7), ..default() };
    let page = page_of(&scenario, records(4000));
    let said: Vec<String> =
        blocks(&page).iter().filter_map(|(json, _)| json["left_out"].as_str().map(str::to_owned)).collect();
    let from = |said: &str| said.rsplit(", from ").next().unwrap().to_owned();
    assert_eq!(said[0], "To keep the page small, the lines that robots saw are there 5 times a second, from 0:07 on.");
    assert!(said[1].starts_with("To keep the page small, what robots saw, but for the ball, is there"), "{said:?}");
    assert!(said[2].contains("seen or believed, are there 2.5 times a second"), "{said:?}");
    assert_eq!([&said[1], &said[2]].map(|said| from(said)), ["0:22 on.", "0:52 on."]);
    // A sample with a list is followed by samples that show the same list again.
    let (_, columns) = &blocks(&page)[4];
    assert_eq!(column(columns, "pink2.t")[..5], [-1, -1, -1, 0, -1]);
}
