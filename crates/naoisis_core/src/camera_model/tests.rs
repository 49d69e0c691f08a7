//! The camera model compared with the paper's table and trigonometry by hand.

use super::*;
use crate::geometry::to_radians;
use crate::robot::body::Body;
use approx::assert_abs_diff_eq;

/// The pinhole of a NAO's cameras: 320 x 240 pixels, 58° along the diagonal.
fn intrinsics() -> CameraIntrinsics {
    CameraIntrinsics::new(Vec2::new(320.0, 240.0), to_radians(58.0))
}

/// The view of a NAO's camera in a head at these angles.
pub(super) fn camera(side: CameraName, head: HeadAngles) -> CameraView {
    let mounts = CameraMounts::default();
    let mount = mounts.as_slice().iter().find(|mount| mount.name == side).unwrap();
    CameraView::new(intrinsics(), mount, Body::default().neck_m, head)
}

fn view(side: CameraName, yaw_deg: f32, pitch_deg: f32) -> CameraView {
    let head = HeadAngles { yaw: to_radians(yaw_deg), pitch: to_radians(pitch_deg) };
    camera(side, head)
}

#[track_caller]
fn assert_pixel(view: CameraView, point: [f32; 3], pixel: [f32; 2]) {
    let actual = view.project(point.into()).unwrap();
    assert_abs_diff_eq!(actual.x, pixel[0], epsilon = 0.02);
    assert_abs_diff_eq!(actual.y, pixel[1], epsilon = 0.02);
}

#[test]
fn the_focal_length_follows_from_the_diagonal() {
    // Half of the diagonal of 320 x 240 is 200 px; 200 / tan 29° = 360.81.
    let intrinsics = intrinsics();
    assert_abs_diff_eq!(intrinsics.focal.x, 360.81, epsilon = 0.005);
    assert_abs_diff_eq!(ops::cos(BOTTOM_TILT), BOTTOM_TILT_UNIT.x, epsilon = 1e-7);
    assert_abs_diff_eq!(ops::sin(BOTTOM_TILT), BOTTOM_TILT_UNIT.y, epsilon = 1e-7);
    assert_abs_diff_eq!(BOTTOM_TILT, to_radians(40.0), epsilon = 1e-7);
}

#[test]
fn a_level_top_camera_sees_what_is_ahead_in_the_middle() {
    let level = view(CameraName::TOP, 0.0, 0.0);
    assert_pixel(level, [2.0539, 0.0, 0.5372], [160.0, 120.0]);
    // 0.5 m to the left at 2 m: 360.81 * 0.25 = 90.20 px left of the centre.
    assert_pixel(level, [2.0539, 0.5, 0.5372], [160.0 - 90.20, 120.0]);
    // On the ground at 2 m: 360.81 * 0.5372 / 2 = 96.91 px below the centre.
    assert_pixel(level, [2.0539, 0.0, 0.0], [160.0, 120.0 + 96.91]);
    assert_eq!(level.project(Vec3::new(0.0, 0.0, 0.5)), None);
}

#[test]
fn turning_the_head_turns_the_lens_and_the_view() {
    // At 90° to the left, the lens is 5.39 cm to the left of the neck and looks along +y.
    let left = view(CameraName::TOP, 90.0, 0.0);
    assert_abs_diff_eq!(left.lens, Vec3::new(0.0, 0.0539, 0.5372), epsilon = 1e-6);
    // What is ahead of the robot is to the right in the image.
    assert_pixel(left, [0.5, 2.0539, 0.5372], [160.0 + 90.20, 120.0]);
    let right = view(CameraName::TOP, -120.0, 0.0);
    // Looks along (cos -120°, sin -120°) = (-0.5, -0.8660).
    assert_pixel(right, [-0.5 * 2.0539, -0.866_025 * 2.0539, 0.5372], [160.0, 120.0]);
}

