"use strict";
// The results in this page: runs with their packed signals, figures, names of the runs to show moving.
const report = JSON.parse(document.getElementById("data").textContent);
const errors = [];
const ready = {};    // decoded runs by name: signal name -> { times (s), values (SI), tolerance }
const pending = {};  // promises of the same

function fail(error) {
  errors.push(String(error && error.stack ? error.stack : error));
}
window.maglevReport = { errors };   // for tests
window.addEventListener("error", (event) => fail(event.error || event.message));
window.addEventListener("unhandledrejection", (event) => fail(event.reason));

/** Integers (count) that the page has as differences of 32 bits, lowest bytes first, from a position on; the lowest bit is
 * the sign. */
function integers(bytes, start, count) {
  const result = new Float64Array(count);
  let sum = 0;
  for (let k = 0; k < count; k++) {
    const at = start + k;
    const bits = bytes[at] | (bytes[at + count] << 8) | (bytes[at + 2 * count] << 16) | (bytes[at + 3 * count] << 24);
    sum += (bits >>> 1) ^ -(bits & 1);
    result[k] = sum;
  }
  return result;
}

/** Decode the signals of a run; a second call returns the same promise. */
function decodeRun(name) {
  pending[name] ??= (async () => {
    const run = report.runs[name];
    const bytes = await unpacked(run.data);
    const signals = {};
    let start = 0;
    for (const [signal, { rows, quantum, tolerance }] of Object.entries(run.signals)) {
      const times = integers(bytes, start, rows).map((count) => count * run.time);
      const values = integers(bytes, start + 4 * rows, rows).map((count) => count * quantum);
      signals[signal] = { times, values, tolerance };
      start += 8 * rows;
    }
    ready[name] = signals;
    return signals;
  })();
  return pending[name];
}

/** Value (SI) of a signal at a time (s), on the straight line between its neighbours. */
function valueAt({ times, values }, time) {
  const k = firstFrom(times, time);
  if (k === 0 || k === times.length) return values[k && k - 1];   // before the first, after the last
  return values[k - 1] + (values[k] - values[k - 1]) * (time - times[k - 1]) / (times[k] - times[k - 1]);
}

// The text before a button is copied.
document.addEventListener("click", async ({ target }) => {
  if (!target.matches("button.copy")) return;
  await navigator.clipboard.writeText(target.previousElementSibling.textContent);
  target.textContent = "Copied";
});
