use super::choice::{action_of, named};
use super::*;
use crate::environment::{ActionKind, ActionSpace};

#[test]
fn choices_are_the_likeliest_or_drawn_by_their_scores() {
    let mut scores = vec![0.0; 13];
    scores[4] = 2.0;
    assert_eq!(action_of(ActionKind::Discrete.into(), Choice::Likeliest, &scores, None), Ok(vec![4.0]));
    assert_eq!(action_of(ActionKind::Discrete.into(), Choice::Likeliest, &[7.0], None), Ok(vec![7.0]));
    let mut random = BehaviourRandom::new(3, RobotId::new(Team::Blue, 1));
    let draws = 20_000;
    let mut of_four = 0;
    for _ in 0..draws {
        let drawn = action_of(ActionKind::Discrete.into(), Choice::Drawn, &scores, Some(&mut random)).unwrap();
        assert!(ActionKind::Discrete.check(&drawn).is_ok());
        of_four += usize::from(drawn[0] == 4.0);
    }
    // e² / (e² + 12) = 0.3811; four standard errors are 0.0137.
    assert!((of_four as f64 / f64::from(draws) - 0.3811).abs() < 0.0137, "{of_four}");
    // A list each: a walk, a direction, a kick.
    let mut lists = vec![0.0; 9 + 5 + 5];
    (lists[3], lists[9 + 2], lists[9 + 5 + 1]) = (1.0, 1.0, 1.0);
    assert_eq!(action_of(ActionKind::MultiDiscrete.into(), Choice::Likeliest, &lists, None), Ok(vec![3.0, 2.0, 1.0]));
}

#[test]
fn outputs_that_are_no_action_are_refused() {
    let of = |kind, outputs: &[f32]| action_of(kind, Choice::Likeliest, outputs, None).unwrap_err();
    assert_eq!(of(ActionKind::Continuous.into(), &[0.0; 7]), "the action has 7 numbers; expected 8");
    assert_eq!(
        of(ActionKind::Discrete.into(), &[0.0; 12]),
        "the action has 12 numbers; expected 13 scores or 1 choices"
    );
    assert_eq!(of(ActionKind::Discrete.into(), &[f32::NAN]), "an output is not finite");
}

#[test]
fn outputs_have_the_names_of_the_action() {
    let names = |kind: ActionSpace, count: usize| named(kind, &vec![0.0; count]).into_keys().collect::<Vec<_>>();
    assert!(names(ActionKind::Continuous.into(), 8).contains(&"walk.forward".to_owned()));
    assert_eq!(names(ActionKind::Discrete.into(), 13).len(), 13);
    assert!(names(ActionKind::Velocities.into(), 20).contains(&"3.turn_left".to_owned()));
    assert_eq!(names(ActionKind::Velocities.into(), 4), ["choice1", "choice2", "choice3", "choice4"]);
}

#[test]
fn one_run_for_several_robots_gives_the_same_numbers_as_a_run_for_each() {
    let policy = built_in::named("learned").unwrap().unwrap();
    let length = policy.network.inputs()[0].shape[1].unwrap();
    let observations: Vec<Vec<f32>> =
        (0..5).map(|row| (0..length).map(|index| ((row * 31 + index * 7) % 23) as f32 / 9.0 - 1.0).collect()).collect();
    let rows: Vec<&[f32]> = observations.iter().map(Vec::as_slice).collect();
    let together = policy.outputs_of_all(&rows).expect("it has no state");
    for (observation, outputs) in observations.iter().zip(together) {
        assert_eq!(policy.outputs(observation.clone(), &mut Vec::new()).unwrap(), outputs);
    }
    assert_eq!(policy.outputs_of_all(&rows[..1]), None);
}
