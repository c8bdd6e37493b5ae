// A coarse field on a finer grid: smooth lines can be drawn of it, and single cells do not show.
//
// Cubic B-splines as weights, over the cells that have a value: pure.

const MOST_CELLS = 400_000;
const MOST_FINER = 4;
/** Cells: as wide as two such splines, a single cell makes no ring. */
const WIDTH = 1.6;
const LEAST_SHARE = 0.25;

/** How many times finer a field may become, from 1 for one that is fine already. */
export function finerBy({ rows, cols }) {
  return Math.max(1, Math.min(MOST_FINER, Math.floor(Math.sqrt(MOST_CELLS / (rows * cols)))));
}

/** The field on a grid `factor` times as fine; NaN where too little is known nearby. */
export function refined(field, factor) {
  if (factor === 1) return field;
  const tall = { rows: field.rows * factor, cols: field.cols * factor };
  const data = new Float32Array(tall.rows * tall.cols);
  const across = Array.from({ length: tall.cols }, (_, i) => tapsAt(i, factor, field.cols));
  for (let r = 0, i = 0; r < tall.rows; r++) {
    const up = tapsAt(r, factor, field.rows);
    for (let c = 0; c < tall.cols; c++, i++) data[i] = mean(field, up, across[c]);
  }
  return { ...tall, data };
}

/** The cells [index, weight] that count for the centre of fine cell `i`. */
function tapsAt(i, factor, count) {
  const at = (i + 0.5) / factor - 0.5;
  const taps = [];
  for (let cell = Math.ceil(at - 2 * WIDTH); cell <= at + 2 * WIDTH; cell++) {
    if (cell >= 0 && cell < count) taps.push([cell, spline(Math.abs(at - cell) / WIDTH)]);
  }
  return taps;
}

function spline(d) {
  return d < 1 ? 2 / 3 - d * d * (1 - d / 2) : (2 - d) ** 3 / 6;
}

function mean({ cols, data }, up, across) {
  let [sum, weight, all] = [0, 0, 0];
  for (const [row, v] of up) {
    for (const [col, u] of across) {
      const value = data[row * cols + col];
      all += u * v;
      if (Number.isNaN(value)) continue;
      sum += u * v * value;
      weight += u * v;
    }
  }
  return weight > LEAST_SHARE * all ? sum / weight : NaN;
}
