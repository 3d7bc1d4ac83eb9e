"use strict";
// The state of the page, as the fragment of its address and as a `maglev run` command: run, controller, settings.

let live = null;   // what the page carries: descriptions of the FMUs, runs, and numbers for the picture

const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 5, 10, 20];
const FIRST_RUN = "3dof-setpoints-improved";   // where the page has it

/** Return true if a controller is the reader's own. */
const isOwn = (model) => model.startsWith("own:");

/** Return true if a controller is one of the page's own, which no folder has: an opponent. */
const RUNG = "ladder:";
const isRung = (model) => model.startsWith(RUNG);

/** Name of a controller's law, such as "linear" of "LinearRegulator3DOF". */
const lawOf = (run, model) => run.laws[model];
const controllersOf = (run) => Object.keys(run.laws);

/** Colour of a controller in the style sheet, the same everywhere. */
const colourOf = (run, model) => `run-${live.colours[lawOf(run, model)] ?? 1}`;

/** The variable `fmu.variable` of a run with a controller; undefined if there is none. */
function variableOf(run, controller, full) {
  const [part, variable] = [full.slice(0, full.indexOf(".")), full.slice(full.indexOf(".") + 1)];
  const model = { plant: run.plant, measurement: run.measurement, controller }[part];
  return live.fmus[model]?.variables.find(({ name, causality }) => name === variable && causality === "parameter");
}

/** Return the start value of a parameter: the plan's value, or the FMU's; undefined if there is no such parameter. */
function plannedValue(run, controller, full) {
  const part = full.slice(0, full.indexOf("."));
  const given = part === "controller" && live.fmus[controller].start ? live.fmus[controller] : run.fmus[part];
  const planned = part === "controller" && isOwn(controller) ? undefined : given?.start[full.slice(full.indexOf(".") + 1)];
  const variable = variableOf(run, controller, full);
  return variable && (planned ?? variable.start);
}

/** Read a value for a parameter; throws what is wrong with it. */
function readValue(variable, full, text) {
  if (variable.boolean) {
    if (text === "true" || text === "false") return text === "true";
    throw new Error(`${full} = ${text}, expected true or false`);
  }
  const value = text.trim() === "" ? NaN : Number(text);
  if (value >= variable.min && value <= variable.max) return value;
  throw new Error(`${full} = ${text}, expected a number from ${variable.min} to ${variable.max} ${variable.unit}`);
}

/** Say which parts of a link are ignored. */
const ignored = (problems) => (problems.length ? `Ignored in this link: ${problems.join("; ")}` : "");

/** Return the state that a fragment asks for, and the problems in it. */
function readFragment(fragment) {
  const problems = [], entries = new URLSearchParams(fragment.replace(/^#/, "").replaceAll("+", "%2B"));
  const asked = entries.get("run");
  if (asked !== null && !Object.hasOwn(live.runs, asked)) problems.push(`run = ${asked}: there is no such run here`);
  const name = [asked, FIRST_RUN, Object.keys(live.runs)[0]].find((each) => Object.hasOwn(live.runs, each));
  const run = live.runs[name], known = controllersOf(run);
  const state = { run: name, controller: run.fmus.controller.model, ghost: "", speed: 1, settings: {}, view: "space", story: "",
    law: entries.get("law") ?? "", result: null };
  try {
    if (entries.has("result")) state.result = readResult(entries.get("result"));
  } catch (error) {
    problems.push(error.message);
  }
  const choices = { controller: known, ghost: known, speed: SPEEDS, view: Object.keys(SHOTS), story: STORIES.map(({ id }) => id) };
  for (const [key, allowed] of Object.entries(choices)) {
    const text = entries.get(key), value = key === "speed" ? Number(text) : text;
    if (allowed.includes(value)) state[key] = value;
    else if (text) problems.push(`${key} = ${text}, expected one of ${allowed.join(", ")}`);
  }
  for (const [full, text] of entries) {
    if (["run", "law", "result", ...Object.keys(choices)].includes(full)) continue;
    const variable = variableOf(run, state.controller, full) ?? variableOf(run, run.fmus.controller.model, full);
    try {
      if (!variable) throw new Error(`${full}: there is no such parameter of ${name}`);
      state.settings[full] = readValue(variable, full, text);
    } catch (error) {
      problems.push(error.message);
    }
  }
  return { state, problems };
}

/** Fragment that asks for a state. */
function fragmentOf({ run, controller, ghost, speed, settings, view, story, law }) {
  const entries = [["run", run]];
  if (view !== "space") entries.push(["view", view]);
  const packed = controller === LAW ? own.packed : law;   // a law from a link stays in it until another one runs
  if (story) entries.push(["story", story]);
  if (story === "beat" && packed && packed.length <= LONGEST_LINK) entries.push(["law", packed], ...(beat.yours ? [["result", resultText(beat.yours)]] : []));
  if (story) return `#${entries.map((entry) => entry.join("=")).join("&")}`;
  if (controller !== live.runs[run].fmus.controller.model && !isOwn(controller)) entries.push(["controller", controller]);
  if (packed && packed.length <= LONGEST_LINK) entries.push(["law", packed]);
  if (ghost && !isOwn(ghost)) entries.push(["ghost", ghost]);
  if (speed !== 1) entries.push(["speed", speed]);
  return `#${[...entries, ...Object.entries(settings)].map(([key, value]) => `${key}=${value}`).join("&")}`;
}

/** Return the command that runs a state without the page, except for drags and kicks. */
function commandOf({ run: name, controller, settings }) {
  const run = live.runs[name];
  const other = controller === run.fmus.controller.model ? "" : ` --controller fmus/native/${controller}.fmu`;
  const known = Object.entries(settings).filter(([full]) => variableOf(run, controller, full));
  return `maglev run ${run.command}${other}${known.map(([full, value]) => ` --set ${full}=${value}`).join("")}`;
}
