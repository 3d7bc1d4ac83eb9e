"use strict";
// Messages that the worker may send. The reader's law runs in that thread and can send anything. The page ignores
// messages of another shape than it expects, and never shows their texts as its own.

const LONGEST_TEXT = 600;      // characters
const MOST_VARIABLES = 5000;   // in a controller's own description

const isNumber = (value) => typeof value === "number" && Number.isFinite(value);
const isText = (value) => typeof value === "string" && value.length > 0;
const isRows = (value) => value instanceof Float32Array && page.width > 0 && value.length % page.width === 0;
const areFlags = (value) => typeof value === "object" && Object.entries(value ?? {}).every(([name, on]) =>
  Object.hasOwn(EVENTS, name) && typeof on === "boolean");
const isAbout = (value) => Array.isArray(value?.variables) && value.variables.length <= MOST_VARIABLES
  && value.variables.every(({ name, causality, unit = "", description = "" }) =>
    [name, causality, unit, description].every((text) => typeof text === "string"));

const SHAPES = {
  loaded: {},
  alive: {},
  started: { width: (value) => value === 1 + 3 * page.run.axes.length + 5 * page.run.motors.length },
  frame: { rows: isRows, ghostRows: isRows, flags: (value) => value !== null && areFlags(value), ghostFlags: areFlags,
    pace: isNumber, time: isNumber },
  refused: { text: isText },
  "ghost refused": { text: isText },
  "own refused": { text: isText },
  "not done": { text: isText },
  owned: { model: (value) => own.waiting && value === own.asked.model, about: isAbout },
  scored: { number: isNumber, values: (value) => Array.isArray(value) && [0, 6].includes(value.length) && value.every(isNumber), lost: isNumber },
};

const isHeard = (message) => typeof message === "object" && message !== null && Object.hasOwn(SHAPES, message.type)
  && Object.entries(SHAPES[message.type]).every(([key, holds]) => holds(message[key]));

/** A message as the page takes it: a text from where a law is says whose it is, an FMU's or the law's. */
function taken(message) {
  if (typeof message.text !== "string") return message;
  const text = message.text.slice(0, LONGEST_TEXT), said = ["law", ...Object.keys(live.fmus)].some((name) => text.startsWith(`${name}: `));
  return { ...message, text: own.present && !said ? `law: ${text}` : text };
}
