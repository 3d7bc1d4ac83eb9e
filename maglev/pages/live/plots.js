"use strict";
// Plots that roll beside the stage: gap, displacements, errors (logarithmic), currents with limits.

const LEFT = 54, RIGHT = 10, TOP = 17, BOTTOM = 4;   // px around a strip
const LARGEST_ERROR = 0.1;                           // m, rad

const windowFor = (speed) => (speed < 0.5 ? 2 : speed > 2 ? 30 : 10);   // s shown

/** What a strip of the stage shows beside its panel: lines with a colour and a function of a row, range, levels that are marked.
 *
 * Of one controller lines have the colours of the axes, of two, by their names, those of the controllers: there errors of the gap
 * are apart, and no currents. */
function stripsOf(run, values, names = null) {
  if (!names) return run.stage.strips.map((panel) => ({ ...panel, ...STRIPS[panel.kind](run, panel, values) }));
  const kinds = [[run.vertical], run.axes.filter((axis) => axis !== run.vertical)];
  const panels = run.stage.strips.filter(({ kind }) => kind !== "currents").flatMap((panel) => (panel.kind !== "error" ? [panel]
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
    const [limit, peak] = ["controller.current_limit", `plant.${motors[0]}.amplifier.peak`].map((name) => values(name) || Infinity);
    const shown = Math.max(1, Number.isFinite(Math.min(limit, peak)) ? Math.min(limit, peak) : 5);
    return { lines, title: `${title}; ${limit <= peak ? "limit" : "peak of a phase"} dashed`, low: -1.15 * shown, high: 1.15 * shown, marks: [-shown, shown] };
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
  const names = strip.names ?? strip.lines.filter((each) => each.name).map((each) => [each.name, each.colour]);
  for (const [name, colour] of [...names].reverse()) {
    const text = `${colour === "other" ? "- -" : "—"} ${name}`;
    write(context, text, end, box.top - 8, colours[colour], { align: "right" });
    end -= context.measureText(text).width + 12;
  }
  const room = context.measureText(strip.title).width < end - box.left;
  write(context, room ? strip.title : strip.title.split(";")[0], box.left, box.top - 8, colours.text);
}

/** Plots of a run and of the one that runs beside it. Lines stay where they are drawn and are moved: only what is new costs. */
class Strips {
  constructor(strips, span) {
    Object.assign(this, { strips, span, points: new Map(), picture: document.createElement("canvas"), key: "", drawn: 0 });
  }

  /** Points of a line of a run, up to date: each row is looked at once. */
  pointsOf(line, rows) {
    const lines = this.points.get(rows) ?? this.points.set(rows, new Map()).get(rows);
    const points = lines.get(line) ?? lines.set(line, { x: [], y: [], seen: 0, ascending: true }).get(line);
    for (let row = Math.max(points.seen, rows.first); row < rows.count; row++) {
      points.x.push(rows.at(row, 0));
      points.y.push(line.value(rows, row));
    }
    points.seen = rows.count;
    for (const values of [points.x, points.y]) if (values.length > 2 * MOST_KEPT) values.splice(0, MOST_KEPT);
    return points;
  }

  /** Draw, unless so little has happened that nothing would move by two px. */
  draw(canvas, rows, ghost, colours, now) {
    const { context, width, height, ratio } = sized(canvas, false), wide = Math.floor((width - LEFT - RIGHT) * ratio);   // px of the screen
    if (wide < 1) return;   // there is no room for a line
    const bucket = this.span / wide, latest = Math.floor(rows.last().time / bucket), since = Math.max(0, latest - wide + 1);
    if (!now && this.key && latest >= this.drawn && latest - this.drawn < 2) return;
    for (const known of [...this.points.keys()]) if (known !== rows && known !== ghost) this.points.delete(known);
    const each = (height - 16) / this.strips.length, across = scaleOf(since * bucket, (since + wide) * bucket, LEFT, LEFT + wide / ratio, false);
    const shown = this.strips.map((planned, i) => {
      const traced = planned.lines.map((line) => [line, this.pointsOf(line, rows), ghost && !line.thin && this.pointsOf(line, ghost)]);
      return { strip: ranged(planned, traced, since * bucket), traced, top: i * each + TOP, tall: each - TOP - BOTTOM };
    });
    const key = `${width} ${height} ${ratio} ${shown.map(({ strip }) => strip.high)} ${rows.number} ${ghost?.number ?? ""} ${Object.values(colours)}`;
    this.drawLines(shown, { key, ratio, wide, latest, since, bucket, height }, colours);
    context.clearRect(0, 0, width, height);
    for (const { strip, top, tall } of shown) drawFrame(context, strip, { left: LEFT, top, width: wide / ratio, height: tall }, colours);
    context.drawImage(this.picture, LEFT, 0, wide / ratio, height);
    const every = this.span > 10 ? 5 : this.span < 10 ? 0.5 : 1;
    for (const [time, text] of across.ticks(this.span / every)) {
      if (across.place(time) < LEFT + wide / ratio) write(context, `${text} s`, across.place(time), height, colours.faint, { align: "center", base: "bottom" });
    }
  }

  /** Bring the picture of the lines up to the latest column: moved to the left, and with what is new. */
  drawLines(shown, { key, ratio, wide, latest, since, bucket, height }, colours) {
    const { picture } = this, context = picture.getContext("2d"), anew = key !== this.key || latest < this.drawn || this.drawn < since;
    const begin = anew ? since : this.drawn, moved = since - Math.max(0, this.drawn - wide + 1);
    if (anew) Object.assign(picture, { width: wide, height: Math.round(height * ratio) });   // which empties it
    else {
      context.globalCompositeOperation = "copy";
      if (moved) context.drawImage(picture, -moved, 0);
      context.globalCompositeOperation = "source-over";
      context.clearRect(begin - since, 0, wide, picture.height);
    }
    const across = scaleOf(begin * bucket, (latest + 1) * bucket, begin - since, latest + 1 - since, false);
    for (const { strip, traced, top, tall } of shown) {
      const up = scaleIn(strip, ratio * top, ratio * tall), drawn = (points, ...look) => {
        context.beginPath();
        follow(context, points, across, up, latest - begin);
        outline(context, ...look);
      };
      context.save();
      context.beginPath();
      context.rect(begin - since, ratio * (top - 1), wide, ratio * (tall + 2));
      context.clip();
      Object.assign(context, { lineJoin: "bevel", lineDashOffset: begin });   // dots go with the line
      for (const [line, ours, other] of traced) {
        if (other) drawn(other, colours.other, 1.5 * ratio, [6 * ratio, 3 * ratio]);
        drawn(ours, colours[line.colour], (line.thin ? 1 : 1.7) * ratio, line.thin ? [2, 2] : []);
      }
      context.restore();
    }
    Object.assign(this, { key, drawn: latest });
  }
}

/** Range of a strip that follows its lines, widened to whole tens, or what it has in their place. */
function ranged(strip, traced, since) {
  if (!strip.tens) return strip;
  let largest = strip.tens;
  for (const { x, y } of traced.flatMap(([, ours, other]) => (other ? [ours, other] : [ours]))) {
    for (let k = firstFrom(x, since); k < y.length; k++) largest = Math.max(largest, Math.abs(y[k]));
  }
  const most = Math.min(strip.high, strip.tens * Math.ceil(1.05 * largest / strip.tens));
  return { ...strip, low: -most, high: most };
}
