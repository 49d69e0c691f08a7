use super::*;
use bevy::math::Vec2;
use naoisis_core::game::{ActivePenalty, Score, SetPlayKind, Timeout};

const VERSION: ProtocolVersion = ProtocolVersion::V18;

fn robots() -> Vec<(RobotId, Penalty)> {
    let robot = |team, number| (RobotId::new(team, number), Penalty(None));
    vec![robot(Team::Blue, 1), robot(Team::Blue, 2), robot(Team::Pink, 2)]
}

fn packet(game: &Game, rules: &Rules, robots: &[(RobotId, Penalty)], for_monitors: bool) -> ControlPacket {
    let (clock, team_numbers) = (CycleClock::default(), PerTeam { blue: 5, pink: 12 });
    let (division, shots_scored) = (Division::Small, PerTeam::default());
    let colours = TeamColours::worn_by(&[], game);
    let records = &[];
    PacketSource {
        game,
        rules,
        division,
        clock: &clock,
        robots,
        records,
        team_numbers,
        colours,
        shots_scored,
        ended: None,
    }
    .packet(VERSION, for_monitors)
}

#[test]
fn a_match_is_told_in_the_protocols_words() {
    let (rules, mut robots) = (Rules::default(), robots());
    let reason = PenaltyReason::Pushing;
    robots[1].1 = Penalty(Some(ActivePenalty { reason, cycles_left: 301 }));
    let mut game = Game { state: GameState::Playing, half: 1, cycles_left: Some(18_000 - 1), ..Game::default() };
    game.score.pink = 2;
    let told = packet(&game, &rules, &robots, false);
    assert_eq!((told.state, told.is_first_half, told.seconds_left), (GameState::Playing, true, 600));
    assert_eq!((told.players_per_team, told.kicking_team), (2, None));
    let [blue, pink] = &told.teams;
    assert_eq!((blue.number, blue.score, pink.number, pink.score), (5, 0, 12, 2));
    // 301 cycles are a little more than ten seconds.
    assert_eq!((blue.players[1].penalty, blue.players[1].seconds_left), (2, 11));
    // Robots that do not exist are sent as substitutes.
    assert_eq!((pink.players[0].penalty, pink.players[1].penalty, pink.players[19].penalty), (14, 0, 14));
    // In the second half the other team is on the left.
    game.blue_end = game.blue_end.opposite();
    game.half = 2;
    let told = packet(&game, &rules, &robots, false);
    assert_eq!((told.teams[0].number, told.is_first_half), (12, false));
}

#[test]
fn whose_a_kick_off_is_is_told_until_it_is_over_and_not_when_the_whistle_comes() {
    let rules = Rules { ready_s: 45.0, set_s: 3.0, ..Rules::default() };
    let kick_off = SetPlay::new(SetPlayKind::KickOff, Team::Pink, Vec2::ZERO, 300);
    for for_monitors in [false, true] {
        let told = |state, set_play| {
            let game = Game { state, set_play, kick_off_team: Team::Pink, state_cycles: 30, ..Game::default() };
            let told = packet(&game, &rules, &robots(), for_monitors);
            (told.kicking_team, told.secondary_seconds_left)
        };
        assert_eq!(told(GameState::Initial, None), (Some(12), 0));
        assert_eq!(told(GameState::Ready, None), (Some(12), 44));
        assert_eq!(told(GameState::Set, None), (Some(12), 0));
        assert_eq!(told(GameState::Playing, Some(kick_off)), (Some(12), 10));
        assert_eq!(told(GameState::Playing, None), (None, 0));
        assert_eq!(told(GameState::Finished, None), (None, 0));
        // A penalty kick has a whistle, too.
        let penalty_kick = SetPlay::new(SetPlayKind::PenaltyKick, Team::Pink, Vec2::ZERO, 900);
        assert_eq!(told(GameState::Set, Some(penalty_kick)), (Some(12), 0));
        assert_eq!(told(GameState::Playing, Some(penalty_kick)), (Some(12), 30));
    }
    let drop_ball = Game { state: GameState::Ready, drop_ball: true, ..Game::default() };
    assert_eq!(packet(&drop_ball, &rules, &robots(), true).kicking_team, None);
}

