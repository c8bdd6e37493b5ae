// Floor and walls: the occupancy grid as two images, drawn once per map and theme.
//
// Seen from afar a wall of one cell would fall between the pixels; so coarser copies are kept in
// which any occupied cell of four makes the whole occupied, and the one that fits is drawn.

import { channels } from "../palette.js";

const OCCUPIED = 65;
const [UNKNOWN, FREE, WALL] = [0, 1, 2];
const LEAST_SIDE = 64;

export class Walls {
  constructor() {
    this.grid = null;
    this.levels = [];
  }

  /** Takes an OccupancyGrid. */
  take(grid, palette) {
    const [rows, cols] = grid.cells.shape;
    this.grid = { ...grid, rows, cols };
    this.levels = [];
    let level = { kinds: kindsOf(grid.cells.data), rows, cols, cell: grid.resolution };
    this.levels.push(level);
    while (Math.max(level.rows, level.cols) > LEAST_SIDE) {
      level = halved(level);
      this.levels.push(level);
    }
    this.colour(palette);
  }

  /** Draws all images anew in these colours. */
  colour(palette) {
    for (const level of this.levels) {
      level.floor = imageOf(level, FREE, channels(palette.free));
      level.walls = imageOf(level, WALL, channels(palette.occupied));
    }
  }

  /** Draws one of the images, "floor" or "walls". */
  draw(context, view, ratio, image) {
    if (!this.grid) return;
    const pixel = 1 / (view.scale * ratio);
    const level = this.levels.find((candidate) => candidate.cell >= pixel) ?? this.levels.at(-1);
    view.applyTo(context, ratio);
    placeImage(context, this.grid.origin);
    context.imageSmoothingEnabled = false;
    context.drawImage(level[image], 0, 0, level.cols * level.cell, level.rows * level.cell);
  }

  /** The coarsest level, whose floor is a mask for the belief, whose cells are no larger than `size` m. */
  maskLevel(size) {
    return this.levels.findLast((level) => level.cell <= size * 1.001) ?? this.levels[0];
  }

  /** The extent of all known cells in the map frame, or null. */
  bounds() {
    const { kinds, rows, cols, cell } = this.levels[0];
    let [r0, r1, c0, c1] = [rows, -1, cols, -1];
    for (let r = 0, i = 0; r < rows; r++) {
      for (let c = 0; c < cols; c++, i++) {
        if (kinds[i] === UNKNOWN) continue;
        if (r < r0) r0 = r;
        if (r > r1) r1 = r;
        if (c < c0) c0 = c;
        if (c > c1) c1 = c;
      }
    }
    if (r1 < 0) return null;
    return boxOf(this.grid.origin, [c0 * cell, r0 * cell, (c1 + 1) * cell, (r1 + 1) * cell]);
  }
}

/** Lets `context` draw with the origin at the grid's corner, x along its rows, y up. */
export function placeImage(context, { x, y, theta }) {
  context.translate(x, y);
  context.rotate(theta);
}

function kindsOf(cells) {
  const kinds = new Uint8Array(cells.length);
  for (let i = 0; i < cells.length; i++) {
    kinds[i] = cells[i] < 0 ? UNKNOWN : cells[i] >= OCCUPIED ? WALL : FREE;
  }
  return kinds;
}

/** Half as many cells each way: a wall anywhere wins, then free floor, then the unknown. */
function halved({ kinds, rows, cols, cell }) {
  const half = { rows: Math.ceil(rows / 2), cols: Math.ceil(cols / 2), cell: cell * 2 };
  half.kinds = new Uint8Array(half.rows * half.cols);
  for (let r = 0, i = 0; r < rows; r++) {
    const base = (r >> 1) * half.cols;
    for (let c = 0; c < cols; c++, i++) {
      const at = base + (c >> 1);
      if (kinds[i] > half.kinds[at]) half.kinds[at] = kinds[i];
    }
  }
  return half;
}

/**
 * The cells of one kind as an image whose first row is the grid's: drawn in metres, y up, it
 * stands the right way.
 */
function imageOf({ kinds, rows, cols }, kind, [r, g, b]) {
  const image = new ImageData(cols, rows);
  const pixels = new Uint32Array(image.data.buffer);
  const colour = ((255 << 24) | (b << 16) | (g << 8) | r) >>> 0;
  for (let i = 0; i < kinds.length; i++) if (kinds[i] === kind) pixels[i] = colour;
  const canvas = new OffscreenCanvas(cols, rows);
  canvas.getContext("2d").putImageData(image, 0, 0);
  return canvas;
}

function boxOf({ x, y, theta }, [left, low, right, high]) {
  const [cos, sin] = [Math.cos(theta), Math.sin(theta)];
  const corners = [[left, low], [right, low], [left, high], [right, high]];
  const xs = corners.map(([u, v]) => x + cos * u - sin * v);
  const ys = corners.map(([u, v]) => y + sin * u + cos * v);
  return { x0: Math.min(...xs), x1: Math.max(...xs), y0: Math.min(...ys), y1: Math.max(...ys) };
}
