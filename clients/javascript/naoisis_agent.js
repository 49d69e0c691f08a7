// Plays a robot of a naoisis match: needs Node.js and nothing else.
//
//     const { play } = require("./naoisis_agent.js");
//     play((perception) => ({ walk: [0.006, 0, perception.percepts.ball?.position_m[1] > 0 ? 3 : -3] }), "my team");
//
//     $ naoisis run match3v3 --blue "exec:node my_team.js"
//
// `decide` receives the perception of the robot in a cycle, as in a trace, and returns a command with the names of a
// trace's `command`, or a whole answer, which has a `command` and what the program thinks: `belief`, `intention`, `reasons`,
// `drawings` and `values`. It also receives the belief of the built-in estimator, if the program asks for it in `hello`, and the
// welcome, which describes the match. Standard output belongs to the match: console.log writes to standard error here.
"use strict";

const { Console } = require("console");
const readline = require("readline");

// Plays until the match is over. Resolves to its end and score, or to undefined if the match was broken off. `decide` receives
// only the named fields of perceptions, such as "percepts.ball" or "game.state"; all, if none are named. `hello` has what else the
// program asks for, such as `{ belief: true }`.
async function play(decide, name = "", fields = [], hello = {}) {
  globalThis.console = new Console(process.stderr);
  const send = (message) => process.stdout.write(JSON.stringify(message) + "\n");
  send({ hello: { protocol: 1, name, fields, ...hello } });
  let welcome;
  for await (const line of readline.createInterface({ input: process.stdin })) {
    const message = JSON.parse(line);
    if (message.end) return message.end;
    // In a cycle, `refused` has the commands of the robot that were refused.
    if (message.refused && message.cycle === undefined) throw new Error(message.refused.reason);
    welcome ??= message.welcome;
    if (message.cycle === undefined) continue;
    const answer = decide(message.perception, message.belief, welcome) ?? {};
    send({ cycle: message.cycle, ...(answer.command ? answer : { command: answer }) });
  }
  return undefined;
}

module.exports = { play };
