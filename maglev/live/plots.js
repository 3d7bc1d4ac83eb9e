"use strict";
// Plots that roll beside the stage: gap, displacements, errors (logarithmic), currents with limits, and the i_d–i_q plane.

const LEFT = 54, RIGHT = 10, TOP = 17, BOTTOM = 4;   // px around a strip
const LEAST_ERROR = 1e-6, LARGEST_ERROR = 0.1;       // m

/** Canvas as large as its place, in px of the page. */
function fitted(canvas) {
  const ratio = Math.min(2, devicePixelRatio || 1);
  const { clientWidth: width, clientHeight: height } = canvas;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  return { context, width, height };
}

const windowFor = (speed) => (speed < 0.5 ? 2 : speed > 2 ? 30 : 10);   // s shown

/** What a strip shows: lines with a colour and a function of a row, range, and levels that are marked. */
function stripsOf(run, values) {
  const { axes, motors } = run;
  const vertical = axes.findIndex((axis) => axis === run.vertical);
  const others = axes.map((_, i) => i).filter((i) => i !== vertical);
  const position = (i) => ({ colour: axes[i], value: (h, r) => 1e3 * h.at(r, columnOf.position(i)), name: axes[i] });
  const reference = (i) => ({ colour: axes[i], thin: true, step: true,
    value: (h, r) => 1e3 * h.at(r, columnOf.reference(i)) });
  const error = (i) => ({ colour: axes[i], name: axes[i], value: (h, r) => Math.log10(Math.max(LEAST_ERROR,
    Math.abs(h.at(r, columnOf.position(i)) - h.at(r, columnOf.reference(i))))) });
  const currents = [{ colour: run.vertical, name: "i_d", value: (h, r) => h.at(r, columnOf.direct(axes, 0)) },
    ...motors.map((motor, m) => ({ colour: run.drives[motor], name: motors.length > 1 ? `i_q ${motor}` : "i_q",
      value: (h, r) => h.at(r, columnOf.quadrature(axes, m)) }))];
  const stops = (axis) => ["lower", "upper"].map((end) => 1e3 * values(`plant.${axis}.stop.${end}`));
  const limit = values("controller.current_limit");
  const peak = values(`plant.${motors[0]}.amplifier.peak`);
  const shown = Math.max(1, limit || peak || 5);
  const gapStops = stops(run.vertical);
  const wide = Math.max(...others.map((i) => stops(axes[i])[1]));
  return [
    { title: "air gap, mm (downwards)", lines: [reference(vertical), position(vertical)], low: gapStops[1] + 1,
      high: gapStops[0] - 1, marks: gapStops, ticks: [20, 25, 30], format: (v) => String(v) },
    { title: "displacement, mm", lines: [...others.map(reference), ...others.map(position)], low: -wide, high: wide,
      auto: true, marks: [], format: (v) => String(v) },
    { title: "|error|", lines: axes.map((_, i) => error(i)), low: Math.log10(LEAST_ERROR),
      high: Math.log10(LARGEST_ERROR), marks: run.bands.map(Math.log10), decades: true, ticks: [-6, -4, -2] },
    { title: limit ? "current, A; limit dashed" : "current, A; peak dashed",
      lines: currents, low: -1.15 * shown, high: 1.15 * shown, marks: [-shown, shown],
      ticks: [-shown, 0, shown], format: (v) => String(v) },
  ];
}

const DECADES = { "-6": "1 µm", "-5": "10 µm", "-4": "0.1 mm", "-3": "1 mm", "-2": "10 mm", "-1": "0.1 m" };

function drawFrame(context, strip, box, colours) {
  const y = (value) => box.top + (strip.high - value) / (strip.high - strip.low) * box.height;
  context.font = "11px system-ui, sans-serif";
  context.textBaseline = "middle";
  context.fillStyle = colours.faint;
  context.strokeStyle = colours.line;
  context.lineWidth = 1;
  context.setLineDash([]);
  for (const tick of strip.ticks) {
    const at = Math.round(y(tick)) + 0.5;
    context.beginPath();
    context.moveTo(box.left, at);
    context.lineTo(box.left + box.width, at);
    context.stroke();
    context.textAlign = "right";
    context.fillText(strip.decades ? DECADES[tick] : strip.format(tick).replace("-", "−"), box.left - 5, at);
  }
  context.setLineDash([5, 4]);
  context.strokeStyle = colours.faint;
  for (const mark of strip.marks) {
    context.beginPath();
    context.moveTo(box.left, y(mark));
    context.lineTo(box.left + box.width, y(mark));
    context.stroke();
  }
  context.setLineDash([]);
  context.textAlign = "left";
  context.fillStyle = colours.text;
  context.fillText(strip.title, box.left, box.top - 8);
  let right = box.left + box.width;
  context.textAlign = "right";
  for (const { name, colour } of strip.lines.filter((line) => line.name).reverse()) {
    context.fillStyle = colours[colour];
    context.fillText(`— ${name}`, right, box.top - 8);
    right -= context.measureText(`— ${name}`).width + 12;
  }
  return y;
}

