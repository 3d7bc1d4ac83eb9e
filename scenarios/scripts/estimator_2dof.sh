#!/bin/sh
# The 2DOF estimator alone, under the positions that were measured and the currents that were delivered at the start of
# Procedure 4. The estimates have left their first guesses; to settle they need some 10 s.
# Run from the folder that holds fmus; FMUS names another folder, OUT another file for the result.
here=$(dirname "$0")
fmpy simulate "${FMUS:-fmus}/Estimator2DOF.fmu" --input-file "$here/estimator_2dof_inputs.csv" \
    --stop-time 1 --output-interval 0.0005 --output-file "${OUT:-estimator_2dof.csv}"
