// The panel's "Next look": what the planner does now, and why.

import { find, setText } from "./elements.js";
import { isSilent, nextLook } from "./planning.js";

const PATIENCE_MS = 2000;

export class NextLook {
  constructor(state, { say, alarm }) {
    Object.assign(this, { state, say, alarm });
    this.told = "";
    this.startedAt = performance.now();
  }

  update() {
    const isPatient = performance.now() - this.startedAt < PATIENCE_MS;
    if (isPatient && !this.state.entry("planning_status")) return;
    const { word, text, isFault = false } = nextLook(this.state);
    const box = find("#next");
    setText(find("strong", box), word);
    setText(find("span", box), text);
    find("span", box).className = "quiet";
    box.classList.toggle("is-fault", isFault);
    box.classList.toggle("is-old", !this.state.isLinked() || isSilent(this.state));
    this.announce(word, text, isFault);
  }

  /** Tells changes of what it does; not each metre on the way. */
  announce(word, text, isFault) {
    if (word !== this.told && this.told) (isFault ? this.alarm : this.say)(`${word}. ${text}`);
    this.told = word;
  }
}
