//! Delays readings by the [`Latency`] of their robot: recognised objects, images and sonars.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

use super::camera::CameraImages;
use super::scene::SensingSystems;
use super::sonar::{SonarReading, SonarSettings, SonarSource};
use super::vision::Percepts;
use naoisis_core::cycle::{Cycle, CycleClock};
use naoisis_core::knowledge::Knowledge;
use naoisis_core::robot::latency::{Latency, delay};

/// Delays readings in [`SensingSystems::Late`].
pub struct ReadingLatencyPlugin;

impl Plugin for ReadingLatencyPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<LatencyQueues>().register_required_components::<Latency, LatencyQueues>();
        app.add_systems(Cycle, set_images_aside.after(SensingSystems::Scene).before(SensingSystems::Images))
            .add_systems(Cycle, delay_readings.in_set(SensingSystems::Late));
    }
}

/// The readings that have not arrived yet, the oldest first.
#[derive(Component, Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Truth)]
#[serde(default)]
pub struct LatencyQueues {
    percepts: VecDeque<Percepts>,
    images: VecDeque<CameraImages>,
    sonars: VecDeque<SonarReading>,
    /// The images that arrived last, while new ones are taken.
    aside: CameraImages,
}

impl LatencyQueues {
    fn are_empty(&self) -> bool {
        self.percepts.is_empty() && self.images.is_empty() && self.sonars.is_empty()
    }

    /// Whether there has never been an image, `images` included: the usual case.
    fn have_no_image(&self, images: &CameraImages) -> bool {
        images.are_unused() && self.aside.are_unused() && self.images.is_empty()
    }

    /// The images in the queues.
    pub fn images(&self) -> impl Iterator<Item = &CameraImages> {
        self.images.iter().chain([&self.aside])
    }
}

/// Puts delayed images that arrived last aside, so that new ones are not drawn over them.
fn set_images_aside(clock: Res<CycleClock>, mut robots: Query<(&Latency, &mut CameraImages, &mut LatencyQueues)>) {
    for (latency, mut images, mut queues) in &mut robots {
        if latency.image_s != 0.0 && !queues.have_no_image(&images) && clock.cycles_in(latency.image_s) > 0 {
            core::mem::swap(&mut *images, &mut queues.aside);
            images.clear();
            // The rendering clears this field for a robot that takes no images now.
            images.arrived = Some(clock.cycle);
        }
    }
}

fn delay_readings(
    clock: Res<CycleClock>,
    mut robots: Query<(
        &Latency,
        &mut Percepts,
        Option<&mut CameraImages>,
        Option<(&SonarSettings, &mut SonarReading)>,
        &mut LatencyQueues,
    )>,
) {
    for (latency, mut percepts, images, sonars, mut queues) in &mut robots {
        percepts.time_s = clock.start_time_s();
        if !latency.delays_readings() && queues.are_empty() {
            continue;
        }
        let [vision, image, sonar] =
            [latency.vision_s, latency.image_s, latency.sonar_s].map(|seconds| clock.cycles_in(seconds));
        if vision > 0 || !queues.percepts.is_empty() {
            delay(&mut *percepts, vision, &mut queues.percepts);
        }
        if let Some(mut images) = images {
            delay_images(image, clock.cycle, &mut images, &mut queues);
        }
        if let Some((settings, mut reading)) = sonars.filter(|(settings, _)| settings.fitted) {
            delay_sonars(sonar, clock.start_time_s(), settings, &mut reading, &mut queues.sonars);
        }
    }
}

/// Delays images by `cycles`, in the cycle `now`.
fn delay_images(cycles: u32, now: u64, images: &mut CameraImages, queues: &mut LatencyQueues) {
    if queues.have_no_image(images) {
        return;
    }
    let LatencyQueues { images: queue, aside, .. } = queues;
    if cycles == 0 {
        if !queue.is_empty() {
            queue.clear();
        }
        return;
    }
    if images.cycle == Some(now) {
        queue.push_back(core::mem::take(images));
    } else if images.arrived.is_none() {
        queue.clear();
        aside.clear();
    }
    core::mem::swap(images, aside);
    let has_arrived = |image: &CameraImages| image.cycle.is_some_and(|taken| taken + u64::from(cycles) <= now);
    while queue.front().is_some_and(has_arrived) {
        *aside = core::mem::replace(images, queue.pop_front().unwrap_or_default());
        images.arrived = Some(now);
    }
}

/// Delays sonar readings by `cycles`, at the time `now`, s.
fn delay_sonars(
    cycles: u32,
    now: f64,
    settings: &SonarSettings,
    reading: &mut SonarReading,
    queue: &mut VecDeque<SonarReading>,
) {
    if cycles > 0 || !queue.is_empty() {
        // Sonars without a rate ping in every cycle. Between two pings, the last reading in the queue is still the newest.
        let pings_always = settings.rate_hz.is_none() || settings.source == SonarSource::Truth;
        let time_s = reading.time_s.or(pings_always.then_some(now));
        let newest = queue.back().filter(|_| time_s != Some(now)).copied();
        *reading = newest.unwrap_or(SonarReading { time_s, ..*reading });
        delay(reading, cycles, queue);
    }
}
