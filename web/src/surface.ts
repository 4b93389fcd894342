// The followed face as a shaded surface that one can turn.

import {
  BufferAttribute,
  BufferGeometry,
  Color,
  DirectionalLight,
  DoubleSide,
  Group,
  HemisphereLight,
  Mesh,
  MeshStandardMaterial,
  PerspectiveCamera,
  Scene,
  WebGLRenderer,
} from "three";

import { byId, themeColour } from "./dom";
import type { Plane } from "./protocol";

const TEAR_MM = 14; // neighbours further apart than this are not one surface
// Half axes of the part that is shown, sideways, up, down: hair and collar end nowhere.
const [ASIDE_MM, UP_MM, DOWN_MM] = [68, 111, 90];
const MIDDLE_MM = 35; // depth behind the nose tip about which the face turns
const MAX_TURN = 1.3; // rad
const STEP = 0.12; // rad a key press
const AWAY_MM = 520; // of the viewer
const FAR_MM = 700;
const NEAREST_MM = 300;

export class SurfaceView {
  private readonly canvas = byId<HTMLCanvasElement>("surface");
  private readonly renderer: WebGLRenderer;
  private readonly scene = new Scene();
  private readonly camera = new PerspectiveCamera(26, 1, 50, 2000);
  private readonly turned = new Group();
  private readonly material = new MeshStandardMaterial({ roughness: 0.72, side: DoubleSide });
  private mesh: Mesh<BufferGeometry> | null = null;
  private shape = "";
  private scheduled = false;

  /** Throws where the browser has no WebGL. */
  constructor() {
    this.renderer = new WebGLRenderer({ canvas: this.canvas, antialias: true, alpha: true });
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    const key = new DirectionalLight(0xffffff, 2.4);
    key.position.set(-0.7, 0.8, 0.9);
    const rim = new DirectionalLight(0xbfe3ff, 0.9);
    rim.position.set(1, 0.1, 0.35);
    this.scene.add(this.turned, key, rim, new HemisphereLight(0xffffff, 0x50605c, 0.75));
    this.camera.position.z = AWAY_MM;
    this.paint();
    this.listen();
    new ResizeObserver(() => this.resize()).observe(this.canvas);
  }

  /** Takes the theme's colour. */
  paint(): void {
    this.material.color = new Color(themeColour("--clay"));
    this.schedule();
  }

  clear(): void {
    if (!this.mesh) return;
    this.turned.remove(this.mesh);
    this.mesh.geometry.dispose();
    this.mesh = null;
    this.shape = "";
    this.schedule();
  }

  show(plane: Plane): void {
    const shape = `${plane.rows}×${plane.cols}`;
    if (!this.mesh || this.shape !== shape) {
      this.clear();
      const geometry = new BufferGeometry();
      const count = plane.rows * plane.cols;
      geometry.setAttribute("position", new BufferAttribute(new Float32Array(3 * count), 3));
      this.mesh = new Mesh(geometry, this.material);
      this.mesh.frustumCulled = false;
      this.turned.add(this.mesh);
      this.shape = shape;
    }
    fill(this.mesh.geometry, plane);
    this.schedule();
  }

  private turn(yaw: number, pitch: number): void {
    const limited = (angle: number) => Math.max(-MAX_TURN, Math.min(MAX_TURN, angle));
    this.turned.rotation.y = limited(this.turned.rotation.y + yaw);
    this.turned.rotation.x = limited(this.turned.rotation.x + pitch);
    this.schedule();
  }

  private zoom(factor: number): void {
    this.camera.position.z = Math.max(NEAREST_MM, Math.min(FAR_MM, this.camera.position.z * factor));
    this.schedule();
  }

  private front(): void {
    this.turned.rotation.set(0, 0, 0);
    this.camera.position.z = AWAY_MM;
    this.schedule();
  }

  private listen(): void {
    const canvas = this.canvas;
    canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
    canvas.addEventListener("pointermove", (event) => {
      if (event.buttons & 1) this.turn(event.movementX / 110, event.movementY / 110);
    });
    canvas.addEventListener("dblclick", () => this.front());
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.zoom(Math.exp(event.deltaY / 900));
    }, { passive: false });
    const keys: Record<string, () => void> = {
      ArrowLeft: () => this.turn(-STEP, 0),
      ArrowRight: () => this.turn(STEP, 0),
      ArrowUp: () => this.turn(0, -STEP),
      ArrowDown: () => this.turn(0, STEP),
      "+": () => this.zoom(0.9),
      "-": () => this.zoom(1.1),
      Home: () => this.front(),
    };
    canvas.addEventListener("keydown", (event) => {
      const action = keys[event.key];
      if (!action) return;
      event.preventDefault();
      event.stopPropagation();
      action();
    });
  }

  private resize(): void {
    const { clientWidth, clientHeight } = this.canvas;
    if (clientWidth === 0 || clientHeight === 0) return;
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.camera.aspect = clientWidth / clientHeight;
    this.camera.updateProjectionMatrix();
    this.schedule();
  }

  // Drawn when something changed, not sixty times a second.
  private schedule(): void {
    if (this.scheduled) return;
    this.scheduled = true;
    requestAnimationFrame(() => {
      this.scheduled = false;
      this.renderer.render(this.scene, this.camera);
    });
  }
}

// The face frame has y down and z away from the viewer; three.js has both the other way round.
function fill(geometry: BufferGeometry, plane: Plane): void {
  const { rows, cols, values, step_mm, offset_mm } = plane;
  const pitch = plane.pitch_mm ?? 1;
  const position = geometry.getAttribute("position") as BufferAttribute;
  const xyz = position.array as Float32Array;
  for (let row = 0, i = 0; row < rows; row++) {
    for (let col = 0; col < cols; col++, i++) {
      xyz[3 * i] = (col - (cols - 1) / 2) * pitch;
      xyz[3 * i + 1] = ((rows - 1) / 2 - row) * pitch;
      xyz[3 * i + 2] = MIDDLE_MM - (offset_mm + step_mm * values[i]!);
    }
  }
  position.needsUpdate = true;
  geometry.setIndex(triangles(plane));
  geometry.computeVertexNormals();
}

function triangles({ rows, cols, values, step_mm, pitch_mm }: Plane): number[] {
  const tear = TEAR_MM / step_mm;
  const pitch = pitch_mm ?? 1;
  const index: number[] = [];
  const inside = (row: number, col: number) => {
    const [x, y] = [(col - cols / 2 + 1) * pitch, (row - rows / 2 + 1) * pitch];
    return Math.abs(x / ASIDE_MM) ** 2.6 + Math.abs(y / (y < 0 ? UP_MM : DOWN_MM)) ** 2.6 < 1;
  };
  const joined = (a: number, b: number, c: number) => {
    const [u, v, w] = [values[a]!, values[b]!, values[c]!];
    return u > 0 && v > 0 && w > 0 && Math.max(u, v, w) - Math.min(u, v, w) < tear;
  };
  for (let row = 0; row + 1 < rows; row++) {
    for (let col = 0; col + 1 < cols; col++) {
      if (!inside(row, col)) continue;
      const a = row * cols + col;
      const [b, c, d] = [a + 1, a + cols, a + cols + 1];
      if (joined(a, c, b)) index.push(a, c, b);
      if (joined(b, c, d)) index.push(b, c, d);
    }
  }
  return index;
}
