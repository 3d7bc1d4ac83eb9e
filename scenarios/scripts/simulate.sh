#!/bin/sh
# Simulate an FMU with FMPy, and say where the result is: simulate.sh NAME INPUTS STOP_TIME STEP RESULT.
# FMUS names the folder of the FMUs, in place of fmus; native ones in its folder native go first, which take a tenth of the
# time for the same results.
folder=${FMUS:-fmus}
fmu=$folder/native/$1.fmu
[ -f "$fmu" ] || fmu=$folder/$1.fmu
if ! [ -f "$fmu" ]; then
    echo "$1.fmu is neither in $folder/native nor in $folder:" \
        "\`maglev build $1 --fmus $folder\` builds it, with --kind native one that is fast" >&2
    exit 2
fi
if ! command -v fmpy > /dev/null; then
    echo "fmpy was not found: \`. .venv/bin/activate\`, or \`pip install fmpy\`" >&2
    exit 2
fi
fmpy simulate "$fmu" --input-file "$2" --stop-time "$3" --output-interval "$4" --output-file "$5" && echo "results: $5"
