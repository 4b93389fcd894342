// The gallery: who is enrolled, delete, and enrolling the face that is followed.

import { byId, make, write } from "./dom";
import type { Command, Enrolment, State } from "./protocol";

type Ask = (command: Command) => Promise<string | null>;

export class People {
  private readonly list = byId("people");
  private readonly form = byId<HTMLFormElement>("enrol-form");
  private readonly name = byId<HTMLInputElement>("enrol-name");
  private readonly start = byId<HTMLButtonElement>("enrol");
  private readonly progress = byId("enrolment");
  private readonly steps = byId("steps");
  private readonly confirm = byId<HTMLDialogElement>("confirm");
  private followed: number | null = null;
  private meant: number | null = null; // whose name is being typed, whoever comes next
  private key = "";

  constructor(private readonly ask: Ask) {
    this.start.onclick = () => this.open();
    byId("enrol-close").onclick = () => this.close();
    byId("enrol-cancel").onclick = () => void ask({ do: "cancel" });
    byId("enrol-save").onclick = () => void ask({ do: "save" });
    this.form.onsubmit = (event) => {
      event.preventDefault();
      void this.begin();
    };
  }

  /** Opens the form, where somebody stands there. */
  open(): void {
    if (this.start.disabled || this.start.hidden) return;
    this.meant = this.followed;
    this.form.hidden = false;
    this.start.hidden = true;
    this.name.focus();
  }

  close(): void {
    if (this.form.hidden) return;
    this.form.hidden = true;
    this.start.hidden = !this.progress.hidden;
    if (!this.start.hidden) this.start.focus();
  }

  follow(track: number | null): void {
    this.followed = track;
    this.start.disabled = track === null;
  }

  draw({ gallery, enrolment }: State): void {
    write(byId("count"), String(gallery.length));
    const key = JSON.stringify(gallery);
    if (key !== this.key) {
      this.key = key;
      this.list.replaceChildren(...gallery.map(({ subject }) => this.row(subject)));
      byId("nobody").hidden = gallery.length > 0;
    }
    this.progress.hidden = enrolment === null;
    if (enrolment) {
      this.form.hidden = true;
      this.start.hidden = true;
      this.guide(enrolment);
    } else if (this.form.hidden) this.start.hidden = false;
  }

  private async begin(): Promise<void> {
    const subject = this.name.value.trim();
    if (!subject || this.meant === null) return;
    const error = await this.ask({ do: "enrol", subject, track: this.meant });
    if (error) return;
    this.name.value = "";
    this.form.hidden = true;
  }

  private guide({ subject, hint, steps, sufficient }: Enrolment): void {
    write(byId("enrol-who"), `Enrolling ${subject}`);
    write(byId("hint"), hint);
    while (this.steps.children.length > steps.length) this.steps.lastElementChild!.remove();
    steps.forEach(({ label, done, needed }, i) => {
      const row = this.steps.children[i] ?? this.steps.appendChild(make("li", "", make("span"), make("progress")));
      const bar = row.lastElementChild as HTMLProgressElement;
      row.className = done >= needed ? "done" : "";
      write(row.firstElementChild!, label);
      bar.max = needed;
      bar.value = Math.min(done, needed);
      bar.setAttribute("aria-label", label);
    });
    byId<HTMLButtonElement>("enrol-save").disabled = !sufficient;
  }

  private row(subject: string): HTMLElement {
    const remove = make("button", "quiet", "Delete");
    remove.type = "button";
    remove.setAttribute("aria-label", `Delete ${subject}`);
    remove.onclick = () => this.remove(subject);
    return make("li", "", make("span", "face", initials(subject)), make("span", "name", subject), remove);
  }

  private remove(subject: string): void {
    write(byId("confirm-who"), `Delete ${subject}?`);
    this.confirm.returnValue = "";
    this.confirm.onclose = () => {
      if (this.confirm.returnValue === "delete") void this.ask({ do: "delete", subject });
    };
    this.confirm.showModal();
  }
}

function initials(subject: string): string {
  const words = subject.split(/\s+/).filter(Boolean);
  return words.slice(0, 2).map((word) => [...word][0]!.toUpperCase()).join("");
}
