"use strict";
// The stage to scale: of the motors of each axis a view from the side, and where it moves along two axes one from above.
// Slots, poles, magnets and gap are those of the data sheet; iron, and how much of the stator is shown, are drawn freely.

const POLES = 4, SLOTTED = 0.79;                   // shown: poles of the mover, share of a view that has slots
const YOKE = 8, TEETH = 22, BACK = 13;             // mm: the stator's iron above its slots, their depth, the mover's iron
const MARGIN = { width: 13.4, height: 18, text: 38 };   // mm around all that moves; px for texts
const NARROW = 520;                                // px, below which there is no view from above
const TILT = 5;                                    // times as large as they are, tilts are drawn
// Phase and direction of winding of successive slots: one slot for each pole and phase.
const WINDING = [[0, 1], [2, -1], [1, 1], [0, -1], [2, 1], [1, -1]];
const newtonsOf = (view) => Math.min(0.42, 0.23 * view.scale);   // px for 1 N

/** Room (mm) of a view, in which the mover comes to its stops. */
const roomOf = ({ rig: { sheet, room } }) => ({ width: 1e3 * (POLES * sheet.pole_pitch + 2 * room.along) + MARGIN.width,
  height: YOKE + TEETH + 1e3 * (room.gap + sheet.magnet_height) + BACK + MARGIN.height });

const aboveView = (room, left, width, height) => ({ kind: "above", left, top: 0, width, height,
  scale: Math.min(width, height - 24) / room.width, middle: left + width / 2, centre: 20 + (height - 20) / 2 });

/** Views of a run on a canvas of a size (px): what they show, where, and px for 1 mm. `seen` is from where: "space" on an
 * orbit, "sides", "above". */
function viewsOf(run, width, height, { seen, orbit }) {
  if (seen === "space") return [spaceView(run, width, height, orbit)];
  if (seen === "above") return [aboveView(roomOf(run), 0, width, height)];
  // Motors that drive one axis look alike from the side.
  const room = roomOf(run), sides = drivenAxes(run).map((axis) => ({ kind: "side", axis, room, sheet: run.rig.sheet,
    motors: motorsOf(run, axis), slots: Math.floor(SLOTTED * room.width / (1e3 * run.rig.sheet.slot_pitch)) }));
  // A phone has the views from the side alone, or that from above: they stay in sight while its controls are used.
  const above = sides.length > 1 && width >= NARROW, share = above ? 0.68 : 1;
  const high = height / sides.length;   // px of a view from the side
  const scale = Math.min(share * width / room.width, (high - MARGIN.text) / room.height);
  const views = sides.map((view, i) => ({ ...view, scale, left: 0, top: i * high, width: share * width,
    height: high, middle: share * width / 2, stator: i * high + 17 + (YOKE + TEETH) * scale }));
  if (above) views.push(aboveView(room, share * width, width - share * width, height));
  return views;
}

/** Height that the stage wants on a page of a width (px). */
function stageHeight(run, width, seen) {
  if (seen === "above") return Math.min(430, width, Math.max(250, 0.43 * innerHeight));
  if (seen === "space") return Math.min(430, Math.max(250, Math.min(0.52 * width, 0.43 * innerHeight)));
  const room = roomOf(run), side = (share) => share * width / room.width * room.height + MARGIN.text;
  if (drivenAxes(run).length === 1) return Math.min(340, side(1));
  return width < NARROW ? 2 * side(1) : Math.min(430, 2 * side(0.68));
}

function arrow(context, x, y, dx, dy, label, colours) {
  const length = Math.hypot(dx, dy);
  if (length < 3) return;
  const [ux, uy] = [dx / length, dy / length];
  line(context, [[x, y], [x + dx - 6 * ux, y + dy - 6 * uy]], colours.text, 2.5);
  polygon(context, [[x + dx, y + dy], [x + dx - 9 * ux - 4.5 * uy, y + dy - 9 * uy + 4.5 * ux],
    [x + dx - 9 * ux + 4.5 * uy, y + dy - 9 * uy - 4.5 * ux]]);
  context.fillStyle = colours.text;
  context.fill();
  write(context, label, x + dx + 6 * (ux < -0.5 ? -1 : 1), y + dy, colours.text, { align: ux < -0.5 ? "right" : "left" });
}

