//! The lasting error between the true and the measured camera directions.
//!
//! A robot computes the pose of its cameras from its joint angles and the assumption that its body is upright. But it rocks as it walks,
//! its joints have play, and no robot is calibrated exactly: see [`GazeNoise`]. The drift is a Gauss-Markov process of first order, with a
//! correlation time of about a step, and does not depend on the duration of a cycle. The geometric vision and the rendered images both
//! use the true directions.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::VisionSettings;
use super::noise::{GazeDecay, GazeNoise};
use crate::sensing::scene::SensesNothing;
use naoisis_core::cycle::CycleClock;
use naoisis_core::knowledge::Knowledge;
use naoisis_core::random::{RandomStream, RandomStreams};
use naoisis_core::robot::head::HeadAngles;
use naoisis_core::robot::motion::ExecutedStep;

/// The error of a robot's camera directions.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Truth)]
pub struct GazeError {
    /// The bias, yaw and pitch, in standard deviations. Drawn on first use.
    bias: Option<Vec2>,
    /// The drift, yaw and pitch, radians. Drawn on first use.
    drift: Option<Vec2>,
    /// The sum of both in this cycle, yaw and pitch, radians.
    error: Vec2,
}

impl GazeError {
    /// The true head angles, from the measured ones.
    pub fn actual(&self, measured: HeadAngles) -> HeadAngles {
        if self.error == Vec2::ZERO {
            return measured;
        }
        HeadAngles { yaw: measured.yaw + self.error.x, pitch: measured.pitch + self.error.y }
    }

    /// The drift of the directions, yaw and pitch, radians, by which the body rocks.
    pub(crate) fn drift(&self) -> Vec2 {
        self.drift.unwrap_or_default()
    }

    /// Advances the error by a cycle, after which the share `decay` of the drift is left.
    fn advance(&mut self, noise: &GazeNoise, is_walking: bool, decay: f32, stream: &mut RandomStream) {
        let bias = if noise.bias_sd == 0.0 {
            Vec2::ZERO
        } else {
            noise.bias_sd * *self.bias.get_or_insert_with(|| draw(1.0, stream))
        };
        let sd = if is_walking { noise.walking_sd } else { noise.standing_sd };
        let drift = match self.drift {
            Some(drift) => decay * drift + draw(sd * (1.0 - decay * decay).sqrt(), stream),
            None => draw(sd, stream),
        };
        // A robot that never had a drift stores none.
        self.drift = self.drift.map(|_| drift).or((sd > 0.0).then_some(drift));
        self.error = bias + drift;
    }
}

/// Advances the gaze errors of all robots.
pub(super) fn move_cameras(
    clock: Res<CycleClock>,
    mut decay: Local<GazeDecay>,
    mut robots: Query<(&VisionSettings, &ExecutedStep, &mut GazeError, &mut RandomStreams), Without<SensesNothing>>,
) {
    for (settings, step, mut gaze, mut streams) in &mut robots {
        let noise = &settings.noise.gaze;
        if *noise == GazeNoise::default() {
            gaze.set_if_neq(GazeError { error: Vec2::ZERO, ..*gaze });
        } else {
            gaze.advance(noise, !step.0.is_null(), decay.after(clock.period(), noise), &mut streams.gaze);
        }
    }
}

fn draw(sd: f32, stream: &mut RandomStream) -> Vec2 {
    Vec2::new(stream.gaussian(sd), stream.gaussian(sd))
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::geometry::to_radians;

    const NOISE: GazeNoise = GazeNoise { bias_sd: 0.0, standing_sd: 0.01, walking_sd: 0.03, correlation_s: 0.4 };

    fn after(period: f32, noise: &GazeNoise) -> f32 {
        GazeDecay::default().after(period, noise)
    }

    /// The errors in this many cycles.
    fn errors(noise: GazeNoise, is_walking: bool, period: f32, cycles: usize) -> Vec<Vec2> {
        let mut stream = RandomStream::for_match(4, "gaze test");
        let mut gaze = GazeError::default();
        (0..cycles)
            .map(|_| {
                gaze.advance(&noise, is_walking, after(period, &noise), &mut stream);
                gaze.error
            })
            .collect()
    }

    fn mean_product(pairs: impl Iterator<Item = (Vec2, Vec2)>) -> f32 {
        let (mut sum, mut count) = (0.0, 0.0);
        for (one, other) in pairs {
            sum += f64::from(one.dot(other)) / 2.0;
            count += 1.0;
        }
        (sum / count) as f32
    }

    #[test]
    fn the_error_is_larger_while_walking_and_alike_for_its_time_whatever_the_cycles_are() {
        for cycles_per_second in [10, 30, 100] {
            let period = 1.0 / cycles_per_second as f32;
            for (is_walking, sd) in [(false, NOISE.standing_sd), (true, NOISE.walking_sd)] {
                let errors = errors(NOISE, is_walking, period, 2000 * cycles_per_second);
                // In 2000 s there are 2000 / 0.4 = 5000 independent squares, on two axes: the mean is known to
                // sqrt(2 / 10000) = 1.4 %, four of them 5.7 %.
                let variance = mean_product(errors.iter().map(|&error| (error, error)));
                assert!((variance / (sd * sd) - 1.0).abs() < 0.057, "{variance}");
                // 0.2 s later the correlation is exp(-0.5) = 0.607.
                let later = errors.iter().skip(cycles_per_second / 5);
                let correlation = mean_product(errors.iter().copied().zip(later.copied())) / variance;
                assert!((correlation - 0.607).abs() < 0.04, "{correlation}");
            }
        }
    }

    #[test]
    fn a_bias_stays_for_the_match_and_has_its_spread_over_robots() {
        let noise = GazeNoise { bias_sd: to_radians(1.0), ..GazeNoise::default() };
        let mut squares = 0.0;
        for match_seed in 0..2000 {
            let mut stream = RandomStream::for_match(match_seed, "gaze test");
            let mut gaze = GazeError::default();
            gaze.advance(&noise, false, after(0.1, &noise), &mut stream);
            let first = gaze.error;
            gaze.advance(&noise, true, after(0.1, &noise), &mut stream);
            assert_eq!(gaze.error, first);
            squares += first.length_squared() / 2.0 / 2000.0;
        }
        // Of 4000 squares the mean is known to sqrt(2 / 4000) = 2.2 %; four of them.
        assert!((squares / to_radians(1.0).powi(2) - 1.0).abs() < 0.09, "{squares}");
    }

    #[test]
    fn an_error_that_is_switched_off_is_gone() {
        let mut stream = RandomStream::for_match(4, "gaze test");
        let mut gaze = GazeError::default();
        gaze.advance(&NOISE, true, after(0.1, &NOISE), &mut stream);
        assert_ne!(gaze.actual(HeadAngles::default()), HeadAngles::default());
        gaze.advance(&GazeNoise::default(), true, 0.0, &mut stream);
        assert_eq!(gaze.actual(HeadAngles::default()), HeadAngles::default());
    }
}
