// Source, play, pause, step, record, denoising: what runs, and how.

import { byId, make, write } from "./dom";
import type { Command, State } from "./protocol";

type Ask = (command: Command) => Promise<string | null>;

export class Controls {
  private readonly source = byId<HTMLSelectElement>("source");
  private readonly denoiser = byId<HTMLSelectElement>("denoiser");
  private readonly play = byId<HTMLButtonElement>("play");
  private readonly step = byId<HTMLButtonElement>("step");
  private readonly record = byId<HTMLButtonElement>("record");
  private state: State | null = null;

  constructor(private readonly ask: Ask) {
    this.play.onclick = () => void this.toggle();
    this.step.onclick = () => void ask({ do: "step" });
    this.record.onclick = () => void ask({ do: "record", on: !this.state?.recording });
    this.source.onchange = () => void ask({ do: "source", name: this.source.value });
    this.denoiser.onchange = () => void ask({ do: "denoise", name: this.denoiser.value });
  }

  toggle(): Promise<string | null> {
    return this.ask({ do: this.state?.playing ? "pause" : "play" });
  }

  draw(state: State): void {
    this.state = state;
    const { playing, recording } = state;
    this.play.dataset["state"] = playing ? "playing" : "paused";
    write(byId("play-label"), playing ? "Pause" : "Play");
    this.step.disabled = playing;
    this.record.dataset["state"] = recording ? "on" : "off";
    this.record.setAttribute("aria-pressed", String(recording !== null));
    write(byId("record-label"), recording ? "Stop" : "Record");
    write(byId("recording"), recording ? `${recording.frames} frames → ${recording.file}` : "");
    choices(this.source, state.sources.map(({ name, label }) => [name, label]), state.source);
    choices(this.denoiser, state.denoisers.map((name) => [name, name]), state.denoiser);
  }
}

function choices(select: HTMLSelectElement, wanted: [string, string][], value: string | null): void {
  const key = JSON.stringify(wanted);
  if (select.dataset["key"] !== key) {
    select.dataset["key"] = key;
    select.replaceChildren(
      ...wanted.map(([name, label]) => {
        const option = make("option", "", label);
        option.value = name;
        return option;
      }),
    );
  }
  if (document.activeElement !== select || select.value === "") select.value = value ?? "";
}
