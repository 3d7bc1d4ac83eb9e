#!/bin/sh
# The 2DOF commutation alone, under the current of the parabola experiment (Fig. 4.8), with the mover pushed past the
# stator at a constant speed. Run from the folder that holds fmus; FMUS names another folder, OUT another file for the
# result.
here=$(dirname "$0")
sh "$here/simulate.sh" "Commutation2DOF" "$here/commutation_2dof_inputs.csv" 0.25 0.0005 "${OUT:-commutation_2dof.csv}"
