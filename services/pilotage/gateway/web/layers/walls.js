// Floor and walls: the occupancy grid as two images, drawn once per map and theme, and patched.
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
    this.known = null;
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
    this.known = null;
    this.extend({ row: 0, col: 0, rows, cols });
    this.colour(palette);
  }

  /** Lays a GridPatch over the map; false when it is of another map, or does not lie on it. */
  patch({ map_id: mapId, row, col, cells }, palette) {
    const { grid } = this;
    const [rows, cols] = cells.shape;
    if (grid?.map_id !== mapId || row + rows > grid.rows || col + cols > grid.cols) return false;
    for (let r = 0; r < rows; r++) {
      const line = cells.data.subarray(r * cols, (r + 1) * cols);
      const at = (row + r) * grid.cols + col;
      grid.cells.data.set(line, at);
      this.levels[0].kinds.set(kindsOf(line), at);
    }
    let window = { row, col, rows, cols };
    this.extend(window);
    this.levels.forEach((level, i) => {
      if (i > 0) {
        window = halvedWindow(window);
        halve(this.levels[i - 1], level, window);
      }
      paint(level.floor, level, window, FREE, channels(palette.free));
      paint(level.walls, level, window, WALL, channels(palette.occupied));
    });
    return true;
  }

  /** Draws all images anew in these colours. */
  colour(palette) {
    for (const level of this.levels) {
      const whole = { row: 0, col: 0, rows: level.rows, cols: level.cols };
      level.floor = new OffscreenCanvas(level.cols, level.rows);
      level.walls = new OffscreenCanvas(level.cols, level.rows);
      paint(level.floor, level, whole, FREE, channels(palette.free));
      paint(level.walls, level, whole, WALL, channels(palette.occupied));
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
    if (!this.known) return null;
    const { cell } = this.levels[0];
    return boxOf(this.grid.origin, this.known.map((index) => index * cell));
  }

  /** Lets the extent of known cells (left, low, right, high) include those of a window. */
  extend({ row, col, rows, cols }) {
    const { kinds, cols: width } = this.levels[0];
    let [left, low, right, high] = this.known ?? [Infinity, Infinity, 0, 0];
    for (let r = row; r < row + rows; r++) {
      for (let c = col, i = r * width + col; c < col + cols; c++, i++) {
        if (kinds[i] === UNKNOWN) continue;
        if (r < low) low = r;
        if (r >= high) high = r + 1;
        if (c < left) left = c;
        if (c >= right) right = c + 1;
      }
    }
    if (right > left) this.known = [left, low, right, high];
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
function halved(level) {
  const half = { rows: Math.ceil(level.rows / 2), cols: Math.ceil(level.cols / 2), cell: level.cell * 2 };
  half.kinds = new Uint8Array(half.rows * half.cols);
  halve(level, half, { row: 0, col: 0, rows: half.rows, cols: half.cols });
  return half;
}

/** The window of the coarser level that holds a window of a finer one. */
function halvedWindow({ row, col, rows, cols }) {
  const [r, c] = [row >> 1, col >> 1];
  return { row: r, col: c, rows: ((row + rows - 1) >> 1) - r + 1, cols: ((col + cols - 1) >> 1) - c + 1 };
}

/** Fills a window of the coarser level `half` from `fine`. */
function halve(fine, half, { row, col, rows, cols }) {
  for (let r = row; r < row + rows; r++) {
    for (let c = col; c < col + cols; c++) {
      let kind = UNKNOWN;
      for (let y = 2 * r; y < Math.min(2 * r + 2, fine.rows); y++) {
        for (let x = 2 * c; x < Math.min(2 * c + 2, fine.cols); x++) {
          kind = Math.max(kind, fine.kinds[y * fine.cols + x]);
        }
      }
      half.kinds[r * half.cols + c] = kind;
    }
  }
}

/**
 * Draws the cells of one kind in a window into an image whose first row is the grid's: drawn in
 * metres, y up, it stands the right way.
 */
function paint(canvas, { kinds, cols: width }, { row, col, rows, cols }, kind, [r, g, b]) {
  const image = new ImageData(cols, rows);
  const pixels = new Uint32Array(image.data.buffer);
  const colour = ((255 << 24) | (b << 16) | (g << 8) | r) >>> 0;
  for (let y = 0, i = 0; y < rows; y++) {
    const line = (row + y) * width + col;
    for (let x = 0; x < cols; x++, i++) if (kinds[line + x] === kind) pixels[i] = colour;
  }
  canvas.getContext("2d").putImageData(image, col, row);
}

function boxOf({ x, y, theta }, [left, low, right, high]) {
  const [cos, sin] = [Math.cos(theta), Math.sin(theta)];
  const corners = [[left, low], [right, low], [left, high], [right, high]];
  const xs = corners.map(([u, v]) => x + cos * u - sin * v);
  const ys = corners.map(([u, v]) => y + sin * u + cos * v);
  return { x0: Math.min(...xs), x1: Math.max(...xs), y0: Math.min(...ys), y1: Math.max(...ys) };
}
