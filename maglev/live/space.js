"use strict";
// The stage in space: stators with their coils, the air gap, the platform with its magnets below; turned with a finger.

const STACK = 90, PAYLOAD = 7.8e-6;   // mm: width of a motor, drawn freely; kg/mm³ of a weight that hangs below
const FLOOR = 75;                     // mm below the lowest platform, drawn freely

/** What is at rest, in mm: a stator for each motor, the platform about the middle of its face, and how large it all is. */
function bodiesOf(run) {
  const { sheet, room, places } = run.rig, half = 500 * POLES * sheet.pole_pitch;
  const driven = drivenAxes(run), pitch = 1e3 * sheet.slot_pitch, needed = half + 1e3 * room.along;
  const motors = run.motors.flatMap((motor) => places[motor].map(([x, z]) => ({ motor, x: 1e3 * x, z: 1e3 * z,
    along: driven.indexOf(run.drives[motor]) })));
  const stators = motors.map((one) => {
    // As long as those across it leave room for.
    const across = motors.filter((other) => other.along !== one.along).map((other) =>
      Math.abs(other.along ? other.x - one.x : other.z - one.z) - STACK / 2 - 6);
    const slots = Math.max(6, Math.floor(2 * Math.min(needed, ...across) / pitch)), long = slots * pitch / 2;
    const [dx, dz] = one.along ? [STACK / 2, long] : [long, STACK / 2];
    return { ...one, slots, ...box([one.x - dx, -YOKE - TEETH, one.z - dz], [one.x + dx, 0, one.z + dz]) };
  });
  const ends = (name, along) => Math.max(...motors.map((one) => Math.abs(one[name]) + (one.along === along ? half : STACK / 2)));
  const [wide, deep] = [ends("x", 0), ends("z", 1)], lowest = 1e3 * (room.gap + sheet.magnet_height) + BACK;
  const radius = Math.hypot(Math.max(wide, ...stators.map(({ high }) => high[0])),
    Math.max(deep, ...stators.map(({ high }) => high[2]))) + 500 * room.along;
  return { motors, stators, half, wide, deep, floor: lowest + FLOOR, radius, magnet: 1e3 * sheet.magnet_height };
}

/** The view of a run on a canvas (px), for `drawStage`; a platform's place is kept for the pointer. */
function spaceView(run, width, height, orbit) {
  const bodies = bodiesOf(run), top = -YOKE - TEETH, tall = bodies.floor - top;
  const camera = new Camera(orbit.yaw, orbit.pitch, { width, height: height - 26, radius: bodies.radius,
    middle: (bodies.floor + top) / 2, tall });
  camera.top += 4;   // what is near is drawn larger, and is below
  return { kind: "space", run, left: 0, top: 0, width, height, camera, bodies };
}

/** How the platform is moved: its place, and its tilts TILT times as large. */
function motionOf(run, from, what) {
  const value = (axis) => (axis === undefined ? 0 : 1e3 * from.axes[axis][what]);
  const [x, z] = [0, 1].map((i) => value(drivenAxes(run)[i])), y = value(run.vertical);
  const slopes = drivenAxes(run).map((axis) => { const tilt = run.rig.tilts[axis];
    return tilt ? TILT * tilt.sign * 1e-3 * value(tilt.axis) : 0; });
  return ([px, py, pz]) => [px + x, py + y + slopes[0] * px + (slopes[1] ?? 0) * pz, pz + z];
}

const plateOf = ({ wide, deep, magnet }, moved) => box([-wide, magnet, -deep], [wide, magnet + BACK, deep], moved);

/** Corners (px) of the platform, or of its reference. */
const platformCorners = ({ camera, bodies, run }, from, what) => {
  const plate = plateOf({ ...bodies, magnet: 0 }, motionOf(run, from, what));
  return [[1, 0], [1, 1]].flatMap((side) => cornersOf(plate, side)).map((point) => camera.seen(point));
};

