#!/bin/sh
# The 2DOF regulator alone, under the positions that were measured and the references that were set in a run.
# Run from the folder that holds fmus; FMUS names another folder, OUT another file for the result.
here=$(dirname "$0")
fmpy simulate "${FMUS:-fmus}/Regulator2DOF.fmu" --input-file "$here/controller_2dof_inputs.csv" \
    --stop-time 0.25 --output-interval 0.0005 --output-file "${OUT:-controller_2dof.csv}"