/** The iron, and in its slots the coils of each motor, one row above the other. */
function drawStator(context, view, row, values, colours) {
  const { scale, middle, stator, sheet, slots, motors } = view;
  const pitch = sheet.slot_pitch * 1e3 * scale, slot = sheet.slot_width * 1e3 * scale;
  const left = middle - slots * pitch / 2, tall = TEETH * scale / motors.length;
  context.fillStyle = colours.iron;
  context.fillRect(left, stator - (YOKE + TEETH) * scale, slots * pitch, (YOKE + TEETH) * scale);
  motors.forEach((motor, place) => {
    const { phases } = row.motors[motor], peak = values(`plant.${motor}.amplifier.peak`) || 5;
    const y = stator - TEETH * scale + place * tall, side = motors.length > 1;
    for (let k = 0; k < slots; k++) {
      const [phase, direction] = WINDING[k % WINDING.length];
      const current = direction * phases[phase], strength = Math.min(1, Math.abs(current) / peak);
      const x = left + (k + 0.5) * pitch - slot / 2;
      context.fillStyle = colours.paper;
      context.fillRect(x, y, slot, tall);
      context.globalAlpha = 0.06 + 0.94 * strength;
      context.fillStyle = colours.current;
      context.fillRect(x, y, slot, tall - (side ? 1 : 0));
      context.globalAlpha = 1;
      const form = { font: `${Math.max(9, Math.min(0.5 * slot, 0.7 * tall))}px`, align: "center" };
      // Out of the plane or into it, as the point and the feathers of an arrow; the letter is the phase.
      const [markX, markY, letterX, letterY] = side ? [0.28, 0.52, 0.7, 0.52] : [0.5, 0.3, 0.5, 0.74];
      if (strength > 0.02) write(context, current > 0 ? "•" : "×", x + markX * slot, y + markY * tall, colours.text, form);
      if (!side || slot > 16) write(context, "abc"[phase], x + letterX * slot, y + letterY * tall, colours.text, form);
    }
  });
}

function moverOutline(view, along, gap) {
  const { scale, middle, stator, sheet } = view, width = POLES * sheet.pole_pitch * 1e3 * scale;
  return [middle + along * scale - width / 2, stator + gap * scale, width,
    (sheet.magnet_height * 1e3 + BACK) * scale];
}

/** Draw what tilts with the mover, about the middle of its face and TILT times as far. */
function tilted(context, view, run, at, draw) {
  const tilt = run.rig.tilts[view.axis];
  if (!tilt) { draw(); return; }
  const x = view.middle + at(view.axis) * view.scale, y = view.stator + at(run.vertical) * view.scale;
  context.save();
  context.translate(x, y);
  context.rotate(TILT * tilt.sign * 1e-3 * at(tilt.axis));
  context.translate(-x, -y);
  draw();
  context.restore();
}

function drawMover(context, view, along, gap, colours) {
  const [x, y, width, height] = moverOutline(view, along, gap), magnet = view.sheet.magnet_height * 1e3 * view.scale;
  context.fillStyle = colours.iron;
  context.fillRect(x, y + magnet, width, height - magnet);
  const pole = width / POLES, form = { font: `600 ${Math.max(8, 0.95 * magnet)}px`, align: "center" };
  for (let k = 0; k < POLES; k++) {
    const north = k % 2 === 0;
    context.fillStyle = north ? colours.north : colours.south;
    context.fillRect(x + (k + 0.1) * pole, y, 0.8 * pole, magnet);
    write(context, north ? "N" : "S", x + (k + 0.5) * pole, y + magnet / 2 + 0.5, colours.paper, form);
  }
}

/** Box (px: left, top, width, height) of the mover in a view, or of its reference. */
function boxIn(view, run, row, what) {
  if (view.kind === "space") {
    const [x, y] = [0, 1].map((i) => platformCorners(view, row, what).map((corner) => corner[i]));
    const [left, top] = [Math.min(...x), Math.min(...y)];
    return [left, top, Math.max(...x) - left, Math.max(...y) - top];
  }
  const mm = (axis) => 1e3 * row.axes[axis][what];
  if (view.kind === "side") return moverOutline(view, mm(view.axis), mm(run.vertical));
  const [across, along] = drivenAxes(run), size = POLES * run.rig.sheet.pole_pitch * 1e3 * view.scale;
  return [view.middle + mm(across) * view.scale - size / 2, view.centre - mm(along) * view.scale - size / 2, size, size];
}

function drawScales(context, view, run, values, colours) {
  const { scale, middle, stator, left, top, width } = view;
  const bottom = stator + (view.room.height - YOKE - TEETH) * scale - 2;
  const ends = 1e3 * run.rig.room.along, step = tickStep(2 * ends, 3);
  const most = step * Math.floor(ends / step);
  for (let k = -5 * most / step; k <= 5 * most / step; k++) {
    const mm = Number((k * step / 5).toPrecision(6)), x = Math.round(middle + mm * scale) + 0.5;
    line(context, [[x, bottom], [x, bottom + (k % 5 ? 3 : 6)]], colours.faint);
    if (k % 5 === 0) write(context, mm ? String(mm).replace("-", "−") : `${view.axis} = 0 mm`, x, bottom + 7, colours.faint,
      { align: "center", base: "top" });
  }
  // End stops: of the gap beside the mover, of the displacement on the scale.
  for (const end of [0, 1]) {
    const [gap, along] = [run.vertical, view.axis].map((axis) => 1e3 * endsOf(run, axis, values)[end]);
    for (const x of [middle - 0.495 * width + 4, middle + 0.495 * width - 14]) {
      line(context, [[x, stator + gap * scale], [x + 10, stator + gap * scale]], colours.text, 2);
    }
    line(context, [[middle + along * scale, bottom - 7], [middle + along * scale, bottom + 7]], colours.text, 2);
  }
  const tilt = run.rig.tilts[view.axis], [first, ...others] = view.motors;
  const named = others.length ? `, coils ${[first, ...others].join(" over ")}`
    : `, motor${run.rig.sharing > 1 ? "s" : ""}${run.motors.length > 1 ? ` ${first}` : ""}`;
  write(context, `from the side: ${view.axis}${tilt ? "," : " and"} air gap ${run.vertical}${tilt
    ? ` and ${tilt.axis} ×${TILT}` : ""}${named}`, left + 4, top, colours.text, { base: "top" });
}

