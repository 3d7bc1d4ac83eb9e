#!/bin/sh
# The 3DOF plant alone, open loop, under the phase currents that the regulator commanded while it moved the stage.
# Run from the folder that holds fmus; FMUS names another folder, OUT another file for the result.
here=$(dirname "$0")
sh "$here/simulate.sh" "Plant3DOF" "$here/plant_3dof_inputs.csv" 0.25 0.0002 "${OUT:-plant_3dof.csv}"
