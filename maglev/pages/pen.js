"use strict";
// What is drawn on the canvases, in px of the page: texts, lines through points, shapes.

/** Write a text at a place, narrower where it is wider than the most (px); a halo keeps lines below it from its letters. */
function write(context, text, x, y, colour, { font = "11px", align = "left", base = "middle", most, halo } = {}) {
  context.font = `${font} system-ui, sans-serif`;
  context.textAlign = align;
  context.textBaseline = base;
  if (halo) {
    Object.assign(context, { strokeStyle: halo, lineWidth: 3, lineJoin: "round" });
    context.strokeText(text, x, y, most);
  }
  context.fillStyle = colour;
  context.fillText(text, x, y, most);
}

/** Draw a line through points. */
function line(context, points, colour, width = 1, dash = []) {
  context.beginPath();
  for (const [x, y] of points) context.lineTo(x, y);
  outline(context, colour, width, dash);
}

/** Draw the line of the path that there is. */
function outline(context, colour, width = 1, dash = []) {
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.setLineDash(dash);
  context.stroke();
  context.setLineDash([]);
}

/** Make a path around points. */
function polygon(context, points) {
  context.beginPath();
  for (const [x, y] of points) context.lineTo(x, y);
  context.closePath();
}

const DASHED = [5, 4];   // px
