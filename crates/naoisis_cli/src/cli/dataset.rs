//! `naoisis dataset`: labelled images for training detectors.

use clap::Args;
use indicatif::ProgressStyle;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use super::agents::AgentArguments;
use super::interrupt::Interrupt;
use super::report::{CommandResult, OrReport};
use super::teams::TeamArguments;
use super::terminal::Printer;
use super::{Program, report};
use naoisis_record::dataset::{ClassNames, DatasetFormat, DatasetSettings, Made, Ranges, YoloTask, make};
use naoisis_sim::scenario::wording::one_of;
use naoisis_sim::scenario::{Scenario, Setting};

/// Arguments of `naoisis dataset`.
#[derive(Args, Debug, Clone)]
pub struct DatasetArguments {
    /// The matches: a scenario file, or the name of a built-in scenario or of a league
    #[arg(default_value = "hsl2026_middle")]
    scenario: String,
    /// The same as the first argument
    #[arg(long = "scenario", value_name = "SCENARIO", conflicts_with = "scenario")]
    scenario_option: Option<String>,
    /// The folder of the data set: new, empty, or with one that was interrupted, which is continued
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Number of images
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    images: u32,
    /// The layout: coco (as Roboflow's), yolo (as Ultralytics'), webdataset; several with commas
    #[arg(long, value_name = "FORMAT", value_delimiter = ',', default_value = "coco", value_parser = format)]
    format: Vec<DatasetFormat>,
    /// The names of classes: naoisis, torso21, hulks or booster
    #[arg(long, value_name = "NAMES", default_value = "naoisis", value_parser = names)]
    names: ClassNames,
    /// What labels of YOLO say: detect (boxes), segment (outlines) or pose (key points of robots)
    #[arg(long, value_name = "TASK", default_value = "detect", value_parser = task)]
    yolo: YoloTask,
    /// Write masks, too: the label of each pixel
    #[arg(long)]
    masks: bool,
    /// Write the depth of each pixel, too, in millimetres
    #[arg(long)]
    depth: bool,
    /// Width and height of the images, pixels [default: those of the robots' cameras]
    #[arg(long, value_name = "WIDTHxHEIGHT", value_parser = size)]
    size: Option<[u32; 2]>,
    /// The ranges from which looks are drawn, laid over those of the program (.ron or .json)
    #[arg(long, value_name = "FILE")]
    looks: Option<PathBuf>,
    /// The model of robots, instead of the scenario's
    #[arg(long, value_name = "MODEL")]
    robot: Option<String>,
    /// Set a field of the scenario: cameras.width=320
    #[arg(long, value_name = "PATH=VALUE")]
    set: Vec<Setting>,
    /// Seed of the first match; each further match has the next seed
    #[arg(long, value_name = "N", default_value_t = 1, allow_negative_numbers = true)]
    seed: u64,
    /// Number of threads [default: one per core]; the files are the same with any number
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Replace a data set with other settings, or a complete one
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    agents: AgentArguments,
    /// Print nothing but errors
    #[arg(long)]
    quiet: bool,
}

