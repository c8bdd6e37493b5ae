// What happened, as the gateway tells it (server-sent events): marks for the charts.

import { WINDOW_MS } from "./history.js";

const KINDS = ["localization", "service", "link", "command", "refusal", "kidnap", "map"];
const MARKED = new Set(["service", "link", "kidnap", "map"]);

/** Follows the events at `address` and keeps the marks of the last two minutes in `marks`. */
export function followEvents(address, marks, clock) {
  const source = new EventSource(address);
  for (const kind of KINDS) {
    source.addEventListener(kind, (message) => {
      const { stamp_ns: stampNs, text } = JSON.parse(message.data);
      if (!MARKED.has(kind)) return;
      marks.push({ at: stampNs / 1e6, text });
      while (marks.length && clock.unixMs() - marks[0].at > WINDOW_MS) marks.shift();
    });
  }
  return source;
}
