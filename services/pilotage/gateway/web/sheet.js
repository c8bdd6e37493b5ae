// On a phone the panel is a sheet over the map, at one of three heights; elsewhere it is a panel.

import { find } from "./elements.js";

const LOW_PX = 148;
const SHARES = [null, 0.5, 0.92];
const TAP_PX = 6;

/** Lets the sheet be dragged and tapped; calls `onChange(inset)` with what it covers at rest. */
export function startSheet(onChange) {
  const panel = find("#panel");
  const grab = find("#grab");
  const charts = find("#charts");
  const phone = matchMedia("(width < 760px) and (orientation: portrait)");
  let stop = 0;
  let drag = null;

  const heights = () => SHARES.map((share) => (share === null ? LOW_PX : share * innerHeight));

  function put(next) {
    stop = next;
    panel.style.setProperty("--sheet-height", `${heights()[stop]}px`);
    panel.classList.toggle("is-open", stop > 0);
    grab.setAttribute("aria-expanded", stop > 0);
    if (stop === 0) panel.scrollTop = 0;
  }

  function rearrange() {
    if (phone.matches) panel.append(charts);
    else panel.after(charts);
    // Swiped charts must be reachable by arrow keys as well.
    charts.tabIndex = phone.matches ? 0 : -1;
    put(0);
    onChange(phone.matches ? LOW_PX : 0);
  }

  grab.addEventListener("pointerdown", (event) => {
    grab.setPointerCapture(event.pointerId);
    drag = { y: event.clientY, height: panel.offsetHeight, moved: 0 };
    panel.classList.add("is-dragged");
  });
  grab.addEventListener("pointermove", (event) => {
    if (!drag) return;
    drag.moved = Math.max(drag.moved, Math.abs(event.clientY - drag.y));
    const height = Math.max(LOW_PX, Math.min(heights()[2], drag.height + drag.y - event.clientY));
    panel.style.setProperty("--sheet-height", `${height}px`);
  });
  grab.addEventListener("pointerup", () => {
    panel.classList.remove("is-dragged");
    if (drag && drag.moved > TAP_PX) put(nearest(heights(), panel.offsetHeight));
  });
  grab.addEventListener("click", () => {
    if (!drag || drag.moved <= TAP_PX) put((stop + 1) % SHARES.length);
    drag = null;
  });
  phone.addEventListener("change", rearrange);
  rearrange();
}

const nearest = (values, wanted) =>
  values.reduce((best, value, i) => (Math.abs(value - wanted) < Math.abs(values[best] - wanted) ? i : best), 0);
