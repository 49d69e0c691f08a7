//! The sonars compared with hand-computed positions of robots and posts.

use super::*;
use crate::sensing::testing::{sense, sensing_app, set, spawn_ball, spawn_post, spawn_robot};
use approx::assert_abs_diff_eq;
use naoisis_core::geometry::{to_radians, unit};
use naoisis_core::team::Team;

/// The reading of a robot at the centre mark that faces +x, of a post at this distance and bearing.
fn reading_of_post(distance: f32, bearing_deg: f32) -> SonarReading {
    let mut app = sensing_app();
    let robot = spawn_robot(&mut app, Team::Blue, 1, [0.0, 0.0, 0.0], [0.0, 0.0]);
    let place = distance * unit(to_radians(bearing_deg));
    spawn_post(&mut app, place.x, place.y, None);
    sense(&mut app, robot)
}

#[track_caller]
fn assert_reading(reading: SonarReading, left: Option<f32>, right: Option<f32>) {
    for (measured, expected) in [(reading.left, left), (reading.right, right)] {
        match (measured, expected) {
            (Some(measured), Some(expected)) => assert_abs_diff_eq!(measured, expected, epsilon = 1e-5),
            _ => assert_eq!(measured, expected),
        }
    }
}

#[test]
fn each_sonar_hears_its_own_side() {
    assert_reading(reading_of_post(0.45, 19.48), Some(0.40), None);
    assert_reading(reading_of_post(0.45, -19.48), None, Some(0.40));
    // The sectors begin at 19.48° - 18° = 1.48° to either side. A post of 5 cm radius straight ahead at 0.45 m reaches
    // into both: along an edge 0.45 cos 1.48° - sqrt(0.05² - (0.45 sin 1.48°)²) = 0.449850 - 0.048627 = 0.401223.
    assert_reading(reading_of_post(0.45, 0.0), Some(0.401_223), Some(0.401_223));
    assert_reading(reading_of_post(0.45, 180.0), None, None);
    assert_reading(reading_of_post(0.45, 90.0), None, None);
}

#[test]
fn the_sector_ends_where_the_specification_says() {
    // Outer edge at 19.48° + 18° = 37.48°. A post whose centre is inside is as far as its near side, up to
    // asin(0.05 / 0.45) = 6.379° outside it is clipped by the edge, beyond it is not heard.
    assert_reading(reading_of_post(0.45, 37.4), Some(0.40), None);
    assert!(reading_of_post(0.45, 37.48 + 6.3).left.is_some_and(|distance| distance > 0.43));
    assert_reading(reading_of_post(0.45, 37.48 + 6.45), None, None);
    assert_reading(reading_of_post(0.45, -37.4), None, Some(0.40));
    assert_reading(reading_of_post(0.45, -37.48 - 6.45), None, None);
}

#[test]
fn the_range_includes_its_ends() {
    // The near side of a post of 5 cm radius is 5 cm nearer than its centre.
    assert_reading(reading_of_post(0.75 + 0.05, 19.48), Some(0.75), None);
    assert_reading(reading_of_post(0.751 + 0.05, 19.48), None, None);
    assert_reading(reading_of_post(0.15 + 0.05, 19.48), Some(0.15), None);
    assert_reading(reading_of_post(0.149 + 0.05, 19.48), None, None);
}

