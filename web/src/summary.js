// The match in numbers: tables, heat maps, passes, and what the page has.
import { el, minutes, svg } from "./dom.js";

const metres = (value) => Number(value.toFixed(3));

export function showMatch(box, match) {
  const { head, end, notes } = match;
  const [blue, pink] = head.teams ?? ["blue", "pink"];
  const parts = [];
  if (end) {
    parts.push(el("p", { className: "result" }, el("span", { className: "blue" }, `${blue} ${end.score.blue}`), " : ", el("span", { className: "pink" }, `${end.score.pink} ${pink}`)));
    if (end.how) parts.push(el("p", { className: "hint" }, end.how));
    if (end.teams?.length) parts.push(table("Teams", ["", "blue", "pink"], end.teams));
  }
  if (match.kicks.length) parts.push(el("h3", {}, "Passes and shots"), passes(match));
  if (end?.heat) {
    parts.push(el("h3", {}, "Where they were"));
    parts.push(el("div", { className: "maps" }, ...end.heat.maps.map(([words, cells]) => heatMap(head.pitch, end.heat, words, cells))));
  }
  if (end?.robots?.length) parts.push(table("Robots", end.robot_columns ?? [], end.robots));
  const facts = [["scenario", head.name || "without a name"], ["seed", head.seed], ["realism", head.realism], ["pitch", `${metres(head.pitch.length_m)} x ${metres(head.pitch.width_m)} m`], ["played", `${minutes(match.endS - match.startS)} min`]];
  if (head.description) facts.unshift(["", head.description]);
  parts.push(el("h3", {}, "About"), el("dl", { className: "facts" }, ...facts.flatMap(([name, value]) => [el("dt", {}, name), el("dd", {}, String(value))])));
  const has = "Positions 30 times a second; what robots saw, believed and wanted 10 times a second; every event. Nothing is loaded from a network.";
  parts.push(el("ul", { className: "notes" }, ...[has, ...notes].map((words) => el("li", {}, words))));
  const keys = [["space", "play, pause"], ["← →", "1 s, with shift 10 s"], [", .", "one step"], ["[ ]", "event before, next event"], ["1 2 3 …", "choose a robot, again: the other team's"], ["esc", "choose none"], ["d a e", "3-D, above, eyes"]];
  parts.push(el("h3", {}, "Keys"), el("dl", { className: "facts" }, ...keys.flatMap(([key, words]) => [el("dt", {}, key), el("dd", {}, words)])));
  box.append(...parts);
}

function table(caption, columns, rows) {
  const head = el("thead", {}, el("tr", {}, ...columns.map((name) => el("th", { scope: "col" }, name))));
  const cells = (row) => row.map((cell, index) => el(index ? "td" : "th", index ? {} : { scope: "row" }, String(cell)));
  return el("div", { className: "wide" }, el("table", {}, el("caption", {}, caption), head, el("tbody", {}, ...rows.map((row) => el("tr", {}, ...cells(row))))));
}

/** A plan of the pitch, +y up, to draw on. */
function plan(pitch, label, ...marks) {
  const [x, y] = [pitch.length_m / 2, pitch.width_m / 2];
  const edge = 0.3;
  const lines = svg("g", { class: "lines", "stroke-width": pitch.line_width_m, fill: "none" });
  const rect = (left, top, width, height) => lines.append(svg("rect", { x: left, y: top, width, height }));
  rect(-x, -y, 2 * x, 2 * y);
  lines.append(svg("path", { d: `M0 ${-y}V${y}` }), svg("circle", { r: pitch.centre_circle_diameter_m / 2 }));
  for (const area of [pitch.penalty_area, pitch.goal_area].filter(Boolean)) for (const left of [-x, x - area.depth_m]) rect(left, -area.width_m / 2, area.depth_m, area.width_m);
  return svg("svg", { viewBox: `${-x - edge} ${-y - edge} ${2 * (x + edge)} ${2 * (y + edge)}`, role: "img", "aria-label": label, class: "plan" }, lines, ...marks);
}

function heatMap(pitch, { columns, rows }, words, cells) {
  const most = Math.max(1, ...cells);
  const [width, height] = [pitch.length_m / columns, pitch.width_m / rows];
  const rects = cells.flatMap((time, index) => {
    if (!time) return [];
    const [column, row] = [index % columns, Math.floor(index / columns)];
    // The eye tells shares of the longest time apart better by their roots.
    return svg("rect", { x: column * width - pitch.length_m / 2, y: pitch.width_m / 2 - (row + 1) * height, width: width * 1.02, height: height * 1.02, opacity: Math.sqrt(time / most).toFixed(3) });
  });
  return el("figure", {}, plan(pitch, `Heat map of ${words}`, svg("g", { class: `heat ${words === "blue" || words === "pink" ? words : ""}` }, ...rects)), el("figcaption", {}, words));
}

function passes(match) {
  const scale = match.head.pitch.line_width_m;
  const arrows = match.kicks.map(([, robot, fromX, fromY, toX, toY, what]) => {
    const team = robot.startsWith("pink") ? "pink" : "blue";
    return svg("g", { class: `kick ${team} ${what === "pass" ? "pass" : what.includes("target") || what === "shot" ? "shot" : "lost"}` }, svg("path", { d: `M${fromX} ${-fromY}L${toX} ${-toY}`, "stroke-width": scale }), svg("circle", { cx: toX, cy: -toY, r: 1.3 * scale }));
  });
  const count = (what) => match.kicks.filter((kick) => kick[6] === what).length;
  const words = `${count("pass")} passes arrived (drawn through), ${count("lost")} did not (thin), ${match.kicks.length - count("pass") - count("lost")} shots (dashed).`;
  return el("figure", {}, plan(match.head.pitch, words, ...arrows), el("figcaption", {}, words));
}
