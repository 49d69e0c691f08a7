//! Files of other simulators: recognises their formats, and converts games of the virtual humanoid league on Webots to scenarios.

use serde_json::{Map, Value, json};
use std::path::Path;

use super::bytes::read_bytes;

/// Describes a file that naoisis cannot read, by its first bytes, such as `a log of rcssserver`. Returns `None` for all other files.
pub fn foreign_file(start: &[u8]) -> Option<&'static str> {
    const KINDS: [(&[u8], &str); 11] = [
        (b"ULG", "a log of rcssserver, of the 2D simulation league"),
        (b"#VRML_SIM", "a world of Webots"),
        (b"<mujoco", "a model of MuJoCo (`naoisis robot import` makes a robot model of it)"),
        (b"<robot", "a description of a robot (`naoisis robot import` makes a robot model of it)"),
        (b"<sdf", "a world or model of Gazebo"),
        (b"<?xml", "an XML file (`naoisis robot import` makes a robot model of a URDF or MJCF file)"),
        (b"\x89MCAP0\r\n", "an MCAP log"),
        (b"#ROSBAG V", "a bag of ROS 1"),
        (b"SQLite format 3\0", "a bag of ROS 2"),
        (b"\x1f\x8b", "a file packed by gzip"),
        (b"PK\x03\x04", "a zip archive"),
    ];
    // Some files begin with a byte order mark or empty lines.
    let text = start.strip_prefix(b"\xef\xbb\xbf").unwrap_or(start).trim_ascii_start();
    // The JSON logs of rcssserver begin with its parameters.
    let is_json = text.starts_with(b"[") || text.starts_with(b"{");
    if is_json && contains(&text[..text.len().min(4096)], b"\"server_param\"") {
        return Some(KINDS[0].1);
    }
    KINDS.iter().find(|(mark, _)| start.starts_with(mark) || text.starts_with(mark)).map(|(_, kind)| *kind)
}

fn contains(text: &[u8], part: &[u8]) -> bool {
    text.windows(part.len()).any(|window| window == part)
}

/// Converts a game of the virtual humanoid league on Webots (`game.json`) to a scenario. Returns `None` for other values.
///
/// The red team plays as pink. The teams are built-in ones, because programs of that league do not use naoisis' protocol. The seed, the
/// size of the robots and the size of the teams are those of the file.
///
/// # Errors
/// The fault of the game, and what was expected.
pub(super) fn webots_game(value: &Value, path: &Path) -> Option<Result<Value, (String, String)>> {
    let fields = value.as_object()?;
    let is_game = ["red", "blue"].iter().all(|team| fields.get(*team).is_some_and(Value::is_object))
        && fields.contains_key("class");
    is_game.then(|| scenario_of_game(fields, path))
}

fn scenario_of_game(game: &Map<String, Value>, path: &Path) -> Result<Value, (String, String)> {
    let word = |name: &str| game.get(name).and_then(Value::as_str).unwrap_or_default();
    let wrong = |name: &str, expected: &str| {
        Err((format!("in this game of Webots' league, `{name}` is `{}`", word(name)), expected.to_owned()))
    };
    let league = match word("class") {
        "KID" => "hsl2026_small",
        "ADULT" => "hsl2026_large",
        _ => return wrong("class", "`KID` or `ADULT`"),
    };
    if !matches!(word("type"), "" | "NORMAL" | "KNOCKOUT") {
        return wrong("type", "`NORMAL` or `KNOCKOUT`: others are no matches");
    }
    let mut names = Vec::new();
    let mut size = 0;
    for team in ["red", "blue"] {
        let of_team = |name: &str| game.get(team).and_then(|team| team.get(name));
        let config = of_team("config").and_then(Value::as_str);
        let config = config.and_then(|config| team_file(&path.with_file_name(config)));
        let players = config.as_ref().and_then(|config| config.get("players")?.as_object().map(Map::len));
        let ports = of_team("ports").and_then(Value::as_array).map_or(0, Vec::len);
        size = size.max(players.unwrap_or(ports));
        let name = config.as_ref().and_then(|config| config.get("name")?.as_str().map(str::to_owned));
        names.push(name.unwrap_or_else(|| format!("team {}", of_team("id").unwrap_or(&Value::Null))));
    }
    let description = format!(
        "A game of Webots' virtual humanoid league: {} (red there, pink here) against {}, both played by built-in teams; hosts, ports, robots and \
         poses of the file are left out.",
        names[0], names[1]
    );
    let mut scenario = json!({
        "name": path.file_stem().unwrap_or_default().to_string_lossy(),
        "description": description,
        "league": league,
        "teams": { "blue": "roles", "pink": "roles" },
    });
    if size > 0 {
        scenario["rules"]["team_size"] = json!(size);
    }
    if !word("type").is_empty() {
        // Only a knockout match needs a winner.
        let is_knockout = word("type") == "KNOCKOUT";
        scenario["rules"]["shoot_out"] = json!(is_knockout);
        scenario["rules"]["extra_time_halves"] = json!(if is_knockout { 2 } else { 0 });
    }
    if let Some(seed) = game.get("random_seed").and_then(Value::as_u64) {
        scenario["seed"] = json!(seed);
    }
    Ok(scenario)
}

/// Returns the values of a team's file. Returns `None` if it cannot be read.
fn team_file(path: &Path) -> Option<Value> {
    serde_json::from_slice(&read_bytes(path).ok()?).ok()
}
