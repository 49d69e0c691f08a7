//! Fits a model's vision to image vision, so that geometric vision has the same errors and detection rates.

use super::sightings::{Detection, detection_curve, detection_paths, focal_length};
use super::{Calibration, groups, jackknife_positive};
use naoisis_core::statistics::{Estimate, median, share};
use naoisis_sensing::sensing::camera::CameraSettings;
use naoisis_sensing::sensing::vision::image::accuracy::{Accuracy, ClassAccuracy};

/// Least number of directions from which a spread is computed.
const FOR_A_SPREAD: usize = 20;
/// Half distance of a class whose detection rate does not fall off, as a multiple of the greatest tested distance. At the tested distance,
/// 1 in 700 is then missed.
const BEYOND: f64 = 3.0;
const USUAL_EXPONENT: f64 = 6.0;

/// Fits the figures of a model's vision to the detections of image vision in random scenes: for each class, the error
/// of its pixel, the detection rate over distance, and the rate of false positives.
///
/// Images are rendered with the true direction of the camera. Errors of joints and of the rocking body stay as in the
/// model, except for errors that the model draws for each image, because the pixel errors contain these already.
pub fn calibrate_by_images(accuracy: &Accuracy, cameras: &CameraSettings) -> Calibration {
    let mut calibration = Calibration::default();
    let into = &mut calibration;
    let classes: [(&str, &ClassAccuracy, bool); 7] = [
        ("ball", &accuracy.ball, true),
        ("goal_posts", &accuracy.goal_posts, true),
        ("robots", &accuracy.robots, true),
        ("lines", &accuracy.lines, false),
        ("junctions", &accuracy.junctions, false),
        ("penalty_crosses", &accuracy.penalty_crosses, false),
        ("centre_circle", &accuracy.centre_circle, false),
    ];
    for (class, seen, is_taken_for) in classes {
        let path = |name: &str| format!("vision.noise.{class}.{name}");
        // A line is compared at its point nearest to the robot, which has no direction of its own.
        if class != "lines" {
            let offs: Vec<f64> =
                seen.sightings.iter().filter_map(|sighting| Some(f64::from(sighting.bearing_error()?))).collect();
            let estimate = if offs.len() < FOR_A_SPREAD {
                None
            } else {
                jackknife_positive(&groups(&offs, |_| 0), |offs| spread(offs).map(|sd| sd * focal_length(cameras)))
            };
            let basis = format!("{} found in images", offs.len());
            into.add(&path("pixel_sd"), estimate, &basis, &format!("{}; {FOR_A_SPREAD} are needed", basis));
        }
        let in_view = seen.sightings.iter().filter(|sighting| sighting.is_in_view);
        let rows: Vec<Detection> = in_view
            .map(|sighting| Detection {
                robot: 0,
                distance_m: f64::from(sighting.distance_m()),
                is_seen: sighting.seen.is_some(),
            })
            .collect();
        detection(&rows, class, into);
        if is_taken_for {
            // There is only one ball: if it is seen, no other object is mistaken for it.
            let found = seen.sightings.iter().filter(|sighting| class == "ball" && sighting.seen.is_some()).count();
            let looks = accuracy.looks.saturating_sub(found);
            let estimate = share(seen.false_detections.min(looks), looks);
            let basis = format!("{} in {looks} looks at images", seen.false_detections);
            into.add(&path("false_positive_probability"), estimate, &basis, "no looks");
        }
    }
    // These errors are already part of the image errors above.
    let none = Some(Estimate::exactly(0.0));
    for path in ["head_angle_sd_deg", "false_balls.per_minute", "false_robots.per_minute"] {
        into.add(&format!("vision.noise.{path}"), none, "counted in the images' own errors", "");
    }
    calibration
}

/// Fits misses and fall-off of a class. If the class is hardly ever missed, or there is too little data to find the start of the fall-off,
/// the result does not fall off within the tested distances: the model's own fall-off would make images look worse than they are.
fn detection(rows: &[Detection], class: &str, into: &mut Calibration) {
    let paths = detection_paths(class);
    let seen = rows.iter().filter(|row| row.is_seen).count();
    let basis = format!("{seen} found in images of {} in view", rows.len());
    if let Some(estimates) = detection_curve(rows) {
        for (path, estimate) in paths.iter().zip(estimates) {
            into.add(path, Some(estimate), &basis, "");
        }
        return;
    }
    if rows.len() < FOR_A_SPREAD {
        into.lacking.push(format!("vision.noise.{class}: {basis}; {FOR_A_SPREAD} are needed"));
        return;
    }
    let farthest_m = rows.iter().map(|row| row.distance_m).fold(0.0, f64::max);
    let beyond = Estimate::exactly((BEYOND * farthest_m).ceil());
    let estimates = [share(rows.len() - seen, rows.len()), Some(beyond), Some(Estimate::exactly(USUAL_EXPONENT))];
    let basis = format!("{basis}, as far as {farthest_m:.1} m");
    for (path, estimate) in paths.iter().zip(estimates) {
        into.add(path, estimate, &basis, "");
    }
}

/// Returns a robust standard deviation of errors with outliers: 1.4826 times the median of their absolute values.
fn spread(errors: &[f64]) -> Option<f64> {
    median(errors.iter().map(|error| error.abs()).collect()).map(|size| 1.4826 * size)
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::random::RandomStream;
    use naoisis_sensing::sensing::vision::image::accuracy::{Conditions, measure};
    use naoisis_sensing::sensing::vision::{ClassNoise, Falloff, VisionNoise, VisionSource};

    #[test]
    fn errors_that_are_known_come_back_within_their_intervals() {
        let falloff = Falloff { half_distance_m: 2.5, exponent: 5.0 };
        let ball = ClassNoise {
            pixel_sd: 4.0,
            miss_probability: 0.15,
            false_positive_probability: 0.1,
            max_distance_m: None,
            falloff: Some(falloff),
        };
        let mut conditions = Conditions::default();
        conditions.vision.source = VisionSource::Geometric;
        conditions.vision.noise = VisionNoise { ball, ..VisionNoise::none() };
        let accuracy = measure(200, &conditions, &mut RandomStream::for_match(16, "known errors"));
        let calibration = calibrate_by_images(&accuracy, &conditions.cameras);
        // Each with 95 %: of ten seeds, nine had all three of the curve.
        for (name, real) in [
            ("pixel_sd", 4.0),
            ("miss_probability", 0.15),
            ("falloff.half_distance_m", 2.5),
            ("falloff.exponent", 5.0),
            ("false_positive_probability", 0.1),
        ] {
            let found = calibration.figure(&format!("vision.noise.ball.{name}")).unwrap().estimate;
            assert!((found.low..=found.high).contains(&real), "{name}: {found:?}");
            assert!(found.margin() < real, "{name}: {found:?} says little");
        }
        let posts = |name: &str| calibration.figure(&format!("vision.noise.goal_posts.{name}")).unwrap().estimate.value;
        assert_eq!((posts("false_positive_probability"), posts("miss_probability")), (0.0, 0.0));
        assert!(posts("falloff.half_distance_m") > 10.0, "what is always found does not fall off");
    }
}
