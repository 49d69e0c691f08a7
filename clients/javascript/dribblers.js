// A small team: finds the ball, walks around it until it lies before the opponents' goal, shoots, and tells its team-mates. The
// same team as dribblers.py.
//
//     naoisis run match3v3 --blue "exec:node clients/javascript/dribblers.js"
"use strict";

const { play } = require("./naoisis_agent.js");

// How far a robot turns in a cycle at most, degrees.
const TURN_DEG = 3.0;
// A ball that was seen longer ago is searched, s.
const LOST_S = 2.0;

const rounded = (number) => Math.floor(1e6 * number + 0.5) / 1e6;

// A place of the team's frame in the frame of the robot: x ahead, y to the left, m.
function inRobotFrame(place, pose) {
  const [x, y] = [place[0] - pose[0], place[1] - pose[1]];
  const heading = pose[2] * (Math.PI / 180);
  const [cos, sin] = [Math.cos(heading), Math.sin(heading)];
  return [rounded(cos * x + sin * y), rounded(cos * y - sin * x)];
}

// Degrees of a cycle's turn to a place in the robot's frame: fewer if it is nearly ahead.
function turnTowards([x, y]) {
  const turn = x > 0.1 ? (30 * y) / x : 1e9 * y;
  return Math.max(-TURN_DEG, Math.min(TURN_DEG, turn));
}

// What a robot needs to know of the match.
function abilities(welcome) {
  const { kicks, motion } = welcome.model;
  // Some robots have a kick whose direction is chosen.
  const aimed = kicks.own?.visual;
  const { region } = aimed ?? kicks.left_straight;
  const [startX, startY] = welcome.pose ?? [-1, 0];
  return {
    goal: [welcome.field.length_m / 2, 0],
    // Its place for kick-offs: from where it starts, towards the middle of the pitch.
    place: [startX, 0.4 * startY],
    // How far it walks in a cycle, m: nearly as fast as it can.
    stepM: rounded(0.9 * motion.max_linear_mps * welcome.cycle_s),
    aims: aimed !== undefined,
    // How near, and how far to one side, a ball can be kicked, m.
    reachM: region ? [0.9 * region.x_m[1], 0.9 * region.y_m[1]] : [0.17, 0.08],
    // How far to one side the goal may be, as a share of its distance.
    aside: aimed ? 0.8 : 0.15,
    // The state that it was told last, and the numbers of whistles and of signals for `ready` at that time.
    told: [undefined, 0, 0],
  };
}

// The state of the game: a whistle or a signal of the referee comes before a late report.
function stateOf({ state, whistles, ready_signals }) {
  if (state !== own.told[0]) own.told = [state, whistles, ready_signals];
  if (state === "set" && whistles > own.told[1]) return "playing";
  return state === "standby" && ready_signals > own.told[2] ? "ready" : state;
}

let own;

function decide(perception, belief, welcome) {
  own ??= abilities(welcome);
  const { stepM, reachM, aside } = own;
  const { penalised, stopped } = perception.game;
  const state = stateOf(perception.game);
  const { pose } = belief;
  if (penalised || stopped || !["ready", "playing"].includes(state)) return {};
  if (perception.body === "fallen") return { posture: "get_up" };
  if (state === "ready") {
    const [x, y] = inRobotFrame(own.place, pose);
    if (x * x + y * y > 0.04) return { walk: [x > Math.abs(y) ? stepM : 0, 0, rounded(turnTowards([x, y]))] };
  }
  if (!belief.ball || belief.ball.age_s > LOST_S) {
    // It turns on the spot and looks near, then far.
    return { walk: [0, 0, TURN_DEG], head_deg: [0, pose[2] > 0 ? 30 : 0] };
  }
  const ball = inRobotFrame(belief.ball.position_m, pose);
  // It faces the ball: the referee removes robots that stand and look elsewhere.
  if (state === "ready") return { walk: [0, 0, rounded(0.3 * turnTowards(ball))] };
  const goal = inRobotFrame(own.goal, pose);
  const said = {
    // A ball at the feet is seen only with the head down.
    head_deg: [0, ball[0] < 0.5 ? 40 : 0],
    say: { intention: "dribble", payload: ball[0] < 1 ? "near" : "far" },
  };
  const isNear = 0 < ball[0] && ball[0] < 0.5 && -0.25 < ball[1] && ball[1] < 0.25;
  const facesGoal = goal[0] > 0 && -aside * goal[0] < goal[1] && goal[1] < aside * goal[0];
  if (isNear && !facesGoal) {
    // Around the ball, which stays in front.
    const side = goal[1] > 0 ? -1 : 1;
    const turn = 0.3 * turnTowards(ball) - (side * 28 * stepM) / Math.max(ball[0], 0.1);
    return { walk: [0.1 * (ball[0] - reachM[0]), (side * stepM) / 2, turn].map(rounded), ...said };
  }
  if (isNear && ball[0] < reachM[0] && -reachM[1] < ball[1] && ball[1] < reachM[1]) {
    if (own.aims) {
      const direction_deg = rounded(Math.atan2(goal[1], goal[0]) * (180 / Math.PI));
      return { kick: { type: "visual", speed: 3, direction_deg }, ...said };
    }
    return { kick: { type: ball[1] > 0 ? "left_straight" : "right_straight", speed: 1 }, ...said };
  }
  if (isNear) {
    // Slowly, and sideways until the ball lies before the robot.
    const walk = [0.1 * (ball[0] - 0.8 * reachM[0]), 0.05 * ball[1], 0.3 * turnTowards(ball)];
    return { walk: walk.map(rounded), ...said };
  }
  return { walk: [stepM, 0, rounded(turnTowards(ball))], ...said };
}

const FIELDS = ["body", "game.penalised", "game.state", "game.stopped", "game.whistles", "game.ready_signals"];

play(decide, "dribblers", FIELDS, { belief: true });
