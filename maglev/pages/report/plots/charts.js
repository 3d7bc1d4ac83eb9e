"use strict";
// Charts of what the procedures found: curves over an air gap, a time or what else, in the units that they are given in.
const HUES = 5;   // colours of curves; further ones differ by dash or symbol

/** Panels of a chart. Kin, or else a label, has one colour in all of them. */
function chartPanels(panels) {
  const kins = [...new Set(panels.flatMap(({ curves }) => curves.map(({ kin }) => kin)))];
  return panels.map(({ x: xTitle, y: title, curves }) => {
    const unit = / \((.*)\)$/.exec(title)?.[1] ?? "";
    const places = curves.flatMap(({ x }) => x).filter((value) => value !== null);
    const air = 0.03 * (Math.max(...places) - Math.min(...places)) || 1;
    return {
      title, xTitle, low: Math.min(...places) - air, high: Math.max(...places) + air, logarithmic: false,
      format: (value) => shortNumber(value), levels: [], areas: [], instants: [], windows: [], marks: [],
      lines: curves.map(({ label, kin, marked, x, y, margin = null }) => {
        const k = kins.indexOf(kin);
        const round = Math.floor(k / HUES);
        return {
          name: label, css: `run-${k % HUES}`, dash: RUN_DASHES[round % RUN_DASHES.length], x, y, margin, unit, note: unit && ` ${unit}`,
          symbol: Object.keys(SYMBOLS)[round % 4], marked: marked || x.length < 2,
          ascending: !marked && x.every((value, at) => value !== null && (at === 0 || value >= x[at - 1])),
        };
      }),
    };
  });
}
