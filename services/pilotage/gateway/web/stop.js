// Stop: always there, acts at once, says what the robot answered and never what was clicked.

import { find, setText } from "./elements.js";
import { withUnit } from "./format.js";

const TWICE_MS = 600;
const SHOWN_MS = 2000;
const TYPING = "input, select, textarea, button, summary, a";

export class Stop {
  constructor(commands, { say, alarm }, popover) {
    Object.assign(this, { commands, say, alarm, popover });
    this.button = find("#stop");
    this.word = find("span", this.button);
    this.escapedAt = -Infinity;
    this.button.addEventListener("click", () => this.act());
    document.addEventListener("keydown", (event) => this.key(event));
  }

  key(event) {
    if (event.repeat) return;
    if (event.key === " " && !event.target.closest?.(TYPING)) {
      event.preventDefault();
      this.act();
    } else if (event.key === "Escape") {
      const now = performance.now();
      if (now - this.escapedAt < TWICE_MS) this.act();
      this.escapedAt = now;
    }
  }

  async act() {
    this.show("Stopping…");
    try {
      const { after } = await this.commands.send("stop");
      const text = `Stopped ${withUnit(after, 2, "s")}`;
      this.show(text, SHOWN_MS);
      this.say(text);
    } catch (error) {
      this.show("Not stopped", 2 * SHOWN_MS);
      this.alarm(`Not stopped: ${error.message}`);
      this.popover.show(this.button, () => [["Not stopped", error.message]]);
    }
  }

  show(text, forMs) {
    setText(this.word, text);
    clearTimeout(this.timer);
    if (forMs) this.timer = setTimeout(() => setText(this.word, "Stop"), forMs);
  }
}
