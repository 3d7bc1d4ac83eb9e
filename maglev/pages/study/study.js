"use strict";
// The plots of a study that change: the response of a metric to the varied quantities, and every sample; `report`,
// scales and SVG are the report's.

/** Numbers with all their bits: as levels and the places of these, or as bytes. */
function numbersOf({ levels, at, bytes }) {
  return at?.map((k) => levels[k]) ?? [...new Float64Array(Uint8Array.from(atob(bytes), (letter) => letter.charCodeAt(0)).buffer)];
}

const sets = report.card.sets.flatMap(({ targets, ...packed }) => targets.map((target) => [target, numbersOf(packed)]));   // SI
const exact = Object.fromEntries(sets), { varied } = report;
report.passed = [...report.passed].map(Number);
report.samples ??= report.passed.map((_, i) => i);   // all of them
const columns = report.columns.map(({ of, scale, ...column }) => (of ? { ...column, values: exact[of].map((value) => scale * value) } : column));
const RESPONSE = { left: 78, right: 14, top: 10, below: 46, scale: 50, height: 330 };   // px
const BARS = { left: 34, top: 6, width: 300, height: 90, most: 20 };   // px of a histogram, and bars of one
const PASSES = { name: "samples that pass", unit: "%", limits: {}, values: report.passed.map((passes) => 100 * passes) };
const MANY = 2000, CELLS = 20;   // samples from which on cells are drawn instead of marks, and cells of a side
let chosen = null;   // numbers of the samples in all ranges; null for all
const isChosen = (i) => !chosen || chosen.has(report.samples[i]);
const metricOf = (i) => (i < 0 ? PASSES : columns[i]);

/** Sorted values of a column, each once; of one in parts the middles of all parts. */
function tried({ values, middles }) {
  return middles ?? [...new Set(values.filter((value) => value !== null))].sort((a, b) => a - b);
}

const mean = (values) => (values.length ? values.reduce((sum, value) => sum + value, 0) / values.length : null);

/** Map values to a share of a colour over which text can be read. */
function shadeOf([low, high]) {
  return { low, high, css: (value) => `fill: color-mix(in oklab, var(--run-0) ${(8 + 48 * (value - low) / (high - low || 1)).toFixed(0)}%, var(--paper))` };
}

/** A column with the middle of its part for each value. */
function inParts({ values, ...column }) {
  const [low, high] = extent(values), wide = (high - low) / CELLS || 1, middle = (k) => low + (k + 0.5) * wide;
  return { ...column, middles: Array.from({ length: CELLS }, (_, k) => middle(k)),
    values: values.map((value) => (value === null ? null : middle(Math.min(CELLS - 1, Math.floor((value - low) / wide))))) };
}

/** All that is known of a sample, below the plot: its values, the command that runs it again, and its run in the live page. */
function tell(i, before = "") {
  const said = columns.filter(({ values }) => values[i] !== null).map(({ name, unit, signed, values }) => `${name} = ${signed && values[i] > 0 ? "+" : ""}${quantityText(values[i], unit)}`);
  document.getElementById("told").textContent = `${before}Sample ${report.samples[i]} ${report.passed[i] ? "passes" : "fails"}${report.causes[report.cause[i]] && ` (${report.causes[report.cause[i]]})`}: ${said.join("; ")}.`;
  fillCard(document.getElementById("card"), report.card, sets.map(([target, values]) => [target, values[i]]));
}

let told = -1;
document.getElementById("response")?.addEventListener("keydown", ({ key }) => {
  const by = { ArrowLeft: -1, ArrowRight: 1 }[key], count = report.samples.length;
  if (by) tell(told = (told + by + count) % count);
});

