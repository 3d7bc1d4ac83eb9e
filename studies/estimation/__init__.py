"""The assumed effects of the stages, estimated from part of the evidence and judged on the rest."""
