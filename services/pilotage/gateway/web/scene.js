// The map's two canvases: `floor` changes with view and map only, `live` with every message.
//
// Drawn on demand: a frame is asked for when something has changed, and none while hidden.

import { BeliefLayer } from "./layers/belief.js";
import { cameraView, drawCamera } from "./layers/camera.js";
import { drawCandidates, drawWayThere, labelChosen, labelOthers } from "./layers/candidates.js";
import { drawGoal, drawPath } from "./layers/goal.js";
import { GraphLayer } from "./layers/graph.js";
import { Labels } from "./layers/labels.js";
import { drawMatches } from "./layers/matches.js";
import { drawModes, labelModes } from "./layers/modes.js";
import { PotentialLayer } from "./layers/potential.js";
import { drawOutline, drawPoseAim, drawRobot } from "./layers/robot.js";
import { drawGrid, drawScaleBar } from "./layers/ruler.js";
import { drawEnds, scanEnds, sonarEnds } from "./layers/scan.js";
import { drawTrail } from "./layers/trail.js";
import { Walls } from "./layers/walls.js";
import { drawWay } from "./layers/way.js";
import { Trail, TRAIL_MS } from "./history.js";
import { readPalette } from "./palette.js";
import { intentions } from "./planning.js";
import { RobotMotion } from "./robot_motion.js";
import { isGraphOld, isOfThisMap, lastPlace, matches } from "./topology.js";

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
    this.potential = new PotentialLayer(this.walls, () => this.touch());
    this.graph = new GraphLayer();
    this.route = null;
    this.chosen = null;
    this.trail = new Trail();
    this.motion = new RobotMotion();
    this.lit = null;
    this.ghost = null;
    this.aim = null;
    this.pointer = null;
    this.isOld = false;
    this.isPlanOld = false;
    this.covered = 0;
    this.footWidth = 210;
    this.drawnAt = 0;
    this.isPhone = matchMedia("(width < 760px)");
    new ResizeObserver(() => this.resize()).observe(live);
    document.addEventListener("visibilitychange", () => this.touch());
  }

  takeMap(grid) {
    this.walls.take(grid, this.palette);
    this.view.bounds = this.walls.bounds();
    this.belief.colour(this.palette);
    this.potential.forget();
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

  /** Takes a Graph. */
  takeGraph(graph) {
    this.graph.take(graph);
    this.touch();
  }

  takePotential(message) {
    this.potential.take(message);
  }

  /** Takes where the pointer is, or null. */
  point(at) {
    this.pointer = at;
    if (this.layers.has("potential") && this.potential.field) this.touch();
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
    if (viewBefore !== this.viewKey()) this.onView?.();
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
    const plan = intentions(state);
    const inks = this.planInks();
    if (layers.has("belief")) this.belief.draw(context, view, this.ratio);
    if (layers.has("potential")) this.potential.draw(context, view, this.ratio, inks.goal);
    const places = this.graphInks();
    if (this.hasGraph()) this.drawGraph(context, places);
    this.inPixels(context);
    const way = state.message("mapped_path");
    if (layers.has("trail") && state.isMapping() && way) drawWay(context, view, palette, way.poses);
    if (layers.has("trail")) {
      drawTrail(context, view, palette, this.trail.points, state.clock.unixMs(), TRAIL_MS);
    }
    if (layers.has("scan") && robot) drawEnds(context, view, palette, this.ends(), robot);
    const seen = layers.has("camera") && robot && cameraView(state);
    if (seen) drawCamera(context, view, palette, robot, seen);
    // A map that was made here begins where the robot stood: the truth is of another frame.
    const isTrueMap = !state.message("mapping_status")?.sensor;
    const truth = layers.has("truth") && isTrueMap && state.message("ground_truth");
    if (truth) drawOutline(context, view, palette["text-2"], truth.pose);
    if (layers.has("matches")) {
      for (const { message, isOld } of matches(state)) drawMatches(context, view, palette, message, isOld);
    }
    if (layers.has("goal")) this.drawGoing(context, inks, plan);
    if (layers.has("looks")) this.drawLooks(context, inks, plan, robot);
    this.drawPlaces(context);
    if (robot) this.drawRobot(context, robot);
    this.drawLabels(context, inks, plan, robot);
    if (this.ghost) drawOutline(context, view, palette.robot, this.ghost);
    if (this.aim) this.drawAim(context);
    else if (layers.has("potential") && this.pointer) {
      this.potential.drawArrow(context, view, inks, this.pointer);
    }
  }

  /** Whether the graph is drawn: one of another map would lie anywhere on this one. */
  hasGraph() {
    return this.layers.has("graph") && isOfThisMap(this.state);
  }

  /** The colours of the graph: grey when nobody keeps it. */
  graphInks() {
    const { palette } = this;
    return isGraphOld(this.state) ? { ...palette, graph: palette.stale } : palette;
  }

  drawGraph(context, inks) {
    const { route, chosen } = this;
    const current = lastPlace(this.state, this.graph.graph)?.node.id;
    this.graph.draw(context, this.view, this.ratio, inks, { route, chosen, current });
  }

  /** The colours of what the planner wants: grey when it has gone silent. */
  planInks() {
    const { palette } = this;
    return this.isPlanOld ? { ...palette, goal: palette.stale, robot: palette.stale } : palette;
  }

  drawGoing(context, inks, { goal, path, hasHeading, isLooking }) {
    if (path && !isLooking) drawPath(context, this.view, inks, path.poses);
    if (goal) drawGoal(context, this.view, inks, goal, hasHeading);
  }

  drawLooks(context, inks, { candidates, path }, robot) {
    if (!candidates.length) return;
    drawWayThere(context, this.view, inks, { candidates, path, robot });
    drawCandidates(context, this.view, inks, candidates);
  }

  drawPlaces(context) {
    if (!this.layers.has("places")) return;
    const { list, best } = this.places;
    drawModes(context, this.view, this.palette, list, { best, lit: this.lit });
  }

  /** Labels give way to each other: first the chosen look, then the places, then other looks. */
  drawLabels(context, inks, { candidates, goal }, robot) {
    const { view, layers } = this;
    const labels = new Labels(context, view.size, robot && view.toScreen(robot));
    for (const box of this.floating()) labels.block(box);
    if (goal && layers.has("goal")) labels.keepFree(view.toScreen(goal), 12);
    const looks = layers.has("looks") ? candidates : [];
    const places = layers.has("places") ? this.places.list : [];
    for (const { pose } of places) labels.keepFree(view.toScreen(pose), 10);
    labelChosen(labels, view, inks, looks);
    labelModes(labels, view, this.palette, places);
    labelOthers(labels, view, inks, looks);
    if (this.hasGraph()) this.graph.label(labels, view, this.palette, this.route?.nodes ?? []);
  }

  /** Where chips, tools, legend and the sheet of a phone float, as far as labels must know. */
  floating() {
    const { size, inset } = this.view;
    const { width, height } = size;
    return [
      { x: 0, y: 0, width, height: inset.top - 10 },
      { x: width - 60, y: 0, width: 60, height: inset.top + 240 },
      { x: 0, y: height - inset.bottom, width: this.footWidth, height: inset.bottom },
      { x: 0, y: height - this.covered, width, height: this.covered },
    ];
  }

  drawAim(context) {
    const { view, palette, aim } = this;
    if (aim.isGoal) drawGoal(context, view, palette, aim, aim.isTurned);
    else drawPoseAim(context, view, palette, aim);
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
