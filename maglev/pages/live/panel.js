"use strict";
// The panel: knobs, references, readings, kicks and switches.

/** Elements that depend on the stage: references, readings, kicks. */
function stagePanel() {
  const { axes } = page.run;
  for (const id of ["references", "readings", "kicks"]) at(id).replaceChildren();
  page.panel.references = {};
  for (const axis of axes) {
    const { name, unit, scale } = page.run.stage.shown[axis], ends = endsOf(page.run, axis, valueOf).map((end) => scale * end);
    page.panel.references[axis] = slider(at("references"), { id: `reference-${axis}`, label: name, unit,
      low: Math.ceil(ends[0] + 0.5), high: Math.floor(ends[1] - 0.5), step: 0.5 }, (value) => lead(axis, value / scale));
    const reading = html("div", {}, at("readings"));
    html("dt", { style: `color: var(--axis-${axes.indexOf(axis)})` }, reading, axis);
    html("dd", { id: `reading-${axis}` }, reading);
    const impulse = impulseOf(axis);
    const arrows = axis === vertical() ? "▲▼" : isTilt(page.run, axis) ? "↺↻" : "◀▶";
    for (const [sign, arrowText] of [[-1, arrows[0]], [1, arrows[1]]]) {
      html("button", { type: "button", "aria-label": `Kick ${axis} by ${impulseText(axis, sign * impulse)}` }, at("kicks"),
        `${axis} ${arrowText}`).addEventListener("click", () => kick(axis, sign * impulse));
    }
  }
}

let shownRun = "";

/** Show the state in the panel. */
function showPanel() {
  const { state, run, panel } = page, models = controllersOf(run);
  if (shownRun !== run.plant) {
    shownRun = run.plant;
    stagePanel();
    showTask();
  }
  at("run").value = state.run;
  at("about").textContent = run.title;
  at("speed").value = String(state.speed);
  at("view").value = state.view;
  choose("controller", models.map((model) => [model, lawOf(run, model)]), state.controller);
  choose("ghost", [["", "none"], ...models.map((model) => [model, lawOf(run, model)])], state.ghost);
  for (const each of SWITCHES) {
    const names = switchNames(each, run, state.controller), input = at(`switch-${each.id}`);
    input.parentElement.hidden = !names.length;
    input.checked = names.length > 0 && names.every((name) => valueOf(name) === true);
  }
  at("blink").hidden = !offNames().length;
  for (const knob of KNOBS) panel.knobs[knob.id](knobValue(knob, run, state.controller, valueOf));
  panel.parameter(run, state.controller, valueOf);
  panel.settings(state.settings);
  // No command runs a controller that is in no file.
  at("copy-command").hidden = !run.command || isOwn(state.controller) || isRung(state.controller)
    || (!run.fmus.measurement && Object.keys(state.settings).some((name) => name.startsWith("measurement.")));
  at("planned").hidden = !Object.keys(state.settings).length && state.controller === run.fmus.controller.model;
}

/** Set a parameter; returns what is wrong with its value. */
function setParameter(full, text) {
  try {
    change({ [full]: readValue(variableOf(page.run, page.state.controller, full), full, text) });
    say(`${full} = ${text}.`);
    return "";
  } catch (error) {
    return error.message;
  }
}

/** Return the names of the parameters that switch all amplifiers off. */
const offNames = () => parametersLike(page.run, page.state.controller, /^plant\.\w+\.amplifier\.off$/);

function buildSwitches() {
  for (const each of SWITCHES) {
    const label = html("label", { class: "check" }, at(each.group ?? "switches"));
    const input = html("input", { type: "checkbox", id: `switch-${each.id}` }, label);
    label.append(each.label);
    input.addEventListener("change", () => change(Object.fromEntries(
      switchNames(each, page.run, page.state.controller).map((name) => [name, input.checked]))));
  }
  at("blink").addEventListener("click", () => {
    const all = (value) => Object.fromEntries(offNames().map((name) => [name, value]));
    post({ type: "blink", values: all(true), back: all(false), time: BLINK });
    say(`No current for ${1e3 * BLINK} ms.`);
  });
}

function buildPanel() {
  for (const speed of SPEEDS) html("option", { value: speed }, at("speed"), `${speed}×`);
  page.panel = {
    knobs: Object.fromEntries(KNOBS.map((knob) => [knob.id, slider(at(knob.group ?? "knobs"), knob,
      (value) => change(knobSettings(knob, page.run, page.state.controller, value)))])),
    shake: slider(at("faults"), { id: "shake", label: "the floor shakes", zero: "no", unit: "m/s²", low: 0, high: 3, step: 0.1 },
      (value) => { post({ type: "shake", value }); page.panel.shake(value); }),
    parameter: parameterForm(at("any"), setParameter),
    settings: settingsList(at("changed"), (full) => change({ [full]: plannedValue(page.run, page.state.controller, full)
      ?? plannedValue(page.run, page.run.fmus.controller.model, full) })),
    references: {},
  };
  buildSwitches();
  at("controller").addEventListener("change", () => swap(at("controller").value));
  at("ghost").addEventListener("change", () => setGhost(at("ghost").value));
  at("run").addEventListener("change", () => {
    begin({ ...readFragment(`#run=${at("run").value}&speed=${page.state.speed}`).state, view: page.state.view });
    play(true);
    say("");
  });
  at("speed").addEventListener("change", () => {
    page.state.speed = Number(at("speed").value);
    post({ type: "speed", value: page.state.speed });
    stateChanged();
  });
  at("play").addEventListener("click", () => play(!page.playing));
  at("restart").addEventListener("click", restart);
  at("lift").addEventListener("click", liftOff);
  at("released").addEventListener("click", release);
  at("planned").addEventListener("click", asPlanned);
  for (const { id, label } of STORIES) {
    html("button", { type: "button", value: id, "aria-pressed": "false" }, at("stories"), label)
      .addEventListener("click", () => tellStory(id));
  }
  at("view").addEventListener("change", () => {
    page.state.view = at("view").value;
    page.shot = { ...SHOTS[page.state.view], zoom: 1 };
    stateChanged();
  });
  at("copy-link").addEventListener("click", () => copy(location.href, "link"));
  at("copy-command").addEventListener("click", () => copy(commandOf(page.state), "command"));
  const stage = at("stage");
  stage.addEventListener("pointerdown", grab);
  // A finger that has taken the mover moves it; others scroll the page.
  for (const touch of ["touchstart", "touchmove"]) stage.addEventListener(touch, (event) => { if (page.drag) event.preventDefault(); }, { passive: false });
  stage.addEventListener("contextmenu", (event) => { if (page.drag || page.press) event.preventDefault(); });
  stage.addEventListener("pointermove", move);
  for (const end of ["pointerup", "pointercancel"]) stage.addEventListener(end, letGo);
  stage.addEventListener("keydown", pressed);
  addEventListener("resize", () => { if (page.run) { stateChanged(); layout(); } });
  addEventListener("hashchange", () => {
    if (!page.state) return;   // it is read once the controllers are there
    const { state, problems } = readFragment(location.hash);
    openState(state);
    if (state.law) showSharedLaw(state.law, state.result);
    say(ignored(problems), problems.length > 0);
  });
  whenColoursChange((printed) => { readColours(printed); if (page.history?.count) drawNow(performance.now()); });
}
