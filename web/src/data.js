// The match, unpacked: columns of whole numbers, one a quantity, and how they are looked up by time.
// The other side, with the format in words, is crates/naoisis_record/src/record/page.

import { minutes } from "./dom.js";

export const STATES = ["initial", "standby", "ready", "set", "playing", "timeout", "finished"];
export const POSTURES = ["upright", "lies on its front", "lies on its back", "gets up", "dives"];
/** What a robot saw: the last kinds are landmarks. */
export const KINDS = ["goal post", "blue robot", "pink robot", "robot", "line", "junction", "penalty mark", "centre circle", "corner arc"];
const LINE = 4;

/** The match in the blocks of the page, and what is wrong with it in `notes`. Throws an error in words if there is none. */
export async function readMatch(blocks) {
  const match = { columns: new Map(), strings: [""], events: [], reasons: [], kicks: [], notes: [], warnings: [], gaps: [], head: null, end: null };
  // The number of the last part that was read, and whether a block was not.
  let [parts, isDamaged] = [0, false];
  for (const [index, block] of blocks.entries()) {
    const text = block.textContent.trim();
    // Whole blocks end with a full stop.
    const isWhole = text.endsWith(".");
    let read;
    try {
      read = await unpack(isWhole ? text.slice(0, -1) : text);
    } catch {
      if (index === 0) throw new Error("The match in this page is damaged: its first part cannot be read.");
      if (!isWhole) match.warnings.push("The page breaks off here: the program that wrote it was stopped.");
      isDamaged ||= isWhole;
      continue;
    }
    const { json, columns } = read;
    if (json.match) match.head = json;
    else if (json.end) match.end = json;
    else if (json.part) {
      if (json.part !== parts + 1) match.gaps.push([match.columns.get("cycle")?.at(-1) ?? 0, columns.get("cycle")[0]]);
      [parts, isDamaged] = [json.part, false];
      addPart(match, json, columns);
    }
  }
  const at = (cycle) => minutes(cycle * match.head.cycle_s);
  for (const [from, to] of match.gaps) match.warnings.push(`A part of the match is damaged and left out: ${at(from)} to ${at(to)}.`);
  if (isDamaged || (match.end && match.end.parts !== parts)) match.warnings.push("The end of the match is damaged and left out.");
  if (!match.head) throw new Error("There is no match in this page.");
  if (!match.columns.get("cycle")) throw new Error("This page has a match, but nothing of it was played.");
  if (!match.end && !match.warnings.length) match.warnings.push("The page has no end: the program that wrote it was stopped, or the match was still going on.");
  if (match.head.fields?.length) match.notes.push(`The match was recorded with these fields only: ${match.head.fields.join(", ")}.`);
  return new Match(match);
}

