"""What the stages do: amplifiers, guides, end stops, encoders and the motion of the 2-DOF and 3-DOF rigs."""
