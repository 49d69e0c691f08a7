//! Episodes of learning tasks as a data set in the layout of [Minari](https://minari.farama.org) 0.5, with Parquet files.
//!
//! The data set `naoisis/ScoreEmptyGoal/striker-v0` is the folder of this name below the folder of data sets, which Minari takes from
//! `MINARI_DATASETS_PATH`. It has `data/metadata.json`, and for each episode `data/N/part-0.parquet` and `data/N/metadata.json`. A table has
//! one row more than the episode has steps: the last one has the last observation only.

use parquet::basic::{Compression, LogicalType, Repetition, Type as PhysicalType, ZstdLevel};
use parquet::data_type::{BoolType, FloatType};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::{Type, TypePtr};
use serde_json::{Value, json};
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use naoisis_core::replace_file::replace_file;

/// The version of Minari whose layout this is.
const MINARI_VERSION: &str = "0.5.4";

/// One agent's steps in an episode.
#[derive(Clone, Copy, Debug)]
pub struct EpisodeSteps<'a> {
    /// The observations before each step and after the last one, one after the other.
    pub observations: &'a [f32],
    /// The actions of the steps, one after the other.
    pub actions: &'a [f32],
    /// The rewards of the steps.
    pub rewards: &'a [f32],
    /// Whether the last step ended the task.
    pub is_terminated: bool,
    /// Whether the time limit ended the episode at its last step.
    pub is_truncated: bool,
    /// The seed of the episode.
    pub seed: u64,
    /// The agent.
    pub agent: &'a str,
}

/// A data set that is being written.
#[derive(Debug)]
pub struct MinariDataset {
    folder: PathBuf,
    /// The numbers of an observation and of an action.
    lengths: [usize; 2],
    metadata: Value,
    episodes: usize,
    steps: usize,
    bytes: u64,
}

impl MinariDataset {
    /// Creates the data set `id` below `root`, instead of an existing one if `replaces` is set. `spaces` are the least and greatest values of observations and of actions; `facts` are further
    /// fields of its metadata, such as `author`.
    ///
    /// # Errors
    /// The folder exists, or cannot be made.
    pub fn create(root: &Path, id: &str, spaces: [&[[f32; 2]]; 2], facts: Value, replaces: bool) -> io::Result<Self> {
        let folder = root.join(id).join("data");
        // A folder without metadata is one of a data set that was broken off.
        if folder.exists() && replaces {
            fs::remove_dir_all(&folder)?;
        } else if folder.exists() {
            return Err(io::Error::new(io::ErrorKind::AlreadyExists, "the data set exists already"));
        }
        fs::create_dir_all(&folder)?;
        let [observation_space, action_space] = spaces.map(|space| space_of(space).to_string());
        let mut metadata = json!({
            "dataset_id": id,
            "minari_version": MINARI_VERSION,
            "data_format": "parquet",
            "observation_space": observation_space,
            "action_space": action_space,
            "jpeg_encoding": false,
        });
        if let (Some(metadata), Value::Object(facts)) = (metadata.as_object_mut(), facts) {
            metadata.extend(facts);
        }
        Ok(Self { folder, lengths: spaces.map(<[_]>::len), metadata, episodes: 0, steps: 0, bytes: 0 })
    }

    /// The folder with the episodes.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The number of episodes and of steps that have been written.
    pub fn written(&self) -> [usize; 2] {
        [self.episodes, self.steps]
    }

    /// Writes the next episode. Episodes are numbered from 0.
    ///
    /// # Errors
    /// The lengths of its lists do not fit, or a file cannot be written.
    pub fn add(&mut self, episode: &EpisodeSteps) -> io::Result<()> {
        let steps = episode.rewards.len();
        let [observation, action] = self.lengths;
        if episode.observations.len() != (steps + 1) * observation || episode.actions.len() != steps * action {
            return Err(io::Error::other("an episode has a row for each step, and one more observation"));
        }
        let folder = self.folder.join(self.episodes.to_string());
        fs::create_dir_all(&folder)?;
        let table = folder.join("part-0.parquet");
        write_table(File::create(&table)?, episode, self.lengths).map_err(io::Error::other)?;
        self.bytes += fs::metadata(&table)?.len();
        let metadata =
            json!({ "id": self.episodes, "total_steps": steps, "seed": episode.seed, "agent": episode.agent });
        write_json(&folder.join("metadata.json"), &metadata)?;
        self.episodes += 1;
        self.steps += steps;
        Ok(())
    }

    /// Completes the description of the data set. Only then can the data set be read.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn finish(mut self) -> io::Result<()> {
        self.metadata["total_episodes"] = self.episodes.into();
        self.metadata["total_steps"] = self.steps.into();
        // In megabytes, rounded to a tenth.
        self.metadata["dataset_size"] = ((self.bytes as f64 / 1e5).round() / 10.0).into();
        write_json(&self.folder.join("metadata.json"), &self.metadata)
    }
}

/// A space of Gymnasium with these least and greatest values.
fn space_of(ranges: &[[f32; 2]]) -> Value {
    let side = |index: usize| ranges.iter().map(|range| range[index]).collect::<Vec<f32>>();
    json!({ "type": "Box", "dtype": "float32", "shape": [ranges.len()], "low": side(0), "high": side(1) })
}

fn write_json(path: &Path, value: &Value) -> io::Result<()> {
    replace_file(path, |mut file| io::Write::write_all(&mut file, format!("{value:#}\n").as_bytes()))
}

