// What is seen now beside what the map has, pair by pair, joined by a dash.
//
// The map's side is broad and pale, what is seen thin and clear: where both agree, one lies
// within the other. A corner is a point: a square of the map, a cross of what is seen.

const [EXPECTED, SEEN] = [6, 2];
const PALE = 0.6;
const [SQUARE, CROSS] = [5, 4];
const POINT_M = 0.02;

/** Draws the pairs of a MatchedPairs; `isOld` in grey. */
export function drawMatches(context, view, palette, { seen, expected }, isOld) {
  const inks = isOld ? { expected: palette.stale, seen: palette.stale } : { expected: palette.graph, seen: palette.robot };
  const pairs = Array.from({ length: seen.shape[0] }, (_, i) => [expected, seen].map((side) => placed(view, side, i)));
  context.lineCap = "round";
  context.globalAlpha = PALE;
  for (const [map] of pairs) strokeSide(context, map, inks.expected, EXPECTED, squarePath);
  context.globalAlpha = 1;
  for (const pair of pairs) strokeJoint(context, palette, pair);
  for (const [, now] of pairs) {
    if (!isOld) strokeSide(context, now, palette.free, SEEN + 2.5, crossPath);
    strokeSide(context, now, inks.seen, SEEN, crossPath);
  }
}

/** One side of pair `i` on the screen: its two ends, and whether it is a point. */
function placed(view, { data }, i) {
  const [x0, y0, x1, y1] = data.subarray(4 * i, 4 * i + 4);
  const isPoint = Math.hypot(x1 - x0, y1 - y0) < POINT_M;
  return { a: view.toScreen({ x: x0, y: y0 }), b: view.toScreen({ x: x1, y: y1 }), isPoint };
}

function strokeSide(context, { a, b, isPoint }, colour, width, pointPath) {
  context.beginPath();
  if (isPoint) pointPath(context, a);
  else {
    context.moveTo(a.x, a.y);
    context.lineTo(b.x, b.y);
  }
  context.strokeStyle = colour;
  context.lineWidth = isPoint ? Math.min(width, SEEN + 2.5) : width;
  context.stroke();
}

/** The dash from the middle of what is seen to the nearest point of what the map has. */
function strokeJoint(context, palette, [map, now]) {
  const from = middle(now);
  const to = nearestOn(map, from);
  context.beginPath();
  context.moveTo(from.x, from.y);
  context.lineTo(to.x, to.y);
  context.setLineDash([3, 3]);
  context.lineCap = "butt";
  context.strokeStyle = palette["text-1"];
  context.lineWidth = 1.5;
  context.stroke();
  context.setLineDash([]);
  context.lineCap = "round";
}

const middle = ({ a, b }) => ({ x: (a.x + b.x) / 2, y: (a.y + b.y) / 2 });

function nearestOn({ a, b }, { x, y }) {
  const [dx, dy] = [b.x - a.x, b.y - a.y];
  const square = dx * dx + dy * dy;
  const u = square ? Math.max(0, Math.min(1, ((x - a.x) * dx + (y - a.y) * dy) / square)) : 0;
  return { x: a.x + u * dx, y: a.y + u * dy };
}

const squarePath = (context, { x, y }) => context.rect(x - SQUARE, y - SQUARE, 2 * SQUARE, 2 * SQUARE);

function crossPath(context, { x, y }) {
  context.moveTo(x - CROSS, y - CROSS);
  context.lineTo(x + CROSS, y + CROSS);
  context.moveTo(x - CROSS, y + CROSS);
  context.lineTo(x + CROSS, y - CROSS);
}
