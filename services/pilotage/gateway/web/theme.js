// Dark or light: as the system says, until the switch says otherwise.

import { settings } from "./settings.js";

/** Applies the theme, lets `button` change it and calls `onChange` whenever colours change. */
export function startTheme(button, onChange) {
  const system = matchMedia("(prefers-color-scheme: light)");
  const current = () => settings.get("theme") ?? (system.matches ? "light" : "dark");
  const apply = () => {
    document.documentElement.dataset.theme = current();
    button.textContent = current() === "dark" ? "Light theme" : "Dark theme";
    onChange();
  };
  system.addEventListener("change", apply);
  button.addEventListener("click", () => {
    settings.set("theme", current() === "dark" ? "light" : "dark");
    apply();
  });
  apply();
  return apply;
}
