//! Reads traces: plain, compressed or in an [MCAP file](super::mcap), complete or cut off.
//!
//! Errors are [`TraceError`]s with file, line and column, and what was expected. If the writing program was killed, the last line is
//! missing or incomplete. Such a trace is read up to there, and [`TraceReader::ending`] says so.

use serde::Deserialize;
use serde_json::Value;
use std::fs::File;
use std::io::{self, BufRead, BufReader, ErrorKind, Read};
use std::path::{Path, PathBuf};

use super::mcap_records::is_mcap;
use super::mcap_trace::McapTrace;
use super::recorder::{EndReason, MatchEnd};
use super::trace::{FORMAT, VERSION};
use naoisis_core::cycle::CycleClock;
use naoisis_core::game::MatchResult;
use naoisis_sim::interface::cycle_record::CycleRecord;
use naoisis_sim::interface::fields::Fields;
use naoisis_sim::scenario::{FieldPath, Scenario, foreign_file, read_settings};

/// Length limit of a line, bytes. It bounds the reader's memory.
const LONGEST_LINE_BYTES: u64 = 16 << 20;

/// Longest time of a match, s: some years.
const LONGEST_S: f64 = 1e8;

/// First bytes of a file compressed by Zstandard.
const ZSTANDARD: &[u8] = b"\x28\xb5\x2f\xfd";
/// First bytes of a file compressed by gzip.
const GZIP: &[u8] = b"\x1f\x8b";
/// The byte order mark with which some editors begin UTF-8 text.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// Why a trace cannot be read.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum TraceError {
    /// The file cannot be opened or read.
    #[error("{}: {}; expected a trace, as `naoisis run --trace` writes it", path.display(), io_words(error))]
    Io {
        /// The file.
        path: PathBuf,
        /// The operating system's error.
        error: io::Error,
    },
    /// A line is invalid.
    #[error("{}:{line}:{column}: {message}; expected {expected}", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: u64,
        /// The column in bytes, from 1.
        column: usize,
        /// What is wrong.
        message: String,
        /// What was expected.
        expected: String,
    },
}

naoisis_core::debug_as_displayed!(TraceError);

fn io_words(error: &io::Error) -> String {
    if error.kind() == ErrorKind::NotFound { "there is no such file".to_owned() } else { error.to_string() }
}

/// How a trace ends.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Ending {
    /// There are more lines.
    NotYet,
    /// The trace is complete: its last line gives this reason.
    Proper(EndReason),
    /// The last line is missing: the program that wrote the trace was killed.
    BrokenOff,
}

#[derive(Deserialize)]
struct HeaderLine {
    format: String,
    version: u32,
    #[serde(default = "one")]
    every: u64,
    #[serde(default)]
    fields: Fields,
    scenario: Value,
}

fn one() -> u64 {
    1
}

#[derive(Deserialize)]
struct LineType {
    #[serde(rename = "type")]
    line_type: String,
}

/// Reads a trace line by line.
pub struct TraceReader {
    path: PathBuf,
    lines: BufReader<Box<dyn Read + Send>>,
    text: Vec<u8>,
    line: u64,
    every: u64,
    fields: Fields,
    scenario: Scenario,
    /// The number of the last cycle, and its time, s.
    last: Option<(u64, f64)>,
    ending: Ending,
    end: Option<MatchEnd>,
}

impl TraceReader {
    /// Opens a trace and reads its header. The trace may be plain, compressed or in an MCAP file, whatever its name is. The lines of an
    /// MCAP file are the header, the messages of its channel `/trace`, and the end.
    ///
    /// # Errors
    /// If there is no such file, or it does not begin as a trace does.
    pub fn open(path: &Path) -> Result<Self, TraceError> {
        let io_error = |error| TraceError::Io { path: path.to_owned(), error };
        let mut file = BufReader::new(File::open(path).map_err(io_error)?);
        let start = file.fill_buf().map_err(io_error)?;
        if start.starts_with(GZIP) {
            let name = path.display();
            let error =
                io::Error::other(format!("it is packed by gzip, which is not read; unpack it: gunzip -c {name}"));
            return Err(io_error(error));
        }
        if is_mcap(start) {
            return Self::new(path, McapTrace::new(file, LONGEST_LINE_BYTES as usize));
        }
        if let Some(kind) = foreign_file(start) {
            return Err(io_error(io::Error::other(format!("this is {kind}; naoisis cannot read it"))));
        }
        let reader: Box<dyn Read + Send> = if start.starts_with(ZSTANDARD) {
            Box::new(zstd::stream::read::Decoder::with_buffer(file).map_err(io_error)?)
        } else {
            Box::new(file)
        };
        Self::new(path, reader)
    }

