//! Robots and their frames as Foxglove scenes.

use bevy::math::{Affine3A, Quat, Vec3};
use foxglove::messages::{CameraCalibration, FrameTransform, FrameTransforms, SceneUpdate};

use super::shapes::{Entity, PITCH, colour, quaternion, scene, timestamp, vector};
use naoisis_core::camera_model::{CameraIntrinsics, CameraName, CameraView};
use naoisis_core::robot::body::Body;
use naoisis_core::robot::head::HeadAngles;
use naoisis_core::team::RobotId;
use naoisis_sensing::appearance::colours;
use naoisis_sensing::appearance::posing::{JointAngles, Limb};
use naoisis_sensing::appearance::robot::RobotDesign;
use naoisis_sensing::appearance::scene::world_from_body;
use naoisis_sensing::sensing::camera::CameraSettings;
use naoisis_sim::interface::cycle_record::{CycleRecord, RobotRecord};
use naoisis_sim::interface::fields::Fields;
use naoisis_sim::scenario::Scenario;

/// Name of the ball's frame.
const BALL: &str = "ball";
/// Opacity of penalised robots.
const PENALISED_OPACITY: f64 = 0.3;
/// Height of a robot's name, and its distance above the robot, m.
const NAME_M: f32 = 0.12;

/// The properties of a robot that do not change.
pub(super) struct Robot {
    pub id: RobotId,
    pub body: Body,
    pub cameras: CameraSettings,
}

impl Robot {
    pub(super) fn of(scenario: &Scenario, id: RobotId) -> Self {
        let settings = scenario.settings_of(&scenario.robot(id));
        Self { id, body: settings.body, cameras: settings.cameras }
    }

    fn head_frame(&self) -> String {
        format!("{}/head", self.id)
    }

    /// Returns the name of a camera's frame: x to the right in its image, y down, z ahead.
    pub(super) fn camera_frame(&self, camera: CameraName) -> String {
        format!("{}/{camera}", self.id)
    }

    /// Returns the transforms from the head to its cameras.
    pub(super) fn camera_frames(&self) -> impl Iterator<Item = FrameTransform> {
        self.cameras.mounts.iter().map(|mount| {
            let view = CameraView::new(self.cameras.intrinsics(mount), mount, self.body.neck_m, HeadAngles::default());
            let head_from_camera =
                Affine3A::from_mat3_translation(view.robot_from_camera(), view.lens - self.body.neck_m);
            frame(0, &self.head_frame(), &self.camera_frame(mount.name), head_from_camera)
        })
    }

    /// Returns the transforms of the robot and its head after a cycle, as far as `has` says that their truth was recorded.
    fn frames(
        &self,
        record: &RobotRecord,
        has: RecordedFrames,
        time_ns: u64,
    ) -> impl Iterator<Item = FrameTransform> + use<> {
        let name = self.id.to_string();
        let HeadAngles { yaw, pitch } = record.head;
        let turned = Quat::from_rotation_z(yaw) * Quat::from_rotation_y(pitch);
        let robot_from_head = Affine3A::from_rotation_translation(turned, self.body.neck_m);
        let body = frame(time_ns, PITCH, &name, world_from_body(record.pose, record.posture, &self.body));
        let head = frame(time_ns, &name, &self.head_frame(), robot_from_head);
        has.poses.then_some(body).into_iter().chain(has.heads.then_some(head))
    }

    /// Draws the body and the head, with the robot's name above.
    pub(super) fn drawn(&self, is_penalised: bool, time_ns: u64) -> SceneUpdate {
        let opacity = if is_penalised { PENALISED_OPACITY } else { 1.0 };
        let mut trunk = Entity::new("body", &self.id.to_string(), time_ns).locked();
        let mut head = Entity::new("head", &self.head_frame(), time_ns).locked();
        let limbs = JointAngles::default().world_from_limbs(&self.body, Affine3A::IDENTITY);
        for part in RobotDesign::Nao.parts(self.id, &self.body) {
            match part.frame {
                Limb::Head => head.part(&part, Affine3A::IDENTITY, opacity),
                limb => trunk.part(&part, limbs[limb as usize], opacity),
            }
        }
        let above = Vec3::Z * (self.body.height_m + NAME_M);
        trunk.text(above, &self.id.to_string(), NAME_M, colour(colours::team(self.id.team), opacity));
        scene([trunk, head])
    }
}

/// The frames of robots whose truth is recorded.
#[derive(Clone, Copy, Debug)]
pub(super) struct RecordedFrames {
    pub poses: bool,
    heads: bool,
}

impl RecordedFrames {
    /// Returns the frames that records with these fields have.
    pub(super) fn of(fields: &Fields) -> Self {
        Self { poses: fields.has("robots.pose"), heads: fields.has("robots.head_deg") }
    }
}

/// Returns the transforms of all robots, as far as `has` says that their truth was recorded, and of the ball after a cycle.
pub(super) fn frames(robots: &[Robot], record: &CycleRecord, has: RecordedFrames, time_ns: u64) -> FrameTransforms {
    let of_robot = |robot: &Robot| record.robot(robot.id).map(|there| robot.frames(there, has, time_ns));
    let mut transforms: Vec<FrameTransform> = robots.iter().filter_map(of_robot).flatten().collect();
    let balls = record.ball.iter().chain(record.more_balls()).zip(1..);
    transforms.extend(
        balls.map(|(ball, number)| {
            frame(time_ns, PITCH, &ball_frame(number), Affine3A::from_translation(ball.position_m))
        }),
    );
    FrameTransforms { transforms }
}

