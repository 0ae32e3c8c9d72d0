#!/usr/bin/env bash
# A motor of a simulated Uno, from its switch to a pulled plug.
#
#     cargo install --path crates/stepwright-cli
#     examples/uno.sh
#
# The firmware runs in a simulator (`cargo xtask sim uno`), with a limit switch 300 steps
# behind the place where the motor stands. The script homes the motor, turns it to 90°,
# changes that travel from a second terminal, and pulls the plug in the middle of a travel.
# Each result is checked: it ends with status 0 if all were right.
#
# SIM names another simulator, PORT_LINK another name for its port.

set -euo pipefail
cd "$(dirname "$0")/.."
sim=${SIM:-cargo xtask sim}
# In $TMPDIR, or in /tmp.
scratch=$(mktemp -d)
port=${PORT_LINK:-$scratch/port}
export STEPWRIGHT_MACHINE=none

fail() {
    echo "$0: $*" >&2
    exit 1
}

# Runs a command in sight: "$ " and its words before what it says.
show() {
    echo
    echo "\$ $*"
    "$@"
}

# The simulator reads acts from file descriptor 3: `power` pulls the plug and puts it back.
coproc SIM_UNO { exec $sim uno --switch 1:-300 --pty-link "$port"; }
simulator=$SIM_UNO_PID
exec 3>&"${SIM_UNO[1]}"
trap 'kill "$simulator" 2>/dev/null && wait "$simulator" || true; rm -rf "$scratch"' EXIT
read -r said <&"${SIM_UNO[0]}" || fail "the simulator does not start"
echo "the simulated Uno is at $port ($said)"
motor=(--steps-per-rev 3200)

echo
echo "## Home: the switch is where it was wired, and 0 is where it closes"
show stepwright settings set switches=1 --port "$port"
show stepwright home --port "$port" --speed 400 --slow 50 --back-off 40 --within 3000
[[ $(stepwright position --port "$port") == "position 40 ready" ]] || fail "not 40 steps from the switch"

echo
echo "## A quarter of a turn, counted from 0"
show stepwright move --to 90deg "${motor[@]}" --port "$port"
[[ $(stepwright position --port "$port") == "position 800 ready" ]] || fail "not at 90°"

echo
echo "## A second terminal watches, and changes the travel of the first"
stepwright move --to 720deg "${motor[@]}" --top-speed 800 --port "$port" >/dev/null 2>&1 &
first=$!
until [[ $(stepwright position --port "$port" 2>/dev/null) == *busy ]]; do sleep 0.1; done
show stepwright retarget 180deg "${motor[@]}" --port "$port"
show stepwright watch --port "$port"
wait "$first" || fail "the first terminal does not learn of the other target"
# 90° + 180°, and not 720°.
[[ $(stepwright position --port "$port") == "position 2400 ready" ]] || fail "not retargeted"

echo
echo "## The plug is pulled on the way"
notes=$scratch/notes
stepwright move 20000 --port "$port" >"$notes" 2>&1 &
first=$!
until [[ $(stepwright position --port "$port" 2>/dev/null) == *busy ]]; do sleep 0.1; done
sleep 1
echo power >&3
wait "$first" && fail "a travel that was cut short counts as done"
tail -n 2 "$notes"
# It counts from where it was switched on again, and its settings are still there.
[[ $(stepwright position --port "$port") == "position 0 ready" ]] || fail "not as at power-up"
show stepwright home --port "$port" --speed 800 --slow 50 --back-off 40 --within 20000
[[ $(stepwright position --port "$port") == "position 40 ready" ]] || fail "not home again"
echo
echo "all as it should be"
