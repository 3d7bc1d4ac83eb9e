"use strict";
// Charts of the results of procedures: curves over an air gap, a time or another quantity, in the units of their data.
const HUES = 5;   // colours of curves; further ones differ by dash or symbol

/** Labels of an abscissa that is the logarithm of a frequency. */
const decadeTicks = ({ low, high }, most) => decades(10 ** low, 10 ** high, most / 3).map((value) => [Math.log10(value), shortNumber(value)]);

/** Panels of a chart. Kin, or else a label, has one colour in all of them. */
function chartPanels(panels) {
  const kins = [...new Set(panels.flatMap(({ curves }) => curves.map(({ kin }) => kin)))];
  return panels.map(({ x: xTitle, y: title, curves, decades = false, logarithmic = false }) => {
    const unit = / \((.*)\)$/.exec(title)?.[1] ?? "", abscissa = (x) => (decades ? x.map(Math.log10) : x);
    const places = abscissa(curves.flatMap(({ x }) => x).filter((value) => value !== null));
    const air = 0.03 * (Math.max(...places) - Math.min(...places)) || 1;
    return {
      title, xTitle, low: Math.min(...places) - air, high: Math.max(...places) + air, logarithmic,
      ...(decades && { ticks: decadeTicks, at: (x) => 10 ** x }),
      format: (value) => shortNumber(value), levels: [], areas: [], instants: [], windows: [], marks: [],
      lines: curves.map(({ label, kin, css, dash, marked, x, y, margin = null }) => {
        const k = kins.indexOf(kin);
        const round = Math.floor(k / HUES);
        return {
          name: label, css: css ?? `run-${k % HUES}`, dash: dash ?? RUN_DASHES[round % RUN_DASHES.length], x: abscissa(x), y, margin, unit, note: unit && ` ${unit}`,
          symbol: Object.keys(SYMBOLS)[round % 4], marked: marked || x.length < 2,
          ascending: !marked && x.every((value, at) => value !== null && (at === 0 || value >= x[at - 1])),
        };
      }),
    };
  });
}
