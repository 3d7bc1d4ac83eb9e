"use strict";
// Plots below the stage, made like those of the report. The run scrolls through them until a hand holds them. Lines
// stay on their canvases, which are moved: only new values are drawn.

const LARGEST_ERROR = 0.1;   // m, rad
// px: heights of a panel, and of the space around all and around each
const TALL = { phone: 46, least: 56, most: 120, around: 640, each: 30 };
Object.assign(PANEL, { head: 20, top: 6, between: 6 });
const plots = {};            // as the report has them; here there is one, `live`
let onPaper = false;

const windowFor = (speed) => (speed < 0.5 ? 2 : speed > 2 ? 30 : 10);   // s shown

/** Panels of a run's plots. Lines of one controller have the colours of the axes; of two, the models, those of the controllers, and
 * errors of the gap are apart. */
function panelsOf(run, values, span, models = null) {
  const kinds = [[run.vertical], run.axes.filter((axis) => axis !== run.vertical)];
  const strips = !models ? run.stage.strips : run.stage.strips.flatMap((strip) => (strip.kind !== "error" ? [strip]
    : kinds.map((axes) => ({ ...strip, axes, title: strip.title.replace("axes", axes.join(", ")) }))));
  return strips.map((strip) => {
    const { lines, low, high, tens, ...rest } = STRIPS[strip.kind](run, strip, values);
    const made = (line) => ({ thin: Boolean(models && line.further), of: line.name, note: ` ${line.unit ?? strip.unit}`, unit: strip.unit, dash: "solid", ascending: true, whose: 0, x: [], y: [], ...line });
    const panel = { title: strip.title, xTitle: "time (s)", low: 0, high: span, logarithmic: false, down: strip.down, levels: [], areas: [], instants: [],
      windows: [], marks: [], format: (value) => numberText(value, strip.digits), ...rest,
      lines: lines.flatMap((line) => (!models || line.of === "reference" ? [made(line)] : models.map((model, whose) => made({ ...line, whose,
        name: `${line.name} ${lawOf(run, model)}`, of: lawOf(run, model), css: colourOf(run, model), dash: whose ? "dash" : "solid" })))) };
    // A closer view has the range that it needs.
    panel.range = (view) => (view.high - view.low < 0.99 * span ? undefined : tens ? widened(panel, tens, high, view.low) : [low, high]);
    return panel;
  });
}

/** Limits of a panel that follow its lines from a time (s) on, by whole tens. */
function widened({ lines }, tens, most, since) {
  let largest = tens;
  for (const { x, y } of lines) for (let k = firstFrom(x, since); k < y.length; k++) largest = Math.max(largest, Math.abs(y[k]));
  const high = Math.min(most, tens * Math.ceil(1.05 * largest / tens));
  return [-high, high];
}

const around = (value, name, css, dash) => [-value, value].map((each) => ({ value: each, name, css, dash }));

const STRIPS = {
  position(run, { axes, scale, down, unit }, values) {
    const lines = axes.flatMap((axis, k) => {
      const i = run.axes.indexOf(axis);
      return [{ name: axes.length > 1 ? `reference of ${axis}` : "reference", of: "reference", css: "reference", dash: "dot", thin: true,
        value: (h, r) => scale * h.at(r, columnOf.reference(i)) },
      { name: axis, css: `axis-${i}`, further: k > 0, value: (h, r) => scale * h.at(r, columnOf.position(i)) }];
    });
    const ends = axes.flatMap((axis) => endsOf(run, axis, values).map((end) => scale * end));
    if (!down) return { lines, high: Math.max(...ends), tens: unit === "mm" ? 10 : 4 };
    return { lines, low: ends[0] - 1, high: ends[1] + 1, levels: ends.map((value) => ({ value, name: "end stops", css: "limit", dash: "dashdot" })) };
  },
  error(run, { axes, scale, floor, unit }) {
    const lines = axes.map((axis, k) => {
      const i = run.axes.indexOf(axis);
      return { name: axis, css: `axis-${i}`, further: k > 0, unit: run.stage.shown[axis].unit,
        value: (h, r) => Math.max(floor, scale * Math.abs(h.at(r, columnOf.position(i)) - h.at(r, columnOf.reference(i)))) };
    });
    return { lines, low: floor, high: scale * LARGEST_ERROR, logarithmic: unit,
      levels: run.bands.map((band) => ({ value: scale * band, name: "bands of settling", css: "reference", dash: "dot" })) };
  },
  currents(run, strip, values) {
    // Motors that drive one axis have one colour, and one name in the legend.
    const { axes, motors } = run, named = (current, motor) => (motors.length > 1 ? `${current} ${motor}` : current);
    const css = (axis) => `axis-${axes.indexOf(axis)}`;
    const lines = [...motors.map((motor, m) => ({ name: named("i_d", motor), of: "i_d", css: css(run.vertical), value: (h, r) => h.at(r, columnOf.direct(axes, m)) })),
      ...motors.map((motor, m) => ({ name: named("i_q", motor), of: `i_q ${run.drives[motor]}`, css: css(run.drives[motor]), further: true,
        value: (h, r) => h.at(r, columnOf.quadrature(axes, m)) }))];
    const [limit, peak] = ["controller.current_limit", `plant.${motors[0]}.amplifier.peak`].map((name) => values(name) || Infinity);
    const shown = Math.max(1, Number.isFinite(Math.min(limit, peak)) ? Math.min(limit, peak) : 5);
    return { lines, low: -1.15 * shown, high: 1.15 * shown, levels: around(shown, limit <= peak ? "limit of the commands" : "peak of a phase", "limit", "dashdot") };
  },
};

