#!/bin/sh
# A 3DOF controller alone, under the positions that were measured and the references that were set in a run.
# Run from the folder that holds fmus; FMUS names another folder, OUT another file for the result, CONTROLLER another
# controller than the regulator of that run.
here=$(dirname "$0")
sh "$here/simulate.sh" "${CONTROLLER:-Regulator3DOF}" "$here/controller_3dof_inputs.csv" 0.25 0.0002 "${OUT:-controller_3dof.csv}"
