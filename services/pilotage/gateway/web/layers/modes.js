// The places it could be: an ellipse at two standard deviations and a pill with number and mass.

import { ellipseOf } from "../geometry.js";

const LEAST_RADIUS = 4;
const PILL = { height: 22, gap: 8, padding: 10 };

/** Draws up to five numbered places; `lit` is the number of the one pointed at. */
export function drawModes(context, view, palette, places, { best, lit, robot }) {
  const ordered = [...places].sort((a, b) => b.mass - a.mass);
  for (const place of ordered) drawEllipse(context, view, palette, place, place === best, place.number === lit);
  const taken = robot ? [{ x: robot.x - 20, y: robot.y - 20, width: 40, height: 40 }] : [];
  for (const place of ordered) drawPill(context, view, palette, place, taken);
}

function drawEllipse(context, view, palette, place, isBest, isLit) {
  const { major, minor, direction } = ellipseOf(place.covariance, 2);
  const at = view.toScreen(place.pose);
  context.beginPath();
  const radii = [major, minor].map((half) => Math.max(LEAST_RADIUS, half * view.scale));
  context.ellipse(at.x, at.y, ...radii, view.screenAngle(direction), 0, 2 * Math.PI);
  const width = isLit ? 4 : isBest ? 2 : 1.5;
  // On the bright middle of a sharp belief the line would be lost without a casing.
  context.strokeStyle = palette.free;
  context.lineWidth = width + 3;
  context.stroke();
  context.strokeStyle = palette.mode;
  context.lineWidth = width;
  context.setLineDash(isBest ? [] : [5, 4]);
  context.stroke();
  context.setLineDash([]);
}

/** Puts the pill above its place, else below, else beside; the lighter one goes if none is free. */
function drawPill(context, view, palette, place, taken) {
  const text = `${place.number} · ${place.percent}\u202f%`;
  context.font = "600 12px Inter, system-ui, sans-serif";
  const width = Math.ceil(context.measureText(text).width) + 2 * PILL.padding;
  const box = spots(view, place, width).find((spot) => !taken.some((other) => overlap(spot, other)));
  if (!box) return;
  taken.push(box);
  context.beginPath();
  context.roundRect(box.x + 0.5, box.y + 0.5, box.width, box.height, PILL.height / 2);
  context.fillStyle = palette.panel;
  context.fill();
  context.strokeStyle = palette.mode;
  context.lineWidth = 1.5;
  context.stroke();
  context.fillStyle = palette["text-1"];
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.fillText(text, box.x + box.width / 2, box.y + box.height / 2 + 1);
}

function spots(view, place, width) {
  const at = view.toScreen(place.pose);
  const { major } = ellipseOf(place.covariance, 2);
  const away = Math.max(20, Math.min(major * view.scale, 60)) + PILL.gap;
  const size = { width, height: PILL.height };
  return [
    { x: at.x - width / 2, y: at.y - away - PILL.height, ...size },
    { x: at.x - width / 2, y: at.y + away, ...size },
    { x: at.x + away, y: at.y - PILL.height / 2, ...size },
    { x: at.x - away - width, y: at.y - PILL.height / 2, ...size },
  ].map((box) => ({ ...box, x: Math.round(box.x), y: Math.round(box.y) }));
}

export function overlap(a, b) {
  return a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height;
}
