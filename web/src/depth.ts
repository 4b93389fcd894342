// The live depth image, its colour scale, and a box with a name around every face.

import { SCALE, drawScale } from "./colours";
import { byId, figure, make, write } from "./dom";
import type { FaceReport, Frame, Plane } from "./protocol";
import { CLASS, MARK, headline } from "./words";

const IN_FRONT_MM = 25; // of the nearest face
const BEHIND_MM = 170;
const STEADY = 0.85; // how much of the last range is kept: the colours must not flicker
const TICKS = 4;
const HIGH = 0.09;

interface Range {
  near: number;
  far: number;
}

export class DepthView {
  private readonly canvas = byId<HTMLCanvasElement>("depth");
  private readonly boxes = byId("boxes");
  private readonly ticks = byId("ticks");
  private readonly known = new Map<number, HTMLButtonElement>();
  private range: Range | null = null;

  constructor(private readonly onFollow: (track: number) => void) {
    drawScale(byId<HTMLCanvasElement>("scale"));
    this.ticks.append(...Array.from({ length: TICKS }, () => make("span")));
  }

  /** Forgets the range of the last source. */
  reset(): void {
    this.range = null;
  }

  draw(frame: Frame, followed: number | null): void {
    const wanted = rangeOf(frame);
    if (wanted) this.range = this.range ? glide(this.range, wanted) : wanted;
    if (this.range) this.paint(frame.depth, this.range);
    this.mark(frame, followed);
  }

  private paint(depth: Plane, { near, far }: Range): void {
    if (this.canvas.width !== depth.cols || this.canvas.height !== depth.rows) {
      this.canvas.width = depth.cols;
      this.canvas.height = depth.rows;
      this.canvas.parentElement!.style.aspectRatio = `${depth.cols} / ${depth.rows}`;
    }
    const context = this.canvas.getContext("2d")!;
    const image = context.createImageData(depth.cols, depth.rows);
    const pixels = new Uint32Array(image.data.buffer);
    const last = SCALE.length - 1;
    const gain = (last * depth.step_mm) / (far - near);
    const start = (last * (depth.offset_mm - near)) / (far - near);
    depth.values.forEach((value, i) => {
      if (value === 0) return; // transparent: the page's ground shows through
      pixels[i] = SCALE[Math.max(0, Math.min(last, Math.round(start + gain * value)))]!;
    });
    context.putImageData(image, 0, 0);
    [...this.ticks.children].forEach((tick, i) =>
      write(tick, figure(near + (i / (TICKS - 1)) * (far - near))),
    );
  }

  private mark(frame: Frame, followed: number | null): void {
    const seen = new Set(frame.faces.map((face) => face.track));
    for (const [track, box] of this.known) {
      if (seen.has(track)) continue;
      box.remove();
      this.known.delete(track);
    }
    for (const face of frame.faces) this.place(face, frame.depth, face.track === followed);
  }

  private place(face: FaceReport, depth: Plane, followed: boolean): void {
    let box = this.known.get(face.track);
    if (!box) {
      box = make("button", "box", make("span", "tag"));
      box.type = "button";
      box.onclick = () => this.onFollow(face.track);
      this.known.set(face.track, box);
      this.boxes.append(box);
    }
    const [x, y, width, height] = face.box;
    Object.assign(box.style, {
      left: `${(100 * x) / depth.cols}%`,
      top: `${(100 * y) / depth.rows}%`,
      width: `${(100 * width) / depth.cols}%`,
      height: `${(100 * height) / depth.rows}%`,
    });
    box.className = `box ${CLASS[face.verdict]}`;
    box.classList.toggle("followed", followed);
    box.classList.toggle("high", y < HIGH * depth.rows); // no room for the name above the box
    box.setAttribute("aria-pressed", String(followed));
    const score = face.score === null ? "" : `  ${figure(face.score, 1)}`;
    write(box.firstElementChild!, `${MARK[face.verdict]} ${headline(face)}${score}`);
  }
}

// The range of the faces where there are any, else of the scene (its 2nd to 98th percentile).
function rangeOf({ faces, depth }: Frame): Range | null {
  const distances = faces.flatMap((face) => face.distance_mm ?? []);
  if (distances.length > 0) {
    return { near: Math.min(...distances) - IN_FRONT_MM, far: Math.max(...distances) + BEHIND_MM };
  }
  const sample = depth.values.filter((value, i) => value > 0 && i % 7 === 0).sort();
  if (sample.length < 10) return null;
  const at = (part: number) =>
    depth.offset_mm + depth.step_mm * sample[Math.floor(part * (sample.length - 1))]!;
  const near = at(0.02);
  return { near, far: Math.max(at(0.98), near + 50) };
}

function glide(from: Range, to: Range): Range {
  const mix = (a: number, b: number) => STEADY * a + (1 - STEADY) * b;
  return { near: mix(from.near, to.near), far: mix(from.far, to.far) };
}
