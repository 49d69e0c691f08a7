//! Legal positions at a kick-off (2010 rule book, section 3.5; 2025 rule book, section 3.7).

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::areas::{base_corners, feet, in_area, in_goal, in_team_frame};
use super::snapshot::{MatchSnapshot, RobotSnapshot};
use crate::game::{DefenderLimit, Evidence, KickOffPositions};
use crate::team::{RobotId, Team};

/// An illegal position of a robot at a kick-off.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Reflect, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum IllegalPosition {
    /// The robot is outside the lines.
    OffPitch,
    /// The robot is not wholly in its own half.
    OutsideOwnHalf,
    /// The robot is illegally in the centre circle, or a team-mate in the circle is nearer to the ball.
    InCentreCircle,
    /// A defender is not behind the penalty mark of its half (2010). On a pitch with the mark in the penalty area,
    /// such as that of 2025, this does not apply.
    PastPenaltyMark,
    /// A field player is in its own penalty area (2010).
    InPenaltyArea,
    /// The keeper is not in its own penalty area (2010).
    KeeperAway,
    /// Too many robots of the team are in their own goal area (2025).
    InGoalArea,
    /// The robot stands on the centre mark.
    OnCentreMark,
    /// The robot stands on the penalty mark at a penalty kick (2025).
    OnPenaltyMark,
    /// The robot is in the penalty area at a penalty kick, and is neither the goalkeeper nor the kicker (2025).
    InPenaltyAreaAtKick,
    /// The robot is ahead of the penalty mark at a penalty kick, or too near to it, and is neither the goalkeeper nor the kicker (HSL 2026).
    NearPenaltyMark,
}

impl IllegalPosition {
    /// The rule in one sentence.
    pub fn rule(self) -> &'static str {
        match self {
            IllegalPosition::OffPitch => "At a kick-off robots stand on the pitch.",
            IllegalPosition::OutsideOwnHalf => "At a kick-off robots stand in their own half.",
            IllegalPosition::InCentreCircle => {
                "At a kick-off one robot of the team that kicks off may be in the centre circle, and nobody else."
            }
            IllegalPosition::PastPenaltyMark => {
                "At a kick-off the defending field players stand behind their penalty mark."
            }
            IllegalPosition::InPenaltyArea => "At a kick-off field players stand outside their own penalty area.",
            IllegalPosition::KeeperAway => "At a kick-off the keeper has both feet in its own penalty area.",
            IllegalPosition::InGoalArea => "Only so many robots of a team may be in their own goal area.",
            IllegalPosition::OnCentreMark => "At a kick-off nobody may stand on the centre mark.",
            IllegalPosition::OnPenaltyMark => "At a penalty kick no attacker may stand on the penalty mark.",
            IllegalPosition::InPenaltyAreaAtKick => {
                "At a penalty kick only the keeper and one attacker may be in the penalty area."
            }
            IllegalPosition::NearPenaltyMark => {
                "At a penalty kick only the keeper and the kicker may be ahead of the penalty mark, or nearer to it than at a free kick."
            }
        }
    }
}

/// The illegal position of each robot at a kick-off of `kick_off_team`, or at a drop ball if there is no such team: one entry for each
/// robot, `None` if it is legal or the robot is penalised.
pub(crate) fn illegal_positions(
    snapshot: &MatchSnapshot,
    kick_off_team: Option<Team>,
) -> impl Iterator<Item = Option<IllegalPosition>> {
    let positions = snapshot.rules.kick_off_positions;
    let nearest = kick_off_team.and_then(|team| match positions {
        KickOffPositions::Spl2010 => nearest_in_circle(snapshot, team),
        KickOffPositions::Spl2025 => snapshot.robot_index(kick_off_player(snapshot, team)?),
    });
    snapshot.robots.iter().enumerate().map(move |(index, robot)| {
        if !robot.is_present() {
            return None;
        }
        let attacks = kick_off_team == Some(robot.id.team);
        let may_be_in_circle = attacks && nearest == Some(index);
        let ball_radius = snapshot.ball.map_or(0.0, |ball| ball.radius);
        let base = robot.bounds.base.footprint(robot.pose);
        if base.overlap_disc(Vec2::ZERO, ball_radius).is_some() {
            return Some(IllegalPosition::OnCentreMark);
        }
        match positions {
            KickOffPositions::Spl2010 => illegal_in_2010(snapshot, robot, attacks, may_be_in_circle),
            KickOffPositions::Spl2025 => illegal_in_2025(snapshot, index, nearest == Some(index)),
        }
    })
}

