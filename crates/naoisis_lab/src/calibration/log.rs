//! Logs: CSV tables of the actions of a robot.

use csv::{ReaderBuilder, StringRecord};
use std::io::{self, BufRead, BufReader, Read};

use super::odometry::OdometryTrack;
use naoisis_core::kick_geometry::KickType;
use naoisis_sim::scenario::wording::quoted;

/// The columns of a log: kind of row, name, meaning, and whether it is required. Other columns are ignored.
pub const COLUMNS: &[(&str, &str, &str, bool)] = &[
    ("walk", "true_forward_m", "where it got to, in its frame at the start, m", true),
    ("walk", "true_left_m", "the same to the left, m", true),
    ("walk", "true_turn_deg", "by how much it turned, degrees", true),
    ("walk", "odometry_forward_m", "where its odometry says that it got to, m", true),
    ("walk", "odometry_left_m", "the same to the left, m", true),
    ("walk", "odometry_turn_deg", "by how much its odometry says that it turned, degrees", true),
    (
        "walk",
        "start_s",
        "instead of `odometry_…`: when it began, s after the first message of an MCAP file's odometry",
        false,
    ),
    ("walk", "end_s", "when it ended, s", false),
    ("walk", "planned_forward_m", "where its steps, as they were planned, lead to, m", false),
    ("walk", "planned_left_m", "the same to the left, m", false),
    ("walk", "planned_turn_deg", "by how much they turn, degrees", false),
    ("kick", "kick", "the kick: left_straight, right_straight, left_side, right_side, or one of the robot's own", true),
    ("kick", "start_forward_m", "where the ball lay, in the robot's frame, m", true),
    ("kick", "start_left_m", "the same to the left, m", true),
    ("kick", "rest_forward_m", "where it came to rest, in the robot's frame at the kick, m", true),
    ("kick", "rest_left_m", "the same to the left, m", true),
    ("kick", "speed", "the strength of the kick, 0 to 1; full without it", false),
    ("sighting", "thing", "what was in view: ball, goal_post, robot, junction, penalty_cross or centre_circle", true),
    ("sighting", "true_forward_m", "where it was, in the robot's frame, m", true),
    ("sighting", "true_left_m", "the same to the left, m", true),
    ("sighting", "seen_forward_m", "where the robot saw it, m; empty if it did not", true),
    ("sighting", "seen_left_m", "the same to the left, m", true),
    ("sighting", "motion", "what the robot did: standing or walking", true),
    ("sighting", "time_s", "when, s", false),
    ("sighting", "lens_height_m", "height of the lens, m; 0.5 without it", false),
    ("any", "kind", "what the row is: walk, kick or sighting; as the columns have it without", false),
    ("any", "robot", "which robot it was, by any name", false),
];

/// The largest table: half a million rows. In memory it takes ten times its size.
const MOST_BYTES: u64 = 32 << 20;

/// A position or displacement in m, to the front and to the left.
pub type Place = [f64; 2];

/// A straight walk or a turn on the spot.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Walk {
    /// The index of the robot in the log.
    pub robot: usize,
    /// The true displacement, m, and turn, degrees.
    pub real: (Place, f64),
    /// The displacement and turn by odometry.
    pub odometry: (Place, f64),
    /// The displacement and turn of the planned steps.
    pub planned: Option<(Place, f64)>,
}

/// A kick and the position where the ball stopped.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Kick {
    /// The index of the robot in the log.
    pub robot: usize,
    /// The type of the kick.
    pub kick_type: KickType,
    /// The start of the ball, m, robot frame.
    pub start: Place,
    /// The position where the ball stopped, m, robot frame.
    pub rest: Place,
    /// The speed of the command, 0 to 1.
    pub speed: f64,
}

/// A class of objects.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
#[expect(missing_docs, reason = "the names say it")]
#[non_exhaustive]
pub enum Thing {
    Ball,
    GoalPost,
    Robot,
    Junction,
    PenaltyCross,
    CentreCircle,
}

