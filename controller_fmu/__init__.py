"""What the real-time computer does: observer, internal model, regulator, antiwindup, commutation, safety trip."""
