"use strict";
// A plot as SVG: panels below each other, each with its legend, its axes, a readout under the pointer, and zooming.
const PANEL = { head: 28, plot: 132, left: 62, right: 12, top: 8, bottom: 36, between: 8, names: 14, paper: 690, half: 336 };   // px; below the last one, below others, above the first; widths on A4, alone and of two

const SYMBOLS = {
  circle: "M-3.5 0a3.5 3.5 0 1 0 7 0a3.5 3.5 0 1 0 -7 0", square: "M-3 -3h6v6h-6z", diamond: "M0 -4.5l4.5 4.5l-4.5 4.5l-4.5 -4.5z",
  cross: "M-4 -1h3v-3h2v3h3v2h-3v3h-2v-3h-3z",
};
const DASHES = { solid: "none", dash: "7 4", dot: "1.5 3", dashdot: "8 3 1.5 3", dashdotdot: "6 2 1.5 2 1.5 2", long: "14 3" };

/** Lets the browser do what is due: no task grows long. */
function breath() {
  return new Promise((resolve) => { setTimeout(resolve, 0); });
}

/** Outline of the band about a line in px; where line or margin has no value, it has a gap. */
function bandPath({ x, y, margin }, across, up) {
  const parts = [];
  let [upper, lower] = [[], []];
  const close = () => {
    if (upper.length > 1) parts.push(`M${[...upper, ...lower.reverse()].join("L")}Z`);
    [upper, lower] = [[], []];
  };
  x.forEach((at, k) => {
    if (y[k] === null || margin[k] === null) {
      close();
      return;
    }
    upper.push(`${across.place(at).toFixed(1)} ${up.place(y[k] + margin[k]).toFixed(1)}`);
    lower.push(`${across.place(at).toFixed(1)} ${up.place(y[k] - margin[k]).toFixed(1)}`);
  });
  close();
  return parts.join("");
}

/** Value of a line at an abscissa: between its points, or that of the nearest mark; null outside. */
function lineAt({ x, y, ascending, marked }, at) {
  if (!x.length) return null;
  if (!ascending || marked) {
    let best = 0;
    for (let k = 1; k < x.length; k++) if (Math.abs(x[k] - at) < Math.abs(x[best] - at)) best = k;
    return y[best];
  }
  const k = firstFrom(x, at);
  if (k === 0) return x[0] === at ? y[0] : null;
  if (k === x.length || y[k] === null || y[k - 1] === null) return null;
  return y[k - 1] + (y[k] - y[k - 1]) * (at - x[k - 1]) / (x[k] - x[k - 1]);
}

/** Draw along a path in the colour and with the dashes of a line. */
function stroke(parent, kind, { name, css, dash = "solid" }, d, width) {
  return svg("path", { class: kind, "data-name": name, d,
    style: `stroke: var(--${css}); stroke-width: ${width}; stroke-dasharray: ${DASHES[dash]}` }, parent);
}

/** A sample of a line for the legend. */
function swatch(parent, { css, dash, marked, symbol }) {
  const picture = svg("svg", { width: 22, height: 10, "aria-hidden": "true" }, parent);
  if (marked) svg("path", { d: SYMBOLS[symbol], transform: "translate(11 5)", style: `fill: var(--${css})` }, picture);
  else svg("path", { d: "M1 5h20", style: `stroke: var(--${css}); stroke-width: 2.5; stroke-dasharray: ${DASHES[dash]}` }, picture);
}

/** Add an entry of a legend: a line, which a click hides, or a mark. */
function entry(list, line, hides = null, shown = true) {
  const made = html(hides ? "button" : "span", { ...(hides && { type: "button", "aria-pressed": String(shown) }), "data-name": line.name }, list);
  if (line.area) html("i", { class: "area", style: `background: var(--${line.css})` }, made);
  else swatch(made, line);
  made.append(line.name);
  if (hides) made.addEventListener("click", hides);
}

const legendOfAll = document.getElementById("legend");   // of all plots of a page, where there is one
const hiddenInAll = new Set();

/** Show or hide the lines of a name in plots whose legend is in a place. */
function hide(hidden, name, place, shown) {
  if (!hidden.delete(name)) hidden.add(name);
  for (const each of place.querySelectorAll(".legend button")) each.setAttribute("aria-pressed", String(!hidden.has(each.dataset.name)));
  for (const plot of shown) plot.drawn = drawPanels(plot);
}

function legend(plot, panel, parent) {
  const list = html("div", { class: "legend" }, parent), told = [...(legendOfAll?.children ?? [])].map(({ dataset }) => dataset.name);
  for (const [name, line] of new Map(panel.lines.map((each) => [each.of ?? each.name, each]))) {
    if (!told.includes(name)) entry(list, { ...line, name }, () => hide(plot.hidden, name, plot.element, [plot]), !plot.hidden.has(name));
  }
  const notes = new Map([...panel.areas, ...panel.levels, ...panel.instants, ...panel.marks].map((each) => [each.name, each]));
  for (const note of notes.values()) if (!told.includes(note.name)) entry(list, note);
}

