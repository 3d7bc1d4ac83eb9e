"""The Procedures of the thesis: what several runs together say about the model, its tables and figures."""
