// The pitch, the ball and the robots in 3-D. Everything is in the pitch frame, z up; one turn of the root makes it three's.
import {
  AmbientLight, BufferAttribute, BufferGeometry, Color, CylinderGeometry, DirectionalLight, Euler, Group, HemisphereLight, InstancedMesh,
  Line, LineBasicMaterial, LineSegments, Matrix4, Mesh, MeshLambertMaterial, MeshStandardMaterial, PCFShadowMap, PerspectiveCamera,
  PlaneGeometry, Quaternion, Scene, SphereGeometry, Sprite, SpriteMaterial, Vector3, WebGLRenderer,
} from "three";
import { RoundedBoxGeometry } from "three/addons/geometries/RoundedBoxGeometry.js";
import { Marks, PEOPLE, points } from "./marks.js";
import { limb, partsOf, rad, stance } from "./shape.js";
import { carpet, badge, ballSkin } from "./textures.js";

export const TEAM = { blue: 0x1f5fe0, pink: 0xf0508f };
const GOALS = { yellow: 0xfaca30, blue: 0x007db6, white: 0xeeeeee };
/** The layer of the floor of the hall, for robots' eyes. */
const EYES = 2;
const MOST_PARTS = 1200;

export class Stage {
  constructor(canvas, match) {
    this.match = match;
    this.canvas = canvas;
    this.renderer = new WebGLRenderer({ canvas, antialias: true, powerPreference: "low-power" });
    this.renderer.setPixelRatio(Math.min(2, devicePixelRatio));
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = PCFShadowMap;
    this.renderer.autoClear = false;
    this.scene = new Scene();
    this.root = new Group();
    this.root.rotation.x = -Math.PI / 2;
    this.scene.add(this.root);
    const { pitch } = match.head;
    this.half = { x: pitch.length_m / 2 + pitch.border_m, y: pitch.width_m / 2 + pitch.border_m };
    // On a larger pitch marks are larger, too.
    this.scale = Math.max(1, this.half.x / 4.2);
    this.camera = new PerspectiveCamera(35, 1, 0.05, 200);
    this.camera.layers.enable(PEOPLE);
    this.eyes = new PerspectiveCamera(45, 1, 0.03, 100);
    this.eyes.layers.enable(EYES);
    this.lights();
    this.pitch(pitch);
    this.parts = { box: this.pool(new RoundedBoxGeometry(1, 1, 1, 2, 0.18)), ball: this.pool(new SphereGeometry(0.5, 24, 16)), rod: this.pool(limb()) };
    this.marks = new Marks(this.root);
    this.badges = match.robots.map((robot) => this.label(badge(robot.team, robot.number), 0.2 * this.scale));
    this.words = this.label(null, 0.3);
    const radius = match.head.ball_radius_m;
    this.ball = new Mesh(new SphereGeometry(radius, 32, 24), new MeshStandardMaterial({ map: ballSkin(match.head.ball_look === "orange"), roughness: 0.5 }));
    this.ball.castShadow = true;
    this.moreBalls = match.moreBalls(match.at(match.startS)).map(() => this.ball.clone());
    this.trail = new Line(new BufferGeometry(), new LineBasicMaterial({ vertexColors: true, transparent: true, depthWrite: false }));
    this.trail.layers.set(PEOPLE);
    this.trail.frustumCulled = false;
    this.root.add(this.ball, ...this.moreBalls, this.trail);
  }

  lights() {
    this.scene.add(new HemisphereLight(0xf3f7ff, 0x3d6b47, 1.5), new AmbientLight(0xffffff, 0.35));
    const sun = new DirectionalLight(0xfff6e8, 2.1);
    const reach = Math.hypot(this.half.x, this.half.y);
    sun.position.set(-0.35 * reach, 1.3 * reach, 0.55 * reach);
    sun.castShadow = true;
    sun.shadow.mapSize.set(2048, 2048);
    sun.shadow.radius = 3;
    sun.shadow.bias = -0.0005;
    sun.shadow.normalBias = 0.01;
    Object.assign(sun.shadow.camera, { left: -reach, right: reach, top: reach, bottom: -reach, near: 0.1, far: 4 * reach });
    this.scene.add(sun);
  }

