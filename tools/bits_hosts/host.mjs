// The run of a WebAssembly module made of host.c, in Node: node host.mjs FILE.wasm writes its digest.

import { readFileSync } from "node:fs";

const { instance } = await WebAssembly.instantiate(readFileSync(process.argv[2]), {});
instance.exports._initialize();
console.log(BigInt.asUintN(64, instance.exports.digest_of_run()).toString(16).padStart(16, "0"));
