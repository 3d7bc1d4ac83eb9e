"use strict";
// The picture of a run, which turns to where something happens, its events, and the numbers above it.

/** The end (m) of the gap that a row is nearest to; where the platform tilts, at one motor first. */
function endAt(row) {
  const ends = endsOf(page.run, vertical(), valueOf);
  const gaps = page.run.motors.map((motor) => gapOf(page.run, row, motor, valueOf));
  const far = (end) => Math.min(...gaps.map((gap) => Math.abs(gap - end)));
  return far(ends[0]) < far(ends[1]) ? ends[0] : ends[1];
}

/** Explain a stop that is touched: why the mover does not leave it, in currents. */
function touched(time, end) {
  const { run } = page, below = end > endsOf(run, vertical(), valueOf)[0];
  const needed = Math.abs(carryingCurrent(run, atGap(run, page.history.last(), end), valueOf));
  const most = Math.min(valueOf("controller.current_limit") || Infinity, valueOf(`plant.${run.motors[0]}.amplifier.peak`));
  const what = `At ${time.toFixed(2)} s the platform ${below ? "fell onto its lower" : "was drawn to its upper"} stop`;
  if (valueOf(`plant.${run.motors[0]}.amplifier.off`) === true) return `${what}: the amplifiers are off.`;
  return needed > most ? `${what}. ${below ? "To lift it" : "To let go of it"} takes ${needed.toFixed(1)} A; there are ${most.toFixed(1)} A.` : `${what}.`;
}

/** Keep in the picture that a run has met an end. */
function hit(row, time, name) {
  const end = endAt(row);
  if (!page.hits.some((each) => each.name === name)) page.hits.push({ end, name, text: `${name} hit it at ${time.toFixed(2)} s` });
  page.dirty = true;
  return end;
}

/** Fill in the values that change with every frame, four times a second. */
let lastReadings = 0;
function readings(now) {
  if (now - lastReadings < 250 || !page.frame) return;
  lastReadings = now;
  const row = page.history.last();
  at("time").textContent = `${row.time.toFixed(2)} s`;
  const { pace } = page.frame, { speed } = page.state, slower = Math.abs(pace - speed) > 0.1 * speed;
  at("pace").textContent = !page.playing ? "paused" : pace === 0 ? "" : `${pace.toFixed(pace < 1 ? 2 : 1)}× real time${slower ? `, asked for ${speed}×` : ""}`;
  for (const axis of page.run.axes) {
    const shown = page.run.stage.shown[axis];
    page.panel.references[axis]?.(shown.scale * row.axes[axis].reference);
    at(`reading-${axis}`).textContent = reading(shown, row.axes[axis].position);
  }
}

/** Return the load on the platform: a weight that an experiment lets fall, or the mass added to the plan's. */
function weightNow(time) {
  const fall = page.story?.falls;
  if (fall && time < fall.at) {
    const for_ = Math.max(0, time - fall.at + Math.sqrt(2 * fall.height / live.gravity));
    return { mass: fall.mass, above: 1e3 * (fall.height - live.gravity / 2 * for_ ** 2) };
  }
  const own = valueOf("plant.payload.mass"), name = `plant.${vertical()}.mass`;
  const mass = own ?? valueOf(name) - plannedValue(page.run, page.state.controller, name);
  const [x, z] = ["x", "z"].map((axis) => 1e3 * (valueOf(`plant.payload.${axis}`) ?? 0));
  return mass > 0.01 ? { mass, x, z, above: 0 } : null;
}

/** Let the view move on to its target. */
function moveCamera() {
  const { shot, orbit } = page;
  if (!shot) return;
  const share = matchMedia("(prefers-reduced-motion: reduce)").matches ? 1 : 0.1, keys = ["yaw", "pitch", "zoom"];
  const left = keys.map((key) => shot[key] - orbit[key]);
  keys.forEach((key, i) => { orbit[key] += share * left[i]; });
  if (Math.max(Math.abs(left[0]), Math.abs(left[1]), 50 * Math.abs(left[2])) < 0.2) page.shot = null;
  page.dirty = true;
}

function draw(now) {
  requestAnimationFrame(draw);
  if (!page.history?.count) return;
  moveCamera();
  if (page.dirty) drawNow(now);
}

function drawNow(now) {
  page.dirty = false;
  page.frames++;
  const { run, state, colours } = page, row = page.history.last(), ghost = page.ghost?.last() ?? null, weight = weightNow(row.time);
  const drawn = (of, model) => ({ row: of, name: lawOf(run, model), colour: colours[colourOf(run, model)], weight });
  page.views = drawScene(at("stage"), run, [drawn(row, state.controller), ...(ghost ? [drawn(ghost, state.ghost)] : [])], {
    orbit: { ...page.orbit, at: [0, 1e3 * row.axes[run.vertical].position, 0] }, ends: endsOf(run, run.vertical, valueOf),
    peak: valueOf(`plant.${run.motors[0]}.amplifier.peak`) || 5, forces: forcesOf(run, row, valueOf), hits: page.hits }, colours);
  page.hint = null;
  if ((!page.dragged || COARSE.matches) && !state.story && !page.printed) drawHint(at("stage"), page.views.space, row, colours);
  drawPlots(page.history, page.ghost);
  readings(now);
  post({ type: "drawn" });
}

const COARSE = matchMedia("(pointer: coarse)");   // a finger takes the platform by its label

/** Say on the platform what one can do with it. */
function drawHint(canvas, view, row, colours) {
  const context = canvas.getContext("2d"), [left, top, width, height] = boxIn(view, row, "position");
  const [x, y] = [left + 0.74 * width, top + 0.86 * height], text = "↔ drag me ↕";
  context.font = "600 14px system-ui, sans-serif";
  const half = context.measureText(text).width / 2 + 9;
  page.hint = { x, y, half };
  context.beginPath();
  context.roundRect(x - half, y - 13, 2 * half, 26, 13);
  fill(context, colours.text);
  write(context, text, x, y + 1, colours.paper, { font: "600 14px", align: "center" });
}

function readColours(printed) {
  page.printed = onPaper = Boolean(printed);
  if (plots.live) plots.live.stale = true;
  page.colours = sceneColours(page.run?.axes ?? [], printed);
  page.dirty = true;
}

function layout() {
  at("stage").setAttribute("aria-label", "The stage, and its air gap. Arrow keys move the references by 1 mm, page up and down that of the gap; space pauses, 1 to 4 swap the controller, k and j kick.");
  readColours();
}