  pitch(pitch) {
    const { x, y } = this.half;
    const floor = new Mesh(new PlaneGeometry(60 * x, 60 * x), new MeshLambertMaterial({ color: 0x8b9096 }));
    floor.position.z = -0.012;
    floor.layers.set(EYES);
    this.floor = floor;
    const texture = carpet(pitch, this.half);
    texture.anisotropy = this.renderer.capabilities.getMaxAnisotropy();
    const green = new Mesh(new PlaneGeometry(2 * x, 2 * y), new MeshLambertMaterial({ map: texture }));
    green.receiveShadow = true;
    this.root.add(floor, green);
    const { goal } = pitch;
    for (const [side, colour] of [[-1, goal.negative_x_colour], [1, goal.positive_x_colour]]) this.goal(pitch, side, GOALS[colour] ?? GOALS.white);
    for (const post of this.match.head.posts ?? []) this.rod([...post.position_m, 0], [...post.position_m, post.height_m], post.radius_m, 0x8c8f99);
  }

  goal(pitch, side, colour) {
    const { width_m: width, height_m: height, depth_m: depth, post_diameter_m: post, bar_diameter_m: bar } = pitch.goal;
    const [line, back] = [(side * pitch.length_m) / 2, side * (pitch.length_m / 2 + depth)];
    const top = height - bar / 2;
    for (const y of [-width / 2, width / 2]) {
      this.rod([line, y, 0], [line, y, height], post / 2, colour);
      this.rod([line, y, 0.02], [back, y, 0.02], 0.02, 0xe4e6e8);
      this.rod([line, y, top], [back, y, 0.02], 0.012, 0xe4e6e8);
    }
    this.rod([line, -width / 2, top], [line, width / 2, top], bar / 2, colour);
    this.rod([back, -width / 2, 0.02], [back, width / 2, 0.02], 0.02, 0xe4e6e8);
    const net = [];
    const across = Math.max(4, Math.round(width / 0.1));
    for (let step = 0; step <= across; step++) {
      const y = (step / across - 0.5) * width;
      net.push(line, y, top, back, y, 0.02);
    }
    for (let step = 1; step < 8; step++) {
      const [x, z] = [line + ((back - line) * step) / 8, top + ((0.02 - top) * step) / 8];
      net.push(x, -width / 2, z, x, width / 2, z);
      for (const y of [-width / 2, width / 2]) net.push(x, y, 0, x, y, z);
    }
    const lines = new LineSegments(points(net), new LineBasicMaterial({ color: 0xffffff, transparent: true, opacity: 0.35 }));
    this.root.add(lines);
  }

  rod(from, to, radius, color) {
    const [start, end] = [new Vector3(...from), new Vector3(...to)];
    const mesh = new Mesh(new CylinderGeometry(radius, radius, start.distanceTo(end), 20), new MeshStandardMaterial({ color, roughness: 0.6 }));
    mesh.position.copy(start).lerp(end, 0.5);
    mesh.quaternion.setFromUnitVectors(new Vector3(0, 1, 0), end.sub(start).normalize());
    mesh.castShadow = true;
    this.root.add(mesh);
  }

  pool(geometry) {
    const mesh = new InstancedMesh(geometry, new MeshStandardMaterial({ roughness: 0.55 }), MOST_PARTS);
    mesh.castShadow = true;
    mesh.frustumCulled = false;
    mesh.setColorAt(0, new Color());
    this.root.add(mesh);
    return mesh;
  }

  label(texture, size) {
    const sprite = new Sprite(new SpriteMaterial({ map: texture, transparent: true, depthTest: false }));
    sprite.scale.setScalar(size);
    sprite.layers.set(PEOPLE);
    sprite.renderOrder = 5;
    sprite.visible = Boolean(texture);
    this.root.add(sprite);
    return sprite;
  }

