// The topological map in words: where on it the robot is, what is matched, what is missing. Pure.

import { distance } from "./geometry.js";
import { countText, nameOf } from "./graph.js";
import { number, withUnit } from "./format.js";

/** Pairs come five times a second; those of a moment ago are old, later there are none. */
export const MATCH_STALE_S = 1;
export const MATCH_GONE_S = 3;
const HERE_M = 1;
const UNAVAILABLE = new Set(["down", "given_up", "stopped"]);

/** What stands in the way of asking the topology service, in words, or null. */
export function absence(state) {
  const process = state.message("deployment")?.processes.find((p) => p.name === "topology");
  if (process && UNAVAILABLE.has(process.state)) {
    return "The topology service is down";
  }
  if (process?.state === "starting") return "The topology service is starting";
  return process || state.entry("heartbeat", "topology") ? null : "No topology service runs here";
}

/** Whether the graph's service has gone, so that what it says of the robot is old. */
export function isGraphOld(state) {
  const process = state.message("deployment")?.processes.find((p) => p.name === "topology");
  if (process) return UNAVAILABLE.has(process.state) || process.state === "late";
  const beat = state.entry("heartbeat", "topology");
  return Boolean(beat) && state.age("heartbeat", "topology") > Math.max(1, beat.message.within);
}

/** Whether the graph is of the map in use. */
export function isOfThisMap(state) {
  const [topology, map] = [state.message("topology"), state.message("map")];
  return !topology || !map || topology.map_id === map.map_id;
}

/** What the chip of the graph says beside its name: {word, text}, or null. */
export function graphTrouble(state) {
  if (!isOfThisMap(state)) {
    return { word: "of another map", text: "The topological map in use is not of this map: build or load one" };
  }
  if (!state.message("topology").nodes.length) {
    return { word: "empty", text: "The topological map has no places yet" };
  }
  if (!isGraphOld(state)) return null;
  return { word: "old", text: `${absence(state) ?? "The topology service is late"}; the graph is as it was` };
}

/** The newest pairs worth showing: [{topic, message, isOld}]. */
export function matches(state) {
  return ["matched_lines", "matched_features"].flatMap((topic) => {
    const age = state.age(topic);
    if (age === null || age > MATCH_GONE_S) return [];
    return [{ topic, message: state.message(topic), isOld: age > MATCH_STALE_S || !state.isLinked() }];
  });
}

/** What the chip of the pairs says beside its name: {word, text}, or null. */
export function matchTrouble(state) {
  if (matches(state).length) return null;
  return { word: "none now", text: `No pair has come for ${withUnit(MATCH_GONE_S, 0, "s")}` };
}

/** The pairs' count in words: "6 lines, 2 corners"; null when none can be shown. */
export function matchText(state) {
  const shown = matches(state);
  if (!shown.length) return null;
  return countText(shown.flatMap(({ message }) => message.kinds)) || "no pair";
}

/** How many pairs the last cycle matched: the localizer's where it tells, else those of the node. */
export function matchCount(state, longest = MATCH_STALE_S) {
  const topic = ["matched_lines", "matched_features"].find((name) => {
    const age = state.age(name);
    return age !== null && age <= longest;
  });
  return topic ? state.message(topic).kinds.length : null;
}

/** The last place reached: {node, entry} of the graph and of what was told there; or null. */
export function lastPlace(state, graph) {
  const told = ["node_arrival", "relocalization"].map((topic) => state.entry(topic)).filter(Boolean);
  const entry = told.sort((a, b) => b.stampMs - a.stampMs)[0];
  const node = entry && graph?.node(entry.message.node);
  if (!node) return null;
  // A graph that was built anew may have given the number to another place.
  const name = told.find(({ message }) => message.node === node.id && message.name)?.message.name;
  return name && name !== node.name ? null : { node, entry };
}

const CAUSES = { corrected: "Pose corrected at", recovered: "Found again at", chain: "Found by a chain of places, at" };

/** What happened at a place, for the charts' marks. */
export function eventText({ topic, message }, graph) {
  const node = graph?.node(message.node);
  const name = node ? nameOf(node) : message.name || `place ${message.node}`;
  return topic === "node_arrival" ? `At ${name}` : `${CAUSES[message.cause] ?? "Found at"} ${name}`;
}

/** The quiet line: at which place it is or was last, and how much of it was seen again. */
export function placeText(state, graph) {
  const last = lastPlace(state, graph);
  if (!last) return "";
  const { node, entry } = last;
  const { message } = entry;
  const pose = state.message("pose")?.pose;
  const away = pose ? distance(pose, node.pose) : 0;
  const of = message.bound ? ` of ${message.bound}` : "";
  const seen = `${message.matched}${of} features matched`;
  if (entry.topic === "relocalization") return `${eventText(entry, graph)}: ${seen}`;
  return away <= HERE_M ? `At ${nameOf(node)}: ${seen}` : `Last at ${nameOf(node)}, ${withUnit(away, 1, "m")} away`;
}

/** The name of the place nearest to a point, or the point itself where none is near. */
export function pointText(point, graph, within = 5) {
  const node = graph?.nearest(point, within);
  return node ? nameOf(node).replaceAll(" ", "\u00a0") : coordinates(point);
}

/** A point of the map, kept on one line. */
export const coordinates = ({ x, y }) => `x\u00a0${number(x, 1)},\u00a0y\u00a0${number(y, 1)}\u202fm`;