/// The robot of a team in the centre circle that is nearest to the ball.
fn nearest_in_circle(snapshot: &MatchSnapshot, team: Team) -> Option<usize> {
    let candidates = snapshot
        .robots
        .iter()
        .enumerate()
        .filter(|(_, robot)| robot.is_present() && robot.id.team == team && touches_circle(snapshot, robot));
    candidates
        .min_by(|(_, a), (_, b)| a.pose.position.length_squared().total_cmp(&b.pose.position.length_squared()))
        .map(|(index, _)| index)
}

/// The robot of a team that is outside its own half, or of several the nearest to the centre mark. It must take the kick-off (2025).
pub(crate) fn kick_off_player(snapshot: &MatchSnapshot, team: Team) -> Option<RobotId> {
    let outside = snapshot
        .robots
        .iter()
        .filter(|robot| robot.is_present() && robot.id.team == team && leaves_own_half(snapshot, robot));
    outside
        .min_by(|a, b| a.pose.position.length_squared().total_cmp(&b.pose.position.length_squared()))
        .map(|robot| robot.id)
}

fn touches_circle(snapshot: &MatchSnapshot, robot: &RobotSnapshot) -> bool {
    let radius = snapshot.pitch.centre_circle_diameter_m / 2.0 + snapshot.pitch.line_width_m / 2.0;
    robot.bounds.base.footprint(robot.pose).overlap_disc(Vec2::ZERO, radius).is_some()
}

/// Whether any part of the base is on or beyond the halfway line.
fn leaves_own_half(snapshot: &MatchSnapshot, robot: &RobotSnapshot) -> bool {
    let own_end = snapshot.game.own_end(robot.id.team);
    base_corners(robot).iter().any(|corner| in_team_frame(own_end, *corner).x > -snapshot.pitch.line_width_m / 2.0)
}

/// Whether a robot is outside the lines.
pub fn is_off_pitch(snapshot: &MatchSnapshot, robot: &RobotSnapshot) -> bool {
    let limits = snapshot.pitch.outer_half_extents();
    let place = robot.pose.position.abs();
    place.x > limits.x || place.y > limits.y
}

fn illegal_in_2010(
    snapshot: &MatchSnapshot,
    robot: &RobotSnapshot,
    attacks: bool,
    may_be_in_circle: bool,
) -> Option<IllegalPosition> {
    let pitch = snapshot.pitch;
    let own_end = snapshot.game.own_end(robot.id.team);
    let mut feet_at_home = feet(robot).map(|foot| in_area(pitch, pitch.penalty_area, own_end, foot)).into_iter();
    if is_off_pitch(snapshot, robot) {
        Some(IllegalPosition::OffPitch)
    } else if leaves_own_half(snapshot, robot) {
        Some(IllegalPosition::OutsideOwnHalf)
    } else if snapshot.game.is_goalkeeper(robot.id) {
        (!feet_at_home.all(|at_home| at_home)).then_some(IllegalPosition::KeeperAway)
    } else if feet_at_home.any(|at_home| at_home) {
        Some(IllegalPosition::InPenaltyArea)
    } else if touches_circle(snapshot, robot) && !may_be_in_circle {
        Some(IllegalPosition::InCentreCircle)
    } else {
        let mark = -(pitch.half_length() - pitch.penalty_mark_distance_m);
        let past = |corner: &Vec2| in_team_frame(own_end, *corner).x > mark;
        let counts = !attacks && pitch.penalty_mark_distance_m > pitch.penalty_area.depth_m;
        (counts && base_corners(robot).iter().any(past)).then_some(IllegalPosition::PastPenaltyMark)
    }
}

fn illegal_in_2025(snapshot: &MatchSnapshot, index: usize, is_kick_off_player: bool) -> Option<IllegalPosition> {
    let robot = &snapshot.robots[index];
    let own_end = snapshot.game.own_end(robot.id.team);
    if is_off_pitch(snapshot, robot) && !in_goal(snapshot.pitch, own_end, robot.pose.position) {
        return Some(IllegalPosition::OffPitch);
    }
    if is_kick_off_player {
        // The robot may be anywhere in the circle, including the other half, but wholly in the circle if not in its own half.
        let radius = snapshot.pitch.centre_circle_diameter_m / 2.0 + snapshot.pitch.line_width_m / 2.0;
        let inside = base_corners(robot).iter().all(|corner| corner.length() <= radius);
        return (leaves_own_half(snapshot, robot) && !inside).then_some(IllegalPosition::OutsideOwnHalf);
    }
    if leaves_own_half(snapshot, robot) {
        return Some(IllegalPosition::OutsideOwnHalf);
    }
    // The kick-off team's other robots may be in the circle, as long as they are in their own half.
    let attacks = snapshot.game.has_kick_off(robot.id.team);
    if !attacks && touches_circle(snapshot, robot) {
        return Some(IllegalPosition::InCentreCircle);
    }
    match snapshot.rules.defender_limit {
        DefenderLimit::AtMost(most) if is_excessive_in_goal_area(snapshot, index, most) => {
            Some(IllegalPosition::InGoalArea)
        }
        _ => None,
    }
}

