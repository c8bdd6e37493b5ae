// The map's two canvases: `floor` changes with view and map only, `live` with every message.
//
// Drawn on demand: a frame is asked for when something has changed, and none while hidden.

import { BeliefLayer } from "./layers/belief.js";
import { drawModes } from "./layers/modes.js";
import { drawAim, drawOutline, drawRobot } from "./layers/robot.js";
import { drawGrid, drawScaleBar } from "./layers/ruler.js";
import { drawEnds, scanEnds, sonarEnds } from "./layers/scan.js";
import { drawTrail } from "./layers/trail.js";
import { Walls } from "./layers/walls.js";
import { drawWay } from "./layers/way.js";
import { Trail, TRAIL_MS } from "./history.js";
import { readPalette } from "./palette.js";
import { RobotMotion } from "./robot_motion.js";

const RATIO_MAX = 2;
const PHONE_FRAME_MS = 1000 / 30;
const RINGS = { lost: "fault", ambiguous: "warning", unknown: "warning" };
const NO_MOUNT = { x: 0, y: 0, theta: 0 };

export class Scene {
  constructor({ floor, live, view, state, layers, places }) {
    Object.assign(this, { floor, live, view, state, layers, places });
    this.palette = readPalette();
    this.walls = new Walls();
    this.belief = new BeliefLayer(this.walls);
    this.trail = new Trail();
    this.motion = new RobotMotion();
    this.lit = null;
    this.ghost = null;
    this.aim = null;
    this.isOld = false;
    this.covered = 0;
    this.drawnAt = 0;
    this.isPhone = matchMedia("(width < 760px)");
    new ResizeObserver(() => this.resize()).observe(live);
    document.addEventListener("visibilitychange", () => this.touch());
  }

  takeMap(grid) {
    this.walls.take(grid, this.palette);
    this.view.bounds = this.walls.bounds();
    this.belief.colour(this.palette);
    this.touchFloor();
  }

  /** Lays a patch over the map it belongs to; says whether it does. */
  takePatch(patch) {
    if (!this.walls.patch(patch, this.palette)) return false;
    this.view.bounds = this.walls.bounds();
    this.touchFloor();
    return true;
  }

  takeBelief(belief) {
    this.belief.take(belief?.marginal ?? null, this.palette);
    this.touch();
  }

  takePose(estimate, atMs) {
    this.motion.take(estimate.pose);
    this.trail.add(atMs, estimate.pose, estimate.state === "localized");
    this.touch();
  }

  recolour() {
    this.palette = readPalette();
    this.walls.colour(this.palette);
    this.belief.colour(this.palette);
    this.touchFloor();
  }

  /** Asks for a frame with the floor in it. */
  touchFloor() {
    this.floorIsDue = true;
    this.touch();
  }

  /** Asks for a frame. */
  touch() {
    if (this.frame || document.hidden) return;
    this.frame = requestAnimationFrame((now) => this.onFrame(now));
  }

  onFrame(now) {
    this.frame = null;
    if (this.isPhone.matches && now - this.drawnAt < PHONE_FRAME_MS - 2) {
      this.touch();
      return;
    }
    this.drawnAt = now;
    const viewBefore = this.viewKey();
    const isZooming = this.view.step();
    const robot = this.motion.pose();
    if (robot && this.state.message("pose")?.state === "localized") this.view.keepInSight(robot);
    if (this.floorIsDue || viewBefore !== this.viewKey()) this.drawFloor();
    this.drawLive(robot);
    if (isZooming || this.motion.isMoving) this.touch();
  }

  viewKey() {
    const { centre, scale, angle } = this.view;
    return `${centre.x} ${centre.y} ${scale} ${angle}`;
  }

  resize() {
    const { width, height } = this.live.getBoundingClientRect();
    this.view.size = { width, height };
    this.ratio = Math.min(RATIO_MAX, devicePixelRatio);
    for (const canvas of [this.floor, this.live]) {
      canvas.width = Math.round(width * this.ratio);
      canvas.height = Math.round(height * this.ratio);
    }
    if (this.view.isFitted) this.view.fit(false);
    this.touchFloor();
    // A canvas that was resized is empty: drawn in a later frame it would flicker.
    cancelAnimationFrame(this.frame);
    this.onFrame(performance.now() + PHONE_FRAME_MS);
  }

  drawFloor() {
    this.floorIsDue = false;
    const context = this.cleared(this.floor);
    this.walls.draw(context, this.view, this.ratio, "floor");
    this.inPixels(context);
    drawGrid(context, this.view, this.palette);
    this.walls.draw(context, this.view, this.ratio, "walls");
    this.inPixels(context);
    drawScaleBar(context, this.view, this.palette, this.covered);
  }

  drawLive(robot) {
    const { view, palette, layers, state } = this;
    const context = this.cleared(this.live);
    if (layers.has("belief")) this.belief.draw(context, view, this.ratio);
    this.inPixels(context);
    const way = state.message("mapped_path");
    if (layers.has("trail") && state.isMapping() && way) drawWay(context, view, palette, way.poses);
    if (layers.has("trail")) {
      drawTrail(context, view, palette, this.trail.points, state.clock.unixMs(), TRAIL_MS);
    }
    if (layers.has("scan") && robot) drawEnds(context, view, palette, this.ends(), robot);
    // A map that was made here begins where the robot stood: the truth is of another frame.
    const isTrueMap = !state.message("mapping_status")?.sensor;
    const truth = layers.has("truth") && isTrueMap && state.message("ground_truth");
    if (truth) drawOutline(context, view, palette["text-2"], truth.pose);
    this.drawPlaces(context, robot);
    if (robot) this.drawRobot(context, robot);
    if (this.ghost) drawOutline(context, view, palette.robot, this.ghost);
    if (this.aim) drawAim(context, view, palette, this.aim);
  }

  drawPlaces(context, robot) {
    if (!this.layers.has("places")) return;
    const at = robot && this.view.toScreen(robot);
    const { list, best } = this.places;
    drawModes(context, this.view, this.palette, list, { best, lit: this.lit, robot: at });
  }

  drawRobot(context, robot) {
    const ring = RINGS[this.state.message("pose").state];
    drawRobot(context, this.view, this.palette, robot, {
      footprint: this.state.message("description")?.footprint,
      ring: ring && this.palette[ring],
      isOld: this.isOld,
    });
  }

  ends() {
    const scan = this.state.message("scan");
    const sonar = this.state.message("sonar");
    if (!scan) return sonar ? sonarEnds(sonar) : [];
    const mounts = this.state.message("description")?.mounts ?? [];
    const mount = mounts.find((m) => m.frame_id === scan.frame_id)?.pose ?? NO_MOUNT;
    return scanEnds(scan, mount);
  }

  cleared(canvas) {
    const context = canvas.getContext("2d");
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, canvas.width, canvas.height);
    return context;
  }

  inPixels(context) {
    context.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
  }
}
