// The page in a headless Chromium. NAOISIS_PAGES is a folder that `.ci/web` fills: match.html and match.jsonl of one match,
// poses.html of a trace with few fields, shots.html of a shoot-out, and hostile.html. What the page looks like is left in test-results.
import assert from "node:assert/strict";
import { existsSync, mkdirSync, readdirSync, readFileSync, writeFileSync } from "node:fs";
import { join, resolve } from "node:path";
import { after, before, test } from "node:test";
import { pathToFileURL } from "node:url";
import { chromium } from "playwright-core";

const folder = process.env.NAOISIS_PAGES;
const shots = new URL("../test-results/", import.meta.url).pathname;
const executablePath = ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"].find(existsSync);
const cycles = readFileSync(join(folder, "match.jsonl"), "utf8").split("\n").filter(Boolean).map((line) => JSON.parse(line)).filter((line) => line.type === "cycle");
const minutes = (seconds) => `${Math.floor((seconds + 1e-4) / 60)}:${String(Math.floor(seconds + 1e-4) % 60).padStart(2, "0")}`;
let browser;

before(async () => {
  mkdirSync(shots, { recursive: true });
  browser = await chromium.launch({ executablePath, args: ["--no-sandbox"] });
});
after(() => browser.close());

/** Waits until what was changed so far is drawn: the page draws in the next frame, not at once. */
const frame = (page) => page.evaluate(() => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve))));

/** Opens a page, and fails the test if it asks for anything, or if anything in it fails. */
async function open(file, { hash = "", width = 1440, height = 900, ...options } = {}) {
  const context = await browser.newContext({ viewport: { width, height }, ...options });
  const page = await context.newPage();
  const faults = [];
  const address = pathToFileURL(resolve(folder, file)).href;
  page.on("pageerror", (error) => faults.push(error.message));
  page.on("console", (message) => message.type() === "error" && faults.push(message.text()));
  page.on("request", (request) => request.url().split("#")[0] !== address && !request.url().startsWith("data:") && faults.push(request.url()));
  await page.goto(address + hash);
  await page.waitForFunction(() => document.body.dataset.state !== "loading");
  return { page, text: (id) => frame(page).then(() => page.locator(`#${id}`).textContent()), state: () => page.evaluate(() => document.body.dataset.state), done: () => (assert.deepEqual(faults, []), context.close()) };
}

/** Goes to a time as a link does. */
async function goTo(page, timeS) {
  await page.evaluate((hash) => (location.hash = hash), `#t=${timeS}`);
  await page.waitForFunction((timeS) => Math.abs(Number(document.getElementById("seek").value) - timeS) < 0.05, timeS);
}

test("score and clock are those of the trace, in both halves", async () => {
  const { page, text, state, done } = await open("match.html");
  assert.equal(await state(), "ready");
  const goals = cycles.filter(({ events }) => events.some(({ kind }) => kind === "goal"));
  assert.ok(goals.length, "a match with a goal");
  assert.deepEqual([...new Set(cycles.map(({ game }) => game.half))], [1, 2]);
  // Before and after each goal, and through the match.
  const some = cycles.filter((_, index) => index % Math.ceil(cycles.length / 25) === 0);
  for (const line of [...goals, ...goals.map(({ cycle }) => cycles[cycle - 1]), ...some, cycles.at(-1)]) {
    await goTo(page, line.time_s);
    const { score, half } = line.game;
    assert.deepEqual([await text("blue-score"), await text("pink-score")], [String(score.blue), String(score.pink)], `at ${line.time_s} s`);
    // The page has the clock ten times a second.
    const clocks = [0, 1, 2, 3].map((before) => minutes(cycles[Math.max(0, line.cycle - before)].game.time_left_s));
    assert.ok(clocks.includes(await text("clock")), `${await text("clock")} at ${line.time_s} s instead of one of ${clocks}`);
    const phase = await text("phase");
    assert.ok(phase.startsWith("finished") || phase.startsWith(`half ${half}, ${line.game.state}`), phase);
  }
  await done();
});

