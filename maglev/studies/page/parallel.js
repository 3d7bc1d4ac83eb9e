"use strict";
// Parallel coordinates on a canvas: a line for each sample across all columns, ranges kept by dragging along an axis.
const AXIS_STEP = 110;   // px between two axes
const TOP = 84, BOTTOM = 28, SIDE = 60;   // px around the axes
const ranges = new Map();   // column: [low, high] that is kept, in its own unit

/** Least and largest of the values that are known. */
function extent(values) {
  const known = values.filter((value) => value !== null);
  return known.length ? [Math.min(...known), Math.max(...known)] : [0, 1];
}

/** Least and largest value of a column, and where what has no value stands: above, for an axis has no infinity. */
function span({ values }) {
  const [low, high] = extent(values), width = high - low || Math.abs(high) || 1;
  return { low: high > low ? low : low - width / 2, high: high > low ? high : high + width / 2,
    none: (high > low ? high : high + width / 2) + 0.08 * width };
}

class Parallel {
  constructor(canvas, all, passed, kept) {
    Object.assign(this, { canvas, all, passed, kept, spans: all.map(span) });
    canvas.style.width = `${SIDE * 2 + AXIS_STEP * (all.length - 1)}px`;
    canvas.style.touchAction = "pan-x pan-y";
    canvas.addEventListener("pointerdown", (event) => this.begin(event));
    canvas.addEventListener("pointermove", (event) => this.move(event));
    canvas.addEventListener("pointerup", () => this.end());
    canvas.addEventListener("pointercancel", () => this.end());
  }

  x(column) {
    return SIDE + AXIS_STEP * column;
  }

  y(column, value) {
    const { low, none } = this.spans[column];
    const height = this.canvas.clientHeight - TOP - BOTTOM;
    return TOP + height * (1 - ((value ?? none) - low) / (none - low));
  }

  valueAt(column, y) {
    const { low, none } = this.spans[column];
    const height = this.canvas.clientHeight - TOP - BOTTOM;
    return low + (none - low) * (1 - (Math.min(Math.max(y, TOP), TOP + height) - TOP) / height);
  }

  /** Whether a sample is in all ranges. */
  inside(sample) {
    for (const [column, [low, high]] of ranges) {
      const value = this.all[column].values[sample] ?? this.spans[column].none;
      if (value < low || value > high) return false;
    }
    return true;
  }

  begin(event) {
    const column = Math.round((event.offsetX - SIDE) / AXIS_STEP);
    if (column < 0 || column >= this.all.length || Math.abs(event.offsetX - this.x(column)) > 24) return;
    event.preventDefault();
    this.canvas.setPointerCapture(event.pointerId);
    this.drag = { column, from: event.offsetY };
    ranges.delete(column);
    this.draw();
  }

  move(event) {
    if (!this.drag) return;
    const { column, from } = this.drag;
    const ends = [this.valueAt(column, from), this.valueAt(column, event.offsetY)];
    if (Math.abs(event.offsetY - from) > 3) ranges.set(column, [Math.min(...ends), Math.max(...ends)]);
    this.draw();
  }

  end() {
    this.drag = undefined;
  }

  draw() {
    const { canvas, all } = this;
    const ratio = window.devicePixelRatio || 1;
    canvas.width = canvas.clientWidth * ratio;
    canvas.height = canvas.clientHeight * ratio;
    const pen = canvas.getContext("2d");
    pen.scale(ratio, ratio);
    const chosen = this.passed.map((_, sample) => this.inside(sample));
    const opacity = Math.min(0.9, Math.max(0.08, 60 / this.passed.length));
    for (const [kept, colours] of [[false, [colour("line"), colour("line")]], [true, [colour("bad"), colour("run-0")]]]) {
      pen.globalAlpha = kept ? opacity : 0.5 * opacity;
      this.passed.forEach((passes, sample) => {
        if (chosen[sample] !== kept) return;
        pen.strokeStyle = colours[passes];
        pen.setLineDash(passes ? [] : [6, 4]);
        pen.beginPath();
        all.forEach(({ values }, column) => pen.lineTo(this.x(column), this.y(column, values[sample])));
        pen.stroke();
      });
    }
    pen.globalAlpha = 1;
    pen.setLineDash([]);
    this.axes(pen);
    const names = chosen.flatMap((kept, sample) => (kept ? [report.samples[sample]] : []));
    this.kept(ranges.size ? names : null);
  }

  axes(pen) {
    pen.font = "11px system-ui, sans-serif";
    this.all.forEach(({ name, unit }, column) => {
      const [x, { low, high }] = [this.x(column), this.spans[column]];
      const ends = ranges.get(column);
      pen.strokeStyle = colour("faint");
      pen.beginPath();
      pen.moveTo(x, this.y(column, null));
      pen.lineTo(x, this.y(column, low));
      pen.stroke();
      if (ends) {
        pen.fillStyle = colour("link");
        pen.globalAlpha = 0.45;
        pen.fillRect(x - 5, this.y(column, ends[1]), 10, this.y(column, ends[0]) - this.y(column, ends[1]));
        pen.globalAlpha = 1;
      }
      pen.fillStyle = colour("text");
      pen.fillText(Number(high.toPrecision(3)), x + 4, this.y(column, high) + 4);
      pen.fillText(Number(low.toPrecision(3)), x + 4, this.y(column, low) + 14);
      pen.save();
      pen.translate(x - 4, TOP - 10);
      pen.rotate(-0.35);
      const words = (unit ? `${name} (${unit})` : name).split(/ (?=of |at |\()/);
      words.forEach((word, line) => pen.fillText(word, 0, 12 * (line - words.length + 1)));
      pen.restore();
    });
  }
}
