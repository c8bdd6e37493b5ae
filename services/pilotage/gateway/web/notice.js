// The line above the map of the demo: that this is a simulation, and how to connect a robot.

import { find, setText } from "./elements.js";

const SAID_MS = 2000;

/** Shows the line while a simulation runs; calls `onChange` when it comes or goes. */
export function startNotice(state, settings, onChange) {
  const notice = find("#notice");
  const copy = find("[data-copy]", notice);

  const told = { isShown: false };

  told.update = () => {
    const isSimulated = state.message("status")?.source === "simulation";
    const isShown = isSimulated && settings.get("notice", true);
    if (isShown === told.isShown) return;
    told.isShown = isShown;
    notice.hidden = !isShown;
    find("#stage").classList.toggle("has-notice", isShown);
    onChange();
  };
  copy.addEventListener("click", async () => {
    await navigator.clipboard.writeText(find("code", notice).textContent);
    setText(copy, "Copied");
    setTimeout(() => setText(copy, "Copy"), SAID_MS);
  });
  find("[data-close]", notice).addEventListener("click", () => {
    settings.set("notice", false);
    told.update();
  });
  return told;
}
