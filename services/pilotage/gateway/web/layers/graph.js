// The topological map: ways, doors and corners, places. Drawn once per view and laid over the map.
//
// Ways are kept as one path per tile of the map, so that thousands cost no more than what is in
// view, and for views from afar with fewer points; of places that would lie on each other, one is
// drawn.

import { nameOf, simplified } from "../graph.js";
import { keepDoorsFree, traceFeatures } from "./features.js";

const TILE_M = 20;
const [EDGE, ROUTE, CASING] = [1.5, 3, 6];
const EDGE_ALPHA = 0.75;
const RADIUS = 5;
const STROKE = 2;
const ROOM_PX = 13;
/** From afar places are small and thin, or they would hide the building: [radius, stroke]. */
const AFAR = [3, 1.5];
const AFAR_BELOW = 16;
const NAMES_FROM = 24;
const ROUND_FROM = 20;
const STRAY_M = 0.08;
const MOST_NAMES = 120;

export class GraphLayer {
  constructor() {
    this.graph = this.baked = null;
    this.tiles = this.coarse = [];
    this.bakedFor = "";
    this.placed = [];
  }

  /** Takes a Graph, or null. */
  take(graph) {
    this.graph = graph;
    this.tiles = graph ? tilesOf(graph.edges.map(({ way }) => way)) : [];
    this.coarse = graph ? tilesOf(graph.edges.map(({ way }) => simplified(way, STRAY_M))) : [];
    this.placed = [];
    this.forget();
  }

  /** Lets it be drawn anew. */
  forget() {
    this.bakedFor = "";
  }

  /** Draws ways, features and places; `route` is {way, nodes} or null, `current` a node's id. */
  draw(context, view, ratio, palette, { route, current, chosen }) {
    if (!this.graph) return;
    const { width, height } = context.canvas;
    const { centre, scale, angle, focus } = view;
    const ink = [palette.graph, palette.panel];
    const wanted = [centre.x, centre.y, focus.x, focus.y, scale, angle, ratio, width, height, ink].join();
    if (this.bakedFor !== wanted) this.bake(view, ratio, palette, width, height);
    this.bakedFor = wanted;
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.drawImage(this.baked, 0, 0);
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    if (route) this.drawRoute(context, view, palette, route);
    this.drawSpecial(context, view, palette, this.graph.node(current), this.graph.node(chosen));
  }

  drawRoute(context, view, palette, { way, nodes }) {
    context.beginPath();
    way.forEach(([x, y], i) => {
      const at = view.toScreen({ x, y });
      if (i) context.lineTo(at.x, at.y);
      else context.moveTo(at.x, at.y);
    });
    context.lineJoin = context.lineCap = "round";
    for (const [colour, width] of [[palette.free, CASING], [palette.graph, ROUTE]]) {
      context.strokeStyle = colour;
      context.lineWidth = width;
      context.stroke();
    }
    const shown = nodes.map((id) => this.graph.node(id)).filter(Boolean);
    const apart = placedOf(shown, view, (at) => isInside(at, view.size));
    for (const { at } of apart) drawNode(context, at, palette.graph, palette.panel);
  }

  /** The place where it is: filled; the one that was pressed: with a second ring. */
  drawSpecial(context, view, palette, current, chosen) {
    if (current) drawNode(context, view.toScreen(current.pose), palette.graph, palette.graph);
    if (!chosen) return;
    const at = view.toScreen(chosen.pose);
    drawNode(context, at, palette.graph, chosen === current ? palette.graph : palette.panel);
    context.beginPath();
    context.arc(at.x, at.y, RADIUS + 5, 0, 2 * Math.PI);
    context.stroke();
  }

  /** Writes the names of the places in view, from close by; `first` nodes' names before others. */
  label(labels, view, palette, first) {
    if (!this.graph || view.scale < NAMES_FROM) return;
    for (const { at } of this.placed) labels.keepFree(at, RADIUS);
    keepDoorsFree(labels, view, this.graph.features, (at) => isInside(at, view.size));
    const ids = new Set(first);
    const order = [...this.placed].sort((a, b) => ids.has(b.node.id) - ids.has(a.node.id));
    const colours = { halo: palette.free, ink: palette["text-2"] };
    for (const { node, at } of order.slice(0, MOST_NAMES)) {
      labels.writePlain(nameOf(node), at, RADIUS + 4, colours);
    }
  }

  /** The node nearest to a point of the screen, at most `reach` px away. */
  pick(view, point, reach) {
    return this.graph?.nearest(view.toMap(point), reach / view.scale);
  }

  bake(view, ratio, palette, width, height) {
    if (this.baked?.width !== width || this.baked?.height !== height) {
      this.baked = new OffscreenCanvas(width, height);
    }
    const context = this.baked.getContext("2d");
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.globalCompositeOperation = "source-over";
    context.globalAlpha = 1;
    context.clearRect(0, 0, width, height);
    context.strokeStyle = palette.graph;
    // Round joints cost most of the time, and from afar nobody sees them.
    context.lineJoin = view.scale < ROUND_FROM ? "bevel" : "round";
    context.lineCap = view.scale < ROUND_FROM ? "butt" : "round";
    this.bakeWays(context, view, ratio);
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.bakeFeatures(context, view);
    // Where ways cross, their paint must not add up: all at full strength first, then less of it.
    context.globalCompositeOperation = "destination-in";
    context.globalAlpha = EDGE_ALPHA;
    context.fillRect(0, 0, width, height);
    context.globalCompositeOperation = "source-over";
    context.globalAlpha = 1;
    this.bakeNodes(context, view, ratio, palette);
  }

