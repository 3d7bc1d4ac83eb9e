#!/bin/sh
# A 3DOF controller alone, under the positions that were measured and the references that were set in a run.
# Run from the folder that holds fmus; FMUS names another folder, OUT another file for the result, CONTROLLER another
# controller than the regulator of that run.
here=$(dirname "$0")
fmpy simulate "${FMUS:-fmus}/${CONTROLLER:-Regulator3DOF}.fmu" --input-file "$here/controller_3dof_inputs.csv" \
    --stop-time 0.25 --output-interval 0.0002 --output-file "${OUT:-controller_3dof.csv}"
