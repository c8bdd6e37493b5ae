// Lines of equal value of a scalar field, by marching squares: pure.
//
// A field is {rows, cols, data}, row 0 at the bottom, values at the centres of cells; NaN where
// there is none. Lines are lists of [col, row] in cells from the outer corner of cell (0, 0).

const LOW_SHARE = 0.02;
const SAMPLES = 4096;
const WANDER = 0.05;

/**
 * `count` levels, evenly spaced between the field's 2nd and 98th percentile: a single peak must
 * not take all of them for itself. None for a field that is flat.
 */
export function levelsOf({ data }, count) {
  const values = sampled(data).sort();
  if (values.length === 0) return [];
  const at = (share) => values[Math.round(share * (values.length - 1))];
  let [low, high] = [at(LOW_SHARE), at(1 - LOW_SHARE)];
  if (!(high > low)) [low, high] = [at(0), at(1)];
  if (!(high > low)) return [];
  return Array.from({ length: count }, (_, i) => low + ((i + 1) * (high - low)) / (count + 1));
}

/** Values from all over the field, in no order, NaN left out. */
function sampled(data) {
  const known = data.filter((value) => !Number.isNaN(value));
  const step = Math.max(1, Math.floor(known.length / SAMPLES));
  return Float32Array.from({ length: Math.ceil(known.length / step) }, (_, i) => known[i * step]);
}

/** The field with each cell without a value beside ones that have some taking their mean. */
export function widened({ rows, cols, data }) {
  const wide = data.slice();
  for (let r = 0, i = 0; r < rows; r++) {
    for (let c = 0; c < cols; c++, i++) {
      if (!Number.isNaN(data[i])) continue;
      let [sum, n] = [0, 0];
      for (let y = Math.max(0, r - 1); y <= Math.min(rows - 1, r + 1); y++) {
        for (let x = Math.max(0, c - 1); x <= Math.min(cols - 1, c + 1); x++) {
          const value = data[y * cols + x];
          if (Number.isNaN(value)) continue;
          sum += value;
          n += 1;
        }
      }
      if (n > 0) wide[i] = sum / n;
    }
  }
  return { rows, cols, data: wide };
}

/** The lines of each level: [[line, ...], ...]. */
export function contoursOf(field, levels) {
  const steps = levels.map(() => new Map());
  const { rows, cols, data } = field;
  const bands = bandsOf(data, levels);
  for (let r = 0; r + 1 < rows; r++) {
    for (let c = 0, i = r * cols; c + 1 < cols; c++, i++) {
      const [a, b, d, e] = [bands[i], bands[i + 1], bands[i + cols], bands[i + cols + 1]];
      if (a === b && a === d && a === e) continue;
      const high = Math.max(a, b, d, e);
      if (high === NOWHERE) continue;
      for (let k = Math.min(a, b, d, e); k < high; k++) {
        const corners = (a > k) | ((b > k) << 1) | ((e > k) << 2) | ((d > k) << 3);
        cross(corners, i, field, levels[k], steps[k]);
      }
    }
  }
  return steps.map((edges, k) => joined(edges).map((line) => simplified(placed(line, field, levels[k]))));
}

/** Direction in which the field rises at a place [col, row], per cell, or null where unknown. */
export function gradientAt({ rows, cols, data }, [col, row]) {
  const [c, r] = [Math.floor(col - 0.5), Math.floor(row - 0.5)];
  if (c < 0 || r < 0 || c + 1 >= cols || r + 1 >= rows) return null;
  const [u, v] = [col - 0.5 - c, row - 0.5 - r];
  const i = r * cols + c;
  const [a, b, d, e] = [data[i], data[i + 1], data[i + cols], data[i + cols + 1]];
  const rise = { x: (1 - v) * (b - a) + v * (e - d), y: (1 - u) * (d - a) + u * (e - b) };
  return Number.isNaN(rise.x + rise.y) ? null : rise;
}

