// What a decision is called, in one place: on boxes, cards and for screen readers.

import type { FaceReport, Verdict } from "./protocol";

export const MARK: Record<Verdict, string> = { accepted: "✓", unknown: "✕", "cannot tell": "?" };

export const CLASS: Record<Verdict, string> = {
  accepted: "accepted",
  unknown: "unknown",
  "cannot tell": "undecided",
};

/** The headline: a name, or what stands in its place. */
export function headline(face: FaceReport): string {
  if (face.verdict === "accepted") return face.subject ?? "Recognised";
  return face.verdict === "unknown" ? "Unknown" : "Cannot tell";
}

/** The line below it: why, or how sure. */
export function because(face: FaceReport): string {
  if (face.verdict === "accepted") return "Recognised";
  if (face.reason === "nobody enrolled") return "Nobody is enrolled yet";
  if (face.verdict === "unknown") return "Not enrolled";
  return sentence(face.reason ?? "still looking");
}

/** Headline and reason in one breath. */
export function spoken(face: FaceReport): string {
  return face.verdict === "accepted"
    ? `${headline(face)} recognised.`
    : `${headline(face)}: ${because(face)}.`;
}

function sentence(text: string): string {
  return text.charAt(0).toUpperCase() + text.slice(1);
}
