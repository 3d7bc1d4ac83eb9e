"""What the real-time computer does: observer, internal model, regulator, anti-windup, commutation, safety trip."""
