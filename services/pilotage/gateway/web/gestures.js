// Wheel, drag, pinch and keys to view; while a pose is aimed, drags belong to the aim.
//
// A finger that rests sets a goal: what it does from then on aims it.

const KEY_PAN = 48;
const ZOOM_STEP = 1.4;
const WHEEL = 0.0015;
const LONG_MS = 400;
const LONG_PX = 8;
const TAP_PX = 4;

/**
 * Lets `canvas` be panned, zoomed and turned; `aim` may take presses, `onHover` hears points, and
 * `onTap(point, isTouch)` of what was pressed and let go at one place.
 */
export function startGestures(canvas, view, { aim, onMove, onHover, onLongPress, onTap }) {
  const pointers = new Map();
  let resting = null;
  let tapping = null;

  const rest = (point) => {
    const timer = setTimeout(() => {
      resting = tapping = null;
      onLongPress(point);
    }, LONG_MS);
    resting = { point, timer };
  };
  const unrest = () => {
    clearTimeout(resting?.timer);
    resting = null;
  };

  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, at(event));
    unrest();
    tapping = pointers.size === 1 && event.button === 0 && !aim.isActive ? at(event) : null;
    if (aim.isActive && pointers.size === 1) aim.press(at(event));
    else if (event.pointerType === "touch" && pointers.size === 1) rest(at(event));
    canvas.classList.add("is-dragging");
  });

  canvas.addEventListener("pointermove", (event) => {
    onHover(at(event));
    const before = pointers.get(event.pointerId);
    if (!before) return;
    const now = at(event);
    // A finger is never quite still: until it has gone some way, it rests.
    if (resting && span(resting.point, now).length < LONG_PX) return;
    unrest();
    if (tapping && span(tapping, now).length > TAP_PX) tapping = null;
    if (aim.isActive && pointers.size === 1) aim.drag(now);
    else if (pointers.size === 1) drag(before, now);
    else if (pointers.size === 2) pinch(event.pointerId, before, now);
    pointers.set(event.pointerId, now);
  });

  const release = (event) => {
    unrest();
    if (aim.isActive && pointers.has(event.pointerId)) aim.release();
    pointers.delete(event.pointerId);
    if (pointers.size === 0) canvas.classList.remove("is-dragging");
  };
  canvas.addEventListener("pointerup", (event) => {
    release(event);
    if (tapping && !aim.isActive) onTap(tapping, event.pointerType === "touch");
    tapping = null;
  });
  canvas.addEventListener("pointercancel", release);
  canvas.addEventListener("pointerleave", () => onHover(null));

  canvas.addEventListener(
    "wheel",
    (event) => {
      event.preventDefault();
      const pixels = event.deltaMode === 0 ? event.deltaY : event.deltaY * 32;
      view.zoomBy(Math.exp(-pixels * WHEEL), at(event));
      onMove();
    },
    { passive: false },
  );

  // The menu that a resting finger opens elsewhere would cover the goal.
  canvas.addEventListener("contextmenu", (event) => event.pointerType === "touch" && event.preventDefault());

  canvas.addEventListener("dblclick", (event) => {
    if (aim.isActive) return;
    view.zoomBy(2, at(event));
    onMove();
  });

  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (aim.isActive ? aim.key(event) : key(event.key)) {
      event.preventDefault();
      onMove();
    }
  });

  function drag(before, now) {
    const [dx, dy] = [now.x - before.x, now.y - before.y];
    if (dx === 0 && dy === 0) return;
    view.panBy(dx, dy);
    onMove();
  }

  function pinch(id, before, now) {
    const other = [...pointers].find(([otherId]) => otherId !== id)[1];
    const [old, fresh] = [span(other, before), span(other, now)];
    if (old.length > 0) view.zoomBy(fresh.length / old.length, other, old.angle - fresh.angle, false);
    view.follows = false;
    onMove();
  }

  function key(name) {
    const steps = { ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
    if (steps[name]) view.panBy(...steps[name].map((step) => step * KEY_PAN));
    else if (name === "+" || name === "=") zoomIn(view);
    else if (name === "-") zoomOut(view);
    else return false;
    return true;
  }
}

export const zoomIn = (view) => view.zoomBy(ZOOM_STEP, view.focus);
export const zoomOut = (view) => view.zoomBy(1 / ZOOM_STEP, view.focus);
export const rotate = (view) => view.zoomBy(1, view.focus, Math.PI / 2);

const at = (event) => ({ x: event.offsetX, y: event.offsetY });

function span(a, b) {
  return { length: Math.hypot(b.x - a.x, b.y - a.y), angle: Math.atan2(b.y - a.y, b.x - a.x) };
}
