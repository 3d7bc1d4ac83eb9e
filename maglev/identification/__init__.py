"""Identification of a stage's constants from recorded data (chapter 3): estimators, diagnostics, files."""