    /// Reads the header of a trace from a reader. `path` is the name in error messages.
    ///
    /// # Errors
    /// If the data does not begin as a trace does.
    pub fn new(path: &Path, reader: impl Read + Send + 'static) -> Result<Self, TraceError> {
        let mut trace = Self {
            path: path.to_owned(),
            lines: BufReader::with_capacity(1 << 16, Box::new(reader)),
            text: Vec::new(),
            line: 0,
            every: 1,
            fields: Fields::default(),
            scenario: Scenario::default(),
            last: None,
            ending: Ending::NotYet,
            end: None,
        };
        let expected = "a trace, which begins with its header";
        if !trace.next_line()? {
            return Err(trace.fault(1, "the file has no whole line", expected));
        }
        if trace.text.starts_with(BYTE_ORDER_MARK) {
            trace.text.drain(..BYTE_ORDER_MARK.len());
        }
        if !trace.text.trim_ascii_start().starts_with(b"{") {
            return Err(trace.fault(1, "this is no trace: it does not begin with an object", expected));
        }
        if trace.line_type()? != "header" {
            return Err(trace.fault(1, "this line is no header", expected));
        }
        let header: HeaderLine = trace.parse("the header of a trace")?;
        if header.format != FORMAT || header.version > VERSION {
            let message = format!("this is `{}`, version {}", header.format, header.version);
            return Err(trace.fault(1, &message, &format!("`{FORMAT}`, version {VERSION}")));
        }
        trace.every = header.every.max(1);
        trace.fields = header.fields;
        trace.scenario = trace.scenario_of(&header.scenario)?;
        Ok(trace)
    }

    /// Reads the scenario of the header, which is checked like that of a file.
    fn scenario_of(&self, value: &Value) -> Result<Scenario, TraceError> {
        let scenario = read_settings::<Scenario>(value, &FieldPath::default());
        let sound = scenario.and_then(|scenario| scenario.validate().map(|()| scenario));
        sound.map_err(|fault| {
            let path = fault.path.clone().within(&FieldPath::from("scenario"));
            self.fault(1, &format!("`{path}`: {}", fault.message), &fault.expected)
        })
    }

    /// Returns the scenario of the match, with its seed.
    pub fn scenario(&self) -> &Scenario {
        &self.scenario
    }

    /// Returns the number of cycles from one line to the next.
    pub fn every(&self) -> u64 {
        self.every
    }

    /// Returns the fields that the lines have.
    pub fn fields(&self) -> &Fields {
        &self.fields
    }

    /// Returns how the trace ends, as far as it was read.
    pub fn ending(&self) -> Ending {
        self.ending
    }

    /// Returns the end of the match. Returns `None` before it is read, or if the trace breaks off.
    pub fn end(&self) -> Option<MatchEnd> {
        self.end
    }

    /// Returns the result of the match, after its end was read.
    pub fn result(&self) -> Option<MatchResult> {
        self.end.and_then(|end| end.result)
    }

    /// Reads the next cycle. Returns `None` after the last one.
    ///
    /// # Errors
    /// The fault of the line, and where it is.
    pub fn next_cycle(&mut self) -> Result<Option<CycleRecord>, TraceError> {
        if self.ending != Ending::NotYet {
            return Ok(None);
        }
        if !self.next_line()? {
            self.ending = Ending::BrokenOff;
            return Ok(None);
        }
        match self.line_type()?.as_str() {
            "cycle" => {}
            "end" => {
                let end: MatchEnd = self.parse("the last line of a trace")?;
                self.ending = Ending::Proper(end.reason);
                self.end = Some(end);
                // The checksum of compressed data follows.
                while self.next_line()? {}
                return Ok(None);
            }
            other => {
                let message = format!("there is no line of type `{other}`");
                return Err(self.fault(1, &message, "`cycle` or `end`"));
            }
        }
        let mut record: CycleRecord = self.parse("a cycle of a trace")?;
        if let Some((last, _)) = self.last
            && !(record.cycle > last && record.cycle - last <= self.every)
        {
            let message = format!("this is cycle {}, after cycle {last}", record.cycle);
            let expected = if self.every == 1 { "cycle" } else { "at most cycle" };
            return Err(self.fault(1, &message, &format!("{expected} {}", last.saturating_add(self.every))));
        }
        let from_s = self.last.map_or(0.0, |(_, last_s)| last_s);
        if record.time_s < from_s {
            let message = format!("`time_s` is {}", record.time_s);
            return Err(self.fault(1, &message, &format!("at least {from_s} s")));
        }
        if record.time_s > LONGEST_S {
            return Err(self.fault(1, &format!("`time_s` is {}", record.time_s), &format!("at most {LONGEST_S} s")));
        }
        if let Some(pair) = record.robots.windows(2).find(|pair| pair[0].id >= pair[1].id) {
            let message = format!("{} follows {}", pair[1].id, pair[0].id);
            return Err(self.fault(1, &message, "robots in the order of their ids, each once"));
        }
        self.last = Some((record.cycle, record.time_s));
        record.time_s = self.exact_time_s(&record);
        Ok(Some(record))
    }