/** Labels along the axes: the simulated values, as many as there is room for, or round numbers. */
function labelled(picture, across, up, first, second, box) {
  const { left, top, width, height } = box;
  for (const [place, text] of across) {
    svg("text", { x: left + place, y: top + height + 15 }, picture, text);
  }
  for (const [place, text] of up) svg("text", { class: "end", x: left - 6, y: top + place + 4 }, picture, text);
  svg("text", { x: left + width / 2, y: top + height + 32 }, picture, titleOf(first));
  const words = titleOf(second), long = height / 6.5;   // letters that have room
  svg("title", {}, svg("text", { transform: `translate(14 ${top + height / 2})rotate(-90)` }, picture,
    words.length > long ? `${words.slice(0, long / 2)} … ${words.slice(-long / 2)}` : words), words);
}

/** Places of some labels, with so much room between two. */
function thinned(labels, room) {
  const every = Math.max(1, Math.ceil(room / Math.abs((labels.at(-1)[0] - labels[0][0]) / Math.max(1, labels.length - 1))));
  return labels.filter((_, k) => k % every === 0);
}

/** Numbers of the samples by their cell. */
function cellsOf(first, second) {
  const cells = new Map();
  report.samples.forEach((_, i) => {
    const cell = `${first.values[i]} ${second.values[i]}`;
    if (!cells.has(cell)) cells.set(cell, []);
    cells.get(cell).push(i);
  });
  return cells;
}

/** Cells: the mean of a metric, or without one the number of samples, and a cross as large as the share that fails; returns the shade. */
function drawCells(picture, metric, first, second, box) {
  const [xs, ys] = [tried(first), tried(second)], cells = cellsOf(first, second);
  const [wide, tall] = [box.width / xs.length, box.height / ys.length];
  const shade = shadeOf(metric ? extent(metric.values) : [0, Math.max(...[...cells.values()].map(({ length }) => length))]);
  ys.forEach((y, row) => xs.forEach((x, column) => {
    const inside = (cells.get(`${x} ${y}`) ?? []).filter(isChosen), failing = inside.filter((i) => !report.passed[i]).length;
    const value = metric ? mean(inside.map((i) => metric.values[i]).filter((each) => each !== null)) : inside.length || null;
    const [left, top] = [box.left + wide * column, box.top + box.height - tall * (row + 1)];
    const cell = svg("rect", { class: "cell", x: left, y: top, width: wide, height: tall, style: value === null ? "fill: none" : shade.css(value) }, picture);
    const said = `${titleOf(first)} ${shortNumber(x)}, ${titleOf(second)} ${shortNumber(y)}: ${metric ? `${value === null ? "none" : quantityText(value, metric.unit)}, ` : ""}${failing} of ${inside.length} fail`;
    svg("title", {}, cell, said);
    const number = value === null ? "" : shortNumber(value, wide > 48 ? 3 : 2), numbered = tall > 30 && wide > 6.5 * number.length + 2;
    // a cross next to the number
    const size = 2 + 7 * failing / inside.length, across = numbered ? 4 : (wide - size) / 2, down = numbered ? 4 : (tall - size) / 2;
    if (failing) svg("path", { class: "fails", d: `M${left + across} ${top + down}l${size} ${size}m0 ${-size}l${-size} ${size}` }, picture);
    if (numbered) svg("text", { x: left + wide / 2, y: top + tall / 2 + 8 }, picture, number);
    if (inside.length) cell.addEventListener("click", () => tell(inside[0], inside.length > 1 ? `${said}. One of them: ` : ""));
  }));
  const sides = [[first, xs, 0, box.width, 40, 8], [second, ys, box.height, 0, 15, 6]].map(([{ middles }, values, start, end, room, most]) => {
    const part = (end - start) / values.length, at = (px) => Math.min(values.length - 1, Math.max(0, Math.floor((px - start) / part)));
    const half = middles ? (values[1] - values[0]) / 2 : 0, scale = scaleOf(values[0] - half, values.at(-1) + half, start, end, false);
    return middles ? { ...scale, labels: scale.ticks(most).map(([value, text]) => [scale.place(value), text]) }
      : { value: (px) => values[at(px)], labels: thinned(values.map((value, k) => [start + part * (k + 0.5), shortNumber(value, 4)]), room) };
  });
  labelled(picture, sides[0].labels, sides[1].labels, first, second, box);
  return { shade, sides, several: [...cells.values()].some(({ length }) => length > 1) };
}

