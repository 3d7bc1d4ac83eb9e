"use strict";
// A reader's controller: a module with its description, dropped on the page, or a law in JavaScript, written in
// it. A law is code. It runs only in the worker, which the page's policy keeps from the network, and which is ended if
// it does not respond. A law that came with a link runs when the reader says so, and not before.

const LAW = "own:law";
const LONGEST_LINK = 12000;    // characters of a law in an address
const LONGEST_LAW = 100000;    // characters of its text
const SILENT = 4;              // looks, a second apart, without an answer, after which a worker is ended

const own = { packed: "", asked: null, silent: 0, present: false };

const lawSaid = (text, bad = false) => {
  at("law-said").textContent = text;
  at("law-said").classList.toggle("bad", bad);
  markLine(Number(/line (\d+): /.exec(text)?.[1] ?? 0));
};

/** Bytes as text for an address, and back. */
const toText = (bytes) => btoa(String.fromCharCode(...bytes)).replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "");
const toBytes = (text) => Uint8Array.from(atob(text.replaceAll("-", "+").replaceAll("_", "/")), (character) => character.charCodeAt(0));
const through = (bytes, stream) => new Blob([bytes]).stream().pipeThrough(stream);

/** Text of a law in an address; it is read no further than a law may be long. */
async function unpackedLaw(packed) {
  const reader = through(toBytes(packed), new DecompressionStream("deflate-raw")).getReader(), decoder = new TextDecoder();
  let text = "";
  for (let part = await reader.read(); !part.done; part = await reader.read()) {
    text += decoder.decode(part.value, { stream: true });
    if (text.length > LONGEST_LAW) throw new Error(`the law of this link is longer than ${LONGEST_LAW} characters`);
  }
  return text;
}

/** Show a law that came with an address, and its result: it is not run. */
async function showSharedLaw(packed, result) {
  try {
    setLawText(await unpackedLaw(packed));
    Object.assign(beat, { yours: result, sent: Boolean(result) });
    showResult();
    lawSaid("This link contains a law: code that somebody wrote. It runs only when you press “Run it”, in this page.");
  } catch (error) {
    say(`The law of this link cannot be read: ${error.message}`, true);
  }
}

/** Have the worker try a controller on the run that is shown; from now on it has to answer. */
function tryOwn(brought) {
  own.asked.model = brought.model;
  own.present ||= own.asked.script;   // in the worker, whatever runs later
  post({ type: "own", name: own.asked.name, run: page.state.run, ...brought });
  own.silent = 0;
  own.waiting = true;
}

/** Try the law that is written, and give it the task. */
async function runLaw() {
  if (!page.run) return;   // while the controllers are being unpacked
  const text = lawText();
  if (text.length > LONGEST_LAW) { lawSaid(`The law has ${text.length} characters, expected at most ${LONGEST_LAW}.`, true); return; }
  const packed = await new Response(through(new TextEncoder().encode(text), new CompressionStream("deflate-raw"))).arrayBuffer();
  own.asked = { packed: toText(new Uint8Array(packed)), script: true, label: "yours", name: "law" };
  lawSaid("");
  tryOwn({ model: LAW, text });
}

/** Read what a model description says of its variables. */
function described(xml) {
  const root = new DOMParser().parseFromString(xml, "text/xml").documentElement;
  if (root.nodeName !== "fmiModelDescription") throw new Error("expected a model description of FMI 2.0");
  const number = (element, name, otherwise) => (element.hasAttribute(name) ? Number(element.getAttribute(name)) : otherwise);
  const variables = [...root.querySelectorAll("ScalarVariable")].map((variable) => {
    const type = variable.firstElementChild, boolean = type?.nodeName === "Boolean";
    return { name: variable.getAttribute("name"), reference: number(variable, "valueReference"), boolean,
      causality: variable.getAttribute("causality"), fixed: variable.getAttribute("variability") === "fixed",
      start: boolean ? type.getAttribute("start") === "true" : number(type, "start", 0), unit: type?.getAttribute("unit") ?? "",
      description: variable.getAttribute("description") ?? "", min: number(type, "min", -1e12), max: number(type, "max", 1e12) };
  });
  return { name: root.getAttribute("modelName"), guid: root.getAttribute("guid"), variables };
}

/** Take in the files of a controller: its module and its description, as `maglev build` writes them; or a page with a stage. */
async function takeFiles(files) {
  try {
    const other = [...files].find(({ name }) => name.endsWith(".html"));
    if (other) { await takePage(other); return; }
    const [module, description] = [".wasm", ".xml"].map((ending) => [...files].find(({ name }) => name.endsWith(ending)));
    if (!module || !description) {
      throw new Error(`${[...files].map(({ name }) => name).join(", ")}: expected the pair NAME.wasm and NAME.xml that maglev build `
        + "FILE.py --kind native --target wasm writes");
    }
    const about = described(await description.text());
    if (about.variables.some(({ name, causality }) => causality === "output" && name.endsWith(".encoder"))) {
      throw new Error(`${about.name} is a stage, expected a controller of the one that runs: for your own stage drop the page that maglev live FILE.toml writes`);
    }
    own.asked = { packed: "", script: false, label: about.name, name: about.name };
    tryOwn({ model: `own:${about.name}`, bytes: new Uint8Array(await module.arrayBuffer()), about });
  } catch (error) {
    at("own").open = true;
    say(error.message, true);
  }
}

/** Accept a controller that fits the shown stage: add it to the controllers, and run it; a law gets the task. */
function owned({ model, about }) {
  own.waiting = false;
  live.fmus[model] = about;
  for (const run of Object.values(live.runs)) if (run.plant === page.run.plant) run.laws[model] = own.asked.label;
  say("");
  if (own.asked.script) {
    own.packed = own.asked.packed;
    if (own.packed.length > LONGEST_LINK) lawSaid(`It is too long for a link: ${own.packed.length} characters packed, at most ${LONGEST_LINK}.`);
    tellStory("beat");
    return;
  }
  if (page.frame?.flags.stop || page.ended) begin({ ...page.state, controller: model });
  else swap(model);
  play(true);
}

function ownRefused({ text }) {
  own.waiting = false;
  if (own.asked.script) lawSaid(text, true); else at("own").open = true;
  say(text, true);
}

/** End a worker in which the reader's controller does not respond, and continue with another one. */
function watchOwn() {
  if (!own.waiting && !isOwn(page.state?.controller ?? "") && !isOwn(page.state?.ghost ?? "")) { own.silent = 0; return; }
  // Looks are counted, not time: a page that stands still for seconds has heard nothing either.
  own.silent = document.hidden ? 0 : own.silent + 1;
  if (own.silent <= SILENT) { post({ type: "alive" }); return; }
  own.waiting = false;
  own.silent = 0;
  for (const run of Object.values(live.runs)) for (const name of Object.keys(run.laws)) if (isOwn(name)) delete run.laws[name];
  own.present = false;
  startWorker();
  const text = `${own.asked.name}: a step took longer than ${SILENT} s, so the controller was removed.`;
  own.after = () => {
    begin({ ...page.state, controller: page.run.fmus.controller.model, ghost: "" });
    play(true);
    ownRefused({ text });
  };
  loadWorker();
}

function buildOwn() {
  at("own-files").addEventListener("change", () => { takeFiles(at("own-files").files); at("own-files").value = ""; });
  addEventListener("dragover", (event) => event.preventDefault());
  addEventListener("drop", (event) => {
    event.preventDefault();
    if (event.dataTransfer.files.length) takeFiles(event.dataTransfer.files);
  });
  setInterval(watchOwn, 1000);
}
