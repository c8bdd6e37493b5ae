// Where to draw the robot between two estimates: on the way from the last one to the newest.

import { between, distance } from "./geometry.js";

const JUMP_M = 0.5;
const MOST_MS = 150;

export class RobotMotion {
  constructor(now = () => performance.now()) {
    this.now = now;
    this.isCalm = matchMedia("(prefers-reduced-motion: reduce)");
    this.to = null;
  }

  /** Takes a new estimate's pose; a jump is shown as one. */
  take(pose) {
    const at = this.now();
    const here = this.pose();
    const jumps = !here || distance(here, pose) > JUMP_M;
    const lasts = jumps || this.isCalm.matches ? 0 : Math.min(MOST_MS, at - this.at);
    this.from = jumps ? pose : here;
    this.to = pose;
    this.at = at;
    this.lastsMs = lasts;
  }

  pose() {
    if (!this.to) return null;
    return between(this.from, this.to, this.share());
  }

  get isMoving() {
    return this.to !== null && this.share() < 1;
  }

  share() {
    return this.lastsMs > 0 ? Math.min(1, (this.now() - this.at) / this.lastsMs) : 1;
  }
}
