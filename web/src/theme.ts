// Dark or light: as the system says, until the user chooses.

import { byId, write } from "./dom";

const KEY = "rangeface-theme";

export function setUpTheme(onChange: () => void): () => void {
  const system = matchMedia("(prefers-color-scheme: dark)");
  const button = byId<HTMLButtonElement>("theme");
  const dark = () => (localStorage.getItem(KEY) ?? (system.matches ? "dark" : "light")) === "dark";
  const apply = () => {
    document.documentElement.dataset["theme"] = dark() ? "dark" : "light";
    write(byId("theme-label"), dark() ? "Light" : "Dark");
    onChange();
  };
  const toggle = () => {
    localStorage.setItem(KEY, dark() ? "light" : "dark");
    apply();
  };
  button.onclick = toggle;
  system.addEventListener("change", apply);
  apply();
  return toggle;
}
