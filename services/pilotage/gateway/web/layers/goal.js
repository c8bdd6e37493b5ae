// Where it is told to go, and the way there.

const RING = 8;
const CROSS = 5;
const TAIL = 18;

/** Draws a Path's poses as a solid line. */
export function drawPath(context, view, palette, poses) {
  if (!pathLine(context, view, poses)) return;
  context.lineJoin = context.lineCap = "round";
  strokeCased(context, palette.free, palette.goal, 2.5);
}

/** Draws ring and cross; `hasHeading`: with a tail that says how the robot shall stand there. */
export function drawGoal(context, view, palette, pose, hasHeading) {
  const { x, y } = view.toScreen(pose);
  const angle = view.screenAngle(pose.theta);
  context.beginPath();
  context.arc(x, y, RING, 0, 2 * Math.PI);
  for (const [u, v] of [[CROSS, 0], [0, CROSS]]) {
    context.moveTo(x - u, y - v);
    context.lineTo(x + u, y + v);
  }
  if (hasHeading) {
    const [cos, sin] = [Math.cos(angle), Math.sin(angle)];
    context.moveTo(x + RING * cos, y + RING * sin);
    context.lineTo(x + (RING + TAIL) * cos, y + (RING + TAIL) * sin);
  }
  context.lineCap = "round";
  strokeCased(context, palette.free, palette.goal, 2);
}

/** Lets `context` follow a path's poses; false when they make no line. */
export function pathLine(context, view, { shape, data }) {
  if (shape[0] < 2) return false;
  context.beginPath();
  for (let i = 0; i < shape[0]; i++) {
    const { x, y } = view.toScreen({ x: data[3 * i], y: data[3 * i + 1] });
    if (i) context.lineTo(x, y);
    else context.moveTo(x, y);
  }
  return true;
}

function strokeCased(context, casing, colour, width) {
  context.strokeStyle = casing;
  context.lineWidth = width + 3.5;
  context.stroke();
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.stroke();
}
