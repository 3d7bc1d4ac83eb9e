"use strict";
// Drawing of a stage in a vertical plane: the stator with its coils above, the mover with its magnets below.
// Widths are to scale, by the motor's data sheet in mm; heights are stretched.
const SLOTS = 15;           // shown
const POLES = 4;            // shown
// Phase and direction of winding of successive slots: one slot for each pole and phase.
const WINDING = [[0, 1], [2, -1], [1, 1], [0, -1], [2, 1], [1, -1]];
const VIEW = { width: 420, height: 300, along: 1.1, up: 4.0, stator: 66 };   // px, px/mm of displacement, px/mm of gap

const svgText = (parent, x, y, text, attributes = {}) => svg("text", { x, y, "text-anchor": "middle", ...attributes }, parent, text);

/** Stator: iron with slots, and in each slot a coil side. Returns the coil sides. */
function drawStator(parent, sheet) {
  const pitch = sheet.slot_pitch * VIEW.along;
  const width = sheet.slot_width * VIEW.along;
  const left = (VIEW.width - SLOTS * pitch) / 2;
  svg("rect", { x: left, y: 12, width: SLOTS * pitch, height: 18, style: "fill: var(--iron)" }, parent);
  const coils = [];
  for (let k = 0; k <= SLOTS; k++) {
    // Between two slots a tooth; the outermost ones are half.
    const start = Math.max(left, left + k * pitch - (pitch - width) / 2);
    const end = Math.min(left + SLOTS * pitch, left + k * pitch + (pitch - width) / 2);
    svg("rect", { x: start, y: 30, width: end - start, height: VIEW.stator - 30, style: "fill: var(--iron)" }, parent);
    if (k === SLOTS) break;
    const [phase, direction] = WINDING[k % WINDING.length];
    const centre = left + (k + 0.5) * pitch;
    const frame = { x: centre - width / 2 + 1, y: 33, width: width - 2, height: VIEW.stator - 36, rx: 2 };
    const style = `fill: var(--phase-${phase}); stroke: var(--phase-${phase})`;
    const area = svg("rect", { ...frame, style }, parent);
    const sign = svgText(parent, centre, 53, "", { style: "font-size: 15px; font-weight: 700" });
    coils.push({ phase, direction, area, sign });
  }
  return coils;
}

/** Mover: magnets of alternating polarity on an iron yoke, its upper face at y = 0, its middle at x = 0. */
function drawMover(parent, sheet) {
  const group = svg("g", {}, parent);
  const pole = sheet.pole_pitch * VIEW.along;
  svg("rect", { x: -POLES / 2 * pole, y: 20, width: POLES * pole, height: 16, style: "fill: var(--iron)" }, group);
  for (let k = 0; k < POLES; k++) {
    const x = (k - POLES / 2) * pole + 0.1 * pole;
    const north = k % 2 === 0;
    svg("rect", { x, y: 0, width: 0.8 * pole, height: 20, style: `fill: var(--${north ? "north" : "south"})` }, group);
    svgText(group, x + 0.4 * pole, 14, north ? "N" : "S", { style: "fill: var(--paper); font-weight: 700" });
  }
  svg("path", { d: "M0 38 l-5 9 h10 z", style: "fill: var(--text)" }, group);
  return group;
}

/** Ruler of displacements at the bottom, scale of gaps on the left. */
function drawScales(parent) {
  const middle = VIEW.width / 2;
  const line = { style: "stroke: var(--faint); stroke-width: 1" };
  for (let mm = -50; mm <= 50; mm += 10) {
    const x = middle + mm * VIEW.along;
    svg("line", { x1: x, x2: x, y1: 268, y2: mm % 50 ? 273 : 277, ...line }, parent);
    if (mm % 50 === 0) svgText(parent, x, 290, mm ? `${mm < 0 ? "−" : ""}${Math.abs(mm)}` : "0 mm");
  }
  svg("line", { x1: middle - 50 * VIEW.along, x2: middle + 50 * VIEW.along, y1: 268, y2: 268, ...line }, parent);
  for (let mm = 0; mm <= 30; mm += 10) {
    const y = VIEW.stator + mm * VIEW.up;
    svg("line", { x1: 26, x2: 34, y1: y, y2: y, ...line }, parent);
    svgText(parent, 22, y + 4, String(mm), { "text-anchor": "end" });
  }
  svg("line", { x1: 30, x2: 30, y1: VIEW.stator, y2: VIEW.stator + 30 * VIEW.up, ...line }, parent);
  svgText(parent, 8, VIEW.stator + 30 * VIEW.up + 20, "gap, mm", { "text-anchor": "start" });
}

/** A view of the stage; returns a function that shows positions and references (mm, tilts in mrad) and phase currents (A). */
function stageView(parent, title, sheet) {
  const figure = html("figure", {}, parent);
  html("figcaption", {}, figure, title);
  const picture = svg("svg", { viewBox: `0 0 ${VIEW.width} ${VIEW.height}`, role: "img", "aria-label": title }, figure);
  drawScales(picture);
  const coils = drawStator(picture, sheet);
  const mover = drawMover(picture, sheet);
  const width = POLES * sheet.pole_pitch * VIEW.along;
  const ghost = svg("rect", { x: -width / 2, y: 0, width, height: 36,
    style: "fill: none; stroke: var(--text); stroke-width: 1.2; stroke-dasharray: 5 4" }, picture);
  // Heights at the ends of a mover that tilts (mrad) are stretched as the gap is.
  const place = (element, { along, gap, tilt }) => element.setAttribute("transform",
    `translate(${(VIEW.width / 2 + along * VIEW.along).toFixed(2)} ${(VIEW.stator + gap * VIEW.up).toFixed(2)})`
    + (tilt ? ` rotate(${(1e-3 * tilt * VIEW.up / VIEW.along * 180 / Math.PI).toFixed(3)})` : ""));
  return ({ position, reference, currents, peak }) => {
    place(mover, position);
    place(ghost, reference);
    for (const { phase, direction, area, sign } of coils) {
      const current = direction * (currents[phase] ?? 0);
      const strength = peak > 0 ? Math.min(1, Math.abs(current) / peak) : 0;
      area.setAttribute("fill-opacity", (0.08 + 0.82 * strength).toFixed(3));
      // Out of the plane or into it, as the point and the feathers of an arrow.
      sign.textContent = strength < 0.03 ? "" : current > 0 ? "•" : "×";
    }
  };
}