/** Show a run's plots from now on; equal lines keep their view, and limits are the present ones. */
function showPlots(run, values, models, span) {
  const element = at("strips"), panels = panelsOf(run, values, span, models);
  if (!element.clientWidth) return;   // there is no room for them
  PANEL.plot = COARSE.matches ? TALL.phone : Math.round(Math.min(TALL.most, Math.max(TALL.least, (innerHeight - TALL.around) / panels.length - TALL.each)));
  const key = JSON.stringify([run.plant, PANEL.plot, panels.map(({ title, lines, levels }) => [title, ...[...lines, ...levels].map(({ name, css }) => name + css)])]);
  if (plots.live?.key === key) {
    panels.forEach(({ levels, range }, p) => Object.assign(plots.live.panels[p], { levels, range }));
    Object.assign(plots.live, { span, stale: true });
    return;
  }
  if (plots.live) plots.live.gone = true;
  fillLegend(panels);
  const plot = makePlot(element, panels, ["live"]), times = [[], []];
  for (const line of panels.flatMap(({ lines }) => lines)) line.x = times[line.whose];
  const now = html("button", { type: "button", title: "follow what runs" }, null, "now");
  now.addEventListener("click", followRun);
  element.querySelector(".tools").prepend(now);
  plots.live = Object.assign(plot, { key, span, times, now, layers: [], ranges: [], seen: [0, 0], numbers: [0, 0], follows: true, rolling: false, stale: true, hold: holdPlots });
}

/** The legend of all panels, whose lines a click hides; a panel has its own for others. */
function fillLegend(panels) {
  const lines = new Map(panels.slice(0, -1).flatMap((panel) => panel.lines).map((line) => [line.of, line]));   // the last one are the currents
  legendOfAll.replaceChildren();
  hiddenInAll.clear();
  for (const [name, line] of lines) entry(legendOfAll, { ...line, name }, () => hide(hiddenInAll, name, document, [plots.live]));
}

/** Stop the plots for a closer look; returns whether they moved. */
function holdPlots() {
  const { rolling, layers, now } = plots.live;
  Object.assign(plots.live, { follows: false, rolling: false });
  for (const layer of layers) if (layer) layer.hidden = true;
  now.setAttribute("aria-pressed", "false");
  return rolling;
}

function followRun() {
  if (!plots.live) return;
  Object.assign(plots.live, { follows: true, stale: true });
  plots.live.now.setAttribute("aria-pressed", "true");
  page.dirty = true;
}

/** Take in new rows of the run: each row is looked at once. */
function takeRows(plot, histories) {
  histories.forEach((rows, whose) => {
    const x = plot.times[whose], lines = plot.panels.flatMap((panel) => panel.lines).filter((line) => line.whose === whose);
    if (plot.numbers[whose] !== (rows?.number ?? 0)) {
      for (const values of [x, ...lines.map(({ y }) => y)]) values.length = 0;
      plot.numbers[whose] = rows?.number ?? 0;
      plot.seen[whose] = 0;
      plot.stale = true;
    }
    if (!rows) return;
    for (let row = Math.max(plot.seen[whose], rows.first); row < rows.count; row++) {
      x.push(rows.at(row, 0));
      for (const { y, value } of lines) y.push(value(rows, row));
    }
    plot.seen[whose] = rows.count;
    if (x.length > 2 * MOST_KEPT) for (const values of [x, ...lines.map(({ y }) => y)]) values.splice(0, MOST_KEPT);
  });
}

