// The drive buttons: a click is one step, holding keeps going until it is let go.
//
// Held, the wanted twist is sent five times a second; the robot's watchdog stops it half a second
// after the last one, whatever becomes of this page.

import { find, setText } from "./elements.js";
import { obstacle } from "./permissions.js";

const HOLD_MS = 350;
const REPEAT_MS = 200;
const HELP = "Click for one step, hold to keep going.";
const SHOWN_MS = 6000;
const SPEED = 0.3;
const RATE = 0.6;

const TWISTS = {
  forward: { vx: SPEED, vy: 0, omega: 0 },
  backward: { vx: -SPEED, vy: 0, omega: 0 },
  left: { vx: 0, vy: 0, omega: RATE },
  right: { vx: 0, vy: 0, omega: -RATE },
};
const STILL = { vx: 0, vy: 0, omega: 0 };

export class Driving {
  constructor(state, commands) {
    Object.assign(this, { state, commands });
    this.buttons = [...document.querySelectorAll("[data-drive]")];
    this.note = find("#drive-reason");
    for (const button of this.buttons) this.listen(button);
    addEventListener("blur", () => this.release());
  }

  listen(button) {
    button.addEventListener("pointerdown", () => {
      this.waiting = setTimeout(() => this.hold(button), HOLD_MS);
    });
    for (const name of ["pointerup", "pointerleave", "pointercancel"]) {
      button.addEventListener(name, () => this.release());
    }
    button.addEventListener("click", () => {
      if (!this.wasHeld) this.step(button.dataset.drive);
      this.wasHeld = false;
    });
  }

  step(direction) {
    const distance = Number(find("#distance").value);
    const angle = (Number(find("#angle").value) * Math.PI) / 180;
    if (direction === "left") return this.try("turn", { angle });
    if (direction === "right") return this.try("turn", { angle: -angle });
    return this.try(direction, { distance });
  }

  hold(button) {
    if (obstacle("velocity", this.state) !== null) return;
    this.wasHeld = true;
    this.held = button;
    button.classList.add("is-held");
    const push = () => this.try("velocity", { twist: TWISTS[button.dataset.drive] });
    push();
    this.pushing = setInterval(push, REPEAT_MS);
  }

  release() {
    clearTimeout(this.waiting);
    if (!this.held) return;
    clearInterval(this.pushing);
    this.held.classList.remove("is-held");
    this.held = null;
    this.try("velocity", { twist: STILL });
  }

  async try(name, body) {
    try {
      await this.commands.send(name, body);
      this.said = null;
    } catch (error) {
      this.said = { text: error.message, until: performance.now() + SHOWN_MS };
    }
    this.update();
  }

  /** Shows whether the robot can be driven now, and if not, why not. */
  update() {
    const reasons = this.buttons.map((button) => {
      const name = { left: "turn", right: "turn" }[button.dataset.drive] ?? button.dataset.drive;
      const reason = obstacle(name, this.state);
      button.disabled = reason !== null;
      return reason;
    });
    const isFresh = this.said && performance.now() < this.said.until;
    const reason = reasons.find((text) => text !== null);
    setText(this.note, reason ?? (isFresh ? this.said.text : HELP));
    this.note.classList.toggle("is-fault", Boolean(!reason && isFresh));
  }
}
