"use strict";
// The runs, in a thread of their own: drawing never delays them, and a long step never delays the drawing.

const ROW_INTERVAL = 2e-3;   // s of the run between two rows for the plots
const TICK = 4;              // ms between two looks at the clock
const MOST_BUSY = 24;        // ms of stepping before messages are heard
const FRAME = 15;            // ms between two messages with rows, at least

const library = { modules: {}, fmus: {} };   // modules are bytes until they are used, laws classes
let parts = "";   // of controllers, in JavaScript
let runs = {};
let simulation = null, ghost = null;
let playing = false, speed = 1;
let acts = [];                       // messages that wait for their time of the run (s), the first ones first
let asked = 0, clock = 0;            // s of the run that are due, ms of the clock when that was so
let rows = [], ghostRows = [];
let lastFrame = 0, waiting = false;  // whether the page has not drawn the last frame yet
let pace = { since: 0, from: 0, value: 0 };

const seen = (name) => library.fmus[name] !== undefined;

async function load({ about, plans, binaries, law, laws }) {
  Object.assign(library, { fmus: about, modules: binaries });
  parts = law;
  for (const [name, text] of Object.entries(laws)) library.modules[name] = { written: await lawClass(text, parts), lines: text.split("\n").length };
  runs = plans;
  postMessage({ type: "loaded" });
}

function start({ run, controller, other, settings, planned = [] }) {
  acts = [...planned];
  simulation = null;
  ghost = null;
  rows = [];
  ghostRows = [];
  const next = new Simulation(library, runs[run], controller, settings);
  if (seen(other)) {
    ghost = new Simulation(library, runs[run], other, settings);
    next.follow(ghost);
  }
  simulation = next;
  resume();
  record();
  postMessage({ type: "started", width: rowWidth(simulation.run) });
  send(true);
}

/** Take in the user's controller, and try it on a run: a law's text, or a module with its description. */
async function own({ model, name, run, text, bytes, about }) {
  const taken = { ...library, modules: { ...library.modules }, fmus: { ...library.fmus } };
  if (text === undefined) {
    taken.modules[model] = bytes;
    taken.fmus[model] = about;
  } else {
    const lines = text.split("\n").length;
    try {
      taken.modules[model] = { written: await lawClass(text, parts), lines };
    } catch (error) {
      throw new Error(`${name}: ${lawTrouble(error, lines)}`);
    }
    taken.fmus[model] = lawAbout(taken.modules[model], name);
  }
  new Simulation(taken, runs[run], model, {}).step();
  Object.assign(library, taken);
  postMessage({ type: "owned", model, about: library.fmus[model] });
}

function resume() {
  asked = simulation ? simulation.time : 0;
  clock = performance.now();
  pace = { since: clock, from: asked, value: 0 };
}

function record() {
  rows.push(simulation.row());
  if (ghost) ghostRows.push(ghost.row());
}

/** Step until the clock is met, or the time is up that stepping may take. */
function advance() {
  setTimeout(advance, TICK);
  const begin = performance.now();
  if (!playing || !simulation) { clock = begin; send(false); return; }
  asked += speed * Math.min(0.1, (begin - clock) / 1e3);
  clock = begin;
  const every = Math.max(1, Math.round(ROW_INTERVAL / simulation.run.step));
  try {
    while (simulation.time + simulation.run.step <= asked) {
      while (acts.length && simulation.time >= acts[0].at - TIME_TOLERANCE) {
        const act = acts.shift();
        HANDLERS[act.type](act);
      }
      simulation.step();
      try {
        ghost?.step();
      } catch (error) {
        ghost = null;
        postMessage({ type: "ghost refused", text: error.message });
      }
      if (simulation.k % every === 0) {
        record();
        if (performance.now() - begin > MOST_BUSY) { asked = simulation.time; break; }
      }
    }
  } catch (error) {
    playing = false;
    postMessage({ type: "refused", text: error.message });
  }
  if (begin - pace.since > 500) {
    pace = { since: begin, from: simulation.time, value: 1e3 * (simulation.time - pace.from) / (begin - pace.since) };
  }
  send(false);
}

function joined(list) {
  const all = new Float32Array(list.length * (list[0]?.length ?? 0));
  list.forEach((row, i) => all.set(row, i * row.length));
  return all;
}

