// The page: it reads the match, and draws when the time, the view or the size has changed.
import { before, readMatch } from "./data.js";
import { Stage } from "./scene.js";
import { View } from "./view.js";
import { drawMind } from "./overlays.js";
import { minutes } from "./dom.js";
import { drawStrip, placeMarks } from "./timeline.js";
import { EventPanel } from "./events.js";
import { RobotPanel } from "./robots.js";
import { showMatch } from "./summary.js";

const $ = (id) => document.getElementById(id);
const isStill = matchMedia("(prefers-reduced-motion: reduce)");
const isDark = matchMedia("(prefers-color-scheme: dark)");
/** Important for the next and the previous event, and worth a mark. */
const LOUD = new Set(["goal", "goal_disallowed", "penalty", "caution", "timeout", "half_begins", "final_whistle", "shot", "shoot_out_begins"]);

function fault(words) {
  $("fault").textContent = words;
  document.body.dataset.state = "fault";
}

class Page {
  constructor(match) {
    this.match = match;
    this.timeS = match.startS;
    this.speed = 1;
    this.isPlaying = false;
    this.robot = null;
    this.camera = 0;
    this.shows = { belief: true, sight: true, wish: true };
    this.isLoud = (event) => LOUD.has(event.kind.split(" ")[0]);
    this.name();
    this.events = new EventPanel($("events"), this);
    this.robots = new RobotPanel($("robot"), this);
    showMatch($("match"), match);
    this.tabs();
    this.controls();
    try {
      this.stage = new Stage($("canvas"), match);
      this.view = new View($("canvas"), this.stage, () => this.redraw(), (index) => this.choose(index === this.robot ? null : index));
    } catch {
      $("caption").textContent = "This browser draws no 3-D here (WebGL is off); events, robots and the summary are beside.";
    }
    addEventListener("keydown", (event) => this.key(event));
    addEventListener("hashchange", () => this.follow(location.hash));
    new ResizeObserver(() => this.resize()).observe($("stage"));
    isDark.addEventListener("change", () => this.resize());
    this.isLost = false;
    if (match.warnings.length) this.say(match.warnings.join(" "));
    this.follow(location.hash);
    document.body.dataset.state = "ready";
    this.resize();
  }

  name() {
    const { head, end, notes } = this.match;
    const [blue, pink] = head.teams ?? ["blue", "pink"];
    $("blue-name").textContent = blue;
    $("pink-name").textContent = pink;
    const title = `${head.name || "A match"}: ${blue} against ${pink}`;
    $("title").textContent = title;
    document.title = title;
    if (end) document.title += `, ${end.score.blue} : ${end.score.pink}`;
    this.notes = notes;
  }

  controls() {
    const { startS, endS } = this.match;
    Object.assign($("seek"), { min: startS, max: endS, step: this.match.cycleS });
    $("seek").addEventListener("input", () => this.seek(Number($("seek").value)));
    $("play").addEventListener("click", () => this.play(!this.isPlaying));
    $("start").addEventListener("click", () => this.play(true));
    $("back").addEventListener("click", () => this.step(-1));
    $("forth").addEventListener("click", () => this.step(1));
    $("previous").addEventListener("click", () => this.jump(-1));
    $("next").addEventListener("click", () => this.jump(1));
    $("speed").addEventListener("change", () => (this.speed = Number($("speed").value)));
    $("link").addEventListener("click", () => this.link());
    for (const button of $("views").children) button.addEventListener("click", () => this.look(button.dataset.view));
    placeMarks($("marks"), this);
  }

  tabs() {
    const tabs = [...document.querySelectorAll("[role=tab]")];
    const show = (chosen) => {
      for (const tab of tabs) {
        const isChosen = tab === chosen;
        tab.setAttribute("aria-selected", isChosen);
        tab.tabIndex = isChosen ? 0 : -1;
        $(tab.getAttribute("aria-controls")).hidden = !isChosen;
      }
      this.redraw();
    };
    tabs.forEach((tab, index) => {
      tab.addEventListener("click", () => show(tab));
      tab.addEventListener("keydown", (event) => {
        const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
        if (!step) return;
        event.stopPropagation();
        const other = tabs[(index + step + tabs.length) % tabs.length];
        show(other);
        other.focus();
      });
    });
    this.showTab = (name) => show($(`tab-${name}`));
  }

  /** Goes where a link points: `#t=312.5&robot=blue2&view=above`. */
  follow(hash) {
    const wish = new URLSearchParams(hash.slice(1));
    const timeS = Number(wish.get("t"));
    if (wish.has("t") && Number.isFinite(timeS)) this.seek(timeS);
    const index = this.match.robots.findIndex((robot) => robot.id === wish.get("robot"));
    if (index >= 0) this.choose(index);
    if (wish.has("view")) this.look(wish.get("view"));
  }

