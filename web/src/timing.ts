// How fast it runs, where the time goes, and what was left out.

import { byId, figure, make, write } from "./dom";
import type { Frame } from "./protocol";

const SMOOTH = 0.9;
const EVERY_MS = 250;

export class Timing {
  private readonly stages = byId("stages");
  private readonly means = new Map<string, number>();
  private written = 0;

  draw({ fps, latency_ms, dropped, ignored, missed, people, times_ms }: Frame): void {
    for (const [stage, time] of Object.entries(times_ms)) {
      const mean = this.means.get(stage) ?? time;
      this.means.set(stage, SMOOTH * mean + (1 - SMOOTH) * time);
    }
    const now = performance.now();
    if (now - this.written < EVERY_MS) return;
    this.written = now;
    write(byId("fps"), figure(fps, 1));
    write(byId("latency"), figure(latency_ms));
    write(byId("dropped-recogniser"), figure(dropped + ignored));
    write(byId("dropped-page"), figure(missed));
    write(byId("seen"), figure(people));
    this.bars();
  }

  private bars(): void {
    const longest = Math.max(...this.means.values(), 1);
    for (const [stage, mean] of this.means) {
      const id = `stage-${stage}`;
      let row = document.getElementById(id);
      if (!row) {
        row = make("div", "stage", make("span"), make("span", "bar", make("i")), make("output"));
        row.id = id;
        write(row.firstElementChild!, stage);
        this.stages.append(row);
      }
      row.querySelector<HTMLElement>("i")!.style.width = `${(100 * mean) / longest}%`;
      write(row.lastElementChild!, `${figure(mean, 1)} ms`);
    }
  }
}
