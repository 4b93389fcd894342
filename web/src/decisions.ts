// Who stands there: one large card for the face that is followed, a row for every other.

import { byId, figure, make, write } from "./dom";
import { EvidenceChart } from "./evidence";
import type { FaceReport, Frame } from "./protocol";
import { CLASS, MARK, because, headline, spoken } from "./words";

const SETTLED_MS = 700; // an answer is spoken when it has stood this long

export class Decisions {
  private readonly card = byId("card");
  private readonly others = byId("others");
  private readonly rows = new Map<number, HTMLButtonElement>();
  private readonly evidence = new EvidenceChart();
  private readonly spokenLast = new Map<number, string>();
  private pending: { text: string; since: number } | null = null;

  constructor(private readonly onFollow: (track: number) => void) {}

  /** The face that the large card, the surface and the enrolment are about. */
  followed({ faces, followed }: Frame): FaceReport | null {
    return faces.find((face) => face.track === followed) ?? null;
  }

  draw(frame: Frame): void {
    const face = this.followed(frame);
    this.evidence.draw(face, frame.time_s);
    this.fill(face);
    this.list(frame.faces.filter((other) => other !== face));
    this.speak(frame.faces);
  }

  private fill(face: FaceReport | null): void {
    this.card.className = `card ${face ? CLASS[face.verdict] : "nobody"}`;
    write(byId("mark"), face ? MARK[face.verdict] : "");
    write(byId("who"), face ? headline(face) : "Nobody in view");
    write(byId("why"), face ? because(face) : "Waiting for a face");
    byId("measures").hidden = !face;
    this.meter(face);
    write(byId("score"), figure(face?.score, 2));
    write(byId("threshold"), figure(face?.threshold, 2));
    write(byId("looks"), figure(face?.looks));
    write(byId("visits"), face?.visits ? figure(face.visits) : "–");
    write(byId("distance"), face?.distance_mm == null ? "–" : `${figure(face.distance_mm / 10)} cm`);
    write(byId("pose"), face?.yaw_deg == null ? "–" : turned(face));
  }

  private meter(face: FaceReport | null): void {
    const threshold = face?.threshold ?? null;
    const score = face?.score ?? null;
    const meter = byId("meter");
    meter.hidden = threshold === null || score === null;
    byId("scores").hidden = meter.hidden;
    if (threshold === null || score === null) return;
    const full = Math.max(1.5 * threshold, 1);
    const part = (value: number) => `${Math.max(0, Math.min(100, (100 * value) / full))}%`;
    byId("meter-fill").style.width = part(score);
    byId("meter-bound").style.left = part(threshold);
    meter.setAttribute("aria-valuenow", Math.max(0, Math.min(score, full)).toFixed(2));
    meter.setAttribute("aria-valuemax", full.toFixed(2));
    meter.setAttribute("aria-valuetext", `score ${score.toFixed(2)}, needed ${threshold.toFixed(2)}`);
  }

  private list(faces: FaceReport[]): void {
    const here = new Set(faces.map((face) => face.track));
    for (const [track, row] of this.rows) {
      if (here.has(track)) continue;
      row.remove();
      this.rows.delete(track);
    }
    for (const face of faces) {
      let row = this.rows.get(face.track);
      if (!row) {
        row = make("button", "", make("span", "dot"), make("strong"), make("span", "small"));
        row.type = "button";
        row.onclick = () => this.onFollow(face.track);
        this.rows.set(face.track, row);
        this.others.append(row);
      }
      row.className = `other ${CLASS[face.verdict]}`;
      const [mark, name, reason] = [...row.children];
      write(mark!, MARK[face.verdict]);
      write(name!, headline(face));
      write(reason!, because(face));
    }
  }

  // Screen readers hear an answer once, when it has settled.
  private speak(faces: FaceReport[]): void {
    const changed = faces.filter((face) => this.spokenLast.get(face.track) !== spoken(face));
    const text = changed.map(spoken).join(" ");
    if (!text) {
      this.pending = null;
      return;
    }
    const now = performance.now();
    if (this.pending?.text !== text) this.pending = { text, since: now };
    if (now - this.pending.since < SETTLED_MS) return;
    write(byId("spoken"), text);
    this.spokenLast.clear();
    for (const face of faces) this.spokenLast.set(face.track, spoken(face));
    this.pending = null;
  }
}

// Left and right are the person's own.
function turned({ yaw_deg, pitch_deg }: FaceReport): string {
  const [yaw, pitch] = [yaw_deg ?? 0, pitch_deg ?? 0];
  const parts = [];
  if (Math.abs(yaw) >= 4) parts.push(`${figure(Math.abs(yaw))}° ${yaw > 0 ? "left" : "right"}`);
  if (Math.abs(pitch) >= 4) parts.push(`${figure(Math.abs(pitch))}° ${pitch > 0 ? "down" : "up"}`);
  return parts.join(", ") || "straight";
}
