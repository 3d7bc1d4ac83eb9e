"use strict";
// The plots of a study; `report`, colours and axes are those of look.js.
const { columns, varied } = report;
const metrics = columns.slice(varied);
const withUnit = ({ name, unit }) => plain(unit ? `${name} (${unit})` : name);
const dark = matchMedia("(prefers-color-scheme: dark)");

/** Text that plotly shows as it is: plotly reads some tags. */
function plain(text) {
  return text.replace(/&/g, "&amp;").replace(/</g, "&lt;").replace(/>/g, "&gt;");
}

function draw2d(element, traces, height, change = {}) {
  const base = commonLayout(height);
  return Plotly.react(element, traces, { ...base, showlegend: false, xaxis: axisStyle(), yaxis: axisStyle(), ...change },
    CONFIGURATION);
}

function drawHistograms() {
  const place = document.getElementById("histograms");
  // All places first: a plot takes the width that it then has.
  while (place.children.length < metrics.length) place.append(Object.assign(document.createElement("div"), { className: "plot" }));
  metrics.forEach((column, i) => {
    const shapes = Object.values(column.limits).map((limit) => ({ type: "line", x0: limit, x1: limit, yref: "paper", y0: 0,
      y1: 1, line: { color: colour("bad"), width: 1.5, dash: "dash" } }));
    draw2d(place.children[i], [{ type: "histogram", x: column.values, nbinsx: 30, marker: { color: colour("run-0") },
      hovertemplate: "%{y} samples at %{x}<extra></extra>" }], 260,
    { shapes, xaxis: { ...axisStyle(), title: { text: withUnit(column), standoff: 6, font: { size: 12 } } },
      yaxis: { ...axisStyle(), title: { text: "samples" } }, bargap: 0.05 });
  });
}

/** Mean of a metric over a grid of two columns; null where there is no sample. */
function surface(x, y, z) {
  const xs = [...new Set(x)].sort((a, b) => a - b);
  const ys = [...new Set(y)].sort((a, b) => a - b);
  const sums = ys.map(() => xs.map(() => [0, 0]));
  z.forEach((value, i) => {
    if (value === null) return;
    const cell = sums[ys.indexOf(y[i])][xs.indexOf(x[i])];
    cell[0] += value;
    cell[1] += 1;
  });
  return { x: xs, y: ys, z: sums.map((row) => row.map(([sum, count]) => (count ? sum / count : null))) };
}

function drawResponse() {
  const chosen = (id) => columns[Number(document.getElementById(id).value)];
  const [metric, first, second] = [chosen("metric"), chosen("first"), chosen("second")];
  const axes = { xaxis: { ...axisStyle(), title: { text: withUnit(first) } },
    yaxis: { ...axisStyle(), title: { text: withUnit(first === second ? metric : second) } } };
  const colorbar = { title: { text: withUnit(metric), side: "right" }, thickness: 14 };
  const text = report.samples.map((sample, i) => `sample ${sample}: ${metric.values[i] ?? "none"}`);
  let trace;
  if (first === second) {
    trace = { type: "scatter", mode: "markers", x: first.values, y: metric.values, text, marker: { color: colour("run-0"),
      size: 6 }, hovertemplate: "%{text}<extra></extra>" };
  } else if (report.grid) {
    trace = { type: "heatmap", ...surface(first.values, second.values, metric.values), colorscale: "Viridis", colorbar,
      hovertemplate: "%{z:.4~g} at %{x:.4~g}, %{y:.4~g}<extra></extra>" };
  } else {
    trace = { type: "scatter", mode: "markers", x: first.values, y: second.values, text, hovertemplate: "%{text}<extra></extra>",
      marker: { color: metric.values.map((value) => value ?? undefined), colorscale: "Viridis", colorbar, showscale: true,
        size: 8, line: { width: 0.5, color: colour("faint") } } };
  }
  return draw2d(document.getElementById("response"), [trace], 480, axes);
}

const parallel = new Parallel(document.getElementById("parallel"), columns, report.passed, (names) => {
  const some = names && names.slice(0, 20).join(", ") + (names.length > 20 ? ", …" : "");
  document.getElementById("kept").textContent = names ? `${names.length} of ${report.samples.length} samples: ${some}` : "";
});

function drawSensitivity() {
  const element = document.getElementById("sensitivity");
  if (!element) return;
  const names = columns.slice(0, varied).map(({ name }) => name);
  const traces = names.flatMap((name, v) => [["first", 1], ["total", 0.45]].map(([kind, opacity]) => ({
    type: "bar", name: `${plain(name)}: ${kind}`, opacity, x: report.sensitivity.map(({ metric }) => plain(metric)),
    y: report.sensitivity.map((each) => each[kind][v]), marker: { color: colour(`run-${v % 5}`) },
    error_y: { type: "data", array: report.sensitivity.map((each) => each[`${kind}Error`][v]), color: colour("text"),
      thickness: 1, width: 2 } })));
  draw2d(element, traces, 420, { showlegend: true, barmode: "group", margin: { l: 60, r: 14, t: 30, b: 140 },
    xaxis: { ...axisStyle(), tickangle: -35 }, yaxis: { ...axisStyle(), title: { text: "Sobol index" } } });
}

function fill(id, from, to, chosen) {
  const select = document.getElementById(id);
  for (let i = from; i < to; i += 1) select.append(new Option(columns[i].name, i, i === chosen, i === chosen));
  select.addEventListener("change", drawResponse);
}

function drawStudy() {
  drawHistograms();
  if (metrics.length) drawResponse();
  parallel.draw();
  drawSensitivity();
}

fill("metric", varied, columns.length, columns.findIndex(({ name }, i) => i >= varied && name.startsWith("overshoot")));
fill("first", 0, varied, 0);
fill("second", 0, varied, Math.min(1, varied - 1));
for (const button of document.querySelectorAll("button.copy")) {
  button.addEventListener("click", async () => {
    await navigator.clipboard.writeText(button.previousElementSibling.textContent);
    button.textContent = "Copied";
  });
}
dark.addEventListener("change", drawStudy);
drawStudy();
