//! Odometry of real robots: topics `/odometer_state` of MCAP files, as `ros2 bag record` writes them on a Booster.

use core::error::Error;
use mcap::records::Record;
use std::collections::HashMap;
use std::io::{self, Read};

use super::wrap_degrees;
use naoisis_record::record::mcap_records::McapRecords;

/// Topic of the odometry of a single robot. With several robots, each one's name follows: `/odometer_state/robot2`.
const TOPIC: &str = "/odometer_state";
/// Size limit of a record, bytes: a chunk with images.
const LONGEST_RECORD_BYTES: usize = 256 << 20;
/// Number of samples that are kept at most: three hours of ten robots at 50 Hz.
const MOST_SAMPLES: usize = 5_400_000;
/// Longest time between a walk's start or end and the nearest sample, s.
const LONGEST_GAP_S: f64 = 0.5;

/// A pose by odometry.
#[derive(Clone, Copy, PartialEq, Debug)]
struct Sample {
    /// Time since the first sample of the file, s.
    time_s: f64,
    /// Position, m, in the frame of the robot when its odometry was reset.
    place: [f64; 2],
    /// Heading in that frame, degrees.
    heading_deg: f64,
}

/// The poses of a robot by its odometry, in order of time.
#[derive(Clone, PartialEq, Debug)]
pub struct OdometryTrack {
    /// The name of the robot: what follows the topic, or the name of the file.
    pub robot: String,
    samples: Vec<Sample>,
}

impl OdometryTrack {
    /// Reads the tracks of all robots in an MCAP file. `name` is the name of a robot whose topic has none.
    ///
    /// # Errors
    /// If the file is damaged, or has no odometry that can be read.
    pub fn read_all(name: &str, file: impl Read) -> io::Result<Vec<Self>> {
        let mut records = McapRecords::new(file, LONGEST_RECORD_BYTES);
        let mut channels = HashMap::new();
        let mut topics = Vec::new();
        let mut tracks: Vec<(Self, u64)> = Vec::new();
        let mut samples = 0;
        let end = records.find(|record| {
            match record {
                Record::Channel(channel) => {
                    let robot = channel.topic.strip_prefix(TOPIC).map(|of| of.trim_start_matches('/'));
                    let Some(robot) = robot else {
                        // The summary at the end of a file lists the channels again.
                        if !topics.contains(&channel.topic) {
                            topics.push(channel.topic);
                        }
                        return Ok(None);
                    };
                    if channel.message_encoding != "cdr" {
                        return Err(unknown_encoding(&channel.topic, &channel.message_encoding));
                    }
                    let robot = if robot.is_empty() { name } else { robot };
                    let track = tracks.iter().position(|(track, _)| track.robot == robot).unwrap_or_else(|| {
                        tracks.push((Self { robot: robot.to_owned(), samples: Vec::new() }, 0));
                        tracks.len() - 1
                    });
                    channels.insert(channel.id, track);
                }
                Record::Message { header, data } => {
                    let Some(track) = channels.get(&header.channel_id) else { return Ok(None) };
                    let Some([x, y, theta]) = three_floats(&data) else {
                        return Err("a message of the odometry is not three 32-bit numbers x, y, theta".into());
                    };
                    samples += 1;
                    if samples > MOST_SAMPLES {
                        return Err(format!("there are more than {MOST_SAMPLES} messages of odometry").into());
                    }
                    let (track, first_ns) = &mut tracks[*track];
                    if track.samples.is_empty() {
                        *first_ns = header.log_time;
                    }
                    let time_s = header.log_time.saturating_sub(*first_ns) as f64 / 1e9;
                    let heading_deg = theta.to_degrees();
                    track.samples.push(Sample { time_s, place: [x, y], heading_deg });
                }
                _ => {}
            }
            Ok(None::<()>)
        });
        // A recording that was stopped by force is used up to there.
        if let Err(error) = end
            && error.kind() != io::ErrorKind::UnexpectedEof
        {
            return Err(error);
        }
        tracks.retain(|(track, _)| !track.samples.is_empty());
        if tracks.is_empty() {
            let words = if topics.is_empty() { "no topics".to_owned() } else { topics.join(", ") };
            let message = format!("there are no messages on the topic `{TOPIC}`; the file has {words}");
            return Err(io::Error::new(io::ErrorKind::InvalidData, message));
        }
        Ok(tracks.into_iter().map(|(track, _)| track).collect())
    }

    /// Returns the displacement, m, and turn, degrees, from `start_s` to `end_s`, in the robot's frame at the start.
    ///
    /// # Errors
    /// If the track has no sample near one of the times.
    pub(super) fn motion(&self, start_s: f64, end_s: f64) -> Result<([f64; 2], f64), String> {
        let (start, end) = (self.at(start_s)?, self.at(end_s)?);
        let [x, y] = [end.place[0] - start.place[0], end.place[1] - start.place[1]];
        let (sin, cos) = libm::sincos(start.heading_deg.to_radians());
        let between = |sample: &&Sample| sample.time_s > start.time_s && sample.time_s <= end.time_s;
        // The turn is summed up, as headings jump by 360 degrees.
        let mut heading_deg = start.heading_deg;
        let mut turn_deg = 0.0;
        for sample in self.samples.iter().filter(between) {
            turn_deg += wrap_degrees(sample.heading_deg - heading_deg);
            heading_deg = sample.heading_deg;
        }
        Ok(([x * cos + y * sin, y * cos - x * sin], turn_deg))
    }

