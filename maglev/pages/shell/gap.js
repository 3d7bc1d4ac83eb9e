"use strict";
// The air gap, several times as large as the stage next to it: stops, a scale, and each mover in the colour of its
// controller.

const BLOCK = 38, HEAD = 32, FOOT = 4;   // px: a mover's height, above the upper stop, below the lowest mover
const BEYOND = 0.5;                         // mm that are seen beyond the stops

/** Place of the gap on a canvas (px), and px for 1 mm. */
function gapView(run, box, ends) {
  const [low, high] = ends.map((end) => 1e3 * end), scale = (box.height - HEAD - BLOCK - FOOT) / (high - low + 2 * BEYOND);
  return { kind: "gap", ...box, run, low, high, scale, y: (mm) => box.top + HEAD + (mm - low + BEYOND) * scale };
}

/** Heights (mm) of a mover's face at its left and its right end: of one that tilts that of the motor farthest out. */
function faceOf(run, row, what = "position") {
  const gap = 1e3 * row.axes[run.vertical][what], [tilt] = Object.values(run.stage.tilts);
  const slope = tilt ? tilt.sign * row.axes[tilt.axis][what] * 1e3 * Math.max(...Object.values(run.stage.places).flat(2)) : 0;
  return [gap - slope, gap + slope];
}

/** Place (px) across of a mover: each has a column of its own. */
function columnOfMover(view, k, count) {
  const left = view.left + 40, right = view.left + view.width - 10, wide = (right - left - 8 * (count - 1)) / count;
  return [left + k * (wide + 8), wide];
}

function drawGap(context, view, movers, look, spaceScale, colours) {
  const { run, left, top, width, height, low, high, scale, y } = view, right = left + width;
  context.beginPath();
  context.roundRect(left, top, width, height, 6);
  fill(context, colours.panel);
  write(context, `air gap ${run.vertical}, ×${Math.round(scale / spaceScale)}`, left + 8, top + 5, colours.text, { font: "600 12px", base: "top" });
  // The stator is above, farther off than there is room for.
  context.fillStyle = colours.iron;
  context.fillRect(left + 40, top + 22, width - 50, 7);
  write(context, "stator", right - 10, top + 5, colours.faint, { align: "right", base: "top" });
  const step = tickStep(high - low, scale > 9 ? 14 : 7);
  for (let mm = step * Math.ceil(low / step); mm <= high; mm += step) {
    line(context, [[left + 34, y(mm)], [right - 10, y(mm)]], colours.line);
    if (Math.round(mm) % 5 === 0) write(context, `${Number(mm.toFixed(1))}`, left + 30, y(mm), colours.faint, { align: "right" });
  }
  write(context, "mm", left + 30, y(low) - 8, colours.faint, { align: "right" });
  for (const end of [low, high]) {
    const hit = (look.hits ?? []).find((each) => Math.abs(1e3 * each.end - end) < 1e-6), colour = hit ? colours.bad : colours.text;
    line(context, [[left + 36, y(end)], [right - 6, y(end)]], colour, hit ? 3 : 1.5, hit ? [] : [9, 5]);
    if (!hit) write(context, "stop", right - 12, y(end) + 8, colours.faint, { align: "right" });
  }
  movers.forEach((mover, k) => drawMover(context, view, mover, columnOfMover(view, k, movers.length), colours));
  // They stay to be read, above each other.
  (look.hits ?? []).forEach(({ end, text }, k) => write(context, text, right - 10, y(1e3 * end) - 9 - 14 * k, colours.bad, { align: "right", font: "600 12px", halo: colours.panel }));
  if (look.forces) {
    const [x, wide] = columnOfMover(view, 0, movers.length), at = y(faceOf(run, movers[0].row)[0]);
    const newton = Math.min(0.6, 0.9 * (height - HEAD) / 4 / look.forces.weight), down = newton * look.forces.weight;
    const lift = (look.hits ?? []).length ? "" : "lift";   // a message names the stop that it has hit
    arrow(context, x + 0.2 * wide, at, 0, -newton * look.forces.lift, lift, colours, colours.panel);
    // There is no room for it if a mover is on its lower stop.
    if (at + BLOCK + down + 7 < top + height) arrow(context, x + 0.2 * wide, at + BLOCK, 0, down, "weight", colours, colours.panel);
  }
}

function drawMover(context, { run, y, scale, top }, { row, name, colour, weight }, [x, wide], colours) {
  const [from, to] = faceOf(run, row), corner = (share, below) => [x + share * wide, y(from + share * (to - from)) + below];
  polygon(context, [corner(0, 0), corner(1, 0), corner(1, BLOCK), corner(0, BLOCK)]);
  fill(context, colour);
  for (let k = 0; k < 2 * POLES; k++) {
    const [a, b] = [k + 0.12, k + 0.88].map((at) => at / 2 / POLES);
    polygon(context, [corner(a, 0), corner(b, 0), corner(b, 7), corner(a, 7)]);
    fill(context, k % 2 ? colours.south : colours.north);
  }
  const wanted = faceOf(run, row, "reference");
  line(context, [[x - 4, y(wanted[0])], [x + wide + 4, y(wanted[1])]], colours.text, 1.5, DASHED);
  const [middle, at] = corner(0.5, 0), gap = 1e3 * row.axes[run.vertical].position;
  context.save();
  context.translate(middle, at);
  context.rotate(Math.atan2(y(to) - y(from), wide));
  write(context, name, 0, 17, colours.paper, { font: "600 11px", align: "center", most: wide - 4, halo: colour });
  write(context, `${gap.toFixed(2)} mm`, 0, 31, colours.paper, { font: "600 12px", align: "center", most: wide - 4, halo: colour });
  context.restore();
  if (!weight) return;
  // On the end of the mover that no stator is above.
  const size = Math.max(18, Math.min(46, 34 * Math.cbrt(weight.mass))), [right, face] = corner(0.86, 0);
  const bottom = face - scale * weight.above;
  if (bottom < top) return;
  context.fillStyle = colours.weight;
  context.fillRect(right - size / 2, bottom - size, size, size);
  write(context, `${Number(weight.mass.toFixed(2))} kg`, right, bottom - size / 2, colours.paper, { font: "600 11px", align: "center" });
}
