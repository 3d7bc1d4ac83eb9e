"""Identification of the motor constants as a component: the reduced-order NPFSI estimator (3.8), sample by sample."""