/// Whether more than `most` robots of the robot's team are in their own goal area, and this robot is one of the excess ones, which are
/// nearest to the area's border. The keeper never is.
fn is_excessive_in_goal_area(snapshot: &MatchSnapshot, index: usize, most: u8) -> bool {
    let robot = &snapshot.robots[index];
    if !super::illegal_defender::is_in_goal_area(snapshot, robot) || snapshot.game.is_goalkeeper(robot.id) {
        return false;
    }
    // The depth of a robot in the area; the keeper counts as deepest.
    let depth = |other: &RobotSnapshot| {
        let own_end = snapshot.game.own_end(other.id.team);
        if snapshot.game.is_goalkeeper(other.id) {
            f32::INFINITY
        } else {
            -in_team_frame(own_end, other.pose.position).x
        }
    };
    let deeper = snapshot
        .robots
        .iter()
        .filter(|other| other.is_present() && other.id.team == robot.id.team && other.id != robot.id)
        .filter(|other| super::illegal_defender::is_in_goal_area(snapshot, other))
        .filter(|other| (depth(other), robot.id) > (depth(robot), other.id))
        .count();
    deeper >= usize::from(most)
}

/// The evidence against a robot at an illegal position.
pub fn evidence(snapshot: &MatchSnapshot, robot: &RobotSnapshot, illegal: IllegalPosition) -> Evidence {
    snapshot.evidence_against(illegal.rule(), robot).otherwise("It had to be at a legal place before `set` began.")
}

#[cfg(test)]
mod tests {
    use super::super::formation::formation;
    use super::super::formation::tests::ron_options;
    use super::super::testing::MatchFixture;
    use super::*;
    use crate::game::Rules;
    use crate::geometry::Pose;
    use crate::pitch::Pitch;
    use crate::team::RobotId;
    use std::fs;
    use std::path::PathBuf;

    /// Teams of this size in formation for a kick-off, with all robots displaced by `off`.
    fn lined_up(pitch: &Pitch, rules: &Rules, kick_off: Option<Team>, off: Pose) -> MatchFixture {
        let mut situation = MatchFixture::three_a_side();
        situation.pitch = pitch.clone();
        situation.rules = rules.clone();
        (situation.game.kick_off_team, situation.game.drop_ball) = (kick_off.unwrap_or_default(), kick_off.is_none());
        let example = situation.robots[0];
        situation.robots = Team::BOTH
            .into_iter()
            .flat_map(|team| (1..=rules.team_size).map(move |number| RobotId::new(team, number)))
            .map(|id| {
                let own_end = situation.game.own_end(id.team);
                let place = formation(pitch, rules.team_size, id.number, own_end, kick_off == Some(id.team));
                let pose = Pose { position: place.position + off.position, heading: place.heading + off.heading };
                RobotSnapshot { id, pose, previous: pose, ..example }
            })
            .collect();
        situation
    }

    #[test]
    fn the_formation_is_legal_by_all_rules_on_all_pitches_even_a_little_off() {
        let files = fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets/fields")).unwrap();
        let read = |path: PathBuf| ron_options().from_str(&fs::read_to_string(path).unwrap()).unwrap();
        let pitches: Vec<Pitch> = files.map(|file| read(file.unwrap().path())).collect();
        assert!(pitches.len() >= 5);
        for (pitch, positions) in pitches
            .iter()
            .flat_map(|pitch| [KickOffPositions::Spl2010, KickOffPositions::Spl2025].map(|rules| (pitch, rules)))
        {
            for (team_size, kick_off) in
                (2..=11).flat_map(|size| [Some(Team::Blue), Some(Team::Pink), None].map(|team| (size, team)))
            {
                let rules = Rules { team_size, kick_off_positions: positions, ..Rules::default() };
                for off in [[0.0; 3], [0.05, 0.05, 0.15], [-0.05, 0.05, -0.15], [0.05, -0.05, -0.15]] {
                    let off = Pose::new(off[0], off[1], off[2]);
                    let situation = lined_up(pitch, &rules, kick_off, off);
                    for (illegal, robot) in illegal_positions(&situation.snapshot(), kick_off).zip(&situation.robots) {
                        let at = robot.pose;
                        assert_eq!(
                            illegal, None,
                            "{} on {}, {positions:?}, {kick_off:?}, {team_size} a side, {at:?}",
                            robot.id, pitch.name
                        );
                    }
                }
            }
        }
    }
}
