"""Status codes of the controllers' `start` and `step`."""

STEPPED = 0
STEP_MISFIT = 1        # the communication step does not fit the sample time
NO_EQUILIBRIUM = 2     # the model holds the mover nowhere at the setpoint
PREFILTER_TOO_FAST = 3  # the reference pre-filter would be unstable at the sample time
BAD_GEOMETRY = 4        # no motor has such a geometry
BAD_PLACES = 5          # the motors stand on one line, and cannot make every force and torque

NONLINEAR = 0   # laws of a regulator
LINEAR = 1
SCHEDULED = 2
INTERPOLATED = 3
