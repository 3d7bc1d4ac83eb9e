"""One self-contained HTML page about a study: claims with their verdicts, figures of the runs, a moving picture."""
