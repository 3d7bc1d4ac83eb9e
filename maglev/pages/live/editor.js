"use strict";
// The text of a law: in CodeMirror once that is unpacked, in a plain field until then.

const editor = { field: null, view: null, setBad: null };

const lawText = () => (editor.view ? editor.view.state.doc.toString() : editor.field.value);

function setLawText(text) {
  if (text === lawText()) return;
  editor.setting = true;
  editor.field.value = text;
  editor.view?.dispatch({ changes: { from: 0, to: editor.view.state.doc.length, insert: text } });
  editor.setting = false;
}

/** A text written by hand for the shown stage outlives the page, if the browser keeps data for it. */
const lawPlace = () => `maglev law ${page.run.plant}`;
function keepLaw(text = lawText()) {
  try { localStorage.setItem(lawPlace(), text); } catch { /* it is in the field alone */ }
}
function keptLaw() {
  try { return localStorage.getItem(lawPlace()) ?? ""; } catch { return ""; }
}

/** Mark a line that is wrong, and show it; none at 0. */
function markLine(number) {
  const { view, setBad } = editor;
  if (!view) return;
  const line = number >= 1 && number <= view.state.doc.lines ? view.state.doc.line(number) : null;
  view.dispatch({ effects: [setBad.of(line?.from ?? null), ...(line ? [CodeMirror.EditorView.scrollIntoView(line.from, { y: "center" })] : [])] });
}

function buildField() {
  editor.field = html("textarea", { id: "law-field", spellcheck: "false", autocapitalize: "off", autocomplete: "off", wrap: "off",
    "aria-label": "The law" }, at("law"));
  editor.field.addEventListener("input", () => keepLaw());
  editor.field.addEventListener("keydown", (event) => {
    if (event.key === "Enter" && (event.ctrlKey || event.metaKey)) { event.preventDefault(); runLaw(); }
  });
}

/** Unpack CodeMirror, and replace the field by it; the text stays. */
async function buildEditor() {
  if (editor.view || editor.asked) return;
  editor.asked = true;
  const address = URL.createObjectURL(new Blob([await unpacked(at("editor").textContent)], { type: "text/javascript" }));
  const script = document.createElement("script");
  await new Promise((resolve, reject) => {
    document.head.append(Object.assign(script, { src: address, onload: resolve, onerror: reject }));
  });
  script.remove();
  URL.revokeObjectURL(address);
  const { EditorView, EditorState, StateEffect, StateField, Decoration, tags } = CodeMirror;
  editor.setBad = StateEffect.define();
  const bad = StateField.define({
    create: () => Decoration.none,
    update: (shown, { changes, effects, docChanged }) => effects.filter((each) => each.is(editor.setBad)).reduce((_, { value }) =>
      (value === null ? Decoration.none : Decoration.set([Decoration.line({ class: "cm-bad" }).range(value)])),
    docChanged ? shown.map(changes) : shown),
    provide: (field) => EditorView.decorations.from(field),
  });
  const style = CodeMirror.HighlightStyle.define([{ tag: tags.keyword, class: "cm-k" }, { tag: tags.comment, class: "cm-c" }]);
  const run = { key: "Mod-Enter", run: () => { runLaw(); return true; } };
  editor.view = new EditorView({ parent: at("law"), state: EditorState.create({ doc: editor.field.value, extensions: [
    CodeMirror.keymap.of([run, ...CodeMirror.defaultKeymap, ...CodeMirror.historyKeymap]), CodeMirror.lineNumbers(), CodeMirror.history(),
    CodeMirror.bracketMatching(), CodeMirror.indentOnInput(), CodeMirror.StreamLanguage.define({ ...CodeMirror.javascript, tokenTable: { property: tags.propertyName } }),
    CodeMirror.syntaxHighlighting(style), EditorView.contentAttributes.of({ "aria-label": "The law" }),
    EditorView.updateListener.of(({ docChanged }) => { if (docChanged && !editor.setting) keepLaw(); }), bad] }) });
  editor.field.hidden = true;
}
