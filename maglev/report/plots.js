"use strict";
// Plots of the figures, drawn when they come into view.
const PANELS = {
  position: { unit: "mm", scale: 1e3, format: ".4f" }, speed: { unit: "mm/s", scale: 1e3, format: ".2f" },
  error: { unit: "mm", scale: 1e3, format: ".4f" }, commands: { unit: "A", scale: 1, format: ".3f" },
  currents: { unit: "A", scale: 1, format: ".3f" },
};
const SMALLEST_ERROR = 1e-4;   // mm, lower end of logarithmic axes
const LENGTHS = [[1e-4, "0.1 µm"], [1e-3, "1 µm"], [1e-2, "10 µm"], [0.1, "0.1 mm"], [1, "1 mm"], [10, "10 mm"],
  [100, "100 mm"]];
const STRIP = 30;   // px, above the legend, for the buttons
// Named one by one: others would send the plot to a server.
const BUTTONS = ["zoom2d", "pan2d", "zoomIn2d", "zoomOut2d", "resetScale2d", "toImage"];
const CONFIGURATION = { responsive: true, displaylogo: false, plotlyServerURL: "", modeBarButtons: [BUTTONS] };
const DASHES = ["solid", "dash", "dot", "dashdot"];
const drawing = {};   // promises of the figures that are drawn or about to be, by id

function colour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}

function coarsePointer() {
  return window.matchMedia("(pointer: coarse)").matches;
}

