// From map to screen and back: pan, zoom, turn and follow, all of them eased or at once.
//
// Screen coordinates are CSS pixels of the map's canvas, y down; the map is in metres, y up.
// One scale serves x and y: circles stay circles.

const LEAST_SCALE = 5;
const MOST_SCALE = 400;
const EASE_MS = 120;
const CALM = 0.3;

export class View {
  constructor(now = () => performance.now()) {
    this.now = now;
    this.size = { width: 1, height: 1 };
    this.inset = { top: 0, right: 0, bottom: 0, left: 0 };
    this.centre = { x: 0, y: 0 };
    this.scale = 20;
    this.angle = 0;
    this.bounds = null;
    this.motion = null;
    this.follows = true;
    this.isFitted = false;
    this.isCalm = matchMedia("(prefers-reduced-motion: reduce)");
  }

  get focus() {
    const { width, height } = this.size;
    const { top, right, bottom, left } = this.inset;
    return { x: left + (width - left - right) / 2, y: top + (height - top - bottom) / 2 };
  }

  get leastScale() {
    return Math.min(LEAST_SCALE, this.fitted()?.scale ?? LEAST_SCALE);
  }

  toScreen({ x, y }) {
    const { cos, sin } = this.turn();
    const dx = x - this.centre.x;
    const dy = y - this.centre.y;
    return {
      x: this.focus.x + this.scale * (cos * dx - sin * dy),
      y: this.focus.y - this.scale * (sin * dx + cos * dy),
    };
  }

  toMap({ x, y }) {
    const { cos, sin } = this.turn();
    const u = (x - this.focus.x) / this.scale;
    const v = (this.focus.y - y) / this.scale;
    return { x: this.centre.x + cos * u + sin * v, y: this.centre.y + cos * v - sin * u };
  }

  /** The canvas angle (clockwise, y down) of a map heading. */
  screenAngle(theta) {
    return -(theta + this.angle);
  }

  /** Lets `context` draw in metres, y up, in the map frame; `ratio` device pixels per CSS pixel. */
  applyTo(context, ratio) {
    const { cos, sin } = this.turn();
    const s = this.scale * ratio;
    const origin = this.toScreen({ x: 0, y: 0 });
    context.setTransform(s * cos, -s * sin, -s * sin, -s * cos, origin.x * ratio, origin.y * ratio);
  }

  panBy(dx, dy) {
    const focus = this.focus;
    this.centre = this.toMap({ x: focus.x - dx, y: focus.y - dy });
    this.motion = null;
    this.follows = this.isFitted = false;
  }

  /** Zooms and turns so that what is under `at` stays there. */
  zoomBy(factor, at, angle = 0, isEased = true) {
    this.isFitted = false;
    const scale = this.limited((this.motion?.to.scale ?? this.scale) * factor);
    const to = { scale, angle: (this.motion?.to.angle ?? this.angle) + angle };
    this.start({ anchor: { screen: at, map: this.toMap(at) }, to }, isEased);
  }

  /** Shows the whole map, also when the window changes its size later. */
  fit(isEased = true) {
    const fitted = this.fitted();
    if (!fitted) return;
    this.goTo(fitted.centre, fitted.scale, isEased);
    this.isFitted = true;
  }

  goTo(centre, scale = this.scale, isEased = true) {
    this.isFitted = false;
    this.start({ to: { centre, scale, angle: this.angle } }, isEased);
  }

  /** Moves just enough to keep `point` in the calm middle of the picture. */
  keepInSight(point) {
    // With the whole map in view there is nothing to follow.
    if (!this.follows || this.isFitted || this.motion) return;
    const { width, height } = this.size;
    const { top, right, bottom, left } = this.inset;
    const at = this.toScreen(point);
    const dx = beyond(at.x - this.focus.x, (width - left - right) * CALM);
    const dy = beyond(at.y - this.focus.y, (height - top - bottom) * CALM);
    if (dx === 0 && dy === 0) return;
    const focus = this.focus;
    this.centre = this.toMap({ x: focus.x + dx, y: focus.y + dy });
  }

  /** Carries an eased motion on; says whether anything moved. */
  step() {
    if (!this.motion) return false;
    const { from, to, anchor, startedAt } = this.motion;
    const share = Math.min(1, (this.now() - startedAt) / EASE_MS);
    const u = 1 - (1 - share) ** 3;
    this.scale = from.scale * (to.scale / from.scale) ** u;
    this.angle = from.angle + u * (to.angle - from.angle);
    if (anchor) this.putUnder(anchor);
    else this.centre = mix(from.centre, to.centre, u);
    if (share === 1) this.motion = null;
    return true;
  }

  start(motion, isEased) {
    const isAtOnce = !isEased || this.isCalm.matches;
    const from = { scale: this.scale, angle: this.angle, centre: this.centre };
    this.motion = { ...motion, from, startedAt: isAtOnce ? -Infinity : this.now() };
    if (isAtOnce) this.step();
  }

  putUnder({ screen, map }) {
    const there = this.toMap(screen);
    this.centre = {
      x: this.centre.x + map.x - there.x,
      y: this.centre.y + map.y - there.y,
    };
  }

  fitted() {
    if (!this.bounds) return null;
    const { x0, y0, x1, y1 } = this.bounds;
    const { cos, sin } = this.turn();
    const [w, h] = [x1 - x0, y1 - y0];
    const across = Math.abs(cos) * w + Math.abs(sin) * h;
    const up = Math.abs(sin) * w + Math.abs(cos) * h;
    const { top, right, bottom, left } = this.inset;
    const room = { x: this.size.width - left - right, y: this.size.height - top - bottom };
    const scale = Math.min(room.x / across, room.y / up, MOST_SCALE);
    return { scale, centre: { x: (x0 + x1) / 2, y: (y0 + y1) / 2 } };
  }

  turn() {
    return { cos: Math.cos(this.angle), sin: Math.sin(this.angle) };
  }

  limited(scale) {
    return Math.min(MOST_SCALE, Math.max(this.leastScale, scale));
  }
}

/**
 * The part of the canvas that nothing floats over: `covered` px at the bottom belong to the
 * sheet of a phone, the notice takes a line at the top, and the layers' chips `chips` px.
 */
export function frameFor(covered, hasNotice, chips = 32) {
  const top = 24 + Math.max(32, covered > 0 ? 32 : chips) + (hasNotice ? 36 : 0);
  return covered > 0
    ? { top: top + 12, right: 16, bottom: covered + 56, left: 16 }
    : { top, right: 68, bottom: 84, left: 16 };
}

const beyond = (value, limit) => Math.sign(value) * Math.max(0, Math.abs(value) - limit);

const mix = (a, b, u) => ({ x: a.x + u * (b.x - a.x), y: a.y + u * (b.y - a.y) });