/** Bring the plots up to the present of the run. */
function drawPlots(rows, ghost) {
  const plot = plots.live;
  if (!plot) return;
  takeRows(plot, [rows, ghost]);
  const { span, views: [view] } = plot, last = rows.last().time;
  Object.assign(view.full, { low: plot.times[0][0], high: Math.max(last, plot.times[0][0] + span) });
  if (plot.follows) Object.assign(view, { low: Math.max(view.full.low, last - span), high: Math.max(last, view.full.low + span) });
  const rolling = plot.follows && page.playing && !onPaper;
  if (rolling !== plot.rolling || plot.stale) {
    Object.assign(plot, { rolling, stale: false, rolled: "", turn: plot.turn + 1 });
    plot.panels.forEach((_, p) => drawPanel(plot, p));
    for (const layer of plot.layers) if (layer) layer.hidden = !rolling;
  }
  if (rolling) rollPlots(plot, last);
}

/** Let the plots scroll to a time (s), unless nothing would move by two px. */
function rollPlots(plot, last) {
  const ratio = Math.min(2, devicePixelRatio || 1), { across } = plot.handles[0], width = across.place(across.high), wide = Math.floor(width * ratio);
  const bucket = plot.span / wide, latest = Math.floor(last / bucket), since = Math.max(0, latest - wide + 1);
  const rolled = `${wide} ${ratio} ${[...plot.hidden]}`, anew = rolled !== plot.rolled || latest < plot.latest || plot.latest < since;
  if (!anew && latest - plot.latest < 2) return;
  Object.assign(plot.views[0], { low: since * bucket, high: (since + wide) * bucket });
  plot.panels.forEach((_, p) => rollPanel(plot, p, { ratio, wide, width, bucket, latest, since, anew }));
  Object.assign(plot, { rolled, latest });
  if ((plot.here ?? Infinity) < plot.views[0].low) pointAll(plot, 0, null);
}

function rollPanel(plot, p, { ratio, wide, width, bucket, latest, since, ...all }) {
  const panel = plot.panels[p], view = plot.views[p], [low, high] = panel.range(view), anew = all.anew || plot.ranges[p] !== `${low} ${high}`;
  if (anew) drawPanel(plot, p);
  plot.ranges[p] = `${low} ${high}`;
  const { across, picture } = plot.handles[p], layer = plot.layers[p] ??= html("canvas", {}, plot.places[p]), context = layer.getContext("2d");
  const begin = anew ? since : plot.latest, moved = since - Math.max(0, plot.latest - wide + 1), tall = Math.round(PANEL.plot * ratio);
  if (anew) {
    Object.assign(layer, { width: wide, height: tall });   // which empties it
    layer.style.cssText = `left: ${PANEL.left}px; top: ${plot.places[p].firstChild.offsetHeight + PANEL.top}px; width: ${width}px; height: ${PANEL.plot}px`;
  } else {
    context.globalCompositeOperation = "copy";
    if (moved) context.drawImage(layer, -moved, 0);
    context.globalCompositeOperation = "source-over";
    context.clearRect(begin - since, 0, wide, tall);
  }
  const along = scaleOf(begin * bucket, (latest + 1) * bucket, begin - since, latest + 1 - since, false);
  const up = scaleOf(low, high, ...(panel.down ? [0, tall] : [tall, 0]), panel.logarithmic);
  Object.assign(context, { lineJoin: "bevel", lineDashOffset: begin });   // dashes go with the line
  for (const line of shownLines(plot, p)) {
    context.beginPath();
    follow(context, line, along, up, latest - begin);
    const dashes = line.dash === "solid" ? [] : DASHES[line.dash].split(" ").map((length) => ratio * length);
    outline(context, page.colours[line.css], (line.thin ? 0.9 : 1.6) * ratio, dashes);
  }
  Object.assign(across, scaleOf(view.low, view.high, 0, width, false));
  drawAcross(picture.querySelector(".across"), panel, across, width, PANEL.plot, p === plot.panels.length - 1);
  drawCursors(plot, p, plot.here ?? null);
  if (picture === document.activeElement) for (const [name, value] of [["min", view.low], ["max", view.high]]) picture.setAttribute(`aria-value${name}`, value);
}
