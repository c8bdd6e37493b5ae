// The legend's second half: how many pairs are matched, and how either side of one is drawn.

import { find, setText } from "./elements.js";
import { matches, matchText } from "./topology.js";

export class Legend {
  constructor(state, layers, scene) {
    Object.assign(this, { state, layers, scene });
    this.part = find("#matched");
  }

  update() {
    const hasCome = ["matched_lines", "matched_features"].some((topic) => this.state.entry(topic));
    this.part.hidden = !hasCome || !this.layers.has("matches");
    this.scene.footWidth = find("#legend").offsetWidth + 24;
    if (this.part.hidden) return;
    const shown = matches(this.state);
    const count = shown.reduce((sum, { message }) => sum + message.kinds.length, 0);
    setText(find("strong", this.part), shown.length ? String(count) : "—");
    setText(find("span", this.part), matchText(this.state) ?? "");
    this.part.classList.toggle("is-old", shown.every(({ isOld }) => isOld));
  }
}