function send(now) {
  if (!simulation || !rows.length || (!now && (waiting || performance.now() - lastFrame < FRAME))) return;
  const frame = { type: "frame", rows: joined(rows), ghostRows: joined(ghostRows), flags: simulation.flags(),
    ghostFlags: ghost?.flags() ?? null, pace: playing ? pace.value : 0, time: simulation.time };
  rows = [];
  ghostRows = [];
  lastFrame = performance.now();
  waiting = true;
  postMessage(frame, [frame.rows.buffer, frame.ghostRows.buffer]);
}

const WITHIN = 1e-4;   // m, in which a task counts as done

/** Score a controller in a task, in a simulation of its own. After the load and after the step it has the largest error
 * of the gap, the time after which it stays within WITHIN, and the overshoot. Then comes the ripple of a current at
 * rest; SI. Of a mover that is lost, the score is when. */
async function scored({ number, run, model, settings, acts: planned, task: { axis, on, step, until } }) {
  const tried = new Simulation(library, runs[run], model, settings), { axes, vertical } = tried.run, due = [...planned];
  const [gap, moved] = [vertical, axis].map((name) => axes.indexOf(name));
  const place = (i) => tried.motion.values[2 * i], error = (i) => Math.abs(place(i) - tried.reference(i, tried.time));
  const values = [0, 0, 0, 0, 0, 0], ripple = { sum: 0, squares: 0, count: 0 };
  let lost = null, since = performance.now();
  while (tried.time < until && lost === null) {
    if (performance.now() - since > MOST_BUSY) {   // meanwhile the shown run continues
      await new Promise((resolve) => { setTimeout(resolve); });
      since = performance.now();
    }
    while (due.length && tried.time >= due[0].at - TIME_TOLERANCE) tried.act(due.shift());
    try {
      tried.step();
    } catch {   // the shown run reports its error
      lost = tried.time;
      break;
    }
    const { time } = tried;
    if (time > on / 2 && time <= on) {
      const current = tried.plant.get(tried.seen)[3];   // the direct one of the first motor
      ripple.sum += current;
      ripple.squares += current ** 2;
      ripple.count++;
    }
    if (tried.plant.flag("at_stop")) lost = time;
    if (time > on && time <= step) {
      values[0] = Math.max(values[0], error(gap));
      if (error(gap) > WITHIN) values[1] = time - on;
    } else if (time > step) {
      if (error(moved) > WITHIN) values[2] = time - step;
      values[3] = Math.max(values[3], place(moved) - tried.reference(moved, time));
      values[4] = Math.max(values[4], error(gap));
    }
  }
  values[5] = Math.sqrt(Math.max(0, ripple.squares / ripple.count - (ripple.sum / ripple.count) ** 2));
  postMessage({ type: "scored", number, values: lost === null ? values : [], lost: lost ?? 0 });
}

const HANDLERS = {
  load,
  start,
  scored,
  own,
  alive: () => postMessage({ type: "alive" }),
  play: (message) => { playing = message.on; if (simulation) resume(); },
  speed: (message) => { speed = message.value; if (simulation) resume(); },
  drawn: () => { waiting = false; },
  tune: (act) => { simulation.act(act); ghost?.act(act); },
  swap: ({ controller }) => simulation.swap(controller),
  lift: ({ settings }) => {
    const others = ghost;
    simulation = simulation.lifted(settings);
    ghost = others?.lifted(settings) ?? null;
    if (ghost) simulation.follow(ghost);
  },
  ghost: ({ other }) => {
    ghost = seen(other) ? simulation.twin(other) : null;
    ghostRows = [];
    rows = [];
    record();
  },
  reference: (act) => simulation.act(act),
  hold: ({ axis, value }) => { if (value === null) simulation.held.delete(axis); else simulation.held.set(axis, value); },
  shake: ({ value }) => { simulation.shaken = value; if (ghost) ghost.shaken = value; },
  /** Set values for a time (s). */
  blink: ({ values, back, time }) => {
    HANDLERS.tune({ type: "tune", values });
    acts.push({ at: simulation.time + time, type: "tune", values: back });
    acts.sort((one, other) => one.at - other.at);
  },
  kick: ({ axis, impulse }) => simulation.kick(axis, impulse),
};

onmessage = async ({ data }) => {
  try {
    await HANDLERS[data.type](data);
  } catch (error) {
    const type = { start: "refused", load: "refused", own: "own refused" }[data.type] ?? "not done";
    postMessage({ type, text: error.message });
  }
};
advance();
