"use strict";
// Reference signals of a run over time, in SI, as maglev.schema.signals has them: the same bits.

const TIME_TOLERANCE = 1e-9;   // s; a step at a multiple of the communication step must not be missed by rounding

function envelope(signal, t) {
  if (t >= signal.ramp) return 1;
  const s = Math.max(t, 0) / signal.ramp;
  return s * s * (3 - 2 * s);
}

function envelopeRate(signal, t) {
  if (t >= signal.ramp) return 0;
  const s = Math.max(t, 0) / signal.ramp;
  return 6 * s * (1 - s) / signal.ramp;
}

const oscillation = (signal, t) => signal.terms
  .reduce((sum, { amplitude, omega, phase }) => sum + amplitude * sine_cosine(omega * t + phase)[0], 0);

const slope = (signal, t) => signal.terms
  .reduce((sum, { amplitude, omega, phase }) => sum + amplitude * omega * sine_cosine(omega * t + phase)[1], 0);

/** Value of a signal at a time (s). */
function signalValue(signal, t) {
  if (signal.kind === "constant") return signal.level;
  if (signal.kind === "sinusoids") return signal.offset + envelope(signal, t) * oscillation(signal, t);
  let k = signal.times.length - 1;
  while (k > 0 && signal.times[k] > t + TIME_TOLERANCE) k--;
  return signal.values[k];
}

/** Rate of a signal at a time (s): none of steps. */
function signalRate(signal, t) {
  if (signal.kind !== "sinusoids") return 0;
  return envelopeRate(signal, t) * oscillation(signal, t) + envelope(signal, t) * slope(signal, t);
}
