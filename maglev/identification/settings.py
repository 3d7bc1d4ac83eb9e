"""Settings of the estimators, apart so that the command line can show them without numpy."""

METHODS = ("reduced", "full", "fsdi")
GAMMA = 1.1        # γ, section 4.3.3
EPSILON = 0.01     # ε, s, section 4.3.3