    /// The time at the end of a cycle as the match had it. That in the trace is rounded, and comparisons of times would come out otherwise.
    fn exact_time_s(&self, record: &CycleRecord) -> f64 {
        /// The greatest difference that is taken for rounding, s.
        const ROUNDING_S: f64 = 1e-4;

        let exact_s = CycleClock { cycle: record.cycle, period_s: self.scenario.cycle_s }.end_time_s();
        if (exact_s - record.time_s).abs() < ROUNDING_S { exact_s } else { record.time_s }
    }

    /// Reads the next line without its line end. Returns false if there is none, or only an incomplete one.
    fn next_line(&mut self) -> Result<bool, TraceError> {
        self.text.clear();
        let read = (&mut self.lines).take(LONGEST_LINE_BYTES).read_until(b'\n', &mut self.text);
        match read {
            // A compressed trace that breaks off ends in the middle of a block.
            Err(error) if error.kind() == ErrorKind::UnexpectedEof => return Ok(false),
            // Of the decompressor.
            Err(error) if error.kind() == ErrorKind::Other => {
                self.line += 1;
                let message = format!("the data is damaged from here on or before: {error}");
                return Err(self.fault(1, &message, "a trace as it was written"));
            }
            Err(error) => return Err(TraceError::Io { path: self.path.clone(), error }),
            Ok(0) => return Ok(false),
            Ok(_) => {}
        }
        self.line += 1;
        if self.text.pop_if(|byte| *byte == b'\n').is_some() {
            return Ok(true);
        }
        if self.text.len() as u64 == LONGEST_LINE_BYTES {
            let message = format!("the line has more than {} MiB", LONGEST_LINE_BYTES >> 20);
            return Err(self.fault(1, &message, "a line of a trace"));
        }
        // The last line may lack its line end, if it is complete otherwise.
        Ok(serde_json::from_slice::<serde::de::IgnoredAny>(&self.text).is_ok())
    }

    fn line_type(&self) -> Result<String, TraceError> {
        // Nearly all lines begin with their type, and need not be parsed twice.
        if self.text.starts_with(br#"{"type":"cycle","#) {
            return Ok("cycle".to_owned());
        }
        self.parse::<LineType>("a line of a trace: an object with a `type`").map(|line| line.line_type)
    }

    fn parse<'de, T: Deserialize<'de>>(&'de self, expected: &str) -> Result<T, TraceError> {
        serde_json::from_slice(&self.text).map_err(|error| {
            let message = error.to_string();
            // The error names the line of the file instead.
            let message = message.split(" at line ").next().unwrap_or_default();
            self.fault(error.column(), message, expected)
        })
    }

