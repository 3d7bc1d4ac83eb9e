#!/bin/sh
# The 3DOF commutation alone, under the currents of the parabola experiment (Figs. 5.7, 5.8), with the mover pushed past
# the stators at constant speeds. Run from the folder that holds fmus; FMUS names another folder, OUT another file for
# the result.
here=$(dirname "$0")
fmpy simulate "${FMUS:-fmus}/Commutation3DOF.fmu" --input-file "$here/commutation_3dof_inputs.csv" \
    --stop-time 0.25 --output-interval 0.0002 --output-file "${OUT:-commutation_3dof.csv}"