function drawSide(context, view, run, row, ghost, values, colours) {
  const mm = (axis, what, from = row) => 1e3 * from.axes[axis][what], vertical = run.vertical;
  drawStator(context, view, row, values, colours);
  drawScales(context, view, run, values, colours);
  for (const flown of ghost ? [ghost, row] : [row]) {
    const place = (axis) => mm(axis, "position", flown);
    context.globalAlpha = flown === row ? 1 : 0.32;
    tilted(context, view, run, place, () => drawMover(context, view, place(view.axis), place(vertical), colours));
  }
  const wanted = (axis) => mm(axis, "reference");
  tilted(context, view, run, wanted, () =>
    boxed(context, moverOutline(view, wanted(view.axis), wanted(vertical)), colours.text, 1.3, DASHED));
  const [x, y, width, height] = moverOutline(view, mm(view.axis, "position"), mm(vertical, "position"));
  const forces = forcesOf(run, row, values), middle = x + width / 2;
  const newton = newtonsOf(view), thrust = newton * 4 * forces.thrust[view.axis];
  arrow(context, middle - 0.12 * width, y, 0, -newton * forces.lift, "lift", colours);
  arrow(context, middle + 0.12 * width, y + height, 0, newton * forces.weight, "weight", colours);
  arrow(context, thrust > 0 ? x + width : x, y + height / 2, thrust, 0, "thrust ×4", colours);
  const push = [row.axes[view.axis].force, row.axes[vertical].force];
  arrow(context, middle, y + height, newton * push[0], newton * push[1], "push", colours);
}

function drawAbove(context, view, run, row, ghost, values, colours) {
  const { scale, middle, centre, left, top } = view;
  const [across, along] = drivenAxes(run);
  const limits = (axis) => endsOf(run, axis, values).map((end) => 1e3 * end * scale);
  write(context, `from above: ${across} to the right, ${along} up`, left + 4, top, colours.text, { base: "top" });
  // The motors that drive an axis lie side by side from edge to edge, a single one in the middle.
  const body = (from) => {
    const [x, y, size] = boxIn(view, run, from, "position"), bar = 0.16 * size;
    context.fillStyle = colours.iron;
    context.fillRect(x, y, size, size);
    for (const axis of [across, along]) {
      const count = run.rig.sharing * motorsOf(run, axis).length;
      context.fillStyle = colours[axis];
      for (let k = 0; k < count; k++) {
        const at = (count > 1 ? k / (count - 1) : 0.5) * (size - bar);
        context.fillRect(...(axis === across ? [x + bar, y + at, size - 2 * bar, bar] : [x + at, y + bar, bar, size - 2 * bar]));
      }
    }
  };
  if (ghost) { context.globalAlpha = 0.32; body(ghost); context.globalAlpha = 1; }
  body(row);
  boxed(context, boxIn(view, run, row, "reference"), colours.text, 1.3, DASHED);
  const [x0, x1] = limits(across), [z0, z1] = limits(along);
  boxed(context, [middle + x0, centre - z1, x1 - x0, z1 - z0], colours.paper, 2);   // where the middle can be: the end stops
  const [corner, edge, size] = boxIn(view, run, row, "position"), [x, y] = [corner + size / 2, edge + size / 2];
  context.fillStyle = colours.text;
  context.beginPath();
  context.arc(x, y, 4, 0, 2 * Math.PI);
  context.fill();
  const { thrust } = forcesOf(run, row, values), newton = newtonsOf(view) * 1.5;
  arrow(context, x, y, newton * 4 * thrust[across], -newton * 4 * thrust[along], "thrust ×4", colours);
  arrow(context, x, y, newton * row.axes[across].force, -newton * row.axes[along].force, "push", colours);
}

/** Say on the mover what one can do with it. */
function drawHint(canvas, view, run, row, colours) {
  const context = canvas.getContext("2d"), [left, top, width, height] = boxIn(view, run, row, "position");
  const [x, y] = [left + (view.kind === "space" ? 0.78 : 0.6) * width, top + 0.78 * height], text = "↔ drag me ↕";
  context.font = "600 14px system-ui, sans-serif";
  const half = context.measureText(text).width / 2 + 9;
  context.fillStyle = colours.text;
  context.beginPath();
  context.roundRect(x - half, y - 13, 2 * half, 26, 13);
  context.fill();
  write(context, text, x, y + 1, colours.paper, { font: "600 14px", align: "center" });
}

function drawStage(canvas, run, row, ghost, values, colours, from) {
  const { context, width, height } = sized(canvas), views = viewsOf(run, width, height, from);
  const draw = { side: drawSide, above: drawAbove, space: drawSpace };
  for (const view of views) draw[view.kind](context, view, run, row, ghost, values, colours);
  return views;
}
