//! Applies the [`Intervention`]s of people, programs and scenarios.

use bevy::prelude::*;

use super::decide::Referee;
use super::placing::Occupied;
use crate::ball::FASTEST_MPS;
use crate::events::MatchEvent;
use crate::game::{ActivePenalty, GameState, Intervention, Penalty, PenaltyReason, Score};
use crate::geometry::{Pose, wrap_angle};
use crate::team::RobotId;

/// The reason for refusing an intervention in a time-out.
const IN_TIMEOUT: &str = "there is a time-out, which `resume` ends";

impl Referee<'_, '_> {
    /// Applies the interventions of this cycle.
    pub(super) fn intervene(&mut self) {
        for &intervention in self.seen.interventions {
            let event = match self.apply(intervention) {
                Ok(()) => MatchEvent::Intervention { intervention },
                Err(message) => MatchEvent::InterventionRefused { intervention, message },
            };
            self.decisions.events.push(event);
        }
    }

    fn apply(&mut self, intervention: Intervention) -> Result<(), String> {
        match intervention {
            Intervention::PlaceBall { position_m, velocity_mps } => {
                self.require_ball()?;
                self.require_on_carpet(position_m)?;
                // NaN is not a possible speed of a ball either.
                if !(0.0..=FASTEST_MPS).contains(&velocity_mps.length()) {
                    return Err(format!("a ball rolls at {FASTEST_MPS} m/s at most"));
                }
                let radius = self.seen.ball.map_or(0.0, |ball| ball.radius);
                let place = Occupied::by_others(&self.now(), None).ball_place(position_m, radius);
                let place = self.put_ball(place);
                self.decisions.ball_velocity = velocity_mps;
                // A set play is taken from there.
                self.decisions.game.set_play.iter_mut().for_each(|set_play| set_play.ball_m = place);
            }
            Intervention::PlaceRobot { robot, pose } => {
                let index = self.find(robot)?;
                self.require_on_carpet(pose.position)?;
                if !pose.is_finite() {
                    return Err("the heading is not finite".to_owned());
                }
                if !self.decisions.robots[index].is_present() {
                    return Err(format!("{robot} serves a penalty"));
                }
                let pose = Pose { heading: wrap_angle(pose.heading), ..pose };
                let occupied = Occupied::by_others(&self.now(), Some(index));
                self.decisions.robots[index].pose = occupied.free_pose(pose, &self.seen.robots[index].bounds);
                self.memory.robots[index].forgive();
            }
            Intervention::SetScore { blue, pink } => {
                self.require_no_shoot_out()?;
                self.decisions.game.score = Score { blue, pink };
            }
            Intervention::Penalise { robot, reason, duration_s } => self.penalise_by_hand(robot, reason, duration_s)?,
            Intervention::PickUp { robot } => self.pick_up(robot)?,
            Intervention::Return { robot } => self.return_by_hand(robot)?,
            Intervention::Whistle => self.whistle_by_hand()?,
            Intervention::DropBall { position_m } => {
                self.require_ball()?;
                self.require_on_carpet(position_m)?;
                self.require_play()?;
                let position_m = self.put_ball(position_m);
                self.drop_ball();
                self.decisions.events.push(MatchEvent::DropBall { position_m });
            }
            Intervention::Stop => match (self.decisions.game.state, self.decisions.game.stop) {
                (GameState::Initial | GameState::Timeout | GameState::Finished, _) => {
                    return Err("there is nothing to stop".to_owned());
                }
                (_, Some(_)) => return Err("the match is stopped already".to_owned()),
                _ => self.stop(None),
            },
            Intervention::Resume => match (self.decisions.game.stop.take(), self.decisions.game.timeout) {
                (Some(stop), _) => self.resume(stop),
                (None, Some(timeout)) => self.end_timeout(timeout),
                (None, None) => return Err("the match is not stopped".to_owned()),
            },
            Intervention::Timeout { team, duration_s } => self.call_timeout(team, duration_s)?,
            Intervention::Substitute { robot, by } => self.ask_for_substitution(robot, by)?,
            Intervention::KickOff { team } => {
                self.require_play()?;
                self.begin_kick_off(Some(team));
            }
        }
        Ok(())
    }