const GRID = "stroke: var(--line); stroke-width: 1";
const LABEL = 13;   // px that a label on an axis takes

/** Grid over the abscissa, into a place for it, and its labels; of panels with one time the last one alone has these. */
function drawAcross(place, panel, across, width, height, last) {
  const most = Math.max(3, Math.floor(width / 80));
  const ticks = (panel.ticks?.(across, most) ?? across.ticks(most)).map(([value, text]) => [(PANEL.left + across.place(value)).toFixed(1), text]);
  place.replaceChildren();
  svg("path", { d: ticks.map(([x]) => `M${x} ${PANEL.top}v${height}`).join(""), style: GRID }, place);
  if (last) for (const [x, text] of ticks) svg("text", { x, y: PANEL.top + height + 14, "text-anchor": "middle" }, place, text);
}

/** Frame, grid and labels of a panel. */
function axes(picture, panel, across, up, width, height, last) {
  const ticks = up.ticks(5), every = Math.ceil(LABEL * ticks.length / height);
  for (const [value, text] of ticks.filter((_, k) => k % every === 0)) {
    const y = up.place(value);
    svg("path", { d: `M${PANEL.left} ${y.toFixed(1)}h${width}`, style: GRID }, picture);
    svg("text", { x: PANEL.left - 6, y: y + 4, "text-anchor": "end" }, picture, text);
  }
  drawAcross(svg("g", { class: "across" }, picture), panel, across, width, height, last);
  if (last) svg("text", { x: PANEL.left + width / 2, y: PANEL.top + height + 29, "text-anchor": "middle" }, picture, panel.xTitle);
  svg("rect", { x: PANEL.left, y: PANEL.top, width, height, style: "fill: none; stroke: var(--faint)" }, picture);
}

/** Bands for the windows of a scenario's events; returns where their names begin, of those that have room before the next. */
function drawWindows(inner, windows, across, width, height) {
  const names = [];
  let free = width;   // px, from the last window to the first
  for (const { name, low, high, css } of [...windows].sort((one, other) => other.low - one.low)) {
    const [from, to] = [Math.max(0, across.place(low)), Math.min(width, across.place(high))];
    if (to <= from) continue;
    svg("rect", { class: "window", x: from, width: to - from, y: PANEL.top, height, style: `fill: var(--${css}); opacity: 0.09` }, inner);
    if (across.place(low) >= 0) svg("path", { d: `M${from} ${PANEL.top}v${height}`, style: `stroke: var(--${css}); stroke-width: 1` }, inner);
    if (free - from > 6.5 * name.length + 6) names.unshift({ x: from, text: name });
    free = from;
  }
  return names;
}

/** Room of a plot's panel for the names of events, px: above the first one, where they cover nothing. */
const named = ({ panels }, p) => (p === 0 && panels[p].windows.length ? PANEL.names : 0);

/** Height of a panel's picture below those, px. */
const tall = (last) => PANEL.top + PANEL.plot + (last ? PANEL.bottom : PANEL.between);

/** Lines of a panel that are not hidden. */
const shownLines = ({ panels, hidden }, p) => panels[p].lines.filter(({ of, name }) => !hidden.has(of ?? name));

