// Flat marks of many kinds in few draw calls: what is believed, seen and wanted.
import { BufferAttribute, BufferGeometry, Color, DoubleSide, InstancedMesh, Matrix4, MeshBasicMaterial, Quaternion, Vector3 } from "three";

/** Layer 0 is the world; people alone see what is in this one. */
export const PEOPLE = 1;
const MOST_MARKS = 2048;

export const points = (places) => new BufferGeometry().setAttribute("position", new BufferAttribute(new Float32Array(places), 3));

/** Marks on the ground and above it: ellipses, rings, lines and dots, created for every frame. */
export class Marks {
  constructor(root) {
    const flat = (inner) => {
      const ring = [];
      for (let step = 0; step < 48; step++) {
        const [from, to] = [step, step + 1].map((at) => [Math.cos((at * Math.PI) / 24), Math.sin((at * Math.PI) / 24)]);
        ring.push(...[[from, inner], [from, 1], [to, 1], [from, inner], [to, 1], [to, inner]].flatMap(([[x, y], scale]) => [x * scale, y * scale, 0]));
      }
      return points(ring);
    };
    this.sets = {
      disc: this.set(flat(0), 0.22),
      ring: this.set(flat(0.86), 0.95),
      arrow: this.set(points([0.5, 0, 0, -0.4, 0.32, 0, -0.4, -0.32, 0]), 0.95),
      bar: this.set(points([0, -0.5, 0, 1, -0.5, 0, 1, 0.5, 0, 0, -0.5, 0, 1, 0.5, 0, 0, 0.5, 0]), 0.85),
    };
    root.add(...Object.values(this.sets));
  }

  set(geometry, opacity) {
    const mesh = new InstancedMesh(geometry, new MeshBasicMaterial({ transparent: true, opacity, side: DoubleSide, depthWrite: false }), MOST_MARKS);
    mesh.count = 0;
    mesh.frustumCulled = false;
    mesh.renderOrder = 2;
    mesh.layers.set(PEOPLE);
    mesh.setColorAt(0, new Color());
    return mesh;
  }

  clear() {
    for (const mesh of Object.values(this.sets)) mesh.count = 0;
  }

  add(name, { x, y, z = 0.012, turn = 0, a, b = a, colour }) {
    const mesh = this.sets[name];
    if (mesh.count >= MOST_MARKS) return;
    const pose = new Quaternion().setFromAxisAngle(new Vector3(0, 0, 1), turn);
    mesh.setMatrixAt(mesh.count, new Matrix4().compose(new Vector3(x, y, z), pose, new Vector3(a, b, 1)));
    mesh.setColorAt(mesh.count, new Color(colour));
    mesh.count += 1;
    mesh.instanceMatrix.needsUpdate = true;
    mesh.instanceColor.needsUpdate = true;
  }

  line(from, to, width, colour, z = 0.014) {
    const [dx, dy] = [to.x - from.x, to.y - from.y];
    this.add("bar", { x: from.x, y: from.y, z, turn: Math.atan2(dy, dx), a: Math.hypot(dx, dy), b: width, colour });
  }

  ellipse({ x, y, ellipse: { a, b, turn } }, colour) {
    this.add("disc", { x, y, turn, a, b, colour });
    const [cos, sin] = [Math.cos(turn), Math.sin(turn)];
    const at = (step) => {
      const [along, across] = [a * Math.cos((step * Math.PI) / 16), b * Math.sin((step * Math.PI) / 16)];
      return { x: x + along * cos - across * sin, y: y + along * sin + across * cos };
    };
    for (let step = 0; step < 32; step++) this.line(at(step), at(step + 1), 0.014, colour, 0.013);
  }
}
