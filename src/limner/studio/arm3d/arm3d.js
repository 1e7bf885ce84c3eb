// A robot's URDF, a plan and joint positions go in; the arm in space, the sheet and the ink on it come out.

import {
  AmbientLight, BufferAttribute, BufferGeometry, Color, DirectionalLight, GridHelper, Group, LineBasicMaterial, LineSegments, Matrix4, Mesh, MeshBasicMaterial,
  MeshStandardMaterial, PerspectiveCamera, PlaneGeometry, Scene, Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import URDFLoader from "urdf-loader";

/** @typedef {{offsets: Uint32Array, points: Int16Array, unit: number}} Lines */
/** @typedef {{width_mm: number, height_mm: number}} Page */

const ABOVE_SHEET_M = 0.0006;
const INK = new Color(0x1d1c1a);
const UNREACHED = new Color(0xb8361c);

/** The room with the arm. Drawn only when something has changed. */
export class Space {
  /** @param {HTMLElement} room @param {string} urdf */
  constructor(room, urdf) {
    this.room = room;
    this.renderer = new WebGLRenderer({ antialias: true, alpha: true });
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    room.append(this.renderer.domElement);
    this.scene = new Scene();
    this.camera = new PerspectiveCamera(38, 1, 0.02, 20);
    // URDFs have z up.
    this.camera.up.set(0, 0, 1);
    this.scene.add(new AmbientLight(0xffffff, 1.3), light(2, 1, 3, 2.2), light(-2, -1, 1, 0.7));
    this.robot = armOf(urdf);
    this.table = new Group();
    this.scene.add(this.robot, this.table);
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.addEventListener("change", () => this.render());
    this.starts = new Uint32Array(1);
    this.sizes = new ResizeObserver(() => this._fit());
    this.sizes.observe(room);
  }

  close() {
    this.sizes.disconnect();
    this.controls.dispose();
    this.renderer.dispose();
    this.renderer.domElement.remove();
  }

  /**
   * The sheet where the plan has it, with all the ink that there will be.
   * @param {{base_from_paper: number[][], joints_named: string[], unreachable?: number[], joints?: Float32Array, base?: string}} plan
   * @param {Lines} lines
   * @param {Page} page
   */
  setPlan(plan, lines, page) {
    this.names = plan.joints_named;
    this.table.clear();
    this.table.matrixAutoUpdate = false;
    const inBase = new Matrix4().set(.../** @type {any} */ (plan.base_from_paper.flat()));
    const [width, height] = [page.width_mm / 1000, page.height_mm / 1000];
    const paper = new Mesh(new PlaneGeometry(width, height), new MeshBasicMaterial({ color: 0xfffdf8, side: 2 }));
    paper.position.set(width / 2, height / 2, 0);
    const floor = new GridHelper(0.8, 16, 0xb3aa98, 0xcfc7b6);
    floor.rotation.x = Math.PI / 2;
    floor.position.set(width / 2, height / 2, -0.004);
    this.ink = inkOf(lines, height, new Set(plan.unreachable));
    this.starts = countsOf(lines);
    this.table.add(paper, floor, this.ink);
    // The plan is in the frame of the arm's base, which may stand anywhere in the robot.
    this.robot.updateMatrixWorld(true);
    this.table.matrix.copy(this.robot.links[plan.base ?? ""]?.matrixWorld ?? new Matrix4()).multiply(inBase);
    this.table.matrixWorldNeedsUpdate = true;
    this.arm = this.robot.links[plan.base ?? ""]?.matrixWorld;
    this._look(new Vector3(width / 2, height / 2, 0).applyMatrix4(this.table.matrix), Boolean(plan.joints));
  }

  /** @param {number[]} q @param {number} ink points that are drawn */
  show(q, ink) {
    this.names?.forEach((name, i) => this.robot.setJointValue(name, q[i]));
    this.ink?.geometry.setDrawRange(0, 2 * (this.starts[Math.min(ink, this.starts.length - 1)] ?? 0));
    this.render();
  }

  render() {
    if (this.waiting) return;
    this.waiting = requestAnimationFrame(() => {
      this.waiting = 0;
      this.renderer.render(this.scene, this.camera);
    });
  }

  /** From beyond the sheet, a little above, towards the arm; from farther off where it rests, reaching up. @param {Vector3} sheet @param {boolean} draws */
  _look(sheet, draws) {
    const far = draws ? 1 : 1.5;
    const arm = new Vector3().setFromMatrixPosition(this.arm ?? new Matrix4());
    const away = sheet.clone().sub(arm).setZ(0).normalize();
    const side = new Vector3(-away.y, away.x, 0);
    this.controls.target.copy(sheet.clone().lerp(arm, 0.35)).add(new Vector3(0, 0, draws ? 0 : 0.2));
    this.camera.position.copy(sheet).addScaledVector(away, 0.95 * far).addScaledVector(side, 0.85 * far).add(new Vector3(0, 0, 0.85 * far));
    this.controls.update();
    this._fit();
  }

  _fit() {
    const { clientWidth: width, clientHeight: height } = this.room;
    if (!width || !height) return;
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.render();
  }
}

/** @param {number} x @param {number} y @param {number} z @param {number} strength */
function light(x, y, z, strength) {
  const lamp = new DirectionalLight(0xffffff, strength);
  lamp.position.set(x, y, z);
  return lamp;
}

/** The robot, in one calm colour; shapes in files are left out. @param {string} urdf */
function armOf(urdf) {
  const loader = new URDFLoader();
  loader.loadMeshCb = (_path, _manager, done) => done(new Group());
  const robot = loader.parse(urdf);
  const paint = new MeshStandardMaterial({ color: new Color(0xd9d0be), roughness: 0.75 });
  robot.traverse((part) => {
    if (part instanceof Mesh) part.material = paint;
  });
  return robot;
}

/**
 * Ink as segments, in drawing order: how many are shown costs nothing to change.
 * @param {Lines} lines
 * @param {number} height of the sheet [m]
 * @param {Set<number>} red strokes that cannot be reached
 */
function inkOf({ offsets, points, unit }, height, red) {
  const places = [];
  const colours = [];
  const put = (/** @type {number} */ i, /** @type {Color} */ colour) => {
    colours.push(colour.r, colour.g, colour.b);
    places.push((points[2 * i] * unit) / 1000, height - (points[2 * i + 1] * unit) / 1000, ABOVE_SHEET_M);
  };
  for (let stroke = 0; stroke < offsets.length - 1; stroke += 1) {
    for (let i = offsets[stroke] + 1; i < offsets[stroke + 1]; i += 1) {
      put(i - 1, red.has(stroke) ? UNREACHED : INK);
      put(i, red.has(stroke) ? UNREACHED : INK);
    }
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(Float32Array.from(places), 3));
  geometry.setAttribute("color", new BufferAttribute(Float32Array.from(colours), 3));
  const ink = new LineSegments(geometry, new LineBasicMaterial({ vertexColors: true }));
  ink.frustumCulled = false;
  return ink;
}

/** How many segments there are before each point. @param {Lines} lines */
function countsOf({ offsets }) {
  const total = offsets[offsets.length - 1] ?? 0;
  const counts = new Uint32Array(total + 1);
  let stroke = 0;
  for (let i = 0; i < total; i += 1) {
    while (i >= offsets[stroke + 1]) stroke += 1;
    counts[i + 1] = counts[i] + (i > offsets[stroke] ? 1 : 0);
  }
  return counts;
}
