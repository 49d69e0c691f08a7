// What the chosen robot believes, saw and wanted, on the pitch.
import { TEAM } from "./scene.js";
import { words } from "./textures.js";

const [BELIEF, SIGHT, WISH] = [0xffe14d, 0x4de1ff, 0xff9f2e];

export function drawMind(stage, { match, robot: index, timeS, shows }, moment) {
  const { marks, scale } = stage;
  const wide = 0.5 + 0.5 * scale;
  marks.clear();
  stage.words.visible = false;
  moment.robots.forEach((robot, other) => {
    const { team } = match.robots[other];
    marks.add("ring", { x: robot.x, y: robot.y, a: 0.2 * wide, colour: other === index ? 0xffffff : TEAM[team] });
    if (other === index) marks.add("ring", { x: robot.x, y: robot.y, a: 0.25 * wide, colour: TEAM[team] });
  });
  if (moment.ball) marks.add("ring", { ...moment.ball, z: 0.012, a: Math.max(0.1 * scale, 1.8 * match.head.ball_radius_m), colour: 0xffffff });
  if (index === null) return;
  const mind = match.mind(index, timeS);
  if (!mind) return;
  if (shows.sight) drawSight(marks, mind, moment.robots[index]);
  if (shows.belief) drawBelief(marks, mind, match.robots[index].team);
  if (shows.wish && mind.target) {
    marks.line(moment.robots[index], mind.target, 0.025 * scale, WISH);
    marks.add("ring", { ...mind.target, a: 0.09, colour: WISH });
    const text = mind.target.words || mind.intention;
    stage.words.visible = Boolean(text);
    if (text && stage.words.text !== text) {
      stage.words.material.map?.dispose();
      stage.words.material.map = words(text);
      stage.words.material.needsUpdate = true;
      stage.words.text = text;
    }
    stage.words.scale.set(0.9 * scale, 0.17 * scale, 1);
    stage.words.position.set(mind.target.x, mind.target.y, 0.2);
  }
}

function drawSight(marks, { things, seenBall }, from) {
  for (const { kind, x, y, endX, endY } of things) {
    if (kind === 4) marks.line({ x, y }, { x: endX, y: endY }, 0.03, SIGHT);
    else if (kind < 4) {
      marks.line(from, { x, y }, 0.008, SIGHT);
      marks.add("ring", { x, y, a: kind ? 0.14 : 0.08, colour: kind === 1 ? TEAM.blue : kind === 2 ? TEAM.pink : SIGHT });
    } else marks.add("ring", { x, y, a: 0.06, colour: SIGHT });
  }
  if (!seenBall) return;
  marks.line(from, seenBall, 0.012, SIGHT);
  marks.add("ring", { ...seenBall, a: 0.07, colour: SIGHT });
}

function drawBelief(marks, { pose, ball, mates, opponents }, team) {
  if (pose) {
    marks.ellipse(pose, BELIEF);
    marks.add("arrow", { x: pose.x, y: pose.y, turn: pose.heading, a: 0.16, colour: BELIEF, z: 0.016 });
  }
  if (ball) {
    marks.ellipse(ball, WISH);
    marks.add("disc", { x: ball.x, y: ball.y, a: 0.05, colour: WISH, z: 0.016 });
    if (pose) marks.line(pose, ball, 0.008, BELIEF);
  }
  const other = team === "blue" ? "pink" : "blue";
  for (const mate of mates) marks.ellipse(mate, TEAM[team]);
  for (const opponent of opponents) marks.ellipse(opponent, TEAM[other]);
  for (const robot of [...mates, ...opponents]) marks.add("disc", { x: robot.x, y: robot.y, a: 0.05, colour: BELIEF, z: 0.016 });
}