/** Points of samples, crosses where they fail: a metric over one column, or by its shade over two. */
function drawPoints(picture, metric, first, second, box) {
  const over = first === second ? metric : second, shade = shadeOf(extent(metric.values.filter((_, i) => report.passed[i])));   // crosses have none
  const range = ({ values }, limits) => {
    const [low, high] = extent([...values, ...limits]), air = 0.03 * (high - low) || 0.5;
    return [low - air, high + air];
  };
  const limits = first === second ? Object.values(metric.limits) : [];
  const across = scaleOf(...range(first, []), 0, box.width, false), up = scaleOf(...range(over, limits), box.height, 0, false);
  const ticks = (scale, column, most, room) => {
    const values = tried(column);
    return values.length <= most ? thinned(values.map((value) => [scale.place(value), shortNumber(value, 4)]), room)
      : scale.ticks(Math.floor(most)).map(([value, text]) => [scale.place(value), text]);
  };
  report.samples.forEach((sample, i) => {
    if (first.values[i] === null || over.values[i] === null || !isChosen(i)) return;
    const [x, y] = [box.left + across.place(first.values[i]), box.top + up.place(over.values[i])];
    const style = first === second ? "fill: var(--run-0)" : metric.values[i] === null ? "fill: none" : shade.css(metric.values[i]);
    const point = report.passed[i] ? svg("circle", { class: "point", cx: x, cy: y, r: 4, style }, picture)
      : svg("path", { class: "fails", d: `M${(x - 4).toFixed(1)} ${(y - 4).toFixed(1)}l8 8m0 -8l-8 8` }, picture);
    svg("title", {}, point, `sample ${sample}: ${metric.values[i] === null ? "none" : quantityText(metric.values[i], metric.unit)}${report.passed[i] ? "" : ", fails"}`);
    point.addEventListener("click", () => tell(i));
  });
  labelled(picture, ticks(across, first, Math.max(3, box.width / 70), 40), ticks(up, over, 6, 15), first, over, box);
  return { shade, sides: [across, up] };
}

/** Let a drag over a plot keep the samples in it: a column and its scale for each side. */
function brush(picture, { left, top, width, height }, sides) {
  const area = svg("rect", { class: "brushed", width: 0 }, picture);
  let from = null, moved = false;
  const at = ({ clientX, clientY }) => {
    const box = picture.getBoundingClientRect(), by = picture.viewBox.baseVal.width / box.width;
    return [Math.min(Math.max((clientX - box.left) * by - left, 0), width - 1), Math.min(Math.max((clientY - box.top) * by - top, 0), height - 1)];
  };
  picture.addEventListener("pointerdown", (event) => {
    if (event.pointerType === "touch") return;   // it scrolls
    [from, moved] = [at(event), false];
    event.preventDefault();
  });
  picture.addEventListener("pointermove", (event) => {
    if (!from) return;
    const to = at(event);
    if (!(moved ||= Math.hypot(to[0] - from[0], to[1] - from[1]) > 5)) return;
    picture.setPointerCapture(event.pointerId);
    const [x, y] = [0, 1].map((k) => Math.min(from[k], to[k])), tall = sides[1] ? Math.abs(to[1] - from[1]) : height;
    for (const [name, value] of Object.entries({ x: left + x, y: top + (sides[1] ? y : 0), width: Math.abs(to[0] - from[0]), height: tall })) area.setAttribute(name, value);
  });
  picture.addEventListener("pointerup", (event) => {
    const to = at(event), start = from;
    from = null;
    if (!start || !moved) return;
    sides.forEach((side, k) => {
      if (side) ranges.set(side.column, [side.value(start[k]), side.value(to[k])].sort((a, b) => a - b));
    });
    parallel.draw();
  });
}

/** Histogram of a metric with limits: bars, those beyond a limit red, and the limits; a sample without a value is in no
 * bar. */
