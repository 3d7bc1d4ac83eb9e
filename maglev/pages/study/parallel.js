"use strict";
// Parallel coordinates: a line for each sample across all columns, ranges kept by dragging along an axis.
const AXES = { step: 110, top: 100, tall: 328, bottom: 28, side: 60 };   // px between two axes, and around them
const ranges = new Map();   // column: [low, high] that is kept, in its own unit

/** Least and largest of the values that are known. */
function extent(values) {
  const known = values.filter((value) => value !== null);
  return known.length ? [Math.min(...known), Math.max(...known)] : [0, 1];
}

/** Scale of a column, and where what has no value stands: above, for an axis has no infinity. */
function axisOf({ values }) {
  const [least, most] = extent(values), width = most - least || Math.abs(most) || 1;
  const [low, high] = most > least ? [least, most] : [least - width / 2, least + width / 2], none = high + 0.08 * width;
  return { ...scaleOf(low, none, AXES.top + AXES.tall, AXES.top, false), low, high, none };
}

class Parallel {
  constructor(picture, all, passed, kept) {
    Object.assign(this, { picture, all, kept, axes: all.map(axisOf) });
    const [width, height] = [AXES.side * 2 + AXES.step * (all.length - 1), AXES.top + AXES.tall + AXES.bottom];
    for (const [name, value] of Object.entries({ width, height, viewBox: `0 0 ${width} ${height}` })) picture.setAttribute(name, value);
    this.group = svg("g", { style: `--seen: ${Math.min(0.9, Math.max(0.08, 60 / passed.length))}` }, picture);
    const across = { place: (column) => this.x(column) }, up = { place: (y) => y }, x = all.map((_, column) => column);
    this.lines = passed.map((passes, sample) => svg("path", { class: passes ? "" : "fails",
      d: linePath({ x, y: x.map((column) => this.y(column, sample)) }, across, up) }, this.group));
    this.bars = all.map((each, column) => this.drawAxis(each, this.axes[column], this.x(column)));
    picture.addEventListener("pointerdown", (event) => this.begin(event));
    picture.addEventListener("pointermove", (event) => this.move(event));
    for (const end of ["pointerup", "pointercancel"]) picture.addEventListener(end, () => { this.drag = undefined; });
  }

  x(column) {
    return AXES.side + AXES.step * column;
  }

  y(column, sample) {
    return this.axes[column].place(this.all[column].values[sample] ?? this.axes[column].none);
  }

  /** Draw an axis; returns the bar over it, which shows what is kept. */
  drawAxis({ name, unit }, { low, high, place }, x) {
    svg("path", { class: "axis", d: `M${x} ${AXES.top}v${AXES.tall}` }, this.picture);
    for (const [value, below] of [[high, 4], [low, 14]]) svg("text", { x: x + 4, y: place(value) + below }, this.picture, shortNumber(value, 3));
    const words = (unit ? `${name} (${unit})` : name).split(/ (?=of |at |and |change |\()/), title = svg("g", { transform: `translate(${x - 4} ${AXES.top - 10})rotate(-20)` }, this.picture);
    words.forEach((word, line) => svg("text", { y: 12 * (line - words.length + 1) }, title, word.length > 24 ? `${word.slice(0, 23)}…` : word));
    return svg("rect", { x: x - 5, width: 10 }, this.picture);
  }

  /** Column that a pointer is at, and its place along the axis (px). */
  at({ clientX, clientY }) {
    const { left, top } = this.picture.getBoundingClientRect(), column = Math.round((clientX - left - AXES.side) / AXES.step);
    return [Math.abs(clientX - left - this.x(column)) > 24 || !this.all[column] ? -1 : column, clientY - top];
  }

  begin(event) {
    const [column, from] = this.at(event);
    if (column < 0) return;
    event.preventDefault();
    this.picture.setPointerCapture(event.pointerId);
    this.drag = { column, from };
    ranges.delete(column);
    this.draw();
  }

  move(event) {
    if (!this.drag) return;
    const { column, from } = this.drag, [, to] = this.at(event);
    if (Math.abs(to - from) > 3) ranges.set(column, [from, to].map(this.axes[column].value).sort((a, b) => a - b));
    this.draw();
  }

  /** Show what is kept: of the samples those in all ranges. */
  draw() {
    const inside = (sample) => [...ranges].every(([column, [low, high]]) => {
      const value = this.all[column].values[sample] ?? this.axes[column].none;
      return value >= low && value <= high;
    });
    const chosen = this.lines.map((_, sample) => sample).filter(inside), seen = new Set(chosen);
    this.lines.forEach((line, sample) => line.classList.toggle("out", !seen.has(sample)));
    this.group.append(...chosen.map((sample) => this.lines[sample]));   // over the others
    this.bars.forEach((bar, column) => {
      const [low, high] = ranges.get(column) ?? [0, 0], { low: least, none, place } = this.axes[column];
      const y = place(Math.min(high, none));
      bar.setAttribute("y", y);
      bar.setAttribute("height", ranges.has(column) ? Math.max(0, place(Math.max(low, least)) - y) : 0);
    });
    this.kept(ranges.size ? chosen.map((sample) => report.samples[sample]) : null);
  }
}
