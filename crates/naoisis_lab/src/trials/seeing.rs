//! Conditions for measuring the vision of a scenario's robots.

use naoisis_core::robot::head::HeadAngles;
use naoisis_core::team::{PerTeam, RobotId, Team};
use naoisis_sensing::sensing::vision::image::accuracy::Conditions;
use naoisis_sim::scenario::Scenario;

/// Returns the conditions for the first blue robot of a scenario: the pitch, ball and robots, its cameras and its vision.
pub fn conditions(scenario: &Scenario) -> Conditions {
    let [own, other] = Team::BOTH.map(|team| scenario.robot(RobotId::new(team, 1)));
    let [own_body, other_body] = [&own, &other].map(|robot| scenario.body_of(robot));
    let [yaw, pitch] = own.head_angles;
    let settings = scenario.settings_of(&own);
    let ball = scenario.ball.unwrap_or_default();
    Conditions {
        pitch: scenario.field.clone(),
        ball_radius_m: ball.radius_m,
        ball_look: ball.look,
        bodies: PerTeam::new(|team| if team == Team::Blue { own_body } else { other_body }),
        head: settings.head.reached_from(HeadAngles { yaw, pitch }),
        cameras: settings.cameras,
        vision: settings.vision,
    }
}
