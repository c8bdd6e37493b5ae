// Where it has been: the last minute, fading; a jump of the estimate is a break, not a line.

export function drawTrail(context, view, palette, points, nowMs, windowMs) {
  context.lineJoin = context.lineCap = "round";
  const pieces = piecesOf(points).map((piece) => piece.map((p) => ({ ...view.toScreen(p.pose), at: p.at })));
  context.globalAlpha = 1;
  context.strokeStyle = palette.free;
  context.lineWidth = 6;
  for (const piece of pieces) strokeAll(context, piece);
  context.strokeStyle = palette.trail;
  context.lineWidth = 3;
  for (const piece of pieces) strokeFading(context, piece, nowMs, windowMs);
  context.globalAlpha = 0.6;
  context.lineWidth = 2;
  context.setLineDash([0.1, 6]);
  for (let i = 1; i < pieces.length; i++) strokeAll(context, [pieces[i - 1].at(-1), pieces[i][0]]);
  context.setLineDash([]);
  context.globalAlpha = 1;
}

/** Splits points at their breaks. */
export function piecesOf(points) {
  const pieces = [];
  for (const point of points) {
    if (point.isBreak || pieces.length === 0) pieces.push([]);
    pieces.at(-1).push(point);
  }
  return pieces;
}

function strokeAll(context, piece) {
  context.beginPath();
  piece.forEach((p, i) => (i ? context.lineTo(p.x, p.y) : context.moveTo(p.x, p.y)));
  context.stroke();
}

/** Strokes runs of equal age in one go: a line per step would show its joints. */
function strokeFading(context, piece, nowMs, windowMs) {
  const STEPS = 8;
  const shade = (p) => Math.min(STEPS, Math.max(0, Math.round((STEPS * (nowMs - p.at)) / windowMs)));
  for (let i = 0; i < piece.length - 1; ) {
    let end = i + 1;
    while (end < piece.length - 1 && shade(piece[end]) === shade(piece[i])) end++;
    context.globalAlpha = 1 - (0.65 * shade(piece[i])) / STEPS;
    context.lineCap = "butt";
    strokeAll(context, piece.slice(i, end + 1));
    i = end;
  }
}
