// What is known of the chosen robot: where it is, what it believes, sees and wants, and why.
import { POSTURES, KINDS } from "./data.js";
import { el } from "./dom.js";

/** What can be shown on the pitch, and the fields that it needs. */
const SHOWN = [
  ["belief", "Belief, with ellipses of 95 %", ["robots.belief"]],
  ["sight", "What it sees", ["robots.percepts"]],
  ["wish", "What it wants", ["robots.intention", "robots.drawings"]],
];
const cm = (metres) => (metres < 1 ? `${Math.round(100 * metres)} cm` : `${metres.toFixed(2)} m`);
/** Whole degrees within (-180, 180]. */
const degrees = (angle) => 180 - ((((540 - Math.round((angle * 180) / Math.PI)) % 360) + 360) % 360);
const inWords = ({ x, y, turn }) => (x || y || turn ? `${Math.hypot(x, y).toFixed(2)} m/s, ${Math.round((turn * 180) / Math.PI)}°/s` : "to stand");
const place = ({ x, y }) => `${x.toFixed(2)}, ${y.toFixed(2)} m`;

export class RobotPanel {
  constructor(box, page) {
    this.page = page;
    this.buttons = page.match.robots.map((robot, index) => {
      const button = el("button", { type: "button", "aria-pressed": "false", "aria-label": robot.id, data: { team: robot.team } }, String(robot.number));
      button.addEventListener("click", () => page.choose(page.robot === index ? null : index));
      return button;
    });
    const isThere = ([, , fields]) => fields.some((field) => page.match.has(field));
    this.checks = SHOWN.filter(isThere).map(([name, words]) => {
      const check = el("input", { type: "checkbox", checked: true });
      check.addEventListener("change", () => {
        page.shows[name] = check.checked;
        page.redraw();
      });
      return el("label", { className: "check", data: { shows: name } }, check, el("i", { "aria-hidden": "true" }), words);
    });
    this.cameras = el("select", { "aria-label": "Camera" });
    this.cameras.addEventListener("change", () => {
      page.camera = Number(this.cameras.value);
      page.redraw();
    });
    this.facts = el("dl", { className: "facts" });
    this.reasons = el("div", { className: "reasons" });
    this.hint = el("p", { className: "hint" }, "Choose a robot here, or on the pitch: the page then shows what it saw, what it believed, what it wanted, and its own view.");
    this.rest = el("div", { hidden: true }, el("div", { className: "checks" }, ...this.checks), el("label", { className: "camera" }, "Camera ", this.cameras), this.facts, this.reasons);
    box.append(el("div", { className: "choose", role: "group", "aria-label": "Robots" }, ...this.buttons), this.hint, this.rest);
  }

  choose(index) {
    this.buttons.forEach((button, other) => button.setAttribute("aria-pressed", other === index));
    this.hint.hidden = index !== null;
    this.rest.hidden = index === null;
    if (index === null) return;
    const { cameras } = this.page.match.robots[index];
    this.cameras.replaceChildren(...cameras.map(({ name }, camera) => el("option", { value: camera }, name)));
    this.cameras.parentElement.hidden = cameras.length < 2;
  }

  show(at, timeS) {
    const { match, robot: index } = this.page;
    if (index === null || this.rest.closest("[hidden]")) return;
    const robot = match.robots[index];
    const now = match.robot(index, at);
    const mind = match.mind(index, timeS);
    // Beliefs are about the instant at which the robot sensed: the end of the cycle before.
    const sensed = match.at(Math.max(match.startS, (mind?.timeS ?? timeS) - match.cycleS));
    const [was, ball] = [match.robot(index, sensed), match.ball(sensed)];
    const rows = [["robot", `${robot.id}, ${robot.model}`]];
    rows.push(["is at", `${place(now)}, ${degrees(now.heading)}°`]);
    if (now.isPenalised) rows.push(["serves", "a penalty"]);
    if (now.posture) rows.push(["posture", POSTURES[now.posture] ?? ""]);
    if (mind?.pose) rows.push(["believes to be at", `${place(mind.pose)}: ${cm(Math.hypot(mind.pose.x - was.x, mind.pose.y - was.y))} off`]);
    if (mind?.ball) rows.push(["believes the ball at", `${place(mind.ball)}${ball ? `: ${cm(Math.hypot(mind.ball.x - ball.x, mind.ball.y - ball.y))} off` : ""}${mind.ball.isHeard ? ", as a team-mate told" : ""}`]);
    else if (mind?.pose) rows.push(["believes the ball", "lost"]);
    if (mind && match.has("robots.percepts")) {
      const counts = new Map(mind.seenBall ? [["ball", 1]] : []);
      for (const { kind } of mind.things) counts.set(KINDS[kind], (counts.get(KINDS[kind]) ?? 0) + 1);
      rows.push(["sees", [...counts].map(([name, count]) => (count > 1 ? `${count} x ${name}` : name)).join(", ") || "nothing that it knows"]);
    }
    const wish = mind && (mind.target?.words || mind.intention);
    const walk = mind && match.has("robots.command") ? inWords(mind.walk) : "";
    if (wish || walk) rows.push(["wants", [wish, walk].filter(Boolean).join(": ")]);
    const words = JSON.stringify(rows);
    if (words !== this.words) this.facts.replaceChildren(...rows.flatMap(([name, value]) => [el("dt", {}, name), el("dd", {}, value)]));
    this.words = words;
    this.why(mind?.options ?? []);
  }

  why(options) {
    const words = JSON.stringify(options);
    if (words === this.said) return;
    this.said = words;
    const rows = options.map(({ name, value, why, isChosen }) => el("li", isChosen ? { className: "chosen" } : {}, el("b", {}, name), ` ${value}`, el("span", {}, why)));
    this.reasons.replaceChildren(...(rows.length ? [el("h3", {}, "Why"), el("ul", {}, ...rows)] : []));
  }
}