#[test]
fn a_time_out_is_a_phase_and_substitutes_are_no_players() {
    let (rules, mut robots) = (Rules::default(), robots());
    robots.push((RobotId::new(Team::Blue, 3), Penalty::SUBSTITUTE));
    let timeout = Timeout { team: Some(Team::Blue), cycles_left: 300, before_shoot_out: false };
    let (state, timeout) = (GameState::Timeout, Some(timeout));
    let game = Game { state, timeout, kick_off_team: Team::Pink, ..Game::default() };
    let told = packet(&game, &rules, &robots, false);
    assert_eq!((told.phase, told.kicking_team, told.secondary_seconds_left), (GamePhase::Timeout, Some(12), 10));
    assert_eq!((told.players_per_team, told.teams[0].players[2]), (2, told.teams[0].players[19]));
    let bytes = told.to_bytes();
    // Phase and state.
    assert_eq!(bytes[9..11], [3, 0]);
    let read = ControlPacket::from_bytes(&bytes).unwrap();
    assert_eq!(read.state, GameState::Timeout);
    assert_eq!(read.version.penalty_reason(read.teams[0].players[2].penalty), Some(PenaltyReason::Substitute));
}

#[test]
fn a_shot_of_a_shoot_out_is_on_the_first_clock_and_it_stands_before_the_whistle() {
    let rules = Rules { shoot_out_s: 60.0, sudden_death_s: None, ..Rules::default() };
    let told = |state, cycles| {
        let mut shoot_out = ShootOut { team: Team::Pink, ..ShootOut::default() };
        shoot_out.shot.cycles = cycles;
        let game = Game { state, shoot_out: Some(shoot_out), cycles_left: Some(0), ..Game::default() };
        let told = packet(&Game { state_cycles: 30, ..game }, &rules, &robots(), false);
        (told.kicking_team, told.seconds_left, told.secondary_seconds_left)
    };
    assert_eq!(told(GameState::Set, 0), (Some(12), 60, 0));
    assert_eq!(told(GameState::Playing, 300), (Some(12), 50, 0));
}

#[test]
fn between_the_halves_the_first_is_finished_and_the_second_initial() {
    let rules = Rules { initial_s: 4.0, ..Rules::default() };
    let told = |state_cycles| {
        let (state, blue_end) = (GameState::Initial, End::PositiveX);
        let cycles_left = Some(18_000);
        let game = Game { state, half: 2, blue_end, state_cycles, cycles_left, overtime_cycles: 70, ..Game::default() };
        let told = packet(&game, &rules, &robots(), false);
        (told.state, told.is_first_half, told.seconds_left, told.teams[0].number)
    };
    assert_eq!(told(59), (GameState::Finished, true, -2, 5));
    assert_eq!(told(60), (GameState::Initial, false, 600, 12));
}

#[test]
fn the_end_of_a_half_is_told_as_it_was_and_the_break_counts_down() {
    let rules = Rules { initial_s: 60.0, set_s: 3.0, ..Rules::default() };
    let before = vec![(RobotId::new(Team::Blue, 1), Penalty(None)), (RobotId::new(Team::Pink, 2), Penalty(None))];
    let ended = EndedPart { robots: before, overtime_cycles: 95 };
    let penalty = ActivePenalty { reason: PenaltyReason::ShootOut, cycles_left: 1 };
    let now = robots().into_iter().map(|(id, _)| (id, Penalty(Some(penalty)))).collect::<Vec<_>>();
    let told = |game: &Game| {
        let (clock, team_numbers) = (CycleClock::default(), PerTeam { blue: 5, pink: 12 });
        let colours = TeamColours::worn_by(&[], game);
        let told = PacketSource {
            game,
            rules: &rules,
            division: Division::Small,
            clock: &clock,
            robots: &now,
            records: &[],
            team_numbers,
            colours,
            shots_scored: PerTeam::default(),
            ended: Some(&ended),
        };
        let told = told.packet(VERSION, false);
        let blue = told.teams.iter().find(|team| team.number == 5).unwrap().players[0].penalty;
        (told.state, told.phase, told.seconds_left, told.secondary_seconds_left, blue)
    };
    let half = |state_cycles| {
        let (state, cycles_left) = (GameState::Initial, Some(18_000));
        told(&Game { state, half: 2, state_cycles, cycles_left, ..Game::default() })
    };
    let shown = VERSION.penalty_code(PenaltyReason::ShootOut);
    assert_eq!(half(300), (GameState::Finished, GamePhase::Normal, -3, 50, 0));
    assert_eq!(half(1500), (GameState::Initial, GamePhase::Normal, 600, 10, shown));
    // Play is finished before a shoot-out, too, and the shoot-out begins in `initial`.
    let shot = |state_cycles, taken| {
        let shoot_out = Some(ShootOut { taken: Score { blue: taken, pink: 0 }, ..ShootOut::default() });
        let (state, cycles_left) = (GameState::Set, Some(0));
        let (state, phase, .., blue) =
            told(&Game { state, half: 2, state_cycles, shoot_out, cycles_left, ..Game::default() });
        (state, phase, blue)
    };
    assert_eq!(shot(10, 0), (GameState::Finished, GamePhase::Normal, 0));
    assert_eq!(shot(20, 0), (GameState::Initial, GamePhase::ShootOut, shown));
    assert_eq!(shot(30, 0), (GameState::Set, GamePhase::ShootOut, shown));
    assert_eq!(shot(10, 1), (GameState::Finished, GamePhase::ShootOut, 0));
}

