"use strict";
// The page: a worker that flies, a picture and plots of what it sends, and hands that reach into the flight.

let worker = null;
const at = (id) => document.getElementById(id);
const post = (message) => worker.postMessage(message);
// The orbit is from where the picture in space is seen, in degrees.
const page = { state: null, run: null, history: null, ghost: null, width: 0, playing: false, frame: null, views: [],
  dirty: true, colours: {}, strips: null, drag: null, turning: null, dragged: false, orbit: { yaw: -30, pitch: 20 }, story: null, fell: null, lit: {}, frames: 0, problems: [], waiting: [], flown: {} };
window.maglevLive = page;

const say = (text, bad = false) => {
  at("status").textContent = text;
  at("status").classList.toggle("bad", bad);
};

const known = new Map();

/** Present value of a parameter `fmu.variable`: set, planned or the FMU's. */
const valueOf = (full) => {
  const set = page.state.settings[full];
  if (set !== undefined && variableOf(page.run, page.state.controller, full)) return set;
  if (!known.has(full)) known.set(full, plannedValue(page.run, page.state.controller, full));
  return known.get(full);
};

/** What stands in the address, and all that shows the settings. */
function stateChanged() {
  known.clear();
  page.strips = new Strips(stripsOf(page.run, valueOf), windowFor(page.state.speed));
  const fragment = fragmentOf(page.state);
  if (location.hash !== fragment) history.replaceState(null, "", fragment);
  showPanel();
  page.dirty = true;
}

/** Begin a run from its start; `planned` is what the worker does in it of its own accord, an experiment. */
function begin(state, planned = []) {
  page.state = state;
  page.run = live.runs[state.run];
  page.story = null;
  page.ended = false;
  page.lit = {};
  page.panel.shake(0);
  if (!planned.length) state.story = "";
  page.history = page.ghost = null;
  post({ type: "start", run: state.run, controller: state.controller, other: state.ghost, settings: { ...state.settings },
    planned });
  post({ type: "speed", value: state.speed });
  at("released").hidden = true;
  at("moment").textContent = "";
  // What moves along one axis alone is not seen from above.
  if (state.view === "above" && drivenAxes(page.run).length < 2) state.view = "space";
  stateChanged();
  layout();
  showStory();
}

const SEEN = { space: "in space; a, d, w, s turn the view", sides: "from the sides", above: "from above" };

/** From the start again, an experiment with all that is done in it. */
function restart() {
  if (page.state.story) { tellStory(page.state.story); return; }
  begin(page.state);
  say("Started anew.");
}

/** From the start again, without what has brought it down. */
function liftOff() {
  begin({ ...page.state, settings: page.state.story ? {} : page.state.settings });
  play(true);
  say("");
}

/** The run as its file plans it: also its controller. */
function asPlanned() {
  begin({ ...page.state, settings: {}, controller: page.run.fmus.controller.model });
  play(true);
  say("As planned again.");
}

/** Change parameters: in flight where they can, with a new start where not. */
function change(settings) {
  const { state, run } = page;
  const fixed = Object.keys(settings).some((full) => variableOf(run, state.controller, full)?.fixed
    && !full.startsWith("measurement."));
  for (const [full, value] of Object.entries(settings)) {
    if (value === plannedValue(run, state.controller, full)) delete state.settings[full];
    else state.settings[full] = value;
  }
  if (fixed) restart();
  else post({ type: "tune", values: settings });
  stateChanged();
}

function swap(controller) {
  page.state.controller = controller;
  post({ type: "swap", controller });
  stateChanged();
  say(`${lawOf(page.run, controller)} controller flies, from where the stage is.`);
}

function setGhost(other) {
  page.state.ghost = other;
  page.ghost = other ? new FlightHistory(page.run, page.width) : null;
  post({ type: "ghost", other });
  stateChanged();
  say(other ? `A transparent stage flies along with the ${lawOf(page.run, other)} controller.` : "No stage flies along.");
}

function play(on) {
  page.playing = on;
  at("play").textContent = on ? "Pause" : "Play";
  post({ type: "play", on });
}

