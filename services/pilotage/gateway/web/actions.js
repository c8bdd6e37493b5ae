// The buttons that act on robot and localizer: each disabled with its reason when it cannot.

import { find, setText } from "./elements.js";
import { number } from "./format.js";
import { obstacle } from "./permissions.js";

const DONE_MS = 2000;

export class Actions {
  constructor(state, commands, aim) {
    Object.assign(this, { state, commands, aim });
    this.said = new Map();
    this.buttons = [...document.querySelectorAll("[data-action]")];
    for (const button of this.buttons) {
      const name = button.dataset.action;
      button.addEventListener("click", () => this.act(name));
    }
  }

  get wanders() {
    return this.state.message("status")?.mode === "wandering";
  }

  act(name) {
    switch (name) {
      case "set_pose":
        return this.aim.start();
      case "wander":
        return this.try(name, { enabled: !this.wanders });
      case "kidnap":
        return this.try(name, {}, ({ pose }) => `Put at ${number(pose.x, 1)}, ${number(pose.y, 1)}\u202fm`);
      default:
        return this.try(name, {}, () => "Begins from nothing");
    }
  }

  async try(name, body, done = () => "") {
    try {
      this.tell(name, done(await this.commands.send(name, body)), false);
    } catch (error) {
      this.tell(name, error.message, true);
    }
  }

  tell(name, text, isFault) {
    this.said.set(name, { text, isFault, until: performance.now() + DONE_MS * (isFault ? 3 : 1) });
    this.update();
  }

  /** Shows which actions can be taken now, and why the others cannot. */
  update() {
    setText(this.button("wander"), this.wanders ? "Pause" : "Wander");
    for (const button of this.buttons) {
      const reason = obstacle(button.dataset.action, this.state);
      const said = this.said.get(button.dataset.action);
      const isFresh = said && performance.now() < said.until;
      const note = button.nextElementSibling;
      button.disabled = reason !== null;
      setText(note, reason ?? (isFresh ? said.text : ""));
      note.classList.toggle("is-fault", Boolean(!reason && isFresh && said.isFault));
    }
  }

  button(name) {
    return this.buttons.find((button) => button.dataset.action === name);
  }
}
