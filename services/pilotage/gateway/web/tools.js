// The view's buttons and the page's keys.

import { find } from "./elements.js";
import { rotate, zoomIn, zoomOut } from "./gestures.js";
import { settings } from "./settings.js";

const TYPING = "input, select, textarea";

/** Connects buttons and keys; returns {moved}, to be called when anything moved the view. */
export function startTools({ view, scene, layers, aim }) {
  const follow = find('[data-tool="follow"]');

  const moved = () => {
    follow.setAttribute("aria-pressed", view.follows);
    scene.touch();
  };
  const fit = () => view.fit();
  const reset = () => {
    view.angle = 0;
    view.follows = true;
    view.fit();
  };
  const doing = {
    in: () => zoomIn(view),
    out: () => zoomOut(view),
    rotate: () => rotate(view),
    fit,
    follow: () => {
      view.follows = !view.follows;
    },
  };
  const keys = { r: doing.rotate, f: fit, 0: reset };

  for (const button of document.querySelectorAll("[data-tool]")) {
    button.addEventListener("click", () => {
      doing[button.dataset.tool]();
      moved();
    });
  }
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.closest?.(TYPING)) return;
    if (event.key === "Escape" && aim.isActive) aim.leave();
    const act = keys[event.key.toLowerCase()];
    if (act) act();
    else if (!layers.toggleKey(event.key.toLowerCase())) return;
    moved();
  });
  find("[data-reset-view]").addEventListener("click", () => {
    settings.forget("layers", "theme", "notice");
    location.reload();
  });
  return { moved };
}
