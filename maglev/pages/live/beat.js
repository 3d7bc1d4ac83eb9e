"use strict";
// Beat the thesis: a task for the reader's law and for the thesis's regulator, and the results of each in numbers.

const TASK = { mass: 1, on: 1, way: 0.01, step: 4, until: 7 };   // kg that are put on, at s; m of the step, at s; s
const TIE = 0.05;                                                // share of the smaller value by which two differ and are as good
const PHONE = matchMedia("(max-width: 67.99rem)");               // where a law is changed by its gains

/** Results that the worker measures: in words, the unit, the number of units in one SI unit, and digits. */
const MEASURES = [["gap error under 1 kg", "mm", 1e3, 2], ["… back within 0.1 mm", "ms", 1e3, 0], ["10 mm step, within 0.1 mm", "ms", 1e3, 0],
  ["… overshoot", "mm", 1e3, 2], ["… gap error meanwhile", "mm", 1e3, 2], ["current ripple at rest", "mA", 1e3, 1]];

const beat = { asked: 0, yours: null, scores: {}, opponent: "thesis", best: null, sent: false, starter: "pid", factors: {}, generated: "" };

/** The thesis's regulator of a stage. */
const thesisOf = (run) => lawLike(run, "nonlinear") ?? run.fmus.controller.model;

/** Whom a law meets. At this task all others beat the first, and the last beats all others; those between are level. */
const OPPONENTS = [
  { id: "thesis", label: "the thesis", model: thesisOf },
  { id: "PID", label: "the PID", model: (run) => lawLike(run, "PID") },
  { id: "retuned", label: "the retuned regulator", model: (run) => `${RUNG}retuned ${run.plant}` },
  { id: "ADRC", label: "ADRC", model: (run) => `${RUNG}ADRC ${run.plant}` }];
const opponentsOf = (run) => OPPONENTS.filter(({ model }) => model(run));
const opponentOf = (run) => opponentsOf(run).find(({ id }) => id === beat.opponent) ?? OPPONENTS[0];
const FASTER = { held: 2, moved: 1.2 };   // times the thesis's poles are those of the regulator that is retuned

/** Gains of the thesis's regulator with poles a number of times as fast, as in maglev.linear.design: s⁵ − k2 s⁴ + (ω0²
 * − k1) s³ − (k2 ω0² + k5) s² − (k1 ω0² + k4) s − (k3 + 1). */
function retuned(run) {
  const start = { ...run.fmus.controller.start }, value = (name) => plannedValue(run, thesisOf(run), `controller.${name}`), square = value("omega0") ** 2;
  for (const axis of run.axes) {
    const [k1, k2, k3, k4, k5] = [1, 2, 3, 4, 5].map((k) => value(`${axis}.k${k}`)), factor = isHeld(run, axis) ? FASTER.held : FASTER.moved;
    const [a4, a3, a2, a1, a0] = [-k2, square - k1, -(k2 * square + k5), -(k1 * square + k4), -(k3 + 1)].map((each, i) => each * factor ** (i + 1));
    [square - a3, -a4, -(a0 + 1), -(a1 + (square - a3) * square), -(a2 - a4 * square)].forEach((gain, k) => { start[`${axis}.k${k + 1}`] = gain; });
  }
  return start;
}

/** Make the opponents of all stages that are no FMU: one has another's module and its own gains, one is a law. */
function makeOpponents() {
  live.laws = {};
  Object.assign(live.colours, { retuned: live.colours.scheduled, ADRC: live.colours.adaptive });   // of laws that are no opponents
  for (const run of Object.values(live.runs)) {
    const [faster, adrc] = OPPONENTS.slice(2).map(({ model }) => model(run)), thesis = thesisOf(run);
    Object.assign(run.laws, { [faster]: "retuned", [adrc]: "ADRC" });
    if (live.laws[adrc]) continue;
    live.laws[adrc] = starterText(run, ADRC);
    live.fmus[adrc] = { name: "ADRC", variables: [] };
    live.fmus[faster] = { ...live.fmus[thesis], start: retuned(live.runs[homeOf(run)]) };
    live.binaries[faster] = live.binaries[thesis];
  }
}

