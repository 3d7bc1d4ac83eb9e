"use strict";
// Hands on the stage: the pointer on the picture, keys, and buttons that copy.

const REFERENCE_STEP = 1e-3;   // m of an arrow key
// m/s, rad/s: velocities that a kick gives the nominal mass
const KICKED = { vertical: 0.06, horizontal: 0.14, tilt: 0.1 };

const BLINK = 0.02;   // s that amplifiers are off for
const NEAR = 14;   // px from the mover within which a finger still takes it
const PRESS = 350;   // ms after which a finger that rests on the mover takes it
const STILL = 8;     // px that a finger may move meanwhile
const LED = { vertical: 0.02, horizontal: 0.08, tilt: 0.05 };   // m/s, rad/s: how fast a reference goes to where the hand has put it
const STRIDE = 0.05;   // s of the run, at most, in a frame: a page that falls behind throws nothing
const SPARED = 1.5e-3;   // m: how near to a stop the hand can put the reference of a gap,
const CARRIED = 0.85;    // and share of the current that there is with which the motors carry the mover there

/** Return the place of a pointer on the stage: the view, axis and position (m) across and upright. `taken` is true if it
 * is on the mover or on the outline of its reference; the label is a handle. */
function pointed(event) {
  const box = at("stage").getBoundingClientRect(), x = event.clientX - box.left, y = event.clientY - box.top;
  const row = page.history?.last(), { space, gap } = page.views;
  if (!space || !row) return null;
  if (x > gap.left && y > gap.top) {
    const [face] = faceOf(page.run, row), top = gap.y(face);
    return { view: gap, taken: y > top - NEAR && y < top + BLOCK + NEAR, places: { [vertical()]: 1e-3 * y / gap.scale } };
  }
  const label = page.hint && Math.abs(x - page.hint.x) < page.hint.half && Math.abs(y - page.hint.y) < NEAR;
  const taken = label || ["position", "reference"].some((what) => inside(hull(platformCorners(space, row, what)), [x, y], NEAR));
  const moved = space.camera.moved(x, y), [first, second] = drivenAxes(page.run);
  return { view: space, taken, label, places: { [first]: 1e-3 * moved.x, ...(second && { [second]: 1e-3 * moved.z }),
    ...(moved.y !== null && { [vertical()]: 1e-3 * moved.y }) } };
}

const dragsMover = () => at("drag-mover").checked;

/** Where a finger swipes the page scrolls: it takes the mover by its label, or once it has rested on it. */
function grab(event) {
  const found = pointed(event);
  if (event.pointerType !== "touch" || !found?.taken || found.label) { take(event, found); return; }
  page.press = { x: event.clientX, y: event.clientY, due: setTimeout(() => {
    page.press = null;
    navigator.vibrate?.(15);
    take(event, pointed(event));
  }, PRESS) };
}

function unpress() {
  clearTimeout(page.press?.due);
  page.press = null;
}

function take(event, found) {
  const row = page.history?.last();
  if (!found?.taken) {
    if (found && found.view !== page.views.gap) {
      page.turning = { x: event.clientX, y: event.clientY, ...page.orbit };
      at("stage").setPointerCapture(event.pointerId);
    }
    return;
  }
  page.dragged = true;
  const what = dragsMover() ? "position" : "reference";
  page.drag = { mover: dragsMover(), kind: found.view.kind, offsets: Object.fromEntries(Object.entries(found.places)
    .map(([axis, place]) => [axis, row.axes[axis][what] - place])) };
  at("stage").setPointerCapture(event.pointerId);
  at("stage").focus({ preventScroll: true });
  event.preventDefault();
}

const DEGREES = 0.35;   // that a px turns the view by

/** Turn the view in space by degrees. */
function turnView(yaw, pitch, from = page.orbit) {
  page.shot = null;
  page.orbit = { ...page.orbit, yaw: from.yaw + yaw, pitch: Math.min(HIGHEST, Math.max(LOWEST, from.pitch + pitch)) };
  page.dirty = true;
}

function move(event) {
  if (page.press && Math.hypot(event.clientX - page.press.x, event.clientY - page.press.y) > STILL) unpress();
  if (page.turning) {
    turnView(-DEGREES * (event.clientX - page.turning.x), DEGREES * (event.clientY - page.turning.y), page.turning);
    return;
  }
  const found = pointed(event);
  if (!page.drag) {
    at("stage").style.cursor = found?.taken ? "grab" : found && found.view !== page.views.gap ? "move" : "";
    return;
  }
  if (!found || found.view.kind !== page.drag.kind) return;
  unspare();
  for (const [axis, place] of Object.entries(found.places)) {
    const value = place + page.drag.offsets[axis];
    if (page.drag.mover) post({ type: "hold", axis, value }); else lead(axis, value);
  }
}

