// The shape of a robot, and how it stands: boxes, balls and rods by the measures of its body.
import { CapsuleGeometry, Color, Euler, Matrix4, Quaternion, SRGBColorSpace, Vector3 } from "three";

const rgb = ([red, green, blue]) => new Color().setRGB(red / 255, green / 255, blue / 255, SRGBColorSpace);

/** Where a robot stands, or lies. */
export function stance({ x, y, heading, posture }) {
  const matrix = new Matrix4().makeRotationZ(heading).setPosition(x, y, 0);
  const [pitch, roll] = [[0, 0], [1.5, 0], [-1.5, 0], [0.8, 0], [0, 1.2]][posture] ?? [0, 0];
  if (pitch || roll) matrix.multiply(new Matrix4().makeRotationFromEuler(new Euler(roll, pitch, 0)).setPosition(0, 0, 0.08));
  return matrix;
}

/** The colours of jerseys; one without a colour here is in the team's. */
const JERSEYS = {
  blue: 0x143cc8, red: 0xc8191e, yellow: 0xf0cd1e, black: 0x19191c, white: 0xeeeeee, green: 0x19963c, orange: 0xf57814, purple: 0x6e2896,
  brown: 0x6e4628, grey: 0x7d7d80,
};

/** The parts of a robot, by the measures of its body: a trunk, a head, legs and arms if it has any. */
export function* partsOf(body, robot, teamColour) {
  const { torso, base, look, legs, arms, neck_m: neck, height_m: height, foot_y_m: footY } = body;
  const [shell, joints, eyes, team] = [rgb(look.shell), rgb(look.joints), rgb(look.eyes), new Color(JERSEYS[body.jersey] ?? teamColour)];
  const of = (limb) => (look.team_limbs?.includes?.(limb) ? team : shell);
  const width = arms ? 1.5 * arms.shoulder_m[1] : 2 * torso.half_width_m;
  const depth = torso.x_m[1] - torso.x_m[0];
  const middle = (torso.x_m[0] + torso.x_m[1]) / 2;
  const hip = legs ? legs.hip_m[2] : torso.z_m[0];
  const chest = [hip + 0.28 * (neck[2] - hip), neck[2] - 0.02];
  const swing = 0.35 * Math.sin(robot.stride ?? 0) * (robot.pace ?? 0);
  // The jersey, with light plates on chest and back.
  yield { shape: "box", size: [depth * 1.15, width, chest[1] - chest[0]], at: [middle, 0, (chest[0] + chest[1]) / 2], colour: team };
  yield { shape: "box", size: [depth * 1.05, width * 0.86, 0.42 * (neck[2] - hip)], at: [middle, 0, hip + 0.2 * (neck[2] - hip)], colour: shell };
  yield { shape: "box", size: [depth * 1.3, width * 0.42, 0.3 * (chest[1] - chest[0])], at: [middle, 0, chest[0] + 0.62 * (chest[1] - chest[0])], colour: shell };
  const headTurn = new Euler(0, robot.pitch, robot.yaw, "ZYX");
  const tall = height - neck[2];
  const around = (x, y, z) => new Vector3(x, y, z).applyEuler(headTurn).add(new Vector3(...neck)).toArray();
  if (body.head === "mast" || look.head === "mast") {
    yield { shape: "rod", size: [0.03, 0.03, tall], at: around(0, 0, tall / 2), turn: headTurn, colour: joints };
    yield { shape: "box", size: [0.06, 0.12, 0.05], at: around(0.02, 0, tall - 0.03), turn: headTurn, colour: of("head") };
  } else {
    yield { shape: "ball", size: [tall * 1.12, tall * 1.25, tall * 1.08], at: around(0.005, 0, tall * 0.48), turn: headTurn, colour: of("head") };
    for (const side of [-1, 1]) {
      yield { shape: "ball", size: [0.02, 0.2 * tall, 0.2 * tall], at: around(tall * 0.5, side * tall * 0.24, tall * 0.55), turn: headTurn, colour: eyes };
      yield { shape: "rod", size: [0.4 * tall, 0.4 * tall, 0.1 * tall], at: around(0, side * tall * 0.62, tall * 0.5), turn: new Euler(Math.PI / 2 + robot.pitch * 0, 0, robot.yaw, "ZYX"), colour: joints };
    }
  }
  for (const side of [-1, 1]) {
    const step = swing * side;
    if (legs) {
      const y = side * footY;
      const length = legs.thigh_m + legs.shank_m;
      const thick = 0.36 * Math.max(0.1, 2 * Math.abs(footY));
      const bend = 0.22;
      const knee = [legs.thigh_m * Math.sin(step + bend), y, hip - legs.thigh_m * Math.cos(step + bend)];
      const ankle = [knee[0] + legs.shank_m * Math.sin(step - bend), y, Math.max(0.04, knee[2] - legs.shank_m * Math.cos(step - bend))];
      yield bone([0, y, hip], knee, 1.15 * thick, of("legs"));
      yield bone(knee, ankle, thick, of("legs"));
      yield { shape: "ball", size: [1.15 * thick, 1.15 * thick, 1.15 * thick], at: knee, colour: joints };
      const foot = base.x_m[1] - base.x_m[0];
      yield { shape: "box", size: [foot, 0.85 * 2 * Math.min(Math.abs(footY), base.half_width_m / 2), 0.16 * length + 0.015], at: [ankle[0] + (base.x_m[0] + base.x_m[1]) / 2, y * 1.02, ankle[2] - 0.02 + Math.max(0, step) * 0.03], colour: of("legs") };
    } else {
      yield { shape: "box", size: [base.x_m[1] - base.x_m[0], base.half_width_m * 0.9, base.z_m[1] - base.z_m[0]], at: [(base.x_m[0] + base.x_m[1]) / 2, (side * base.half_width_m) / 2, (base.z_m[0] + base.z_m[1]) / 2], colour: joints };
    }
    if (arms) {
      const [x, y, z] = arms.shoulder_m;
      const thick = 0.17 * arms.length_m + 0.025;
      const elbow = [x - 0.35 * arms.length_m * Math.sin(0.3 + step), side * (y + 0.035), z - 0.5 * arms.length_m];
      const hand = [elbow[0] + 0.5 * arms.length_m * Math.cos(0.55 - step), side * (y + 0.015), elbow[2] - 0.22 * arms.length_m];
      yield { shape: "ball", size: [1.5 * thick, 1.4 * thick, 1.5 * thick], at: [x, side * y, z], colour: joints };
      yield bone([x, side * (y + 0.01), z], elbow, thick, of("arms"));
      yield bone(elbow, hand, 0.9 * thick, of("arms"));
    }
  }
}

/** A limb between two places. */
function bone(from, to, thick, colour) {
  const [start, end] = [new Vector3(...from), new Vector3(...to)];
  const middle = start.clone().lerp(end, 0.5);
  const way = end.sub(start);
  const length = way.length();
  const turn = new Euler().setFromQuaternion(new Quaternion().setFromUnitVectors(new Vector3(0, 0, 1), way.normalize()));
  return { shape: "rod", size: [thick, thick, length + thick * 0.5], at: middle.toArray(), turn, colour };
}

export const limb = () => new CapsuleGeometry(0.5, 0.35, 6, 16).scale(1, 1 / 1.35, 1).rotateX(Math.PI / 2);
export const rad = (degrees) => ((degrees ?? 0) * Math.PI) / 180;
