"use strict";
// Actions of a reader on a plot: zoom, move, read values, measure between two cursors, save it.
const NEAR_CURSOR = 10;   // px, in which a click takes one away

/** Show another range of a panel, and of all that share its view, within what there is. */
function showRange(plot, p, low, high) {
  plot.hold?.();
  const view = plot.views[p];
  const { full } = view;
  const span = Math.min(Math.max(high - low, 1e-6 * (full.high - full.low)), full.high - full.low);
  view.low = Math.max(full.low, Math.min(low, full.high - span));
  view.high = view.low + span;
  plot.drawn = drawPanels(plot, p);
}

/** Zoom all panels by a factor around their middle, or move them by a share of their range. */
function zoomAll(plot, factor, shift) {
  const done = new Set();
  plot.views.forEach((view, p) => {
    if (done.has(view)) return;
    done.add(view);
    const span = (view.high - view.low) * factor;
    const middle = (view.low + view.high) / 2 + shift * (view.high - view.low);
    showRange(plot, p, middle - span / 2, middle + span / 2);
  });
}

function tools(plot, parent) {
  const button = (sign, label, action) => {
    const made = html("button", { type: "button", "aria-label": label, title: label }, parent, sign);
    made.addEventListener("click", action);
  };
  button("+", "zoom in", () => zoomAll(plot, 0.5, 0));
  button("−", "zoom out", () => zoomAll(plot, 2, 0));
  button("◂", "to the left", () => zoomAll(plot, 1, -0.25));
  button("▸", "to the right", () => zoomAll(plot, 1, 0.25));
  button("all", "show all", () => zoomAll(plot, Infinity, 0));
  for (const [ending, made] of Object.entries(SAVED)) {
    button(ending.toUpperCase(), `save the view as ${ending.toUpperCase()}`, async () => {
      if (plot.hold?.()) await (plot.drawn = drawPanels(plot));
      save(plot, ending, await made(plot));
    });
  }
}

/** Draw the cursors of a panel, at an abscissa and where they are fixed; returns whether the first is seen. */
function drawCursors(plot, p, here) {
  const { across, cursor } = plot.handles[p], inside = (x) => x !== null && x >= across.low && x <= across.high;
  cursor.setAttribute("d", [here, ...plot.views[p].fixed].filter(inside)
    .map((x) => `M${(PANEL.left + across.place(x)).toFixed(1)} ${PANEL.top}v${PANEL.plot}`).join(""));
  return inside(here);
}

/** Show what a panel's lines are at an abscissa; the cursors alone where values are not asked for, nothing at null. */
function pointAt(plot, p, here, values) {
  if (!plot.handles[p]) return;   // not yet drawn
  const panel = plot.panels[p], { fixed } = plot.views[p], { lines, picture, readout } = plot.handles[p];
  readout.hidden = !drawCursors(plot, p, here) || !values;
  if (readout.hidden) return;
  const said = fillReadout(panel, lines, readout, here, fixed[0] === here ? undefined : fixed[0]);
  picture.setAttribute("aria-valuenow", here);
  picture.setAttribute("aria-valuetext", said.join("; "));
}

/** Fill a readout, which replaces the legend, with the values of lines at an abscissa, or their differences from a fixed
 * cursor; returns the words. */
function fillReadout(panel, lines, readout, here, since) {
  readout.replaceChildren();
  const { at = (x) => x } = panel, said = [`${panel.xTitle}: ${shortNumber(at(here))}${since === undefined ? "" : `, Δ ${shortNumber(at(here) - at(since))}`}`];
  html("div", {}, readout, said[0]);
  for (const line of lines) {
    const value = lineAt(line, here);
    if (value === null) continue;
    const row = html("div", {}, readout);
    swatch(row, line);
    const before = since === undefined ? null : lineAt(line, since);
    said.push(`${line.name}: ${panel.format(value)}${before === null ? line.note : ` ${line.unit}, Δ ${panel.format(value - before)}`}`);
    row.append(said.at(-1));
  }
  return said;
}