test("what is drawn is where the trace says", async () => {
  const { page, done } = await open("match.html");
  for (const line of cycles.filter((_, index) => index % 400 === 7)) {
    const shown = await page.evaluate((timeS) => {
      const { match } = globalThis.naoisisPage;
      const at = match.at(timeS);
      return { ball: match.ball(at), robots: match.robots.map(({ id, index }) => ({ id, ...match.robot(index, at) })) };
    }, line.time_s);
    assert.ok(Math.hypot(shown.ball.x - line.ball.position_m[0], shown.ball.y - line.ball.position_m[1]) < 0.006);
    for (const [index, { id, pose, penalised }] of line.robots.entries()) {
      const robot = shown.robots[index];
      assert.deepEqual([robot.id, robot.isPenalised], [id, penalised !== null]);
      assert.ok(Math.hypot(robot.x - pose[0], robot.y - pose[1]) < 0.006, `${id} at ${line.time_s} s`);
      const turn = (robot.heading * 180) / Math.PI - pose[2];
      assert.ok(Math.abs(turn - 360 * Math.round(turn / 360)) < 0.3, `${id} turns ${turn}`);
    }
  }
  // What a robot believed: the team frame is turned for the team that defends +x.
  const line = cycles.find(({ cycle, robots }) => cycle % 3 === 0 && cycle > 300 && robots.every(({ belief }) => belief?.ball));
  const minds = await page.evaluate((timeS) => globalThis.naoisisPage.match.robots.map(({ index }) => globalThis.naoisisPage.match.mind(index, timeS)), line.time_s);
  for (const [index, { id, belief, percepts }] of line.robots.entries()) {
    const turn = id.startsWith("blue") === (line.game.blue_end === "negative_x") ? 1 : -1;
    const off = (place, [x, y]) => Math.hypot(place.x - turn * x, place.y - turn * y);
    assert.ok(off(minds[index].pose, belief.pose) < 0.006 && off(minds[index].ball, belief.ball.position_m) < 0.02, id);
    assert.equal(minds[index].opponents.length, belief.opponents.length);
    assert.equal(minds[index].things.length, percepts.goal_posts.length + percepts.robots.length + percepts.landmarks.length);
    assert.ok(minds[index].options.some(({ isChosen }) => isChosen), `${id} has reasons`);
  }
  await done();
});

test("it plays, seeks, steps and follows links and keys", async () => {
  const { page, text, done } = await open("match.html", { hash: "#t=12.5&robot=blue2&view=above" });
  const time = () => page.evaluate(() => globalThis.naoisisPage.timeS);
  assert.equal(await text("time"), "0:12.5");
  assert.equal(await page.getByRole("button", { name: "Above" }).getAttribute("aria-pressed"), "true");
  assert.equal(await page.getByRole("button", { name: "blue2" }).getAttribute("aria-pressed"), "true");
  assert.match(await page.locator(".facts").first().textContent(), /blue2, nao.*believes to be at/);
  await page.keyboard.press(".");
  assert.equal(Math.round((await time()) * 30), 376);
  await page.keyboard.press("ArrowRight");
  assert.equal(Math.round((await time()) * 30), 406);
  await page.getByLabel("Speed").selectOption("4");
  await page.getByRole("button", { name: "Play", exact: true }).click();
  await page.waitForFunction(() => globalThis.naoisisPage.timeS > 15);
  await page.getByRole("button", { name: "Pause" }).click();
  const held = await time();
  await page.waitForTimeout(300);
  assert.equal(await time(), held);
  // The next event, and its reasons.
  await page.getByRole("tab", { name: "Events" }).click();
  await page.locator(".events button[data-kind=goal]").first().click();
  await frame(page);
  assert.match(await page.locator(".why:visible").first().textContent(), /Rule: /);
  await page.getByRole("slider", { name: "Time of the match" }).focus();
  await page.keyboard.press("Home");
  assert.equal(await text("time"), "0:00.0");
  await page.keyboard.press("]");
  assert.ok((await time()) > 0);
  await done();
});

test("nothing is drawn while nothing changes", async () => {
  const { page, done } = await open("match.html", { hash: "#t=20" });
  const frames = () => page.evaluate(() => globalThis.naoisisPage.stage.renderer.info.render.frame);
  await page.waitForTimeout(2000);
  const drawn = await frames();
  await page.waitForTimeout(500);
  assert.equal(await frames(), drawn);
  assert.ok(drawn > 0);
  await page.keyboard.press("ArrowRight");
  await frame(page);
  assert.ok((await frames()) > drawn);
  await done();
});

