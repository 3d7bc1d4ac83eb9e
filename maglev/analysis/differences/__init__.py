"""What a participant does, by differences of its responses: derivatives, and the state space of these."""
