"use strict";
// The stage in two sentences, and four experiments that show why: each runs live, and tells its result.

const STORY_START = 1;                    // s of the run at which something is done
const DROP = { mass: 1, height: 0.06 };   // kg that fall on the platform, m
const CHANGE = 3.5e-3;                    // m of the gap: beyond the range of the linearisation at one gap
const SPARE = 1.3;                        // weak amplifiers give this many times the current that carries

const numbers = {
  mm: (metres, digits = 1) => `${(1e3 * metres).toFixed(digits)} mm`,
  ms: (seconds) => `${Math.round(1e3 * seconds)} ms`,
  amperes: (current) => `${Math.abs(current).toFixed(1)} A`,
};

/** Time (s) after the story's event of the first row of a run for which something holds; undefined if for none. */
function firstAfter(rows, since, holds) {
  for (let row = rows.since(since); row < rows.count; row++) if (holds((column) => rows.at(row, column))) return rows.at(row, 0) - since;
  return undefined;
}

/** Time (s) after an event until a run's gap meets an end, and that end. */
function gapLost(run, rows, since) {
  const [low, high] = endsOf(run, run.vertical, valueOf), gap = columnOf.position(run.axes.indexOf(run.vertical));
  const after = rows && firstAfter(rows, since, (at) => at(gap) < low + 1e-5 || at(gap) > high - 1e-5);
  if (after === undefined) return undefined;
  const fell = rows.at(rows.since(since + after), gap) > (low + high) / 2;
  return { after, where: fell ? "its lower stop" : "its upper stop", end: fell ? high : low };
}

/** Rate (1/s) at which an error of the gap grows under a current that holds: of the picture's forces, by differences. */
function growth(run, row, values) {
  const d = carryingCurrent(run, row, values), step = 1e-5, gap = row.axes[run.vertical].position;
  const lift = (at) => {
    const motors = Object.fromEntries(run.motors.map((motor) => [motor, { ...row.motors[motor], d, q: 0 }]));
    return forcesOf(run, { axes: { ...row.axes, [run.vertical]: { position: at } }, motors }, values).lift;
  };
  return Math.sqrt((lift(gap - step) - lift(gap + step)) / (2 * step) / values(`plant.${run.vertical}.mass`));
}

const motorValues = (run, variable, value) => Object.fromEntries(run.motors.map((motor) => [`plant.${motor}.${variable}`, value]));
const slow = (from, until, speed) => [{ at: from, type: "speed", value: speed }, { at: until, type: "speed", value: 1 }];
const lawLike = (run, text) => controllersOf(run).find((model) => lawOf(run, model) === text);

/** Experiments. `text` describes one in two sentences; `acts` are messages to the worker at times of the run. `tell`
 * returns the result that a run shows, undefined until it shows one; `shot` is the view of it. */