test("every control has a name, and the tabs are tabs", async () => {
  const { page, done } = await open("match.html", { hash: "#t=30&robot=pink1" });
  const tree = await page.locator("body").ariaSnapshot();
  for (const part of ['heading "match3v3: ', 'img "The pitch. The ball is at', 'group "Score and clock"', 'slider "Time of the match"', 'combobox "Speed"', 'button "Play"', 'tab "Events"', 'tabpanel "Robots"', 'checkbox "What it sees"', 'combobox "Camera"', "status"]) {
    assert.ok(tree.includes(part), `${part} in\n${tree}`);
  }
  const nameless = await page.evaluate(() =>
    [...document.querySelectorAll("button, input, select, [role=img], [role=tabpanel]")]
      .filter((element) => !(element.ariaLabel || element.textContent.trim() || element.title || element.labels?.length || element.getAttribute("aria-labelledby")))
      .map((element) => element.outerHTML),
  );
  assert.deepEqual(nameless, []);
  await page.getByRole("tab", { name: "Robots" }).focus();
  await page.keyboard.press("ArrowRight");
  await frame(page);
  assert.equal(await page.getByRole("tab", { name: "Match" }).getAttribute("aria-selected"), "true");
  const score = cycles.at(-1).game.score;
  assert.match(await page.locator(".result").textContent(), new RegExp(`${score.blue} : ${score.pink}`));
  assert.ok((await page.locator("#match table").count()) >= 2 && (await page.locator("svg.plan").count()) >= 4);
  await done();
});

