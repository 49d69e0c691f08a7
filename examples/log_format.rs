//! A custom log format: the positions of the ball as a table for other programs.
//!
//! Run with `cargo run --release --no-default-features --example log_format -- run match3v3 --log ball_csv=ball.csv`;
//! without a command it prints the contents of such a file.

#![expect(clippy::print_stdout, reason = "an example says what it finds")]

use bevy::prelude::*;
use naoisis::interface::cycle_record::CycleRecord;
use naoisis::prelude::*;
use naoisis::record::RecordPlugin;
use naoisis::record::output_file::OutputFile;
use naoisis::record::recorder::{self, EndReason, MatchEnd, RecordError, Recorder};
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;
use std::process::ExitCode;

/// A table of the ball's positions.
struct BallTable {
    output: OutputFile,
    file: BufWriter<File>,
    /// The first error, which is reported at the end.
    error: Option<io::Error>,
}

impl BallTable {
    fn create(path: &Path) -> Result<Self, RecordError> {
        let output = OutputFile::create(path)?;
        let mut file = BufWriter::new(output.writer()?);
        let error = writeln!(file, "time_s,x_m,y_m").err();
        Ok(Self { output, file, error })
    }
}

impl Recorder for BallTable {
    fn record(&mut self, record: &CycleRecord, _: &mut World) {
        let Some(ball) = &record.ball else { return };
        let (time_s, place) = (record.time_s, ball.position_m);
        if let Err(error) = writeln!(self.file, "{time_s:.3},{:.4},{:.4}", place.x, place.y) {
            self.error.get_or_insert(error);
        }
    }

    fn has_failed(&self) -> bool {
        self.error.is_some()
    }

    fn finish(mut self: Box<Self>, _: &MatchEnd, _: &CycleRecord) -> Result<Option<String>, RecordError> {
        let written = self.error.take().map_or_else(|| self.file.flush(), Err);
        let said = format!("the positions of the ball are in {}", self.output.path().display());
        self.output.close(written).map(|()| Some(said))
    }
}

fn add_format(app: &mut App) {
    app.add_log_format("ball_csv", "the positions of the ball, as a table", BallTable::create);
}

fn main() -> Result<ExitCode, Box<dyn core::error::Error>> {
    if std::env::args().len() > 1 {
        return Ok(naoisis::cli::run(add_format));
    }
    let path = std::env::temp_dir().join(format!("ball_{}.csv", std::process::id()));
    let mut app = App::new();
    app.add_plugins((NaoisisPlugins, RecordPlugin));
    app.start_match(&Scenario::named("kick_right_straight")?)?;
    recorder::start(app.world_mut(), vec![Box::new(BallTable::create(&path)?)]);
    app.run_cycles(90);
    for said in recorder::finish(app.world_mut(), EndReason::Duration) {
        println!("{}", said?.unwrap_or_default());
    }
    let table = std::fs::read_to_string(&path)?;
    std::fs::remove_file(&path)?;
    let last = table.lines().last().unwrap_or_default();
    println!("{} lines, the last is {last}", table.lines().count());
    // The names of the columns, the start, and every cycle.
    assert_eq!(table.lines().count(), 1 + 1 + 90);
    Ok(ExitCode::SUCCESS)
}