async function unpack(text) {
  const bytes = Uint8Array.from(atob(text.trim()), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  const raw = new Uint8Array(await new Response(stream).arrayBuffer());
  const length = new DataView(raw.buffer).getUint32(0, true);
  const json = JSON.parse(new TextDecoder().decode(raw.subarray(4, 4 + length)));
  const columns = new Map();
  let at = 4 + length;
  for (const [name, size, isPlain] of json.columns ?? []) {
    columns.set(name, column(raw.subarray(at, at + size), isPlain));
    at += size;
  }
  if (at !== raw.length) throw new Error("a column is cut off");
  return { json, columns };
}

/** Zigzag numbers of seven bits a byte; differences from the number before, unless they are plain. */
function column(bytes, isPlain) {
  const values = [];
  let [value, shift, last] = [0, 0, 0];
  for (const byte of bytes) {
    value |= (byte & 127) << shift;
    shift += 7;
    if (byte < 128) {
      const number = (value >>> 1) ^ -(value & 1);
      last = isPlain ? number : last + number;
      values.push(last);
      [value, shift] = [0, 0];
    }
  }
  return values;
}

function addPart(match, json, columns) {
  for (const [name, values] of columns) {
    const all = match.columns.get(name) ?? [];
    for (const value of values) all.push(value);
    match.columns.set(name, all);
  }
  // A damaged part before this one may have had texts.
  match.strings.length = json.first_string ?? match.strings.length;
  for (const name of ["strings", "events", "reasons", "kicks"]) match[name].push(...(json[name] ?? []));
  if (json.left_out && !match.notes.includes(json.left_out)) match.notes.push(json.left_out);
}

/** Half axes of 95 % are kept as logarithms, in cm. */
const axis = (step) => 0.01 * Math.exp(0.15 * step);

class Match {
  constructor({ columns, strings, events, reasons, kicks, notes, warnings, gaps, head, end }) {
    const typed = new Map([...columns].map(([name, values]) => [name, Int32Array.from(values)]));
    this.get = (name) => typed.get(name) ?? new Int32Array(0);
    Object.assign(this, { strings, notes: [...warnings, ...notes], warnings, head, end, kicks });
    this.gaps = gaps.map((gap) => gap.map((cycle) => cycle * head.cycle_s));
    this.cycleS = head.cycle_s;
    this.cycles = this.get("cycle");
    this.senses = this.get("sense");
    this.startS = this.cycles[0] * this.cycleS;
    this.endS = this.cycles.at(-1) * this.cycleS;
    // Without the angles of the head it is not known where the cameras look.
    const cameras = (robot) => (this.has("robots.head_deg") ? robot.cameras : []);
    this.robots = head.robots.map((robot, index) => ({ ...robot, cameras: cameras(robot), index, team: robot.id.startsWith("pink") ? "pink" : "blue", number: Number(robot.id.replace(/\D/g, "")) }));
    this.events = events.map(([cycle, kind, words, about, place, why]) => {
      const robot = this.robots.find((robot) => robot.id === about);
      return { timeS: cycle * this.cycleS, kind, words, robot, team: robot?.team ?? about, place, why };
    });
    this.reasons = this.robots.map(({ index }) => reasons.filter((entry) => entry[1] === index));
    // Where the lists of each robot begin, sample by sample.
    this.starts = this.robots.map(({ id }) => Object.fromEntries(["b", "o", "m", "p", "v", "t", "l", "g"].map((name) => [name, starts(this.get(`${id}.${name}`), name)])));
    this.lines = this.robots.map(({ id }) => starts(this.get(`${id}.lk`).map((kind) => Number(kind === LINE)), "l"));
  }

  /** Whether a field, or a part of it, was recorded. */
  has(field) {
    const names = this.head.fields ?? [];
    return !names.length || names.some((name) => name === field || field.startsWith(`${name}.`) || name.startsWith(`${field}.`));
  }

  /** The sample of the truth at a time, and how far it is to the next, 0 to 1. */
  at(timeS) {
    const cycle = timeS / this.cycleS;
    const index = before(this.cycles, cycle);
    const next = Math.min(index + 1, this.cycles.length - 1);
    const span = this.cycles[next] - this.cycles[index];
    return { index, next, share: span ? Math.min(1, (cycle - this.cycles[index]) / span) : 0 };
  }

  /** Whether the match at a time is in a damaged part of the page. */
  isLost(timeS) {
    return this.gaps.some(([from, to]) => timeS > from + 1e-6 && timeS < to - 1e-6);
  }

  timeOf(index) {
    return this.cycles[index] * this.cycleS;
  }

  /** A quantity between two samples; what was carried is not slid. */
  between(name, { index, next, share }, unit, most = Infinity) {
    const values = this.get(name);
    const step = values[next] - values[index];
    return (values[index] + (Math.abs(step) * unit > most ? 0 : step * share)) * unit;
  }

  ball(at) {
    if (!this.get("ball.in")[at.index]) return null;
    return this.place("ball", at);
  }

  /** The balls beside the first, in a training with several. */
  moreBalls(at) {
    const places = [];
    for (let number = 2; this.get(`ball${number}.x`).length; number += 1) places.push(this.place(`ball${number}`, at));
    return places;
  }

  place(ball, at) {
    const [x, y, z] = ["x", "y", "z"].map((name) => this.between(`${ball}.${name}`, at, 0.005, 0.6));
    return { x, y, z };
  }

  robot(index, at) {
    const { id } = this.robots[index];
    const [x, y] = ["x", "y"].map((name) => this.between(`${id}.${name}`, at, 0.005, 0.3));
    const heading = radians(this.between(`${id}.h`, at, 0.5, 45));
    const [yaw, pitch] = ["yaw", "pitch"].map((name) => radians(this.between(`${id}.${name}`, at, 2, 90)));
    const status = this.get(`${id}.s`)[at.index];
    return { x, y, heading, yaw, pitch, posture: status & 7, isPenalised: status >= 8 };
  }

  /** The state of the game at a time; undefined where the match was recorded without it. */
  game(at) {
    const of = (name) => this.get(name)[at.index];
    const seconds = (name) => (of(name) === undefined ? undefined : of(name) < 0 ? null : of(name) / 10);
    // The team that shoots in the lowest two bits, then the goals of both in six each.
    const shots = of("shots");
    const shootOut = shots ? { team: (shots & 3) === 2 ? "pink" : "blue", blue: (shots >> 2) & 63, pink: (shots >> 8) & 63 } : null;
    return { shootOut, state: STATES[of("state")], half: of("half"), blue: of("blue"), pink: of("pink"), leftS: seconds("left"), secondS: seconds("second"), blueEnd: of("blue_end") };
  }

  /** What a robot believed, saw and wanted at a time; places in the pitch frame. */
  mind(index, timeS) {
    const { id } = this.robots[index];
    const at = before(this.senses, timeS / this.cycleS + 0.01);
    if (at < 0 || !this.senses.length) return null;
    const of = (name, row) => this.get(`${id}.${name}`)[row];
    const rows = (name) => {
      let sample = at;
      // A list that was left out is that of the sample before.
      while (sample > 0 && of(name, sample) < 0) sample -= 1;
      const [from, to] = [sample, sample + 1].map((sample) => this.starts[index][name][sample]);
      return Array.from({ length: to - from }, (_, row) => from + row);
    };
    const ellipse = (name, row) => ({ a: axis(of(`${name}a`, row)), b: axis(of(`${name}b`, row)), turn: radians(15 * of(`${name}c`, row)) });
    const mind = { timeS: this.senses[at] * this.cycleS, mates: [], opponents: [], things: [], words: "" };
    for (const row of rows("b")) mind.pose = { x: of("bx", row) * 0.005, y: of("by", row) * 0.005, heading: radians(of("bh", row) / 2), ellipse: ellipse("b", row) };
    for (const row of rows("o")) mind.ball = { x: of("ox", row) * 0.02, y: of("oy", row) * 0.02, isHeard: of("o", at) === 2, ellipse: ellipse("o", row) };
    for (const row of rows("m")) mind.mates.push({ x: of("mx", row) * 0.05, y: of("my", row) * 0.05, ellipse: ellipse("m", row) });
    for (const row of rows("p")) mind.opponents.push({ x: of("px", row) * 0.05, y: of("py", row) * 0.05, ellipse: ellipse("p", row) });
    for (const row of rows("v")) mind.seenBall = { x: of("vx", row) * 0.02, y: of("vy", row) * 0.02 };
    for (const row of rows("t")) mind.things.push({ kind: of("tk", row), x: of("tx", row) * 0.08, y: of("ty", row) * 0.08 });
    for (const row of rows("l")) {
      const thing = { kind: of("lk", row), x: of("lx", row) * 0.08, y: of("ly", row) * 0.08 };
      const end = this.lines[index][row];
      if (thing.kind === LINE) Object.assign(thing, { endX: of("ex", end) * 0.08, endY: of("ey", end) * 0.08 });
      mind.things.push(thing);
    }
    for (const row of rows("g")) mind.target = { x: of("gx", row) * 0.02, y: of("gy", row) * 0.02, words: this.strings[of("g", at) - 1] ?? "" };
    mind.intention = this.strings[of("i", at)] ?? "";
    mind.walk = { x: of("wx", at) * 0.05, y: of("wy", at) * 0.05, turn: radians(10 * of("wt", at)) };
    const reasons = this.reasons[index];
    const [, , chosen, options] = reasons[before(reasons.map((entry) => entry[0]), timeS / this.cycleS)] ?? [];
    mind.options = (options ?? []).map(([name, value, why], option) => ({ name, value, why, isChosen: option === chosen }));
    return mind;
  }
}

/** Where the rows of each sample begin: flags count once, lists as often as they say. */
function starts(counts, name) {
  const isList = ["m", "p", "t", "l"].includes(name);
  const all = new Int32Array(counts.length + 1);
  for (const [index, count] of counts.entries()) all[index + 1] = all[index] + Math.max(0, isList ? count : Math.min(1, count));
  return all;
}

/** The last of the sorted values that is not after one; -1 if all are. */
export function before(values, value) {
  let [low, high] = [0, values.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (values[middle] <= value + 1e-6) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}

const radians = (degrees) => (degrees * Math.PI) / 180;
