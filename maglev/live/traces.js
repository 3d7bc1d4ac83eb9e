"use strict";
// Lines of the plots, a pixel's column at a time: each row of a flight is looked at once, however long it is shown.

class Trace {
  /**
   * @param {(rows: FlightHistory, row: number) => number} value what is drawn
   * @param {number} bucket time of a column, s
   * @param {number} size columns
   */
  constructor(value, bucket, size) {
    this.value = value;
    this.bucket = bucket;
    this.low = new Float32Array(size).fill(NaN);
    this.high = new Float32Array(size).fill(NaN);
    this.newest = -1;   // column of the last row, counted from time 0
    this.last = NaN;
    this.seen = 0;
  }

  /** Take in the rows that are new. */
  update(rows) {
    const size = this.low.length;
    for (let row = Math.max(this.seen, rows.first); row < rows.count; row++) {
      const column = Math.floor(rows.at(row, 0) / this.bucket), now = this.value(rows, row), place = column % size;
      if (column > this.newest) {
        // Columns without a row, and the beginning of this one, join the line to what it was.
        const from = this.newest < 0 ? column : Math.max(this.newest + 1, column - size);
        for (let k = from; k <= column; k++) this.low[k % size] = this.high[k % size] = this.newest < 0 ? now : this.last;
        this.newest = column;
      }
      if (now < this.low[place]) this.low[place] = now;
      if (now > this.high[place]) this.high[place] = now;
      this.last = now;
    }
    this.seen = rows.count;
  }

  /** Largest absolute value that is shown. */
  most() {
    let most = 0;
    for (let i = 0; i < this.low.length; i++) most = Math.max(most, -this.low[i] || 0, this.high[i] || 0);
    return most;
  }

  /** Draw the columns from one on, the first at `left`; equal ones side by side as one. */
  draw(context, first, left, y, thickness, dotted) {
    const size = this.low.length;
    const begin = Math.max(first, this.newest - size + 1);
    for (let column = begin; column <= this.newest;) {
      const low = this.low[column % size], high = this.high[column % size];
      let end = column + 1;
      while (end <= this.newest && (!dotted || end % 4) && this.low[end % size] === low && this.high[end % size] === high) {
        end++;
      }
      if (low === low) {
        const top = Math.min(y(high), y(low)), height = Math.abs(y(high) - y(low));
        const wide = dotted ? Math.max(1, Math.min(2, end - column)) : end - column;
        context.fillRect(left + column - first, top - thickness / 2, wide, height + thickness);
      }
      column = end;
    }
  }
}