/** Point at an abscissa in a panel, in those that share its view, and in the other plots that are drawn of the same runs. */
function pointAll(plot, p, here) {
  plot.here = here;
  plot.views.forEach((view, q) => { if (view === plot.views[p]) pointAt(plot, q, here, true); });
  for (const other of Object.values(plots)) {
    if (other !== plot && other.runs.some((run) => plot.runs.includes(run))) other.panels.forEach((_, q) => pointAt(other, q, here, false));
  }
}

/** Fix a cursor at an abscissa: the first, the second, or the first of the next two; one that is near is taken away. */
function fix(plot, p, here) {
  const view = plot.views[p], near = plot.handles[p].across.value(NEAR_CURSOR) - view.low, at = view.fixed.findIndex((x) => Math.abs(x - here) < near);
  view.fixed = at >= 0 ? view.fixed.filter((_, k) => k !== at) : [...(view.fixed.length < 2 ? view.fixed : []), here];
  pointAll(plot, p, at >= 0 ? view.fixed.at(-1) ?? null : here);
}

/** Keys of a panel: arrows move the cursor, with shift by more, and Enter fixes it; plus and minus zoom about it, 0 shows all. */
function keys(plot, p, event) {
  const view = plot.views[p], span = view.high - view.low, here = plot.here ?? (view.low + view.high) / 2;
  const by = { ArrowLeft: -1, ArrowRight: 1, ArrowDown: -1, ArrowUp: 1 }[event.key];
  if (by) pointAll(plot, p, Math.min(Math.max(here + by * span / (event.shiftKey ? 10 : 100), view.low), view.high));
  else if (event.key === "Home" || event.key === "End") pointAll(plot, p, event.key === "Home" ? view.low : view.high);
  else if (event.key === "+" || event.key === "=") showRange(plot, p, here - span / 4, here + span / 4);
  else if (event.key === "-") showRange(plot, p, here - span, here + span);
  else if (event.key === "0") showRange(plot, p, view.full.low, view.full.high);
  else if (event.key === "Enter") fix(plot, p, here);
  else if (event.key === "Escape") {
    view.fixed = [];
    pointAll(plot, p, null);
  }
  else return;
  event.preventDefault();
}

/** Readout under the pointer or by keys, cursors by a click or tap, and zooming by dragging; a double click shows all. */
function handle(plot, p, picture, across, lines, height) {
  const place = plot.places[p];
  const cursor = svg("path", { class: "cursor", style: "stroke: var(--faint); pointer-events: none" }, picture);
  const chosen = svg("rect", { y: PANEL.top, height, width: 0, style: "fill: var(--link); opacity: 0.2" }, picture);
  let readout = place.querySelector(".readout");
  if (!readout) fillReadout(plot.panels[p], lines, readout = html("div", { class: "readout", hidden: "" }, place.querySelector(".told")), across.high, across.low);   // its room is kept
  plot.handles[p] = { across, lines, cursor, picture, readout };
  picture.setAttribute("aria-valuemin", across.low);
  picture.setAttribute("aria-valuemax", across.high);
  picture.setAttribute("aria-valuenow", (across.low + across.high) / 2);
  pointAt(plot, p, readout.hidden ? null : plot.here ?? null, true);   // the pointer was on it before it was redrawn
  let from = null;
  const at = (event) => {
    const box = picture.getBoundingClientRect();
    const px = (event.clientX - box.left) * picture.viewBox.baseVal.width / box.width - PANEL.left;
    return across.value(Math.min(Math.max(px, 0), across.place(across.high)));
  };
  const x = (value) => PANEL.left + across.place(value);
  picture.addEventListener("pointermove", (event) => {
    const here = at(event);
    if (from !== null && event.pointerType !== "touch") {
      chosen.setAttribute("x", Math.min(x(from), x(here)));
      chosen.setAttribute("width", Math.abs(x(here) - x(from)));
    }
    pointAll(plot, p, here);
  });
  const leave = () => pointAll(plot, p, plot.views[p].fixed.at(-1) ?? null);
  picture.addEventListener("pointerleave", (event) => { if (event.pointerType !== "touch") leave(); });
  picture.addEventListener("pointercancel", () => { from = null; leave(); });   // the finger scrolls the page
  picture.addEventListener("focus", () => { if (picture.matches(":focus-visible")) pointAll(plot, p, plot.here ?? (across.low + across.high) / 2); });
  picture.addEventListener("blur", () => { if (picture.isConnected) pointAll(plot, p, null); });
  picture.addEventListener("keydown", (event) => keys(plot, p, event));
  picture.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    from = at(event);
    picture.setPointerCapture(event.pointerId);
    pointAll(plot, p, from);
  });
  picture.addEventListener("pointerup", (event) => {
    const [start, end] = [from, at(event)];
    from = null;
    chosen.setAttribute("width", 0);
    if (start === null) return;
    if (Math.abs(across.place(end) - across.place(start)) < 5) fix(plot, p, end);
    else if (event.pointerType !== "touch") showRange(plot, p, Math.min(start, end), Math.max(start, end));
  });
  picture.addEventListener("dblclick", () => {
    const { full } = plot.views[p];
    showRange(plot, p, full.low, full.high);
  });
}

