#!/bin/sh
# The 3DOF plant alone, open loop, under the phase currents that the regulator commanded while it moved the stage.
# Run from the folder that holds fmus; FMUS names another folder, OUT another file for the result.
here=$(dirname "$0")
fmpy simulate "${FMUS:-fmus}/Plant3DOF.fmu" --input-file "$here/plant_3dof_inputs.csv" \
    --stop-time 0.25 --output-interval 0.0002 --output-file "${OUT:-plant_3dof.csv}"
