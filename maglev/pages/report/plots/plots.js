"use strict";
// Plots of the figures: the panels of the runs, drawn when they come near the view and released when they are far.
const RUN_DASHES = ["solid", "dash", "dashdotdot", "long"];   // references and limits have others
const MARKED = { reference: { css: "reference", dash: "dot" }, "bands of settling": { css: "reference", dash: "dot" }, "end stops": { css: "limit", dash: "dashdot" } };
const plots = {};     // plots that are drawn, by id of the figure
const drawing = {};   // promises of the same
const frictionless = new Set();   // ids of the figures that show their runs without friction, too
let onPaper = false;   // from before printing to after it, while nothing is forgotten

/** Points of sizes, from a floor on; between rows that differ by much, further points of the straight line. */
function logarithmicPoints({ times, values }, { scale, floor }) {
  const x = [];
  const y = [];
  const size = (value) => Math.max(scale * Math.abs(value), floor);
  for (let k = 0; k < times.length; k++) {
    if (k > 0) {
      const parts = Math.min(12, Math.ceil(Math.abs(Math.log(size(values[k]) / size(values[k - 1]))) / 0.4));
      const crossing = values[k] * values[k - 1] < 0 ? Math.max(parts, 4) : parts;
      for (let part = 1; part < crossing; part++) {
        x.push(times[k - 1] + (times[k] - times[k - 1]) * part / crossing);
        y.push(size(values[k - 1] + (values[k] - values[k - 1]) * part / crossing));
      }
    }
    x.push(times[k]);
    y.push(size(values[k]));
  }
  return { x, y };
}

/** Runs that a figure draws: its own and, where asked for, these without friction. */
function runsOf(id) {
  const { runs, without, chart } = report.figures[id];
  return !chart && without && frictionless.has(id) ? [...runs, ...without] : runs;
}

/** Panels of a chart, where asked for with its curves without friction. */
function chartOf(id) {
  const { chart, without } = report.figures[id];
  return !without || !frictionless.has(id) ? chart : chart.map((panel, p) => ({ ...panel, curves: [...panel.curves,
    ...(without[p]?.curves ?? []).map((curve) => ({ ...curve, label: `${curve.label}, without friction`,
      kin: `${curve.kin}, without friction` }))] }));
}

function drawnLine(line, panel) {
  const { scale, unit } = panel;
  const signal = ready[line.run][line.signal];
  const points = panel.floor ? logarithmicPoints(signal, panel)
    : { x: signal.times, y: signal.values.map((value) => scale * value) };
  return { ...line, ...points, unit, ascending: true,
    note: line.css === "reference" ? ` ${unit}` : ` ± ${Number((scale * signal.tolerance).toPrecision(2))} ${unit}` };
}

/** Ranges, across a panel, in which the data of the thesis's figure end. */
function panelAreas(figure, p) {
  const { scale } = figure.panels[p];
  return (figure.bounds ?? []).filter(({ panel }) => panel === p).map(({ low, high, met }) => ({
    low: scale * low, high: scale * high, area: true,
    css: met === null ? "none" : met ? "good" : "bad",
    name: `axis of the thesis's figure${met === null ? "" : met ? ": met" : ": not met"}`,
  }));
}

/** Values that the thesis states: at a time, or at a level between two times. */
function panelMarks(figure, p, end) {
  const { scale } = figure.panels[p];
  return (figure.marks ?? []).filter(({ panel }) => panel === p).map((mark) => ({
    name: mark.text, css: "thesis", dash: "dot", x: mark.time, low: mark.start, high: mark.end ?? end,
    value: mark.level === null ? null : scale * mark.level,
  }));
}

/** When a stop was touched or a controller tripped. */
const instantsOf = (runs) => runs.flatMap(({ name, label, css = "bad" }) => report.runs[name].events.map(({ time, text }) => ({
  x: time, css, dash: "dash", name: `${runs.length > 1 ? `${label} ` : ""}${text}` })));

function figurePanels(id) {
  const figure = report.figures[id];
  const runs = runsOf(id);
  const ends = runs.flatMap(({ name }) => Object.values(ready[name]).map(({ times }) => times.at(-1)));
  const windows = Object.values(Object.fromEntries(runs.flatMap(({ name }) => report.runs[name].windows)
    .map(([name, low, high]) => [`${name} ${low} ${high}`, { name, low, high, css: "open" }])));
  const instants = instantsOf(runs), names = runs.map(({ name }) => name);
  return figure.panels.map((panel, p) => ({
    title: panel.title, xTitle: "time (s)", low: 0,
    high: Math.max(...ends), logarithmic: panel.floor !== null && panel.unit,
    format: (value) => numberText(value, panel.digits),
    lines: panel.lines.filter(({ run, signal }) => names.includes(run) && ready[run][signal]).map((line) => drawnLine(line, panel)),
    levels: panel.levels, areas: panelAreas(figure, p), instants, windows, down: panel.down,
    marks: panelMarks(figure, p, Math.max(...ends)),
  }));
}