function drawFloor(context, { camera, bodies, run }, moved, colours) {
  const { floor, radius, wide, deep } = bodies, at = (x, z) => camera.seen([x, floor, z]), reach = 0.7 * radius;
  context.beginPath();
  for (let k = -4; k <= 4; k++) {
    for (const [from, to] of [[[k / 4, -1], [k / 4, 1]], [[-1, k / 4], [1, k / 4]]]) {
      context.moveTo(...at(reach * from[0], reach * from[1]));
      context.lineTo(...at(reach * to[0], reach * to[1]));
    }
  }
  outline(context, colours.line);
  polygon(context, [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([x, z]) => {
    const point = moved([x * wide, 0, z * deep]);
    return at(point[0], point[2]);
  }));
  context.globalAlpha = 0.18;
  context.fillStyle = "#000";
  context.fill();
  context.globalAlpha = 1;
  drivenAxes(run).forEach((axis, i) => write(context, `+${axis}`, ...at(i ? -0.86 * reach : 0.62 * reach,
    i ? 0.62 * reach : -0.9 * reach), colours[axis], { font: "12px", align: "center" }));
}

/** A stator: iron, and on the sides that are seen its coils by the current of their phase. */
function drawStatorBox(context, { camera }, stator, row, peak, colours) {
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
      context.fillStyle = colours.paper;
      context.fill();
      context.globalAlpha = 0.06 + 0.94 * Math.min(1, Math.abs(phases[WINDING[k % WINDING.length][0]]) / peak);
      context.fillStyle = colours.current;
      context.fill();
      context.globalAlpha = 1;
    }
  }
}

const SLOT = 1 / 3;   // of the slot pitch, half of what is open: b0/t1 is two thirds

/** The platform: plate, magnets, and what hangs below it. */
function drawPlatform(context, { camera, bodies, run }, from, payload, colours) {
  const moved = motionOf(run, from, "position"), plate = plateOf(bodies, moved), centre = moved([0, 0, 0]);
  // Sides are told from a place that is seen as the camera is from a platform that has not moved; tilts are too small to matter.
  const view = Object.assign(Object.create(camera), { place: camera.place.map((value, i) => value - centre[i]) });
  const magnets = bodies.motors.flatMap((one) => Array.from({ length: POLES }, (_, k) => {
    const at = (k - POLES / 2 + 0.5) * 2 * bodies.half / POLES, long = 0.8 * bodies.half / POLES, side = STACK / 2;
    const [x, z] = one.along ? [one.x, one.z + at] : [one.x + at, one.z];
    const [dx, dz] = one.along ? [side, long] : [long, side];
    return { north: k % 2 === 0, ...box([x - dx, 0, z - dz], [x + dx, bodies.magnet, z + dz], moved) };
  }));
  const size = Math.cbrt(payload.mass / PAYLOAD) / 2, weight = payload.mass > 0.01 && box(
    [payload.x - size, bodies.magnet + BACK, payload.z - size],
    [payload.x + size, bodies.magnet + BACK + 2 * size, payload.z + size], moved);
  const drawn = [() => weight && drawBox(context, view, weight, colours.weight),
    () => drawBox(context, view, plate, colours.plate),
    () => { for (const each of farFirst(view, magnets)) drawBox(context, view, each, each.north ? colours.north : colours.south); }];
  for (const draw of view.place[1] < 0 ? drawn : drawn.reverse()) draw();
}

/** What was added to the planned mass of the platform (kg), and where (mm): the knob `payload`. */
function payloadOf(run, values, planned) {
  const own = values("plant.payload.mass");
  if (own !== undefined) {
    return { mass: own, x: 1e3 * (values("plant.payload.x") ?? 0), z: 1e3 * (values("plant.payload.z") ?? 0) };
  }
  const name = `plant.${run.vertical}.mass`;
  return { mass: values(name) - planned(name), x: 0, z: 0 };
}

