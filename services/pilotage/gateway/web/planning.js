// What the planner does, in words: pure.

import { capitalized, number, withUnit } from "./format.js";

/** So many candidates have a letter and a label. */
export const LETTERED = 6;
/** Twice a second it says what it does; four times that is late. */
export const SILENT_S = 2;
const UNAVAILABLE = new Set(["down", "given_up", "stopped"]);
const ANY_HEADING = 3;

export const letterOf = (i) => String.fromCharCode(65 + i);

/** Less than this is nothing worth a number. */
const LEAST_BITS = 0.05;

/** How uncertainty is expected to change: "−1.3 bits", or in words that it hardly will. */
export const gainText = (gain) => (gain < LEAST_BITS ? "hardly any gain" : withUnit(-gain, 1, "bits"));

/** The label of candidate `i`: its letter, and its gain if there is one. */
export const lookLabel = (i, gain) => (gain < LEAST_BITS ? letterOf(i) : `${letterOf(i)} ${gainText(gain)}`);

/** What the page draws of the planner's intentions; nothing once it is idle. */
export function intentions(state) {
  const status = state.message("planning_status");
  if (!status || status.mode === "idle") return { candidates: [], path: null, goal: null };
  const isLooking = status.mode === "localizing";
  const told = state.message("goal");
  return {
    candidates: isLooking ? (state.message("plan")?.candidates ?? []) : [],
    path: state.message("path") ?? null,
    goal: status.goal,
    hasHeading: !(told?.heading_tolerance > ANY_HEADING),
    isLooking,
  };
}

/** Whether the planner has gone silent, so that what it wants is old. */
export const isSilent = (state) => (state.age("planning_status") ?? 0) > SILENT_S;

/** What stands in the way of planning here at all: {word, text, reason, isFault}, or null. */
export function absence(state) {
  const process = state.message("deployment")?.processes.find((p) => p.name === "planner");
  if (process && UNAVAILABLE.has(process.state)) return ABSENCES.down;
  const age = state.age("planning_status");
  if (age === null) return process ? ABSENCES.starting : ABSENCES.missing;
  if (age <= SILENT_S) return null;
  const text = `No word for ${withUnit(age, 0, "s")}; what it wanted is old.`;
  return { word: "Planner silent", text, reason: "The planner is silent" };
}

const ABSENCES = {
  down: {
    word: "Planner down",
    text: "Nothing drives by itself until it is back.",
    reason: "The planner is down",
    isFault: true,
  },
  starting: {
    word: "Planner starting",
    text: "It has not said yet what it does.",
    reason: "The planner is starting",
  },
  missing: {
    word: "No planner",
    text: "Topic planning_status has not come; planner should send it.",
    reason: "No planner runs here",
  },
};

/** What it does and why: {word, text, isFault}. */
export function nextLook(state) {
  const missing = absence(state);
  if (missing) return missing;
  const status = state.message("planning_status");
  switch (status.mode) {
    case "localizing":
      return { word: "Resolving doubt", text: lookText(status, state.message("plan")) };
    case "going":
      return { word: "Going", text: goingText(status) };
    case "waiting":
      return { word: "Waiting", text: sentence(status.reason) };
    default:
      return idle(status);
  }
}

function lookText(status, plan) {
  const then = status.goal ? "Then on to the goal." : "";
  if (!plan?.candidates.length) return joined(sentence(status.reason), then);
  const [{ travel, expected_gain: gain, kind }] = plan.candidates;
  const where = kind === "here" ? "Look round from here" : `Drive ${withUnit(travel, 1, "m")} to ${letterOf(0)}`;
  return joined(`${where}: ${gainText(gain)} expected.`, sentence(plan.reason), then);
}

function goingText({ goal, distance_left: left, reason }) {
  const where = goal ? ` to x ${number(goal.x, 1)}, y ${withUnit(goal.y, 1, "m")}` : "";
  const start = left === null ? `On the way${where}.` : `${withUnit(left, 1, "m")} left${where}.`;
  return joined(start, /^going to/i.test(reason) ? "" : sentence(reason));
}

const OUTCOMES = {
  done: "Done",
  cancelled: "Cancelled",
  interrupted: "Interrupted",
  failed: "Gave up",
};

function idle({ outcome, reason, always_localizes: isAlways }) {
  if (outcome in OUTCOMES) {
    return { word: OUTCOMES[outcome], text: sentence(reason), isFault: outcome === "failed" };
  }
  return { word: "Idle", text: isAlways ? "Waits for a doubt to resolve." : "Nothing is planned." };
}

const joined = (...sentences) => sentences.filter(Boolean).join(" ");

/** A reason as a sentence: begun with a capital, ended with a full stop. */
function sentence(text) {
  const told = text.trim();
  return told && capitalized(told) + (/[.!?]$/.test(told) ? "" : ".");
}