const STORIES = [
  { id: "beat", label: "Beat the thesis", controller: () => LAW, ghost: (run) => opponentOf(run).model(run), shot: { yaw: -30, pitch: 22, zoom: 1 },
    text: (run) => `Yours and ${opponentOf(run).label} at the same task: ${TASK.mass} kg is put on after ${TASK.on} s, and after ${TASK.step} s both make a step of `
      + `${1e3 * TASK.way} mm along ${drivenAxes(run)[0]}.`,
    acts: taskActs, tell: (run, rows, time) => (time < TASK.until ? undefined : verdictText()) },
  { id: "off", label: "Controller off", shot: { yaw: -22, pitch: 9, zoom: 1.15 },
    text: () => "After one second the amplifiers are switched off, shown ten times slower. The magnets alone cannot hold the platform: "
      + "the nearer it is the stronger they pull, so it leaves, up or down.",
    acts: (run) => [{ at: STORY_START, type: "tune", values: motorValues(run, "amplifier.off", true), shown: true },
      ...slow(STORY_START - 0.02, STORY_START + 0.12, 0.1)],
    tell: (run, rows) => {
      const lost = gapLost(run, rows, STORY_START);
      return lost && `Without current it hit ${lost.where} after ${numbers.ms(lost.after)}: time enough for ${
        (lost.after / run.step).toFixed(0)} samples of the controller.`;
    } },
  { id: "weight", label: "Drop a weight", shot: { yaw: -30, pitch: 28, zoom: 1.7 }, falls: { ...DROP, at: STORY_START },
    text: () => `A weight of ${DROP.mass} kg falls ${numbers.mm(DROP.height, 0)} onto the platform, shown five times slower. Nobody `
      + "tells the controller: its internal model finds the current that carries it.",
    acts: (run, controller) => {
      const payload = KNOBS.find(({ id }) => id === "payload");
      return [{ at: STORY_START, type: "kick", axis: run.vertical, impulse: DROP.mass * Math.sqrt(2 * live.gravity * DROP.height) },
        { at: STORY_START, type: "tune", values: knobSettings(payload, run, controller, DROP.mass), shown: true },
        ...slow(STORY_START - 1.2 * Math.sqrt(2 * DROP.height / live.gravity), STORY_START + 0.4, 0.2)];
    },
    tell: (run, rows, time) => {
      if (time < STORY_START + 2) return undefined;
      const axis = run.axes.indexOf(run.vertical), sum = (at) => run.motors.reduce((all, _, m) => all + at(columnOf.direct(run.axes, m)), 0);
      let most = 0, back = 0;
      for (let row = rows.since(STORY_START); row < rows.count; row++) {
        const error = rows.at(row, columnOf.position(axis)) - rows.at(row, columnOf.reference(axis));
        most = Math.max(most, error);
        if (Math.abs(error) > 1e-4) back = rows.at(row, 0) - STORY_START;
      }
      const current = (until) => {   // over 0.3 s: it is not smooth
        let all = 0;
        const [first, end] = [rows.since(until - 0.3), rows.since(until)];
        for (let row = first; row < end; row++) all += sum((column) => rows.at(row, column));
        return numbers.amperes(all / (end - first) / run.motors.length);
      };
      return `The platform sank by ${numbers.mm(most)} and was back within 0.1 mm after ${numbers.ms(back)}; the current ${
        run.motors.length * run.stage.sharing > 1 ? "of each motor " : ""}went from ${current(STORY_START)} to ${current(STORY_START + 2)}.`;
    } },
  { id: "pid", label: "PID against nonlinear", ghost: (run) => lawLike(run, "PID"), shot: { yaw: -22, pitch: 9, zoom: 1.15 },
    text: () => `Both are told to go ${numbers.mm(CHANGE)} down at once, shown five times slower. The nonlinear law knows how the pull `
      + "changes with the gap; the PID is tuned for one gap.",
    acts: (run, controller, start) => [{ at: STORY_START, type: "reference", axis: run.vertical, value: start[run.vertical] + CHANGE },
      ...slow(STORY_START - 0.02, STORY_START + 0.3, 0.2)],
    tell: (run, rows, time, ghost) => {
      if (time < STORY_START + 1.5) return undefined;
      const [ours, theirs] = [rows, ghost].map((seen) => gapLost(run, seen, STORY_START));
      const said = (lost) => (lost ? `hit ${lost.where} after ${numbers.ms(lost.after)}` : "reached it and stays");
      return `The PID ${said(theirs)}; the nonlinear law ${said(ours)}.`;
    } },
  { id: "weak", label: "Weak amplifiers", shot: { yaw: -22, pitch: 9, zoom: 1.15 },
    text: () => `After one second the amplifiers can give only ${SPARE} times the current that carries the platform; then it is pushed `
      + "down. Enough at rest, too little farther from the iron, whatever the law.",
    acts: (run, controller, start, needed) => [
      { at: STORY_START, type: "tune", values: motorValues(run, "amplifier.peak", Number((SPARE * Math.abs(needed)).toPrecision(2))), shown: true },
      { at: STORY_START + 1, type: "kick", axis: run.vertical, impulse: impulseOf(run.vertical) },
      ...slow(STORY_START + 0.98, STORY_START + 1.3, 0.2)],
    tell: (run, rows) => {
      const lost = gapLost(run, rows, STORY_START + 1), row = page.history.last();
      if (!lost) return undefined;
      const needed = carryingCurrent(run, atGap(run, row, lost.end), valueOf), peak = valueOf(`plant.${run.motors[0]}.amplifier.peak`);
      return `It needed more than the ${numbers.amperes(peak)} there were and hit ${lost.where} after ${numbers.ms(lost.after)}; `
        + `to lift off from there takes ${numbers.amperes(needed)}.`;
    } },
];

