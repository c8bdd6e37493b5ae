// A pose on the map: press where, drag to where it looks, then confirm. For setting the robot's
// pose, and for sending it to a goal; a goal that is not dragged leaves the heading open.
//
// By keyboard: arrows move it (0.1 m, with shift 1 m), [ and ] turn it by 5 degrees, Enter
// confirms, Escape leaves. The ghost stays until the answer; a refusal is written beside it.

import { find, setText } from "./elements.js";
import { degrees, number, withUnit } from "./format.js";
import { wrap } from "./geometry.js";

const LEAST_DRAG = 8;
const TURN = Math.PI / 36;
const ANY_HEADING = 3.14;
const KEYS = " Arrow keys move, [ and ] turn, Enter asks, Esc leaves.";
const hasKeys = matchMedia("(pointer: fine)");

const KINDS = {
  set_pose: {
    hint: "Press where the robot is, drag to where it looks.",
    question: (place, heading) => `Robot at ${place} looking ${heading ?? "0°"}?`,
    asking: "Setting the pose…",
    refused: "Not set",
    body: (pose) => ({ pose }),
  },
  go_to: {
    hint: "Press where it shall go, drag to where it shall look there.",
    question: (place, heading) => `Go to ${place}, ${heading ? `looking ${heading}` : "any heading"}?`,
    asking: "Asking the planner…",
    refused: "Not going",
    body: (pose, isTurned) => ({ pose, ...(isTurned ? {} : { heading_tolerance: ANY_HEADING }) }),
  },
};

export class Aim {
  /** `send(command, body)` gives a command and throws with the reason when it is refused. */
  constructor(view, scene, send) {
    Object.assign(this, { view, scene, send });
    this.isActive = false;
    this.box = find("#aim");
    this.yes = find("[data-confirm]", this.box);
    this.yes.addEventListener("click", () => this.confirm());
    find("[data-cancel]", this.box).addEventListener("click", () => this.leave());
  }

  get words() {
    return KINDS[this.command];
  }

  /** Begins to aim for a command, "set_pose" or "go_to". */
  start(command) {
    this.leave();
    this.isActive = true;
    this.command = command;
    find("#stage").classList.add("is-aiming");
    setText(find("#hint"), this.words.hint + (hasKeys.matches ? KEYS : ""));
    find("#hint").hidden = false;
    find("#live").focus();
  }

  /** Says at a point of the screen why what was wanted there cannot be done. */
  refuse(command, point, reason) {
    this.start(command);
    find("#hint").hidden = true;
    this.press(point);
    this.isRefused = true;
    this.say(`${this.words.refused}: ${reason}`);
  }

  leave() {
    this.isActive = this.isRefused = false;
    this.scene.aim = null;
    this.asked = null;
    this.box.hidden = true;
    find("#hint").hidden = true;
    find("#stage").classList.remove("is-aiming");
    this.scene.touch();
  }

  press(point) {
    if (this.isRefused) return;
    this.pressedAt = point;
    const { theta = 0, isTurned = false } = this.scene.aim ?? {};
    this.put({ ...this.view.toMap(point), theta, isTurned });
    this.box.hidden = true;
  }

  drag(point) {
    if (!this.scene.aim || !this.pressedAt || this.isRefused) return;
    const { x, y } = this.pressedAt;
    if (Math.hypot(point.x - x, point.y - y) < LEAST_DRAG) return;
    const to = this.view.toMap(point);
    const { x: mx, y: my } = this.scene.aim;
    this.put({ x: mx, y: my, theta: Math.atan2(to.y - my, to.x - mx), isTurned: true });
  }

  release() {
    if (this.scene.aim && !this.isRefused) this.ask();
  }

  key({ key, shiftKey }) {
    const pose = this.scene.aim ?? { ...this.view.toMap(this.view.focus), theta: 0, isTurned: false };
    const step = shiftKey ? 1 : 0.1;
    const moves = {
      ArrowLeft: { x: -step }, ArrowRight: { x: step }, ArrowUp: { y: step }, ArrowDown: { y: -step },
      "[": { theta: TURN }, "]": { theta: -TURN },
    };
    if (key === "Escape") this.leave();
    else if (this.isRefused) return false;
    else if (key === "Enter") this.scene.aim && this.confirm();
    else if (moves[key]) this.put(moved(pose, moves[key], this.view.angle));
    else return false;
    if (moves[key]) this.ask();
    return true;
  }

  put(pose) {
    this.asked = null;
    this.scene.aim = { ...pose, isGoal: this.command === "go_to" };
    this.scene.touch();
  }

  ask() {
    const { x, y, theta, isTurned } = this.scene.aim;
    const heading = isTurned ? degrees(theta) : null;
    this.yes.disabled = false;
    setText(this.yes, "Confirm");
    this.say(this.words.question(`${number(x, 1)}, ${withUnit(y, 1, "m")}`, heading));
  }

  say(text) {
    setText(find("p", this.box), text);
    this.yes.hidden = Boolean(this.isRefused);
    this.box.hidden = false;
    const at = this.view.toScreen(this.scene.aim);
    const { width, height } = this.view.size;
    const left = Math.max(8, Math.min(at.x + 32, width - this.box.offsetWidth - 8));
    const top = Math.max(8, Math.min(at.y + 24, height - this.view.inset.bottom - this.box.offsetHeight - 8));
    this.box.style.transform = `translate(${left}px, ${top}px)`;
  }

  /** Asks the robot; what comes when the pose has been changed or left meanwhile is not shown. */
  async confirm() {
    const { command, words, scene } = this;
    const { x, y, theta, isTurned } = scene.aim;
    if (this.asked === scene.aim) return;
    const asked = (this.asked = scene.aim);
    this.yes.disabled = true;
    this.say(words.asking);
    try {
      await this.send(command, words.body({ x, y, theta: wrap(theta) }, isTurned));
      if (this.asked === asked) this.leave();
    } catch (error) {
      if (this.asked !== asked) return;
      this.asked = null;
      this.yes.disabled = false;
      setText(this.yes, "Try again");
      this.say(`${words.refused}: ${error.message}`);
    }
  }
}

/** The pose moved by a step of the screen's own directions, whichever way the map is turned. */
function moved(pose, { x = 0, y = 0, theta = 0 }, angle) {
  const [cos, sin] = [Math.cos(angle), Math.sin(angle)];
  return {
    x: pose.x + cos * x + sin * y,
    y: pose.y - sin * x + cos * y,
    theta: wrap(pose.theta + theta),
    isTurned: pose.isTurned || theta !== 0,
  };
}
