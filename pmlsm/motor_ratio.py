"""Constants and limit of a motor that differs from the others, relative to those of the stage."""


class MotorRatio:
    """Factors to the constants of the velocity rows, and to the largest current that controllers command."""

    def __init__(self, thrust: float, attraction: float, coils: float, iron: float, limit: float):
        self.thrust = thrust            # parameter
        self.attraction = attraction    # parameter
        self.coils = coils              # parameter
        self.iron = iron                # parameter
        self.limit = limit              # parameter of controllers: by current_limit