function drawHistogram(metric) {
  const known = metric.values.filter((value) => value !== null), limits = Object.values(metric.limits), { left, top, width, height } = BARS;
  if (!known.length || !limits.length) return;
  const [low, high] = extent([...known, ...limits]), wide = (high - low) / BARS.most || 1;
  const { min = -Infinity, max = Infinity } = metric.limits, counts = Array.from({ length: BARS.most }, () => [0, 0]);   // within, beyond
  for (const value of metric.values.filter((value, i) => value !== null && isChosen(i))) counts[Math.min(BARS.most - 1, Math.floor((value - low) / wide))][Number(value < min || value > max)] += 1;
  const most = Math.max(...counts.map(([within, beyond]) => within + beyond)), across = scaleOf(low - 0.5 * wide, high + 0.5 * wide, 0, width, false);
  const none = metric.values.length - known.length, title = titleOf(metric) + (none ? `; ${none} without` : "");
  const picture = svg("svg", { class: "response bars", viewBox: `0 0 ${left + width + 20} ${top + height + 34}`, role: "img",
    "aria-label": `${title}: ${known.length} samples from ${extent(known).map((value) => shortNumber(value, 4)).join(" to ")}` });
  counts.forEach((parts, k) => parts.forEach((count, beyond) => {   // one on the other
    const [from, to] = [low + k * wide, low + (k + 1) * wide], x = left + across.place(from) + 0.5, below = beyond * parts[0];
    if (count) svg("title", {}, svg("rect", { class: beyond ? "bar beyond" : "bar", x, y: top + height * (1 - (below + count) / most),
      width: across.place(to) - across.place(from) - 1, height: height * count / most }, picture), `${count} from ${quantityText(from, metric.unit)} to ${quantityText(to, metric.unit)}${beyond ? ", beyond a limit" : ""}`);
  }));
  for (const limit of limits) svg("path", { class: "limit", d: `M${left + across.place(limit)} ${top}v${height}` }, picture);
  svg("text", { class: "end", x: left - 4, y: top + 8 }, picture, String(most));
  svg("path", { class: "outline", d: `M${left} ${top}v${height}h${width}` }, picture);
  for (const [value, text] of across.ticks(5)) svg("text", { x: left + across.place(value), y: top + height + 14 }, picture, text);
  svg("text", { x: left + width / 2, y: top + height + 29 }, picture, title);
  if (parallel) brush(picture, BARS, [{ ...across, column: columns.indexOf(metric) }]);
  document.getElementById("histograms").append(picture);
}

/** Draw the metric over one or two quantities, and below it the meaning of shades and crosses. */
function drawResponse(most = 960) {
  const element = document.getElementById("response");
  if (!element) return;
  const [metric, first, second] = ["metric", "first", "second"].map((id) => metricOf(Number(document.getElementById(id).value)));
  const { left, right, top, below, scale, height } = RESPONSE, whole = Math.max(280, Math.min(most, element.clientWidth));
  const box = { left, top, width: whole - left - right, height }, alone = first === second, many = !report.grid && report.samples.length > MANY;
  const over = alone ? metric : second, cells = many || (report.grid && !alone);
  const picture = svg("svg", { class: "response", viewBox: `0 0 ${whole} ${top + height + below + scale}`, role: "img",
    "aria-label": `${titleOf(metric)} over ${titleOf(first)}${alone ? "" : ` and ${titleOf(second)}`}` });
  const { shade, sides, several } = !cells ? drawPoints(picture, metric, first, second, box)
    : drawCells(picture, alone ? null : metric, ...[first, over].map((column) => (many ? inParts(column) : column)), box);
  for (const limit of alone ? Object.values(metric.limits).filter((each) => each >= sides[1].low && each <= sides[1].high) : []) {
    svg("path", { class: "limit", d: `M${left} ${top + sides[1].place(limit)}h${box.width}` }, picture);
  }
  svg("rect", { class: "outline", x: left, y: top, width: box.width, height, style: "fill: none" }, picture);
  const y = top + height + below + 6, shaded = cells || (!alone && report.passed.includes(1)), beside = left + (shaded ? 150 : 0);
  if (shaded) {
    for (let k = 0; k < 20; k++) svg("rect", { x: left + 6 * k, y, width: 6, height: 12, style: shade.css(shade.low + (k + 0.5) / 20 * (shade.high - shade.low)) }, picture);
    svg("text", { class: "start", x: left, y: y + 26 }, picture, shortNumber(shade.low, 3));
    svg("text", { class: "end", x: left + 120, y: y + 26 }, picture, shortNumber(shade.high, 3));
  }
  const asked = Object.entries(metric.limits).map(([end, limit]) => `${end === "min" ? "≥" : "≤"} ${quantityText(limit, metric.unit)}`).join(", ");
  const words = alone ? [cells && "number of samples", asked && `dashed: asked for ${asked}`] : [shaded && titleOf(metric), asked && `asked for ${asked}`];
  svg("text", { class: "start", x: 4, y: y + 42 }, picture, words.filter(Boolean).join(", "));
  if (report.passed.includes(0)) {
    svg("path", { class: "fails", d: `M${beside} ${y + 2}l8 8m0 -8l-8 8` }, picture);
    svg("text", { class: "start", x: beside + 14, y: y + 10 }, picture, several ? "share that fails" : "fails");
  }
  if (parallel) {
    brush(picture, box, [first, over].map((column, k) => (columns.includes(column) ? { ...sides[k], column: columns.indexOf(column) } : null)));
  }
  element.replaceChildren(picture);
}

