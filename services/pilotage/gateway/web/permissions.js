// Which command can be given now, and if not, why not: null means that it can.

import { absence } from "./planning.js";
import { absence as absenceOfTopology } from "./topology.js";

const NAMES = {
  set_pose: "localizer",
  relocalize: "localizer",
  map_start: "mapper",
  map_stop: "mapper",
  go_to: "planner",
  localize_actively: "planner",
  cancel: "planner",
  topology_build: "topology",
  topology_route: "topology",
};
const UNAVAILABLE = new Set(["down", "given_up", "stopped"]);

/**
 * Returns the reason why command `name` cannot be given, in words, or null. To ask for a route
 * is open to those as well who may only look.
 */
export function obstacle(name, state) {
  if (state.link !== "open") return "No contact";
  if (state.message("link")?.connected === false) return "The gateway has lost the bus";
  if (state.forbidden && name !== "topology_route") return state.forbidden;
  const service = NAMES[name] ?? "robot";
  const process = state.message("deployment")?.processes.find((p) => p.name === service);
  if (process && UNAVAILABLE.has(process.state)) return `The ${service}${service === "topology" ? " service" : ""} is down`;
  if (service === "mapper") return mapperObstacle(state);
  if (service === "planner") return plannerObstacle(name, state);
  if (service === "topology") return topologyObstacle(name, state);
  return service === "localizer" ? localizerObstacle(state) : robotObstacle(name, state);
}

function mapperObstacle(state) {
  const mode = state.message("mapping_status")?.mode;
  if (!mode) return "The mapper has not said what it does";
  return mode === "handing_over" ? "The localizer is about to take over" : null;
}

function localizerObstacle(state) {
  if (state.isMapping()) return "A map is being made";
  return state.entry("map") ? null : "There is no map yet";
}

function topologyObstacle(name, state) {
  const missing = absenceOfTopology(state);
  if (missing) return missing;
  if (name === "topology_route") return state.entry("pose") ? null : "No pose has come yet";
  return localizerObstacle(state);
}

function plannerObstacle(name, state) {
  if (state.message("status")?.source === "replay") return "A recorded run cannot be driven";
  const missing = absence(state);
  if (missing) return missing.reason;
  if (name === "cancel") return null;
  return localizerObstacle(state) ?? (state.entry("pose") ? null : "No pose has come yet");
}

function robotObstacle(name, state) {
  const status = state.message("status");
  if (name === "kidnap" && status && status.source !== "simulation") {
    return "Only a simulated robot can be carried away";
  }
  const description = state.message("description");
  if (!description) return "The robot has not said what it can do";
  if (description.commands.includes(name)) return null;
  return status?.source === "replay" ? "A recorded run cannot be driven" : "This robot cannot do that";
}
