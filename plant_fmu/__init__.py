"""The plants: amplifiers, guides, end stops, encoders and the motion of the stages."""
