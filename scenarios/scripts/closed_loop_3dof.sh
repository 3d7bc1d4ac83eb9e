#!/bin/sh
# A 3DOF plant under its controller, in one FMU: the setpoint experiment of 26 s, complete.
# Run from the folder that holds fmus; FMUS names another folder, OUT another file for the result, LOOP another loop than
# that of the regulator, STOP_TIME an earlier end (s).
here=$(dirname "$0")
sh "$here/simulate.sh" "${LOOP:-ClosedLoop3DOF}" "$here/../inputs/3dof-setpoints.csv" "${STOP_TIME:-26}" 0.0002 "${OUT:-closed_loop_3dof.csv}"
