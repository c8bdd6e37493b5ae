// Setting a pose on the map: press where it is, drag to where it looks, then confirm.
//
// By keyboard: arrows move it (0.1 m, with shift 1 m), [ and ] turn it by 5 degrees, Enter
// confirms, Escape leaves. The ghost stays until the answer; a refusal is written beside it.

import { find, setText } from "./elements.js";
import { wrap } from "./geometry.js";

const LEAST_DRAG = 8;
const TURN = Math.PI / 36;
const HINT = "Press where the robot is, drag to where it looks. Arrow keys move, [ and ] turn, Esc leaves.";

export class Aim {
  constructor(view, scene, send) {
    Object.assign(this, { view, scene, send });
    this.isActive = false;
    this.box = find("#aim");
    find("[data-confirm]", this.box).addEventListener("click", () => this.confirm());
    find("[data-cancel]", this.box).addEventListener("click", () => this.leave());
  }

  start() {
    this.isActive = true;
    find("#stage").classList.add("is-aiming");
    setText(find("#hint"), HINT);
    find("#hint").hidden = false;
    find("#live").focus();
  }

  leave() {
    this.isActive = false;
    this.scene.aim = null;
    this.box.hidden = true;
    find("#hint").hidden = true;
    find("#stage").classList.remove("is-aiming");
    this.scene.touch();
  }

  press(point) {
    this.pressedAt = point;
    this.put({ ...this.view.toMap(point), theta: this.scene.aim?.theta ?? 0 });
    this.box.hidden = true;
  }

  drag(point) {
    const { x, y } = this.pressedAt;
    if (!this.scene.aim || Math.hypot(point.x - x, point.y - y) < LEAST_DRAG) return;
    const to = this.view.toMap(point);
    const { x: mx, y: my } = this.scene.aim;
    this.put({ x: mx, y: my, theta: Math.atan2(to.y - my, to.x - mx) });
  }

  release() {
    if (this.scene.aim) this.ask();
  }

  key({ key, shiftKey }) {
    const pose = this.scene.aim ?? { ...this.view.toMap(this.view.focus), theta: 0 };
    const step = shiftKey ? 1 : 0.1;
    const moves = {
      ArrowLeft: { x: -step }, ArrowRight: { x: step }, ArrowUp: { y: step }, ArrowDown: { y: -step },
      "[": { theta: TURN }, "]": { theta: -TURN },
    };
    if (key === "Escape") this.leave();
    else if (key === "Enter") this.scene.aim && this.confirm();
    else if (moves[key]) this.put(moved(pose, moves[key], this.view.angle));
    else return false;
    if (moves[key]) this.ask();
    return true;
  }

  put(pose) {
    this.scene.aim = pose;
    this.scene.touch();
  }

  ask() {
    const { x, y, theta } = this.scene.aim;
    const degrees = Math.round((theta * 180) / Math.PI);
    this.say(`Robot at ${x.toFixed(1)}, ${y.toFixed(1)}\u202fm looking ${degrees}°?`);
  }

  say(text) {
    setText(find("p", this.box), text);
    this.box.hidden = false;
    const at = this.view.toScreen(this.scene.aim);
    const { width, height } = this.view.size;
    const left = Math.max(8, Math.min(at.x + 32, width - this.box.offsetWidth - 8));
    const top = Math.max(8, Math.min(at.y + 24, height - this.view.inset.bottom - this.box.offsetHeight - 8));
    this.box.style.transform = `translate(${left}px, ${top}px)`;
  }

  async confirm() {
    const { x, y, theta } = this.scene.aim;
    this.say("Setting the pose…");
    try {
      await this.send({ pose: { x, y, theta: wrap(theta) } });
      this.leave();
    } catch (error) {
      this.say(`Not set: ${error.message}`);
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
  };
}
