"use strict";
// The panel: elements that set a run's parameters, made from tables; each reads what it shows from the settings.

/** Return names `fmu.variable` of the running parameters whose ends match. */
function parametersLike(run, controller, pattern) {
  return [["plant", run.plant], ["controller", controller], ["measurement", run.measurement]].flatMap(([part, model]) => live.fmus[model].variables
    .filter(({ causality, name }) => causality === "parameter" && pattern.test(`${part}.${name}`))
    .map(({ name }) => `${part}.${name}`));
}

/** Parameters that a knob sets: of its patterns, those of the first that what runs has any of. */
const knobNames = (knob, run, controller) => [knob.like].flat()
  .map((pattern) => parametersLike(run, controller, pattern)).find((names) => names.length) ?? [];

/** Knobs on one or several parameters: by a factor of the planned value, by an addition, or as a value in a unit. */
const KNOBS = [
  { id: "payload", label: "payload", unit: "kg", low: 0, high: 2, step: 0.05, by: "sum",
    like: [/^plant\.payload\.mass$/, /^plant\.\w+\.mass$/] },
  ...["x", "z"].map((axis) => ({ id: `payload-${axis}`, label: `its place, ${axis}`, unit: "mm", low: -150, high: 150, step: 10,
    scale: 1e-3, by: "value", like: new RegExp(`^plant\\.payload\\.${axis}$`), hides: true })),
  { id: "friction", label: "guide friction", unit: "×", low: 0, high: 3, step: 0.1, by: "factor",
    like: /^plant\.\w+\.friction\.(coulomb|viscous)$/ },
  { id: "bias", label: "bias", unit: "×", low: -3, high: 3, step: 0.25, like: /^plant\.\w+\.bias$/, by: "factor" },
  { id: "encoder", zero: "exact", label: "encoder's step", unit: "µm", low: 0, high: 100, step: 5, scale: 1e-6, by: "value",
    like: /^plant\.encoder\.resolution$/ },
  { id: "peak", label: "amplifier peak", unit: "A", low: 0.5, high: 12, step: 0.5, by: "value",
    like: /^plant\.\w+\.amplifier\.peak$/ },
  { id: "limit", label: "current limit", zero: "none", unit: "A", low: 0, high: 9, step: 0.25, by: "value",
    like: /^controller\.current_limit$/ },
  { id: "noise", group: "faults", label: "noise", zero: "none", unit: "µm", low: 0, high: 100, step: 2, scale: 1e-6, by: "value",
    like: /^measurement\.\w+\.noise$/ },
  { id: "delay", group: "faults", label: "delay", zero: "none", unit: "ms", low: 0, high: 20, step: 0.5, scale: 1e-3, by: "value",
    like: /^measurement\.delay$/ },
  { id: "lost", group: "faults", label: "samples lost", zero: "none", unit: "%", low: 0, high: 95, step: 5, scale: 0.01, by: "value",
    like: /^measurement\.\w+\.lost$/ },
  { id: "bus", group: "faults", label: "bus voltage", zero: "no limit", unit: "V", low: 0, high: 48, step: 1, by: "value",
    like: /^plant\.bus_voltage$/ },
  { id: "magnets", group: "faults", label: "warmer magnets", zero: "none", unit: "K", low: 0, high: 100, step: 5, by: "value",
    like: /^plant\.magnet_rise$/ },
  { id: "gains", label: "all gains", unit: "×", low: 0.2, high: 2, step: 0.05, like: /^controller\.\w+\.k[1-5]$/,
    by: "factor" },
];

/** Switches: the Booleans that each sets, of the first motor or encoder or of all. */
const SWITCHES = [
  { id: "windup", group: "knobs", label: "anti-windup", like: /^controller\.antiwindup$/ },
  { id: "phase", label: "a phase is open", like: /^plant\.\w+\.phase_b\.open$/, first: 1 },
  { id: "supply", label: "a supply is lost", like: /^plant\.\w+\.phase_[abc]\.open$/, first: 3 },
  { id: "stuck", label: "amplifiers stuck", like: /^plant\.\w+\.amplifier\.stuck$/ },
  { id: "frozen", label: "an encoder is stuck", like: /^measurement\.\w+\.frozen$/, first: 1 },
];

const switchNames = ({ like, first = Infinity }, run, controller) => parametersLike(run, controller, like).slice(0, first);

