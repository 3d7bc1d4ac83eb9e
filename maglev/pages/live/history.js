"use strict";
// Rows of a run that are kept for the picture and the plots, the oldest ones overwritten.

const MOST_KEPT = 16384;

class RunHistory {
  static made = 0;

  constructor(run, width) {
    this.number = ++RunHistory.made;
    this.run = run;
    this.width = width;
    this.data = new Float32Array(MOST_KEPT * width);
    this.count = 0;   // rows that ever came
  }

  add(rows) {
    for (let at = 0; at < rows.length; at += this.width) {
      this.data.set(rows.subarray(at, at + this.width), (this.count % MOST_KEPT) * this.width);
      this.count++;
    }
  }

  get first() { return Math.max(0, this.count - MOST_KEPT); }

  at(row, column) { return this.data[(row % MOST_KEPT) * this.width + column]; }

  /** First row at or after a time (s). */
  since(time) { return firstOf(this.first, this.count, (row) => this.at(row, 0) >= time); }

  /** The last row by names: time, and of each axis and motor what there is. */
  last() {
    if (!this.count) return null;
    const value = (column) => this.at(this.count - 1, column), { axes, motors } = this.run;
    return {
      time: value(0),
      axes: Object.fromEntries(axes.map((axis, i) => [axis, { position: value(columnOf.position(i)),
        reference: value(columnOf.reference(i)), force: value(columnOf.force(i)) }])),
      motors: Object.fromEntries(motors.map((motor, i) => [motor, { phases: [0, 1, 2].map((c) => value(columnOf.phases(axes, i) + c)),
        d: value(columnOf.direct(axes, i)), q: value(columnOf.quadrature(axes, i)) }])),
    };
  }
}

/** Columns of a row, as Simulation.row writes them. */
const columnOf = {
  position: (axis) => 1 + 3 * axis,
  reference: (axis) => 2 + 3 * axis,
  force: (axis) => 3 + 3 * axis,
  phases: (axes, motor) => 1 + 3 * axes.length + 5 * motor,   // three
  direct: (axes, motor) => 4 + 3 * axes.length + 5 * motor,
  quadrature: (axes, motor) => 5 + 3 * axes.length + 5 * motor,
};
