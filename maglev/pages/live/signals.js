"use strict";
// Reference signals of a run over time, in SI, as maglev.scenario has them: the same bits.

const TIME_TOLERANCE = 1e-9;   // s; a step at a multiple of the communication step must not be missed by rounding

/** Sum of sinusoids under its ramp at a time (s), and its rate. */
function oscillation({ ramp, terms }, t) {
  let [sum, slope] = [0, 0];
  for (const { amplitude, omega, phase } of terms) {
    const [sine, cosine] = sine_cosine(omega * t + phase);
    sum += amplitude * sine;
    slope += amplitude * omega * cosine;
  }
  if (t >= ramp) return [sum, slope];
  const s = Math.max(t, 0) / ramp, envelope = s * s * (3 - 2 * s);
  return [envelope * sum, 6 * s * (1 - s) / ramp * sum + envelope * slope];
}

/** Value of a signal at a time (s). */
function signalValue(signal, t) {
  if (signal.kind === "constant") return signal.level;
  if (signal.kind === "sinusoids") return signal.offset + oscillation(signal, t)[0];
  let k = signal.times.length - 1;
  while (k > 0 && signal.times[k] > t + TIME_TOLERANCE) k--;
  return signal.values[k];
}

/** Rate of a signal at a time (s): none of steps. */
const signalRate = (signal, t) => (signal.kind === "sinusoids" ? oscillation(signal, t)[1] : 0);
