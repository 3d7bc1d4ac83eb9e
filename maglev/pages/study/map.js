"use strict";
// Maps of outcomes on canvases, a law each, that show one part: zoomed and moved together, a place read in all of them.
const MAP = { left: 56, right: 8, top: 6, below: 36, least: 8 };   // px around a map; cells that are seen at least
// How an outcome looks: its colour, and which pixels are inked, for who does not tell colours apart.
const LOOKS = [["good", () => 1], ["good", (x, y) => (y % 6 < 2 ? 0.9 : 0.35)], ["close", (x, y) => ((x + y) % 8 < 3 ? 1 : 0.5)],
  ["bad", (x, y) => ((x - y + 4096) % 8 < 3 ? 1 : 0.5)], ["bad", (x, y) => (x % 8 < 2 && y % 8 < 2 ? 0.9 : 0.25)], ["text", () => 1]];

class OutcomeMaps {
  constructor(place, { factors, laws, outcomes }) {
    Object.assign(this, { factors, laws, outcomes, layer: 0, at: null });
    [this.rows, this.columns] = factors.map(({ values }) => values.length);
    this.all = { x: [-0.5, this.columns - 0.5], y: [-0.5, this.rows - 0.5] };
    this.view = { ...this.all };
    const tools = html("div", { class: "controls" }, place);
    for (const [sign, label, by] of [["+", "zoom in", 0.5], ["−", "zoom out", 2], ["all", "show all", Infinity]]) {
      html("button", { type: "button", "aria-label": label }, tools, sign).addEventListener("click", () => this.zoom(by));
    }
    const others = factors.slice(2);   // every combination of their values is a layer
    this.layers = others.reduce((all, { values }) => all.flatMap((each) => values.map((_, k) => [...each, k])), [[]]);
    if (this.layers.length > 1) {
      const select = html("select", { class: "layer" }, html("label", {}, tools, `${others.map(({ name }) => name).join(", ")} `));
      this.layers.forEach((layer, k) => select.append(new Option(others.map((each, i) => this.text(each, layer[i])).join(", "), k)));
      select.addEventListener("change", () => { this.layer = Number(select.value); this.draw(); });
    }
    const legend = html("p", { class: "legend" }, place), maps = html("div", { class: "maps" }, place), seen = new Set(laws.flatMap(({ cells }) => [...new Set(cells)]));
    this.swatches = outcomes.flatMap((name, k) => {
      if (!seen.has(k)) return [];
      const note = html("span", {}, legend), canvas = html("canvas", { "aria-hidden": "true" }, note);
      note.append(name);
      return [[canvas, k]];
    });
    for (const law of laws) {
      const figure = html("figure", {}, maps);
      law.caption = html("figcaption", {}, figure);
      law.canvas = html("canvas", { tabindex: 0, role: "application" }, figure);
      this.listen(law);
    }
    this.place = html("p", { class: "place", role: "status" }, place, "Point at a place, or tap it, to see its outcome and its command.");
    this.card = html("p", { hidden: "" }, place);
  }

  text({ values, scale, unit }, k) {
    return `${shortNumber(scale * values[k], 4)} ${unit}`.trim();
  }

  outcome({ cells }, row, column) {
    return cells[(this.layer * this.rows + row) * this.columns + column];
  }

  /** Zoom by a factor about a place, the one that is pointed at or the middle. */
  zoom(by, about = null) {
    for (const [side, k] of [["x", 1], ["y", 0]]) {
      const [low, high] = this.view[side], whole = this.all[side][1] - this.all[side][0];
      const at = about?.[k] ?? (this.at && this.at[k] >= low && this.at[k] <= high ? this.at[k] : (low + high) / 2);
      const span = Math.min(whole, Math.max(Math.min(MAP.least, whole), by * (high - low)));
      this.move(side, at - (at - low) / (high - low) * span, span);
    }
    this.draw();
  }

  /** Show a span of a side from a place on, within what there is. */
  move(side, low, span) {
    const [least, most] = this.all[side], from = Math.min(Math.max(low, least), most - span);
    this.view[side] = [from, from + span];
  }

  /** Return the place of a pointer in a map, in cells: row and column with fractions. */
  placeOf({ canvas }, { clientX, clientY }) {
    const box = canvas.getBoundingClientRect(), { x, y } = this.view;
    return [y[1] - (clientY - box.top - MAP.top) / (box.height - MAP.top - MAP.below) * (y[1] - y[0]),
      x[0] + (clientX - box.left - MAP.left) / (box.width - MAP.left - MAP.right) * (x[1] - x[0])];
  }

