#!/bin/sh
# The 2DOF plant alone, open loop, under the phase currents that the regulator commanded while it moved the stage.
# Run from the folder that holds fmus; FMUS names another folder, OUT another file for the result.
here=$(dirname "$0")
fmpy simulate "${FMUS:-fmus}/Plant2DOF.fmu" --input-file "$here/plant_2dof_inputs.csv" \
    --stop-time 0.25 --output-interval 0.0005 --output-file "${OUT:-plant_2dof.csv}"
