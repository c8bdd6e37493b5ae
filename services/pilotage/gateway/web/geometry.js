// Poses of the plane: {x, y, theta} in m and rad, theta counter-clockwise.

export function wrap(angle) {
  const turn = 2 * Math.PI;
  return angle - turn * Math.floor((angle + Math.PI) / turn);
}

export function compose(a, b) {
  const cos = Math.cos(a.theta);
  const sin = Math.sin(a.theta);
  return {
    x: a.x + cos * b.x - sin * b.y,
    y: a.y + sin * b.x + cos * b.y,
    theta: wrap(a.theta + b.theta),
  };
}

/** The point of `pose`'s frame that (x, y) of the outer frame is. */
export function into(pose, x, y) {
  const cos = Math.cos(pose.theta);
  const sin = Math.sin(pose.theta);
  const dx = x - pose.x;
  const dy = y - pose.y;
  return { x: cos * dx + sin * dy, y: cos * dy - sin * dx };
}

export const distance = (a, b) => Math.hypot(a.x - b.x, a.y - b.y);

/** The pose a share `u` of the way from `a` to `b`, turning the shorter way. */
export function between(a, b, u) {
  return {
    x: a.x + u * (b.x - a.x),
    y: a.y + u * (b.y - a.y),
    theta: wrap(a.theta + u * wrap(b.theta - a.theta)),
  };
}

/**
 * Half axes and direction of the ellipse at `sigmas` standard deviations of the x-y part of a
 * covariance {shape: [3, 3], data}.
 */
export function ellipseOf({ data }, sigmas) {
  const [xx, xy, yy] = [data[0], data[1], data[4]];
  const mean = (xx + yy) / 2;
  const spread = Math.hypot((xx - yy) / 2, xy);
  return {
    major: sigmas * Math.sqrt(Math.max(0, mean + spread)),
    minor: sigmas * Math.sqrt(Math.max(0, mean - spread)),
    direction: Math.atan2(2 * xy, xx - yy) / 2,
  };
}