/** All but the lines, of the samples that are chosen; once a frame. */
let due = 0;
function drawAll() {
  due ||= requestAnimationFrame(() => {
    due = 0;
    document.getElementById("histograms").replaceChildren();
    columns.slice(varied).forEach(drawHistogram);
    drawResponse();
  });
  const kept = ({ name, values, scale }) => {
    const [low, high] = ranges.get(columns.findIndex((column) => column.name === name)) ?? [-Infinity, Infinity];
    return values.map((value) => scale * value >= low && scale * value <= high);
  };
  mapped.then((maps) => maps?.keep(ranges.size ? maps.factors.map(kept) : null));
}

const lines = document.getElementById("parallel");
const parallel = lines && new Parallel(lines, columns, report.passed, (names) => {
  const some = names && names.slice(0, 20).join(", ") + (names.length > 20 ? ", …" : "");
  chosen = names && new Set(names);
  drawAll();
  const passing = names && report.samples.filter((sample, i) => chosen.has(sample) && report.passed[i]).length;
  document.getElementById("kept").textContent = names ? `${names.length} of ${report.samples.length} samples, ${passing} pass: ${some}` : "";
  document.getElementById("keeping").hidden = !names;
});
document.getElementById("keep-all").addEventListener("click", () => {
  ranges.clear();
  for (const input of document.querySelectorAll("#ranges input")) input.value = "";
  parallel.draw();
});

/** Ranges to type, for who does not drag. */
function fillRanges() {
  columns.forEach((column, i) => {
    const row = html("div", { role: "group", "aria-label": titleOf(column) }, document.getElementById("ranges"), `${titleOf(column)} `);
    const ends = ["from", "to"].map((word) => html("input", { type: "number", step: "any" }, html("label", {}, row, `${word} `)));
    for (const end of ends) {
      end.addEventListener("change", () => {
        const [low, high] = ends.map(({ value }) => value);
        if (low === "" && high === "") ranges.delete(i);
        else ranges.set(i, [low === "" ? -Infinity : Number(low), high === "" ? Infinity : Number(high)]);
        parallel.draw();
      });
    }
  });
}

for (const select of document.querySelectorAll("#metric, #first, #second")) select.addEventListener("change", () => drawResponse());
if (parallel) fillRanges();
let width = window.innerWidth;
window.addEventListener("resize", () => {
  if (window.innerWidth !== width) drawResponse();
  width = window.innerWidth;
});
window.addEventListener("beforeprint", () => drawResponse(690));   // px on A4: letters are as large
window.addEventListener("afterprint", () => drawResponse());
columns.slice(varied).forEach(drawHistogram);
drawResponse();
parallel?.draw();
