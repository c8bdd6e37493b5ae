// Places from which the robot might look: hollow diamonds, and what each look is expected to tell.

import { LETTERED, lookLabel } from "../planning.js";
import { pathLine } from "./goal.js";

const HALF = 7;
const MINOR_HALF = 4;
const MINOR_ALPHA = 0.45;

/** Draws the dashed way to the chosen one: the planner's `path`, or straight from `robot`. */
export function drawWayThere(context, view, palette, { candidates, path, robot }) {
  const straight = robot && { shape: [2, 3], data: [...pose(robot), ...pose(candidates[0].pose)] };
  const way = path?.poses.shape[0] > 1 ? path.poses : straight;
  if (!way || !pathLine(context, view, way)) return;
  context.lineJoin = "round";
  context.lineCap = "butt";
  context.strokeStyle = palette.free;
  context.lineWidth = 5;
  context.stroke();
  context.strokeStyle = palette.robot;
  context.lineWidth = 2;
  context.setLineDash([4, 4]);
  context.stroke();
  context.setLineDash([]);
}

/** Draws all candidates, the chosen one last and on top. */
export function drawCandidates(context, view, palette, candidates) {
  for (let i = candidates.length - 1; i >= 0; i--) {
    const isMinor = i >= LETTERED;
    diamond(context, view.toScreen(candidates[i].pose), isMinor ? MINOR_HALF : HALF);
    context.lineJoin = "miter";
    context.globalAlpha = isMinor ? MINOR_ALPHA : 1;
    context.strokeStyle = palette.free;
    context.lineWidth = isMinor ? 3 : 5;
    context.stroke();
    context.strokeStyle = palette.robot;
    context.lineWidth = i === 0 ? 2.5 : 1.5;
    context.stroke();
  }
  context.globalAlpha = 1;
}

/** Keeps the lettered diamonds free of labels, then writes letter and gain of the chosen one. */
export function labelChosen(labels, view, palette, candidates) {
  for (const { pose: at } of candidates.slice(0, LETTERED)) labels.keepFree(view.toScreen(at), HALF);
  if (candidates.length) write(labels, view, palette, candidates, 0);
}

/** Writes letter and gain of the others that have letters, as far as there is room. */
export function labelOthers(labels, view, palette, candidates) {
  for (let i = 1; i < Math.min(LETTERED, candidates.length); i++) {
    write(labels, view, palette, candidates, i);
  }
}

function write(labels, view, palette, candidates, i) {
  const { pose: at, expected_gain: gain } = candidates[i];
  const colours = { fill: palette.panel, edge: i ? palette["text-3"] : palette.robot, ink: palette["text-1"] };
  labels.write(lookLabel(i, gain), view.toScreen(at), HALF + 5, colours);
}

function diamond(context, { x, y }, half) {
  context.beginPath();
  context.moveTo(x, y - half);
  context.lineTo(x + half, y);
  context.lineTo(x, y + half);
  context.lineTo(x - half, y);
  context.closePath();
}

const pose = ({ x, y, theta }) => [x, y, theta];