  /** Say what is at a place, of the law that is pointed at first, with the command that runs it. */
  point(law, place) {
    const [row, column] = place.map((at, k) => Math.min(Math.max(Math.round(at), 0), this.factors[k].values.length - 1));
    this.at = [row, column];
    const levels = [row, column, ...this.layers[this.layer]];
    const where = this.factors.map((factor, k) => `${factor.name} ${this.text(factor, levels[k])}`).join(", ");
    const became = [law, ...this.laws.filter((each) => each !== law)].map((each) =>
      `${each.name ? `${each.name} ` : ""}${this.outcomes[this.outcome(each, row, column)]}`);
    this.place.textContent = `${where}: ${became.join("; ")}`;
    fillCard(this.card, { live: report.card?.live, command: law.command }, this.factors.flatMap(({ sets, values }, k) =>
      Object.entries(sets).map(([target, given]) => [target, (given ?? values)[levels[k]]])));
    this.draw();
  }

  /** Show the cells alone whose values are kept, of each factor; all at null. */
  keep(kept) {
    this.kept = kept;
    this.draw();
  }

  /** Return true if the value of a factor is kept. */
  keeps(factor, k) {
    return this.kept?.[factor][k] ?? true;
  }

  listen(law) {
    const { canvas } = law, fingers = new Map();
    let held = null;
    canvas.addEventListener("wheel", (event) => {
      if (!event.ctrlKey && event.deltaY > 0 && this.view.x[0] === this.all.x[0] && this.view.x[1] === this.all.x[1]) return;   // the page scrolls on
      event.preventDefault();
      this.zoom(event.deltaY > 0 ? 1.25 : 0.8, this.placeOf(law, event));
    }, { passive: false });
    canvas.addEventListener("pointerdown", (event) => {
      fingers.set(event.pointerId, event);
      canvas.setPointerCapture(event.pointerId);
      held = { from: event, view: { ...this.view }, moved: false };
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!fingers.has(event.pointerId)) {
        this.point(law, this.placeOf(law, event));
        return;
      }
      const apart = () => { const [one, other] = [...fingers.values()]; return Math.hypot(one.clientX - other.clientX, one.clientY - other.clientY); };
      const before = fingers.size > 1 ? apart() : 0;
      fingers.set(event.pointerId, event);
      if (fingers.size > 1) this.zoom(before / apart(), this.placeOf(law, event));
      else {
        const [by, up] = [event.clientX - held.from.clientX, event.clientY - held.from.clientY];
        if (!(held.moved ||= Math.hypot(by, up) > 5)) return;
        const { x, y } = held.view;
        this.move("x", x[0] - by / (canvas.clientWidth - MAP.left - MAP.right) * (x[1] - x[0]), x[1] - x[0]);
        this.move("y", y[0] + up / (canvas.clientHeight - MAP.top - MAP.below) * (y[1] - y[0]), y[1] - y[0]);
        this.draw();
      }
    });
    for (const end of ["pointerup", "pointercancel"]) {
      canvas.addEventListener(end, (event) => {
        if (end === "pointerup" && fingers.size === 1 && !held.moved) this.point(law, this.placeOf(law, event));
        fingers.delete(event.pointerId);
      });
    }
    canvas.addEventListener("dblclick", () => this.zoom(Infinity));
    canvas.addEventListener("keydown", (event) => {
      const by = { ArrowLeft: [0, -1], ArrowRight: [0, 1], ArrowDown: [-1, 0], ArrowUp: [1, 0] }[event.key];
      const zoom = { "+": 0.5, "=": 0.5, "-": 2, 0: Infinity }[event.key];
      if (by) this.point(law, (this.at ?? [this.rows >> 1, this.columns >> 1]).map((at, k) => at + by[k]));
      else if (zoom) this.zoom(zoom);
      else return;
      event.preventDefault();
    });
  }

  draw() {
    if (this.due) return;
    this.due = requestAnimationFrame(() => {
      this.due = 0;
      this.inks = LOOKS.map(([name, ink]) => [rgb(name), ink]);
      for (const law of this.laws) this.drawLaw(law);
      for (const [canvas, k] of this.swatches) {
        const image = new ImageData(Object.assign(canvas, { width: 28, height: 14 }).width, 14);
        for (let p = 0; p < 28 * 14; p++) this.paint(image.data, p, k, p % 28, Math.floor(p / 28));
        canvas.getContext("2d").putImageData(image, 0, 0);
      }
    });
  }

  /** Ink of an outcome over paper at a pixel. */
  paint(data, p, outcome, x, y) {
    const [colours, ink] = this.inks[outcome], strength = ink(x, y), paper = this.paper ??= rgb("paper");
    for (let c = 0; c < 3; c++) data[4 * p + c] = strength * colours[c] + (1 - strength) * paper[c];
    data[4 * p + 3] = 255;
  }

  drawLaw(law) {
    const { canvas } = law, { context, width: wide, height: tall, ratio } = sized(canvas), { x, y } = this.view, ink = colour("text");
    const [width, height] = [wide - MAP.left - MAP.right, tall - MAP.top - MAP.below];
    const image = new ImageData(Math.max(1, Math.round(width * ratio)), Math.max(1, Math.round(height * ratio)));
    this.paper = null;
    const columns = Array.from({ length: image.width }, (_, px) => Math.round(x[0] + (px + 0.5) / image.width * (x[1] - x[0])));
    const layerKept = this.layers[this.layer].every((k, other) => this.keeps(other + 2, k));
    for (let py = 0; layerKept && py < image.height; py++) {
      const row = Math.round(y[1] - (py + 0.5) / image.height * (y[1] - y[0]));
      for (let px = 0; this.keeps(0, row) && px < image.width; px++) {
        if (this.keeps(1, columns[px])) this.paint(image.data, py * image.width + px, this.outcome(law, row, columns[px]), Math.floor(px / ratio), Math.floor(py / ratio));
      }
    }
    context.putImageData(image, Math.round(MAP.left * ratio), Math.round(MAP.top * ratio));
    const [down, across] = this.factors, middle = { align: "center" };
    for (const [place, text] of this.axis(across, x, width, 30)) write(context, text, MAP.left + place, MAP.top + height + 10, ink, middle);
    write(context, titleOf(across), MAP.left + width / 2, MAP.top + height + 26, ink, middle);
    for (const [place, text] of this.axis(down, y, height, 15)) write(context, text, MAP.left - 5, MAP.top + height - place, ink, { align: "end" });
    context.save();
    context.translate(6, MAP.top + height / 2);
    context.rotate(-Math.PI / 2);
    write(context, titleOf(down), 0, 0, ink, middle);
    context.restore();
    context.save();
    context.beginPath();
    context.rect(MAP.left, MAP.top, width, height);
    outline(context, ink);
    context.clip();
    if (this.at) {
      const [cx, cy] = [MAP.left + (this.at[1] - x[0]) / (x[1] - x[0]) * width, MAP.top + (y[1] - this.at[0]) / (y[1] - y[0]) * height];
      for (const [thick, css] of [[4, "paper"], [1.5, "text"]]) {
        line(context, [[cx - 9, cy], [cx + 9, cy]], colour(css), thick);
        line(context, [[cx, cy - 9], [cx, cy + 9]], colour(css), thick);
      }
    }
    context.restore();
    const size = this.rows * this.columns, layer = law.cells.subarray(this.layer * size, (this.layer + 1) * size);
    const shown = layer.filter((_, k) => layerKept && this.keeps(0, Math.floor(k / this.columns)) && this.keeps(1, k % this.columns));
    const share = shown.reduce((sum, outcome) => sum + (outcome === 0), 0) / (shown.length || 1);
    const others = this.layers.length > 1 ? this.factors.slice(2) : [], chosen = others.map((factor, i) =>   // which paper has no list for
      `${factor.name} ${this.text(factor, this.layers[this.layer][i])}`);
    const whose = [law.name, ...chosen].filter(Boolean).join(", ");
    law.caption.textContent = `${whose}${whose && ": "}${this.outcomes[0]} in ${(100 * share).toFixed(0)} % of ${this.kept ? "what is kept" : "the map"}`;
    canvas.setAttribute("aria-label", law.caption.textContent);
  }

  /** Labels of a side at the middles of their cells (px), as many as have their room. */
  axis(factor, [low, high], length, room) {
    const cell = length / (high - low), texts = factor.values.map((value) => shortNumber(factor.scale * value, 3));
    const every = Math.ceil(Math.max(room, room > 20 ? 7 * Math.max(...texts.map((text) => text.length)) : 0) / cell);
    return texts.map((text, k) => [(k - low) * cell, text]).filter(([place], k) => k % every === 0 && place >= 0 && place <= length);
  }
}