function drawGap(context, { camera, bodies, run }, row, colours) {
  // At the end of the nearest stator, from its face to the magnets' faces.
  const near = farFirst(camera, bodies.stators).at(-1), moved = motionOf(run, row, "position");
  const corners = [[near.low[0], near.low[2]], [near.low[0], near.high[2]], [near.high[0], near.low[2]],
    [near.high[0], near.high[2]]].sort((p, q) => camera.seen([q[0], 0, q[1]])[1] - camera.seen([p[0], 0, p[1]])[1]);
  const [x, z] = corners[0], shift = moved([0, 0, 0]), [, y] = moved([x - shift[0], 0, z - shift[2]]);
  const [top, bottom] = [camera.seen([x, 0, z]), camera.seen([x, y, z])];
  context.beginPath();
  for (const [px, py] of [top, bottom]) { context.moveTo(px - 6, py); context.lineTo(px + 6, py); }
  context.moveTo(...top);
  context.lineTo(...bottom);
  outline(context, colours.text, 2);
  context.font = "600 12px system-ui, sans-serif";
  const gap = 1e3 * gapAt(run, row);
  const text = `air gap ${gap.toFixed(1)} mm`, [left, high] = [bottom[0] + 10, bottom[1] + 14];
  context.fillStyle = colours.paper;
  context.globalAlpha = 0.8;
  context.fillRect(left - 3, high - 9, context.measureText(text).width + 6, 18);
  context.globalAlpha = 1;
  write(context, text, left, high, colours.text, { font: "600 12px" });
}

const gapAt = (run, row) => row.axes[run.vertical].position;

function drawForces(context, view, row, values, colours) {
  const { camera, run, bodies } = view, forces = forcesOf(run, row, values), moved = motionOf(run, row, "position");
  const newton = 1.3;   // mm for 1 N
  const at = (from, x, y, z, label) => {
    const [a, b] = [from, [from[0] + x, from[1] + y, from[2] + z]].map((point) => camera.seen(point));
    arrow(context, ...a, b[0] - a[0], b[1] - a[1], label, colours);
  };
  const middle = moved([0, bodies.magnet + BACK, 0]), front = moved([0, 0, 0]);
  at([front[0] - 12, front[1], front[2]], 0, -newton * forces.lift, 0, "lift");
  at([middle[0] + 12, middle[1], middle[2]], 0, newton * forces.weight, 0, "weight");
  const [first, second] = drivenAxes(run), push = (axis) => (axis ? newton * row.axes[axis].force : 0);
  at(front, 4 * newton * forces.thrust[first], 0, 4 * newton * (forces.thrust[second] ?? 0), "thrust ×4");
  at(middle, push(first), push(run.vertical), push(second), "push");
}

function drawSpace(context, view, run, row, ghost, values, colours) {
  const { camera, bodies } = view, moved = motionOf(run, row, "position");
  const peak = (motor) => values(`plant.${motor}.amplifier.peak`) || 5;
  const payload = payloadOf(run, values, (name) => plannedValue(run, page.state.controller, name));
  drawFloor(context, view, moved, colours);
  const platform = () => {
    if (ghost) {
      context.globalAlpha = 0.4;
      drawPlatform(context, view, ghost, { mass: 0 }, colours);
      context.globalAlpha = 1;
    }
    drawPlatform(context, view, row, payload, colours);
  };
  const stators = () => farFirst(camera, bodies.stators)
    .forEach((stator) => drawStatorBox(context, view, stator, row, peak(stator.motor), colours));
  // The air gap is between them: what is on the camera's side of it comes last.
  const above = camera.place[1] < 0;
  if (above) platform(); else stators();
  if (above) stators(); else platform();
  polygon(context, hull(platformCorners(view, row, "reference")));
  outline(context, colours.text, 1.3, DASHED);
  if (ghost) {   // which is behind what flies, as a rule
    polygon(context, hull(platformCorners(view, ghost, "position")));
    outline(context, colours.bad, 2);
  }
  drawForces(context, view, row, values, colours);
  drawGap(context, view, row, colours);
  write(context, `in space: drag the platform, or beside it to turn the view${run.rotations.length
    ? `; tilts ×${TILT}` : ""}`, 4, 0, colours.text, { base: "top" });
}