/** Whether a line reaches over at least `least` cells one way or the other. */
export function isLarge(line, least) {
  const span = (axis) => {
    const values = line.map((point) => point[axis]);
    return Math.max(...values) - Math.min(...values);
  };
  return span(0) >= least || span(1) >= least;
}

const NOWHERE = 255;

/** How many levels lie below each value. */
function bandsOf(data, levels) {
  const bands = new Uint8Array(data.length);
  for (let i = 0; i < data.length; i++) {
    const value = data[i];
    let band = 0;
    while (band < levels.length && value > levels[band]) band++;
    bands[i] = Number.isNaN(value) ? NOWHERE : band;
  }
  return bands;
}

// Edges of a square: 0 below, 1 right, 2 above, 3 left. By which corners (bit 0 below left, on
// counter-clockwise) are high, the steps from edge to edge, the high side on the left.
const STEPS = [
  [], [[0, 3]], [[1, 0]], [[1, 3]], [[2, 1]], null, [[2, 0]], [[2, 3]],
  [[3, 2]], [[0, 2]], null, [[1, 2]], [[3, 1]], [[0, 1]], [[3, 0]], [],
];
const APART = { 5: [[0, 3], [2, 1]], 10: [[1, 0], [3, 2]] };
const TOGETHER = { 5: [[0, 1], [2, 3]], 10: [[3, 0], [1, 2]] };

function cross(corners, i, { cols, data }, level, edges) {
  const ids = [2 * i, 2 * (i + 1) + 1, 2 * (i + cols), 2 * i + 1];
  for (const [from, to] of STEPS[corners] ?? saddle(corners, i, cols, data, level)) {
    edges.set(ids[from], ids[to]);
  }
}

/** Where high and low corners lie crosswise, the mean in the middle decides. */
function saddle(corners, i, cols, data, level) {
  const middle = (data[i] + data[i + 1] + data[i + cols] + data[i + cols + 1]) / 4;
  return (middle > level ? TOGETHER : APART)[corners];
}

/** Chains steps into lines; one that closes ends with the edge it began with. */
function joined(edges) {
  const ends = new Set(edges.values());
  const lines = [];
  const follow = (start) => {
    const line = [start];
    for (let at = start; edges.has(at); ) {
      const next = edges.get(at);
      edges.delete(at);
      line.push(next);
      at = next;
    }
    lines.push(line);
  };
  for (const start of [...edges.keys()]) if (!ends.has(start)) follow(start);
  for (const start of [...edges.keys()]) if (edges.has(start)) follow(start);
  return lines;
}

/** The points where a line crosses its edges: even ids lie along a row, odd ones along a column. */
function placed(line, { cols, data }, level) {
  return line.map((id) => {
    const i = id >> 1;
    const [dx, dy] = id & 1 ? [0, 1] : [1, 0];
    const [a, b] = [data[i], data[i + dx + dy * cols]];
    const u = (level - a) / (b - a);
    return [(i % cols) + 0.5 + dx * u, Math.floor(i / cols) + 0.5 + dy * u];
  });
}

/** Drops points that lie within a twentieth of a cell of the line without them. */
function simplified(line) {
  const keeps = new Uint8Array(line.length);
  keeps[0] = keeps[line.length - 1] = 1;
  const open = [[0, line.length - 1]];
  while (open.length) {
    const [from, to] = open.pop();
    const [worst, far] = farthest(line, from, to);
    if (far <= WANDER) continue;
    keeps[worst] = 1;
    open.push([from, worst], [worst, to]);
  }
  return line.filter((_, i) => keeps[i]);
}

function farthest(line, from, to) {
  const [[x, y], [u, v]] = [line[from], line[to]];
  const [dx, dy] = [u - x, v - y];
  const length = Math.hypot(dx, dy);
  let [worst, far] = [from, 0];
  for (let i = from + 1; i < to; i++) {
    const [px, py] = [line[i][0] - x, line[i][1] - y];
    const away = length > 1e-9 ? Math.abs(dx * py - dy * px) / length : Math.hypot(px, py);
    if (away > far) [worst, far] = [i, away];
  }
  return [worst, far];
}
