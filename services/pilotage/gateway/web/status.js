// States in words and shapes: ok, warning, fault, none. No colour stands alone.

import { capitalized, number, withUnit } from "./format.js";

export const STALE_S = 0.5;
export const GONE_S = 3;
const UNTOLD = new Set(["heartbeat", "health", "deployment"]);

/** The one state chip. `estimate` is the newest PoseEstimate, `shown` how many places are listed. */
export function stateChip(estimate, shown, age, isMapping = false) {
  if (!estimate || age === null || age > GONE_S) {
    return { kind: "none", text: isMapping ? "Mapping, no data" : "No data" };
  }
  if (isMapping) return { kind: "ok", text: "Mapping" };
  switch (estimate.state) {
    case "localized":
      return { kind: "ok", text: "Localized" };
    case "ambiguous":
      return { kind: "warning", text: shown > 1 ? `Ambiguous · ${shown} places` : "Ambiguous" };
    case "lost":
      return { kind: "fault", text: "Lost" };
    default:
      return { kind: "warning", text: "Searching" };
  }
}

/** The chip of one process as its launcher tells of it; `rateHz` of what it sends, or null. */
export function processChip(process, rateHz) {
  const name = capitalized(process.name);
  const tries = `try ${process.try_number} of ${process.max_tries}`;
  switch (process.state) {
    case "ready":
      return { kind: "ok", text: rateHz === null ? name : `${name} ${withUnit(rateHz, 1, "Hz")}` };
    case "starting":
      return process.try_number > 0
        ? { kind: "fault", text: `${name} restarting, ${tries}` }
        : { kind: "none", text: `${name} starting` };
    case "late":
      return lateChip(process.name, process.late_for ?? 0);
    case "down":
      return { kind: "fault", text: `${name} down, restarting, ${tries}` };
    case "given_up":
      return { kind: "fault", text: `${name} given up after ${process.try_number} tries` };
    default:
      return { kind: "none", text: `${name} stopped` };
  }
}

/** The chip of a service that is `lateS` s behind with its beats or with what it sends. */
export const lateChip = (service, lateS) => ({
  kind: "warning",
  text: `${capitalized(service)} late ${withUnit(lateS, 1, "s")}`,
});

/** The chip of a service without a launcher, by the age of its heartbeat in s. */
export function heartbeatChip(service, beat, age, rateHz) {
  const name = capitalized(service);
  const limit = Math.max(1, beat.within);
  if (age > limit) return { kind: "fault", text: `${name} silent ${withUnit(age, 1, "s")}` };
  if (beat.state === "starting") return { kind: "none", text: `${name} starting` };
  return { kind: "ok", text: rateHz === null ? name : `${name} ${withUnit(rateHz, 1, "Hz")}` };
}

/** What a service sends steadily, but for its signs of life. */
export function mainStreams(health) {
  return (health?.topics ?? []).filter(
    (topic) => topic.direction === "out" && topic.limit !== null && !UNTOLD.has(topic.topic),
  );
}

/** The fastest of them by its limit; undefined when a service sends events only. */
export function mainStream(health) {
  return mainStreams(health).sort((a, b) => a.limit - b.limit || b.rate_hz - a.rate_hz)[0];
}

/** The rate in Hz of a service's fastest stream, or null. */
export const mainRate = (health) => mainStream(health)?.rate_hz ?? null;

const MEANING = {
  localizer: "The pose on the map is frozen",
  mapper: "The map is frozen",
  planner: "Nothing drives by itself",
  robot: "Nothing comes from the robot; its watchdog has stopped it",
  router: "Nothing gets through; everyone waits for the router",
  launcher: "Nobody restarts what fails",
};

/** What happened, what it means and what is done about it; null when all is well. */
export function trouble(processes) {
  const down = processes.find((p) => p.state === "down" || p.state === "given_up");
  if (!down) return null;
  const reason = down.reason ? ` (${down.reason})` : "";
  const remedy =
    down.state === "given_up"
      ? "It is not restarted any more: start it by hand"
      : `Restarting, try ${down.try_number} of ${down.max_tries}`;
  const meaning = MEANING[down.name] ?? "What it does is missing";
  return `${capitalized(down.name)} stopped${reason}. ${meaning}. ${remedy}.`;
}

/** The source of the data in a few words: "demo", "lab_02 · live", "replay 42 %". */
export function sourceText(robot, status) {
  if (!status) return robot ?? "";
  if (status.source === "simulation") return robot === "demo" ? "demo" : `${robot} · simulation`;
  if (status.source === "live") return `${robot} · live`;
  const speed = status.speed_factor === 1 ? "" : ` · ${number(status.speed_factor, 0)}×`;
  const done = status.progress === null ? "" : ` ${withUnit(Math.floor(status.progress * 100), 0, "%")}`;
  return `replay${done}${speed}`;
}

/**
 * How sure it is: the one big number. Localized, it is the calibrated `confidence`; otherwise the
 * share of the belief in the best place. Neither is ever dressed up as the other.
 */
export function certainty(estimate, modes) {
  if (estimate?.state === "localized") {
    return { share: estimate.confidence, about: "inside 0.5\u202fm and 15° of" };
  }
  if (modes.length === 0) return null;
  return { share: modes[0].mass, about: "inside 0.5\u202fm of place" };
}
