// The page: one connection, and who is told about what comes over it.

import { Connection } from "./connection";
import { Controls } from "./controls";
import { Decisions } from "./decisions";
import { DepthView } from "./depth";
import { byId, write } from "./dom";
import { People } from "./people";
import type { Command, Frame, State } from "./protocol";
import { askForKey, redeem } from "./session";
import "./style.css";
import { SurfaceView } from "./surface";
import { setUpTheme } from "./theme";
import { Timing } from "./timing";

const MESSAGE_MS = 6000;

const follow = (track: number) => void ask({ do: "follow", track });
const depth = new DepthView(follow);
const decisions = new Decisions(follow);
const controls = new Controls(ask);
const people = new People(ask);
const timing = new Timing();
const surface = openSurface();
const toggleTheme = setUpTheme(() => surface?.paint());
let source: string | null = null;
let shownFaces: number[] = [];

const connection = new Connection({
  frame: showFrame,
  state: showState,
  connected: showConnection,
  refused: () => {
    showConnection(false, "Not signed in.");
    askForKey(() => connection.open());
  },
});
void redeem().then(() => connection.open());

function showFrame(frame: Frame): void {
  const face = decisions.followed(frame);
  shownFaces = frame.faces.map(({ track }) => track);
  depth.draw(frame, face?.track ?? null);
  decisions.draw(frame);
  timing.draw(frame);
  people.follow(face?.track ?? null);
  byId("surface-figure").toggleAttribute("data-empty", !frame.surface);
  if (frame.surface) surface?.show(frame.surface);
  else surface?.clear();
  document.body.dataset["frame"] = String(frame.frame);
}

function showState(state: State): void {
  if (state.source !== source) depth.reset();
  source = state.source;
  controls.draw(state);
  people.draw(state);
  const status = state.problem ? "problem" : state.ended ? "ended" : state.playing ? "live" : "paused";
  byId("status").dataset["state"] = status;
  write(byId("status-label"), { problem: "Problem", ended: "Ended", live: "Live", paused: "Paused" }[status]);
  const problem = byId("problem");
  problem.hidden = !state.problem;
  write(problem, state.problem ?? "");
}

function showConnection(connected: boolean, reason: string): void {
  const banner = byId("offline");
  banner.hidden = connected;
  write(banner, reason);
  document.body.toggleAttribute("data-offline", !connected);
}

async function ask(command: Command): Promise<string | null> {
  const error = await connection.ask(command);
  if (error) say(error);
  return error;
}

function say(text: string): void {
  const message = byId("message");
  write(message, text);
  message.hidden = false;
  setTimeout(() => {
    if (message.textContent === text) message.hidden = true;
  }, MESSAGE_MS);
}

function openSurface(): SurfaceView | null {
  try {
    return new SurfaceView();
  } catch {
    byId("surface-figure").setAttribute("data-unsupported", "");
    return null;
  }
}

// ── keyboard ────────────────────────────────────────────────────────────────────────────────

const help = byId<HTMLDialogElement>("help");
byId("help-open").onclick = () => help.showModal();

const KEYS: Record<string, () => void> = {
  " ": () => void controls.toggle(),
  ".": () => byId("step").click(),
  r: () => byId("record").click(),
  e: () => people.open(),
  g: () => byId("people").querySelector<HTMLElement>("button")?.focus(),
  t: toggleTheme,
  "?": () => help.showModal(),
};

document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey || document.querySelector("dialog[open]")) return;
  if (event.key === "Escape") people.close();
  const target = event.target as HTMLElement;
  if (target.closest("input, select, textarea")) return;
  if (event.key === " " && target.closest("button, summary")) return; // the button's own key
  const number = Number(event.key);
  const track = number >= 1 ? shownFaces[number - 1] : undefined;
  const action = track === undefined ? KEYS[event.key.toLowerCase()] : () => follow(track);
  if (!action) return;
  event.preventDefault();
  action();
});
