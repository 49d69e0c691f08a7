// Puts markup into every string of a trace that a file or a program may choose: node hostile.js TRACE > HOSTILE
import { readFileSync } from "node:fs";

const EVIL = `</script><script>globalThis.hacked=1</script><img src=x onerror="globalThis.hacked=1">`;
const FREE = new Set(["name", "description", "intention", "payload", "words", "rule", "otherwise", "what", "why", "text", "message"]);
// Presets are named by what is free elsewhere.
const KEPT = new Set(["field", "rules", "mounts"]);

function spoil(value, key, parent) {
  if (typeof value === "string") return FREE.has(key) && !KEPT.has(parent) ? EVIL : value;
  if (Array.isArray(value)) return value.map((item) => spoil(item, key, parent));
  if (value && typeof value === "object") return Object.fromEntries(Object.entries(value).map(([name, item]) => [name, spoil(item, name, key)]));
  return value;
}

for (const line of readFileSync(process.argv[2], "utf8").split("\n").filter(Boolean)) console.log(JSON.stringify(spoil(JSON.parse(line), "", "")));
