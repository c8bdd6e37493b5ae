// Labels on the map: small pills that avoid the robot, the rim and each other.

const FONT = "600 12px Inter, system-ui, sans-serif";
const PLAIN_FONT = "12px Inter, system-ui, sans-serif";
const HALO = 3;
const MOST_WIDTHS = 2000;
const widths = new Map();
const HEIGHT = 22;
const PADDING = 10;

export class Labels {
  /** `size` of the canvas in CSS pixels; `robot` where it is drawn, or null. */
  constructor(context, size, robot) {
    Object.assign(this, { context, size });
    this.taken = [];
    if (robot) this.keepFree(robot, 20);
  }

  /** Lets no label lie in a box of the screen: what floats above the map would cover it. */
  block(box) {
    this.taken.push(box);
  }

  /** Lets no label cover what is drawn within `radius` of a point. */
  keepFree({ x, y }, radius) {
    this.taken.push({ x: x - radius, y: y - radius, width: 2 * radius, height: 2 * radius });
  }

  /**
   * Writes `text` above `at`, else below, else beside it, `away` from it; says whether there was
   * room. Who asks first is served first.
   */
  write(text, at, away, { fill, edge, ink }) {
    const { context } = this;
    const box = this.taking(text, FONT, at, away, PADDING);
    if (!box) return false;
    context.beginPath();
    context.roundRect(box.x + 0.5, box.y + 0.5, box.width, box.height, HEIGHT / 2);
    context.fillStyle = fill;
    context.fill();
    context.strokeStyle = edge;
    context.lineWidth = 1.5;
    context.stroke();
    context.fillStyle = ink;
    context.textAlign = "center";
    context.textBaseline = "middle";
    context.fillText(text, box.x + box.width / 2, box.y + box.height / 2 + 1);
    return true;
  }

  /** Writes `text` without a pill, on a halo of the floor's colour. */
  writePlain(text, at, away, { halo, ink }) {
    const { context } = this;
    const box = this.taking(text, PLAIN_FONT, at, away, 2);
    if (!box) return false;
    const [x, y] = [box.x + box.width / 2, box.y + box.height / 2 + 1];
    context.textAlign = "center";
    context.textBaseline = "middle";
    context.lineJoin = "round";
    context.lineWidth = 2 * HALO;
    context.strokeStyle = halo;
    context.strokeText(text, x, y);
    context.fillStyle = ink;
    context.fillText(text, x, y);
    return true;
  }

  /** Takes the first free box beside `at` for `text` in this font; undefined without room. */
  taking(text, font, at, away, padding) {
    this.context.font = font;
    const width = Math.ceil(this.widthOf(text, font)) + 2 * padding;
    const box = spots(at, away, width).find((spot) => this.isFree(spot));
    if (box) this.taken.push(box);
    return box;
  }

  /** Measured once per text: hundreds of names come again in every frame. */
  widthOf(text, font) {
    const key = `${font} ${text}`;
    if (!widths.has(key)) {
      if (widths.size > MOST_WIDTHS) widths.clear();
      widths.set(key, this.context.measureText(text).width);
    }
    return widths.get(key);
  }

  isFree(spot) {
    const { width, height } = this.size;
    const isInside = spot.x >= 0 && spot.y >= 0 && spot.x + spot.width <= width && spot.y + HEIGHT <= height;
    return isInside && !this.taken.some((other) => overlap(spot, other));
  }
}

function spots(at, away, width) {
  const size = { width, height: HEIGHT };
  return [
    { x: at.x - width / 2, y: at.y - away - HEIGHT, ...size },
    { x: at.x - width / 2, y: at.y + away, ...size },
    { x: at.x + away, y: at.y - HEIGHT / 2, ...size },
    { x: at.x - away - width, y: at.y - HEIGHT / 2, ...size },
  ].map((box) => ({ ...box, x: Math.round(box.x), y: Math.round(box.y) }));
}

export function overlap(a, b) {
  return a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height;
}
