// How this browser is let in: an invitation in the address, or a key; both become a cookie that no
// script can read.

import { byId, write } from "./dom";

/** Redeems the invitation of the address, if there is one, and takes it out of the address. */
export async function redeem(): Promise<void> {
  const token = location.hash.slice(1);
  if (!token) return;
  history.replaceState(null, "", location.pathname);
  await signIn(token);
}

/** Asks for a key until one opens a session. */
export function askForKey(then: () => void): void {
  const dialog = byId<HTMLDialogElement>("sign-in");
  const key = byId<HTMLInputElement>("key");
  if (!dialog.open) dialog.showModal();
  dialog.oncancel = (event) => event.preventDefault();
  dialog.querySelector("form")!.onsubmit = (event) => {
    event.preventDefault();
    void signIn(key.value.trim()).then((open) => {
      write(byId("sign-in-error"), open ? "" : "This key is not known here.");
      if (!open) return;
      key.value = "";
      dialog.close();
      then();
    });
  };
}

async function signIn(token: string): Promise<boolean> {
  try {
    const headers = { Authorization: `Bearer ${token}` };
    return (await fetch("live/session", { method: "POST", headers })).ok;
  } catch {
    return false;
  }
}
