"use strict";
// Forces on the mover, computed by the page from currents and gap: for the picture and its text.

/** Air gap (m) of a motor, at its place where the mover tilts. */
const gapOf = (run, row, motor, values) => Object.values(run.stage.tilts).reduce((gap, { axis, sign, place }) =>
  gap + sign * values(`plant.${motor}.${place}`) * row.axes[axis].position, row.axes[run.vertical].position);

/** Forces (N) on the mover, from currents and gaps by (4.3), (5.3): for the picture only. */
function forcesOf(run, row, values) {
  const { stage, vertical } = run, constant = (name) => values(`plant.${name}`);
  const [attraction, coils, iron] = stage.vertical.map(constant);
  const thrust = Object.fromEntries(drivenAxes(run).map((axis) => [axis, 0]));
  let lift = 0;
  for (const motor of run.motors) {
    const { d, q } = row.motors[motor], axis = run.drives[motor];
    const [f1, f2, f3, f4] = gapFunctions(stage.unlike[motor] ?? stage.gap, gapOf(run, row, motor, values));
    lift += stage.sharing * stage.mass[vertical] * (attraction * f2 - coils * f3 * d + iron * f4 * (d * d + q * q));
    thrust[axis] -= stage.sharing * stage.mass[axis] * constant(stage.thrust[axis]) * f1 * q;
  }
  return { lift, thrust, weight: (values(`plant.${vertical}.mass`) + (values("plant.payload.mass") ?? 0)) * live.gravity };
}

/** A row with another air gap (m), and no tilt. */
const atGap = (run, row, gap) => ({ ...row, axes: Object.fromEntries(Object.entries(row.axes).map(([axis, of]) =>
  [axis, { ...of, position: axis === run.vertical ? gap : isTilt(run, axis) ? 0 : of.position }])) });

/** Direct current (A) with which the motors carry the mover from where it is; undefined where none does. */
function carryingCurrent(run, row, values) {
  const beyond = (d) => {
    const motors = Object.fromEntries(run.motors.map((motor) => [motor, { ...row.motors[motor], d, q: 0 }]));
    const { lift, weight } = forcesOf(run, { ...row, motors }, values);
    return lift - weight;
  };
  // A parabola through three of its points.
  const [left, none, right] = [-1, 0, 1].map(beyond), [b, a] = [(right - left) / 2, (right + left) / 2 - none];
  const root = Math.sqrt(b * b - 4 * a * none);
  return [2 * none / (-b + root), 2 * none / (-b - root)].filter(Number.isFinite).sort((p, q) => Math.abs(p) - Math.abs(q))[0];
}

/** Shape functions of the forces at an air gap (m), interpolated in the table that comes with the page. */
function gapFunctions({ first, step, values }, gap) {
  const at = Math.min(values.length - 1.001, Math.max(0, (gap - first) / step)), k = Math.floor(at);
  return values[k].map((low, i) => low + (at - k) * (values[k + 1][i] - low));
}
