"use strict";
// A controller in JavaScript in the place of an FMU: a class with tables of ports, parameters, a sample time, start and step.

const STEP_TOLERANCE = 1e-6;   // of a sample, by which steps may miss it

// Globals that a law must not use, which it finds empty: the page's policy keeps it from the network.
const HIDDEN = ["fetch", "XMLHttpRequest", "WebSocket", "EventSource", "Worker", "importScripts", "postMessage", "self", "globalThis"];

/** Class of a text: the only one in it that has ports. It is code of who wrote it, and all that it can reach is this thread. */
async function lawClass(text, parts) {
  const names = [...text.matchAll(/^\s*class\s+([A-Za-z_$][\w$]*)/gm)].map(([, name]) => name);
  // The text comes first, so that its lines have their numbers; the parts come after it, so that it can reuse their
  // names.
  const script = `self.lawClasses = ((${HIDDEN.join(", ")}) => { "use strict"; const own = () => { ${text}
return [${names.join(", ")}]; };
${parts}
return own(); })();`;
  const address = URL.createObjectURL(new Blob([script], { type: "text/javascript" }));
  self.lawClasses = [];
  try {
    importScripts(address);
  } catch (error) {
    if (error instanceof SyntaxError) throw await misspelt(address, error);
    throw error;
  } finally {
    URL.revokeObjectURL(address);
  }
  const found = self.lawClasses.filter((each) => each.inputs || each.outputs);
  if (found.length !== 1) throw new Error(`there are ${found.length} classes with ports in it, expected one`);
  return found[0];
}

/** Error of an unreadable script, with its line: the thread that tries it gets this. */
function misspelt(address, { message }) {
  return new Promise((resolve) => {
    const trial = new Worker(address), what = message.replace(/^.*WorkerGlobalScope': /, "");
    const found = (lineno) => {
      trial.terminate();
      resolve(Object.assign(new SyntaxError(what), { lineno }));
    };
    trial.onerror = (event) => { event.preventDefault(); found(event.lineno); };
    setTimeout(found, 1000);
  });
}

/** Return the error of a law in one line, with the line of the text. */
function lawTrouble(error, lines) {
  const place = /blob:[^\s)]*?:(\d+):\d+/.exec(String(error.stack)), line = error.lineno ?? Number(place?.[1]);
  return `${line >= 1 && line <= lines ? `line ${line}: ` : ""}${error.name === "Error" ? "" : `${error.name}: `}${error.message}`;
}

class Law {
  /**
   * @param {{written: Function, lines: number}} source class and length of its text
   * @param {{name: string}} about
   * @param {Map<string, number|boolean>} start values by name; those that it does not have are left out
   * @param {number} time where it begins, s
   */
  constructor({ written, lines }, about, start, time) {
    this.lines = lines;
    this.time = time;
    this.about = about;
    this.law = this.tried(() => new written());
    this.steps = -1;   // steps since the last sample; none yet
    for (const [name, value] of start) if (this.has(name)) this.set(name, value);
    if (this.law.start) this.tried(() => this.law.start());
  }

  tried(act) {
    try {
      return act();
    } catch (error) {
      throw new Error(`${this.about.name}: ${lawTrouble(error, this.lines)}`);
    }
  }

  /** Owner and attribute of "y.measured": this.y.measured, or this.y_measured. */
  place(name) { return lawPlace(this.law, name); }

  has(name) { return this.place(name) !== undefined; }

  ports(names) {
    const places = names.map((name) => {
      const place = this.place(name);
      if (!place) throw new Error(`${this.about.name}: missing port: ${name}`);
      return place;
    });
    return { names, places, values: new Float64Array(names.length) };
  }

  get(ports) {
    ports.places.forEach(([owner, key], i) => {
      const value = owner[key];
      if (typeof value !== "number" || !Number.isFinite(value)) {
        throw new Error(`${this.about.name}: ${ports.names[i]} = ${value} at t = ${Number(this.time.toFixed(6))} s, expected a finite number`);
      }
      ports.values[i] = value;
    });
    return ports.values;
  }

  put(ports) { ports.places.forEach(([owner, key], i) => { owner[key] = ports.values[i]; }); }

  set(name, value) {
    const [owner, key] = this.place(name);
    owner[key] = value;
  }

  flag(name) {
    const [owner, key] = this.place(name);
    return Boolean(owner[key]);
  }

  step(time, size) {
    const every = this.law.sample_time / size, steps = Math.round(every);
    if (!(steps >= 1) || Math.abs(every - steps) > STEP_TOLERANCE * steps) {
      throw new Error(`${this.about.name}: communication step = ${size} s, expected one that divides its sample_time = ${
        this.law.sample_time} s`);
    }
    this.time = time;
    this.steps = (this.steps + 1) % steps;
    if (this.steps === 0) this.tried(() => this.law.step(time));
  }
}

function lawPlace(law, name) {
  const parts = name.split("."), key = parts.pop();
  let owner = law;
  for (const part of parts) owner = typeof owner === "object" && owner ? owner[part] : undefined;
  if (typeof owner === "object" && owner && key in owner) return [owner, key];
  const flat = name.replaceAll(".", "_");
  return flat in law ? [law, flat] : undefined;
}

/** Describe a law as a model description does; throws what it lacks. */
function lawAbout(source, name) {
  const { written } = source, law = new Law(source, { name }, new Map(), 0), tables = ["inputs", "outputs", "parameters"];
  if (typeof law.law.step !== "function") throw new Error(`${name}: expected a method step(t)`);
  const variables = tables.flatMap((table) => Object.entries(written[table] ?? {}).map(([variable, unit]) => {
    const place = law.place(variable);
    if (!place) throw new Error(`${name}: ${table} has "${variable}", expected an attribute this.${variable}${
      variable.includes(".") ? ` or this.${variable.replaceAll(".", "_")}` : ""}`);
    const start = place[0][place[1]];
    return { name: variable, causality: { inputs: "input", outputs: "output", parameters: "parameter" }[table],
      boolean: typeof start === "boolean", start, fixed: table === "parameters" && Boolean(law.law.start), unit,
      description: "", min: -1e12, max: 1e12 };
  }));
  return { name, variables };
}
