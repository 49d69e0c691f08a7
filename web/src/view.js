// Where people look from: around the pitch, from above, or out of a robot's eyes. Pointers, wheel and fingers move it.
import { Vector3 } from "three";

const EASE_PER_S = 9;

export class View {
  constructor(canvas, stage, changed, picked) {
    Object.assign(this, { canvas, stage, changed, picked, mode: "orbit", camera: stage.camera });
    this.fingers = new Map();
    this.reset();
    this.now = { ...this.wish };
    canvas.addEventListener("pointerdown", (event) => this.down(event));
    canvas.addEventListener("pointermove", (event) => this.move(event));
    for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, (event) => this.up(event));
    canvas.addEventListener("wheel", (event) => this.zoom(event, Math.exp(event.deltaY * 0.001)), { passive: false });
    canvas.addEventListener("dblclick", () => this.choose(this.mode));
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  }

  /** Around the pitch: a turn about the vertical, a height above the ground, and a distance that is a share of what shows all. */
  reset() {
    const isAbove = this.mode === "above";
    this.wish = { x: 0, y: 0, turn: -Math.PI / 2, height: isAbove ? Math.PI / 2 - 1e-3 : 0.78, zoom: 1 };
    this.changed();
  }

  choose(mode) {
    this.mode = mode;
    this.reset();
  }

  down(event) {
    this.canvas.setPointerCapture(event.pointerId);
    this.fingers.set(event.pointerId, { x: event.offsetX, y: event.offsetY });
    this.moved = 0;
  }

  move(event) {
    const last = this.fingers.get(event.pointerId);
    if (!last) return;
    const [dx, dy] = [event.offsetX - last.x, event.offsetY - last.y];
    this.moved += Math.abs(dx) + Math.abs(dy);
    if (this.fingers.size === 2) {
      const [other] = [...this.fingers].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
      const far = (at) => Math.hypot(at.x - other.x, at.y - other.y);
      this.zoom(event, far(last) / Math.max(1, far({ x: event.offsetX, y: event.offsetY })));
      this.pan(dx / 2, dy / 2);
    } else if (event.shiftKey || event.buttons === 2 || this.mode === "above") this.pan(dx, dy);
    else {
      this.wish.turn -= dx * 0.006;
      this.wish.height = Math.min(Math.PI / 2 - 1e-3, Math.max(0.08, this.wish.height + dy * 0.005));
    }
    this.now = { ...this.wish };
    this.fingers.set(event.pointerId, { x: event.offsetX, y: event.offsetY });
    this.changed();
  }

  up(event) {
    if (this.fingers.delete(event.pointerId) && event.type === "pointerup" && this.moved < 6) this.pick(event.offsetX, event.offsetY);
  }

  pan(dx, dy) {
    const scale = (this.far * Math.tan((this.camera.fov * Math.PI) / 360) * 2) / this.canvas.clientHeight;
    const { turn } = this.wish;
    const most = this.stage.half;
    const clamp = (value, limit) => Math.min(limit, Math.max(-limit, value));
    this.wish.x = clamp(this.wish.x + (Math.sin(turn) * dx + Math.cos(turn) * dy) * scale, most.x);
    this.wish.y = clamp(this.wish.y + (-Math.cos(turn) * dx + Math.sin(turn) * dy) * scale, most.y);
  }

  zoom(event, factor) {
    event.preventDefault?.();
    this.wish.zoom = Math.min(2, Math.max(0.08, this.wish.zoom * factor));
    this.changed();
  }

  /** Sets the camera as far away as shows the whole pitch, times the zoom, with the pitch in the middle of the picture. */
  aim({ x, y, turn, height, zoom }) {
    const { camera, stage } = this;
    const { half, size } = stage;
    const way = new Vector3(Math.cos(height) * Math.cos(turn), Math.sin(height), -Math.cos(height) * Math.sin(turn));
    camera.aspect = size.width / size.height;
    const corners = [-1, 1].flatMap((side) => [-1, 1].flatMap((end) => [0, 0.5].map((up) => new Vector3(side * half.x, up, end * half.y))));
    const look = (far, centre) => {
      [camera.near, camera.far] = [far / 100, far * 4 + 20];
      camera.position.copy(way).multiplyScalar(far).add(centre);
      camera.lookAt(centre);
      camera.updateProjectionMatrix();
      camera.updateMatrixWorld();
    };
    let far = 2 * half.x;
    let middle = 0;
    for (let round = 0; round < 5; round++) {
      look(far, new Vector3());
      const seen = corners.map((corner) => corner.clone().project(camera));
      const [low, high] = [Math.min(...seen.map(({ y }) => y)), Math.max(...seen.map(({ y }) => y))];
      const wide = Math.max(...seen.map(({ x }) => Math.abs(x)));
      middle = (low + high) / 2;
      // Room for the board above.
      far *= Math.max(wide / 0.985, (high - low) / 1.84);
    }
    this.far = far * zoom;
    look(this.far, new Vector3(x, 0, -y));
    camera.projectionMatrix.elements[9] += (middle + 0.05) * Math.min(1, zoom);
    camera.projectionMatrixInverse.copy(camera.projectionMatrix).invert();
  }

  /** Moves the camera towards where it is wanted. Returns whether it is still on its way. */
  settle(moment, isStill) {
    const nowMs = performance.now();
    const step = isStill ? 1 : 1 - Math.exp(-EASE_PER_S * Math.min(0.1, (nowMs - (this.lastMs ?? nowMs - 16)) / 1000));
    let isGoing = false;
    for (const [name, wish] of Object.entries(this.wish)) {
      const way = wish - this.now[name];
      if (Math.abs(way) > 1e-3) isGoing = true;
      this.now[name] = Math.abs(way) > 1e-3 ? this.now[name] + way * step : wish;
    }
    this.lastMs = isGoing ? nowMs : null;
    this.moment = moment;
    this.aim(this.now);
    return isGoing;
  }

  /** Picks the robot whose chest is nearest to a place of the canvas. */
  pick(left, top) {
    if (this.mode === "eyes" || !this.moment) return;
    const { width, height } = this.stage.size;
    let best = [36, null];
    this.moment.robots.forEach((robot, index) => {
      for (const up of [0.15, 0.4]) {
        const at = new Vector3(robot.x, up, -robot.y).project(this.camera);
        const far = Math.hypot(((at.x + 1) / 2) * width - left, ((1 - at.y) / 2) * height - top);
        if (far < best[0]) best = [far, index];
      }
    });
    if (best[1] !== null) this.picked(best[1]);
  }
}
