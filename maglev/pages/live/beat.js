"use strict";
// Beat the thesis: a task for a law of the reader's and for the thesis's regulator, and what each makes of it, in numbers.

const TASK = { mass: 1, on: 1, way: 0.01, step: 4, until: 7 };   // kg that are put on, at s; m of the step, at s; s
const TIE = 0.05;                                                // share of the smaller value by which two differ and are as good
const PHONE = matchMedia("(max-width: 67.99rem)");               // where a law is changed by its gains

/** What is measured, as the worker gives it: in words, its unit, how many of it are one SI unit, and digits. */
const MEASURES = [["gap error under 1 kg", "mm", 1e3, 2], ["… back within 0.1 mm", "ms", 1e3, 0], ["10 mm step, within 0.1 mm", "ms", 1e3, 0],
  ["… overshoot", "mm", 1e3, 2], ["… gap error meanwhile", "mm", 1e3, 2], ["current ripple at rest", "mA", 1e3, 1]];

const beat = { asked: 0, yours: null, thesis: null, sent: false, starter: "pid", factors: {}, generated: "" };

/** The thesis's regulator of a stage. */
const thesisOf = (run) => lawLike(run, "nonlinear") ?? run.fmus.controller.model;

/** What is done in the task: messages to the worker, by their times. */
function taskActs(run, controller) {
  const [axis] = drivenAxes(run), row = restRow(run), payload = KNOBS.find(({ id }) => id === "payload");
  return [...run.axes.map((each) => ({ at: 0, type: "reference", axis: each, value: row.axes[each].position })),
    { at: TASK.on, type: "tune", values: knobSettings(payload, run, controller, TASK.mass), shown: true },
    { at: TASK.step, type: "reference", axis, value: row.axes[axis].position + TASK.way }];
}

/** Have the worker measure the thesis's regulator and, where it runs, the law. */
function askScores(run, yours) {
  beat.asked += 2;
  Object.assign(beat, { thesis: null, ...(yours ? { yours: null, sent: false } : {}) });
  const { on, step, until } = TASK, task = { axis: drivenAxes(run)[0], on, step, until };
  [thesisOf(run), ...(yours ? [LAW] : [])].forEach((model, i) => post({ type: "scored", number: beat.asked + i, run: homeOf(run), model,
    settings: {}, acts: taskActs(run, model), task }));
  showResult();
}

function scored({ number, values, lost }) {
  if (number !== beat.asked && number !== beat.asked + 1) return;   // of a task before
  beat[number === beat.asked ? "thesis" : "yours"] = { values, lost };
  showResult();
  if (page.state.story === "beat") stateChanged();   // the result is in the link
}

const measured = (result, i) => {
  const [, unit, scale, digits] = MEASURES[i];
  return !result ? "" : result.values.length ? `${(scale * result.values[i]).toFixed(digits)} ${unit}` : i ? "–" : `lost at ${result.lost.toFixed(2)} s`;
};

/** Of each measure −1 where the law is better, 1 where the thesis is, 0 where they are as good as each other: within TIE, or read the
 * same. None while one is not measured, or has lost the platform. */
function compared({ yours, thesis } = beat) {
  if (!yours?.values.length || !thesis?.values.length) return [];
  return yours.values.map((ours, i) => {
    const theirs = thesis.values[i], alike = Math.max(ours, theirs) <= (1 + TIE) * Math.min(ours, theirs) || measured(yours, i) === measured(thesis, i);
    return alike ? 0 : Math.sign(ours - theirs);
  });
}

function verdictText() {
  if (!beat.yours || !beat.thesis) return "";
  const [better, alike, worse] = [-1, 0, 1].map((sign) => compared().filter((each) => each === sign).length);
  const parts = [better && `beats the thesis in ${better}`, alike && `is as good (within ${100 * TIE} %) in ${alike}`, worse && `is worse in ${worse}`];
  const how = compared().length ? `It ${parts.filter(Boolean).join(", ")} of ${MEASURES.length} measures.`
    : `It lost the platform after ${beat.yours.lost.toFixed(2)} s.`;
  return beat.sent ? `${how} This is what the link says: run it to check.` : how;
}