/** Begin what an address asks for. */
function openState(state) {
  const { story } = state;
  begin(state);
  if (story) tellStory(story);
}

const vertical = () => page.run.vertical;

/** Keep a place (m, rad) of an axis between its ends. */
function within(axis, value) {
  const margin = 0.5e-3, [lower, upper] = endsOf(page.run, axis, valueOf);
  return Math.min(upper - margin, Math.max(lower + margin, value));
}

function refer(axis, value) {
  post({ type: "reference", axis, value: value === null ? null : within(axis, value) });
  at("released").hidden = false;
}

function release() {
  for (const axis of page.run.axes) refer(axis, null);
  at("released").hidden = true;
  say("The references follow the run again.");
}

const impulseText = (axis, impulse) => `${impulse} ${isTilt(page.run, axis) ? "N m s" : "N s"}`.replace("-", "−");

function kick(axis, impulse) {
  post({ type: "kick", axis, impulse });
  say(`A kick of ${impulseText(axis, impulse)} ${isTilt(page.run, axis) ? "in" : "along"} ${axis}.`);
}

function started({ width }) {
  page.width = width;
  page.history = new FlightHistory(page.run, width);
  page.ghost = page.state.ghost ? new FlightHistory(page.run, width) : null;
}

const EVENTS = { stop: "an end stop is touched", tripped: "the controller has tripped",
  infeasible: "no current makes what is demanded", clamped: "an amplifier is at its peak", limited: "a command is at its limit" };

const LIT = 400;   // ms
const GHOST_DOWN = "The stage that flies along touches an end stop.";

/** What a stop that is touched means: why the mover does not leave it, in currents. */
function touched(time) {
  const { run } = page, row = page.history.last(), ends = endsOf(run, vertical(), valueOf);
  // A platform that tilts meets its stops at one motor first.
  const end = ends.findIndex((each) => run.motors.some((motor) => Math.abs(each - gapOf(run, row, motor, valueOf)) < 0.5e-3));
  const needed = Math.abs(carryingCurrent(run, end < 0 ? row : atGap(run, row, ends[end]), valueOf));
  const most = Math.min(valueOf("controller.current_limit") || Infinity, valueOf(`plant.${run.motors[0]}.amplifier.peak`));
  if (end < 0 || !(needed > most)) return `At ${time.toFixed(2)} s an end stop is touched.`;
  const where = `At ${time.toFixed(2)} s the mover ${end ? "fell onto" : "is drawn to"} its stop at ${(1e3 * ends[end]).toFixed(1)} mm`;
  return `${where}: ${most.toPrecision(2)} A cannot ${end ? "lift it from" : "let go of it"} there, ${needed.toPrecision(2)} A would.`;
}

function frame(message) {
  if (!page.history) return;   // it is of the flight before
  page.frame = message;
  page.history.add(message.rows);
  page.ghost?.add(message.ghostRows);
  page.dirty = true;
  followStory(message.time);
  const before = at("flags").dataset.now ?? "", clock = performance.now();
  for (const name of Object.keys(EVENTS)) if (message.flags[name]) page.lit[name] = clock;
  // One that comes and goes is shown for long enough to be read.
  const now = Object.keys(EVENTS).filter((name) => clock - page.lit[name] < LIT);
  if (before !== now.join()) {
    at("flags").dataset.now = now.join();
    at("flags").replaceChildren(...now.map((name) => html("span", { class: `flag ${name}` }, null, EVENTS[name])));
    at("lift").hidden = !now.includes("stop");
    if (now.includes("stop") && !before.includes("stop")) say(page.fell = touched(message.time), true);
    if (!now.includes("stop") && at("status").textContent === page.fell) say("");
  }
  if (message.ghostFlags?.stop && !page.ghostDown && !page.story) say(GHOST_DOWN, true);
  if (!message.ghostFlags?.stop && page.ghostDown && at("status").textContent === GHOST_DOWN) say("");
  page.ghostDown = message.ghostFlags?.stop;
}

