// What the camera sees: upright edges as rays, landmarks where they appear to be, and where it looks.

import { compose } from "../geometry.js";

const NO_MOUNT = { x: 0, y: 0, theta: 0 };
const [RAY_M, STAR] = [1.5, 7];
const [NEAR_PX, FAR_PX, HALF_RAD] = [22, 32, 0.5];
const OLD_S = 1;

/** What of a robot's camera is fresh: {mount, pan, landmarks, edges}; null without a camera. */
export function cameraView(state) {
  const mounts = state.message("description")?.mounts ?? [];
  const fresh = (topic) => ((state.age(topic) ?? Infinity) <= OLD_S ? state.message(topic) : null);
  const [landmarks, edges] = [fresh("landmarks"), fresh("vertical_edges")];
  const camera = mounts.find(({ kind }) => kind === "camera");
  if (!camera && !landmarks && !edges) return null;
  const mountOf = (message) => mounts.find((m) => m.frame_id === message?.frame_id)?.pose ?? camera?.pose ?? NO_MOUNT;
  return {
    mount: camera?.pose ?? NO_MOUNT,
    pan: state.message("gaze_command")?.pan ?? 0,
    landmarks: (landmarks?.sightings ?? []).map(({ range, bearing }) => spot(mountOf(landmarks), range, bearing)),
    rays: [...(edges?.bearings ?? [])].map((bearing) => ({ ...mountOf(edges), theta: mountOf(edges).theta + bearing })),
  };
}

/** Draws a camera's view around the robot's pose. */
export function drawCamera(context, view, palette, robot, { mount, pan, landmarks, rays }) {
  context.strokeStyle = palette["text-2"];
  context.lineCap = "round";
  drawRays(context, view, robot, rays);
  drawGaze(context, view, compose(robot, { ...mount, theta: mount.theta + pan }));
  for (const landmark of landmarks) drawStar(context, palette, view.toScreen(compose(robot, landmark)));
}

/** A landmark in base_link: its bearing is of the robot's x axis, however the camera is turned. */
function spot(mount, range, bearing) {
  return { x: mount.x + range * Math.cos(bearing), y: mount.y + range * Math.sin(bearing), theta: 0 };
}

function drawRays(context, view, robot, rays) {
  context.beginPath();
  for (const ray of rays) {
    const from = compose(robot, ray);
    const [a, b] = [0.3, RAY_M].map((away) => view.toScreen(compose(from, { x: away, y: 0, theta: 0 })));
    context.moveTo(a.x, a.y);
    context.lineTo(b.x, b.y);
  }
  context.globalAlpha = 0.6;
  context.lineWidth = 1;
  context.stroke();
  context.globalAlpha = 1;
}

/** A bow ahead of the robot, on the side where the camera looks. */
function drawGaze(context, view, camera) {
  const at = view.toScreen(camera);
  const angle = view.screenAngle(camera.theta);
  context.beginPath();
  context.arc(at.x, at.y, FAR_PX, angle - HALF_RAD, angle + HALF_RAD);
  for (const side of [angle - HALF_RAD, angle + HALF_RAD]) {
    context.moveTo(at.x + NEAR_PX * Math.cos(side), at.y + NEAR_PX * Math.sin(side));
    context.lineTo(at.x + FAR_PX * Math.cos(side), at.y + FAR_PX * Math.sin(side));
  }
  context.lineWidth = 2;
  context.stroke();
}

/** A star of six rays on a halo of the floor's colour. */
function drawStar(context, palette, { x, y }) {
  context.beginPath();
  for (let i = 0; i < 3; i++) {
    const [dx, dy] = [STAR * Math.cos((i * Math.PI) / 3), STAR * Math.sin((i * Math.PI) / 3)];
    context.moveTo(x - dx, y - dy);
    context.lineTo(x + dx, y + dy);
  }
  for (const [colour, width] of [[palette.free, 5], [palette["text-1"], 2]]) {
    context.strokeStyle = colour;
    context.lineWidth = width;
    context.stroke();
  }
}
