#!/bin/sh
# The 3DOF regulator alone, under the positions that were measured and the references that were set in a run.
# Run from the folder that holds fmus; FMUS names another folder, OUT another file for the result.
here=$(dirname "$0")
fmpy simulate "${FMUS:-fmus}/Regulator3DOF.fmu" --input-file "$here/controller_3dof_inputs.csv" \
    --stop-time 0.25 --output-interval 0.0002 --output-file "${OUT:-controller_3dof.csv}"
