#!/bin/sh
# The 2DOF estimator alone, under the positions that were measured and the currents that were delivered at the start of
# Procedure 4. The estimates have left their first guesses; to settle they need some 10 s.
# Run from the folder that holds fmus; FMUS names another folder, OUT another file for the result.
here=$(dirname "$0")
sh "$here/simulate.sh" "Estimator2DOF" "$here/estimator_2dof_inputs.csv" 1 0.0005 "${OUT:-estimator_2dof.csv}"
