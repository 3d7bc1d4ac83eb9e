"use strict";
// An FMU from its WebAssembly module: FMI's functions, with variables by name.

const FMI_OK = 0, CO_SIMULATION = 1;

/** An FMU with start values, ready to step. */
class Fmu {
  /**
   * @param {WebAssembly.Module} module
   * @param {{name: string, guid: string, variables: object[]}} about its model description
   * @param {Map<string, number|boolean>} start values by name; those that it does not have are left out
   * @param {number} time where it begins, s
   */
  constructor(module, about, start, time) {
    this.about = about;
    this.all = [];   // places of variables that are set or got together
    this.byName = new Map(about.variables.map((variable) => [variable.name, variable]));
    this.c = new WebAssembly.Instance(module, {}).exports;
    this.c._initialize();
    this.scratch = this.c.malloc(16);
    this.instance = this.c.fmi2Instantiate(this.text(about.name), CO_SIMULATION, this.text(about.guid), 0,
      this.c.maglevCallbacks(), 0, 1);
    if (!this.instance) throw new Error(`${about.name}: ${this.message()}`);
    this.check(this.c.fmi2SetupExperiment(this.instance, 0, 0, time, 0, 0));
    for (const [name, value] of start) if (this.has(name)) this.set(name, value);
    this.check(this.c.fmi2EnterInitializationMode(this.instance));
    this.check(this.c.fmi2ExitInitializationMode(this.instance));
  }

  has(name) { return this.byName.has(name); }

  /** Memory as arrays, until it grows. */
  doubles(address, count) { return new Float64Array(this.c.memory.buffer, address, count); }

  words(address, count = 1) { return new Uint32Array(this.c.memory.buffer, address, count); }

  text(text) {
    const bytes = new TextEncoder().encode(`${text}\0`);
    const address = this.c.malloc(bytes.length);
    new Uint8Array(this.c.memory.buffer).set(bytes, address);
    return address;
  }

  /** Return the last message of the FMU. */
  message() {
    const bytes = new Uint8Array(this.c.memory.buffer, this.c.maglevMessage());
    return new TextDecoder().decode(bytes.slice(0, bytes.indexOf(0)));
  }

  check(status) { if (status !== FMI_OK) throw new Error(`${this.about.name}: ${this.message()}`); }

  /** Places for Real variables that are set or got together; `values` is where their numbers are. */
  ports(names) {
    const missing = names.find((name) => !this.has(name));
    if (missing !== undefined) throw new Error(`${this.about.name}: missing port: ${missing}`);
    const references = this.c.malloc(4 * Math.max(1, names.length));
    const address = this.c.malloc(8 * Math.max(1, names.length));
    this.words(references, names.length).set(names.map((name) => this.byName.get(name).reference));
    const ports = { names, references, address, values: null };
    this.all.push(ports);
    this.look();
    return ports;
  }

  /** Rebuild the arrays of the ports: the old ones are void once the memory has grown. */
  look() { for (const ports of this.all) ports.values = this.doubles(ports.address, ports.names.length); }

  get(ports) {
    this.check(this.c.fmi2GetReal(this.instance, ports.references, ports.names.length, ports.address));
    return ports.values;
  }

  put(ports) {
    this.check(this.c.fmi2SetReal(this.instance, ports.references, ports.names.length, ports.address));
  }

  reference(name) {
    this.words(this.scratch)[0] = this.byName.get(name).reference;
    return this.scratch;
  }

  /** Set an input or parameter. */
  set(name, value) {
    const reference = this.reference(name), place = this.scratch + 8;
    if (this.byName.get(name).boolean) {
      this.words(place)[0] = value ? 1 : 0;
      this.check(this.c.fmi2SetBoolean(this.instance, reference, 1, place));
    } else {
      this.doubles(place, 1)[0] = value;
      this.check(this.c.fmi2SetReal(this.instance, reference, 1, place));
    }
  }

  flag(name) {
    this.check(this.c.fmi2GetBoolean(this.instance, this.reference(name), 1, this.scratch + 8));
    return this.words(this.scratch + 8)[0] !== 0;
  }

  step(time, size) { this.check(this.c.fmi2DoStep(this.instance, time, size, 1)); }

  /** The whole state, for another instance of the same FMU. */
  state() {
    const { c, instance, scratch } = this;
    this.words(scratch)[0] = 0;
    this.check(c.fmi2GetFMUstate(instance, scratch));
    this.check(c.fmi2SerializedFMUstateSize(instance, this.words(scratch)[0], scratch + 4));
    const [size] = this.words(scratch + 4), bytes = c.malloc(size);
    this.check(c.fmi2SerializeFMUstate(instance, this.words(scratch)[0], bytes, size));
    const copy = new Uint8Array(c.memory.buffer, bytes, size).slice();
    c.free(bytes);
    this.check(c.fmi2FreeFMUstate(instance, scratch));
    this.look();
    return copy;
  }

  restore(state) {
    const { c, instance, scratch } = this, bytes = c.malloc(state.length);
    new Uint8Array(c.memory.buffer).set(state, bytes);
    this.words(scratch)[0] = 0;
    this.check(c.fmi2DeSerializeFMUstate(instance, bytes, state.length, scratch));
    this.check(c.fmi2SetFMUstate(instance, this.words(scratch)[0]));
    this.check(c.fmi2FreeFMUstate(instance, scratch));
    c.free(bytes);
    this.look();
  }
}
