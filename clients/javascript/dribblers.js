// A small team: finds the ball, dribbles it, shoots, and tells its team-mates. The same team as dribblers.py.
//
//     naoisis run match3v3 --blue "exec:node clients/javascript/dribblers.js"
"use strict";

const { play } = require("./naoisis_agent.js");

// How far a robot walks and turns in a cycle, m and degrees.
const STEP_M = 0.006;
const TURN_DEG = 3.0;
// A ball this near, and this far to one side, can be kicked.
const REACH_M = 0.17;
const FOOT_M = 0.08;

// The middle between the posts of the goal that is attacked, m, as far as they are seen.
function opponentsGoal(perception) {
  const colour = perception.game.own_end === "negative_x" ? "yellow" : "blue";
  const posts = perception.percepts.goal_posts.filter((post) => post.colour === colour).map((post) => post.position_m);
  if (posts.length === 0) return null;
  const mean = (index) => posts.reduce((sum, post) => sum + post[index], 0) / posts.length;
  return [mean(0), mean(1)];
}

// Degrees of a cycle's turn to a place in the robot's frame.
function turnTowards([x, y]) {
  if (x > 0 && -0.1 * x < y && y < 0.1 * x) return 0;
  return y > 0 ? TURN_DEG : -TURN_DEG;
}

function decide(perception) {
  if (perception.game.penalised || perception.game.state !== "playing") return {};
  if (perception.body === "fallen") return { posture: "get_up" };
  const ball = perception.percepts.ball;
  if (!ball) return { walk: [0, 0, TURN_DEG], head_deg: [0, 15] };
  const [x, y] = ball.position_m;
  const say = { intention: "dribble", payload: x < 1 ? "near" : "far" };
  // A ball at the feet is seen only with the head down.
  const head_deg = [0, x < 0.5 ? 25 : 0];
  const goal = opponentsGoal(perception);
  if (x < REACH_M && -FOOT_M < y && y < FOOT_M) {
    if (goal && turnTowards(goal) === 0) {
      return { kick: { type: y > 0 ? "left_straight" : "right_straight", speed: 1 }, head_deg, say };
    }
    // Around the ball, until the goal comes into view.
    if (!goal) return { walk: [0, STEP_M / 2, -TURN_DEG], head_deg: [0, 0], say };
  }
  return { walk: [STEP_M, 0, turnTowards([x, y])], head_deg, say };
}

play(decide, "dribblers");