/// Returns the value that a word stands for.
fn among<T: Copy>(all: &[(&'static str, T)], word: &str) -> Result<T, String> {
    let found = all.iter().find(|(name, _)| *name == word).map(|(_, value)| *value);
    found.ok_or_else(|| format!("expected {}", one_of(all.iter().map(|(name, _)| *name))))
}

fn format(word: &str) -> Result<DatasetFormat, String> {
    among(&DatasetFormat::ALL, word)
}

fn names(word: &str) -> Result<ClassNames, String> {
    among(&ClassNames::ALL, word)
}

fn task(word: &str) -> Result<YoloTask, String> {
    among(&YoloTask::ALL, word)
}

fn size(word: &str) -> Result<[u32; 2], String> {
    let sides = word.split_once('x').and_then(|(width, height)| Some([width.parse().ok()?, height.parse().ok()?]));
    sides
        .filter(|sides| sides.iter().all(|side| (16..=4096).contains(side)))
        .ok_or_else(|| "expected width and height of 16 to 4096 pixels, such as 640x480".to_owned())
}

impl DatasetArguments {
    fn scenario_name(&self) -> &str {
        self.scenario_option.as_deref().unwrap_or(&self.scenario)
    }

    fn scenario(&self) -> Result<Scenario, ExitCode> {
        let file = super::begin::scenario_file(self.scenario_name())?;
        let mut settings = self.set.clone();
        if let Some(robot) = &self.robot {
            let setting = format!("model={robot}").parse::<Setting>();
            settings.push(setting.map_err(|error| report::usage_error(&format!("--robot: {error}")))?);
        }
        let file = file.check_with(&settings).map_err(|errors| report::scenario_errors(&errors))?;
        if !self.quiet {
            super::notes::tell(&super::notes::of_scenario(&file));
        }
        Ok(file.scenario)
    }

    fn settings(&self) -> Result<DatasetSettings, ExitCode> {
        let ranges = Ranges::read(self.looks.as_deref()).map_err(|error| report::scenario_error(&error))?;
        if let Some((path, expected)) = ranges.fault() {
            let file = self.looks.as_ref().map(|file| file.display().to_string()).unwrap_or_default();
            return Err(report::usage_error(&format!("--looks: {file}: `{path}` cannot be; expected {expected}")));
        }
        let mut formats = self.format.clone();
        formats.dedup();
        let Self { seed, names, yolo, masks, depth, size, .. } = *self;
        let mut settings = DatasetSettings::new(self.images, ranges);
        (settings.seed, settings.formats, settings.names) = (seed, formats, names);
        (settings.yolo, settings.masks, settings.depth, settings.size) = (yolo, masks, depth, size);
        Ok(settings)
    }
}

/// Runs the command.
pub fn dataset(program: Program<'_>, arguments: &DatasetArguments) -> CommandResult {
    let (scenario, settings) = (arguments.scenario()?, arguments.settings()?);
    let interrupt = Interrupt::finish_running().or_failure()?;
    let progress = super::batch::progress_bar(settings.images as usize, 0, arguments.quiet);
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {pos}/{len} images, {per_sec}, {eta} left") {
        progress.set_style(style);
    }
    let agents = arguments.agents.settings(arguments.scenario_name(), &TeamArguments::default());
    let simulator = || {
        let mut app = program.simulator();
        app.insert_resource(agents.clone());
        app
    };
    let threads =
        arguments.threads.map_or_else(|| std::thread::available_parallelism().map_or(1, usize::from), usize::from);
    let started = Instant::now();
    let made =
        make(&arguments.out, &scenario, &settings, arguments.force, threads, interrupt.stop(), simulator, |images| {
            progress.set_position(u64::from(images));
        });
    progress.finish_and_clear();
    let made = made.map_err(|error| match error {
        error if error.is_usage() => report::usage_error(&format!("--out: {error}")),
        error => report::failure(&error.to_string()),
    })?;
    let mut printer = Printer::default();
    if !arguments.quiet {
        printer.print(summary(&made, &settings, arguments, started.elapsed().as_secs_f64()));
    }
    let status = printer.finish(ExitCode::SUCCESS);
    Ok(if made.is_complete { status } else { interrupt.finish(status) })
}

fn summary(made: &Made, settings: &DatasetSettings, arguments: &DatasetArguments, wall_s: f64) -> String {
    let Made { images, earlier, is_complete } = *made;
    let out = arguments.out.display();
    if earlier == images && is_complete {
        return format!("{out} is complete: {images} images\n");
    }
    let new = images - earlier.min(images);
    let rate = f64::from(new) / wall_s.max(1e-3);
    let how_many = if is_complete { images.to_string() } else { format!("{images} of {}", settings.images) };
    let text = format!("{how_many} images in {out}, {new} of them in {wall_s:.1} s ({rate:.1} a second)\n");
    if is_complete { text } else { text + "interrupted; the same command continues\n" }
}
