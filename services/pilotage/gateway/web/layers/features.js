// Doors, passages and corners, each in a form of its own and, where it has one, at its true width.
//
// A door: its leaf open along the way, and the arc that it swings through. A passage: its two
// jambs and a dotted sill. A corner: an L into the free space, and a dash on the line that halves it.

const LEAST_PX = 16;
const JAMB_PX = 5;
const [OFF_PX, ARM_PX] = [3, 7];
const BISECTOR_PX = [6, 10];
const CORNERS_FROM = 14;

/** Traces the solid lines of the features that `isSeen` in px; dotted ones go to `dotted`. */
export function traceFeatures(solid, dotted, view, features, isSeen) {
  for (const feature of features) {
    const at = view.toScreen(feature.pose);
    if (!isSeen(at)) continue;
    const angle = view.screenAngle(feature.pose.theta);
    if (feature.kind === "corner") {
      if (view.scale >= CORNERS_FROM) traceCorner(solid, at, angle);
    } else {
      const half = ((feature.width ?? 0) * view.scale) / 2;
      if (2 * half < LEAST_PX) continue;
      if (feature.kind === "door") traceDoor(solid, at, angle, half);
      else tracePassage(solid, dotted, at, angle, half);
    }
  }
}

/** Lets no label lie on the open leaves of doors. */
export function keepDoorsFree(labels, view, features, isSeen) {
  for (const { kind, pose, width } of features) {
    const at = view.toScreen(pose);
    const half = ((width ?? 0) * view.scale) / 2;
    if (kind !== "door" || !isSeen(at) || 2 * half < LEAST_PX) continue;
    const angle = view.screenAngle(pose.theta);
    labels.keepFree({ x: at.x + half * Math.cos(angle), y: at.y + half * Math.sin(angle) }, half);
  }
}

function traceDoor(path, at, angle, half) {
  const hinge = beside(at, angle, half);
  const jamb = beside(at, angle, -half);
  const [cos, sin] = [Math.cos(angle), Math.sin(angle)];
  const leaf = { x: hinge.x + 2 * half * cos, y: hinge.y + 2 * half * sin };
  path.moveTo(hinge.x, hinge.y);
  path.lineTo(leaf.x, leaf.y);
  const to = Math.atan2(jamb.y - hinge.y, jamb.x - hinge.x);
  path.moveTo(leaf.x, leaf.y);
  path.arc(hinge.x, hinge.y, 2 * half, angle, to, isBackward(angle, to));
}

function tracePassage(path, dotted, at, angle, half) {
  const [dx, dy] = [JAMB_PX * Math.cos(angle), JAMB_PX * Math.sin(angle)];
  const jambs = [half, -half].map((side) => beside(at, angle, side));
  for (const { x, y } of jambs) {
    path.moveTo(x - dx, y - dy);
    path.lineTo(x + dx, y + dy);
  }
  dotted.moveTo(jambs[0].x, jambs[0].y);
  dotted.lineTo(jambs[1].x, jambs[1].y);
}

function traceCorner(path, at, angle) {
  const along = (from, turn, length) => {
    return { x: from.x + length * Math.cos(angle + turn), y: from.y + length * Math.sin(angle + turn) };
  };
  const tip = along(at, 0, OFF_PX);
  const [left, right] = [Math.PI / 4, -Math.PI / 4].map((turn) => along(tip, turn, ARM_PX));
  const [start, end] = BISECTOR_PX.map((length) => along(tip, 0, length));
  path.moveTo(left.x, left.y);
  path.lineTo(tip.x, tip.y);
  path.lineTo(right.x, right.y);
  path.moveTo(start.x, start.y);
  path.lineTo(end.x, end.y);
}

/** The point of the screen `off` px to the left of a direction. */
const beside = ({ x, y }, angle, off) => ({ x: x + off * Math.sin(angle), y: y - off * Math.cos(angle) });

/** Whether the shorter way from one angle to the other is counter-clockwise on the screen. */
const isBackward = (from, to) => Math.sin(to - from) < 0;
