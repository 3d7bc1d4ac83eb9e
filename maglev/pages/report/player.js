"use strict";
// Moving picture of the main runs, or of runs side by side: choice of run, play and pause, position in time, speed.
{
  const player = document.getElementById("player");
  const ABOUT = "As on the live page: the stage in space, of one run with coils yellow by their current, and next to it the air gap, larger, with its "
    + "stops, each platform in the colour of its controller. The dashed outline is the reference; tilts are drawn five times as large.";

  function labelled(text, name, attributes, parent) {
    const label = html("label", attributes.class ? { class: attributes.class } : {}, parent, `${text} `);
    return html(name, { ...attributes, class: "" }, label);
  }

  const mapped = (of, make) => Object.fromEntries(Object.entries(of).map(([name, each]) => [name, make(each)]));

  /** A function that shows a time (s) of decoded runs. */
  function show({ stage, runs }, canvas) {
    const at = (run, signal, time) => (ready[run][signal] ? valueAt(ready[run][signal], time) : 0);
    const rowAt = ({ axes, motors }, run, time) => ({
      axes: mapped(axes, ({ position, reference }) => ({ position: at(run, position, time), reference: at(run, reference, time) })),
      motors: mapped(motors, ({ currents }) => ({ phases: [0, 1, 2].map((k) => at(run, currents[k], time)) })) });
    const [{ run: first }] = runs, { motors } = report.runs[first];
    const peak = Object.values(motors).flatMap(({ currents }) => currents).flatMap((signal) => ready[first][signal]?.values ?? [])
      .reduce((most, value) => Math.max(most, Math.abs(value)), 0.1);
    return (time, printed) => {
      const colours = sceneColours([], printed);
      const drawn = runs.map(({ run, label, css }) => ({ row: rowAt(report.runs[run], run, time), name: label, colour: colours[css] }));
      window.maglevReport.views = { ...drawScene(canvas, stage, drawn, { orbit: SHOTS.space, ends: stage.stage.room.ends, peak }, colours), drawn };
    };
  }

  function build() {
    const canvas = html("canvas", { id: "player-stage", role: "img", "aria-label": "The stage, and its air gap" }, player);
    const controls = html("div", { class: "controls" }, player);
    const choice = labelled("Run", "select", { id: "player-run" }, controls);
    for (const name of Object.keys(report.moving)) html("option", { value: name }, choice, `${name}: ${report.runs[name].title}`);
    controls.hidden = choice.options.length < 2;
    const transport = html("div", { class: "controls" }, player);
    const button = html("button", { type: "button", id: "player-play" }, transport, "Play");
    const slider = labelled("Time", "input", { type: "range", id: "player-time", min: "0", step: "0.01", class: "scrub" }, transport);
    const clock = html("span", { id: "player-clock" }, transport);
    const speed = labelled("Speed", "select", { id: "player-speed" }, transport);
    for (const factor of ["0.25", "1", "4"]) html("option", { value: factor }, speed, `${factor}×`);
    speed.value = "1";
    const event = html("p", { class: "status", role: "status" }, player);
    const details = html("details", {}, player);
    details.append(html("summary", {}, null, "About this picture"), html("p", {}, null, ABOUT));
    let display = () => {}, time = 0, end = 0, playing = false, before = 0;

    function showTime(next) {
      time = Math.min(Math.max(next, 0), end);
      [slider.value, clock.textContent] = [String(time), `${numberText(time, 2)} s`];
      slider.setAttribute("aria-valuetext", `${numberText(time, 2)} seconds`);
      const { runs } = report.moving[choice.value];
      const passed = runs.flatMap(({ run, label }) => report.runs[run].events.filter((each) => each.time <= time)
        .map((each) => `⚠ ${runs.length > 1 ? `${label} ` : ""}${each.text}`)).join("; ");
      if (event.textContent !== passed) event.textContent = passed;
      display(time);
    }

    function frame(now) {
      if (!playing) return;
      showTime(time + Number(speed.value) * (now - before) / 1e3);
      before = now;
      if (time >= end) play(false);
      else requestAnimationFrame(frame);
    }

    function play(start) {
      playing = start;
      button.textContent = start ? "Pause" : "Play";
      if (!start) return;
      if (time >= end) showTime(0);
      before = performance.now();
      requestAnimationFrame(frame);
    }

    async function load() {
      play(false);
      const name = choice.value, { runs } = report.moving[name];
      const decoded = await Promise.all(runs.map(({ run }) => decodeRun(run)));
      if (name !== choice.value) return;   // another run was chosen meanwhile
      end = Math.max(...decoded.flatMap((signals) => Object.values(signals).map(({ times }) => times.at(-1))));
      slider.max = String(end);
      display = show(report.moving[name], canvas);
      showTime(0);
    }

    button.addEventListener("click", () => play(!playing));
    slider.addEventListener("input", () => { play(false); showTime(Number(slider.value)); });
    choice.addEventListener("change", () => load().catch(fail));
    load().then(() => {
      // It moves from the start, unless the reader wants no motion; an invisible picture does not move.
      if (time === 0 && !window.matchMedia("(prefers-reduced-motion: reduce)").matches) play(true);
    }).catch(fail);
    new IntersectionObserver(([{ isIntersecting }]) => { if (!isIntersecting) play(false); }).observe(canvas);
    new ResizeObserver(() => display(time)).observe(canvas);
    whenColoursChange((printed) => display(time, printed));
  }

  if (player) build();
}
