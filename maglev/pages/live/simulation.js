"use strict";
// A run, stepped as the master of `maglev run` does: at t = k h the controller gets references and measurements and
// steps. The plant then steps under its currents (Gauss–Seidel, controller first).

const HOLD = { stiffness: 1500, damping: 60, most: 150 };   // N/m, N s/m, N: the hand that holds the mover
const SHAKE = 10 * Math.PI;   // rad/s, of the floor: 5 Hz
const KICK_TIME = 0.02;                                     // s

/** Return true if a controller is the user's own. */
const isOwn = (model) => model.startsWith("own:");

class Simulation {
  /**
   * @param {{modules: object, fmus: object}} library modules, compiled when they are first used, and descriptions, by name of the FMU
   * @param {object} run the plan
   * @param {string} model the controller
   * @param {object} settings values by `fmu.variable`, over the plan's
   * @param {number} k communication point at which it begins
   */
  constructor(library, run, model, settings, k = 0) {
    this.library = library;
    this.run = run;
    this.settings = settings;
    this.k = k;
    this.kicks = [];
    this.held = new Map();        // place (m) to which the hand pulls an axis
    this.chosen = new Map();      // reference (m, rad) of an axis instead of the plan's
    this.plant = this.made("plant", run.fmus.plant.model);
    this.forces = this.plant.ports(run.external);
    this.motion = this.plant.ports(run.axes.flatMap((axis) => [`${axis}.position`, `${axis}.velocity`]));
    this.seen = this.plant.ports(run.motors.flatMap((motor) => ["i_a", "i_b", "i_c", "i_d", "i_q"]
      .map((current) => `${motor}.${current}`)));
    this.wirePlant();
    this.measure();
    this.swap(model);
    // Targets of a run's signals other than references: forces, faults, parameters that change.
    this.events = run.signals.filter(({ to }) => !to.endsWith(".reference")).map((signal) => ({ signal, last: undefined }));
    this.pushes = run.external.map((port) => this.events.find(({ signal }) => signal.to === `plant.${port}`)?.signal);
    this.events = this.events.filter(({ signal }) => !this.pushes.includes(signal));
    this.shaken = 0;   // m/s², amplitude of the floor
    this.readOutputs();
  }

  /** Return an FMU of the run, with the start values of the plan and then the settings. A user's FMU has its own values:
   * the plan's gains and limits are those of the packaged controllers. */
  made(part, model) {
    const { modules } = this.library;
    if (modules[model] instanceof Uint8Array) modules[model] = new WebAssembly.Module(modules[model]);
    const module = modules[model], planned = this.library.fmus[model].start ?? this.run.fmus[part]?.start ?? {};
    const start = new Map(isOwn(model) ? [] : Object.entries(planned));
    for (const [name, value] of Object.entries(this.settings)) if (name.startsWith(`${part}.`)) start.set(name.slice(part.length + 1), value);
    return new (module.written ? Law : Fmu)(module, this.library.fmus[model], start, this.k * this.run.step);
  }

  /** Ports at the ends of the wires that go from one FMU to the other. */
  wirePlant() {
    const ends = (from, end) => this.run.wires.filter(([source]) => source.startsWith(`${from}.`))
      .map((wire) => wire[end].slice(wire[end].indexOf(".") + 1));
    this.measured = this.plant.ports(ends("plant", 0));
    this.commanded = this.plant.ports(ends("controller", 1));
    // The part between encoders and controller names its ports as these do.
    const last = this.run.fmus.measurement ? "measurement" : "plant";
    this.measuredNames = ends(last, 1);
    [this.encoderNames, this.betweenNames] = last === "plant" ? [ends("plant", 0), this.measuredNames]
      : [ends("plant", 1), ends(last, 0)];
    this.commandNames = ends("controller", 0);
  }

  /** Put the set errors between encoders and controller, from the present measurement on; nothing if no error is set. */
  measure() {
    const { run, settings } = this, set = Object.keys(settings).some((name) => name.startsWith("measurement."));
    this.between = run.fmus.measurement || set ? this.made("measurement", run.measurement) : null;
    if (!this.between) return;
    this.encoders = this.between.ports(this.encoderNames);
    this.given = this.between.ports(this.betweenNames);
  }

  /** Measurements as the controller gets them. */
  sensed(t) {
    if (!this.between) return this.measured.values;
    this.encoders.values.set(this.measured.values);
    this.between.put(this.encoders);
    this.between.step(t, this.run.step);
    return this.between.get(this.given);
  }

  /** Set what a run's signals drive, and the floor. */
  happen(t) {
    for (const event of this.events) {
      const value = signalValue(event.signal, t);
      if (value === event.last) continue;
      event.last = value;
      this.tune(event.signal.to, value);
    }
    if (this.shaken || this.wasShaken) {
      const name = `${this.run.vertical}.floor_acceleration`;
      if (this.plant.has(name)) this.plant.set(name, this.shaken * Math.sin(SHAKE * t));
      this.wasShaken = this.shaken;
    }
  }

  /** Replace the running controller: the new one begins at the present measurement, where nothing jumps. If it lacks a
   * port, nothing changes; only rates of the references may be missing. */
  swap(model) {
    const { axes } = this.run, fmu = this.made("controller", model);
    const rated = axes.map((_, i) => i).filter((i) => fmu.has(`${axes[i]}.reference_rate`));
    Object.assign(this, { controller: fmu, model, rated, measurements: fmu.ports(this.measuredNames),
      references: fmu.ports(axes.map((axis) => `${axis}.reference`)),
      rates: fmu.ports(rated.map((i) => `${axes[i]}.reference_rate`)), commands: fmu.ports(this.commandNames) });
    this.signals = axes.map((axis) => this.run.signals.find(({ to }) => to === `controller.${axis}.reference`));
    this.fixedReferences = fmu.get(this.references).slice();
  }