#[test]
fn a_torso_is_heard_by_its_nearest_point_and_legs_and_ball_are_not() {
    let mut app = sensing_app();
    let robot = spawn_robot(&mut app, Team::Blue, 1, [0.0, 0.0, 0.0], [0.0, 0.0]);
    // The other robot faces this one: its chest is at x = 0.5 - 0.05 = 0.45 from y = -0.15 to 0.15. In either sector the nearest point of
    // the chest is at its inner edge: 0.45 / cos 1.48° = 0.450150.
    let other = spawn_robot(&mut app, Team::Blue, 2, [0.5, 0.0, 180.0], [0.0, 0.0]);
    assert_reading(sense(&mut app, robot), Some(0.450_150), Some(0.450_150));
    // The other robot shows its side: facing +y, the arm is at x = 0.5 - 0.15 = 0.35, from y = -0.03 to 0.05.
    set(&mut app, other, Pose::new(0.5, 0.0, core::f32::consts::FRAC_PI_2));
    assert_reading(sense(&mut app, robot), Some(0.350_117), Some(0.350_117));
    // Just to the left of x = 0.5, y = 0.3 its chest is at y = 0.15..0.45: the corner (0.45, 0.15) is the nearest point.
    set(&mut app, other, Pose::new(0.5, 0.3, core::f32::consts::PI));
    assert_reading(sense(&mut app, robot), Some(Vec2::new(0.45, 0.15).length()), None);
    // Far away: 0.8 m, with the ball in between, and its feet (at x = 0.8 - 0.11) within the range.
    spawn_ball(&mut app, 0.4, 0.1);
    set(&mut app, other, Pose::new(0.81, 0.0, core::f32::consts::PI));
    assert_reading(sense(&mut app, robot), None, None);
    // Sonars at the height of the legs detect them.
    set(&mut app, robot, SonarSettings { height_m: 0.2, noise: SonarNoise::None, ..default() });
    assert_reading(sense(&mut app, robot), Some(0.700_234), Some(0.700_234));
}

#[test]
fn the_nearest_of_two_counts_and_a_robot_does_not_hear_itself() {
    let mut app = sensing_app();
    let robot = spawn_robot(&mut app, Team::Pink, 1, [1.0, 1.0, 0.0], [0.0, 0.0]);
    assert_reading(sense(&mut app, robot), None, None);
    let heading = unit(to_radians(25.0));
    for distance in [0.7, 0.45] {
        spawn_post(&mut app, 1.0 + distance * heading.x, 1.0 + distance * heading.y, None);
    }
    assert_reading(sense(&mut app, robot), Some(0.40), None);
    // An object nearer than the minimum gives no reading, and hides the others.
    spawn_post(&mut app, 1.0 + 0.19 * heading.x, 1.0 + 0.19 * heading.y, None);
    assert_reading(sense(&mut app, robot), None, None);
}

#[test]
fn the_sonars_turn_with_the_body_and_not_with_the_head() {
    let mut app = sensing_app();
    let robot = spawn_robot(&mut app, Team::Blue, 1, [0.0, 0.0, 0.0], [90.0, 0.0]);
    // At 0.45 m and bearing 90° + 19.48°, for a robot that faces +y.
    let place = 0.45 * unit(to_radians(109.48));
    spawn_post(&mut app, place.x, place.y, None);
    assert_reading(sense(&mut app, robot), None, None);
    set(&mut app, robot, Pose::new(0.0, 0.0, core::f32::consts::FRAC_PI_2));
    assert_reading(sense(&mut app, robot), Some(0.40), None);
}

#[test]
fn a_low_post_is_not_heard() {
    let mut app = sensing_app();
    let robot = spawn_robot(&mut app, Team::Blue, 1, [0.0, 0.0, 0.0], [0.0, 0.0]);
    let post = spawn_post(&mut app, 0.42, 0.15, None);
    set(&mut app, post, naoisis_core::pitch::Post { radius: 0.05, height: 0.39, colour: None });
    assert_reading(sense(&mut app, robot), None, None);
}

#[test]
fn truth_knows_no_range_and_no_noise() {
    let mut app = sensing_app();
    let robot = spawn_robot(&mut app, Team::Blue, 1, [0.0, 0.0, 0.0], [0.0, 0.0]);
    let place = 2.05 * unit(to_radians(19.48));
    spawn_post(&mut app, place.x, place.y, None);
    let settings = SonarSettings { source: SonarSource::Truth, miss_probability: 1.0, ..default() };
    set(&mut app, robot, settings);
    assert_reading(sense(&mut app, robot), Some(2.0), None);
}

