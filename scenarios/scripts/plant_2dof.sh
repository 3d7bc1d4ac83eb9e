#!/bin/sh
# The 2DOF plant alone, open loop, under the phase currents that the regulator commanded while it moved the stage.
# Run from the folder that holds fmus; FMUS names another folder, OUT another file for the result.
here=$(dirname "$0")
sh "$here/simulate.sh" "Plant2DOF" "$here/plant_2dof_inputs.csv" 0.25 0.0005 "${OUT:-plant_2dof.csv}"
