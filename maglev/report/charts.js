"use strict";
// Charts of what the procedures found: curves over an air gap, a time or what else, in the units that they are given in.
const SYMBOLS = ["circle", "square", "diamond", "cross"];
const HUES = 5;   // colours of curves; further ones differ by dash or symbol

/** Text that plotly shows as it is: plotly reads some tags. */
function plain(text) {
  return text.replace(/&/g, "&amp;").replace(/</g, "&lt;").replace(/>/g, "&gt;");
}

function panelAxis(letter, p) {
  return p === 0 ? letter : `${letter}${p + 1}`;
}

function chartTraces(panels) {
  // Kin, or else a label, has one colour in all panels; a label is in the legend once.
  const kins = [...new Set(panels.flatMap(({ curves }) => curves.map(({ kin }) => kin)))];
  const inLegend = new Set();
  return panels.flatMap(({ curves }, p) => curves.map(({ label, kin, marked, x, y }) => {
    const k = kins.indexOf(kin);
    const hue = colour(`series-${k % HUES}`);
    const round = Math.floor(k / HUES) % DASHES.length;
    const first = !inLegend.has(label);
    inLegend.add(label);
    return {
      x, y, type: "scatter", mode: marked || x.length < 2 ? "markers" : "lines", name: plain(label),
      legendgroup: label, showlegend: first, xaxis: panelAxis("x", p), yaxis: panelAxis("y", p),
      line: { color: hue, width: 1.5, dash: DASHES[round], simplify: false }, marker: { color: hue, size: 7, symbol: SYMBOLS[round] },
      hovertemplate: "%{y:.5~g} at %{x:.5~g}<extra>%{fullData.name}</extra>",
    };
  }));
}

function chartLayout(panels, height) {
  const axis = axisStyle();
  const result = commonLayout(height);
  const count = panels.length;
  const space = 0.28 / count;   // between panels, for the title of the abscissae
  const size = (1 - (count - 1) * space) / count;
  panels.forEach(({ x, y }, p) => {
    const top = 1 - p * (size + space);
    const id = p === 0 ? "" : String(p + 1);
    result[`xaxis${id}`] = { ...axis, anchor: panelAxis("y", p), title: { text: plain(x), standoff: 6 } };
    result[`yaxis${id}`] = { ...axis, anchor: panelAxis("x", p), domain: [Math.max(0, top - size), top],
      title: { text: plain(y), font: { size: 11 }, standoff: 10 } };
  });
  return result;
}