  bakeWays(context, view, ratio) {
    view.applyTo(context, ratio);
    const seen = boxInView(view);
    context.lineWidth = EDGE / view.scale;
    const tiles = view.scale < ROUND_FROM ? this.coarse : this.tiles;
    for (const { path, box } of tiles) if (overlap(box, seen)) context.stroke(path);
  }

  bakeFeatures(context, view) {
    const [solid, dotted] = [new Path2D(), new Path2D()];
    traceFeatures(solid, dotted, view, this.graph.features, (at) => isInside(at, view.size));
    context.lineJoin = context.lineCap = "round";
    context.lineWidth = 1.5;
    context.stroke(solid);
    context.setLineDash([0.1, 4]);
    context.stroke(dotted);
    context.setLineDash([]);
  }

  bakeNodes(context, view, ratio, palette) {
    this.placed = placedOf(this.graph.nodes, view, (at) => isInside(at, view.size));
    const stamp = stampOf(ratio, palette, view.scale < AFAR_BELOW ? AFAR : [RADIUS, STROKE]);
    const half = stamp.width / 2;
    // Laid on whole pixels, or the image would blur.
    context.setTransform(1, 0, 0, 1, 0, 0);
    for (const { at } of this.placed) {
      context.drawImage(stamp, Math.round(at.x * ratio - half), Math.round(at.y * ratio - half));
    }
  }
}

/** One path for the ways whose middle lies in the same tile, with the box that they fill. */
function tilesOf(ways) {
  const tiles = new Map();
  for (const way of ways) {
    const [x, y] = way[way.length >> 1];
    const key = `${Math.floor(x / TILE_M)} ${Math.floor(y / TILE_M)}`;
    if (!tiles.has(key)) {
      tiles.set(key, { path: new Path2D(), box: { x0: Infinity, y0: Infinity, x1: -Infinity, y1: -Infinity } });
    }
    const { path, box } = tiles.get(key);
    way.forEach(([px, py], i) => {
      if (i) path.lineTo(px, py);
      else path.moveTo(px, py);
      box.x0 = Math.min(box.x0, px);
      box.y0 = Math.min(box.y0, py);
      box.x1 = Math.max(box.x1, px);
      box.y1 = Math.max(box.y1, py);
    });
  }
  return [...tiles.values()];
}

/** The nodes in view that have room, with their places on the screen; openings come first. */
export function placedOf(nodes, view, isSeen) {
  const taken = new Set();
  const placed = [];
  const put = (node) => {
    const at = view.toScreen(node.pose);
    if (!isSeen(at)) return;
    const key = Math.floor(at.x / ROOM_PX) * 65536 + Math.floor(at.y / ROOM_PX);
    if (taken.has(key)) return;
    taken.add(key);
    placed.push({ node, at });
  };
  const isOpening = ({ kind }) => kind === "door" || kind === "passage";
  for (const node of nodes) if (isOpening(node)) put(node);
  for (const node of nodes) if (!isOpening(node)) put(node);
  return placed;
}

function drawNode(context, { x, y }, colour, fill, [radius, stroke] = [RADIUS, STROKE]) {
  context.beginPath();
  context.arc(x, y, radius, 0, 2 * Math.PI);
  context.fillStyle = fill;
  context.fill();
  context.strokeStyle = colour;
  context.lineWidth = stroke;
  context.stroke();
}

/** A node as an image: thousands of them are laid faster than drawn. */
function stampOf(ratio, palette, size) {
  const half = size[0] + size[1];
  const stamp = new OffscreenCanvas(Math.ceil(2 * half * ratio), Math.ceil(2 * half * ratio));
  const context = stamp.getContext("2d");
  context.scale(ratio, ratio);
  const middle = { x: stamp.width / ratio / 2, y: stamp.height / ratio / 2 };
  drawNode(context, middle, palette.graph, palette.panel, size);
  return stamp;
}

function boxInView(view) {
  const { width, height } = view.size;
  const corners = [[0, 0], [width, 0], [0, height], [width, height]].map(([x, y]) => view.toMap({ x, y }));
  const [xs, ys] = [corners.map(({ x }) => x), corners.map(({ y }) => y)];
  return { x0: Math.min(...xs), y0: Math.min(...ys), x1: Math.max(...xs), y1: Math.max(...ys) };
}

const overlap = (a, b) => a.x0 <= b.x1 && b.x0 <= a.x1 && a.y0 <= b.y1 && b.y0 <= a.y1;

const isInside = ({ x, y }, { width, height }) => x > -ROOM_PX && y > -ROOM_PX && x < width + ROOM_PX && y < height + ROOM_PX;
