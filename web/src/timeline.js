// The strip behind the slider: where the ball was, and marks of events.
import { el, minutes } from "./dom.js";

const NAMES = { goal: "goal", penalty: "penalty", half_begins: "whistle", final_whistle: "whistle", caution: "penalty", goal_disallowed: "out", shot: "goal" };

/** Above the middle the ball is in pink's half, below in blue's: who presses is seen at a glance. */
export function drawStrip(canvas, match) {
  const { clientWidth: width, clientHeight: height } = canvas;
  if (!width) return;
  const scale = Math.min(2, devicePixelRatio);
  [canvas.width, canvas.height] = [width * scale, height * scale];
  const context = canvas.getContext("2d");
  context.scale(scale, scale);
  const style = getComputedStyle(canvas);
  const half = (match.head.pitch.length_m / 2) * 200;
  const [xs, ends, states, isIn] = ["ball.x", "blue_end", "state", "ball.in"].map(match.get);
  for (let column = 0; column < width; column++) {
    const [from, to] = [column, column + 1].map((at) => match.at(match.startS + (at / width) * (match.endS - match.startS)).index);
    if (match.isLost(match.startS + ((column + 0.5) / width) * (match.endS - match.startS))) continue;
    let [sum, count, plays] = [0, 0, 0];
    for (let index = from; index <= Math.max(from, to); index++) {
      if (isIn[index]) [sum, count] = [sum + xs[index] * (ends[index] ? -1 : 1), count + 1];
      plays += states[index] === 4;
    }
    const share = count ? Math.max(-1, Math.min(1, sum / count / half)) : 0;
    context.globalAlpha = plays ? 0.75 : 0.25;
    context.fillStyle = style.getPropertyValue(share > 0 ? "--blue" : "--pink");
    const long = Math.abs(share) * (height / 2 - 1);
    context.fillRect(column, share > 0 ? height / 2 - long : height / 2, 1, Math.max(0.5, long));
  }
}

export function placeMarks(box, page) {
  const { match } = page;
  const span = Math.max(1e-6, match.endS - match.startS);
  const marks = match.events.filter(page.isLoud).map((event) => {
    const kind = NAMES[event.kind.split(" ")[0]] ?? "whistle";
    const mark = el("button", { type: "button", tabIndex: -1, title: `${minutes(event.timeS)} ${event.words}`, data: { kind, team: event.team ?? "" } });
    mark.style.left = `${(100 * (event.timeS - match.startS)) / span}%`;
    mark.addEventListener("click", () => page.goTo(event));
    return mark;
  });
  box.replaceChildren(...marks);
}