impl Thing {
    /// All classes, with the word for logs and the class of a model's vision.
    pub const NAMES: [(Thing, &'static str, &'static str); 6] = [
        (Thing::Ball, "ball", "ball"),
        (Thing::GoalPost, "goal_post", "goal_posts"),
        (Thing::Robot, "robot", "robots"),
        (Thing::Junction, "junction", "junctions"),
        (Thing::PenaltyCross, "penalty_cross", "penalty_crosses"),
        (Thing::CentreCircle, "centre_circle", "centre_circle"),
    ];
}

/// The motion of a robot while it looks.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Motion {
    /// It stands.
    Standing,
    /// It walks.
    Walking,
}

/// An object in view, detected or not.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct LoggedSighting {
    /// The index of the robot in the log.
    pub robot: usize,
    /// The class of the object.
    pub thing: Thing,
    /// Its true position, m, robot frame.
    pub real: Place,
    /// Its detected position, m, robot frame; `None` if it was not detected.
    pub seen: Option<Place>,
    /// The motion of the robot.
    pub motion: Motion,
    /// The time, s.
    pub time_s: Option<f64>,
    /// The height of the lens, m.
    pub lens_height_m: f64,
}

/// The rows of a log.
#[derive(Clone, PartialEq, Debug, Default)]
#[non_exhaustive]
pub struct RobotLog {
    /// The walks of the robot.
    pub walks: Vec<Walk>,
    /// The kicks of the robot.
    pub kicks: Vec<Kick>,
    /// Objects that were in view.
    pub sightings: Vec<LoggedSighting>,
    /// The names of the robots, in the order of the log.
    pub robots: Vec<String>,
    /// The recorded odometry of robots, for walks of tables that are read after it.
    pub odometry: Vec<OdometryTrack>,
}

/// An error of a log.
#[derive(Clone, PartialEq, thiserror::Error)]
#[error("line {line}{}: {kind}", .column.as_ref().map(|column| format!(", column `{column}`")).unwrap_or_default())]
pub struct LogError {
    /// The line, from 1.
    pub line: u64,
    /// The name of the column, if the error is in one.
    pub column: Option<String>,
    /// The kind of the error.
    pub kind: LogErrorKind,
}

naoisis_core::debug_as_displayed!(LogError);

/// The kinds of errors of logs.
#[derive(Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LogErrorKind {
    /// The file is no CSV table, cannot be read, or is too large.
    #[error("this is no CSV: {0}")]
    NotCsv(String),
    /// The columns fit no kind of row.
    #[error("the columns are those of no walks, kicks or sightings: {0}")]
    NoKind(String),
    /// A value is missing.
    #[error("nothing is there; expected {0}")]
    Missing(&'static str),
    /// A value is invalid.
    #[error("{} is not what was expected: {expected}", quoted(.value))]
    Wrong {
        /// The value.
        value: String,
        /// The valid values.
        expected: String,
    },
}

naoisis_core::debug_as_displayed!(LogErrorKind);

impl RobotLog {
    /// Adds the rows of a table, whose first line names the [columns](COLUMNS). Cells are separated by commas, semicolons or tabs.
    ///
    /// # Errors
    /// The first row that cannot be read.
    pub fn read(&mut self, table: impl Read) -> Result<(), LogError> {
        let mut table = BufReader::new(Limited { table, left: MOST_BYTES });
        let refused = |kind: LogErrorKind| LogError { line: 1, column: None, kind };
        let start = table.fill_buf().map_err(|error| refused(LogErrorKind::NotCsv(error.to_string())))?;
        if start.is_empty() {
            return Err(refused(LogErrorKind::NotCsv("the file is empty".to_owned())));
        }
        let delimiter = delimiter_of(start);
        let mut reader =
            ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).delimiter(delimiter).from_reader(table);
        let not_csv = |error: &csv::Error| {
            let line = error.position().map_or(1, csv::Position::line);
            LogError { line, column: None, kind: LogErrorKind::NotCsv(error.to_string()) }
        };
        let header = reader.headers().map_err(|error| not_csv(&error))?.clone();
        let kind = if header.iter().any(|column| column == "kind") { None } else { Some(kind_of(&header)?) };
        for row in reader.records() {
            let row = row.map_err(|error| not_csv(&error))?;
            Row { header: &header, row: &row, line: row.position().map_or(1, csv::Position::line) }
                .add_to(self, kind)?;
        }
        Ok(())
    }

    fn robot(&mut self, name: &str) -> usize {
        match self.robots.iter().position(|robot| robot == name) {
            Some(index) => index,
            None => {
                self.robots.push(name.to_owned());
                self.robots.len() - 1
            }
        }
    }
}

