// Turns, moves and zooms the cloud: by mouse, touch and keyboard.

const DEGREES_PER_PIXEL = 0.4;
const KEY_DEGREES = 10;
const KEY_PIXELS = 40;
const CLICK_PIXELS = 4;

const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

/** Calls `changed()` after each change, and `clicked(x, y)`, in pixels from the middle, right and up. */
export function control(canvas, turntable, changed, clicked) {
  const pointers = new Map();
  let travelled = 0;
  const fromMiddle = (event) => {
    const box = canvas.getBoundingClientRect();
    return [event.clientX - box.left - box.width / 2, box.top + box.height / 2 - event.clientY];
  };
  const spread = () => {
    const [a, b] = [...pointers.values()];
    return Math.hypot(a[0] - b[0], a[1] - b[1]);
  };
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    if (pointers.size === 0) travelled = 0;
    pointers.set(event.pointerId, fromMiddle(event));
  });
  canvas.addEventListener("pointermove", (event) => {
    const before = pointers.get(event.pointerId);
    if (!before) return;
    const now = fromMiddle(event);
    const [right, up] = [now[0] - before[0], now[1] - before[1]];
    travelled += Math.hypot(right, up);
    const apart = pointers.size === 2 ? spread() : 0;
    pointers.set(event.pointerId, now);
    if (pointers.size === 2) {
      turntable.move(right / 2, -up / 2);
      if (apart > 0) turntable.zoomBy(spread() / apart, ...now);
    } else if (travelled > CLICK_PIXELS) {
      if (event.buttons & 6 || event.shiftKey) turntable.move(right, -up);
      else turntable.turn(-right * DEGREES_PER_PIXEL, -up * DEGREES_PER_PIXEL);
    }
    changed();
  });
  const leave = (event) => {
    const was = pointers.delete(event.pointerId);
    if (was && event.type === "pointerup" && event.button === 0 && pointers.size === 0 && travelled <= CLICK_PIXELS) {
      clicked(...fromMiddle(event));
    }
  };
  canvas.addEventListener("pointerup", leave);
  canvas.addEventListener("pointercancel", leave);
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    const pixels = event.deltaMode === 1 ? event.deltaY * 30 : event.deltaY;
    turntable.zoomBy(Math.exp(-Math.max(Math.min(pixels, 300), -300) * 0.0015), ...fromMiddle(event));
    changed();
  }, { passive: false });
  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    if (!pressKey(turntable, event)) return;
    event.preventDefault();
    changed();
  });
}

/** Does what a key asks for; false if it asks for nothing. */
function pressKey(turntable, { key, shiftKey }) {
  if (key in ARROWS) {
    const [right, down] = ARROWS[key];
    if (shiftKey) turntable.move(right * KEY_PIXELS, down * KEY_PIXELS);
    else turntable.turn(-right * KEY_DEGREES, down * KEY_DEGREES);
  } else if (key === "+" || key === "=") {
    turntable.zoomBy(1.25);
  } else if (key === "-" || key === "_") {
    turntable.zoomBy(0.8);
  } else if (key === "0" || key === "Home") {
    turntable.fit();
  } else {
    return false;
  }
  return true;
}