#[test]
fn nodding_moves_the_lens_about_the_neck() {
    // Lens offset (0.0539, 0.0777) turned down by 30°: x = 0.0539 cos 30 + 0.0777 sin 30 = 0.08553,
    // z = 0.4595 - 0.0539 sin 30 + 0.0777 cos 30 = 0.49984.
    let down = view(CameraName::TOP, 0.0, 30.0);
    assert_abs_diff_eq!(down.lens, Vec3::new(0.085_53, 0.0, 0.499_84), epsilon = 1e-5);
    // The middle of the image looks at x = 0.08553 + 0.49984 / tan 30° = 0.95128.
    let ground = down.ground_point(down.intrinsics.centre).unwrap();
    assert_abs_diff_eq!(ground, Vec2::new(0.951_28, 0.0), epsilon = 1e-4);
    // With the head up by 35° no ground is in the image of the top camera: its lower edge looks 35° - 18.4° up.
    let up = view(CameraName::TOP, 0.0, -35.0);
    assert_eq!(up.ground_point(Vec2::new(160.0, 239.9)), None);
}

#[test]
fn the_bottom_camera_looks_40_degrees_further_down() {
    // x = 0.0488 + 0.4709 / tan 40° = 0.6100.
    let level = view(CameraName::BOTTOM, 0.0, 0.0);
    assert_abs_diff_eq!(level.ground_point(Vec2::new(160.0, 120.0)).unwrap().x, 0.6100, epsilon = 1e-4);
    assert_pixel(level, [0.6100, 0.0, 0.0], [160.0, 120.0]);
    // Head to the left by 40° and down by 10°: the lens is (0.0488 cos 10 + 0.0114 sin 10) = 0.05004 ahead of
    // the neck and 0.4595 - 0.0488 sin 10 + 0.0114 cos 10 = 0.46225 high; the centre looks 50° down:
    // 0.05004 + 0.46225 / tan 50° = 0.43791 along the yaw.
    let turned = view(CameraName::BOTTOM, 40.0, 10.0);
    let ground = turned.ground_point(turned.intrinsics.centre).unwrap();
    assert_abs_diff_eq!(ground, 0.437_91 * unit(to_radians(40.0)), epsilon = 1e-4);
}

#[test]
fn the_visible_stretch_of_floor_with_a_level_head() {
    // Half the vertical opening is atan(120 / 360.81) = 18.396°.
    // Top: 0.0539 + 0.5372 / tan 18.396° = 1.669 m to the horizon.
    let top = view(CameraName::TOP, 0.0, 0.0);
    assert_abs_diff_eq!(top.ground_point(Vec2::new(160.0, 240.0)).unwrap().x, 1.669, epsilon = 5e-4);
    assert_eq!(top.ground_point(Vec2::new(160.0, 120.0)), None);
    // Bottom: 0.0488 + 0.4709 / tan(40° + 18.396°) = 0.339 to 0.0488 + 0.4709 / tan(40° - 18.396°) = 1.238.
    let bottom = view(CameraName::BOTTOM, 0.0, 0.0);
    assert_abs_diff_eq!(bottom.ground_point(Vec2::new(160.0, 240.0)).unwrap().x, 0.339, epsilon = 5e-4);
    assert_abs_diff_eq!(bottom.ground_point(Vec2::new(160.0, 0.0)).unwrap().x, 1.238, epsilon = 5e-4);
}

#[test]
fn a_ball_at_the_feet_needs_a_nod_of_19_degrees() {
    // The paper's kicks need the ball at 10 cm or more. A point of the ground at 15 cm comes into view where the lower edge of the image,
    // 58.396° + pitch below the horizontal, meets it: at a pitch of 19.17°, as the lens is then at x = 0.0488 cos 19.17 + 0.0114 sin 19.17
    // = 0.04984 and z = 0.4595 - 0.0488 sin 19.17 + 0.0114 cos 19.17 = 0.45424, and tan(77.566°) = 4.5354 = 0.45424 / (0.15 - 0.04984).
    let ball = Vec3::new(0.15, 0.0, 0.0);
    assert_eq!(view(CameraName::BOTTOM, 0.0, 19.1).pixel_in_image(ball), None);
    assert!(view(CameraName::BOTTOM, 0.0, 19.25).pixel_in_image(ball).is_some());
}

