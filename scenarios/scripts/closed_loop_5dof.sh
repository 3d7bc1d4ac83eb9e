#!/bin/sh
# A 5DOF plant under its controller, in one FMU: the setpoint experiment of 21 s, complete.
# Run from the folder that holds fmus; FMUS names another folder, OUT another file for the result, LOOP another loop than
# that of the regulator, STOP_TIME an earlier end (s).
here=$(dirname "$0")
sh "$here/simulate.sh" "${LOOP:-ClosedLoop5DOF}" "$here/../inputs/5dof-setpoints.csv" "${STOP_TIME:-21}" 0.0002 "${OUT:-closed_loop_5dof.csv}"
