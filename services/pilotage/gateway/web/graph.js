// The topological map as the page uses it: places by id, ways as points, what lies near: pure.

import { capitalized } from "./format.js";
import { distance, wrap } from "./geometry.js";

/** Features of two places that are nearer than this, alike and turned alike are one. */
const SAME_M = 0.25;
const SAME_RAD = 0.5;

export class Graph {
  /** Takes a TopologicalMap. */
  constructor(message) {
    this.mapId = message.map_id;
    this.name = message.name ?? "";
    this.spacing = message.spacing ?? "";
    this.nodes = message.nodes;
    this.byId = new Map(this.nodes.map((node) => [node.id, node]));
    const known = message.edges.filter(({ start, end }) => this.byId.has(start) && this.byId.has(end));
    this.edges = known.map((edge) => ({ ...edge, way: this.wayOf(edge) }));
    this.features = distinct(this.nodes.flatMap((node) => node.features));
  }

  node(id) {
    return this.byId.get(id);
  }

  /** The points [[x, y], ...] of an edge; straight from node to node where it names none. */
  wayOf({ start, end, way }) {
    if (way?.shape[0] > 1) return pointsOf(way);
    return [start, end].map((id) => [this.node(id).pose.x, this.node(id).pose.y]);
  }

  /** The node nearest to a point, at most `within` m away; undefined when there is none. */
  nearest(point, within = Infinity) {
    let best;
    let least = within;
    for (const node of this.nodes) {
      const away = distance(node.pose, point);
      if (away <= least) [best, least] = [node, away];
    }
    return best;
  }

  /** Where one can go from a node: [{node, cost}], the nearest first. */
  neighbours(id) {
    const found = new Map();
    for (const { start, end, cost } of this.edges) {
      if (start !== id && end !== id) continue;
      const other = start === id ? end : start;
      if (other !== id) found.set(other, Math.min(cost, found.get(other) ?? Infinity));
    }
    return [...found].map(([other, cost]) => ({ node: this.node(other), cost })).sort((a, b) => a.cost - b.cost);
  }
}

/** Points [[x, y], ...] of an array {shape: [n, 2], data}. */
export function pointsOf({ shape, data }) {
  return Array.from({ length: shape[0] }, (_, i) => [data[2 * i], data[2 * i + 1]]);
}

/** Length of points [[x, y], ...] in m. */
export function lengthOf(points) {
  let sum = 0;
  for (let i = 1; i < points.length; i++) {
    sum += Math.hypot(points[i][0] - points[i - 1][0], points[i][1] - points[i - 1][1]);
  }
  return sum;
}

/** The fewest of the points from which a line strays no farther than `within` m from them all. */
export function simplified(points, within) {
  if (points.length < 3) return points;
  const [first, last] = [points[0], points.at(-1)];
  let [worst, far] = [0, within];
  for (let i = 1; i < points.length - 1; i++) {
    const away = farFrom(first, last, points[i]);
    if (away > far) [worst, far] = [i, away];
  }
  if (worst === 0) return [first, last];
  const before = simplified(points.slice(0, worst + 1), within);
  return [...before.slice(0, -1), ...simplified(points.slice(worst), within)];
}

/** How far a point lies from the piece of line from `a` to `b`. */
function farFrom([ax, ay], [bx, by], [x, y]) {
  const [dx, dy] = [bx - ax, by - ay];
  const square = dx * dx + dy * dy;
  const u = square ? Math.max(0, Math.min(1, ((x - ax) * dx + (y - ay) * dy) / square)) : 0;
  return Math.hypot(x - ax - u * dx, y - ay - u * dy);
}

/** What a node is called. */
export const nameOf = (node) => capitalized(node.name || `place ${node.id}`);

/** "2 doors, 1 corner": how many there are of each kind. */
export function countText(kinds) {
  const counts = new Map();
  for (const kind of kinds) counts.set(kind, (counts.get(kind) ?? 0) + 1);
  return [...counts].map(([kind, n]) => `${n} ${kind}${n === 1 ? "" : "s"}`).join(", ");
}

/** Each feature once, though many places are bound to it. */
export function distinct(features) {
  const cells = new Map();
  const kept = [];
  for (const feature of features) {
    const [col, row] = [Math.floor(feature.pose.x / SAME_M), Math.floor(feature.pose.y / SAME_M)];
    if (hasAlike(cells, col, row, feature)) continue;
    kept.push(feature);
    const key = keyOf(col, row);
    if (cells.has(key)) cells.get(key).push(feature);
    else cells.set(key, [feature]);
  }
  return kept;
}

const keyOf = (col, row) => col * 2 ** 26 + row;

function hasAlike(cells, col, row, feature) {
  for (let c = col - 1; c <= col + 1; c++) {
    for (let r = row - 1; r <= row + 1; r++) {
      if (cells.get(keyOf(c, r))?.some((other) => isSame(other, feature))) return true;
    }
  }
  return false;
}

function isSame(a, b) {
  if (a.kind !== b.kind || distance(a.pose, b.pose) > SAME_M) return false;
  const turn = Math.abs(wrap(a.pose.theta - b.pose.theta));
  // A door is walked through either way: only its axis counts.
  return (a.kind === "corner" ? turn : Math.min(turn, Math.PI - turn)) < SAME_RAD;
}