#[test]
fn pixel_and_ray_are_inverse_in_any_head_pose() {
    for (side, yaw, pitch) in
        [(CameraName::TOP, 33.0, 17.0), (CameraName::BOTTOM, -75.0, -20.0), (CameraName::TOP, -120.0, 30.0)]
    {
        let view = view(side, yaw, pitch);
        for pixel in [Vec2::new(0.0, 0.0), Vec2::new(319.0, 100.0), Vec2::new(47.5, 239.5)] {
            let back = view.project(view.lens + 1.7 * view.ray(pixel)).unwrap();
            assert_abs_diff_eq!(back, pixel, epsilon = 1e-3);
            if let Some(ground) = view.ground_point(pixel) {
                assert_abs_diff_eq!(view.project(ground.extend(0.0)).unwrap(), pixel, epsilon = 0.02);
            }
        }
        // The axes are a right-handed orthonormal frame.
        assert_abs_diff_eq!(view.right.cross(view.down), view.forward, epsilon = 1e-6);
        assert_abs_diff_eq!(view.robot_from_camera().determinant(), 1.0, epsilon = 1e-6);
    }
}

#[test]
fn what_is_beside_the_view_is_not_in_the_image() {
    let mut sides = [0; 3];
    let mut seen_whole = 0;
    for (side, yaw, pitch) in
        [(CameraName::TOP, 0.0, 0.0), (CameraName::BOTTOM, 70.0, 30.0), (CameraName::TOP, -50.0, -35.0)]
    {
        let view = view(side, yaw, pitch);
        for index in 0..4000 {
            let place = unit(index as f32 * 0.7) * (index as f32 * 1e-3);
            let beside = view.side_of(place);
            sides[beside as usize] += 1;
            for height in [0.0, 0.3, 0.8] {
                let pixel = view.pixel_in_image(place.extend(height));
                assert!(pixel.is_none() || beside == ViewSide::Inside);
                let beneath = place.extend(height - 0.2);
                assert!(pixel.is_none() || view.may_see(beneath, 0.2));
                // If the whole ball is in the image, so is this point.
                assert!(pixel.is_some() || !view.surely_sees(beneath, 0.2));
                seen_whole += usize::from(view.surely_sees(beneath, 0.2));
                assert_eq!(pixel, view.project(place.extend(height)).filter(|&pixel| view.contains(pixel)));
            }
        }
    }
    // 48° ahead and 48° behind, of 360°, may be in view, and everything near the feet: the rest is certainly not.
    assert!(sides[0] > 3000 && sides[2] > 3000, "{sides:?}");
    assert!(seen_whole > 300, "{seen_whole}");
}

/// Calibrated cameras: their focal lengths differ, their principal points are not in the middle, and their lenses distort.
fn calibrated() -> Vec<CameraIntrinsics> {
    let size = Vec2::new(640.0, 480.0);
    let lenses = [([0.1, -0.2, 0.0], [0.001, 0.002]), ([-0.35, 0.12, -0.02], [0.0, -0.003]), ([0.0; 3], [0.0; 2])];
    let camera = |(radial, tangential)| {
        let lens = Distortion::new(radial, tangential);
        CameraIntrinsics::calibrated(size, Vec2::new(455.0, 461.0), Vec2::new(332.0, 231.0), lens)
    };
    lenses.map(camera).to_vec()
}

#[test]
fn a_calibrated_camera_projects_as_it_looks() {
    for intrinsics in calibrated() {
        let mount = CameraMount::new(CameraName::TOP, Vec3::new(0.05, 0.0, 0.9), to_radians(20.0));
        let view = CameraView::new(intrinsics, &mount, Vec3::Z * 0.8, HeadAngles { yaw: 0.6, pitch: 0.2 });
        for (u, v) in (0..=16).flat_map(|u| (0..=12).map(move |v| (u, v))) {
            let pixel = Vec2::new(40.0 * u as f32, 40.0 * v as f32);
            let back = view.project(view.lens + 1.7 * view.ray(pixel)).unwrap();
            assert_abs_diff_eq!(back, pixel, epsilon = 0.02);
            // A point in the image is not beside the view.
            if let Some(ground) = view.ground_point(pixel).filter(|ground| ground.length() < 10.0) {
                assert_eq!(view.side_of(ground), ViewSide::Inside);
                assert!(view.may_see(ground.extend(0.0), 1e-3));
            }
        }
        // Where a segment is visible, its points are in the image, and beyond they are not.
        let mut seen = 0;
        for index in 0..200 {
            let direction = unit(index as f32 * 0.7);
            let (start, end) = (2.0 * direction, Vec2::new(2.5, 1.0) - 3.0 * direction.perp());
            let (start, end) = (start.extend(0.0), end.extend(0.0));
            let Some(part) = view.visible_part(start, end) else { continue };
            seen += 1;
            let is_seen = |share: f32| view.pixel_in_image(start.lerp(end, share)).is_some();
            let width = part[1] - part[0];
            assert!((1..8).all(|share| is_seen(part[0] + width * share as f32 / 8.0)), "{part:?}");
            assert!(part[0] == 0.0 || !is_seen(part[0] - 0.002), "{part:?}");
            assert!(part[1] == 1.0 || !is_seen(part[1] + 0.002), "{part:?}");
        }
        assert!(seen > 20, "{seen}");
        let outline = view.seen_ground(6.0);
        let corner = view.ground_point(view.intrinsics.size).unwrap();
        assert!(outline.iter().any(|place| place.distance(corner) < 1e-3));
    }
}

