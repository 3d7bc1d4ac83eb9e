"use strict";
// The content of the page, unpacked: descriptions and runs as JSON, modules as bytes; then everything begins.

/** Return the content of a page. */
async function contentOf(from) {
  const held = (id) => unpacked(from.getElementById(id).textContent);
  const content = JSON.parse(new TextDecoder().decode(await held("data")));
  for (const run of Object.values(content.runs)) run.stage = content.stages[run.stage];
  for (const { variables } of Object.values(content.fmus)) variables.forEach((each, i) => { each.reference = i; });
  const names = Object.keys(content.fmus);
  const bytes = await Promise.all(names.map((name) => held(`fmu-${name}`)));
  content.worker = new TextDecoder().decode(await held("worker"));
  content.binaries = Object.fromEntries(names.map((name, i) => [name, bytes[i]]));
  return content;
}

/** List the runs by stage; the panel is rebuilt for the next run. */
function listRuns() {
  shownRun = "";
  at("run").replaceChildren();
  for (const stage of Object.values(live.stages).reverse()) {
    const runs = Object.entries(live.runs).filter(([, run]) => run.stage === stage);
    const group = runs.length && html("optgroup", { label: stage.title }, at("run"));
    for (const [name, { title }] of runs) {
      const short = title.replace(`${stage.title}: `, "");
      html("option", { value: name, title: name }, group, short[0].toUpperCase() + short.slice(1));
    }
  }
}

/** Text of the scripts of a page: pages with the same one carry what is of one shape. */
const programOf = (from) => [...from.querySelectorAll("script:not([id]), #worker")].map(({ textContent }) => textContent).join();

/** Fly the content of another page of this kind, instead of this page's, until it is loaded again. */
async function takePage(file) {
  const from = new DOMParser().parseFromString(await file.text(), "text/html");
  if (programOf(from) !== programOf(document)) {
    throw new Error(`${file.name}: expected a page of maglev live, of the version of this one: ${at("version").textContent}`);
  }
  live = await contentOf(from);
  makeOpponents();
  listRuns();
  // The reader's controller was for the stage before.
  Object.assign(own, { packed: "", present: false, waiting: false, silent: 0, after: () => {
    openState(readFragment("").state);
    play(true);
    say(`The stages of ${file.name} run here until this page is reloaded.`);
  } });
  startWorker();
  loadWorker();
}

async function startPage() {
  live = await contentOf(document);
  makeOpponents();
  listRuns();
  buildPanel();
  buildOwn();
  buildBeat();
  requestAnimationFrame(draw);
  startWorker();
  loadWorker();
  if (at("text").open) buildEditor().catch((error) => page.problems.push(String(error)));
}

if (parent !== window) document.documentElement.classList.add("framed");   // on a page that has its own heading and ways: the stage alone
startPage().catch((error) => {
  page.problems.push(String(error));
  say(`This page cannot start: ${error.message}. It needs WebAssembly and DecompressionStream, as browsers of 2023 have.`,
    true);
});