/** Return the actions of the task: messages to the worker, by their times. */
function taskActs(run, controller) {
  const [axis] = drivenAxes(run), row = restRow(run), payload = KNOBS.find(({ id }) => id === "payload");
  return [...run.axes.map((each) => ({ at: 0, type: "reference", axis: each, value: row.axes[each].position })),
    { at: TASK.on, type: "tune", values: knobSettings(payload, run, controller, TASK.mass), shown: true },
    { at: TASK.step, type: "reference", axis, value: row.axes[axis].position + TASK.way }];
}

/** Have the worker measure the law where it runs, and the opponents where they are not measured yet. */
function askScores(run, yours) {
  if (yours) Object.assign(beat, { yours: null, sent: false }); else Object.assign(beat, { scores: {}, yours: null, sent: false, best: keptBest() });
  const { on, step, until } = TASK, task = { axis: drivenAxes(run)[0], on, step, until };
  const models = [...(yours ? [["yours", LAW]] : []), ...opponentsOf(run).filter(({ id }) => !beat.scores[id]).map(({ id, model }) => [id, model(run)])];
  beat.due = new Map(models.map(([id, model]) => {
    post({ type: "scored", number: ++beat.asked, run: homeOf(run), model, settings: {}, acts: taskActs(run, model), task });
    return [beat.asked, id];
  }));
  showResult();
}

function scored({ number, values, lost }) {
  const id = beat.due?.get(number);
  if (!id) return;   // of a task before
  if (id === "yours") beat.yours = { values, lost }; else beat.scores[id] = { values, lost };
  keepBest();
  showResult();
  if (page.state.story === "beat") stateChanged();   // the result is in the link
}

const measured = (result, i) => {
  const [, unit, scale, digits] = MEASURES[i];
  if (result?.values[i] > TASK.until - TASK.step - 1e-3 && unit === "ms") return `not in ${TASK.until - TASK.step} s`;
  return !result ? "" : result.values.length ? `${(scale * result.values[i]).toFixed(digits)} ${unit}` : i ? "–" : `lost at ${result.lost.toFixed(2)} s`;
};

/** Of each measure −1 where the law is better, 1 where the opponent is, 0 where they are as good as each other: within TIE, or read the
 * same. None while one is not measured, or has lost the platform. */
function compared(yours, theirs) {
  if (!yours?.values.length || !theirs?.values.length) return [];
  return yours.values.map((ours, i) => {
    const value = theirs.values[i], alike = Math.max(ours, value) <= (1 + TIE) * Math.min(ours, value) || measured(yours, i) === measured(theirs, i);
    return alike ? 0 : Math.sign(ours - value);
  });
}

/** Return the number of measures in which a result is better than an opponent's, minus that in which it is worse. */
const ahead = (result, id) => -compared(result, beat.scores[id]).reduce((sum, each) => sum + each, 0);
const beats = (result, id) => ahead(result, id) > 0;

/** The best result for the stage outlives the page: that which beats most opponents, and is ahead of all by most. */
const bestPlace = () => `maglev best ${page.run.plant}`;
function keptBest() {
  try { return readResult(localStorage.getItem(bestPlace())); } catch { return null; }
}
function keepBest() {
  const { yours, best, sent } = beat, ids = opponentsOf(page.run).map(({ id }) => id);
  if (!yours?.values.length || sent || !ids.every((id) => beat.scores[id])) return;
  const worth = (result) => (result ? ids.reduce((sum, id) => sum + ahead(result, id) + (beats(result, id) ? 100 : 0), 0) : -Infinity);
  if (worth(yours) <= worth(best)) return;
  beat.best = yours;
  try { localStorage.setItem(bestPlace(), resultText(yours)); } catch { /* it is on the page alone */ }
}