#[test]
fn the_image_includes_its_left_and_upper_edges_only() {
    let view = view(CameraName::TOP, 0.0, 0.0);
    assert!(view.contains(Vec2::ZERO) && view.contains(Vec2::new(319.99, 239.99)));
    assert!(!view.contains(Vec2::new(320.0, 100.0)) && !view.contains(Vec2::new(100.0, -0.01)));
}

#[test]
fn a_segment_is_clipped_at_the_edges_of_the_image() {
    // A line across the view at x = 2.0539: 2 m ahead of the lens, visible to 160 / 360.81 * 2 = 0.88689 m on
    // either side. Of a segment from y = -2 to 2 that is (2 ± 0.88689) / 4.
    let top = view(CameraName::TOP, 0.0, 0.0);
    let part = top.visible_part(Vec3::new(2.0539, -2.0, 0.0), Vec3::new(2.0539, 2.0, 0.0)).unwrap();
    assert_abs_diff_eq!(part[0], (2.0 - 0.886_89) / 4.0, epsilon = 1e-4);
    assert_abs_diff_eq!(part[1], (2.0 + 0.886_89) / 4.0, epsilon = 1e-4);
    // Away from the robot along y = 0, from behind it to 5 m ahead: visible from 1.669 m on.
    let part = top.visible_part(Vec3::new(-5.0, 0.0, 0.0), Vec3::new(5.0, 0.0, 0.0)).unwrap();
    assert_abs_diff_eq!(-5.0 + 10.0 * part[0], 1.669, epsilon = 1e-3);
    assert_eq!(part[1], 1.0);
    // Behind the robot, or beside the view, nothing is visible.
    assert_eq!(top.visible_part(Vec3::new(-1.0, -1.0, 0.0), Vec3::new(-1.0, 1.0, 0.0)), None);
    assert_eq!(top.visible_part(Vec3::new(1.0, 3.0, 0.0), Vec3::new(3.0, 3.0, 0.0)), None);
}

#[test]
fn a_camera_that_looks_aside_sees_as_one_ahead_in_a_head_that_is_turned() {
    let mount = |pan_deg: f32| {
        // About the neck, so that only directions differ.
        let lens = Body::default().neck_m;
        CameraMount::new(CameraName::TOP, lens, to_radians(25.0)).panned(to_radians(pan_deg))
    };
    let intrinsics = CameraIntrinsics::new(Vec2::new(320.0, 240.0), 1.0);
    let view = |pan_deg, yaw_deg, pitch_deg| {
        let head = HeadAngles { yaw: to_radians(yaw_deg), pitch: to_radians(pitch_deg) };
        CameraView::new(intrinsics, &mount(pan_deg), Body::default().neck_m, head)
    };
    for (pan, yaw) in [(90.0, 0.0), (-35.0, 20.0), (180.0, -100.0)] {
        let (aside, turned) = (view(pan, yaw, 0.0), view(0.0, pan + yaw, 0.0));
        for (one, other) in
            [aside.forward, aside.right, aside.down].into_iter().zip([turned.forward, turned.right, turned.down])
        {
            assert_abs_diff_eq!(one, other, epsilon = 1e-6);
        }
    }
    // A head that nods by 30° rolls a camera that looks to its left: what is right in its image rises, sin 30° = 0.5.
    let rolled = view(90.0, 0.0, 30.0);
    assert_abs_diff_eq!(rolled.right, Vec3::new(0.866_025, 0.0, -0.5), epsilon = 1e-5);
    assert!((rolled.right.cross(rolled.down) - rolled.forward).length() < 1e-6);
}
