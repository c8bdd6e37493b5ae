// What the laser or the sonar ring saw, from where the robot was believed to be when it did.

import { compose } from "../geometry.js";

/** The ends of a LaserScan in base_link: [{x, y}], nothing for beams without a return. */
export function scanEnds(scan, mount) {
  const ends = [];
  scan.ranges.forEach((range, i) => {
    if (!(range >= scan.range_min && range < scan.range_max)) return;
    const theta = scan.angle_min + i * scan.angle_increment;
    ends.push(compose(mount, { x: range * Math.cos(theta), y: range * Math.sin(theta), theta: 0 }));
  });
  return ends;
}

/** The echoes of a SonarScan on the axes of their cones, in base_link. */
export function sonarEnds(sonar) {
  const { data } = sonar.mounts;
  const ends = [];
  sonar.ranges.forEach((range, i) => {
    if (!(range < sonar.range_max)) return;
    const mount = { x: data[3 * i], y: data[3 * i + 1], theta: data[3 * i + 2] };
    ends.push(compose(mount, { x: range, y: 0, theta: 0 }));
  });
  return ends;
}

export function drawEnds(context, view, palette, ends, pose) {
  context.globalAlpha = 0.6;
  context.fillStyle = palette["text-2"];
  for (const end of ends) {
    const at = view.toScreen(compose(pose, { ...end, theta: 0 }));
    context.fillRect(at.x - 1, at.y - 1, 2, 2);
  }
  context.globalAlpha = 1;
}