function verdictText() {
  const { yours, sent } = beat, opponent = opponentOf(page.run), theirs = beat.scores[opponent.id];
  if (!yours || !theirs) return "";
  const signs = compared(yours, theirs), [better, alike, worse] = [-1, 0, 1].map((sign) => signs.filter((each) => each === sign).length);
  const parts = [better && `beats ${opponent.label} in ${better}`, alike && `is as good (within ${100 * TIE} %) in ${alike}`, worse && `is worse in ${worse}`];
  const how = signs.length ? `It ${parts.filter(Boolean).join(", ")} of ${MEASURES.length} measures.`
    : `It lost the platform after ${yours.lost.toFixed(2)} s.`;
  return sent ? `${how} The link says so: run it to check.` : how;
}

function showResult() {
  if (!page.run) return;
  const { yours, best } = beat, { id, model } = opponentOf(page.run), theirs = beat.scores[id], table = at("result"), signs = compared(yours, theirs);
  table.replaceChildren();
  html("caption", {}, table, verdictText());
  const head = html("tr", {}, html("thead", {}, table));
  for (const [text, colour] of [["less is better; bold: by over 5 %"], ...(best ? [["your best"]] : []), ["yours", "run-1"], [id, colourOf(page.run, model(page.run))]]) {
    const cell = html("th", { scope: "col" }, head, text);
    if (colour) cell.prepend(html("i", { class: "swatch", style: `background: var(--${colour})` }));
  }
  const body = html("tbody", {}, table);
  MEASURES.forEach(([name], i) => {
    const row = html("tr", {}, body);
    html("th", { scope: "row" }, row, name);
    if (best) html("td", {}, row, measured(best, i));
    html("td", { class: signs[i] < 0 ? "best" : "" }, row, measured(yours, i));
    html("td", { class: signs[i] > 0 ? "best" : "" }, row, measured(theirs, i));
  });
  choose("ladder", opponentsOf(page.run).map((each) => [each.id, [yours, best].some((result) => beats(result, each.id)) ? `${each.id} ✓` : each.id]), id);
}

/** Choose another opponent, and restart the task against it. */
function chooseOpponent(id) {
  beat.opponent = id;
  showTaskText();
  showResult();
  if (page.state.story === "beat") tellStory("beat");
}

function showTaskText() {
  const [axis] = drivenAxes(page.run), { label } = opponentOf(page.run);
  at("task").textContent = `Hold ${TASK.mass} kg that is put on, then make a step of ${1e3 * TASK.way} mm along ${axis}, better than ${label}.`;
}

/** The result as a link has it, and back: numbers in SI, or when it was lost. */
const resultText = ({ values, lost }) => (values.length ? values.map((value) => Number(value.toPrecision(4))).join() : `lost,${Number(lost.toPrecision(4))}`);
function readResult(text) {
  const parts = text.replace(/^lost,/, "").split(",").map(Number), good = parts.every((value) => Number.isFinite(value) && value >= 0);
  if (!good || parts.length !== (text.startsWith("lost,") ? 1 : MEASURES.length)) throw new Error(`result: expected ${MEASURES.length} numbers`);
  return text.startsWith("lost,") ? { values: [], lost: parts[0] } : { values: parts, lost: 0 };
}

/** Show the chosen starter in the editor; a text written by hand stays unless the starter is asked for. */
function showStarter(asked = false) {
  const text = starterText(page.run, STARTERS[beat.starter], beat.factors);
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

/** Show the parts that depend on the stage: the task in words, the starters, and the thesis's results. */
function showTask() {
  showTaskText();
  showStarter();
  if (keptLaw() && lawText() === beat.generated) setLawText(keptLaw());
  showGains();
  askScores(page.run, false);
}

function buildBeat() {
  buildField();
  at("ladder").addEventListener("change", () => chooseOpponent(at("ladder").value));
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
}