#[test]
fn a_robot_that_is_sent_off_has_no_time_and_no_cautions() {
    let mut robots = robots();
    let sent_off = ActivePenalty { reason: PenaltyReason::SentOff, cycles_left: u64::MAX };
    robots[1].1 = Penalty(Some(sent_off));
    let player = packet(&Game::default(), &Rules::default(), &robots, false).teams[0].players[1];
    assert_eq!((player.seconds_left, player.cautions), (0, 0));
}

#[test]
fn the_shot_under_way_counts_and_the_shooting_team_has_no_goalkeeper() {
    let rules = Rules { set_s: 3.0, ..Rules::default() };
    let (taken, goals) = (Score { blue: 1, pink: 0 }, Score { blue: 1, pink: 0 });
    let shoot_out = Some(ShootOut { team: Team::Pink, taken, goals, ..ShootOut::default() });
    let told = |state_cycles| {
        let score = Score { blue: 2, pink: 2 };
        let game = Game { state: GameState::Set, state_cycles, shoot_out, score, ..Game::default() };
        let told = packet(&game, &rules, &robots(), false);
        let of = |team: &TeamPacket| (team.score, team.shots, team.goalkeeper);
        (told.state, of(&told.teams[0]), of(&told.teams[1]))
    };
    // After the shot it is still blue's, and the sides have not changed: pink is on the left in a game that goes on with blue there.
    assert_eq!(told(0), (GameState::Finished, (2, 0, 1), (3, 1, 0)));
    assert_eq!(told(30), (GameState::Set, (3, 1, 1), (2, 1, 0)));
}

#[test]
fn after_the_last_shot_it_is_still_the_one_of_its_team() {
    let taken = Score { blue: 3, pink: 3 };
    let shoot_out = ShootOut { team: Team::Blue, taken, winner: Some(Team::Blue), ..ShootOut::default() };
    let game = Game { state: GameState::Finished, shoot_out: Some(shoot_out), ..Game::default() };
    let told = packet(&game, &Rules::default(), &robots(), false);
    assert_eq!((told.kicking_team, told.teams[0].goalkeeper, told.teams[1].goalkeeper), (Some(12), 1, 0));
    assert_eq!((told.teams[0].shots, told.teams[1].shots), (3, 3));
}

#[test]
fn whose_a_free_kick_is_monitors_know_before_robots() {
    let rules = Rules { free_kick_signal_s: 5.0, ..Rules::default() };
    let mut set_play = SetPlay::new(SetPlayKind::CornerKick, Team::Pink, Vec2::ZERO, 900);
    let told = |set_play, for_monitors| {
        let game = Game { state: GameState::Playing, set_play: Some(set_play), ..Game::default() };
        packet(&game, &rules, &robots(), for_monitors)
    };
    assert_eq!((told(set_play, false).kicking_team, told(set_play, true).kicking_team), (None, Some(12)));
    assert_eq!(told(set_play, false).secondary_seconds_left, 30);
    set_play.cycles = 150;
    assert_eq!(told(set_play, false).kicking_team, Some(12));
}

#[test]
fn each_shot_of_a_shoot_out_has_a_bit() {
    let mut scored = PerTeam::default();
    let mut before = ShootOut::default();
    for goal in [true, false, true] {
        let mut after = before;
        after.taken.blue += 1;
        after.goals.blue += u32::from(goal);
        note_shots(&mut scored, Some(&before), Some(&after));
        before = after;
    }
    note_shots(&mut scored, None, Some(&before));
    assert_eq!(scored, PerTeam { blue: 0b101, pink: 0 });
}
