// The theme's colours, resolved for the canvas.

const NAMES = [
  "app", "panel", "raised", "line", "text-1", "text-2", "text-3", "unknown", "free", "occupied",
  "belief-1", "belief-2", "belief-3", "belief-4", "belief-5", "mode", "on-mode", "trail", "graph", "robot", "goal",
  "accent", "ok", "warning", "fault", "stale", "series-2", "series-3",
];

/** Returns the colours by name as "rgb(r, g, b)". */
export function readPalette() {
  const probe = document.createElement("i");
  document.body.append(probe);
  const palette = Object.fromEntries(
    NAMES.map((name) => {
      probe.style.color = `var(--${name})`;
      return [name, getComputedStyle(probe).color];
    }),
  );
  probe.remove();
  return palette;
}

/** Returns [r, g, b] of such a colour. */
export const channels = (colour) => colour.match(/[\d.]+/g).slice(0, 3).map(Number);

const LOW = 0.001;
const HIGH = 0.1;
const ALPHA_LOW = 0.25;
const ALPHA_HIGH = 0.95;

/**
 * Returns the colour [r, g, b, alpha 0..255] of a belief of `density` (share of mass per m^2), on
 * a log scale from 0.1 % to 10 % that never changes: a scale that adapts would make doubt look
 * like certainty. Null below it.
 */
export function beliefColour(ramp, density) {
  if (!(density >= LOW)) return null;
  const share = Math.min(1, Math.log(density / LOW) / Math.log(HIGH / LOW));
  const place = share * (ramp.length - 1);
  const i = Math.min(ramp.length - 2, Math.floor(place));
  const u = place - i;
  const mixed = ramp[i].map((low, c) => low + u * (ramp[i + 1][c] - low));
  return [...mixed, 255 * (ALPHA_LOW + share * (ALPHA_HIGH - ALPHA_LOW))];
}

export const rampOf = (palette) => [1, 2, 3, 4, 5].map((i) => channels(palette[`belief-${i}`]));