/// A reader that fails after so many bytes.
struct Limited<R> {
    table: R,
    left: u64,
}

impl<R: Read> Read for Limited<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let bytes = self.table.read(buffer)?;
        self.left = self.left.checked_sub(bytes as u64).ok_or_else(|| {
            io::Error::new(io::ErrorKind::FileTooLarge, format!("the table has more than {} MiB", MOST_BYTES >> 20))
        })?;
        Ok(bytes)
    }
}

/// Returns the character that separates the cells of a table: the most frequent of the possible ones in its first line.
fn delimiter_of(start: &[u8]) -> u8 {
    let mut lines = start.split(|byte| *byte == b'\n').filter(|line| !line.trim_ascii().is_empty());
    let first = lines.find(|line| !line.starts_with(b"#")).unwrap_or_default();
    // Of characters with the same number, the last counts.
    let count = |delimiter: &u8| first.iter().filter(|byte| *byte == delimiter).count();
    [b'\t', b';', b','].into_iter().max_by_key(count).unwrap_or(b',')
}

/// The kind of the rows of a table with these columns.
fn kind_of(header: &StringRecord) -> Result<&'static str, LogError> {
    let lacking = |kind: &str| {
        let needed = COLUMNS.iter().filter(|(of, .., needed)| *of == kind && *needed);
        let has = |name: &str| header.iter().any(|column| column == name);
        let is_recorded = |name: &str| name.starts_with("odometry_") && has("start_s") && has("end_s");
        needed.map(|(_, name, ..)| *name).filter(|name| !has(name) && !is_recorded(name)).collect::<Vec<_>>()
    };
    let kinds = ["walk", "kick", "sighting"].map(|kind| (kind, lacking(kind)));
    if let Some((kind, _)) = kinds.iter().find(|(_, lacking)| lacking.is_empty()) {
        return Ok(kind);
    }
    let words = kinds.map(|(kind, lacking)| format!("a {kind} lacks {}", lacking.join(", "))).join("; ");
    Err(LogError { line: 1, column: None, kind: LogErrorKind::NoKind(words) })
}

/// A row with the names of its cells.
struct Row<'a> {
    header: &'a StringRecord,
    row: &'a StringRecord,
    line: u64,
}