function showResult() {
  const { yours, thesis } = beat, table = at("result"), best = compared();
  table.replaceChildren();
  html("caption", {}, table, verdictText());
  const head = html("tr", {}, html("thead", {}, table));
  for (const [text, colour] of [["less is better; bold: by over 5 %"], ["yours", "run-1"], ["thesis", "run-0"]]) {
    const cell = html("th", { scope: "col" }, head, text);
    if (colour) cell.prepend(html("i", { class: "swatch", style: `background: var(--${colour})` }));
  }
  const body = html("tbody", {}, table);
  MEASURES.forEach(([name], i) => {
    const row = html("tr", {}, body);
    html("th", { scope: "row" }, row, name);
    html("td", { class: best[i] < 0 ? "best" : "" }, row, measured(yours, i));
    html("td", { class: best[i] > 0 ? "best" : "" }, row, measured(thesis, i));
  });
}

/** The result as a link has it, and back: numbers in SI, or when it was lost. */
const resultText = ({ values, lost }) => (values.length ? values.map((value) => Number(value.toPrecision(4))).join() : `lost,${Number(lost.toPrecision(4))}`);
function readResult(text) {
  const parts = text.replace(/^lost,/, "").split(",").map(Number), good = parts.every((value) => Number.isFinite(value) && value >= 0);
  if (!good || parts.length !== (text.startsWith("lost,") ? 1 : MEASURES.length)) throw new Error(`result: expected ${MEASURES.length} numbers`);
  return text.startsWith("lost,") ? { values: [], lost: parts[0] } : { values: parts, lost: 0 };
}

/** The starter that is chosen, in the editor; what was written by hand stays unless it is asked for. */
function showStarter(asked = false) {
  const text = starterText(page.run, beat.starter, beat.factors);
  if (asked || lawText().trim() === "" || lawText() === beat.generated) setLawText(text);
  beat.generated = text;
}

/** Sliders of a starter's gains, by how much they are changed, for axes that are held and those that move. */
function showGains() {
  const { parameters } = STARTERS[beat.starter];
  at("law-gains").replaceChildren();
  for (const held of [true, false]) {
    const axes = page.run.axes.filter((axis) => isHeld(page.run, axis) === held).join(", ");
    for (const name of Object.keys(parameters)) {
      const key = `${name} ${held}`;
      const show = slider(at("law-gains"), { id: `gain-${name}-${held}`, label: `${name} of ${axes}`, unit: "×", low: 0.2, high: 3, step: 0.05 }, (value) => {
        beat.factors[key] = value;
        show(value);
        showStarter(true);
      });
      show(beat.factors[key] ?? 1);
    }
  }
}

function chooseStarter() {
  const written = lawText().trim() !== "" && lawText() !== beat.generated;
  if (written && !confirm(`Replace what is written by the starter ${STARTERS[at("starter").value].label}?`)) {
    at("starter").value = beat.starter;
    return;
  }
  keepLaw("");
  Object.assign(beat, { starter: at("starter").value, factors: {} });
  showStarter(true);
  showGains();
  lawSaid("");
}

/** What depends on the stage: the task in words, the starters, what the thesis makes of it. */
function showTask() {
  const [axis] = drivenAxes(page.run);
  at("task").textContent = `Hold ${TASK.mass} kg that is put on, then make a step of ${1e3 * TASK.way} mm along ${axis}, better than the thesis's regulator does.`;
  showStarter();
  if (keptLaw() && lawText() === beat.generated) setLawText(keptLaw());
  showGains();
  askScores(page.run, false);
}

function buildBeat() {
  buildField();
  for (const [id, { label }] of Object.entries(STARTERS)) html("option", { value: id }, at("starter"), label);
  at("starter").addEventListener("change", chooseStarter);
  at("run-law").addEventListener("click", runLaw);
  at("law-gains").addEventListener("change", runLaw);   // a slider that is let go
  at("share-law").addEventListener("click", () => {
    if (own.packed && own.packed.length <= LONGEST_LINK) copy(location.href, "link with the law and its result");
    else lawSaid(own.packed ? `Too long for a link: ${own.packed.length} characters packed, at most ${LONGEST_LINK}.`
      : "Run it first: the link brings the law that runs, and its result.", true);
  });
  at("text").open = !PHONE.matches;
  PHONE.addEventListener("change", () => { at("text").open = !PHONE.matches; });
  at("text").addEventListener("toggle", () => { if (at("text").open) buildEditor(); });
  showResult();
}