const titleOf = ({ name, unit }) => (unit ? `${name} (${unit})` : name);

/** Show in a card the command that runs a sample, its settings, and its link to the live page. */
function fillCard(card, { command, live }, sets) {
  card.replaceChildren(html("code", {}, null, [command, ...sets.map(([target, value]) => `--set ${target}=${value}`)].join(" ")), " ",
    html("button", { type: "button", class: "copy" }, null, "Copy"));
  if (live) card.append(" ", html("a", { href: live + sets.map(([target, value]) => `&${encodeURIComponent(target)}=${value}`).join("") }, null, "open it live"));
  card.hidden = false;
}

function colour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}

function rgb(name) {
  return [1, 3, 5].map((at) => parseInt(colour(name).slice(at, at + 2), 16));
}

/** The maps of the page, drawn, if it has any; the cells of a law are packed bytes. */
async function drawMaps() {
  const place = document.getElementById("maps");
  if (!place) return null;
  for (const law of report.maps.laws) law.cells = await unpacked(law.packed);
  const maps = new OutcomeMaps(place, report.maps);
  new ResizeObserver(() => maps.draw()).observe(place);   // at first, too
  for (const media of ["(prefers-color-scheme: dark)", "print"]) matchMedia(media).addEventListener("change", () => maps.draw());
  return maps;
}

const mapped = drawMaps();   // for tests, too
