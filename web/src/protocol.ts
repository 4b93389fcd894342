// What the server and the page say to each other.
//
// Frames are binary: the number of frames that this page was not sent because newer ones had come,
// the length of the head (both uint32, little-endian), the head (JSON, padded with blanks to a
// multiple of four bytes), and then its planes, each uint16 row by row. Everything else is JSON
// text: the server's state and replies, the page's commands.

export type Verdict = "accepted" | "unknown" | "cannot tell";

export interface FaceReport {
  track: number;
  /** x, y, width, height in pixels of the depth image. */
  box: [number, number, number, number];
  verdict: Verdict;
  subject: string | null;
  /** Evidence for the best person, what is needed for a name, and what rules everybody out. */
  score: number | null;
  threshold: number | null;
  refuse_at: number | null;
  reason: string | null;
  /** Comparisons that were made, and how the evidence grew: time (s), evidence. */
  looks: number;
  evidence: [number, number][];
  yaw_deg: number | null;
  pitch_deg: number | null;
  distance_mm: number | null;
  /** How often this person has come. */
  visits: number;
}

interface PlaneHead {
  name: "depth" | "surface";
  rows: number;
  cols: number;
  /** mm = offset_mm + step_mm · value; the value 0 is an invalid pixel. */
  offset_mm: number;
  step_mm: number;
  /** Surfaces only: size of a cell, and whose face it is. */
  pitch_mm?: number;
  track?: number;
}

interface FrameHead {
  frame: number;
  time_s: number;
  fps: number;
  latency_ms: number;
  /** Frames left out before recognition; frames that came too late or out of order. */
  dropped: number;
  ignored: number;
  /** The track that is shown close up, and is meant by an enrolment. */
  followed: number | null;
  /** Different people seen so far. */
  people: number;
  times_ms: Record<string, number>;
  faces: FaceReport[];
  planes: PlaneHead[];
}

export type Plane = PlaneHead & { values: Uint16Array };

export type Frame = Omit<FrameHead, "planes"> & {
  depth: Plane;
  surface: Plane | null;
  /** Frames that this page was not sent. */
  missed: number;
};

export interface EnrolStep {
  label: string;
  done: number;
  needed: number;
}

export interface Enrolment {
  subject: string;
  track: number;
  hint: string;
  steps: EnrolStep[];
  /** Enough views for a template; more views make a better one. */
  sufficient: boolean;
}

export interface State {
  sources: { name: string; label: string }[];
  source: string | null;
  playing: boolean;
  ended: boolean;
  problem: string | null;
  recording: { file: string; frames: number } | null;
  denoiser: string;
  denoisers: string[];
  gallery: { subject: string }[];
  enrolment: Enrolment | null;
}

export type Command =
  | { do: "play" | "pause" | "step" | "cancel" | "save" }
  | { do: "source" | "denoise"; name: string }
  | { do: "record"; on: boolean }
  | { do: "follow"; track: number }
  | { do: "enrol"; subject: string; track: number }
  | { do: "delete"; subject: string };

export type Notice =
  | { state: State }
  | { reply: number; error: string | null };

export function decodeFrame(message: ArrayBuffer): Frame {
  const view = new DataView(message);
  const [missed, headLength] = [view.getUint32(0, true), view.getUint32(4, true)];
  const text = new TextDecoder().decode(new Uint8Array(message, 8, headLength));
  const { planes: heads, ...frame } = JSON.parse(text) as FrameHead;
  let offset = 8 + headLength;
  const planes = heads.map((head): Plane => {
    const values = new Uint16Array(message, offset, head.rows * head.cols);
    offset += values.byteLength + (values.byteLength % 4);
    return { ...head, values };
  });
  const depth = planes.find((plane) => plane.name === "depth");
  if (!depth) throw new Error("a frame without depth");
  const surface = planes.find((plane) => plane.name === "surface") ?? null;
  return { ...frame, depth, surface, missed };
}
