// What happened, as the gateway tells it (server-sent events): marks for the charts.

import { WINDOW_MS } from "./history.js";
import { eventText } from "./topology.js";

const MARKED = new Set(["service", "link", "kidnap", "map", "place"]);

/** Follows the events at `address` and keeps the marks of the last two minutes in `marks`. */
export function followEvents(address, marks, clock) {
  const source = new EventSource(address);
  source.addEventListener("message", (message) => {
    const { stamp_ns: stampNs, kind, text } = JSON.parse(message.data);
    if (MARKED.has(kind)) mark(marks, { at: stampNs / 1e6, text }, clock.unixMs());
  });
  return source;
}

/** Marks poses found again, as the topology service tells them; to be corrected is no event. */
export function followRelocalizations(state, graph, marks) {
  let seen = -Infinity;
  state.on("relocalization", (entry) => {
    const now = state.clock.unixMs();
    // Of a log that is replayed fast, stamps run ahead of every clock.
    const at = state.isRealTime() ? entry.stampMs : now;
    // After a lost connection the newest comes once more.
    const isNew = entry.stampMs > seen && now - at < WINDOW_MS;
    seen = Math.max(seen, entry.stampMs);
    if (isNew && entry.message.cause !== "corrected") mark(marks, { at, text: eventText(entry, graph()) }, now);
  });
}

function mark(marks, event, now) {
  marks.push(event);
  while (marks.length && now - marks[0].at > WINDOW_MS) marks.shift();
}
