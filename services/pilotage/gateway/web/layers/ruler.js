// The metre grid of close views and the scale bar.

const GRID_FROM = 40;
const BAR_PX = 80;

export function drawGrid(context, view, palette) {
  if (view.scale <= GRID_FROM) return;
  const { width, height } = view.size;
  const corners = [[0, 0], [width, 0], [0, height], [width, height]].map(([x, y]) => view.toMap({ x, y }));
  const [x0, x1] = [Math.min(...corners.map((c) => c.x)), Math.max(...corners.map((c) => c.x))];
  const [y0, y1] = [Math.min(...corners.map((c) => c.y)), Math.max(...corners.map((c) => c.y))];
  context.beginPath();
  for (let x = Math.ceil(x0); x <= x1; x++) line(context, view, { x, y: y0 }, { x, y: y1 });
  for (let y = Math.ceil(y0); y <= y1; y++) line(context, view, { x: x0, y }, { x: x1, y });
  context.globalAlpha = 0.4;
  context.strokeStyle = palette.line;
  context.lineWidth = 1;
  context.stroke();
  context.globalAlpha = 1;
}

/** Draws the bar at the bottom right, above the `covered` px that a sheet hides. */
export function drawScaleBar(context, view, palette, covered) {
  const metres = roundLength(BAR_PX / view.scale);
  const length = metres * view.scale;
  const right = view.size.width - 20;
  const y = view.size.height - covered - 20;
  context.beginPath();
  context.moveTo(right - length, y - 4);
  context.lineTo(right - length, y);
  context.lineTo(right, y);
  context.lineTo(right, y - 4);
  context.strokeStyle = palette["text-2"];
  context.lineWidth = 2;
  context.lineJoin = "miter";
  context.stroke();
  context.font = "12px Inter, system-ui, sans-serif";
  context.textAlign = "center";
  context.textBaseline = "alphabetic";
  context.fillStyle = palette["text-2"];
  context.fillText(metres < 1 ? `${Math.round(metres * 100)}\u202fcm` : `${metres}\u202fm`, right - length / 2, y - 8);
}

/** The largest of 1, 2, 5, 10, ... (and 0.1 ...) that is no longer than `metres`. */
export function roundLength(metres) {
  const power = 10 ** Math.floor(Math.log10(metres) + 1e-9);
  const step = [5, 2, 1].find((s) => s * power <= metres * (1 + 1e-9));
  return step * power;
}

function line(context, view, a, b) {
  const from = view.toScreen(a);
  const to = view.toScreen(b);
  context.moveTo(from.x, from.y);
  context.lineTo(to.x, to.y);
}