  /** A simulation from where this one is, with another controller. */
  twin(model) {
    const other = new Simulation(this.library, this.run, model, this.settings);
    other.k = this.k;
    other.plant.restore(this.plant.state());
    if (this.between && other.between) other.between.restore(this.between.state());
    other.shaken = this.shaken;
    other.swap(model);
    this.follow(other);
    other.readOutputs();
    return other;
  }

  /** Return a simulation that continues from now, at rest at its references. */
  lifted(settings) {
    const starts = this.run.axes.map((axis, i) => [`plant.${axis}.position_start`, this.reference(i, this.time)]);
    const known = Object.fromEntries(starts.filter(([name]) => this.plant.has(name.slice(6))));
    const other = new Simulation(this.library, this.run, this.model, { ...settings, ...known }, this.k);
    other.settings = settings;
    other.shaken = this.shaken;
    other.chosen = this.chosen;
    return other;
  }

  /** Let another simulation have the same hands on it. */
  follow(other) {
    other.chosen = this.chosen;
    other.held = this.held;
    other.kicks = this.kicks;
  }

  get time() { return this.k * this.run.step; }

  readOutputs() {
    this.plant.get(this.measured);
    this.plant.get(this.motion);
  }

  reference(axis, t) {
    const chosen = this.chosen.get(this.run.axes[axis]);
    if (chosen !== undefined) return chosen;
    const signal = this.signals[axis];
    return signal ? signalValue(signal, t) : this.fixedReferences[axis];
  }

  referenceRate(axis, t) {
    const signal = this.signals[axis];
    return signal?.rate_to && !this.chosen.has(this.run.axes[axis]) ? signalRate(signal, t) : 0;
  }

  /** External force (N), or torque (N m), on an axis: the hand that holds it, and kicks. */
  force(number, t) {
    const axis = this.run.axes[number], target = this.held.get(axis);
    let force = 0;
    if (target !== undefined) {
      const { values } = this.motion;
      const pull = HOLD.stiffness * (target - values[2 * number]) - HOLD.damping * values[2 * number + 1];
      force = Math.min(HOLD.most, Math.max(-HOLD.most, pull));
    }
    for (const kick of this.kicks) if (kick.axis === axis && t < kick.until && t >= kick.from) force += kick.force;
    return force;
  }

  kick(axis, impulse) {
    const kick = { axis, from: this.time, until: this.time + KICK_TIME, force: impulse / KICK_TIME };
    this.kicks.splice(0, this.kicks.length, ...this.kicks.filter(({ until }) => until > this.time), kick);
  }

  /** One communication step. */
  step() {
    const { plant, controller, run } = this, t = this.time;
    if (this.events.length || this.shaken || this.wasShaken) this.happen(t);
    for (let i = 0; i < run.axes.length; i++) {
      this.references.values[i] = this.reference(i, t);
      this.forces.values[i] = this.force(i, t) + (this.pushes[i] ? signalValue(this.pushes[i], t) : 0);
    }
    this.rated.forEach((i, k) => { this.rates.values[k] = this.referenceRate(i, t); });
    this.measurements.values.set(this.sensed(t));
    controller.put(this.references);
    controller.put(this.rates);
    controller.put(this.measurements);
    controller.step(t, run.step);
    this.commanded.values.set(controller.get(this.commands));
    plant.put(this.commanded);
    plant.put(this.forces);
    plant.step(t, run.step);
    this.readOutputs();
    this.k++;
  }

  /** Do an action at a time: set parameters, choose a reference, or release it. */
  act({ type, values, axis, value }) {
    if (type === "tune") for (const [name, each] of Object.entries(values)) { this.settings[name] = each; this.tune(name, each); }
    else if (value === null) this.chosen.delete(axis);
    else this.chosen.set(axis, value);
  }

  /** Set a parameter that can change while it runs, where there is one of that name. */
  tune(name, value) {
    const part = name.slice(0, name.indexOf(".")), variable = name.slice(name.indexOf(".") + 1);
    if (part === "measurement" && (!this.between || this.between.byName.get(variable)?.fixed)) { this.measure(); return; }
    const fmu = { plant: this.plant, measurement: this.between }[part] ?? this.controller;
    if (fmu.has(variable)) fmu.set(variable, value);
  }

  /** Return the values to draw and plot: the time, for each axis position, reference, force; for each motor its
   * currents. */
  row() {
    const t = this.time;
    return new Float32Array([t, ...this.run.axes.flatMap((_, i) => [this.motion.values[2 * i], this.reference(i, t), this.forces.values[i]]),
      ...this.plant.get(this.seen)]);
  }

  flags() {
    const { plant, controller, run } = this, said = (name) => controller.has(name) && controller.flag(name);
    return { stop: plant.flag("at_stop"), tripped: said("tripped"), limited: said("saturated"),
      infeasible: controller.has("feasible") && !controller.flag("feasible"), clamped: run.motors.some((motor) => plant.flag(`${motor}.saturated`)) };
  }
}

/** Numbers in a row of `Simulation.row`. */
const rowWidth = (run) => 1 + 3 * run.axes.length + 5 * run.motors.length;