    /// Returns the sample nearest to a time.
    fn at(&self, time_s: f64) -> Result<Sample, String> {
        let distance = |sample: &&Sample| (sample.time_s - time_s).abs();
        let nearest = self.samples.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
        nearest.filter(|sample| distance(sample) <= LONGEST_GAP_S).copied().ok_or_else(|| {
            let last_s = self.samples.last().map_or(0.0, |sample| sample.time_s);
            format!("a time at which the odometry of `{}` was recorded, 0 to {last_s:.1} s", self.robot)
        })
    }
}

fn unknown_encoding(topic: &str, encoding: &str) -> Box<dyn Error + Send + Sync> {
    format!("the topic `{topic}` is encoded as `{encoding}`; expected `cdr`, as ROS 2 writes it").into()
}

/// Reads three 32-bit floating-point numbers encoded as CDR: a header of 4 bytes, which gives the byte order, and the numbers.
fn three_floats(data: &[u8]) -> Option<[f64; 3]> {
    let (header, data) = data.split_at_checked(4)?;
    let is_little = header[1] & 1 == 1;
    let (numbers, _) = data.as_chunks::<4>();
    let &[x, y, theta] = numbers.first_chunk::<3>()?;
    let number = |bytes| f64::from(if is_little { f32::from_le_bytes(bytes) } else { f32::from_be_bytes(bytes) });
    let numbers = [number(x), number(y), number(theta)];
    numbers.iter().all(|number| number.is_finite()).then_some(numbers)
}

#[cfg(test)]
mod tests {
    use super::*;
    use mcap::records::MessageHeader;
    use mcap::{WriteOptions, Writer};
    use std::io::Cursor;

    /// Returns an MCAP file with a message each 20 ms of a robot that walks 1 m/s along its heading and turns 90 deg/s.
    fn recording(topic: &str, encoding: &str, little: bool) -> Vec<u8> {
        let mut file = Cursor::new(Vec::new());
        let mut writer = Writer::with_options(&mut file, WriteOptions::new()).unwrap();
        let schema = writer
            .add_schema("booster_interface/msg/Odometer", "ros2msg", b"float32 x\nfloat32 y\nfloat32 theta")
            .unwrap();
        let images = writer.add_channel(0, "/camera/image", "cdr", &Default::default()).unwrap();
        let channel = writer.add_channel(schema, topic, encoding, &Default::default()).unwrap();
        for sample in 0..200_u32 {
            let log_time = 1_780_000_000_000_000_000 + u64::from(sample) * 20_000_000;
            let time_s = sample as f32 * 0.02;
            let theta = time_s * core::f32::consts::FRAC_PI_2;
            let (sin, cos) = libm::sincosf(theta);
            let pose = [sin * 2.0 / core::f32::consts::PI, (1.0 - cos) * 2.0 / core::f32::consts::PI];
            // Headings are between -pi and pi.
            let theta = libm::atan2f(sin, cos);
            let mut data = vec![0, u8::from(little), 0, 0];
            for number in [pose[0], pose[1], theta] {
                data.extend(if little { number.to_le_bytes() } else { number.to_be_bytes() });
            }
            let header = MessageHeader { channel_id: channel, sequence: sample, log_time, publish_time: log_time };
            writer.write_to_known_channel(&header, &data).unwrap();
            writer.write_to_known_channel(&MessageHeader { channel_id: images, ..header }, &[1; 100]).unwrap();
        }
        writer.finish().unwrap();
        drop(writer);
        file.into_inner()
    }

    #[test]
    fn the_odometry_of_a_recording_gives_displacements_in_the_frame_at_the_start() {
        for little in [true, false] {
            let file = recording("/odometer_state", "cdr", little);
            let tracks = OdometryTrack::read_all("anna", &*file).unwrap();
            assert_eq!((tracks.len(), tracks[0].robot.as_str()), (1, "anna"));
            // A quarter of a circle, wherever on the circle the walk begins, and more than half a turn.
            for start_s in [0.0, 1.0, 1.5] {
                let (place, turn_deg) = tracks[0].motion(start_s, start_s + 1.0).unwrap();
                let radius_m = 2.0 / core::f64::consts::PI;
                assert!((place[0] - radius_m).abs() < 1e-3 && (place[1] - radius_m).abs() < 1e-3, "{place:?}");
                assert!((turn_deg - 90.0).abs() < 1e-3);
            }
            assert!((tracks[0].motion(0.0, 3.0).unwrap().1 - 270.0).abs() < 1e-3);
            assert!(tracks[0].motion(0.0, 9.0).unwrap_err().contains("0 to 4.0 s"));
        }
    }

    #[test]
    fn robots_are_named_by_their_topics_and_a_cut_off_file_is_read_up_to_there() {
        let file = recording("/odometer_state/robot2", "cdr", true);
        for end in [file.len(), file.len() - 10] {
            let tracks = OdometryTrack::read_all("file", &file[..end]).unwrap();
            assert_eq!(tracks[0].robot, "robot2");
        }
    }

    #[test]
    fn files_without_odometry_say_what_they_have() {
        let error = |file: &[u8]| OdometryTrack::read_all("anna", file).unwrap_err().to_string();
        assert!(error(&recording("/other", "cdr", true)).contains("the file has /camera/image, /other"));
        assert!(error(&recording("/odometer_state", "json", true)).contains("encoded as `json`"));
        assert!(error(b"kind,robot\n").contains("MCAP"), "{}", error(b"kind,robot\n"));
    }
}
