"use strict";
// What a reader can do with a plot: zoom, go to and fro, read values, save it.

/** Show another range of a panel, and of all that share its view, within what there is. */
function showRange(plot, p, low, high) {
  const view = plot.views[p];
  const { full } = view;
  const span = Math.min(Math.max(high - low, 1e-6 * (full.high - full.low)), full.high - full.low);
  view.low = Math.max(full.low, Math.min(low, full.high - span));
  view.high = view.low + span;
  plot.drawn = drawPanels(plot, p);
}

/** Zoom all panels by a factor around their middle, or move them by a share of what they show. */
function change(plot, factor, shift) {
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
  button("+", "zoom in", () => change(plot, 0.5, 0));
  button("−", "zoom out", () => change(plot, 2, 0));
  button("◂", "to the left", () => change(plot, 1, -0.25));
  button("▸", "to the right", () => change(plot, 1, 0.25));
  button("all", "show all", () => change(plot, Infinity, 0));
  button("save", "save this plot as SVG", () => save(plot));
}

/** Readout under the pointer, and zooming by dragging; a double click shows all. */
function handle(plot, p, picture, across, lines, height) {
  const place = plot.places[p];
  const cursor = svg("path", { style: "stroke: var(--faint); pointer-events: none" }, picture);
  const chosen = svg("rect", { y: PANEL.top, height, width: 0, style: "fill: var(--link); opacity: 0.2" }, picture);
  const readout = html("div", { class: "readout", hidden: "" }, place);
  let from = null;
  const at = (event) => {
    const box = picture.getBoundingClientRect();
    const px = (event.clientX - box.left) * picture.viewBox.baseVal.width / box.width - PANEL.left;
    return across.value(Math.min(Math.max(px, 0), across.place(across.high)));
  };
  const x = (value) => PANEL.left + across.place(value);
  picture.addEventListener("pointermove", (event) => {
    const here = at(event);
    cursor.setAttribute("d", `M${x(here).toFixed(1)} ${PANEL.top}v${height}`);
    if (from !== null) {
      chosen.setAttribute("x", Math.min(x(from), x(here)));
      chosen.setAttribute("width", Math.abs(x(here) - x(from)));
    }
    const panel = plot.panels[p];
    readout.replaceChildren();
    html("div", {}, readout, `${panel.xTitle}: ${shortNumber(here)}`);
    for (const line of lines) {
      const value = lineAt(line, here);
      if (value === null) continue;
      const row = html("div", {}, readout);
      swatch(row, line);
      row.append(`${line.name}: ${panel.format(value)}${line.note}`);
    }
    readout.hidden = false;
    readout.style.left = `${here > (across.low + across.high) / 2 ? PANEL.left + 8 : picture.clientWidth - readout.offsetWidth - 20}px`;
  });
  picture.addEventListener("pointerleave", () => {
    readout.hidden = true;
    cursor.setAttribute("d", "");
  });
  picture.addEventListener("pointerdown", (event) => {
    // On a touch screen dragging scrolls the page.
    if (event.pointerType === "touch" || event.button !== 0) return;
    from = at(event);
    picture.setPointerCapture(event.pointerId);
  });
  picture.addEventListener("pointerup", (event) => {
    const [start, end] = [from, at(event)];
    from = null;
    chosen.setAttribute("width", 0);
    if (start !== null && Math.abs(across.place(end) - across.place(start)) > 5) {
      showRange(plot, p, Math.min(start, end), Math.max(start, end));
    }
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
  const whole = svg("svg", { xmlns: SVG, width, height: pictures.length * (PANEL.height + 22), "font-family": "sans-serif", "font-size": 12 });
  svg("rect", { width: "100%", height: "100%", style: "fill: var(--paper)" }, whole);
  pictures.forEach((picture, p) => {
    const group = svg("g", { transform: `translate(0 ${p * (PANEL.height + 22)})`, style: "fill: var(--text)" }, whole);
    const { title, lines } = plot.panels[p];
    const label = svg("text", { x: PANEL.left, y: 14, "font-weight": "bold" }, group, title);
    for (const line of lines) svg("tspan", { dx: 14, "font-weight": "normal", style: `fill: var(--${line.css})` }, label, `— ${line.name}`);
    const copy = picture.cloneNode(true);
    copy.setAttribute("y", 22);
    copy.setAttribute("width", width);
    copy.setAttribute("height", PANEL.height);
    for (const line of copy.querySelectorAll(".line[style*=stroke]")) line.setAttribute("fill", "none");
    group.append(copy);
  });
  const style = getComputedStyle(document.documentElement);
  return new XMLSerializer().serializeToString(whole).replace(/var\((--[\w-]+)\)/g, (_, name) => style.getPropertyValue(name).trim());
}

function save(plot) {
  const link = html("a", { download: `${plot.element.dataset.figure}.svg`,
    href: URL.createObjectURL(new Blob([pictureText(plot)], { type: "image/svg+xml" })) });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}