/** Return the position of a knob for the present values of its parameters; undefined if nothing that runs has them. */
function knobValue(knob, run, controller, valueOf) {
  const names = knobNames(knob, run, controller);
  if (!names.length) return undefined;
  const full = names.find((name) => plannedValue(run, controller, name) !== 0) ?? names[0];
  const planned = plannedValue(run, controller, full), now = valueOf(full);
  if (knob.by === "sum") return now - planned;
  if (knob.by === "factor") return planned === 0 ? 1 : now / planned;
  return now / (knob.scale ?? 1);
}

/** Values of its parameters that a knob sets. */
function knobSettings(knob, run, controller, value) {
  const digits = (number) => Number(number.toPrecision(12));
  return Object.fromEntries(knobNames(knob, run, controller).map((full) => {
    const planned = plannedValue(run, controller, full);
    return [full, digits(knob.by === "sum" ? planned + value : knob.by === "factor" ? planned * value
      : value * (knob.scale ?? 1))];
  }));
}

/** Add a labelled range with its value next to it; `act` gets the number. */
function slider(parent, { id, label, unit, low, high, step, zero, hides }, act) {
  const row = html("div", { class: "slider" }, parent);
  html("label", { for: id }, row, label);
  const input = html("input", { type: "range", id, min: low, max: high, step }, row);
  const shown = html("output", { for: id }, row);
  const show = (value) => {
    const off = value === undefined;
    input.disabled = off;
    row.hidden = off && hides === true;
    const text = off ? "—" : value === 0 && zero ? zero : `${Number(value.toFixed(step < 0.5 ? 2 : 1))} ${unit}`.replace("-", "−");
    if (shown.textContent !== text) {
      shown.textContent = text;
      input.setAttribute("aria-valuetext", text);
    }
    if (!off && document.activeElement !== input && Number(input.value) !== value) input.value = value;
  };
  input.addEventListener("input", () => { act(Number(input.value)); });
  return show;
}

/** Show the choices of a list, and which is chosen. */
function choose(id, options, chosen) {
  const list = at(id), key = JSON.stringify(options);
  if (list.dataset.key !== key) list.replaceChildren(...options.map(([value, text]) => html("option", { value }, null, text)));
  list.dataset.key = key;
  list.value = chosen;
}

/** Add a form for any parameter: a list to choose from, its value, and its description. */
function parameterForm(parent, act) {
  const form = html("form", { class: "parameter" }, parent);
  html("label", { for: "parameter-name" }, form, "any parameter");
  const names = html("select", { id: "parameter-name" }, form);
  html("label", { for: "parameter-value" }, form, "its value (SI)");
  const row = html("div", { class: "row" }, form);
  const value = html("input", { id: "parameter-value", type: "text", autocomplete: "off" }, row);
  html("button", { type: "submit" }, row, "Set");
  const wrong = html("p", { class: "bad", id: "parameter-wrong", role: "status" }, form), about = html("p", { class: "about", id: "parameter-about" }, form);
  let now = () => undefined, run = null, controller = "";
  const tell = (problem) => {
    wrong.textContent = problem;
    value.setAttribute("aria-invalid", String(problem !== ""));
  };
  const show = () => {
    const variable = variableOf(run, controller, names.value);
    value.value = String(now(names.value));
    tell("");
    about.textContent = `${variable.description}${variable.unit ? `, ${variable.unit}` : ""}`
      + `${variable.fixed ? "; restarts when it changes" : ""}`;
  };
  names.addEventListener("change", show);
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    tell(act(names.value, value.value));
  });
  return (nextRun, nextController, valueOf) => {
    now = valueOf;
    if (run === nextRun && controller === nextController) {
      if (document.activeElement !== value && document.activeElement !== names) show();
      return;
    }
    [run, controller] = [nextRun, nextController];
    const before = names.value, all = parametersLike(run, controller, /./);
    names.replaceChildren(...all.map((full) => html("option", { value: full }, null, full)));
    names.value = all.includes(before) ? before : all[0];
    show();
  };
}

/** The settings that differ from the plan, each with a button that takes it back. */
function settingsList(parent, act) {
  const list = html("ul", { class: "settings", "aria-label": "Changes to the planned run" }, parent);
  return (settings) => {
    const key = JSON.stringify(settings);
    if (list.dataset.key === key) return;
    list.dataset.key = key;
    list.replaceChildren();
    for (const [full, value] of Object.entries(settings)) {
      const item = html("li", {}, list, `${full} = ${value} `);
      html("button", { type: "button", "aria-label": `Take back ${full}` }, item, "undo")
        .addEventListener("click", () => act(full));
    }
  };
}