    fn penalise_by_hand(
        &mut self,
        robot: RobotId,
        reason: PenaltyReason,
        duration_s: Option<f32>,
    ) -> Result<(), String> {
        let index = self.find(robot)?;
        self.require_no_shoot_out()?;
        if !self.decisions.robots[index].is_present() {
            return Err(format!("{robot} serves a penalty already"));
        }
        let rule = match reason {
            PenaltyReason::PickUp => "A team may ask for a robot to be picked up.",
            _ => "The person that runs the match can penalise a robot.",
        };
        if let Some(seconds) = duration_s.filter(|seconds| !(seconds.is_finite() && *seconds >= 0.0)) {
            return Err(format!("a penalty cannot last {seconds} s"));
        }
        let evidence = self.seen.evidence_against(rule, &self.seen.robots[index]);
        let is_sent_off = reason == PenaltyReason::Pushing && self.caution(index, &evidence);
        match duration_s {
            _ if is_sent_off => self.penalise(index, PenaltyReason::SentOff, evidence),
            None => self.penalise(index, reason, evidence),
            Some(seconds) => self.remove(index, reason, self.seen.cycles(seconds), evidence),
        }
        Ok(())
    }

    fn pick_up(&mut self, robot: RobotId) -> Result<(), String> {
        let index = self.find(robot)?;
        let goes_on = |served: &ActivePenalty| !served.is_for_the_match() && served.reason != PenaltyReason::ShootOut;
        let Some(served) = self.decisions.robots[index].penalty.0.filter(goes_on) else {
            return self.penalise_by_hand(robot, PenaltyReason::PickUp, None);
        };
        // Its penalty becomes that of a robot that is picked up, and does not become shorter.
        let rule = "A robot that serves a penalty may be picked up.";
        let evidence = self.seen.evidence_against(rule, &self.seen.robots[index]);
        let cycles = self.penalty_cycles(PenaltyReason::PickUp, robot.team).max(served.cycles_left);
        self.decisions.robots[index].penalty = Penalty(None);
        self.remove(index, PenaltyReason::PickUp, cycles, evidence);
        Ok(())
    }

    fn return_by_hand(&mut self, robot: RobotId) -> Result<(), String> {
        let index = self.find(robot)?;
        self.require_no_shoot_out()?;
        if self.decisions.robots[index].is_present() {
            return Err(format!("{robot} serves no penalty"));
        }
        if self.decisions.robots[index].penalty.0.is_some_and(|it| it.reason == PenaltyReason::Substitute) {
            return Err(format!("{robot} is a substitute"));
        }
        self.bring_back(index);
        Ok(())
    }

    fn whistle_by_hand(&mut self) -> Result<(), String> {
        match self.decisions.game.state {
            _ if self.decisions.game.stop.is_some() => return Err("the match is stopped".to_owned()),
            GameState::Standby => self.signal_ready(),
            GameState::Ready => {
                self.whistle();
                self.begin_set();
            }
            GameState::Set => self.begin_play(),
            GameState::Playing => self.whistle(),
            GameState::Timeout => return Err(IN_TIMEOUT.to_owned()),
            GameState::Initial | GameState::Finished => return Err("there is no play to whistle for".to_owned()),
        }
        Ok(())
    }

    pub(super) fn find(&self, robot: RobotId) -> Result<usize, String> {
        self.seen.robot_index(robot).ok_or_else(|| format!("there is no robot {robot}"))
    }

    fn require_ball(&self) -> Result<(), String> {
        self.seen.ball.map(|_| ()).ok_or_else(|| "there is no ball".to_owned())
    }

    fn require_play(&self) -> Result<(), String> {
        match self.decisions.game.state {
            GameState::Finished => Err("the match is over".to_owned()),
            GameState::Timeout => Err(IN_TIMEOUT.to_owned()),
            _ => self.require_no_shoot_out(),
        }
    }

