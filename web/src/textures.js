// What is drawn once on small canvases: the carpet with its lines, the badges of robots, words, the ball.
import { CanvasTexture, SRGBColorSpace } from "three";

function texture(width, height, draw) {
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [width, height];
  draw(canvas.getContext("2d"), width, height);
  const made = new CanvasTexture(canvas);
  made.colorSpace = SRGBColorSpace;
  return made;
}

/** The lines of a pitch on a canvas whose units are metres: also for maps. */
export function chalk(context, pitch) {
  const [x, y] = [pitch.length_m / 2, pitch.width_m / 2];
  context.lineWidth = pitch.line_width_m;
  context.beginPath();
  context.rect(-x, -y, 2 * x, 2 * y);
  context.moveTo(0, -y);
  context.lineTo(0, y);
  for (const area of [pitch.penalty_area, pitch.goal_area].filter(Boolean)) {
    for (const left of [-x, x - area.depth_m]) context.rect(left, -area.width_m / 2, area.depth_m, area.width_m);
  }
  context.stroke();
  context.beginPath();
  context.arc(0, 0, pitch.centre_circle_diameter_m / 2, 0, 7);
  context.stroke();
  const corner = pitch.corner_arc_radius_m;
  if (corner > 0) {
    [[-x, -y, 0], [x, -y, 1], [x, y, 2], [-x, y, 3]].forEach(([left, top, quarter]) => {
      context.beginPath();
      context.arc(left, top, corner, (quarter * Math.PI) / 2, ((quarter + 1) * Math.PI) / 2);
      context.stroke();
    });
  }
  const mark = pitch.penalty_mark_size_m / 2;
  for (const at of [-x + pitch.penalty_mark_distance_m, x - pitch.penalty_mark_distance_m, 0]) {
    context.beginPath();
    context.moveTo(at - mark, 0);
    context.lineTo(at + mark, 0);
    if (at) {
      context.moveTo(at, -mark);
      context.lineTo(at, mark);
    }
    context.stroke();
  }
}

export function carpet(pitch, half) {
  const scale = 2048 / (2 * half.x);
  return texture(2048, Math.round(2 * half.y * scale), (context, width, height) => {
    context.fillStyle = "#25763c";
    context.fillRect(0, 0, width, height);
    context.translate(width / 2, height / 2);
    context.scale(scale, scale);
    const strips = 10;
    const wide = pitch.length_m / strips;
    context.fillStyle = "#2b8045";
    for (let strip = 0; strip < strips; strip += 2) context.fillRect(-pitch.length_m / 2 + strip * wide, -half.y, wide, 2 * half.y);
    context.strokeStyle = "#f0f3f0";
    chalk(context, pitch);
  });
}

/** A robot's number: blue in a disc, pink in a square, so that shape tells teams apart as well. */
export const badge = (team, number) =>
  texture(96, 96, (context) => {
    context.fillStyle = team === "blue" ? "#1f5fe0" : "#e03f83";
    context.strokeStyle = "#fff";
    context.lineWidth = 6;
    context.beginPath();
    if (team === "blue") context.arc(48, 48, 40, 0, 7);
    else context.roundRect(10, 10, 76, 76, 16);
    context.fill();
    context.stroke();
    context.fillStyle = "#fff";
    context.font = "700 52px system-ui, sans-serif";
    context.textAlign = "center";
    context.textBaseline = "middle";
    context.fillText(String(number), 48, 51);
  });

export const words = (text) =>
  texture(512, 96, (context) => {
    context.font = "600 46px system-ui, sans-serif";
    context.textAlign = "center";
    context.textBaseline = "middle";
    context.lineWidth = 10;
    context.lineJoin = "round";
    context.strokeStyle = "#0b0d12";
    context.strokeText(text.slice(0, 24), 256, 48);
    context.fillStyle = "#ffe14d";
    context.fillText(text.slice(0, 24), 256, 48);
  });

export const ballSkin = (isOrange) =>
  texture(256, 128, (context, width, height) => {
    context.fillStyle = isOrange ? "#ff7010" : "#f6f6f4";
    context.fillRect(0, 0, width, height);
    context.fillStyle = isOrange ? "#d95604" : "#24262b";
    for (const [x, y] of [[20, 64], [84, 38], [84, 96], [148, 64], [212, 38], [212, 96]]) {
      context.beginPath();
      context.ellipse(x, y, 15, 13, 0, 0, 7);
      context.fill();
    }
    for (const y of [0, height]) context.fillRect(0, y - 8, width, 16);
  });