for (const [name, options] of Object.entries({
  "desktop-light": { hash: "#t=25&robot=blue2", colorScheme: "light" },
  "desktop-dark": { hash: "#t=25", colorScheme: "dark" },
  "desktop-above": { hash: "#t=25&robot=pink2&view=above", colorScheme: "dark" },
  "desktop-eyes": { hash: "#t=25&robot=blue3&view=eyes", colorScheme: "light" },
  "phone-light": { hash: "#t=25", width: 390, height: 844, hasTouch: true, isMobile: true, colorScheme: "light" },
  "phone-dark": { hash: "#t=25&robot=blue2", width: 390, height: 844, hasTouch: true, isMobile: true, colorScheme: "dark", reducedMotion: "reduce" },
})) {
  test(`it fits ${name}`, async () => {
    const { page, done } = await open("match.html", options);
    await page.waitForTimeout(1200);
    await page.screenshot({ path: `${shots}${name}.png` });
    const { scroll, width } = await page.evaluate(() => ({ scroll: document.documentElement.scrollWidth, width: innerWidth }));
    assert.ok(scroll <= width, `${scroll} of ${width} px`);
    // The pitch is drawn: its green is there.
    const green = await page.evaluate(() => {
      const { stage } = globalThis.naoisisPage;
      globalThis.naoisisPage.draw(true);
      const gl = stage.renderer.getContext();
      const pixels = new Uint8Array(4 * gl.drawingBufferWidth * gl.drawingBufferHeight);
      gl.readPixels(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
      let count = 0;
      for (let at = 0; at < pixels.length; at += 4) count += pixels[at + 1] > 1.5 * pixels[at] && pixels[at + 1] > 1.2 * pixels[at + 2];
      return (4 * count) / pixels.length;
    });
    assert.ok(green > 0.15, `${green}`);
    await done();
  });
}

test("the pages of the gallery play", async () => {
  const gallery = new URL("../../docs/gallery/", import.meta.url);
  const names = readdirSync(gallery).filter((name) => name.endsWith(".html") && name !== "index.html");
  assert.ok(names.length >= 6);
  for (const name of names) {
    const { page, state, text, done } = await open(new URL(name, gallery).pathname, { hash: "#t=60" });
    assert.equal(await state(), "ready", name);
    assert.equal(await text("time"), "1:00.0");
    await page.waitForTimeout(1500);
    await page.screenshot({ path: `${shots}gallery-${name}.png` });
    assert.match(readFileSync(new URL("README.md", gallery), "utf8"), new RegExp(`\\[${name}\\]`));
    await done();
  }
});

test("a hostile trace is text and nothing else", async () => {
  const { page, state } = await open("hostile.html", { hash: "#t=8&robot=blue2" });
  assert.equal(await state(), "ready");
  for (const name of ["Events", "Robots", "Match"]) await page.getByRole("tab", { name }).click();
  await page.getByRole("tab", { name: "Robots" }).click();
  const found = await page.evaluate(() => ({
    hacked: globalThis.hacked,
    images: document.images.length,
    scripts: [...document.scripts].filter((script) => !script.type).length,
    handlers: document.querySelectorAll("[onerror], [onload], iframe, object, embed").length,
    text: document.title + document.body.innerText,
  }));
  assert.deepEqual([found.hacked, found.images, found.scripts, found.handlers], [undefined, 0, 2, 0]);
  assert.ok(found.text.includes("<script>"), "it is shown as it is");
  // Nothing that gets in even so may run, or load.
  const ran = await page.evaluate(async () => {
    const script = document.createElement("script");
    script.textContent = "globalThis.hacked = 1";
    document.body.append(script);
    const asked = await fetch("https://naoisis.invalid/").then(() => true, () => false);
    return [globalThis.hacked, asked];
  });
  assert.deepEqual(ran, [undefined, false]);
  await page.context().close();
});

test("a page that is broken says so in words", async () => {
  const whole = readFileSync(join(folder, "match.html"), "latin1");
  const first = whole.indexOf('<script type="application/octet-stream">');
  const make = (name, text) => writeFileSync(join(folder, name), text, "latin1");
  make("empty.html", whole.slice(0, first));
  make("cut.html", whole.slice(0, whole.length - 40));
  make("first.html", `${whole.slice(0, first + 60)}!!!!${whole.slice(first + 64)}`);
  make("foreign.html", `${whole.slice(0, first)}<script type="application/octet-stream">AAAA</script>`);
  for (const [name, words] of [
    ["empty.html", /There is no match in this page/],
    ["first.html", /damaged: its first part cannot be read/],
    ["foreign.html", /damaged: its first part cannot be read/],
  ]) {
    const { state, text, done } = await open(name);
    assert.equal(await state(), "fault", name);
    assert.match(await text("fault"), words);
    await done();
  }
  // A single damaged letter in the middle of a part.
  const opening = '<script type="application/octet-stream">';
  const part = whole.indexOf(opening, whole.indexOf(opening, first + 1) + 1);
  const middle = part + 2000;
  make("letter.html", whole.slice(0, middle) + (whole[middle] === "A" ? "B" : "A") + whole.slice(middle + 1));
  make("missing.html", whole.slice(0, part) + whole.slice(whole.indexOf(opening, part + 1)));
  const end = whole.lastIndexOf(opening);
  make("short.html", whole.slice(0, whole.lastIndexOf(opening, end - 1)) + whole.slice(end));
  const last = whole.lastIndexOf('<script type="application/octet-stream">') + 100;
  make("last.html", whole.slice(0, last) + (whole[last] === "A" ? "B" : "A") + whole.slice(last + 1));
  for (const [name, words] of [
    ["cut.html", /breaks off here: the program that wrote it was stopped/],
    ["letter.html", /A part of the match is damaged and left out: \d+:\d\d to \d+:\d\d/],
    ["missing.html", /A part of the match is damaged and left out: \d+:\d\d to \d+:\d\d/],
    ["short.html", /The end of the match is damaged and left out/],
    ["last.html", /The end of the match is damaged and left out/],
  ]) {
    const { page, state, text, done } = await open(name, { hash: "#t=10" });
    assert.equal(await state(), "ready");
    assert.equal(await text("time"), "0:10.0");
    await page.getByRole("tab", { name: "Match" }).click();
    assert.match(await text("match"), words);
    await done();
  }
  // It is said at once, and in the gap.
  const { page, text, done } = await open("letter.html");
  assert.match(await text("caption"), /damaged and left out/);
  const gap = await page.evaluate(() => globalThis.naoisisPage.match.gaps[0]);
  await goTo(page, (gap[0] + gap[1]) / 2);
  assert.match(await text("caption"), /This part of the match is damaged/);
  assert.equal(await text("clock"), "–");
  await done();
});

test("a match that was recorded without its game has no score, and says so", async () => {
  const { page, text, state, done } = await open("poses.html", { hash: "#t=2" });
  assert.equal(await state(), "ready");
  assert.deepEqual([await text("blue-score"), await text("pink-score"), await text("clock"), await text("phase")], ["–", "–", "–", ""]);
  assert.match(await text("events"), /Events were not recorded/);
  assert.match(await text("title"), /roles against chasers/);
  await page.getByRole("tab", { name: "Match" }).click();
  assert.match(await text("match"), /recorded with these fields only: ball, robots\.pose/);
  // Nor does it say what robots saw, wanted, or where their heads looked.
  await page.getByRole("tab", { name: "Robots" }).click();
  await page.getByRole("button", { name: "blue2" }).click();
  const robot = await text("robot");
  assert.match(robot, /is at/);
  assert.doesNotMatch(robot, /sees|wants|Belief|What it/);
  assert.equal(await page.locator("#eyes-frame").isHidden(), true);
  await done();
});

test("a shoot-out has its own score and a winner", async () => {
  const { page, text, done } = await open("shots.html");
  const shots = await page.evaluate(() => globalThis.naoisisPage.match.events.filter(({ kind }) => kind.startsWith("shot")).map(({ timeS }) => timeS));
  assert.ok(shots.length >= 2);
  await goTo(page, shots[0] - 0.2);
  assert.match(await text("phase"), /^penalty shoot-out 0 : 0, (blue|pink) shoots$/);
  await page.getByRole("tab", { name: "Match" }).click();
  assert.match(await text("match"), /penalty shoot-out \d+ : \d+, won by (blue|pink)/);
  await done();
});
