"""What lies between a stage's encoders and its controller: noise, errors, delay, and samples that do not arrive."""
