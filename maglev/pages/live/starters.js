"use strict";
// Laws to begin with: the controller of `maglev new controller` for the stage that runs, and variations of what it does on an axis.

/** Text of the acceleration that a law asks for, with what it makes of error and rate. */
const demanded = (what, made) => `  /** Acceleration (m/s²) ${what} */
  demand(observer, dt) {
    this.velocity.update(this.measured, observer, dt);
    let error = this.measured - this.reference;
    let rate = this.velocity.velocity - this.reference_rate;
    ${made}
  }
`;

/** A law by what is different of it: its parameters with their units, what they are of the poles (rad/s) that the design of an axis
 * has, and the acceleration that it asks for. */
const STARTERS = {
  pid: { label: "PID", name: "PID", parameters: { kp: "1/s²", ki: "1/s³", kd: "1/s" },
    from: (w) => [w ** 2, 0.22 * w ** 3, 1.7 * w],
    demand: demanded("against the error, its integral and its rate.",
      "return -this.kp * error - this.ki * this.integral - this.kd * rate;") },
  feedback: { label: "state feedback", name: "state feedback with an integral", parameters: { bandwidth: "rad/s" }, from: (w) => [w] },
  sliding: { label: "sliding mode", name: "sliding mode", parameters: { slope: "1/s", reach: "m/s²", layer: "m/s" },
    from: (w) => [0.6 * w, 0.1 * w, 0.1],
    demand: demanded("that keeps the error on a surface, along which it fades, and goes there from wherever it is.",
      `let surface = rate + 2.0 * this.slope * error + this.slope * this.slope * this.integral;
    return -2.0 * this.slope * rate - this.slope * this.slope * error - this.reach * Math.tanh(surface / this.layer);`) },
};

/** Whether an axis is held against the magnets' pull, the gap and tilts, or moves along it. */
const isHeld = (run, axis) => axis === run.vertical || isTilt(run, axis);

/** Text of a starter for a stage; `factors` are on its parameters, by name and whether of an axis that is held. */
function starterText(run, id, factors = {}) {
  const { name, parameters, from, demand } = STARTERS[id], names = Object.keys(parameters);
  const number = (value) => { const text = String(Number(value.toPrecision(3))); return text.includes(".") ? text : `${text}.0`; };
  let text = run.stage.law.replace(/(\w+) = new Axis\(([^,]+), ([^)]+)\)/g, (_, axis, place, poles) => `${axis} = new Axis(${place}, ${
    from(Number(poles)).map((value, i) => number(value * (factors[`${names[i]} ${isHeld(run, axis)}`] ?? 1))).join(", ")})`);
  if (demand) {
    text = text.replace("constructor(position, bandwidth)", `constructor(position, ${names.join(", ")})`)
      .replace(/    this\.bandwidth = .*\n/, names.map((each) => `    this.${each} = ${each}; // ${parameters[each]}, parameter\n`).join(""))
      .replace(/  \/\*\* Acceleration \(m\/s²\) by which[\s\S]*?\n  }\n/, () => demand)
      .replace(/static parameters = \{[\s\S]*?\};/, `static parameters = {${run.axes.map((axis) => names.map((each) =>
        `"${axis}.${each}": "${parameters[each]}"`).join(", ")).join(",\n      ")}, "limit": "A"};`)
      .replaceAll("state feedback with an integral", name).replaceAll("State feedback with an integral", name[0].toUpperCase() + name.slice(1));
  }
  return text;
}
