"use strict";
// Shared functions of all pages: elements, packed bytes, scales of plots with round ticks, and drawing on canvases, in
// px of the page.
const SVG = "http://www.w3.org/2000/svg";
const SMALLER = { mm: "µm", mrad: "µrad", s: "ms", mA: "µA" };

/** An element with attributes, put into a parent if there is one. */
const html = (name, ...more) => filled(document.createElement(name), ...more);
const svg = (name, ...more) => filled(document.createElementNS(SVG, name), ...more);

function filled(element, attributes, parent, text = "") {
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  if (text) element.textContent = text;
  if (parent) parent.append(element);
  return element;
}

/** Bytes that a page holds as gzip in base64. */
async function unpacked(text) {
  const letters = atob(text), packed = new Uint8Array(letters.length);
  for (let k = 0; k < letters.length; k++) packed[k] = letters.charCodeAt(k);
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Return the distance of ticks that divides a span into at most a number of parts: 1, 2 or 5 times a power of ten. */
function tickStep(span, most) {
  const power = 10 ** Math.floor(Math.log10(span / most));
  return power * ([1, 2, 5].find((factor) => factor * power * most >= span * (1 - 1e-9)) ?? 10);
}

function numberText(value, digits) {
  return value.toFixed(digits).replace(/^-(0(\.0*)?)$/, "$1").replace("-", "−");
}

/** A value (SI) in the unit and with the digits that the table of panels has for it. */
const reading = ({ scale, digits, unit }, value) => `${numberText(scale * value, digits)} ${unit}`;

/** Return a number with significant digits, and no more zeros than needed. */
function shortNumber(value, digits = 5) {
  return String(Number(value.toPrecision(digits))).replaceAll("-", "−");
}

/** Powers of ten between two limits, with 2 and 5 times these where there are few. */
function decades(low, high, few = 2) {
  const steps = Math.log10(high / low) < few ? [1, 2, 5] : [1], found = [];
  for (let power = Math.floor(Math.log10(low)); 10 ** power <= high * 1.001; power++) found.push(...steps.map((step) => Number(`${step}e${power}`)));
  return found.filter((value) => value >= low * 0.999 && value <= high * 1.001);
}

/** A value with its unit, below a tenth of it in a smaller one: the rule of `printed` in maglev/scenario/quantities.py. */
function quantityText(value, unit, digits = 3) {
  const small = value !== 0 && Math.abs(value) < 0.1 && SMALLER[unit], number = small ? 1e3 * value : value;
  return `${Math.abs(number) >= 100 ? numberText(number, 0) : shortNumber(number, digits)} ${small || unit}`.trim();
}

/** Ticks between two limits, as value and text. */
function linearTicks(low, high, most) {
  const step = tickStep(high - low, most);
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const ticks = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) {
    ticks.push([k * step, digits < 7 ? numberText(k * step, digits) : shortNumber(k * step)]);
  }
  return ticks;
}

/** Return a scale from values to px; a logarithmic one has a unit, "mm" or "mrad". */
function scaleOf(low, high, start, end, logarithmic) {
  const of = logarithmic ? Math.log10 : (value) => value;
  const [from, to] = [of(low), of(high)];
  const place = (value) => start + (of(value) - from) / (to - from) * (end - start);
  const value = (px) => {
    const at = from + (px - start) / (end - start) * (to - from);
    return logarithmic ? 10 ** at : at;
  };
  const ticks = (most) => (logarithmic ? decades(low, high).map((mm) => [mm, quantityText(mm, logarithmic, 1)]) : linearTicks(low, high, most));
  return { low, high, place, value, ticks };
}

/** First of ascending positions from which on something holds; the last one, which is not asked, where it does for none. */
function firstOf(low, high, holds) {
  while (low < high) {
    const middle = (low + high) >> 1;
    if (holds(middle)) high = middle; else low = middle + 1;
  }
  return low;
}

/** First position in an ascending array whose value is at least this one. */
const firstFrom = (values, value) => firstOf(0, values.length, (k) => values[k] >= value);

/** First and last point of a line that are drawn between two abscissae: one more to each side, for the lines to these are seen. */
const drawnOf = ({ x, ascending }, from, to) => (ascending ? [Math.max(0, firstFrom(x, from) - 1), Math.min(x.length - 1, firstFrom(x, to))]
  : [0, x.length - 1]);

