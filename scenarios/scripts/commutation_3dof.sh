#!/bin/sh
# The 3DOF commutation alone, under the currents of the parabola experiment (Figs. 5.7, 5.8), with the mover pushed past
# the stators at constant speeds. Run from the folder that holds fmus; FMUS names another folder, OUT another file for
# the result.
here=$(dirname "$0")
sh "$here/simulate.sh" "Commutation3DOF" "$here/commutation_3dof_inputs.csv" 0.25 0.0002 "${OUT:-commutation_3dof.csv}"
