// The places it could be: an ellipse at two standard deviations and a pill with number and mass.

import { ellipseOf } from "../geometry.js";

const LEAST_RADIUS = 4;
const GAP = 8;

/** Draws the ellipses of up to five numbered places; `lit` is the number of the one pointed at. */
export function drawModes(context, view, palette, places, { best, lit }) {
  for (const place of byMass(places)) {
    drawEllipse(context, view, palette, place, place === best, place.number === lit);
  }
}

/** Writes number and mass of each place; where there is no room, the lighter one goes without. */
export function labelModes(labels, view, palette, places) {
  const colours = { fill: palette.panel, edge: palette.mode, ink: palette["text-1"] };
  for (const place of byMass(places)) {
    const { major } = ellipseOf(place.covariance, 2);
    const away = Math.max(20, Math.min(major * view.scale, 60)) + GAP;
    labels.write(`${place.number} · ${place.percent}\u202f%`, view.toScreen(place.pose), away, colours);
  }
}

const byMass = (places) => [...places].sort((a, b) => b.mass - a.mass);

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
