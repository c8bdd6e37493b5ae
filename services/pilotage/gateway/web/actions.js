// The buttons that act on robot, localizer and planner: disabled with the reason when they cannot.

import { find, setText } from "./elements.js";
import { capitalized, number } from "./format.js";
import { Pausing } from "./pausing.js";
import { obstacle } from "./permissions.js";

const DONE_MS = 2000;

export class Actions {
  constructor(state, commands, aim) {
    Object.assign(this, { state, commands, aim });
    this.said = new Map();
    this.pausing = new Pausing(state);
    this.buttons = [...document.querySelectorAll("[data-action]")];
    for (const button of this.buttons) {
      const name = button.dataset.action;
      button.addEventListener("click", () => this.act(name));
    }
    this.always = find("#always");
    this.always.addEventListener("change", () => this.setAlways(this.always.checked));
  }

  get planning() {
    return this.state.message("planning_status");
  }

  get isResolving() {
    return this.planning?.mode === "localizing";
  }

  act(name) {
    switch (name) {
      case "set_pose":
        return this.aim.start("set_pose");
      case "send_goal":
        return this.aim.start("go_to");
      case "resolve":
        return this.resolve();
      case "wander":
        return this.try(name, this.pausing.press());
      case "kidnap":
        return this.try(name, [[name, {}]], ({ pose }) => `Put at ${number(pose.x, 1)}, ${number(pose.y, 1)}\u202fm`);
      default:
        return this.try(name, [[name, {}]], () => "Begins from nothing");
    }
  }

  /** Lets a place of the screen be the goal, or says beside it why it cannot. */
  sendGoalAt(point) {
    const reason = obstacle("go_to", this.state);
    if (reason !== null) return this.aim.refuse("go_to", point, reason);
    this.aim.start("go_to");
    return this.aim.press(point);
  }

  resolve() {
    if (this.isResolving) return this.try("resolve", [["cancel", {}]]);
    const always = this.planning?.always_localizes ?? false;
    return this.try("resolve", [["localize_actively", { always }]], detailOf);
  }

  /** Only giving up everything ends the standing order: what is under way is begun again. */
  async setAlways(isOn) {
    this.isAsking = true;
    if (isOn) await this.try("always", [["localize_actively", { always: true }]], detailOf);
    else await this.try("always", [["cancel", {}], ...this.pausing.resumption(false)]);
    this.isAsking = false;
  }

  /** Gives commands one after the other; `done` words the last reply. */
  async try(name, commands, done = () => "") {
    let reply;
    try {
      for (const [command, body] of commands) reply = await this.commands.send(command, body);
      this.tell(name, done(reply), false);
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
    setText(this.button("wander"), this.pausing.word);
    setText(this.button("resolve"), this.isResolving ? "Stop resolving" : "Resolve doubt");
    for (const button of this.buttons) {
      const name = button.dataset.action;
      const reason = this.reasonAgainst(name);
      button.disabled = reason !== null;
      this.note(button.nextElementSibling, name, reason, name === "resolve" && this.isResolving ? this.onward : "");
    }
    const reason = obstacle("localize_actively", this.state);
    this.always.disabled = reason !== null;
    if (!this.isAsking) this.always.checked = this.planning?.always_localizes ?? false;
    this.note(find("#always-note"), "always", reason, "");
  }

  get onward() {
    return this.planning.goal ? "Then it goes on to the goal" : "Drives so as to find out";
  }

  reasonAgainst(name) {
    switch (name) {
      case "resolve":
        return this.isResolving ? obstacle("cancel", this.state) : this.reasonAgainstResolving();
      case "send_goal":
        return obstacle("go_to", this.state);
      case "wander":
        return obstacle(this.pausing.next[0][0], this.state);
      default:
        return obstacle(name, this.state);
    }
  }

  reasonAgainstResolving() {
    const reason = obstacle("localize_actively", this.state);
    if (reason !== null) return reason;
    return this.state.message("pose")?.state === "localized" ? "There is no doubt now" : null;
  }

  /** Writes below a button why it cannot act, else what it answered just now, else `usual`. */
  note(node, name, reason, usual) {
    const said = this.said.get(name);
    const isFresh = said && said.text && performance.now() < said.until;
    setText(node, reason ?? (isFresh ? said.text : usual));
    node.classList.toggle("is-fault", Boolean(!reason && isFresh && said.isFault));
  }

  button(name) {
    return this.buttons.find((button) => button.dataset.action === name);
  }
}

const detailOf = ({ detail }) => capitalized(detail);
