// The robot where it is believed to be, where it really is when that is known, and ghosts.

import { compose } from "../geometry.js";

const ARROW = [[12, 0], [-12, 9], [-7, 0], [-12, -9]];
const RING = 16;

/** Draws the robot; `ring` is a colour or null, `isOld` hatches it. */
export function drawRobot(context, view, palette, pose, { footprint, ring, isOld }) {
  const at = view.toScreen(pose);
  if (ring) {
    context.beginPath();
    context.arc(at.x, at.y, RING, 0, 2 * Math.PI);
    stroke(context, palette.free, 5);
    stroke(context, ring, 2.5);
  }
  if (footprint && isLarger(footprint, view.scale)) {
    footprintPath(context, view, pose, footprint);
    stroke(context, palette.free, 4);
    stroke(context, palette.robot, 1.5);
  }
  arrowPath(context, view, pose);
  stroke(context, palette.free, 6);
  context.fillStyle = isOld ? hatch(context, palette) : palette.robot;
  context.fill();
  if (isOld) stroke(context, palette.robot, 1.5);
}

/** Draws a dashed outline: the reference pose, or where it was at a moment of the charts. */
export function drawOutline(context, view, colour, pose) {
  arrowPath(context, view, pose);
  context.setLineDash([4, 3]);
  stroke(context, colour, 2);
  context.setLineDash([]);
}

/** Draws the pose that is being set, with the line along which it is aimed. */
export function drawPoseAim(context, view, palette, pose) {
  const at = view.toScreen(pose);
  const angle = view.screenAngle(pose.theta);
  context.beginPath();
  context.arc(at.x, at.y, RING, 0, 2 * Math.PI);
  context.moveTo(at.x + RING * Math.cos(angle), at.y + RING * Math.sin(angle));
  context.lineTo(at.x + 48 * Math.cos(angle), at.y + 48 * Math.sin(angle));
  stroke(context, palette.free, 5);
  stroke(context, palette.accent, 2);
  arrowPath(context, view, pose);
  context.fillStyle = palette.accent;
  context.fill();
}

function arrowPath(context, view, pose) {
  const at = view.toScreen(pose);
  const angle = view.screenAngle(pose.theta);
  const [cos, sin] = [Math.cos(angle), Math.sin(angle)];
  context.beginPath();
  for (const [u, v] of ARROW) context.lineTo(at.x + cos * u - sin * v, at.y + sin * u + cos * v);
  context.closePath();
}

function footprintPath(context, view, pose, { shape, data }) {
  context.beginPath();
  for (let i = 0; i < shape[0]; i++) {
    const corner = compose(pose, { x: data[2 * i], y: data[2 * i + 1], theta: 0 });
    const at = view.toScreen(corner);
    context.lineTo(at.x, at.y);
  }
  context.closePath();
}

/** Whether the robot's true outline is larger on the screen than the arrow. */
function isLarger({ data }, scale) {
  return scale * Math.max(...data.map(Math.abs)) > 14;
}

function hatch(context, palette) {
  const tile = new OffscreenCanvas(6, 6);
  const pen = tile.getContext("2d");
  pen.fillStyle = palette.free;
  pen.fillRect(0, 0, 6, 6);
  pen.strokeStyle = palette.robot;
  pen.lineWidth = 2;
  for (const from of [-6, 0, 6]) {
    pen.moveTo(from - 1, 7);
    pen.lineTo(from + 7, -1);
  }
  pen.stroke();
  return context.createPattern(tile, "repeat");
}

function stroke(context, colour, width) {
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.lineJoin = "round";
  context.stroke();
}
