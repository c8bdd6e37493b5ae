// The modes of the belief as numbered places that keep their numbers.
//
// A mode takes the number of the nearest one before it; by mass they are renumbered only after
// two quiet seconds, so that a number does not jump about while two places are nearly as likely.

import { percentsOf } from "./format.js";
import { distance, wrap } from "./geometry.js";

export const MOST = 5;
export const LEAST_MASS = 0.03;
const SAME_M = 1.0;
const SAME_RAD = 0.6;
const QUIET_MS = 2000;

export class Places {
  constructor() {
    this.list = [];
    this.elsewhere = 100;
    this.best = null;
    this.changedAt = -Infinity;
  }

  /**
   * Takes the modes of a new belief (by falling mass) at `nowMs`. Each place has its `number` and
   * its `percent`, whole ones that sum to 100 with `elsewhere`.
   */
  update(modes, nowMs) {
    const shown = modes.filter((mode, i) => i === 0 || mode.mass >= LEAST_MASS).slice(0, MOST);
    const numbered = this.matched(shown);
    const isSettled = nowMs - this.changedAt >= QUIET_MS;
    const numbers = isSettled ? shown.map((_, i) => i + 1) : numbered;
    const next = shown.map((mode, i) => ({ ...mode, number: numbers[i] }));
    if (changed(this.list, next)) this.changedAt = nowMs;
    const rest = Math.max(0, 1 - shown.reduce((sum, mode) => sum + mode.mass, 0));
    const percents = percentsOf([...shown.map((mode) => mode.mass), rest]);
    next.forEach((place, i) => (place.percent = percents[i]));
    this.elsewhere = percents.at(-1);
    this.best = next[0] ?? null;
    this.list = next.sort((a, b) => a.number - b.number);
  }

  /** The number that each mode had, or the lowest free one. */
  matched(modes) {
    const free = new Set(this.list);
    const numbers = modes.map((mode) => {
      const old = nearest(mode, free);
      free.delete(old);
      return old?.number;
    });
    const taken = new Set(numbers);
    return numbers.map((number) => {
      if (number !== undefined) return number;
      let lowest = 1;
      while (taken.has(lowest)) lowest++;
      taken.add(lowest);
      return lowest;
    });
  }
}

function nearest(mode, candidates) {
  let best;
  for (const old of candidates) {
    const away = distance(old.pose, mode.pose);
    const turn = Math.abs(wrap(old.pose.theta - mode.pose.theta));
    if (away < SAME_M && turn < SAME_RAD && (!best || away < best.away)) best = { old, away };
  }
  return best?.old;
}

function changed(before, after) {
  const old = new Map(before.map((place) => [place.number, place]));
  return after.some((place) => {
    const was = old.get(place.number);
    return !was || nearest(place, [was]) === undefined;
  });
}
