// What has been in the last two minutes: poses for the trail and the ghost, series for the charts.
//
// Times are Unix ms by the gateway's clock when the value arrived. A gap is a gap: `null` breaks
// a line, a break in the trail is not bridged.

import { distance } from "./geometry.js";

export const WINDOW_MS = 120_000;
export const TRAIL_MS = 60_000;
const JUMP_M = 0.5;
const GAP_MS = 2000;
const STEP_M = 0.05;

export class Trail {
  constructor() {
    this.points = [];
  }

  /** Takes a pose; only those of a localized robot are a trace of it. */
  add(atMs, pose, isLocalized) {
    while (this.points.length && atMs - this.points[0].at > TRAIL_MS) this.points.shift();
    if (!isLocalized) return;
    const last = this.points.at(-1);
    const away = last ? distance(last.pose, pose) : 0;
    if (last && away < STEP_M && atMs - last.seen < GAP_MS) {
      last.seen = atMs;
      return;
    }
    const isBreak = Boolean(last) && (away > JUMP_M || atMs - last.seen > GAP_MS);
    this.points.push({ at: atMs, seen: atMs, pose, isBreak });
  }

  /** Takes the gateway's memory of the last minute: [[stamp s, x, y, theta], ...] and breaks. */
  seed({ poses, breaks }) {
    const isBreak = new Set(breaks);
    const old = poses.map(([stamp, x, y, theta], i) => {
      return { at: stamp * 1000, seen: stamp * 1000, pose: { x, y, theta }, isBreak: isBreak.has(i) };
    });
    this.points = [...old.filter((point) => !(point.at >= this.points[0]?.at)), ...this.points];
  }

  clear() {
    this.points = [];
  }
}

export class Series {
  constructor() {
    this.samples = [];
  }

  /** Takes a value, or null where there is none. */
  add(atMs, value) {
    const last = this.samples.at(-1);
    if (last && atMs <= last.at) return;
    if (last && value !== null && atMs - last.at > GAP_MS) this.samples.push({ at: last.at + 1, value: null });
    this.samples.push({ at: atMs, value });
    while (this.samples.length && atMs - this.samples[0].at > WINDOW_MS) this.samples.shift();
  }

  /** The sample nearest to a time, or undefined. */
  near(atMs) {
    let best;
    for (const sample of this.samples) {
      if (!best || Math.abs(sample.at - atMs) < Math.abs(best.at - atMs)) best = sample;
    }
    return best && Math.abs(best.at - atMs) < GAP_MS ? best : undefined;
  }

  get latest() {
    return this.samples.at(-1)?.value ?? null;
  }
}

/** The ages of the last seconds and the one that 99 in 100 are below. */
export class AgePercentile {
  constructor(windowMs = 10_000) {
    this.windowMs = windowMs;
    this.ages = [];
  }

  add(atMs, ageMs) {
    this.ages.push({ atMs, ageMs });
    while (atMs - this.ages[0].atMs > this.windowMs) this.ages.shift();
  }

  p99() {
    if (this.ages.length === 0) return null;
    const sorted = this.ages.map((entry) => entry.ageMs).sort((a, b) => a - b);
    return sorted[Math.min(sorted.length - 1, Math.floor(sorted.length * 0.99))];
  }
}
