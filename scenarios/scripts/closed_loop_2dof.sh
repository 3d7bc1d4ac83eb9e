#!/bin/sh
# A 2DOF plant under its controller, in one FMU: the setpoint experiment of 26 s, complete.
# Run from the folder that holds fmus; FMUS names another folder, OUT another file for the result, LOOP another loop than
# that of the regulator, STOP_TIME an earlier end (s).
here=$(dirname "$0")
sh "$here/simulate.sh" "${LOOP:-ClosedLoop2DOF}" "$here/../inputs/2dof-setpoints.csv" "${STOP_TIME:-26}" 0.0005 "${OUT:-closed_loop_2dof.csv}"
