// One button for whatever drives the robot by itself: it pauses that, and lets it go on.

import { isSilent } from "./planning.js";

export class Pausing {
  constructor(state) {
    this.state = state;
    this.paused = [];
  }

  get isPlanning() {
    if (isSilent(this.state)) return false;
    return (this.state.message("planning_status")?.mode ?? "idle") !== "idle";
  }

  get isWandering() {
    return this.state.message("status")?.mode === "wandering";
  }

  /** Whether it was this button that ended the planner's last task. */
  get isPaused() {
    return this.paused.length > 0 && this.state.message("planning_status")?.outcome === "cancelled";
  }

  /** What a press does, in a word. */
  get word() {
    if (this.isPlanning || this.isWandering) return "Pause";
    return this.isPaused ? "Go on" : "Wander";
  }

  /** The commands of the next press: [[name, body], ...]. */
  get next() {
    if (this.isPlanning) return [["cancel", {}]];
    if (this.isWandering) return [["wander", { enabled: false }]];
    return this.isPaused ? this.paused : [["wander", { enabled: true }]];
  }

  /** Returns the commands of this press; what it interrupts is kept in mind. */
  press() {
    const commands = this.next;
    this.paused = this.isPlanning ? this.resumption() : [];
    return commands;
  }

  /** The commands that let the planner go on with what it does now, doubts resolved or not. */
  resumption(always = this.state.message("planning_status")?.always_localizes ?? false) {
    if (!this.isPlanning) return [];
    const { goal } = this.state.message("planning_status");
    if (!goal) return [["localize_actively", { always }]];
    const told = this.state.message("goal");
    const tolerance = told && {
      position_tolerance: told.position_tolerance,
      heading_tolerance: told.heading_tolerance,
    };
    const going = ["go_to", { pose: goal, ...tolerance }];
    return always ? [going, ["localize_actively", { always }]] : [going];
  }
}