/** Plot of a figure whose runs are decoded. */
function plotOf(id) {
  const figure = report.figures[id], element = document.querySelector(`[data-figure="${id}"]`);
  plots[id] = figure.chart ? makePlot(element, chartPanels(chartOf(id)), [])
    : makePlot(element, figurePanels(id), runsOf(id).map(({ name }) => name), figure.view ?? (figure.until ? [0, figure.until] : null));
  return plots[id];
}

async function decodeAndDraw(id) {
  const element = document.querySelector(`[data-figure="${id}"]`);
  try {
    for (const { name } of runsOf(id)) {
      await decodeRun(name);
      await breath();
    }
    if (!drawing[id]) return;   // released meanwhile
    await (plots[id] ?? plotOf(id)).drawn;
    element.style.minHeight = `${element.offsetHeight}px`;   // so that nothing jumps when it is released
  } catch (error) {
    fail(error);
    element.textContent = `This plot could not be drawn: ${error.message}`;
  }
}

/** Draw a figure; a second call returns the same promise. Figures are drawn one after the other. */
let queue = Promise.resolve();
function draw(id) {
  drawing[id] ??= queue = queue.then(() => (drawing[id] ? decodeAndDraw(id) : undefined));
  return drawing[id];
}

/** Forget the plot of a figure that is far from the view. */
function release(id) {
  if (onPaper) return;
  delete drawing[id];
  if (!plots[id]) return;
  plots[id].gone = true;
  plots[id].element.replaceChildren();
  delete plots[id];
}

/** Show a figure's runs without friction too, or hide them, in the shown range of time, and the verdicts of claims. */
async function showFrictionless(id, shown) {
  const button = document.querySelector(`[data-switch="${id}"]`);
  if (!button) return;   // nothing of it was run without friction
  const figure = report.figures[id];
  button.setAttribute("aria-pressed", String(shown));
  frictionless[shown ? "add" : "delete"](id);
  for (const details of button.closest("figure").querySelectorAll("details.what-if")) details.open = shown;
  if (!drawing[id]) return;   // when it comes near the view
  await drawing[id];
  const view = figure.chart ? null : plots[id]?.views[0];
  if (view) figure.view = [view.low, view.high];
  if (plots[id]) plots[id].gone = true;
  delete plots[id];
  delete drawing[id];
  await draw(id);
}

/** Fill the legends of all plots: their runs, which a click hides; the first one also has the marks of panels. */
function fillLegend({ runs }) {
  for (const list of document.querySelectorAll("[data-legend]")) {
    runs.forEach(({ label: name, css }, r) => entry(list, { name, css, dash: RUN_DASHES[r % RUN_DASHES.length] },
      () => hide(hiddenInAll, name, document, Object.values(plots))));
  }
  for (const note of [...Object.entries(MARKED).map(([name, look]) => ({ name, ...look })), ...instantsOf(runs)]) entry(legendOfAll, note);
}
if (legendOfAll) Object.values(report.figures).slice(0, 1).forEach(fillLegend);
for (const button of document.querySelectorAll("[data-switch]")) {
  button.hidden = false;
  button.addEventListener("click", () => showFrictionless(button.dataset.switch, button.getAttribute("aria-pressed") !== "true"));
}
for (const link of document.querySelectorAll("a[data-without]")) {
  link.addEventListener("click", () => showFrictionless(link.dataset.without, true));
}

const near = new Set();   // ids of the figures in view or near it
const nearView = new IntersectionObserver((entries) => {
  for (const { isIntersecting, target: { dataset: { figure } } } of entries) {
    if (isIntersecting) {
      near.add(figure);
      draw(figure);
    } else {
      near.delete(figure);
      release(figure);
    }
  }
}, { rootMargin: "800px" });
for (const element of document.querySelectorAll("[data-figure]")) nearView.observe(element);

let width = window.innerWidth;
window.addEventListener("resize", () => {
  if (window.innerWidth === width) return;   // on a phone the height alone changes when the address bar hides
  width = window.innerWidth;
  for (const plot of Object.values(plots)) plot.drawn = drawPanels(plot);
});

/** Every run, decoded while nothing else is due: paper does not wait. */
async function decodeAll() {
  for (const name of Object.keys(report.runs)) {
    await decodeRun(name);
    await breath();
  }
}
const decoded = decodeAll().catch(fail);

/** Every panel of every figure whose runs are decoded, at once. */
function drawAll() {
  for (const id of Object.keys(report.figures)) {
    if (!runsOf(id).every(({ name }) => ready[name])) continue;
    const plot = plots[id] ?? plotOf(id);
    plot.places.forEach((place, p) => { if (onPaper || !place.querySelector(".panel-plot")) drawPanel(plot, p); });
  }
}
window.addEventListener("beforeprint", () => {   // however it is asked for
  onPaper = true;
  drawAll();
});
window.addEventListener("afterprint", () => {
  onPaper = false;
  for (const [id, plot] of Object.entries(plots)) {
    if (near.has(id)) plot.drawn = drawPanels(plot);
    else release(id);
  }
});

// For tests: draw everything, the drawn plots, and errors.
window.maglevReport = { drawAll: () => decoded.then(drawAll), errors, figures: report.figures, plots, ready };
