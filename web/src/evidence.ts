// How the evidence for the followed face grew, between the bound that gives a name and the bound
// that rules everybody out.

import { byId } from "./dom";
import type { FaceReport } from "./protocol";
import { CLASS } from "./words";

const WINDOW_S = 12;
const HEIGHT = 84;
const EDGE = 6;

export class EvidenceChart {
  private readonly figureOf = byId("evidence");
  private readonly drawing = this.figureOf.querySelector("svg")!;
  private readonly line = byId("evidence-line");
  private readonly end = byId("evidence-end");
  private readonly bounds = [byId("bound-name"), byId("bound-unknown")] as const;

  draw(face: FaceReport | null, now_s: number): void {
    const all = face?.evidence ?? [];
    const recent = all.filter(([time_s]) => time_s > now_s - WINDOW_S);
    this.figureOf.toggleAttribute("data-empty", recent.length === 0);
    this.figureOf.dataset["verdict"] = face ? CLASS[face.verdict] : "";
    const limits = [face?.threshold ?? null, face?.refuse_at ?? null];
    const values = [0, ...recent.map(([, value]) => value), ...limits.filter((v) => v !== null)];
    const [low, high] = [Math.min(...values), Math.max(...values, 1)];
    const width = Math.max(this.drawing.clientWidth, 60);
    this.drawing.setAttribute("viewBox", `0 0 ${width} ${HEIGHT}`);
    const x = (time_s: number) => width - EDGE - ((now_s - time_s) / WINDOW_S) * (width - 2 * EDGE);
    const y = (value: number) => HEIGHT - EDGE - ((value - low) / (high - low)) * (HEIGHT - 2 * EDGE);

    const points = recent.map(([time_s, value]) => [x(time_s), y(value)] as const);
    const last = points.at(-1);
    if (last) points.push([x(now_s), last[1]]); // what was shown stands until the next look
    this.line.setAttribute("points", points.map((point) => point.map(fixed).join(",")).join(" "));
    this.end.setAttribute("cx", fixed(x(now_s)));
    if (last) this.end.setAttribute("cy", fixed(last[1]));
    this.bounds.forEach((bound, i) => {
      const limit = limits[i] ?? null;
      bound.toggleAttribute("hidden", limit === null);
      if (limit === null) return;
      bound.setAttribute("x2", fixed(width));
      for (const end of ["y1", "y2"]) bound.setAttribute(end, fixed(y(limit)));
    });
  }
}

function fixed(value: number): string {
  return value.toFixed(1);
}
