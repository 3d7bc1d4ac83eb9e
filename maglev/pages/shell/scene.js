"use strict";
// A moving stage, live or recorded: in space, and next to it its air gap, much larger.

const POLES = 4;                           // of a mover that are shown
const YOKE = 8, TEETH = 22, BACK = 13;     // mm: the stator's iron above its slots, their depth, the mover's iron
const TILT = 5;                            // exaggeration of tilts in space
const WINDING = [0, 2, 1];                 // phases of successive slots: one slot for each pole and phase
const SHOTS = { space: { yaw: -30, pitch: 20 }, sides: { yaw: 0, pitch: 4 }, above: { yaw: 0, pitch: 80 } };   // degrees

/** Horizontal axes, in the order of the motors that drive them. */
const drivenAxes = (run) => [...new Set(Object.values(run.drives))];
const isTilt = (run, axis) => run.rotations.includes(axis);

/** Ends of an axis (m, rad): its stops. If the stops are at the motors, these are the ends of the gap, and a tilt ends
 * where, from the middle, the farthest motor meets one. */
function endsOf(run, axis, values) {
  const ends = (of) => ["lower", "upper"].map((end) => values(`plant.${of}.stop.${end}`));
  const tilt = Object.values(run.stage.tilts).find((each) => each.axis === axis);
  if (!tilt) return ends(ends(axis)[0] === undefined ? run.motors[0] : axis);
  const most = Math.min(...run.motors.map((motor) => {
    const [low, high] = ends(motor);
    return (high - low) / 2 / Math.abs(values(`plant.${motor}.${tilt.place}`));
  }));
  return [-most, most];
}

/** Return the colours of the style sheet by their names, also of axes. On paper they are the light ones, its first. */
function sceneColours(axes, printed = false) {
  const first = () => [...document.styleSheets].flatMap(({ cssRules }) => [...cssRules]).find(({ selectorText }) => selectorText === ":root").style;
  const style = printed ? first() : getComputedStyle(document.documentElement), colour = (name) => style.getPropertyValue(`--${name}`).trim();
  return Object.fromEntries(["paper", "panel", "text", "faint", "line", "iron", "current", "north", "south", "plate", "weight", "bad",
    "reference", ...Array.from({ length: 7 }, (_, k) => `run-${k}`), ...axes.map((_, i) => `axis-${i}`)].map((name) => [name, colour(name)]));
}

/** Redraw when the reader's colours change, and for paper, which is told. */
function whenColoursChange(drawAnew) {
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => drawAnew(false));
  addEventListener("beforeprint", () => drawAnew(true));
  addEventListener("afterprint", () => drawAnew(false));
}

const NARROW = 520;   // px, below which the gap is under the stage

/**
 * Draw a stage.
 *
 * @param {object} run its axes, motors and stage
 * @param {object[]} movers to draw, the main one first: `row` of its run, `name` and `colour` of its controller. A `weight`
 *   has mass (kg), position x, z (mm), and height above the platform (mm)
 * @param {{orbit: object, ends: number[], peak: number, forces: object?, hits: object[]?}} look the view, the ends of the
 *   gap (m), the current (A) of the brightest coil. Forces (N) act on the first mover; hits are ends (m), with words
 * @returns {{space: object, gap: object}} the two views, for a pointer
 */
function drawScene(canvas, run, movers, look, colours) {
  const { context, width, height } = sized(canvas), under = width < NARROW, beside = Math.round(Math.min(300, 0.34 * width));
  const [across, down] = under ? [width, Math.round((look.orbit.pitch > 45 ? 0.62 : 0.42) * height)] : [width - beside - 8, height];
  const space = spaceView(run, { left: 0, top: 0, width: across, height: down }, look.orbit);
  const gap = gapView(run, under ? { left: 0, top: down, width, height: height - down }
    : { left: width - beside, top: 0, width: beside, height }, look.ends);
  for (const [view, draw] of [[space, () => drawSpace(context, space, movers, look, colours)],
    [gap, () => drawGap(context, gap, movers, look, space.camera.scale, colours)]]) {
    context.save();
    context.beginPath();
    context.rect(view.left, view.top, view.width, view.height);
    context.clip();
    draw();
    context.restore();
  }
  return { space, gap };
}