    fn fault(&self, column: usize, message: &str, expected: &str) -> TraceError {
        TraceError::Line {
            path: self.path.clone(),
            line: self.line.max(1),
            column: column.max(1),
            message: message.to_owned(),
            expected: expected.to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::recorder::Recorder;
    use crate::record::trace::TraceRecorder;
    use bevy::prelude::World;
    use naoisis_core::events::MatchEvent;
    use naoisis_core::geometry::Pose;
    use naoisis_core::robot::posture::Posture;

    const HEADER: &str = r#"{"type":"header","format":"naoisis-trace","version":1,"seed":3,"scenario":{"seed":3}}"#;

    fn cycle(number: u64) -> String {
        format!(
            r#"{{"type":"cycle","cycle":{number},"time_s":0.1,"ball":null,"robots":[{{"id":"pink2","pose":[1,2,90],
            "velocity":[0.1,0,90],"head_deg":[90,-30],"penalised":null,"odometry":[0,0,0],"sonar_m":{{"left":null,"right":0.4}},
            "percepts":{{"ball":null,"goal_posts":[],"robots":[],"landmarks":[]}},"inbox":[],"belief":null,"unknown":1}}],"game":{{"state":"playing","score":{{"blue":1,"pink":0}},
            "half":1,"time_left_s":5.0}},"events":[{{"kind":"final_whistle"}}]}}"#
        )
        .replace('\n', "")
    }

    fn read(lines: &[&str]) -> Result<(Vec<CycleRecord>, Ending), TraceError> {
        let text = lines.join("\n");
        let mut trace = TraceReader::new(Path::new("match.jsonl"), io::Cursor::new(text.into_bytes()))?;
        let mut records = Vec::new();
        while let Some(record) = trace.next_cycle()? {
            records.push(record);
        }
        Ok((records, trace.ending()))
    }

    fn message(lines: &[&str]) -> String {
        read(lines).expect_err("a broken trace").to_string()
    }

    #[test]
    fn times_are_those_of_the_match_although_a_trace_rounds_them() {
        let at = |number: u64, time_s: &str| cycle(number).replace("\"time_s\":0.1,", &format!("\"time_s\":{time_s},"));
        let [first, second, third] = [at(1, "0.03333"), at(2, "0.06667"), at(3, "0.5")];
        let (records, _) = read(&[HEADER, &first, &second, &third]).unwrap();
        let times: Vec<f64> = records.iter().map(|record| record.time_s).collect();
        // The last one is no rounded time of its cycle, as in a trace of another program.
        assert_eq!(times, [1.0 / 30.0, 2.0 / 30.0, 0.5]);
    }

    #[test]
    fn times_do_not_go_back_and_numbers_are_finite() {
        for (from, to, told) in [
            ("0.1,\"ball", "-1,\"ball", "`time_s` is -1; expected at least 0.1 s"),
            ("0.1,\"ball", "0.09,\"ball", "`time_s` is 0.09; expected at least 0.1 s"),
            ("[1,2,90]", "[1,1e300,90]", "expected a finite number, of single precision"),
            (
                "\"ball\":null,\"robots",
                "\"ball\":{\"position_m\":[0,0,1e300],\"velocity_mps\":[0,0,0]},\"robots",
                "number out of range; expected a cycle of a trace",
            ),
        ] {
            let wrong = cycle(1).replacen(from, to, 1);
            assert_ne!(wrong, cycle(1), "{from}");
            let said = message(&[HEADER, &cycle(0), &wrong, ""]);
            assert!(said.starts_with("match.jsonl:3:") && said.contains(told), "{said}");
        }
    }

    #[test]
    fn cycles_are_read_in_radians() {
        let end = r#"{"type":"end","reason":"final_whistle"}"#;
        let (records, ending) = read(&[HEADER, &cycle(0), &cycle(1), end]).unwrap();
        assert_eq!((records.len(), ending), (2, Ending::Proper(EndReason::FinalWhistle)));
        let robot = &records[1].robots[0];
        let quarter = core::f32::consts::FRAC_PI_2;
        assert_eq!(robot.pose, Pose::new(1.0, 2.0, quarter));
        assert_eq!((robot.velocity.angular, robot.head.yaw), (quarter, quarter));
        assert_eq!((robot.posture, robot.sonar_m.right), (Posture::Upright, Some(0.4)));
        assert_eq!(records[1].events, [MatchEvent::FinalWhistle]);
    }

    #[test]
    fn a_flipped_bit_of_a_compressed_trace_is_noticed() {
        let (first, second) = (cycle(0), cycle(1));
        let text = [HEADER, &first, &second, r#"{"type":"end","reason":"duration"}"#, ""].join("\n");
        let mut encoder = zstd::stream::write::Encoder::new(Vec::new(), 3).unwrap();
        encoder.include_checksum(true).unwrap();
        io::Write::write_all(&mut encoder, text.as_bytes()).unwrap();
        let packed = encoder.finish().unwrap();
        let ending = |packed: Vec<u8>| -> Result<Ending, TraceError> {
            let decoder = zstd::stream::read::Decoder::new(io::Cursor::new(packed)).unwrap();
            let mut trace = TraceReader::new(Path::new("match.jsonl.zst"), decoder)?;
            while trace.next_cycle()?.is_some() {}
            Ok(trace.ending())
        };
        assert_eq!(ending(packed.clone()).unwrap(), Ending::Proper(EndReason::Duration));
        // The window size, in the frame's header, changes no content.
        let first_block = 6;
        for index in first_block..packed.len() {
            let mut damaged = packed.clone();
            damaged[index] ^= 1;
            assert!(!matches!(ending(damaged), Ok(Ending::Proper(_))), "byte {index}");
        }
    }

    #[test]
    fn a_trace_of_a_killed_program_is_read_as_far_as_it_goes() {
        let whole = cycle(1);
        for rest in [&[][..], &[""], &["{"], &[&whole[..40]]] {
            let (records, ending) = read(&[&[HEADER, &cycle(0)], rest].concat()).unwrap();
            assert_eq!((records.len(), ending), (1, Ending::BrokenOff), "{rest:?}");
        }
    }

    #[test]
    fn every_line_that_was_written_is_in_the_file_when_the_program_is_killed() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["plain.jsonl", "small.jsonl.zst"] {
            let path = folder.path().join(name);
            let mut recorder = TraceRecorder::create(&path).unwrap();
            recorder.start(&Scenario::default(), &CycleRecord::default(), &mut World::new());
            // A killed program closes nothing.
            core::mem::forget(recorder);
            assert!(TraceReader::open(&path).is_ok(), "{name}");
        }
    }

    #[test]
    fn a_trace_is_read_by_what_is_in_it_and_not_by_its_name() {
        let folder = tempfile::tempdir().unwrap();
        let text = [HEADER, &cycle(0), &cycle(1), ""].join("\n");
        let packed = zstd::bulk::compress(text.as_bytes(), 1).unwrap();
        let windows = format!("\u{feff}{}", text.replace('\n', "\r\n"));
        let files: [(&str, &[u8]); 4] = [
            ("packed.jsonl", &packed),
            ("plain.jsonl.zst", text.as_bytes()),
            ("plain.gz", text.as_bytes()),
            ("windows.txt", windows.as_bytes()),
        ];
        for (name, bytes) in files {
            let path = folder.path().join(name);
            std::fs::write(&path, bytes).unwrap();
            let mut trace = TraceReader::open(&path).unwrap_or_else(|error| panic!("{error}"));
            let cycles: Vec<u64> =
                core::iter::from_fn(|| trace.next_cycle().unwrap()).map(|cycle| cycle.cycle).collect();
            assert_eq!(cycles, [0, 1], "{name}");
        }
        let path = folder.path().join("really.jsonl.gz");
        std::fs::write(&path, b"\x1f\x8b\x08\0").unwrap();
        let error = TraceReader::open(&path).err().unwrap().to_string();
        assert!(error.contains("it is packed by gzip, which is not read; unpack it: gunzip -c"), "{error}");
        let path = folder.path().join("match.rcg");
        std::fs::write(&path, b"ULG5\n").unwrap();
        let error = TraceReader::open(&path).err().unwrap().to_string();
        assert!(
            error.contains("this is a log of rcssserver, of the 2D simulation league; naoisis cannot read it"),
            "{error}"
        );
    }

    #[test]
    fn what_is_wrong_is_said_with_its_place() {
        assert_eq!(
            message(&[HEADER, &cycle(0), "{\"type\":\"cycle\",\"cycle\":x}", ""]),
            "match.jsonl:3:25: expected value; expected a cycle of a trace"
        );
        assert_eq!(
            message(&[HEADER, &cycle(0), "{\"type\":\"cycle\",\"cycle\":1,\"robots\":[]}", ""]),
            "match.jsonl:3:38: missing field `time_s`; expected a cycle of a trace"
        );
        assert_eq!(
            message(&[HEADER, &cycle(0), &cycle(2), ""]),
            "match.jsonl:3:1: this is cycle 2, after cycle 0; expected cycle 1"
        );
        assert_eq!(
            message(&["{\"type\":\"cycle\"}", ""]),
            "match.jsonl:1:1: this line is no header; expected a trace, which begins with its header"
        );
        let scenario = |scenario: &str| message(&[&HEADER.replace(r#"{"seed":3}"#, scenario), &cycle(0), ""]);
        assert_eq!(
            scenario(r#"{"cycle_s":0}"#),
            "match.jsonl:1:1: `scenario.cycle_s`: `cycle_s` is 0; expected 0.001 to 1 s"
        );
        assert!(scenario(r#"{"sede":3}"#).contains("1:1: `scenario.sede`: there is no field `sede`"));
        assert!(
            scenario(r#"{"robots":[{"number":1},{"number":1}]}"#)
                .contains("1:1: `scenario.robots[1].number`: there is a blue1 already")
        );
        assert!(message(&[""]).contains("the file has no whole line"));
        assert_eq!(
            message(&[&HEADER.replace("naoisis-trace", "rosbag"), ""]),
            "match.jsonl:1:1: this is `rosbag`, version 1; expected `naoisis-trace`, version 1"
        );
    }
}