    /// Checks that there is no shoot-out, in which all robots but the shooter and the goalkeeper wait beside the pitch without a penalty.
    pub(super) fn require_no_shoot_out(&self) -> Result<(), String> {
        match self.decisions.game.shoot_out {
            Some(_) => Err("there is a shoot-out".to_owned()),
            None => Ok(()),
        }
    }

    fn require_on_carpet(&self, place: Vec2) -> Result<(), String> {
        let carpet = self.seen.pitch.carpet_half_extents();
        // A position with NaN is not on the carpet either.
        if place.abs().cmple(carpet).all() {
            return Ok(());
        }
        Err(format!(
            "({}, {}) is not on the carpet, which ends at ±{} m and ±{} m",
            place.x, place.y, carpet.x, carpet.y
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::MatchFixture;
    use super::*;
    use crate::game::{SetPlay, SetPlayKind, ShootOut};
    use crate::team::Team;

    const BLUE2: RobotId = RobotId::new(Team::Blue, 2);

    fn decided(intervention: Intervention) -> super::super::decide::Decisions {
        MatchFixture { interventions: vec![intervention], ..MatchFixture::three_a_side() }.decide()
    }

    #[test]
    fn the_ball_is_placed_and_rolls() {
        let (position_m, velocity_mps) = (Vec2::new(1.0, 1.0), Vec2::new(0.5, 0.0));
        let decided = decided(Intervention::PlaceBall { position_m, velocity_mps });
        assert_eq!((decided.ball, decided.ball_velocity), (Some(position_m), velocity_mps));
    }

    #[test]
    fn a_ball_that_touches_a_robot_stays_and_one_inside_it_is_moved() {
        let situation = MatchFixture::three_a_side();
        let robot = &situation.robots[1];
        let (base, radius) = (robot.bounds.base.footprint(robot.pose), 0.03);
        let mut touches = 0;
        for step in 0..60 {
            let position_m = robot.pose.transform_point(Vec2::new(0.005 * step as f32, 0.0));
            let placed = decided(Intervention::PlaceBall { position_m, velocity_mps: Vec2::ZERO }).ball.unwrap();
            if base.overlap_disc(position_m, radius).is_none() {
                assert_eq!(placed, position_m);
                touches += usize::from(base.overlap_disc(position_m, radius + 0.006).is_some());
            } else if step == 0 {
                assert!(placed.distance(position_m) > 0.04);
            }
        }
        assert!(touches > 0);
    }

    #[test]
    fn the_ball_of_a_set_play_stays_where_it_is_placed() {
        let mut situation = MatchFixture::three_a_side();
        let kick_in = SetPlay::new(SetPlayKind::KickIn, Team::Blue, Vec2::new(-1.0, 2.0), 900);
        situation.game.set_play = Some(kick_in);
        let position_m = Vec2::new(1.0, 2.0);
        situation.interventions = vec![Intervention::PlaceBall { position_m, velocity_mps: Vec2::ZERO }];
        assert_eq!(situation.pass().game.set_play.unwrap().ball_m, position_m);
    }

    #[test]
    fn a_robot_is_placed_where_there_is_room() {
        let pose = Pose::new(1.0, 1.0, 0.5);
        let decided_there = decided(Intervention::PlaceRobot { robot: BLUE2, pose });
        assert_eq!(decided_there.robots[1].pose, pose);
        // Pink's keeper stands at that position.
        let taken = Pose { heading: 0.0, ..MatchFixture::three_a_side().robots[3].pose };
        let beside = decided(Intervention::PlaceRobot { robot: BLUE2, pose: taken }).robots[1].pose;
        assert!((0.05..0.5).contains(&beside.position.distance(taken.position)));
    }

    #[test]
    fn a_robot_is_penalised_and_returns() {
        let duration_s = Some(10.0);
        let mut situation = MatchFixture {
            interventions: vec![Intervention::Penalise { robot: BLUE2, reason: PenaltyReason::Manual, duration_s }],
            ..MatchFixture::three_a_side()
        };
        let robot = situation.pass().robots[1];
        // 10 s of 1/30 s.
        assert_eq!(robot.penalty.0.unwrap().cycles_left, 300);
        let mut situation = MatchFixture { interventions: vec![Intervention::Return { robot: BLUE2 }], ..situation };
        assert!(situation.pass().robots[1].is_present());
    }

    #[test]
    fn a_push_that_is_called_by_hand_is_cautioned_as_one_that_the_referee_sees() {
        let push = Intervention::Penalise { robot: BLUE2, reason: PenaltyReason::Pushing, duration_s: None };
        let mut situation = MatchFixture { interventions: vec![push], ..MatchFixture::three_a_side() };
        situation.rules.cautions_to_send_off = Some(2);
        let reason = |situation: &mut MatchFixture| situation.pass().robots[1].penalty.0.unwrap().reason;
        assert_eq!(reason(&mut situation), PenaltyReason::Pushing);
        let mut again = MatchFixture { interventions: vec![Intervention::Return { robot: BLUE2 }, push], ..situation };
        assert_eq!(reason(&mut again), PenaltyReason::SentOff);
    }

    #[test]
    fn score_whistle_and_drop_ball() {
        assert_eq!(decided(Intervention::SetScore { blue: 3, pink: 1 }).game.score, Score { blue: 3, pink: 1 });
        assert_eq!(decided(Intervention::Whistle).game.whistles, 1);
        let mut ready = MatchFixture { interventions: vec![Intervention::Whistle], ..MatchFixture::three_a_side() };
        ready.game.state = GameState::Ready;
        ready.pass();
        assert_eq!(ready.game.state, GameState::Set);
        ready.interventions = vec![Intervention::Whistle];
        assert_eq!(ready.decide().game.state, GameState::Playing);
        let dropped = decided(Intervention::DropBall { position_m: Vec2::new(1.0, -1.0) });
        assert_eq!((dropped.ball, dropped.game.drop_ball), (Some(Vec2::new(1.0, -1.0)), true));
    }

    #[test]
    fn what_cannot_be_done_is_refused_and_changes_nothing() {
        let nobody = RobotId::new(Team::Pink, 9);
        let far = Pose::new(9.0, 0.0, 0.0);
        let impossible = [
            Intervention::PlaceBall { position_m: Vec2::new(f32::NAN, 0.0), velocity_mps: Vec2::ZERO },
            Intervention::PlaceBall { position_m: Vec2::ZERO, velocity_mps: Vec2::splat(f32::INFINITY) },
            Intervention::PlaceRobot { robot: nobody, pose: Pose::default() },
            Intervention::PlaceRobot { robot: BLUE2, pose: far },
            Intervention::Penalise { robot: nobody, reason: PenaltyReason::Manual, duration_s: None },
            Intervention::Penalise { robot: BLUE2, reason: PenaltyReason::Manual, duration_s: Some(-1.0) },
            Intervention::Return { robot: BLUE2 },
            Intervention::Return { robot: nobody },
        ];
        let before = MatchFixture::three_a_side();
        for intervention in impossible {
            let decided = decided(intervention);
            assert!(matches!(decided.events[..], [MatchEvent::InterventionRefused { .. }]), "{intervention:?}");
            assert_eq!((decided.ball, &decided.robots), (None, &before.robots));
        }
    }

    #[test]
    fn in_a_shoot_out_nobody_is_sent_off_or_brought_back() {
        let mut situation = MatchFixture::three_a_side();
        situation.game.shoot_out = Some(ShootOut::default());
        let penalise = Intervention::Penalise { robot: BLUE2, reason: PenaltyReason::Manual, duration_s: None };
        for intervention in [
            penalise,
            Intervention::Return { robot: BLUE2 },
            Intervention::DropBall { position_m: Vec2::ZERO },
            // The score of play is level, and stays so.
            Intervention::SetScore { blue: 2, pink: 1 },
        ] {
            situation.interventions = vec![intervention];
            let refused = MatchEvent::InterventionRefused { intervention, message: "there is a shoot-out".to_owned() };
            assert!(situation.decide().events.contains(&refused), "{intervention:?}");
        }
    }
}