/// The frame of a ball, from 1.
pub(super) fn ball_frame(number: usize) -> String {
    if number == 1 { BALL.to_owned() } else { format!("{BALL}_{number}") }
}

fn frame(time_ns: u64, parent: &str, child: &str, parent_from_child: Affine3A) -> FrameTransform {
    FrameTransform {
        timestamp: timestamp(time_ns),
        parent_frame_id: parent.to_owned(),
        child_frame_id: child.to_owned(),
        translation: vector(parent_from_child.translation.into()),
        rotation: quaternion(Quat::from_mat3a(&parent_from_child.matrix3)),
    }
}

/// Returns the calibration of a camera, in the convention of OpenCV and ROS: the centre of the top-left pixel is at (0, 0).
pub(super) fn calibration(intrinsics: &CameraIntrinsics, frame_id: String) -> CameraCalibration {
    let [fx, fy] = intrinsics.focal.to_array().map(f64::from);
    let [cx, cy] = (intrinsics.centre - 0.5).to_array().map(f64::from);
    CameraCalibration {
        timestamp: timestamp(0),
        frame_id,
        width: intrinsics.size.x as u32,
        height: intrinsics.size.y as u32,
        distortion_model: intrinsics.distortion.model().to_owned(),
        d: intrinsics.distortion.coefficients().into_iter().map(f64::from).collect(),
        k: vec![fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0],
        r: vec![1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        p: vec![fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::geometry::Pose;
    use naoisis_core::team::Team;

    fn affine(of: &FrameTransform) -> Affine3A {
        let (place, turned) = (of.translation.unwrap(), of.rotation.unwrap());
        let rotation = Quat::from_array([turned.x, turned.y, turned.z, turned.w].map(|part| part as f32));
        Affine3A::from_rotation_translation(
            rotation,
            Vec3::from_array([place.x, place.y, place.z].map(|part| part as f32)),
        )
    }

    #[test]
    fn through_the_frames_a_point_is_in_the_pixel_where_its_camera_sees_it() {
        let id = RobotId::new(Team::Pink, 2);
        let robot = Robot::of(&Scenario::default(), id);
        let mut record = RobotRecord::new(id);
        (record.pose, record.head) = (Pose::new(1.0, -2.0, 2.5), HeadAngles { yaw: 0.4, pitch: 0.2 });
        let frames: Vec<_> = robot.frames(&record, RecordedFrames { poses: true, heads: true }, 7).collect();
        let [base, head] = frames.as_slice() else { panic!("{frames:?}") };
        assert_eq!((base.parent_frame_id.as_str(), head.child_frame_id.as_str()), ("pitch", "pink2/head"));
        let ball = Vec3::new(1.2, 0.3, 0.05);
        for (mount, camera) in robot.cameras.mounts.iter().zip(robot.camera_frames()) {
            let view = robot.cameras.view(mount.name, &robot.body, record.head).unwrap();
            let expected = view.project(ball).unwrap();
            let seen = (affine(head) * affine(&camera)).inverse().transform_point3(ball);
            let k = calibration(&view.intrinsics, String::new()).k;
            let pixel = [k[0] as f32 * seen.x / seen.z + k[2] as f32, k[4] as f32 * seen.y / seen.z + k[5] as f32];
            let pixel = bevy::math::Vec2::from_array(pixel) + 0.5;
            // The rounding of rotations moves a point by up to a tenth of a pixel.
            assert!(pixel.abs_diff_eq(expected, 0.1), "{}: {pixel} {expected}", mount.name);
        }
        let forward = affine(base).transform_vector3(Vec3::X).truncate();
        assert!(forward.abs_diff_eq(record.pose.forward(), 1e-3));
    }

    #[test]
    fn a_robot_whose_pose_was_not_recorded_has_no_frame() {
        let id = RobotId::new(Team::Pink, 2);
        let robot = Robot::of(&Scenario::default(), id);
        let names = |fields: Fields| -> Vec<String> {
            robot.frames(&RobotRecord::new(id), RecordedFrames::of(&fields), 0).map(|of| of.child_frame_id).collect()
        };
        assert_eq!(names("ball".parse().unwrap()), [""; 0]);
        assert_eq!(names("robots.pose".parse().unwrap()), ["pink2"]);
        assert_eq!(names(Fields::default()), ["pink2", "pink2/head"]);
    }

    #[test]
    fn a_penalised_robot_is_faint() {
        let robot = Robot::of(&Scenario::default(), RobotId::new(Team::Blue, 1));
        let faint = robot.drawn(true, 0);
        assert_eq!(faint.entities.len(), 2);
        assert!(faint.entities.iter().flat_map(|entity| &entity.spheres).all(|sphere| sphere.color.unwrap().a == 0.3));
        assert_eq!(robot.drawn(false, 0).entities[0].texts[0].text, "blue1");
    }
}