/** Points of |error| in mm; between rows that differ by much, further points of the straight line. */
function logarithmicPoints({ times, values }) {
  const x = [];
  const y = [];
  const size = (value) => Math.max(1e3 * Math.abs(value), SMALLEST_ERROR);
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

/** Lines that a panel draws: signal, legend, colour, dash. */
function panelLines(figure, panel) {
  const lines = [];
  const { kind, of } = panel;
  if (kind === "commands" || kind === "currents") {
    figure.runs.forEach(({ name, label }, r) => {
      (report.runs[name].motors[of]?.[kind] ?? []).forEach((signal, s) => {
        const short = signal.split(".").pop().replace("_cmd", "");
        const text = figure.runs.length > 1 ? `${short} ${label}` : short;
        const hue = kind === "currents" ? s % 3 : 3 + s % 2;
        lines.push({ run: name, signal, text, colour: `series-${hue}`, dash: DASHES[r % 4] });
      });
    });
    return lines;
  }
  if (kind === "position") {
    // The reference once, of the run that was recorded longest.
    const longest = figure.runs.map(({ name }) => ({ name, signal: report.runs[name].axes[of]?.reference }))
      .filter(({ name, signal }) => ready[name][signal])
      .sort((a, b) => ready[b.name][b.signal].times.at(-1) - ready[a.name][a.signal].times.at(-1))[0];
    if (longest) lines.push({ run: longest.name, ...longest, text: "reference", colour: "reference", dash: "dot" });
  }
  figure.runs.forEach(({ name, label }, r) => {
    const signal = report.runs[name].axes[of]?.[kind];
    if (signal) lines.push({ run: name, signal, text: label, colour: `series-${r % 4}`, dash: "solid" });
  });
  return lines;
}

function traces(figure) {
  const inLegend = new Set();
  return figure.panels.flatMap((panel, p) => panelLines(figure, panel).flatMap((line) => {
    const signal = ready[line.run][line.signal];
    if (!signal) return [];
    const { scale, unit, format } = PANELS[panel.kind];
    const points = panel.kind === "error" ? logarithmicPoints(signal)
      : { x: Array.from(signal.times), y: Array.from(signal.values, (value) => scale * value) };
    const first = !inLegend.has(line.text);
    inLegend.add(line.text);
    const within = `${Number((scale * signal.tolerance).toPrecision(2))} ${unit}`;
    return [{
      ...points, type: "scatter", mode: "lines", name: line.text, legendgroup: line.text, showlegend: first,
      yaxis: p === 0 ? "y" : `y${p + 1}`, line: { color: colour(line.colour), width: 1.5, dash: line.dash, simplify: false },
      hovertemplate: `%{y:${format}} ${unit} at %{x:.4f} s (± ${within})<extra>${line.text}</extra>`,
    }];
  }));
}

/** Ranges, across a panel, in which the data of the thesis's figure end; in the legend once for each outcome. */
function boundTraces(figure) {
  const end = Math.max(...figure.runs.flatMap(({ name }) => Object.values(ready[name]).map(({ times }) => times.at(-1))));
  const inLegend = new Set();
  return (figure.bounds ?? []).map(({ panel, low, high, met }) => {
    const { scale } = PANELS[figure.panels[panel].kind];
    const hue = colour(met === null ? "none" : met ? "good" : "bad");
    const text = `axis of the thesis's figure${met === null ? "" : met ? ": met" : ": not met"}`;
    const first = !inLegend.has(text);
    inLegend.add(text);
    return {
      x: [0, end, end, 0, 0], y: [low, low, high, high, low].map((value) => scale * value), type: "scatter", mode: "lines",
      fill: "toself", opacity: 0.18, line: { color: hue, width: 1 }, fillcolor: hue, hoverinfo: "skip", name: text,
      legendgroup: text, showlegend: first, yaxis: panel === 0 ? "y" : `y${panel + 1}`,
    };
  });
}

function yAxisTitle({ kind, of }) {
  const what = { position: of, speed: `speed of ${of}`, error: `|error| of ${of}`, commands: `${of} commands`,
    currents: `${of} currents` }[kind];
  return kind === "error" ? what : `${what} (${PANELS[kind].unit})`;
}

function axisStyle() {
  return { gridcolor: colour("line"), zerolinecolor: colour("line"), linecolor: colour("faint"), automargin: true };
}

/** What every plot looks like. */
function commonLayout(height) {
  return {
    paper_bgcolor: colour("paper"), plot_bgcolor: colour("paper"), font: { color: colour("text"), size: 12 },
    margin: { l: 60, r: 14, t: STRIP, b: 40 }, hovermode: "closest", uirevision: "kept",
    dragmode: coarsePointer() ? false : "zoom",   // on a touch screen dragging scrolls the page
    // Below the strip of buttons; it pushes the panels down by as many lines as it needs.
    legend: { orientation: "h", x: 0, xanchor: "left", yref: "container", y: 1 - STRIP / height, yanchor: "top",
      bgcolor: "rgba(0,0,0,0)" },
    modebar: { bgcolor: "rgba(0,0,0,0)", color: colour("faint"), activecolor: colour("text") },
    hoverlabel: { namelength: -1 },
  };
}

function layout(figure, height) {
  const count = figure.panels.length;
  const axis = axisStyle();
  const result = {
    ...commonLayout(height),
    // One time axis below all panels: they zoom together.
    xaxis: { ...axis, title: { text: "time (s)" }, anchor: count === 1 ? "y" : `y${count}`,
      ...(figure.until ? { range: [0, figure.until] } : {}) },
    shapes: [],
  };
  figure.panels.forEach((panel, p) => {
    const top = 1 - p / count;
    const space = count === 1 ? 0 : 0.18 / count;
    const id = p === 0 ? "" : String(p + 1);
    const logarithmic = panel.kind === "error"
      ? { type: "log", tickvals: LENGTHS.map(([mm]) => mm), ticktext: LENGTHS.map(([, text]) => text),
        minallowed: Math.log10(SMALLEST_ERROR) } : {};
    result[`yaxis${id}`] = { ...axis, ...logarithmic, domain: [top - 1 / count + (p === count - 1 ? 0 : space), top],
      title: { text: yAxisTitle(panel), font: { size: 11 }, standoff: 10 } };
    if (panel.kind === "error") {
      for (const band of report.runs[figure.runs[0].name].bands) {
        result.shapes.push({ type: "line", xref: "paper", x0: 0, x1: 1, yref: `y${id}`, y0: 1e3 * band, y1: 1e3 * band,
          line: { color: colour("reference"), width: 1, dash: "dot", simplify: false } });
      }
    }
  });
  figure.runs.forEach(({ name }, r) => {
    for (const { time } of report.runs[name].events) {
      result.shapes.push({ type: "line", x0: time, x1: time, yref: "paper", y0: 0, y1: 1,
        line: { color: colour(`series-${r % 4}`), width: 1.5, dash: "dash", simplify: false } });
    }
  });
  return result;
}

/** Draw or redraw a figure whose runs are decoded. */
function drawNow(id) {
  const element = document.querySelector(`[data-figure="${id}"]`);
  const figure = report.figures[id];
  const height = element.clientHeight;
  return figure.chart ? Plotly.react(element, chartTraces(figure.chart), chartLayout(figure.chart, height), CONFIGURATION)
    : Plotly.react(element, [...boundTraces(figure), ...traces(figure)], layout(figure, height), CONFIGURATION);
}

async function decodeAndDraw(id) {
  try {
    await Promise.all(report.figures[id].runs.map(({ name }) => decodeRun(name)));
    await drawNow(id);
  } catch (error) {
    fail(error);
    document.querySelector(`[data-figure="${id}"]`).textContent = `This plot could not be drawn: ${error.message}`;
  }
}

/** Draw a figure; a second call returns the same promise. */
function draw(id) {
  drawing[id] ??= decodeAndDraw(id);
  return drawing[id];
}

async function drawAll() {
  for (const id of Object.keys(report.figures)) await draw(id);
}

function redraw() {
  for (const id of Object.keys(drawing)) drawing[id] = drawing[id].then(() => drawNow(id)).catch(fail);
}

const inView = new IntersectionObserver((entries) => {
  for (const { isIntersecting, target } of entries) {
    if (isIntersecting) {
      inView.unobserve(target);
      draw(target.dataset.figure);
    }
  }
}, { rootMargin: "300px" });
for (const element of document.querySelectorAll("[data-figure]")) inView.observe(element);

window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);

// For tests: draw everything, and what went wrong.
window.maglevReport = { drawAll, errors };
