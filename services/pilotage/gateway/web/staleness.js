// Old data look old: the picture greys, the robot is hatched and says its age; and what is
// still waited for is named.

import { find, setText } from "./elements.js";
import { GONE_S, STALE_S } from "./status.js";
import { seconds } from "./format.js";
import { isSilent } from "./planning.js";

const PATIENCE_MS = 2000;

export class Staleness {
  constructor(state, view, scene) {
    Object.assign(this, { state, view, scene });
    this.startedAt = performance.now();
    this.problem = null;
  }

  /** Shows a sentence instead of the map's until it is null. */
  waitFor(problem) {
    this.problem = problem;
  }

  update() {
    const age = this.state.age("pose");
    const isOld = age !== null && age > STALE_S;
    const stage = find("#stage").classList;
    stage.toggle("is-stale", isOld);
    stage.toggle("is-lost", this.state.contactMs !== null && !this.state.isLinked());
    if (isOld !== this.scene.isOld) this.scene.touch();
    this.scene.isOld = isOld;
    const isPlanOld = isSilent(this.state);
    if (isPlanOld !== this.scene.isPlanOld) this.scene.touch();
    this.scene.isPlanOld = isPlanOld;
    this.showAge(isOld ? age : null);
    this.showWaiting();
  }

  showAge(age) {
    const label = find("#age");
    const robot = this.scene.motion.pose();
    label.hidden = age === null || robot === null;
    if (label.hidden) return;
    setText(label, age > 99 ? "very old" : `${seconds(age)} old${age > GONE_S ? ", not updated" : ""}`);
    const at = this.view.toScreen(robot);
    label.style.transform = `translate(${Math.round(at.x + 20)}px, ${Math.round(at.y + 14)}px)`;
  }

  showWaiting() {
    const isPatient = performance.now() - this.startedAt < PATIENCE_MS;
    const hasMap = this.scene.walls.grid !== null;
    setText(find("#waiting p"), this.problem ?? (hasMap || isPatient ? "" : "Waiting for the map from mapper"));
  }
}