/** Draw one panel of a plot into its place; its legend once, its picture again each time. */
function drawPanel(plot, p) {
  const [panel, place, view] = [plot.panels[p], plot.places[p], plot.views[p]];
  const whole = Math.max(240, Math.min(plot.element.clientWidth, onPaper ? (plot.panels.length > 1 ? PANEL.half : PANEL.paper) : Infinity));   // letters are as large on paper
  const [width, height] = [whole - PANEL.left - PANEL.right, PANEL.plot];
  const last = !plot.runs.length || onPaper || p === plot.panels.length - 1;
  const lines = shownLines(plot, p);
  const limits = [...[...panel.levels, ...panel.marks].map(({ value }) => value).filter((value) => value !== null), ...panel.areas.flatMap(({ low, high }) => [low, high])];
  const across = scaleOf(view.low, view.high, 0, width, false);
  const ends = [PANEL.top + height, PANEL.top];
  const up = scaleOf(...panel.range?.(view) ?? fitted(lines, limits, view.low, view.high, panel.logarithmic), ...(panel.down ? ends.reverse() : ends),
    panel.logarithmic);
  if (!place.firstChild) {
    const head = html("div", { class: "panel-head" }, place);
    html("strong", {}, head, panel.title);
    legend(plot, panel, html("div", { class: "told" }, head));
  }
  const above = named(plot, p);
  const picture = svg("svg", { viewBox: `0 ${-above} ${whole} ${tall(last) + above}`, class: "panel-plot", role: "slider", tabindex: 0,
    "aria-label": `${panel.title} over ${panel.xTitle}: ${lines.map(({ name }) => name).join(", ")}` });
  axes(picture, panel, across, up, width, height, last);
  // An inner picture cuts off what is outside.
  const inner = svg("svg", { x: PANEL.left, y: PANEL.top, width, height,
    viewBox: `0 ${PANEL.top} ${width} ${height}` }, picture);
  const names = drawWindows(inner, panel.windows, across, width, height);
  if (above) for (const { x, text } of names) svg("text", { class: "window-name", x: PANEL.left + x, y: 2 }, picture, text);
  for (const { low, high, css } of panel.areas) {
    const [top, bottom] = [up.place(high), up.place(low)].sort((a, b) => a - b);
    svg("rect", { class: "bound", x: 0, width, y: top, height: Math.max(1, bottom - top), style: `fill: var(--${css}); opacity: 0.18` }, inner);
  }
  const upright = (x) => `M${across.place(x).toFixed(1)} ${PANEL.top}v${height}`;
  for (const level of panel.levels) stroke(inner, "level", level, `M0 ${up.place(level.value).toFixed(1)}h${width}`, 1.2);
  for (const instant of panel.instants) stroke(inner, "instant", instant, upright(instant.x), 1.5);
  // A line out of sight leaves the legend, where its place stays free: nothing jumps.
  const sight = [...panel.areas.map(({ name, low, high }) => [name, high >= up.low && low <= up.high]),
    ...panel.levels.map(({ name, value }) => [name, value >= up.low && value <= up.high]),
    ...panel.instants.map(({ name, x }) => [name, x >= view.low && x <= view.high]),
    ...panel.marks.map(({ name, x, value, low, high }) => [name, value === null ? x >= view.low && x <= view.high
      : high >= view.low && low <= view.high && value >= up.low && value <= up.high])];
  const seen = new Set(sight.filter(([, inside]) => inside).map(([name]) => name));
  for (const note of place.querySelectorAll(".legend span")) note.style.visibility = seen.has(note.dataset.name) ? "" : "hidden";
  for (const mark of panel.marks) {
    const d = mark.value === null ? upright(mark.x)
      : `M${across.place(mark.low).toFixed(1)} ${up.place(mark.value).toFixed(1)}H${across.place(mark.high).toFixed(1)}`;
    svg("title", {}, stroke(inner, "mark", mark, d, 2), mark.name);
  }
  for (const line of plot.rolling ? [] : lines) {
    if (line.margin) {
      svg("path", { class: "band", "data-name": line.name, d: bandPath(line, across, up), style: `fill: var(--${line.css}); opacity: 0.18` }, inner);
    }
    if (line.marked) {
      const marks = line.x.map((x, k) => (line.y[k] === null ? ""
        : SYMBOLS[line.symbol].replace(/^M(\S+) (\S+?)(?=[a-z])/, (_, dx, dy) =>
          `M${(across.place(x) + Number(dx)).toFixed(1)} ${(up.place(line.y[k]) + Number(dy)).toFixed(1)}`)));
      svg("path", { class: "line", "data-name": line.name, d: marks.join(""), style: `fill: var(--${line.css})` }, inner);
    } else stroke(inner, "line", line, linePath(line, across, up, width), line.thin ? 0.7 : 1.5);
  }
  const former = place.querySelector(".panel-plot"), focused = former && former === document.activeElement;
  if (former) former.replaceWith(picture);
  else place.append(picture);
  handle(plot, p, picture, across, lines, height);
  if (focused) picture.focus({ preventScroll: true });
}

/** Draw panels: those in the window at once, so that a step of zooming is seen in one frame; the others after a breath.
 * */
async function drawPanels(plot, only = null) {
  plot.turn += 1;
  const { turn } = plot;
  const due = plot.panels.map((_, p) => p).filter((p) => only === null || plot.views[p] === plot.views[only]);
  const seen = due.filter((p) => {
    const { top, bottom } = plot.places[p].getBoundingClientRect();
    return plot.places[p].querySelector(".panel-plot") && bottom > 0 && top < innerHeight;
  });
  for (const p of seen) drawPanel(plot, p);
  for (const p of due) {
    if (seen.includes(p)) continue;
    drawPanel(plot, p);
    await breath();
    // Of panels that share their view, the latest request draws all.
    if (plot.gone || (plot.runs.length && turn !== plot.turn)) return;
  }
}

/** Make a plot in an element; returns it with `drawn`, a promise. Panels over the time of runs, by name, share their view. */
function makePlot(element, panels, runs, range = null) {
  const linked = runs.length > 0;
  const everything = { low: Math.min(...panels.map(({ low }) => low)), high: Math.max(...panels.map(({ high }) => high)) };
  const shared = { ...everything, ...(range ? { low: range[0], high: range[1] } : {}), full: everything, fixed: [] };
  const views = panels.map(({ low, high }) => (linked ? shared : { low, high, full: { low, high }, fixed: [] }));
  element.replaceChildren();
  const plot = { element, panels, views, runs, hidden: legendOfAll ? hiddenInAll : new Set(), gone: false, turn: 0, handles: [] };
  tools(plot, html("div", { class: "tools", role: "group", "aria-label": "Zoom" }, element));
  plot.places = panels.map((_, p) => html("div", { class: "panel",
    style: `min-height: ${tall(!linked || p === panels.length - 1) + named(plot, p) + PANEL.head}px` }, element));
  plot.drawn = drawPanels(plot);
  return plot;
}