/** Return the introduction: the body that floats, and why it falls, at the start of the shown run. */
function introduction(run) {
  const row = restRow(run), rate = growth(run, row, valueOf);
  return `A platform of ${run.stage.mass[run.vertical]} kg hangs ${numbers.mm(row.axes[run.vertical].position, 0)} below the iron that its magnets pull at. `
    + `${Number.isFinite(rate) ? `Left alone, an error grows tenfold in ${numbers.ms(Math.log(10) / rate)}; a` : "A"} controller acts ${
      Math.round(1 / run.step)} times a second.`;
}

/** Return the start of a run (m, rad), as a row of a run. */
function restRow(run) {
  const axes = Object.fromEntries(run.axes.map((axis) => [axis, { position: valueOf(`plant.${axis}.position_start`) ?? 0 }]));
  return { axes, motors: Object.fromEntries(run.motors.map((motor) => [motor, { d: 0, q: 0 }])) };
}

/** Begin an experiment on the stage that is shown: its start, held there until something is done. */
function tellStory(id) {
  const story = STORIES.find((each) => each.id === id), run = live.runs[homeOf(page.run)];
  if (id === "beat" && !run.laws[LAW]) { runLaw(); return; }   // which comes back once it is taken
  page.run = run;
  const controller = story.controller?.(run) ?? lawLike(run, "nonlinear") ?? run.fmus.controller.model, ghost = story.ghost?.(run) ?? "";
  page.state = { ...page.state, run: homeOf(run), controller, ghost, speed: 1, settings: {}, story: id };
  known.clear();
  const row = restRow(run), start = Object.fromEntries(run.axes.map((axis) => [axis, row.axes[axis].position]));
  const acts = [...run.axes.map((axis) => ({ at: 0, type: "reference", axis, value: start[axis] })),
    ...story.acts(run, controller, start, carryingCurrent(run, row, valueOf))].sort((one, other) => one.at - other.at);
  begin(page.state, acts);
  page.shot = story.shot;
  if (id === "beat") askScores(run, true);
  page.story = { ...story, run, shown: acts.filter(({ shown }) => shown) };
  play(true);
  say("");
  at("released").hidden = false;
  at("moment").textContent = "";
}

/** Return the run with which the experiments of a stage begin: that of its description. Otherwise it is the first of
 * those with most references that change least of the plant, and in which nothing else happens. */
function homeOf({ stage }) {
  if (live.runs[stage.home]) return stage.home;
  const worth = (name) => {
    const { signals, fmus } = live.runs[name], references = signals.filter(({ to }) => to.endsWith(".reference")).length;
    if (references < signals.length || fmus.measurement) return -Infinity;   // something happens in it anyway
    return 100 * references - Object.keys(fmus.plant.start).length;
  };
  return Object.keys(live.runs).filter((name) => live.runs[name].stage === stage)
    .reduce((one, other) => (worth(other) > worth(one) ? other : one));
}

/** Follow an experiment: show its settings once they are set, and its result once it is there. */
function followStory(time) {
  const { story } = page;
  if (!story || page.run !== story.run) return;
  for (const act of story.shown.filter((each) => time >= each.at)) {
    story.shown.splice(story.shown.indexOf(act), 1);
    Object.assign(page.state.settings, act.values);
    stateChanged();
  }
  const told = at("moment").textContent === "" && story.tell(story.run, page.history, time, page.ghost);
  if (told) at("moment").textContent = told;
}

/** The line under the title, or the story of the experiment. */
function showStory() {
  const { state, run } = page;
  at("what").textContent = state.story ? STORIES.find(({ id }) => id === state.story).text(run) : introduction(run);
  for (const button of at("stories").children) button.setAttribute("aria-pressed", String(button.value === state.story));
}