/** A line of the history: of each pixel's column the first, the least and the largest value, and the last. */
function drawLine(context, history, value, since, box, x, y) {
  context.beginPath();
  const first = Math.max(history.first, history.since(since) - 1);
  let column = -1, low = 0, high = 0, last = 0, begun = false;
  const flush = () => {
    if (column < 0) return;
    const at = box.left + column;
    if (!begun) context.moveTo(at, y(low)); else context.lineTo(at, y(low));
    begun = true;
    if (high !== low) context.lineTo(at, y(high));
    if (last !== high) context.lineTo(at, y(last));
  };
  for (let row = first; row < history.count; row++) {
    const at = Math.max(0, Math.floor(x(history.at(row, 0)))), now = value(history, row);
    if (at !== column) {
      flush();
      column = at;
      low = high = now;
    }
    if (now < low) low = now;
    if (now > high) high = now;
    last = now;
  }
  flush();
  context.stroke();
}

/** Range of a strip that follows its lines, widened to tens. */
function ranged(strip, history, since) {
  if (!strip.auto) return strip;
  let most = 10;
  for (let row = history.since(since); row < history.count; row += 8) {
    for (const line of strip.lines) most = Math.max(most, Math.abs(line.value(history, row)));
  }
  most = Math.min(strip.high, 10 * Math.ceil(1.05 * most / 10));
  return { ...strip, low: -most, high: most, ticks: [-most / 2, 0, most / 2] };
}

function drawStrips(canvas, strips, history, ghost, span, colours) {
  const { context, width, height } = fitted(canvas);
  const now = history.last()?.time ?? 0, since = Math.max(0, now - span);
  const each = (height - 16) / strips.length;
  strips.forEach((planned, i) => {
    const strip = ranged(planned, history, since);
    const box = { left: LEFT, top: i * each + TOP, width: width - LEFT - RIGHT, height: each - TOP - BOTTOM };
    const y = drawFrame(context, strip, box, colours);
    const x = (time) => (time - since) / span * box.width;
    context.save();
    context.beginPath();
    context.rect(box.left, box.top, box.width, box.height);
    context.clip();
    for (const line of strip.lines) {
      context.strokeStyle = colours[line.colour];
      context.lineWidth = line.thin ? 1 : 1.6;
      context.setLineDash(line.thin ? [2, 3] : []);
      if (ghost && !line.thin) {
        context.globalAlpha = 0.45;
        drawLine(context, ghost, line.value, since, box, x, y);
      }
      context.globalAlpha = line.thin ? 0.8 : 1;
      drawLine(context, history, line.value, since, box, x, y);
      context.globalAlpha = 1;
    }
    context.restore();
  });
  context.setLineDash([]);
  context.fillStyle = colours.faint;
  context.textBaseline = "bottom";
  for (let second = Math.ceil(since); second <= now; second++) {
    if (second < 0 || (span > 10 && second % 5)) continue;
    context.textAlign = "center";
    context.fillText(`${second} s`, LEFT + (second - since) / span * (width - LEFT - RIGHT), height);
  }
}

/** The plane of the direct and the quadrature current: where each motor is and has been for a moment, and its limits. */
function drawPlane(canvas, run, history, ghost, values, colours) {
  const { context, width, height } = fitted(canvas);
  const limit = values("controller.current_limit"), peak = values(`plant.${run.motors[0]}.amplifier.peak`);
  const most = 1.25 * Math.max(limit, limit ? 0 : peak, 1), size = Math.min(width - 50, height - 42);
  const left = (width - size) / 2 + 8, top = 18;
  const x = (amperes) => left + (amperes / most + 1) / 2 * size, y = (amperes) => top + (1 - amperes / most) / 2 * size;
  context.font = "11px system-ui, sans-serif";
  context.strokeStyle = colours.line;
  context.lineWidth = 1;
  context.setLineDash([]);
  context.strokeRect(left, top, size, size);
  context.beginPath();
  context.moveTo(x(0), y(-most));
  context.lineTo(x(0), y(most));
  context.moveTo(x(-most), y(0));
  context.lineTo(x(most), y(0));
  context.stroke();
  context.fillStyle = colours.text;
  context.textAlign = "center";
  context.textBaseline = "alphabetic";
  context.fillText("i_q over i_d, A; limit dashed", left + size / 2, top - 6);
  context.fillStyle = colours.faint;
  for (const tick of [-1, 1]) {
    const value = limit || peak || 1;
    context.fillText(`${tick < 0 ? "−" : ""}${value}`, x(tick * value), top + size + 14);
    context.fillText(`${tick < 0 ? "−" : ""}${value}`, left - 14, y(tick * value) + 4);
  }
  context.setLineDash([5, 4]);
  context.strokeStyle = colours.faint;
  if (limit) context.strokeRect(x(-limit), y(limit), x(limit) - x(-limit), y(-limit) - y(limit));
  context.setLineDash([]);
  run.motors.forEach((motor, m) => {
    for (const [flown, alpha] of [[ghost, 0.4], [history, 1]]) {
      if (!flown?.count) continue;
      context.strokeStyle = context.fillStyle = colours[run.drives[motor]];
      context.globalAlpha = 0.5 * alpha;
      context.beginPath();
      for (let row = Math.max(flown.first, flown.count - 250); row < flown.count; row += 2) {
        context.lineTo(x(flown.at(row, columnOf.direct(run.axes, m))), y(flown.at(row, columnOf.quadrature(run.axes, m))));
      }
      context.stroke();
      context.globalAlpha = alpha;
      context.beginPath();
      const last = flown.last().motors[motor];
      context.arc(x(last.d), y(last.q), 5, 0, 2 * Math.PI);
      context.fill();
      context.globalAlpha = 1;
    }
  });
}