  /** Puts ball and robots where they are; what the robot `hidden` looks out of is left out. */
  place(moment, hidden = null) {
    const { ball, moreBalls, robots } = moment;
    for (const mesh of Object.values(this.parts)) mesh.count = 0;
    robots.forEach((robot, index) => {
      const { body, team } = this.match.robots[index];
      if (index !== hidden) for (const part of partsOf(body, robot, TEAM[team])) this.part(part, robot);
      const height = robot.posture === 0 ? body.height_m : 0.3;
      this.badges[index].position.set(robot.x, robot.y, height + 0.15 * this.scale);
      this.badges[index].material.opacity = robot.isPenalised ? 0.35 : 1;
    });
    for (const mesh of Object.values(this.parts)) {
      mesh.instanceMatrix.needsUpdate = true;
      mesh.instanceColor.needsUpdate = true;
    }
    this.ball.visible = Boolean(ball);
    if (ball) rollTo(this.ball, ball);
    this.moreBalls.forEach((mesh, index) => rollTo(mesh, moreBalls[index]));
  }

  part({ shape, size, at, turn, colour }, robot) {
    const mesh = this.parts[shape];
    if (mesh.count >= MOST_PARTS) return;
    const local = new Matrix4().compose(new Vector3(...at), new Quaternion().setFromEuler(turn ?? new Euler()), new Vector3(...size));
    mesh.setMatrixAt(mesh.count, local.premultiply(stance(robot)));
    mesh.setColorAt(mesh.count, colour);
    mesh.count += 1;
  }

  /** Draws the way that the ball came. */
  way(places) {
    const colours = places.flatMap((_, index) => [1, 0.75, 0.3, (0.9 * index) / places.length]);
    this.trail.geometry.dispose();
    this.trail.geometry = points(places.flatMap(({ x, y, z }) => [x, y, z]));
    this.trail.geometry.setAttribute("color", new BufferAttribute(new Float32Array(colours), 4));
  }

  /** Looks out of a robot's camera. */
  lookOut(robot, { body, cameras }, camera, aspect) {
    const mount = cameras[camera] ?? cameras[0];
    if (!mount) return false;
    const neck = new Vector3(...body.neck_m);
    const head = new Matrix4().makeRotationFromEuler(new Euler(0, robot.pitch, robot.yaw, "ZYX"));
    const lens = new Vector3(...mount.lens_m).sub(neck).applyMatrix4(head).add(neck);
    const turned = head.multiply(new Matrix4().makeRotationFromEuler(new Euler(0, rad(mount.tilt_deg), rad(mount.pan_deg), "ZYX")));
    // A camera of three looks along -z with +y up; the lens looks along +x with +z up.
    const axes = new Matrix4().makeBasis(new Vector3(0, -1, 0), new Vector3(0, 0, 1), new Vector3(-1, 0, 0));
    const pose = stance(robot).multiply(turned.setPosition(lens)).multiply(axes).premultiply(new Matrix4().makeRotationX(-Math.PI / 2));
    pose.decompose(this.eyes.position, this.eyes.quaternion, new Vector3());
    const [width, height] = mount.size;
    const tangent = Math.tan(rad(mount.diagonal_fov_deg) / 2) / Math.hypot(width, height);
    const fit = Math.max(1, width / height / aspect);
    this.eyes.fov = (2 * Math.atan(tangent * height * fit) * 180) / Math.PI;
    this.eyes.aspect = aspect;
    this.eyes.updateProjectionMatrix();
    return mount;
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    this.renderer.setSize(width, height, false);
    this.size = { width, height };
  }

  /** Draws one view into a part of the canvas, in pixels from its lower left corner. */
  draw(camera, [left, bottom, width, height], background) {
    const { renderer } = this;
    renderer.setViewport(left, bottom, width, height);
    renderer.setScissor(left, bottom, width, height);
    renderer.setScissorTest(true);
    renderer.setClearColor(background);
    renderer.clear();
    const isEye = camera === this.eyes;
    this.floor.visible = isEye;
    renderer.render(this.scene, camera);
  }
}

/** Puts a ball somewhere, turned as if it had rolled there. */
function rollTo(mesh, ball) {
  const [dx, dy] = [ball.x - mesh.position.x, ball.y - mesh.position.y];
  const way = Math.hypot(dx, dy);
  if (way > 1e-4 && way < 1) mesh.quaternion.premultiply(new Quaternion().setFromAxisAngle(new Vector3(-dy / way, dx / way, 0), way / ball.z));
  mesh.position.set(ball.x, ball.y, ball.z);
}
