"""Where the motors of a platform that tilts are: the matrices J and S, and the displacements at the magnets."""

from controller_fmu.motor_place import MotorPlace
from controller_fmu.symmetric3 import Symmetric3


class TiltingPlatform:
    """Height of the magnets' faces, and JᵀJ of the motors, see `MotorPlace`."""

    def __init__(self, height: float):
        self.height = height          # m, parameter: of the magnets' faces below the centre of mass
        self.square = Symmetric3()    # JᵀJ
        self.motors = 0.0             # how many there are

    def begin(self) -> None:
        """Begin with no motor."""
        self.square.set_diagonal(0.0, 0.0, 0.0)
        self.motors = 0.0

    def add(self, place: MotorPlace) -> None:
        """Take in a motor's row of J."""
        self.square.add_square(1.0, 1.0, -place.z, place.x)
        self.motors += 1.0

    def solvable(self) -> bool:
        """Factorise JᵀJ; whether the motors feel and make every tilt, that is are not all on one line."""
        square = self.square
        square.factorise()
        return square.g1 > 0.0 and square.g2 > 0.0 and square.g3 > 0.0

    def rolls(self) -> bool:
        """Factorise JᵀJ where guides hold pitch and no motor has an x; whether the motors feel and make roll."""
        square = self.square
        square.factorise()
        return square.g1 > 0.0 and square.g2 > 0.0

    def share(self, place: MotorPlace) -> None:
        """Give a motor its column of S."""
        place.share_y, place.share_roll, place.share_pitch = self.square.solve(1.0, -place.z, place.x)

    def spread_x(self) -> float:
        """Σ x² / n of the motors, m²."""
        return self.square.s33 / self.motors

    def spread_z(self) -> float:
        """Σ z² / n of the motors, m²."""
        return self.square.s22 / self.motors

    def along_x(self, x: float, pitch: float) -> float:
        """Displacement (m) at the faces of the magnets, with which motors commutate that drive along x."""
        return x - self.height * pitch

    def along_z(self, z: float, roll: float) -> float:
        """Displacement (m) at the faces of the magnets, with which motors commutate that drive along z."""
        return z + self.height * roll