/** Follow a line with the pen of a canvas or a path, in px; of many points in a column of px the first, the extremes and the last. */
function follow(pen, { x, y, ascending }, across, up, width) {
  const [first, last] = drawnOf({ x, ascending }, across.low, across.high);
  let away = true;   // from the line, where it has no value
  const point = (k) => {
    if (y[k] !== null) pen[away ? "moveTo" : "lineTo"](across.place(x[k]), up.place(y[k]));
    away = y[k] === null;
  };
  if (!ascending || last - first < 4 * width) {
    for (let k = first; k <= last; k++) point(k);
    return;
  }
  for (let start = first; start <= last;) {
    const column = Math.floor(across.place(x[start]));
    let [end, low, high] = [start, start, start];
    while (end < last && Math.floor(across.place(x[end + 1])) === column) {
      end += 1;
      if (y[end] < y[low]) low = end;
      if (y[end] > y[high]) high = end;
    }
    let former = -1;
    for (const k of low < high ? [start, low, high, end] : [start, high, low, end]) {
      if (k !== former) point(k);
      former = k;
    }
    start = end + 1;
  }
}

/** Path of a line in px. */
function linePath(line, across, up, width) {
  const parts = [], put = (letter) => (x, y) => parts.push(`${letter}${x.toFixed(1)} ${y.toFixed(1)}`);
  follow({ moveTo: put("M"), lineTo: put("L") }, line, across, up, width);
  return parts.join("");
}

/** Return limits of the lines between two abscissae, with some air; levels near enough are included. */
function fitted(lines, levels, from, to, logarithmic) {
  let [low, high] = [Infinity, -Infinity];
  const take = (value) => {
    if (value < low) low = value;
    if (value > high) high = value;
  };
  for (const line of lines) {
    const { x, y, ascending } = line, [first, last] = drawnOf(line, from, to);
    for (let k = first; k <= last; k++) if (y[k] !== null && (ascending || (x[k] >= from && x[k] <= to))) take(y[k]);
  }
  if (low > high) return logarithmic ? [1e-3, 1] : [0, 1];
  if (!logarithmic && high - low < 1e-9 * Math.max(1e-3, Math.abs(high))) [low, high] = [low - 0.5, high + 0.5];
  const [least, most] = logarithmic ? [low / 10, high * 10] : [2 * low - high, 2 * high - low];
  levels.filter((level) => level >= least && level <= most).forEach(take);
  if (logarithmic) return [low / 1.3, Math.max(high * 1.3, low * 10)];
  const air = 0.06 * (high - low);
  return [low - air, high + air];
}

/** Canvas as large as its place, in px of the page; empty if it is to be cleared. */
function sized(canvas, clear = true) {
  const ratio = Math.min(2, devicePixelRatio || 1);
  const { clientWidth: width, clientHeight: height } = canvas;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  if (clear) context.clearRect(0, 0, width, height);
  return { context, width, height, ratio };
}

/** Write a text at a place, narrower where it is wider than the most (px); a halo keeps lines below it from its letters. */
function write(context, text, x, y, colour, { font = "11px", align = "left", base = "middle", most, halo } = {}) {
  context.font = `${font} system-ui, sans-serif`;
  context.textAlign = align;
  context.textBaseline = base;
  if (halo) {
    Object.assign(context, { strokeStyle: halo, lineWidth: 3, lineJoin: "round" });
    context.strokeText(text, x, y, most);
  }
  context.fillStyle = colour;
  context.fillText(text, x, y, most);
}

/** Draw a line through points. */
function line(context, points, colour, width = 1, dash = []) {
  context.beginPath();
  for (const [x, y] of points) context.lineTo(x, y);
  outline(context, colour, width, dash);
}

/** Draw the line of the path that there is. */
function outline(context, colour, width = 1, dash = []) {
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.setLineDash(dash);
  context.stroke();
  context.setLineDash([]);
}

/** Make a path around points. */
function polygon(context, points) {
  context.beginPath();
  for (const [x, y] of points) context.lineTo(x, y);
  context.closePath();
}

/** Fill the current path, with a share of the present opacity. */
function fill(context, colour, share = 1) {
  const alpha = context.globalAlpha;
  Object.assign(context, { globalAlpha: share * alpha, fillStyle: colour });
  context.fill();
  context.globalAlpha = alpha;
}

const DASHED = [5, 4];   // px
