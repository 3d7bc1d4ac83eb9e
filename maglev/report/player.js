"use strict";
// Moving picture of the main runs: choice of run, play and pause, place in time, speed.
{
  const player = document.getElementById("player");
  const ABOUT = "The mover hangs below the stator and rises when the gap shrinks. Coils are coloured by phase, the stronger " +
    "the more current they carry; a dot is current towards you, a cross away from you. The dashed outline is the " +
    "reference. Widths are to scale, gaps and tilts are drawn 3.6 times larger.";

  function labelled(text, name, attributes, parent) {
    const label = html("label", attributes.class ? { class: attributes.class } : {}, parent, `${text} `);
    return html(name, { ...attributes, class: "" }, label);
  }

  /** Views, readings and a function that shows a time (s) of a decoded run. */
  function show(name, views, list) {
    const run = report.runs[name];
    const signals = ready[name];
    const vertical = Object.keys(run.axes).find((axis) => run.axes[axis].vertical);
    const motors = Object.values(run.motors);
    // The first motor of those that drive an axis, of a stage of one's own in the order of the axes.
    const horizontal = Object.keys(run.axes).filter((axis) => axis !== vertical && !run.axes[axis].rotation);
    const driving = (axis) => Object.keys(run.motors).filter((name) => run.drives[name] === axis);
    const motorOf = (axis, k) => run.motors[driving(axis)[0]] ?? motors[k];
    const at = (signal, time) => (signals[signal] ? valueAt(signals[signal], time) : 0);
    const peak = Math.max(0, ...motors.flatMap((motor) => motor.currents)
      .map((signal) => (signals[signal]?.values ?? []).reduce((most, value) => Math.max(most, Math.abs(value)), 0)));
    views.replaceChildren();
    list.replaceChildren();
    const others = (axis) => horizontal.filter((other) => other !== axis).join(", ");
    const draw = horizontal.map((axis) => stageView(views,
      `${axis}–${vertical} plane${others(axis) ? `, seen along ${others(axis)}` : ", seen from the side"}${driving(axis).length > 1
        ? `, coils of ${driving(axis)[0]}` : ""}`, run.sheet));
    const printed = (label) => {
      const row = html("div", {}, list);
      html("dt", {}, row, label);
      return html("dd", {}, row);
    };
    const clock = printed("time");
    const values = report.moving[name].map((shown) => ({ shown, place: printed(shown.name) }));
    return (time) => {
      const mm = (axis, what) => 1e3 * at(run.axes[axis][what], time);
      const placed = (axis, what) => ({ along: mm(axis, what), gap: mm(vertical, what),
        tilt: run.tilts[axis] ? run.tilts[axis].sign * mm(run.tilts[axis].axis, what) : 0 });
      horizontal.forEach((axis, k) => draw[k]({ position: placed(axis, "position"), reference: placed(axis, "reference"),
        currents: (motorOf(axis, k)?.currents ?? []).map((signal) => at(signal, time)), peak,
      }));
      clock.textContent = `${time.toFixed(2)} s`;
      for (const { shown, place } of values) place.textContent = reading(shown, at(shown.signal, time));
    };
  }

  function build() {
    const views = html("div", { class: "views", id: "player-views" }, player);
    const controls = html("div", { class: "controls" }, player);
    const choice = labelled("Run", "select", { id: "player-run" }, controls);
    for (const name of Object.keys(report.moving)) html("option", { value: name }, choice, `${name}: ${report.runs[name].title}`);
    const transport = html("div", { class: "controls" }, player);
    const button = html("button", { type: "button", id: "player-play" }, transport, "Play");
    const slider = labelled("Time", "input",
      { type: "range", id: "player-time", min: "0", step: "0.01", class: "scrub" }, transport);
    const speed = labelled("Speed", "select", { id: "player-speed" }, transport);
    for (const factor of ["0.25", "1", "4"]) html("option", { value: factor }, speed, `${factor}×`);
    speed.value = "1";
    const event = html("p", { class: "status", role: "status" }, player);
    const details = html("details", {}, player);
    html("summary", {}, details, "What is drawn, and the values");
    html("p", {}, details, ABOUT);
    const readings = html("dl", { class: "readings" }, details);
    let display = () => {};
    let time = 0;
    let end = 0;
    let playing = false;
    let before = 0;

    function showTime(next) {
      time = Math.min(Math.max(next, 0), end);
      slider.value = String(time);
      slider.setAttribute("aria-valuetext", `${time.toFixed(2)} seconds`);
      const passed = report.runs[choice.value].events.filter((each) => each.time <= time);
      const text = passed.map((each) => `⚠ ${each.text} at ${each.time.toFixed(3)} s`).join("; ");
      if (event.textContent !== text) event.textContent = text;
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
      const name = choice.value;
      inUse.clear();
      inUse.add(name);
      const signals = await decodeRun(name);
      if (name !== choice.value) return;   // another was chosen meanwhile
      end = Math.max(...Object.values(signals).map(({ times }) => times.at(-1)));
      slider.max = String(end);
      display = show(name, views, readings);
      showTime(0);
    }

    button.addEventListener("click", () => play(!playing));
    slider.addEventListener("input", () => { play(false); showTime(Number(slider.value)); });
    choice.addEventListener("change", () => load().catch(fail));
    load().then(() => {
      // It moves from the start, unless the reader wants no motion; what cannot be seen need not move.
      if (time === 0 && !window.matchMedia("(prefers-reduced-motion: reduce)").matches) play(true);
    }).catch(fail);
    new IntersectionObserver(([{ isIntersecting }]) => { if (!isIntersecting) play(false); }).observe(views);
  }

  if (Object.keys(report.moving).length) {
    build();
  } else {
    html("p", {}, player, "None of the main runs was recorded.");
  }
}
