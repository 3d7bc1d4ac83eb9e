"use strict";
// What the page carries, unpacked: descriptions and runs as JSON, modules as bytes; then everything begins.

/** Bytes of an element that holds gzip in base64. */
async function unpacked(id) {
  const packed = Uint8Array.from(atob(document.getElementById(id).textContent), (character) => character.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

async function startPage() {
  live = JSON.parse(new TextDecoder().decode(await unpacked("data")));
  for (const run of Object.values(live.runs)) run.rig = live.rigs[run.rig];
  const names = Object.keys(live.fmus);
  const bytes = await Promise.all(names.map((name) => unpacked(`fmu-${name}`)));
  live.binaries = Object.fromEntries(names.map((name, i) => [name, bytes[i]]));
  buildPanel();
  buildOwn();
  requestAnimationFrame(draw);
  startWorker();
  loadWorker();
}

if (parent !== window) document.querySelector(".shell")?.remove();   // in a frame of the site, which has its own way
startPage().catch((error) => {
  page.problems.push(String(error));
  say(`This page cannot start: ${error.message}. It needs WebAssembly and DecompressionStream, as browsers of 2023 have.`,
    true);
});
