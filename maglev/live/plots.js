"use strict";
// Plots that roll beside the stage: gap, displacements, errors (logarithmic), currents with limits.

const LEFT = 54, RIGHT = 10, TOP = 17, BOTTOM = 4;   // px around a strip
const LARGEST_ERROR = 0.1;                           // m, rad

const windowFor = (speed) => (speed < 0.5 ? 2 : speed > 2 ? 30 : 10);   // s shown

/** What a strip of the rig shows beside its panel: lines with a colour and a function of a row, range, levels that are marked.
 *
 * Of one controller lines have the colours of the axes, of two, by their names, those of the controllers: there errors of the gap
 * are apart, and no currents. */
function stripsOf(run, values, names = null) {
  if (!names) return run.rig.strips.map((panel) => ({ ...panel, ...STRIPS[panel.kind](run, panel, values) }));
  const kinds = [[run.vertical], run.axes.filter((axis) => axis !== run.vertical)];
  const panels = run.rig.strips.filter(({ kind }) => kind !== "currents").flatMap((panel) => (panel.kind !== "error" ? [panel]
    : kinds.map((axes) => ({ ...panel, axes, title: panel.title.replace("axes", axes.join(", ")) }))));
  return panels.map((panel, i) => {
    const { lines, ...strip } = { ...panel, ...STRIPS[panel.kind](run, panel, values) };
    return { ...strip, names: i ? [] : [[names[0], "ours"], [names[1], "other"]],
      lines: lines.map((line) => ({ ...line, colour: line.thin ? "reference" : "ours" })) };
  });
}

const STRIPS = {
  position(run, { axes, scale, down, unit }, values) {
    const lines = axes.flatMap((axis) => {
      const i = run.axes.indexOf(axis);
      return [{ colour: axis, thin: true, value: (h, r) => scale * h.at(r, columnOf.reference(i)) },
        { colour: axis, name: axis, value: (h, r) => scale * h.at(r, columnOf.position(i)) }];
    });
    const ends = axes.flatMap((axis) => endsOf(run, axis, values).map((end) => scale * end));
    if (down) return { lines, low: ends[0] - 1, high: ends[1] + 1, marks: ends };
    const wide = Math.max(...ends);
    return { lines, low: -wide, high: wide, tens: unit === "mm" ? 10 : 4, marks: [] };
  },
  error(run, { axes, scale, floor, title, unit }) {
    const lines = axes.map((axis) => {
      const i = run.axes.indexOf(axis);
      return { colour: axis, value: (h, r) => Math.max(floor, scale * Math.abs(h.at(r, columnOf.position(i)) - h.at(r, columnOf.reference(i)))) };
    });
    return { lines, title: axes.some((axis) => isTilt(run, axis)) ? `${title}, of tilts in mrad` : title, low: floor, high: scale * LARGEST_ERROR,
      logarithmic: unit, marks: run.bands.map((band) => scale * band) };
  },
  currents(run, { title }, values) {
    // Motors that drive one axis have one colour and one name.
    const first = (motor) => motorsOf(run, run.drives[motor])[0] === motor, { axes, motors } = run;
    const lines = [...motors.map((_, m) => ({ colour: run.vertical, name: m ? "" : "i_d", value: (h, r) => h.at(r, columnOf.direct(axes, m)) })),
      ...motors.map((motor, m) => ({ colour: run.drives[motor], name: first(motor) ? `i_q ${run.drives[motor]}` : "",
        value: (h, r) => h.at(r, columnOf.quadrature(axes, m)) }))];
    const limit = values("controller.current_limit"), shown = Math.max(1, limit || values(`plant.${motors[0]}.amplifier.peak`) || 5);
    return { lines, title: `${title}; ${limit ? "limit" : "peak"} dashed`, low: -1.15 * shown, high: 1.15 * shown, marks: [-shown, shown] };
  },
};

const LABEL = 13;   // px that a label on an axis takes

/** Scale of a strip in a place on the page (px). */
const scaleIn = ({ low, high, down, logarithmic = false }, top, height) =>
  scaleOf(low, high, ...(down ? [top, top + height] : [top + height, top]), logarithmic);

function drawFrame(context, strip, box, colours) {
  const scale = scaleIn(strip, box.top, box.height), y = scale.place;
  const right = box.left + box.width, across = (at) => [[box.left, at], [right, at]];
  const ticks = scale.ticks(5), every = Math.ceil(LABEL * ticks.length / box.height);
  for (const [value, text] of ticks.filter((_, k) => k % every === 0)) {
    const at = Math.round(y(value)) + 0.5;
    line(context, across(at), colours.line);
    write(context, text, box.left - 5, at, colours.faint, { align: "right" });
  }
  for (const mark of strip.marks) line(context, across(y(mark)), colours.faint, 1, DASHED);
  let end = right;
  for (const [name, colour] of (strip.names ?? strip.lines.filter((each) => each.name).map((each) => [each.name, each.colour])).reverse()) {
    write(context, `— ${name}`, end, box.top - 8, colours[colour], { align: "right" });
    end -= context.measureText(`— ${name}`).width + 12;
  }
  const room = context.measureText(strip.title).width < end - box.left;
  write(context, room ? strip.title : strip.title.split(";")[0], box.left, box.top - 8, colours.text);
}

