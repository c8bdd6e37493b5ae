// The banner under the strip: lost contact first, then a lost bus, then a service that is down.

import { find, setText } from "./elements.js";
import { timeOfDay } from "./format.js";
import { trouble } from "./status.js";

/** Shows what is wrong with the whole picture, or nothing. */
export function updateBanner(state, nextTryAt) {
  const banner = find("#banner");
  const told = wordsFor(state, nextTryAt);
  banner.hidden = told === null;
  if (!told) return;
  banner.className = `is-${told.kind}`;
  setText(banner, told.text);
}

function wordsFor(state, nextTryAt) {
  if (state.link !== "open") return lostContact(state, nextTryAt);
  const link = state.message("link");
  if (link?.connected === false) {
    const since = timeOfDay(link.since_ns / 1e6);
    const text =
      `The bus is gone since ${since}. Showing the last picture; Stop cannot reach the robot, ` +
      "whose watchdog stops it. The gateway waits for the router.";
    return { kind: "fault", text };
  }
  const text = trouble(state.message("deployment")?.processes ?? []);
  return text && { kind: "warning", text };
}

function lostContact(state, nextTryAt) {
  if (state.contactMs === null) return null;
  const wait = Math.max(0, Math.ceil((nextTryAt - performance.now()) / 1000));
  const again = wait > 0 ? `Trying again in ${wait}\u202fs.` : "Trying again now.";
  const since = timeOfDay(state.contactMs);
  const text =
    `No contact since ${since}. Showing the last picture. ${again} ` +
    "Stop cannot reach the robot from here.";
  return { kind: "fault", text };
}
