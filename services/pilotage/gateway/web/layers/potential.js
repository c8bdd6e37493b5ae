// The potential field: lines of equal value only, so that it overlays the belief without mixing.
//
// Lines are found once per message, in a worker, and drawn once per view; until either changes, a
// picture of them is laid over the map. From afar, every other level and rings round single
// pieces of furniture are left out: they would hide the field's shape, and the ways between.

import { gradientAt, isLarge } from "./contours.js";
import { into } from "../geometry.js";
import { placeImage } from "./walls.js";

const LEVELS = 8;
const EVERY = 4;
const ALPHA = 0.65;
const [THIN, THICK] = [1, 1.8];
const ARROW_PX = 30;
const RING_M = 5;
const CLOSE_FROM = 20;

export class PotentialLayer {
  /** `onLines()` hears when the lines of a field that was taken can be drawn. */
  constructor(walls, onLines) {
    Object.assign(this, { walls, onLines });
    this.field = this.lines = this.baked = null;
    this.bakedFor = "";
    this.taken = 0;
    this.worker = new Worker(new URL("./contour_worker.js", import.meta.url), { type: "module" });
    this.worker.onmessage = ({ data }) => this.takeLines(data);
  }

  /** Takes a PotentialField. Where it is exactly zero, nobody can stand. */
  take({ resolution, origin, potential }) {
    const [rows, cols] = potential.shape;
    const data = potential.data.map((value) => (value === 0 ? NaN : value));
    this.field = { rows, cols, data, resolution, origin };
    this.worker.postMessage({ number: ++this.taken, field: { rows, cols, data }, count: LEVELS });
  }

  /** Takes the lines, and the field as they show it, `factor` times as fine. */
  takeLines({ number, lines, fine, factor }) {
    if (number !== this.taken) return;
    const { origin } = this.field;
    const resolution = this.field.resolution / factor;
    const isShape = (line) => isLarge(line, RING_M / resolution);
    const levels = lines.map((level, i) => ({
      shapes: pathOf(level.filter(isShape), resolution),
      rings: pathOf(level.filter((line) => !isShape(line)), resolution),
      pixels: i % EVERY === EVERY - 1 ? THICK : THIN,
    }));
    this.lines = { origin, resolution, fine, levels };
    this.forget();
    this.onLines();
  }

  /** Lets the lines be drawn anew: the map has changed that they are clipped to. */
  forget() {
    this.bakedFor = "";
  }

  draw(context, view, ratio, colour) {
    if (!this.lines) return;
    const { width, height } = context.canvas;
    const { centre, scale, angle, focus } = view;
    const wanted = [centre.x, centre.y, focus.x, focus.y, scale, angle, ratio, width, height, colour].join();
    if (this.bakedFor !== wanted) this.bake(view, ratio, colour, width, height);
    this.bakedFor = wanted;
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.globalAlpha = ALPHA;
    context.drawImage(this.baked, 0, 0);
    context.globalAlpha = 1;
  }

  /** Draws an arrow from the place `at` of the screen, down the field. */
  drawArrow(context, view, palette, at) {
    const rise = this.riseAt(view.toMap(at));
    const length = rise && Math.hypot(rise.x, rise.y);
    if (!length) return;
    const angle = view.screenAngle(Math.atan2(-rise.y, -rise.x));
    for (const [colour, width] of [[palette.free, 5], [palette.goal, 2]]) {
      arrowPath(context, at, angle);
      context.strokeStyle = colour;
      context.lineWidth = width;
      context.lineJoin = context.lineCap = "round";
      context.stroke();
    }
  }

  /** The field's value at a point of the map, or null. */
  valueAt(point) {
    if (!this.field) return null;
    const { rows, cols, data, origin, resolution } = this.field;
    const [col, row] = cellAt(origin, resolution, point).map(Math.floor);
    if (row < 0 || col < 0 || row >= rows || col >= cols) return null;
    const value = data[row * cols + col];
    return Number.isNaN(value) ? null : value;
  }

  /** Direction in which the field rises at a point, in the map frame, or null. */
  riseAt(point) {
    if (!this.lines) return null;
    const { origin, resolution, fine } = this.lines;
    const rise = gradientAt(fine, cellAt(origin, resolution, point));
    if (!rise) return null;
    const [cos, sin] = [Math.cos(origin.theta), Math.sin(origin.theta)];
    return { x: cos * rise.x - sin * rise.y, y: sin * rise.x + cos * rise.y };
  }

  bake(view, ratio, colour, width, height) {
    if (this.baked?.width !== width || this.baked?.height !== height) {
      this.baked = new OffscreenCanvas(width, height);
    }
    const context = this.baked.getContext("2d");
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.globalCompositeOperation = "source-over";
    context.clearRect(0, 0, width, height);
    view.applyTo(context, ratio);
    const { origin, levels } = this.lines;
    placeImage(context, origin);
    context.strokeStyle = colour;
    context.lineJoin = "round";
    const isAfar = view.scale < CLOSE_FROM;
    levels.forEach(({ shapes, rings, pixels }, i) => {
      if (isAfar && i % 2 === 0) return;
      context.lineWidth = pixels / view.scale;
      context.stroke(shapes);
      if (!isAfar) context.stroke(rings);
    });
    if (!this.walls.grid) return;
    context.globalCompositeOperation = "destination-in";
    this.walls.draw(context, view, ratio, "floor");
  }
}

function cellAt(origin, resolution, { x, y }) {
  const local = into(origin, x, y);
  return [local.x / resolution, local.y / resolution];
}

function pathOf(lines, resolution) {
  const path = new Path2D();
  for (const line of lines) {
    line.forEach(([col, row], i) => {
      if (i) path.lineTo(col * resolution, row * resolution);
      else path.moveTo(col * resolution, row * resolution);
    });
  }
  return path;
}

function arrowPath(context, at, angle) {
  const [cos, sin] = [Math.cos(angle), Math.sin(angle)];
  const point = (u, v) => [at.x + cos * u - sin * v, at.y + sin * u + cos * v];
  context.beginPath();
  context.moveTo(...point(6, 0));
  context.lineTo(...point(ARROW_PX, 0));
  context.moveTo(...point(ARROW_PX - 7, -5));
  context.lineTo(...point(ARROW_PX, 0));
  context.lineTo(...point(ARROW_PX - 7, 5));
}
