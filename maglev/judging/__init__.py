"""From a recorded run to metrics, and from these to verdicts on claims."""
