"""Programs of the real-time computer: observer, internal model, regulator, anti-windup, commutation, safety trip."""