/// Many readings of a distance of 0.4 m with this noise.
fn readings(settings: SonarSettings, count: usize) -> Vec<Option<f32>> {
    let mut stream = RandomStream::for_match(5, "sonar test");
    (0..count).map(|_| measure(&settings, [Some(0.4), None], &mut stream).left).collect()
}

fn mean_and_deviation(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let count = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / count;
    (mean, (values.map(|value| (value - mean).powi(2)).sum::<f64>() / count).sqrt())
}

#[test]
fn noise_has_the_spread_that_was_asked_for() {
    let count = 20_000;
    // Standard errors: of the mean sd / sqrt(20000) = 0.0071 sd, of the deviation of normal draws 0.005 sd (less for
    // uniform ones). Four of them: 99.99 % confidence.
    let half_width_m = 0.05;
    for (noise, sd) in [
        (SonarNoise::Gaussian { sd_m: 0.02 }, 0.02),
        // A uniform distribution of half width w has the deviation w / sqrt(3).
        (SonarNoise::Uniform { half_width_m }, f64::from(half_width_m) / 3f64.sqrt()),
    ] {
        let measured = readings(SonarSettings { noise, ..default() }, count);
        let (mean, deviation) = mean_and_deviation(measured.iter().map(|reading| f64::from(reading.unwrap())));
        assert!((mean - 0.4).abs() < 4.0 * 0.0071 * sd, "{mean}");
        assert!((deviation - sd).abs() < 4.0 * 0.005 * sd, "{deviation}");
    }
    assert_eq!(readings(SonarSettings { noise: SonarNoise::None, ..default() }, 1), [Some(0.4)]);
}

#[test]
fn outliers_are_anywhere_in_the_range() {
    let noise = SonarNoise::Outliers { sd_m: 0.0, probability: 0.1 };
    let measured = readings(SonarSettings { noise, ..default() }, 10_000);
    let outliers: Vec<f64> =
        measured.iter().flatten().filter(|&&reading| reading != 0.4).map(|&reading| f64::from(reading)).collect();
    // Binomial: 1000 ± sqrt(10000 * 0.1 * 0.9) = 30; four of them: 99.99 %.
    assert!((outliers.len() as f64 - 1000.0).abs() < 120.0);
    assert!(outliers.iter().all(|reading| (0.15..=0.75).contains(reading)));
    // Uniform over 0.15..0.75: mean 0.45, deviation 0.6 / sqrt(12) = 0.1732, standard error 0.0055.
    let (mean, deviation) = mean_and_deviation(outliers.iter().copied());
    assert!((mean - 0.45).abs() < 4.0 * 0.0055 && (deviation - 0.1732).abs() < 0.01);
}

#[test]
fn echoes_are_missed_as_often_as_asked_for() {
    let count = 10_000;
    for (miss_probability, least, most) in [(0.0, 0, 0), (0.3, 2816, 3184), (1.0, count, count)] {
        // Binomial: 3000 ± sqrt(10000 * 0.3 * 0.7) = 46; four of them: 99.99 %.
        let measured = readings(SonarSettings { miss_probability, ..default() }, count);
        let missed = measured.iter().filter(|reading| reading.is_none()).count();
        assert!((least..=most).contains(&missed), "{missed} missed");
    }
}

#[test]
fn a_reading_stays_until_the_next_ping_however_long_cycles_are() {
    let noise = SonarNoise::Gaussian { sd_m: 0.01 };
    for (cycles_per_second, pings_per_second) in [(30, 10), (83, 10), (5, 5)] {
        let mut app = sensing_app();
        app.insert_resource(CycleClock { period_s: 1.0 / f64::from(cycles_per_second), ..default() });
        let robot = spawn_robot(&mut app, Team::Blue, 1, [0.0, 0.0, 0.0], [0.0, 0.0]);
        set(&mut app, robot, SonarSettings { noise, rate_hz: Some(10.0), ..default() });
        spawn_post(&mut app, 0.42, 0.15, None);
        let readings: Vec<SonarReading> =
            (0..20 * cycles_per_second).map(|_| sense::<SonarReading>(&mut app, robot)).collect();
        let changes = readings.windows(2).filter(|pair| pair[0] != pair[1]).count() as i32;
        assert!((changes - 20 * pings_per_second).abs() <= 2, "{changes}");
        assert!(readings.last().unwrap().left.is_some());
    }
}