  /** The link to what is shown. */
  hash() {
    const parts = [`t=${Number(this.timeS.toFixed(2))}`];
    if (this.robot !== null) parts.push(`robot=${this.match.robots[this.robot].id}`);
    if (this.view && this.view.mode !== "orbit") parts.push(`view=${this.view.mode}`);
    return `#${parts.join("&")}`;
  }

  async link() {
    const address = location.href.replace(/#.*/, "") + this.hash();
    try {
      history.replaceState(null, "", this.hash());
      await navigator.clipboard.writeText(address);
      this.say("The link to this moment is copied.");
    } catch {
      this.say(`The address bar has the link to this moment: ${this.hash()}`);
    }
  }

  say(words) {
    $("caption").textContent = words;
  }

  look(mode) {
    if (!this.view || !["orbit", "above", "eyes"].includes(mode)) return;
    if (mode === "eyes" && this.robot === null) this.choose(0);
    this.view.choose(mode);
    for (const button of $("views").children) button.setAttribute("aria-pressed", button.dataset.view === mode);
    this.redraw();
  }

  choose(index) {
    this.robot = index;
    this.camera = 0;
    if (index === null && this.view?.mode === "eyes") this.look("orbit");
    this.robots.choose(index);
    if (index !== null) this.showTab("robot");
    this.redraw();
  }

  play(isPlaying) {
    if (isPlaying && this.timeS >= this.match.endS - 1e-6) this.timeS = this.match.startS;
    this.isPlaying = isPlaying;
    document.body.dataset.playing = isPlaying;
    $("start").hidden = true;
    $("play").setAttribute("aria-label", isPlaying ? "Pause" : "Play");
    this.lastMs = null;
    this.redraw();
  }

  seek(timeS) {
    const { startS, endS } = this.match;
    this.timeS = Math.min(endS, Math.max(startS, timeS));
    if (timeS > startS) $("start").hidden = true;
    this.redraw();
  }

  step(cycles) {
    this.play(false);
    const { index } = this.match.at(this.timeS + 1e-6);
    const to = Math.min(this.match.cycles.length - 1, Math.max(0, index + cycles));
    this.seek(this.match.timeOf(to));
  }

  jump(step) {
    const loud = this.match.events.filter(this.isLoud);
    const event = step > 0 ? loud.find((event) => event.timeS > this.timeS + 0.05) : loud.findLast((event) => event.timeS < this.timeS - 0.05);
    if (event) this.goTo(event);
  }

  goTo(event) {
    this.seek(event.timeS);
    this.events.point(event);
    this.say(event.words);
  }

  key(event) {
    const isTyping = event.target.matches("select, input:not([type=range]), [role=tab]");
    if (event.ctrlKey || event.altKey || event.metaKey || isTyping) return;
    // The robot with that number: of the chosen robot's team, or of the other if it is chosen already.
    const chosen = this.match.robots[this.robot];
    const numbered = (team) => this.match.robots.find((robot) => robot.team === team && robot.number === Number(event.key));
    const teams = chosen?.team === "pink" ? ["pink", "blue"] : ["blue", "pink"];
    const next = teams.map(numbered).find((robot) => robot && robot !== chosen);
    const act = {
      " ": () => this.play(!this.isPlaying),
      ArrowLeft: () => this.seek(this.timeS - (event.shiftKey ? 10 : 1)),
      ArrowRight: () => this.seek(this.timeS + (event.shiftKey ? 10 : 1)),
      Home: () => this.seek(this.match.startS),
      End: () => this.seek(this.match.endS),
      ",": () => this.step(-1),
      ".": () => this.step(1),
      "[": () => this.jump(-1),
      "]": () => this.jump(1),
      a: () => this.look("above"),
      d: () => this.look("orbit"),
      e: () => this.look("eyes"),
      Escape: () => this.choose(null),
    }[event.key] ?? (next ? () => this.choose(next.index) : null);
    if (!act || (event.key === " " && event.target.matches("button, summary"))) return;
    event.preventDefault();
    act();
  }

  resize() {
    this.stage?.resize();
    drawStrip($("strip"), this.match);
    this.redraw();
  }

  /** Asks for one picture, soon. Nothing is drawn while nothing changes. */
  redraw() {
    this.frame ??= requestAnimationFrame((nowMs) => {
      this.frame = null;
      this.tick(nowMs);
    });
  }

  tick(nowMs) {
    if (this.isPlaying) {
      this.timeS += this.speed * Math.min(0.25, (nowMs - (this.lastMs ?? nowMs)) / 1000);
      this.lastMs = nowMs;
      if (this.timeS >= this.match.endS) {
        this.timeS = this.match.endS;
        this.play(false);
        if (!this.match.end) this.say(this.match.warnings.at(-1));
      }
    }
    this.show();
    const isGoing = this.stage && this.draw(isStill.matches);
    if (this.isPlaying || isGoing) this.redraw();
  }

  show() {
    const { match, timeS } = this;
    const at = match.at(timeS);
    const game = match.game(at);
    const score = game.blue === undefined ? "score not recorded" : `score ${game.blue} to ${game.pink}`;
    $("blue-score").textContent = game.blue ?? "–";
    $("pink-score").textContent = game.pink ?? "–";
    $("score").setAttribute("aria-label", score);
    const isLost = match.isLost(timeS);
    if (isLost !== this.isLost) this.say(isLost ? "This part of the match is damaged: what was before it is still shown." : "");
    this.isLost = isLost;
    $("clock").textContent = isLost || game.leftS === undefined ? "–" : minutes(game.leftS ?? timeS);
    const half = game.half && `half ${game.half}`;
    const second = (game.secondS ?? null) === null ? "" : ` ${Math.ceil(game.secondS)} s`;
    const way = game.blueEnd === undefined ? "" : `; blue plays ${game.blueEnd ? "←" : "→"}`;
    const shots = game.shootOut && `penalty shoot-out ${game.shootOut.blue} : ${game.shootOut.pink}${game.state === "finished" ? "" : `, ${game.shootOut.team} shoots`}`;
    $("phase").textContent = shots ? shots : game.state === "finished" ? "finished" : [half, game.state && game.state + second].filter(Boolean).join(", ") + way;
    $("time").textContent = minutes(timeS, 1);
    $("seek").value = timeS;
    $("seek").setAttribute("aria-valuetext", [minutes(timeS), half, score].filter(Boolean).join(", "));
    const share = (timeS - match.startS) / Math.max(1e-6, match.endS - match.startS);
    $("timeline").style.setProperty("--share", share);
    const last = match.events[before(match.events.map((event) => event.timeS), timeS)];
    if (this.isPlaying && last !== this.last && last && this.isLoud(last)) this.say(last.words);
    this.last = last;
    this.events.show(timeS);
    this.robots.show(at, timeS);
  }

  /** Returns whether the camera is still on its way. */
  draw(isStill) {
    const { match, stage, view, robot, timeS } = this;
    const at = match.at(timeS);
    const moment = { ball: match.ball(at), moreBalls: match.moreBalls(at), robots: match.robots.map((_, index) => this.walk(match.robot(index, at), index, timeS)) };
    const way = [];
    for (let age = 1.5; age >= 0; age -= 0.05) {
      const ball = match.ball(match.at(Math.max(match.startS, timeS - age)));
      const last = way.at(-1);
      if (last && ball && Math.hypot(ball.x - last.x, ball.y - last.y) > 0.6) way.length = 0;
      if (ball) way.push(ball);
    }
    stage.way(way);
    drawMind(stage, this, moment);
    const background = isDark.matches ? 0x10141b : 0xdfe6ee;
    const isGoing = view.settle(moment, isStill);
    const { width, height } = stage.size;
    const hasEyes = robot !== null && match.robots[robot].cameras.length > 0;
    const isEyes = view.mode === "eyes" && hasEyes;
    const eyes = (box) => {
      const mount = stage.lookOut(moment.robots[robot], match.robots[robot], this.camera, box[2] / box[3]);
      if (!mount) return;
      stage.place(moment, robot);
      stage.draw(stage.eyes, box, 0xabc7e3);
      Object.assign($("eyes-frame").style, { width: `${box[2]}px`, height: `${box[3]}px` });
      $("eyes-label").textContent = `${match.robots[robot].id} sees: ${mount.name}`;
    };
    $("eyes-frame").hidden = !hasEyes;
    $("eyes-frame").dataset.large = isEyes;
    if (isEyes) eyes([0, 0, width, height]);
    else {
      stage.place(moment);
      stage.draw(view.camera, [0, 0, width, height], background);
      if (hasEyes) {
        const wide = Math.round(Math.min(260, width * 0.32));
        eyes([12, 12, wide, Math.round(wide * 0.75)]);
      }
    }
    $("canvas").setAttribute("aria-label", this.inWords(moment));
    return isGoing;
  }

  /** A robot with the swing of its legs: by the way that it went. */
  walk(robot, index, timeS) {
    const from = this.match.robot(index, this.match.at(Math.max(this.match.startS, timeS - 0.3)));
    const pace = Math.min(1, (Math.hypot(robot.x - from.x, robot.y - from.y) + 0.1 * Math.abs(robot.heading - from.heading)) / 0.04);
    return { ...robot, pace, stride: timeS * 12 + index };
  }

  inWords({ ball, robots }) {
    const at = ({ x, y }) => `${x.toFixed(1)}, ${y.toFixed(1)}`;
    const there = robots.filter((robot) => !robot.isPenalised).length;
    return `The pitch. ${ball ? `The ball is at ${at(ball)} m from the centre.` : "There is no ball."} ${there} of ${robots.length} robots play.`;
  }
}

async function begin() {
  const blocks = [...document.querySelectorAll("script[type='application/octet-stream']:not([id])")];
  if (!blocks.length) return fault("There is no match in this page.");
  try {
    const match = await readMatch(blocks);
    globalThis.naoisisPage = new Page(match);
  } catch (error) {
    fault(error.message);
  }
}

begin();