impl Row<'_> {
    fn add_to(&self, log: &mut RobotLog, kind: Option<&str>) -> Result<(), LogError> {
        let robot = log.robot(self.cell("robot").unwrap_or_default());
        match kind.or_else(|| self.cell("kind")) {
            Some("walk") => {
                let walk = self.walk(robot, &log.odometry)?;
                log.walks.push(walk);
            }
            Some("kick") => log.kicks.push(self.kick(robot)?),
            Some("sighting") => log.sightings.push(self.sighting(robot)?),
            Some(other) => return Err(self.wrong("kind", other, "`walk`, `kick` or `sighting`")),
            None => return Err(self.missing("kind")),
        }
        Ok(())
    }

    fn walk(&self, robot: usize, recorded: &[OdometryTrack]) -> Result<Walk, LogError> {
        let planned = match self.optional("planned_forward_m")? {
            Some(_) => Some(self.motion("planned")?),
            None => None,
        };
        let odometry = match self.optional("start_s")? {
            Some(start_s) => self.recorded_motion(start_s, recorded)?,
            None => self.motion("odometry")?,
        };
        Ok(Walk { robot, real: self.motion("true")?, odometry, planned })
    }

    /// The motion by the recorded odometry of the row's robot. A single recording is that of all rows without a robot.
    fn recorded_motion(&self, start_s: f64, recorded: &[OdometryTrack]) -> Result<(Place, f64), LogError> {
        let end_s = self.number("end_s")?;
        let name = self.cell("robot");
        let track = match (name, recorded) {
            (None, [track]) => track,
            (Some(name), _) if let Some(track) = recorded.iter().find(|track| track.robot == name) => track,
            _ => {
                let names = recorded.iter().map(|track| format!("`{}`", track.robot)).collect::<Vec<_>>();
                let expected = match &names[..] {
                    [] => "an MCAP file with the odometry of the walk beside the table".to_owned(),
                    _ => format!("a robot whose odometry was recorded: {}", names.join(", ")),
                };
                return Err(self.wrong("robot", name.unwrap_or_default(), &expected));
            }
        };
        if end_s <= start_s {
            return Err(self.wrong("end_s", &end_s.to_string(), "a time after `start_s`"));
        }
        for (column, time_s) in [("start_s", start_s), ("end_s", end_s)] {
            track.motion(time_s, time_s).map_err(|expected| self.wrong(column, &time_s.to_string(), &expected))?;
        }
        track.motion(start_s, end_s).map_err(|expected| self.wrong("end_s", &end_s.to_string(), &expected))
    }

    fn motion(&self, of: &str) -> Result<(Place, f64), LogError> {
        Ok((self.place(of)?, self.number(&format!("{of}_turn_deg"))?))
    }

    fn kick(&self, robot: usize) -> Result<Kick, LogError> {
        let name = self.cell("kick").ok_or_else(|| self.missing("kick"))?;
        let kick_type: KickType = name.parse().map_err(|_| {
            let names = KickType::ALL.map(|kick| format!("`{kick}`")).join(", ");
            self.wrong("kick", name, &format!("one of {names}, or the name of a kick of the robot's own"))
        })?;
        let speed = self.optional("speed")?.unwrap_or(1.0);
        if !(0.0..=1.0).contains(&speed) {
            return Err(self.wrong("speed", &speed.to_string(), "a number from 0 to 1"));
        }
        Ok(Kick { robot, kick_type, start: self.place("start")?, rest: self.place("rest")?, speed })
    }

    fn sighting(&self, robot: usize) -> Result<LoggedSighting, LogError> {
        let name = self.cell("thing").ok_or_else(|| self.missing("thing"))?;
        let thing = Thing::NAMES.into_iter().find(|(_, word, _)| *word == name);
        let (thing, ..) = thing.ok_or_else(|| {
            let names = Thing::NAMES.map(|(_, word, _)| format!("`{word}`")).join(", ");
            self.wrong("thing", name, &format!("one of {names}"))
        })?;
        let motion = match self.cell("motion").ok_or_else(|| self.missing("motion"))? {
            "standing" => Motion::Standing,
            "walking" => Motion::Walking,
            other => return Err(self.wrong("motion", other, "`standing` or `walking`")),
        };
        let seen = match (self.cell("seen_forward_m"), self.cell("seen_left_m")) {
            (None, None) => None,
            _ => Some(self.place("seen")?),
        };
        let lens_height_m = self.optional("lens_height_m")?.unwrap_or(0.5);
        if lens_height_m <= 0.0 {
            return Err(self.wrong("lens_height_m", &lens_height_m.to_string(), "a height above the ground, m"));
        }
        let (real, time_s) = (self.place("true")?, self.optional("time_s")?);
        Ok(LoggedSighting { robot, thing, real, seen, motion, time_s, lens_height_m })
    }

    fn place(&self, of: &str) -> Result<Place, LogError> {
        Ok([self.number(&format!("{of}_forward_m"))?, self.number(&format!("{of}_left_m"))?])
    }

    fn number(&self, column: &str) -> Result<f64, LogError> {
        self.optional(column)?.ok_or_else(|| self.missing(column))
    }

    fn optional(&self, column: &str) -> Result<Option<f64>, LogError> {
        let Some(cell) = self.cell(column) else { return Ok(None) };
        // Spreadsheets of some languages write decimal commas.
        let number =
            cell.replace(',', ".").parse::<f64>().ok().filter(|number| number.is_finite() && number.abs() < 1e6);
        number.map(Some).ok_or_else(|| self.wrong(column, cell, "a number"))
    }

    /// The text of a column; `None` if it is empty or missing.
    fn cell(&self, column: &str) -> Option<&str> {
        let index = self.header.iter().position(|name| name == column)?;
        self.row.get(index).filter(|cell| !cell.is_empty())
    }

    fn missing(&self, column: &str) -> LogError {
        let meaning =
            COLUMNS.iter().find(|(_, name, ..)| *name == column).map_or("a value", |(_, _, meaning, _)| meaning);
        LogError { line: self.line, column: Some(column.to_owned()), kind: LogErrorKind::Missing(meaning) }
    }

    fn wrong(&self, column: &str, value: &str, expected: &str) -> LogError {
        let kind = LogErrorKind::Wrong { value: value.to_owned(), expected: expected.to_owned() };
        LogError { line: self.line, column: Some(column.to_owned()), kind }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_all_kinds_stand_in_one_table_or_in_one_each() {
        let mut log = RobotLog::default();
        log.read(
            "kind,robot,kick,start_forward_m,start_left_m,rest_forward_m,rest_left_m,thing,true_forward_m,true_left_m,seen_forward_m,seen_left_m,motion\n\
             kick,anna,left_side,0.16,0.02,0.2,-1.3,,,,,,\n\
             # a remark\n\
             sighting,bert,,,,,,ball,2,0.5,,,walking\n"
                .as_bytes(),
        )
        .unwrap();
        log.read(
            "true_forward_m,true_left_m,true_turn_deg,odometry_forward_m,odometry_left_m,odometry_turn_deg,robot,weather\n\
             0.9,0.01,3,1,0,0,anna,fine\n"
                .as_bytes(),
        )
        .unwrap();
        assert_eq!((log.kicks[0].kick_type, log.kicks[0].speed), (KickType::LeftSide, 1.0));
        assert_eq!((log.sightings[0].seen, log.sightings[0].motion), (None, Motion::Walking));
        assert_eq!((log.walks[0].planned, log.walks[0].robot), (None, 0));
        assert_eq!(log.robots, ["anna", "bert"]);
    }

    #[test]
    fn tables_of_spreadsheets_have_semicolons_tabs_and_decimal_commas() {
        let table =
            "# kicks\nkick;start_forward_m;start_left_m;rest_forward_m;rest_left_m\nleft_side;0,16;0;0,2;-1,3\n";
        for text in [table.to_owned(), table.replace(';', "\t")] {
            let mut log = RobotLog::default();
            log.read(text.as_bytes()).unwrap();
            assert_eq!((log.kicks[0].start, log.kicks[0].rest), ([0.16, 0.0], [0.2, -1.3]));
        }
    }

    #[test]
    fn walks_without_recorded_odometry_say_what_is_missing() {
        let table = "robot,start_s,end_s,true_forward_m,true_left_m,true_turn_deg\nanna,0,1,1,0,0\n";
        let error = RobotLog::default().read(table.as_bytes()).unwrap_err().to_string();
        assert!(error.contains("line 2, column `robot`: `anna`") && error.contains("an MCAP file"), "{error}");
    }

    #[test]
    fn what_is_wrong_is_told_by_line_and_column() {
        let error = |text: &str| RobotLog::default().read(text.as_bytes()).unwrap_err().to_string();
        let header = "kick,start_forward_m,start_left_m,rest_forward_m,rest_left_m\n";
        let words = error(&format!("{header}left_straight,0.1,0,x,0\n"));
        assert_eq!(words, "line 2, column `rest_forward_m`: `x` is not what was expected: a number");
        assert!(error(&format!("{header}back heel,0.1,0,1,0\n")).contains("one of `left_straight`"));
        assert!(error(&format!("{header}left_straight,0.1,0,,0\n")).contains("expected where it came to rest"));
        assert!(error("a,b\n1,2\n").contains("a kick lacks kick, start_forward_m"));
        assert!(error("kind\njump\n").contains("line 2, column `kind`: `jump`"));
        assert!(error(&format!("{header}left_straight,0.1\n")).contains("line 2"));
        assert_eq!(error(""), "line 1: this is no CSV: the file is empty");
    }

    #[test]
    fn a_table_without_end_is_refused() {
        for byte in [b'0', b'\n', b',', 0] {
            let error = RobotLog::default().read(io::repeat(byte)).unwrap_err().to_string();
            assert!(error.contains("the table has more than 32 MiB"), "{byte}: {error}");
        }
    }
}