/** The plot as one SVG picture: colours and fonts written out, legends as text. */
function pictureText(plot) {
  const pictures = [...plot.element.querySelectorAll(".panel-plot")];
  const width = pictures[0].viewBox.baseVal.width;
  const heights = pictures.map((picture) => picture.viewBox.baseVal.height + 22);
  const top = (p) => heights.slice(0, p).reduce((sum, height) => sum + height, 0);
  const whole = svg("svg", { xmlns: SVG, width, height: top(heights.length), "font-family": "sans-serif", "font-size": 12 });
  svg("rect", { width: "100%", height: "100%", style: "fill: var(--paper)" }, whole);
  pictures.forEach((picture, p) => {
    const group = svg("g", { transform: `translate(0 ${top(p)})`, style: "fill: var(--text)" }, whole);
    const label = svg("text", { x: PANEL.left, y: 14, "font-weight": "bold" }, group, plot.panels[p].title);
    for (const line of shownLines(plot, p)) svg("tspan", { dx: 14, "font-weight": "normal", style: `fill: var(--${line.css})` }, label, `— ${line.name}`);
    const copy = picture.cloneNode(true);
    copy.setAttribute("y", 22);
    copy.setAttribute("width", width);
    copy.setAttribute("height", heights[p] - 22);
    for (const line of copy.querySelectorAll(".line[style*=stroke]")) line.setAttribute("fill", "none");
    group.append(copy);
  });
  const style = getComputedStyle(document.documentElement);
  return new XMLSerializer().serializeToString(whole).replace(/var\((--[\w-]+)\)/g, (_, name) => style.getPropertyValue(name).trim());
}

/** The plot as pixels, two to a px of the page. */
async function picturePixels(plot) {
  const image = new Image();
  image.src = URL.createObjectURL(new Blob([pictureText(plot)], { type: "image/svg+xml" }));
  await image.decode();
  const canvas = html("canvas", { width: 2 * image.width, height: 2 * image.height });
  canvas.getContext("2d").drawImage(image, 0, 0, canvas.width, canvas.height);
  URL.revokeObjectURL(image.src);
  return new Promise((resolve) => { canvas.toBlob(resolve); });
}

/** Points of the lines that are seen, a row each; no text is a formula of a spreadsheet. */
function pointsText(plot) {
  const text = (words) => `"${words.replace(/^[=+@\t\r-]/, "'$&").replaceAll('"', '""')}"`;
  const rows = plot.panels.flatMap(({ title, xTitle, logarithmic, at: value = (x) => x }, p) => shownLines(plot, p).flatMap(({ name, x, y }) => {
    const { low, high } = plot.views[p], start = [`${title}${logarithmic ? ` (${logarithmic})` : ""} over ${xTitle}`, name].map(text).join();
    return Array.from(x, (at, k) => (at >= low && at <= high && y[k] !== null ? `${start},${Number(value(at).toPrecision(12))},${Number(y[k].toPrecision(9))}\n` : ""));
  }));
  return `panel,line,x,y\n${rows.join("")}`;
}

const SAVED = { svg: (plot) => new Blob([pictureText(plot)], { type: "image/svg+xml" }), png: picturePixels,
  csv: (plot) => new Blob([pointsText(plot)], { type: "text/csv" }) };

function save(plot, ending, blob) {
  const link = html("a", { download: `${plot.element.dataset.figure}.${ending}`, href: URL.createObjectURL(blob) });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}
