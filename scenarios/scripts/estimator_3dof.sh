#!/bin/sh
# The 3DOF estimator alone, under the positions that were measured and the currents that were delivered at the start of
# Procedure 4. The estimates have left their first guesses; to settle they need some 10 s.
# Run from the folder that holds fmus; FMUS names another folder, OUT another file for the result.
here=$(dirname "$0")
sh "$here/simulate.sh" "Estimator3DOF" "$here/estimator_3dof_inputs.csv" 0.5 0.0002 "${OUT:-estimator_3dof.csv}"
