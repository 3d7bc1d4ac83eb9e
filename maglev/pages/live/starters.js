"use strict";
// Starters: the controller of `maglev new controller` for the running stage, and variations of its law for an axis.

/** Text of a method for the demanded acceleration, computed from error and rate. */
const demanded = (what, made) => `  /** Acceleration (m/s²) ${what} */
  demand(observer, dt) {
    this.velocity.update(this.measured, observer, dt);
    let error = this.measured - this.reference;
    let rate = this.velocity.velocity - this.reference_rate;
    ${made}
  }
`;

/** Starters. Each lacks something, so that the thesis's regulator does better. A law has its own parameters with their
 * units and their values in terms of the design poles (rad/s) of an axis, and its own demanded acceleration. */
const STARTERS = {
  pid: { label: "PID", name: "PID", parameters: { kp: "1/s²", ki: "1/s³", kd: "1/s" },
    from: (w) => [w ** 2, 0.03 * w ** 3, 1.2 * w],
    demand: demanded("against the error, its integral and its rate.",
      "return -this.kp * error - this.ki * this.integral - this.kd * rate;") },
  feedback: { label: "state feedback", name: "state feedback", parameters: { stiffness: "1/s²", damping: "1/s" }, from: (w) => [1.5 * w ** 2, 1.8 * w],
    demand: demanded("against the error and its rate; nothing finds the current that carries a load.",
      "return -this.stiffness * error - this.damping * rate;") },
  sliding: { label: "sliding mode", name: "sliding mode", parameters: { slope: "1/s", reach: "m/s²", layer: "m/s" },
    from: (w) => [0.7 * w, 0.03 * w, 0.1],
    demand: demanded("that keeps the error on a surface, along which it fades, and goes there from wherever it is.",
      `let surface = rate + 2.0 * this.slope * error + this.slope * this.slope * this.integral;
    return -2.0 * this.slope * rate - this.slope * this.slope * error - this.reach * Math.tanh(surface / this.layer);`) },
};

/** Active disturbance rejection (Han 2009, Gao 2003): an observer with three poles finds what pushes an axis, the law takes it back. */
const ADRC = { name: "ADRC", parameters: { bandwidth: "rad/s", observed: "rad/s" }, from: (w) => [2 * w, 8 * w],
  demand: demanded("that takes back the push which the observer finds, and places two poles.", `if (this.seen === undefined) Object.assign(this, { seen: this.measured, speed: 0, push: 0 });
    let pole = Math.exp(-this.observed * dt), faster = 1 - pole, off = this.measured - this.seen;
    this.seen += (1 - pole ** 3) * off;
    this.speed += 1.5 * faster ** 2 * (1 + pole) / dt * off;
    this.push += faster ** 3 / dt ** 2 * off;
    let demand = -this.bandwidth * (this.bandwidth * (this.seen - this.reference) + 2 * (this.speed - this.reference_rate)) - this.push;
    this.seen += dt * (this.speed + dt / 2 * (demand + this.push));
    this.speed += dt * (demand + this.push);
    return demand;`) };

/** Return true if an axis is held against the magnets' pull, as the gap and tilts are, and does not move along it. */
const isHeld = (run, axis) => axis === run.vertical || isTilt(run, axis);

/** Text of a starter for a stage; `factors` are on its parameters, by name and whether of an axis that is held. */
function starterText(run, { name, parameters, from, demand }, factors = {}) {
  const names = Object.keys(parameters);
  const number = (value) => { const text = String(Number(value.toPrecision(3))); return text.includes(".") ? text : `${text}.0`; };
  return run.stage.law.replace(/(\w+) = new Axis\(([^,]+), ([^)]+)\)/g, (_, axis, place, poles) => `${axis} = new Axis(${place}, ${
    from(Number(poles)).map((value, i) => number(value * (factors[`${names[i]} ${isHeld(run, axis)}`] ?? 1))).join(", ")})`)
    .replace("constructor(position, bandwidth)", `constructor(position, ${names.join(", ")})`)
    .replace(/    this\.bandwidth = .*\n/, names.map((each) => `    this.${each} = ${each}; // ${parameters[each]}, parameter\n`).join(""))
    .replace(/  \/\*\* Acceleration \(m\/s²\) by which[\s\S]*?\n  }\n/, () => demand)
    .replace(/static parameters = \{[\s\S]*?\};/, `static parameters = {${run.axes.map((axis) => names.map((each) =>
      `"${axis}.${each}": "${parameters[each]}"`).join(", ")).join(",\n      ")}, "limit": "A"};`)
    .replaceAll("state feedback with an integral", name).replaceAll("State feedback with an integral", name[0].toUpperCase() + name.slice(1));
}
