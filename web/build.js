// Builds the page without a match: `npm run build`, or `node build.js FILE` to write it somewhere else.
//
// The program is compressed, as the match is: a short loader unpacks it and adds it as an inline script. The content
// security policy names both scripts and the style by their hashes, so the page runs nothing else and loads nothing.
import { createHash } from "node:crypto";
import { readFileSync, writeFileSync } from "node:fs";
import { build, transform } from "esbuild";
import { zlibSync } from "fflate";

const here = (path) => new URL(path, import.meta.url);
const target = process.argv[2] ?? here("../crates/naoisis_record/src/record/page/page.html");
const hash = (text) => `'sha256-${createHash("sha256").update(text).digest("base64")}'`;
const small = async (path, loader) => {
  const { code } = await transform(readFileSync(here(path), "utf8"), { loader, minify: true });
  return code.trim();
};

const bundle = await build({
  entryPoints: [here("src/main.js").pathname],
  bundle: true,
  minify: true,
  write: false,
  format: "iife",
  target: "es2022",
  legalComments: "eof",
});
const program = bundle.outputFiles[0].text.trim();
const packed = Buffer.from(zlibSync(Buffer.from(program), { level: 9 })).toString("base64");
const loader = await small("src/loader.js", "js");
const style = await small("src/style.css", "css");
const policy = [
  "default-src 'none'",
  `script-src ${hash(loader)} ${hash(program)}`,
  `style-src ${hash(style)}`,
  "img-src data:",
  "base-uri 'none'",
  "form-action 'none'",
].join("; ");
const parts = { policy, style, loader, program: packed };
const page = readFileSync(here("src/page.html"), "utf8").replace(/\{\{(\w+)\}\}/g, (_, name) => parts[name]);
writeFileSync(target, page);
console.log(`${program.length} bytes of program, ${page.length} bytes of page`);