/** Release the hand if the platform cannot be held; the message has been shown while it was held. */
function unspare() {
  if (page.lit.spared === Infinity) page.lit.spared = performance.now();
}

function letGo() {
  unpress();
  unspare();
  if (page.drag?.mover) for (const axis of Object.keys(page.drag.offsets)) post({ type: "hold", axis, value: null });
  page.drag = page.turning = null;
}

const kindOf = (axis) => (axis === vertical() ? "vertical" : isTilt(page.run, axis) ? "tilt" : "horizontal");

/** The gap (m) between one and another that is farthest from the first and where the current is enough to hold the mover. */
function carriedGap(from, to) {
  const most = CARRIED * Math.min(valueOf("controller.current_limit") || Infinity, valueOf(`plant.${page.run.motors[0]}.amplifier.peak`));
  const carried = (gap) => !(Math.abs(carryingCurrent(page.run, atGap(page.run, page.history.last(), gap), valueOf)) > most);
  if (carried(to) || !carried(from)) return to;
  for (let [near, far] = [from, to]; ;) {
    const middle = (near + far) / 2;
    if (Math.abs(far - near) < 1e-5) return near;
    if (carried(middle)) near = middle; else far = middle;
  }
}

/** Have a reference go to where the hand has put it: no faster than the stage follows, and to where it can be held. */
function lead(axis, value) {
  const now = page.history?.last()?.axes[axis].reference;
  if (now === undefined) return;
  const target = axis === vertical() ? carriedGap(now, within(axis, value, SPARED)) : within(axis, value);
  page.leads[axis] = { now, ...page.leads[axis], target };
  if (target !== value) page.lit.spared = page.drag ? Infinity : performance.now();
}

/** Move the references towards the hand as far as they may in a time (s) of the run; return true if one is behind it. */
function followHand(time) {
  let behind = false;
  for (const [axis, each] of Object.entries(page.leads)) {
    const most = LED[kindOf(axis)] * Math.min(STRIDE, Math.max(0, time)), way = each.target - each.now;
    behind ||= Math.abs(way) > 2 * most;
    each.now += Math.min(most, Math.max(-most, way));
    refer(axis, each.now, true);
    if (each.now === each.target) delete page.leads[axis];
  }
  return behind;
}

/** Move a reference by a step from where it is. */
function nudge(axis, by) {
  const row = page.history?.last();
  if (row) refer(axis, row.axes[axis].reference + by);
}

const across = () => drivenAxes(page.run)[0];
const upward = () => drivenAxes(page.run)[1];

/** Impulse of a kick of an axis, N s or N m s. */
const impulseOf = (axis) => Number((page.run.stage.mass[axis] * KICKED[kindOf(axis)]).toPrecision(2));

// Keys act where the picture has the focus alone, so that no one who speaks or mistypes swaps a controller.
const KEYS = {
  " ": () => play(!page.playing),
  r: restart,
  k: () => kick(across(), impulseOf(across())),
  j: () => kick(vertical(), impulseOf(vertical())),
  g: () => {
    const others = controllersOf(page.run).filter((model) => model !== page.state.controller);
    setGhost(page.state.ghost ? "" : others[0]);
  },
  ArrowRight: () => nudge(across(), REFERENCE_STEP),
  ArrowLeft: () => nudge(across(), -REFERENCE_STEP),
  ArrowUp: () => (upward() ? nudge(upward(), REFERENCE_STEP) : nudge(vertical(), -REFERENCE_STEP)),
  ArrowDown: () => (upward() ? nudge(upward(), -REFERENCE_STEP) : nudge(vertical(), REFERENCE_STEP)),
  PageUp: () => nudge(vertical(), -REFERENCE_STEP),
  PageDown: () => nudge(vertical(), REFERENCE_STEP),
  a: () => turnView(10, 0),
  d: () => turnView(-10, 0),
  w: () => turnView(0, 5),
  s: () => turnView(0, -5),
};

function pressed(event) {
  if (event.ctrlKey || event.metaKey || event.altKey || !page.run) return;
  const act = KEYS[event.key] ?? swapKey(event.key);
  if (!act) return;
  event.preventDefault();
  act();
}

/** Digits swap the controller: 1 the first that there is, and so on. */
function swapKey(key) {
  const model = /^[1-9]$/.test(key) && controllersOf(page.run)[Number(key) - 1];
  return model ? () => swap(model) : undefined;
}

async function copy(text, what) {
  at("copied").value = text;
  at("copied").hidden = false;
  try {
    await navigator.clipboard.writeText(text);
    say(`Copied: ${what}.`);
  } catch {
    at("copied").focus();
    at("copied").select();
    say(`The ${what} is selected: copy it with the keys of your system.`);
  }
}
