"use strict";
// The page: a worker that runs, a picture and plots of its data, and hands that reach into the run.

let worker = null;
const at = (id) => document.getElementById(id);
const post = (message) => worker.postMessage(message);
// The orbit is from where the picture in space is seen; the shot is the one that it goes to.
const page = { state: null, run: null, history: null, ghost: null, width: 0, playing: false, frame: null, views: [],
  dirty: true, colours: {}, drag: null, press: null, leads: {}, hint: null, turning: null, dragged: false, orbit: { ...SHOTS.space, zoom: 1 }, shot: null,
  story: null, fell: null, hits: [], lit: {}, frames: 0, problems: [] };
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

/** Update the address, and everything that shows the settings. */
function stateChanged() {
  known.clear();
  const { controller, ghost, speed } = page.state;
  showPlots(page.run, valueOf, ghost ? [controller, ghost] : null, windowFor(speed));
  const fragment = fragmentOf(page.state);
  if (location.hash !== fragment) history.replaceState(null, "", fragment);
  showPanel();
  page.dirty = true;
}

/** Begin a run from its start; `planned` are the actions of an experiment, which the worker takes in it. */
function begin(state, planned = []) {
  page.state = state;
  page.run = live.runs[state.run];
  page.story = null;
  page.ended = false;
  page.hits = [];
  page.lit = {};
  page.leads = {};
  page.panel.shake(0);
  if (!planned.length) state.story = "";
  page.history = page.ghost = null;
  post({ type: "start", run: state.run, controller: state.controller, other: state.ghost, settings: { ...state.settings },
    planned });
  post({ type: "speed", value: state.speed });
  at("released").hidden = true;
  at("moment").textContent = "";
  stateChanged();
  layout();
  showStory();
}

/** Restart, an experiment with all its actions. */
function restart() {
  if (page.state.story) { tellStory(page.state.story); return; }
  begin(page.state);
  say("Started anew.");
}

/** Lift the mover into the air at its references, without the settings that brought it down; the run and its experiment
 * continue. */
function liftOff() {
  if (page.ended) { restart(); return; }
  if (page.story) page.state.settings = {}; else release();   // where it was dragged to it may not hold
  page.hits = [];
  post({ type: "lift", settings: { ...page.state.settings } });
  stateChanged();
  play(true);
  say("");
}

/** The run as its file plans it: also its controller. */
function asPlanned() {
  begin({ ...page.state, settings: {}, controller: page.run.fmus.controller.model });
  play(true);
  say("As planned again.");
}

/** Change parameters: while it runs where they can, with a new start where not. */
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
  say(`${isOwn(controller) ? "Your" : `The ${lawOf(page.run, controller)}`} controller takes over, from where the stage is.`);
}

function setGhost(other) {
  page.state.ghost = other;
  page.ghost = other ? new RunHistory(page.run, page.width) : null;
  post({ type: "ghost", other });
  stateChanged();
  say(other ? `A transparent stage runs along with ${isOwn(other) ? "your" : `the ${lawOf(page.run, other)}`} controller.` : "No stage runs along.");
}

function play(on) {
  page.playing = on;
  if (on) followRun();
  page.dirty = true;
  at("play").textContent = on ? "Pause" : "Play";
  post({ type: "play", on });
}

/** Begin what an address asks for. */
function openState(state) {
  const { story } = state, waits = story === "beat" && state.law && !live.runs[state.run].laws[LAW];   // for its reader
  begin(state);
  if (story && !waits) tellStory(story);
  if (waits) { page.state.story = story; stateChanged(); }
}

const vertical = () => page.run.vertical;

/** Keep a place (m, rad) of an axis between its ends. */
function within(axis, value, margin = 0.5e-3) {
  const [lower, upper] = endsOf(page.run, axis, valueOf);
  return Math.min(upper - margin, Math.max(lower + margin, value));
}

/** Set a reference, or have it follow the run again; a reference that the hand leads continues to where the hand has put
 * it. */
function refer(axis, value, led = false) {
  if (!led) delete page.leads[axis];
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
  page.history = new RunHistory(page.run, width);
  followRun();
  page.ghost = page.state.ghost ? new RunHistory(page.run, width) : null;
}

const EVENTS = { stop: "an end stop is touched", tripped: "the controller has tripped",
  slowed: "the reference is slower than the hand", spared: "no farther: it could not be held",
  infeasible: "no current gives the forces that are demanded", clamped: "an amplifier is at its peak", limited: "a command is at its limit" };

const LIT = 400;   // ms

function frame(message) {
  if (!page.history) return;   // it is of the run before
  const slowed = followHand(message.time - (page.frame?.time ?? message.time));
  page.frame = message;
  page.history.add(message.rows);
  page.ghost?.add(message.ghostRows);
  page.dirty = true;
  followStory(message.time);
  const before = at("flags").dataset.now ?? "", clock = performance.now();
  for (const name of Object.keys(EVENTS)) if (message.flags[name] || (name === "slowed" && slowed)) page.lit[name] = clock;
  // A message that comes and goes is shown for long enough to be read.
  const now = Object.keys(EVENTS).filter((name) => clock - page.lit[name] < LIT);
  if (before !== now.join()) {
    at("flags").dataset.now = now.join();
    at("flags").replaceChildren(...now.map((name) => html("span", { class: `flag ${name}` }, null, EVENTS[name])));
    at("lift").hidden = !now.includes("stop");
    if (now.includes("stop") && !before.includes("stop")) {
      const end = hit(page.history.last(), message.time, lawOf(page.run, page.state.controller));
      if (!page.story) say(page.fell = touched(message.time, end), true);   // which tells it by itself
    }
    if (!now.includes("stop") && at("status").textContent === page.fell) say("");
  }
  if (message.ghostFlags?.stop && !page.ghostDown && page.ghost.count) hit(page.ghost.last(), message.time, lawOf(page.run, page.state.ghost));
  page.ghostDown = message.ghostFlags?.stop;
}

function refused({ text }) {
  page.ended = true;
  play(false);
  say(`The run has ended: ${text}`, true);
  if (page.state.controller === LAW) lawSaid(text, true);
}

const RECEIVED = {
  loaded: () => {
    if (own.after) { own.after(); return; }
    const { state, problems } = readFragment(location.hash);
    openState(state);
    play(!matchMedia("(prefers-reduced-motion: reduce)").matches);
    if (state.law) showSharedLaw(state.law, state.result);
    say(problems.length ? ignored(problems) : page.playing ? "" : "Paused: your system asks for reduced motion.",
      problems.length > 0);
  },
  started,
  frame,
  refused,
  "ghost refused": ({ text }) => { setGhost(""); say(`The stage that ran along has ended: ${text}`, true); },
  owned,
  "own refused": ownRefused,
  alive: () => { own.silent = 0; },
  "not done": ({ text }) => say(text, true),
  scored,
};

/** Begin a thread that runs; one that there was is ended. */
function startWorker() {
  worker?.terminate();
  worker = new Worker(URL.createObjectURL(new Blob([live.worker], { type: "text/javascript" })));
  worker.onmessage = ({ data }) => { if (isHeard(data)) RECEIVED[data.type](taken(data)); };
  worker.onerror = (event) => { page.problems.push(event.message); say(event.message, true); };
}

const loadWorker = () => post({ type: "load", about: live.fmus, plans: live.runs, binaries: live.binaries, law: live.parts, laws: live.laws });