function refused({ text }) {
  page.ended = true;
  play(false);
  say(`The flight has ended: ${text}`, true);
  if (page.state.controller === LAW) lawSaid(text, true);
}

const RECEIVED = {
  loaded: () => {
    if (own.after) { own.after(); return; }
    const { state, problems } = readFragment(location.hash);
    openState(state);
    play(!matchMedia("(prefers-reduced-motion: reduce)").matches);
    if (state.law) showSharedLaw(state.law);
    say(problems.length ? problems.join("; ") : page.playing ? "" : "Paused, for your system asks for little motion.",
      problems.length > 0);
  },
  started,
  frame,
  refused,
  "ghost refused": ({ text }) => { setGhost(""); say(`The stage that flew along has ended: ${text}`, true); },
  owned,
  "own refused": ownRefused,
  alive: () => { own.heard = performance.now(); },
  "not done": ({ text }) => say(text, true),
  flown: (message) => { page.flown[message.run] = message; },
};

/** Begin a thread that flies; one that there was is ended. */
function startWorker() {
  worker?.terminate();
  worker = new Worker(URL.createObjectURL(new Blob([at("worker").textContent], { type: "text/javascript" })));
  worker.onmessage = ({ data }) => { if (isHeard(data)) RECEIVED[data.type](taken(data)); };
  worker.onerror = (event) => { page.problems.push(event.message); say(event.message, true); };
}

const loadWorker = () => post({ type: "load", about: live.fmus, plans: live.runs, binaries: live.binaries, law: live.parts });

/** Fill in what changes with every frame, four times a second. */
let lastReadings = 0;
function readings(now) {
  if (now - lastReadings < 250 || !page.frame) return;
  lastReadings = now;
  const row = page.history.last();
  at("time").textContent = `${row.time.toFixed(2)} s`;
  at("pace").textContent = page.playing ? `${page.frame.pace.toFixed(page.frame.pace < 1 ? 2 : 1)}× real time` : "paused";
  for (const axis of page.run.axes) {
    const shown = page.run.rig.shown[axis];
    page.panel.references[axis]?.(shown.scale * row.axes[axis].reference);
    at(`reading-${axis}`).textContent = reading(shown, row.axes[axis].position);
  }
}

function draw(now) {
  requestAnimationFrame(draw);
  if (!page.dirty || !page.history?.count) return;
  page.dirty = false;
  page.frames++;
  const row = page.history.last(), ghost = page.ghost?.last() ?? null;
  page.views = drawStage(at("stage"), page.run, row, ghost, valueOf, page.colours, { seen: page.state.view, orbit: page.orbit });
  page.strips.draw(at("strips"), page.history, page.ghost, page.colours, !page.playing);
  if (!page.dragged) drawHint(at("stage"), page.views[0], page.run, row, page.colours);
  drawPlane(at("plane"), page.run, page.history, page.ghost, valueOf, page.colours);
  readings(now);
  post({ type: "drawn" });
}

/** Colours of the style sheet by the names of what they stand for; those of the axes are the run's. */
function readColours() {
  const style = getComputedStyle(document.documentElement);
  const colour = (name) => style.getPropertyValue(`--${name}`).trim();
  page.colours = Object.fromEntries(["paper", "text", "faint", "line", "iron", "current", "north", "south", "plate", "weight", "bad"]
    .map((name) => [name, colour(name)]));
  page.run?.axes.forEach((axis, i) => { page.colours[axis] = colour(`axis-${i}`); });
  page.dirty = true;
}

function layout() {
  const stage = at("stage");
  const height = Math.round(stageHeight(page.run, stage.parentElement.clientWidth, page.state.view));
  stage.style.height = `${height}px`;
  const least = 75 * page.strips.strips.length;
  at("strips").style.height = `${Math.max(least, Math.min(520, innerHeight - height - 215))}px`;   // all on one screen
  stage.setAttribute("aria-label", `The stage, ${SEEN[page.state.view]}. Arrow keys move the references by 1 mm, page up and down that of the gap; space pauses, 1 to 4 swap the controller, k and j kick.`);
  readColours();
}