/** Plots of a flight and of the one that flies along. Lines stay where they are drawn and are moved: only new ones cost. */
class Strips {
  constructor(strips, span) {
    this.strips = strips;
    this.span = span;
    this.lines = new Map();   // traces of each line, of both flights
    this.picture = document.createElement("canvas");   // the lines alone, in px of the screen
    this.key = "";            // what the picture holds; if it is another one, all is drawn anew
    this.drawn = -1;          // column that was drawn last, counted from time 0
  }

  /** Traces of a line of a flight, up to date. */
  trace(line, rows) {
    const lines = this.lines.get(rows) ?? this.lines.set(rows, new Map()).get(rows);
    const trace = lines.get(line) ?? lines.set(line, new Trace(line.value, this.bucket, this.columns + 2)).get(line);
    trace.update(rows);
    return trace;
  }

  /** Draw, unless so little has happened that nothing would move by two px. */
  draw(canvas, rows, ghost, colours, now) {
    const { context, width, height, ratio } = sized(canvas, false);
    this.columns = Math.round((width - LEFT - RIGHT) * ratio);
    if (this.columns < 1) return;   // there is no room for a line
    this.bucket = this.span / this.columns;
    const latest = Math.floor(rows.last().time / this.bucket);
    if (!now && this.key && latest >= this.drawn && latest - this.drawn < 2) return;
    for (const flight of [...this.lines.keys()]) if (flight !== rows && flight !== ghost) this.lines.delete(flight);
    const size = `${width} ${height} ${ratio}`;
    if (!this.key.startsWith(size)) this.lines.clear();
    const each = (height - 16) / this.strips.length;
    const shown = this.strips.map((planned, i) => {
      const flown = planned.lines.map((line) => [line, this.trace(line, rows), ghost && !line.thin && this.trace(line, ghost)]);
      return { strip: ranged(planned, flown), flown, top: i * each + TOP, height: each - TOP - BOTTOM };
    });
    const key = `${size} ${shown.map(({ strip }) => strip.high)} ${rows.number} ${ghost?.number ?? ""} ${Object.values(colours)}`;
    this.drawLines(shown, latest, key, ratio, height, colours);
    context.clearRect(0, 0, width, height);
    for (const { strip, top, height: tall } of shown) {
      drawFrame(context, strip, { left: LEFT, top, width: width - LEFT - RIGHT, height: tall }, colours);
    }
    context.drawImage(this.picture, LEFT, 0, this.columns / ratio, height);
    this.drawTimes(context, Math.max(0, latest - this.columns + 1) * this.bucket, this.bucket * ratio, height, colours);
  }

  /** Bring the picture of the lines up to a column: moved to the left, and with what is new. */
  drawLines(shown, latest, key, ratio, height, colours) {
    const { picture, columns } = this, context = picture.getContext("2d"), tall = Math.round(height * ratio);
    const first = Math.max(0, latest - columns + 1);
    let begin = Math.max(first, this.drawn);
    if (key !== this.key || latest < this.drawn || this.drawn < first) {
      picture.width = columns;   // which empties it
      picture.height = tall;
      begin = first;
    } else {
      const moved = first - Math.max(0, this.drawn - columns + 1);
      context.globalCompositeOperation = "copy";
      if (moved) context.drawImage(picture, -moved, 0);
      context.globalCompositeOperation = "source-over";
      context.clearRect(begin - first, 0, columns, tall);
    }
    for (const { strip, flown, top, height: high } of shown) {
      const scale = scaleIn(strip, top, high), y = (value) => ratio * scale.place(value);
      context.save();
      context.beginPath();
      context.rect(0, ratio * (top - 1), columns, ratio * (high + 2));
      context.clip();
      for (const [line, trace, other] of flown) {
        context.fillStyle = colours.other;
        if (other) other.draw(context, begin, begin - first, y, 1.5 * ratio, false);
        context.fillStyle = colours[line.colour];
        context.globalAlpha = line.thin ? 0.8 : 1;
        trace.draw(context, begin, begin - first, y, (line.thin ? 1 : 1.7) * ratio, line.thin);
      }
      context.restore();
    }
    this.key = key;
    this.drawn = latest;
  }

  drawTimes(context, since, bucket, height, colours) {
    const every = this.span > 10 ? 5 : this.span < 10 ? 0.5 : 1;
    for (let time = every * Math.ceil(since / every); time < since + this.span; time += every) {
      write(context, `${time} s`, LEFT + (time - since) / bucket, height, colours.faint, { align: "center", base: "bottom" });
    }
  }
}

/** Range of a strip that follows its lines, widened to whole tens, or what it has in their place. */
function ranged(strip, flown) {
  if (!strip.tens) return strip;
  const largest = Math.max(strip.tens, ...flown.flatMap(([, trace, other]) => [trace.most(), other ? other.most() : 0]));
  const most = Math.min(strip.high, strip.tens * Math.ceil(1.05 * largest / strip.tens));
  return { ...strip, low: -most, high: most };
}
