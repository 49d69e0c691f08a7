//! Files of other simulators.

use naoisis::scenario::{Scenario, ScenarioFile, foreign_file};
use std::fs;

const GAME: &str = r#"{ "type": "NORMAL", "kickoff": "red", "class": "KID", "host": "127.0.0.1", "random_seed": 123,
    "red": { "id": 8, "config": "reds.json", "ports": [10001, 10002, 10003, 10004] },
    "blue": { "id": 25, "config": "blues.json", "ports": [10021, 10022, 10023, 10024] } }"#;

#[test]
fn a_game_of_webots_league_is_a_scenario() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("game.json");
    fs::write(&path, GAME).unwrap();
    let team =
        r#"{ "name": "Reds", "players": { "1": { "proto": "R" }, "2": { "proto": "R" }, "3": {}, "4": {}, "5": {} } }"#;
    fs::write(folder.path().join("reds.json"), team).unwrap();
    let scenario = Scenario::load(&path).unwrap();
    let expected = Scenario::from_json(
        r#"{ "league": "hsl2026_small", "seed": 123, "rules": { "team_size": 5, "shoot_out": false }, "teams": { "blue": "roles", "pink": "roles" } }"#,
    );
    let expected = expected.unwrap();
    assert_eq!((scenario.seed, &scenario.rules, &scenario.teams), (123, &expected.rules, &expected.teams));
    assert!(scenario.description.contains("Reds (red there, pink here) against team 25"), "{}", scenario.description);
    assert_eq!((scenario.rules.team_size, scenario.field), (5, expected.field));
    // Only a knockout match needs a winner.
    fs::write(&path, GAME.replace("NORMAL", "KNOCKOUT")).unwrap();
    let rules = Scenario::load(&path).unwrap().rules;
    assert!(rules.shoot_out && rules.extra_time_halves == 2);

    let error = |from: &str, to: &str| {
        fs::write(&path, GAME.replace(from, to)).unwrap();
        Scenario::load(&path).unwrap_err().to_string()
    };
    let class = error("KID", "TEEN");
    assert!(class.contains("in this game of Webots' league, `class` is `TEEN`; expected `KID` or `ADULT`"), "{class}");
    assert!(error("NORMAL", "PENALTY").contains("`type` is `PENALTY`"));
    assert_eq!(ScenarioFile::check(path.to_str().unwrap(), |_| Vec::new()).unwrap_err().len(), 1);
}

#[test]
fn files_of_others_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let json = br#"[{"type":"server_param","params":{"goal_width":14.02}},"#;
    let files: [(&str, &[u8], &str); 5] = [
        ("match.rcg", b"ULG5\n(show 1)", "a log of rcssserver, of the 2D simulation league"),
        ("match.json", json, "a log of rcssserver, of the 2D simulation league"),
        ("world.json", b"#VRML_SIM R2021a utf8\n", "a world of Webots"),
        ("robot.urdf", b"\xef\xbb\xbf\n<robot name='r'/>", "`naoisis robot import`"),
        ("log.mcap", b"\x89MCAP0\r\n", "an MCAP log"),
    ];
    for (name, bytes, words) in files {
        let path = folder.path().join(name);
        fs::write(&path, bytes).unwrap();
        let errors = ScenarioFile::check(path.to_str().unwrap(), |_| Vec::new()).unwrap_err();
        assert_eq!(errors.len(), 1);
        let error = errors[0].to_string();
        assert!(error.contains(words) && error.contains("naoisis cannot read it"), "{error}");
    }
    assert_eq!(foreign_file(b"(name: \"a\")"), None);
    for name in ["match.jsonl", "match.jsonl.zst"] {
        let path = folder.path().join(name);
        fs::write(&path, "{}").unwrap();
        let error = Scenario::load(&path).unwrap_err().to_string();
        assert!(error.contains("`naoisis replay` shows traces"), "{error}");
    }
}
