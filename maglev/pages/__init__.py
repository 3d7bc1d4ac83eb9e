"""Pages: figures, report, comparison, study and live page, with shared colours, panels and links."""
