"use strict";
// The stage in space: stators with their coils, the air gap, the platform with its magnets below, and its load.

const STACK = 90, DENSITY = 7.8e-6;   // mm: width of a motor, drawn freely; kg/mm³ of a weight
const FLOOR = 26;                     // mm below the lowest platform, drawn freely
const LEDGE = 80;                     // mm of a platform before its stator, where that leaves no room for a weight

/** Return the bodies at rest, in mm: a stator for each motor, the platform about the middle of its face, and the total
 * size. */
function bodiesOf(run) {
  const { sheet, room, places } = run.stage, half = 500 * POLES * sheet.pole_pitch;
  const driven = drivenAxes(run), pitch = 1e3 * sheet.slot_pitch, needed = half + 1e3 * room.along;
  const motors = run.motors.flatMap((motor) => places[motor].map(([x, z]) => ({ motor, x: 1e3 * x, z: 1e3 * z,
    along: driven.indexOf(run.drives[motor]) })));
  const stators = motors.map((one) => {
    // As long as the motors across leave room for.
    const across = motors.filter((other) => other.along !== one.along).map((other) =>
      Math.abs(other.along ? other.x - one.x : other.z - one.z) - STACK / 2 - 6);
    const slots = Math.max(6, Math.floor(2 * Math.min(needed, ...across) / pitch)), long = slots * pitch / 2;
    const [dx, dz] = one.along ? [STACK / 2, long] : [long, STACK / 2];
    return { ...one, slots, ...box([one.x - dx, -YOKE - TEETH, one.z - dz], [one.x + dx, 0, one.z + dz]) };
  });
  const ends = (name, along) => Math.max(...motors.map((one) => Math.abs(one[name]) + (one.along === along ? half : STACK / 2)));
  const [wide, deep] = [ends("x", 0), ends("z", 1)], lowest = 1e3 * (room.ends[1] + sheet.magnet_height) + BACK;
  const ledge = motors.length > 1 ? 0 : LEDGE, away = driven.length > 1 ? 500 * room.along : 0;
  // The space that is visible wherever the platform goes.
  const most = [wide + 500 * room.along, deep + away];
  const points = [...stators.flatMap(({ low, high }) => [low, high, [low[0], low[1], high[2]], [high[0], low[1], low[2]]]),
    ...[[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([x, z]) => [x * most[0], lowest, z * most[1] + Math.min(0, z) * ledge])];
  return { motors, stators, half, wide, deep, ledge, floor: lowest + FLOOR, points, magnet: 1e3 * sheet.magnet_height };
}

const bodies = new WeakMap();   // of runs, once each

/** The view of a run in a box of a canvas (px) from an orbit. */
function spaceView(run, place, orbit) {
  if (!bodies.has(run)) bodies.set(run, bodiesOf(run));
  const parts = bodies.get(run);
  return { kind: "space", run, ...place, camera: new Camera(orbit, place, parts.points), bodies: parts };
}

/** Return the motion of the platform: its place, and its tilts, TILT times as large. */
function motionOf(run, from, what) {
  const value = (axis) => (axis === undefined ? 0 : 1e3 * from.axes[axis][what]);
  const [x, z] = [0, 1].map((i) => value(drivenAxes(run)[i])), y = value(run.vertical);
  const slopes = drivenAxes(run).map((axis) => { const tilt = run.stage.tilts[axis];
    return tilt ? TILT * tilt.sign * 1e-3 * value(tilt.axis) : 0; });
  return ([px, py, pz]) => [px + x, py + y + slopes[0] * px + (slopes[1] ?? 0) * pz, pz + z];
}

const plateOf = ({ wide, deep, ledge, magnet }, moved) => box([-wide, magnet, -deep - ledge], [wide, magnet + BACK, deep], moved);

/** Corners (px) of the platform, or of its reference. */
const platformCorners = ({ camera, bodies: parts, run }, from, what) => {
  const plate = plateOf({ ...parts, magnet: 0 }, motionOf(run, from, what));
  return [[1, 0], [1, 1]].flatMap((side) => cornersOf(plate, side)).map((point) => camera.seen(point));
};

/** Box (px: left, top, width, height) of the platform, or of its reference. */
function boxIn(view, row, what) {
  const [x, y] = [0, 1].map((i) => platformCorners(view, row, what).map((corner) => corner[i]));
  const [left, top] = [Math.min(...x), Math.min(...y)];
  return [left, top, Math.max(...x) - left, Math.max(...y) - top];
}

function drawFloor(context, { camera, bodies: { floor, wide, deep, ledge } }, moved, colours) {
  const at = (x, z) => camera.seen([x, floor, z]), [across, along] = [1.2 * wide, 1.2 * deep + ledge];
  context.beginPath();
  for (let k = -4; k <= 4; k++) {
    for (const [from, to] of [[[k / 4, -1], [k / 4, 1]], [[-1, k / 4], [1, k / 4]]]) {
      context.moveTo(...at(across * from[0], along * from[1]));
      context.lineTo(...at(across * to[0], along * to[1]));
    }
  }
  outline(context, colours.line);
  polygon(context, [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([x, z]) => {
    const point = moved([x * wide, 0, z * deep + Math.min(0, z) * ledge]);
    return at(point[0], point[2]);
  }));
  fill(context, "#000", 0.18);
}

/** Names of the horizontal axes at the ends of the floor, or at the edge of the view where that is nearer. */
function nameAxes(context, { camera, bodies: { floor, wide, deep, ledge }, run, left, top, width, height }, colours) {
  const within = (place, from, size) => Math.min(from + size - 12, Math.max(from + 12, place));
  drivenAxes(run).forEach((axis, i) => {
    const [x, y] = camera.seen([(i ? -1.03 : 0.98) * wide, floor, (i ? 0.86 : -0.9) * (1.2 * deep + ledge)]);
    write(context, `+${axis}`, within(x, left, width), within(y, top, height), colours[`axis-${run.axes.indexOf(axis)}`] ?? colours.text, { font: "600 12px", align: "center", halo: colours.paper });
  });
}

/** A stator: iron, and on the sides that are seen its coils by the current of their phase. */
function drawStator(context, { camera }, stator, row, peak, colours) {
  const { phases } = row.motors[stator.motor], { slots, along } = stator;
  drawBox(context, camera, stator, colours.iron);
  const coil = TEETH / (YOKE + TEETH), half = SLOT / slots;
  for (const side of along ? [[0, 0], [0, 1], [1, 1]] : [[2, 0], [2, 1], [1, 1]]) {
    if (!faces(camera, stator, side)) continue;
    const below = side[0] === 1;
    for (let k = 0; k < slots; k++) {
      const [from, to] = [(k + 0.5) / slots - half, (k + 0.5) / slots + half];
      // Shares along the two axes of the side in the order x, y, z.
      const ends = below ? (along ? [[0, from], [1, to]] : [[from, 0], [to, 1]])
        : along ? [[1 - coil, from], [1, to]] : [[from, 1 - coil], [to, 1]];
      polygon(context, cornersOf(stator, side, ...ends).map((point) => camera.seen(point)));
      fill(context, colours.paper);
      fill(context, colours.current, 0.06 + 0.94 * Math.min(1, Math.abs(phases[WINDING[k % WINDING.length]]) / peak));
    }
  }
}

const SLOT = 1 / 3;   // of the slot pitch, half of the opening: b0/t1 is two thirds

/** The platform: plate and magnets. */
function drawPlatform(context, { camera, bodies: parts, run }, { row }, colours) {
  const moved = motionOf(run, row, "position"), centre = moved([0, 0, 0]);
  // Sides are chosen from a place that is to a platform at rest as the camera is to this one; tilts are too small to
  // matter.
  const view = Object.assign(Object.create(camera), { place: camera.place.map((value, i) => value - centre[i]) });
  const magnets = parts.motors.flatMap((one) => Array.from({ length: POLES }, (_, k) => {
    const at = (k - POLES / 2 + 0.5) * 2 * parts.half / POLES, long = 0.8 * parts.half / POLES, side = STACK / 2;
    const [x, z] = one.along ? [one.x, one.z + at] : [one.x + at, one.z];
    const [dx, dz] = one.along ? [side, long] : [long, side];
    return { north: k % 2 === 0, ...box([x - dx, 0, z - dz], [x + dx, parts.magnet, z + dz], moved) };
  }));
  const drawn = [() => drawBox(context, view, plateOf(parts, moved), colours.plate),
    () => { for (const each of farFirst(view, magnets)) drawBox(context, view, each, each.north ? colours.north : colours.south); }];
  for (const draw of view.place[1] < 0 ? drawn : drawn.reverse()) draw();
}

/** Box of a mover's weight: in the middle of the platform, or where it says. */
function weightOf({ bodies: { magnet, deep, ledge }, run }, { row, weight: { mass, x = 0, z = 0, above } }) {
  const size = Math.cbrt(mass / DENSITY) / 2, at = ledge ? [0, -deep - ledge / 2] : [x, z];
  const moved = motionOf(run, row, "position"), [dx, y, dz] = moved([at[0], magnet - above, at[1]]);
  return box([dx - size, y - 2 * size, dz - size], [dx + size, y, dz + size]);
}

function drawSpace(context, view, movers, { peak, forces }, colours) {
  const { camera, bodies: parts, run } = view, [{ row }, ...others] = movers, moved = motionOf(run, row, "position");
  drawFloor(context, view, moved, colours);
  const platforms = () => {
    context.globalAlpha = 0.4;
    for (const other of others) drawPlatform(context, view, other, colours);
    context.globalAlpha = 1;
    drawPlatform(context, view, movers[0], colours);
  };
  // Stators, and the weights that are between them; the nearest come last.
  const weights = movers.filter(({ weight }) => weight).map((mover) => ({ mover, ...weightOf(view, mover) }));
  const stators = () => farFirst(camera, [...parts.stators, ...weights]).forEach((body) => (body.mover
    ? drawWeight(context, camera, body, colours) : drawStator(context, view, body, row, peak, colours)));
  // The air gap is between them and the platforms: bodies on the camera's side of it come last.
  for (const draw of camera.place[1] < 0 ? [platforms, stators] : [stators, platforms]) draw();
  polygon(context, hull(platformCorners(view, row, "reference")));
  outline(context, colours.text, 1.3, DASHED);
  for (const other of others) {   // which is behind the first, as a rule
    polygon(context, hull(platformCorners(view, other.row, "position")));
    outline(context, other.colour, 2.5);
  }
  nameAxes(context, view, colours);
  if (forces) drawForces(context, view, row, forces, colours);
}

function drawWeight(context, camera, weight, colours) {
  drawBox(context, camera, weight, colours.weight);
  const middle = weight.low.map((low, i) => (low + weight.high[i]) / 2);
  write(context, `${Number(weight.mover.weight.mass.toFixed(2))} kg`, ...camera.seen(weight.moved(middle)), colours.paper,
    { font: "600 12px", align: "center", halo: colours.weight });
}

function arrow(context, x, y, dx, dy, label, colours, halo) {
  const length = Math.hypot(dx, dy);
  if (length < 10) return;   // px
  const [ux, uy] = [dx / length, dy / length];
  line(context, [[x, y], [x + dx - 6 * ux, y + dy - 6 * uy]], colours.text, 2.5);
  polygon(context, [[x + dx, y + dy], [x + dx - 9 * ux - 4.5 * uy, y + dy - 9 * uy + 4.5 * ux],
    [x + dx - 9 * ux + 4.5 * uy, y + dy - 9 * uy - 4.5 * ux]]);
  fill(context, colours.text);
  write(context, label, x + dx + 6 * (ux < -0.5 ? -1 : 1), y + dy, colours.text, { align: ux < -0.5 ? "right" : "left", halo });
}

/** Draw the forces that push the platform along: those of its motors, and of the hand. Lift and weight are next to the
 * gap. */
function drawForces(context, { camera, run, bodies: parts }, row, { thrust }, colours) {
  const newton = 1.3, moved = motionOf(run, row, "position");   // mm for 1 N
  const at = (from, x, y, z, label) => {
    const [a, b] = [from, [from[0] + x, from[1] + y, from[2] + z]].map((point) => camera.seen(point));
    arrow(context, ...a, b[0] - a[0], b[1] - a[1], label, colours);
  };
  const [first, second] = drivenAxes(run), push = (axis) => (axis ? newton * row.axes[axis].force : 0);
  at(moved([0, 0, 0]), 4 * newton * thrust[first], 0, 4 * newton * (thrust[second] ?? 0), "thrust ×4");
  at(moved([0, parts.magnet + BACK, 0]), push(first), push(run.vertical), push(second), "push");
}
