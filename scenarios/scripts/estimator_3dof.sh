#!/bin/sh
# The 3DOF estimator alone, under the positions that were measured and the currents that were delivered at the start of
# Procedure 4. The estimates have left their first guesses; to settle they need some 10 s.
# Run from the folder that holds fmus; FMUS names another folder, OUT another file for the result.
here=$(dirname "$0")
fmpy simulate "${FMUS:-fmus}/Estimator3DOF.fmu" --input-file "$here/estimator_3dof_inputs.csv" \
    --stop-time 0.5 --output-interval 0.0002 --output-file "${OUT:-estimator_3dof.csv}"