fn write_table(file: File, episode: &EpisodeSteps, [observation, action]: [usize; 2]) -> Result<(), ParquetError> {
    let primitive = |name: &str, kind| {
        Type::primitive_type_builder(name, kind).with_repetition(Repetition::REQUIRED).build().map(Arc::new)
    };
    let fields = vec![
        list("observations")?,
        list("actions")?,
        primitive("rewards", PhysicalType::FLOAT)?,
        primitive("terminations", PhysicalType::BOOLEAN)?,
        primitive("truncations", PhysicalType::BOOLEAN)?,
    ];
    let schema = Type::group_type_builder("episode").with_fields(fields).build()?;
    let properties = WriterProperties::builder()
        .set_created_by("naoisis".to_owned())
        .set_compression(Compression::ZSTD(ZstdLevel::default()))
        .build();
    let mut writer = SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties))?;
    let mut group = writer.next_row_group()?;
    let rows = episode.rewards.len() + 1;
    // The row of the last observation has an action and a reward of 0, as Minari pads them.
    let mut actions = episode.actions.to_vec();
    actions.resize(rows * action, 0.0);
    let mut rewards = episode.rewards.to_vec();
    rewards.push(0.0);
    let at_the_end = |is: bool| (0..rows).map(|row| is && row + 2 == rows).collect::<Vec<bool>>();
    for column in 0..5 {
        let Some(mut cells) = group.next_column()? else { break };
        match column {
            0 | 1 => {
                let (values, length) =
                    if column == 0 { (episode.observations, observation) } else { (actions.as_slice(), action) };
                // A new list begins at each row.
                let repetitions: Vec<i16> = (0..rows * length).map(|index| i16::from(index % length != 0)).collect();
                let levels = vec![1; values.len()];
                cells.typed::<FloatType>().write_batch(values, Some(&levels), Some(&repetitions))?;
            }
            2 => drop(cells.typed::<FloatType>().write_batch(&rewards, None, None)?),
            3 => drop(cells.typed::<BoolType>().write_batch(&at_the_end(episode.is_terminated), None, None)?),
            _ => drop(cells.typed::<BoolType>().write_batch(&at_the_end(episode.is_truncated), None, None)?),
        }
        cells.close()?;
    }
    group.close()?;
    writer.close().map(drop)
}

/// A column with a list of numbers in each row.
fn list(name: &str) -> Result<TypePtr, ParquetError> {
    let element =
        Type::primitive_type_builder("element", PhysicalType::FLOAT).with_repetition(Repetition::REQUIRED).build()?;
    let elements = Type::group_type_builder("list")
        .with_repetition(Repetition::REPEATED)
        .with_fields(vec![Arc::new(element)])
        .build()?;
    let list = Type::group_type_builder(name)
        .with_logical_type(Some(LogicalType::List))
        .with_repetition(Repetition::REQUIRED)
        .with_fields(vec![Arc::new(elements)])
        .build()?;
    Ok(Arc::new(list))
}

#[cfg(test)]
mod tests {
    use super::*;
    use parquet::file::reader::{FileReader, SerializedFileReader};

    #[test]
    fn an_episode_has_a_row_for_each_observation() {
        let root = std::env::temp_dir().join(format!("naoisis-minari-{}", std::process::id()));
        let ranges = [[-1.0, 1.0], [0.0, 2.0]];
        let mut dataset = MinariDataset::create(
            &root,
            "naoisis/Test/idle-v0",
            [&ranges, &ranges[..1]],
            json!({ "author": "us" }),
            false,
        )
        .unwrap();
        let again = MinariDataset::create(&root, "naoisis/Test/idle-v0", [&ranges, &ranges], json!({}), false);
        assert_eq!(again.unwrap_err().kind(), io::ErrorKind::AlreadyExists);
        let episode = EpisodeSteps {
            observations: &[0.1, 0.2, 0.3, 0.4, 0.5, 0.6],
            actions: &[0.7, 0.8],
            rewards: &[0.0, 1.0],
            is_terminated: true,
            is_truncated: false,
            seed: 7,
            agent: "blue1",
        };
        dataset.add(&episode).unwrap();
        assert!(dataset.add(&EpisodeSteps { actions: &[0.7], ..episode }).is_err());
        assert_eq!(dataset.written(), [1, 2]);
        let folder = dataset.folder().to_owned();
        dataset.finish().unwrap();
        let metadata: Value = serde_json::from_slice(&fs::read(folder.join("metadata.json")).unwrap()).unwrap();
        assert_eq!(
            (&metadata["total_episodes"], &metadata["total_steps"], &metadata["author"]),
            (&json!(1), &json!(2), &json!("us"))
        );
        let space: Value = serde_json::from_str(metadata["observation_space"].as_str().unwrap()).unwrap();
        assert_eq!((&space["shape"], &space["high"]), (&json!([2]), &json!([1.0, 2.0])));
        let table = SerializedFileReader::new(File::open(folder.join("0/part-0.parquet")).unwrap()).unwrap();
        let rows: Vec<String> =
            table.get_row_iter(None).unwrap().map(|row| row.unwrap().to_string().replace("0E0", "0.0")).collect();
        let expected = [
            "{observations: [0.1, 0.2], actions: [0.7], rewards: 0.0, terminations: false, truncations: false}",
            "{observations: [0.3, 0.4], actions: [0.8], rewards: 1.0, terminations: true, truncations: false}",
            "{observations: [0.5, 0.6], actions: [0.0], rewards: 0.0, terminations: false, truncations: false}",
        ];
        assert_eq!(rows, expected);
        fs::remove_dir_all(root).unwrap();
    }
}