#[test]
fn robots_that_face_each_other_hear_echoes_of_nothing() {
    let settings = SonarSettings { noise: SonarNoise::None, crosstalk_probability: 0.2, ..default() };
    let share = |x: f32, y: f32, heading_deg: f32, others: SonarSettings| {
        let mut app = sensing_app();
        let robot = spawn_robot(&mut app, Team::Blue, 1, [0.0, 0.0, 0.0], [0.0, 0.0]);
        let other = spawn_robot(&mut app, Team::Pink, 1, [x, y, heading_deg], [0.0, 0.0]);
        set(&mut app, robot, settings);
        set(&mut app, other, others);
        let readings: Vec<SonarReading> = (0..3000).map(|_| sense::<SonarReading>(&mut app, robot)).collect();
        let heard = |ear: fn(&SonarReading) -> Option<f32>| readings.iter().filter_map(ear).collect::<Vec<_>>();
        [heard(|reading| reading.left), heard(|reading| reading.right)]
    };
    // The other robot is in the left sector only, and looks 7° past this one, which is in one of its sectors; 1.2 m is too far for an echo.
    // Binomial: 600 ± 22, four of them.
    let [left, right] = share(1.15, 0.35, 190.0, settings);
    assert!(left.len().abs_diff(600) < 88 && right.is_empty(), "{}", left.len());
    assert!(left.iter().all(|distance| (0.15..=0.75).contains(distance)));
    assert!(left.iter().any(|distance| *distance < 0.25) && left.iter().any(|distance| *distance > 0.65));
    // No crosstalk from a robot that looks away, is further away than twice the range, or has no working sonars.
    for [left, right] in [
        share(1.15, 0.35, 10.0, settings),
        share(1.5, 0.45, 190.0, settings),
        share(1.15, 0.35, 190.0, SonarSettings { source: SonarSource::Truth, ..settings }),
    ] {
        assert!(left.is_empty() && right.is_empty());
    }
    // An echo that is nearer counts.
    let [left, _] = share(0.5, 0.17, 190.0, settings);
    assert!(left.len() == 3000 && left.iter().all(|distance| *distance < 0.5));
}

#[test]
fn noise_stays_within_the_range() {
    let noise = SonarNoise::Gaussian { sd_m: 1.0 };
    let measured = readings(SonarSettings { noise, ..default() }, 1000);
    assert!(measured.iter().flatten().all(|reading| (0.15..=0.75).contains(reading)));
    assert!(measured.contains(&Some(0.15)) && measured.contains(&Some(0.75)));
}

#[test]
fn settings_read_as_documented() {
    let read = |json: &str| serde_json::from_str::<SonarSettings>(json);
    let settings = read(r#"{ "max_m": 1.0, "noise": { "uniform": { "half_width_m": 0.01 } } }"#).unwrap();
    assert_eq!(settings.noise, SonarNoise::Uniform { half_width_m: 0.01 });
    assert_eq!(settings.min_m, 0.15);
    assert_eq!(read(r#"{ "noise": "none" }"#).unwrap().noise, SonarNoise::None);
    assert_eq!(read(r#"{ "noise": "default" }"#).unwrap(), SonarSettings::default());
    assert!(read(r#"{ "noise": { "gaussian": { "sd": 1 } } }"#).is_err());
    let written = serde_json::to_string(&SonarSettings::default()).unwrap();
    assert_eq!(read(&written).unwrap(), SonarSettings::default());
}
