// What the live page takes of CodeMirror; `npm install --no-package-lock && npm run build` here writes maglev/pages/live/vendor/codemirror.js of it.
export { EditorView, Decoration, keymap, lineNumbers } from "@codemirror/view";
export { EditorState, StateEffect, StateField } from "@codemirror/state";
export { defaultKeymap, history, historyKeymap } from "@codemirror/commands";
export { HighlightStyle, StreamLanguage, bracketMatching, indentOnInput, syntaxHighlighting } from "@codemirror/language";
export { javascript } from "@codemirror/legacy-modes/mode/javascript";
export { tags } from "@lezer/highlight";
