#!/usr/bin/env bash
# What the system does to a program: limits, signals, closed descriptors, folders that cannot be written, another
# locale. Nothing is lost, nothing half-written, no file of a stranger touched, and the message blames what failed.
#
#   faults.sh BIN            the rows of the table, tab-separated as `hard cases` prints them; failures on standard error
#
# CI size: 2 steps of each limit, 2 kills of each kind, all descriptors and surroundings at once; SIZE=full: 20 steps, 30
# kills, each alone. SEED=n: moments of the kills.
set -uo pipefail
bin=$(cd "$1" && pwd)
top=$(cd "$(dirname "$0")/../.." && pwd)
seed=${SEED:-1}
closings=('<&- >&- 2>&-') surroundings=('TMPDIR=/nowhere HOME=/nowhere TZ=Asia/Tokyo')
if [ "${SIZE:-}" = full ]; then
    steps=20 kills=30
    closings+=('<&-' '>&-' '2>&-')
    surroundings+=('TMPDIR=/nowhere' 'TMPDIR=' 'HOME=/nowhere' 'LC_ALL=xx_XX.UTF-8' 'TZ=Asia/Tokyo')
else
    steps=2 kills=2
fi
work=$(mktemp -d)
trap 'chmod -R u+w "$work"; rm -rf "$work"' EXIT
cd "$work"
RANDOM=$seed
unset MAKELEVEL MAKEFLAGS MFLAGS

# Inputs, and what each program makes of them: name, output, command.
"$bin/fractalgen" -q --size 16 -o d.vdb
"$bin/p1solve" -q d.vdb --sun 0,1,0 -o l.vdb
"$bin/render" -q l.vdb --resolution 16 --integrator path --spp 1 -o part.exr
"$bin/render" -q l.vdb --resolution 16 --integrator path --spp 1 --spp-offset 1 -o part2.exr
printf '1 2 3\n4 5 6\n' > table.txt
programs=(fractalgen cloudsim illuminate p1solve render exrmerge)
declare -A output=([fractalgen]=o.vdb [cloudsim]=o.vdb [illuminate]=o.vdb [p1solve]=o.vdb [render]=o.exr [exrmerge]=o.exr)
declare -A words=(
    [fractalgen]='--size 24 --seed 3' [cloudsim]='--cells 8 --minutes 1' [illuminate]='../d.vdb --sun 0,1,0'
    [p1solve]='../d.vdb --sun 0,1,0' [render]='../l.vdb --resolution 32' [exrmerge]='../part.exr ../part2.exr')

declare -A tried failed where
order=()
# note ROW GOOD TEXT: one more case of a row, which fails if GOOD is 0.
note() {
    [ -n "${tried[$1]:-}" ] || { order+=("$1"); tried[$1]=0 failed[$1]=0 where[$1]=; }
    tried[$1]=$((tried[$1] + 1))
    [ "$2" = 1 ] || { failed[$1]=$((failed[$1] + 1)); where[$1]=$3; echo "faults.sh: $1: $3" >&2; }
}

# In a folder of its own that holds the old output and a stranger's file. Sets status; said and the folder stay.
fresh() {
    rm -rf run; mkdir run; cd run
    echo old > "${output[$1]}"
    echo stranger > .o.stranger
}
command_of() { printf '%s' "'$bin/$1' -q ${words[$1]} -o ${output[$1]}"; }
# attempt COMMAND: sets status, and said to its standard error, which is a pipe: limits of files do not meet it.
attempt() {
    (eval "$1") 2>&1 > /dev/null | cat > ../said
    status=${PIPESTATUS[0]}
}

# judge ROW PROGRAM TEXT [LEFT]: the status is 0 to 3 or the signal's; the output is new and whole or old; the sentence
# is one, begins with the program and matches TEXT if the program failed. LEFT=1: a temporary file may stay.
judge() {
    local row=$1 program=$2 text=$3 good=1 why=
    local out=${output[$program]}
    if [ "$status" -eq 0 ]; then
        cmp -s "$out" "../whole/$program" || { good=0 why="status 0, another result"; }
    elif [ "$(cat "$out" 2> /dev/null)" != old ]; then
        cmp -s "$out" "../whole/$program" || { good=0 why="status $status, and the old file is lost"; }
    fi
    if [ "$status" -gt 3 ] && [ "$status" -ne 130 ] && [ "$status" -ne 143 ] && [ "$status" -ne 137 ]; then good=0 why="status $status"; fi
    if [ "$status" -ge 1 ] && [ "$status" -le 3 ]; then
        [ "$(wc -l < ../said)" -eq 1 ] || { good=0 why="status $status: $(wc -l < ../said) lines: $(head -c 200 ../said)"; }
        grep -q "^$program: " ../said && grep -qE "$text" ../said || { good=0 why="status $status: $(head -c 200 ../said)"; }
    fi
    [ "$(cat .o.stranger)" = stranger ] || { good=0 why="a file of a stranger changed"; }
    local others
    others=$(ls -A | grep -vxF -e "$out" -e .o.stranger || true)
    [ -z "$others" ] || [ "${4:-0}" = 1 ] || { good=0 why="status $status, left: $others"; }
    note "$row" $good "$program: $why"
    cd ..
}

mkdir whole
for program in "${programs[@]}"; do
    fresh $program
    eval "$(command_of $program)" 2> ../said || { echo "faults.sh: $program: $(cat ../said)" >&2; exit 1; }
    cp "${output[$program]}" "../whole/$program"
    cd ..
done

# A file may not grow beyond a limit, as on a disk that fills up: at steps of the output's size.
for program in "${programs[@]}"; do
    blocks=$((($(stat -c %s "whole/$program") + 1023) / 1024))
    for step in $(seq 0 $((steps - 1))); do
        fresh $program
        attempt "ulimit -f $((blocks * step / steps)); exec $(command_of $program)"
        judge "file size limit" $program 'cannot write|File too large|No space'
    done
done

# Address space: at steps between what a program needs to start and what it needs to end. Sanitizers take terabytes of it.
address_steps=$steps
[ -z "${ASAN_OPTIONS:-}${UBSAN_OPTIONS:-}${TSAN_OPTIONS:-}" ] || address_steps=0
for program in "${programs[@]}"; do
    for step in $(seq 1 $address_steps); do
        fresh $program
        kib=$((120000 + 500000 * step / steps))
        attempt "ulimit -v $kib; exec $(command_of $program)"
        # The system's loader needs memory, too, before there is a program.
        if [ $status = 127 ]; then cd ..; continue; fi
        judge "memory limit" $program 'memory'
    done
done

# Nobody may write into a folder that is not theirs.
if [ "$(id -u)" = 0 ] && command -v setpriv > /dev/null; then
    chmod a+rx "$work"; chmod a+r ./*.vdb ./*.exr
    for program in "${programs[@]}"; do
        fresh $program
        chmod 755 .
        attempt "setpriv --reuid=65534 --regid=65534 --clear-groups $(command_of $program)"
        [ $status -ne 0 ] || status=99
        judge "folder of another user" $program 'Permission denied'
    done
fi

# Signals at random moments.
for signal in INT TERM KILL; do
    for kill in $(seq $kills); do
        program=${programs[$((RANDOM % ${#programs[@]}))]}
        fresh $program
        moment=$(printf '0.%03d' $((RANDOM % 400)))
        attempt "timeout --preserve-status -s $signal $moment $(command_of $program)"
        judge "signal $signal" $program . $([ $signal = KILL ] && echo 1 || echo 0)
    done
done

# Closed descriptors. A result that goes to a closed standard output is no result.
for program in "${programs[@]}"; do
    for closed in "${closings[@]}"; do
        fresh $program
        : > ../said
        eval "($(command_of $program)) 2> ../said $closed"; status=$?
        [ $status -eq 0 ] || status=$((100 + status))
        judge "closed descriptors" $program .
    done
done

# Surroundings that change no result.
if [ -e /usr/share/i18n/locales/de_DE ] && localedef -i de_DE -f UTF-8 "$work/de_DE.UTF-8" > /dev/null 2>&1; then
    surroundings+=("LOCPATH=$work LC_ALL=de_DE.UTF-8")
fi
for program in "${programs[@]}"; do
    for change in "${surroundings[@]}"; do
        fresh $program
        attempt "env $change $(command_of $program)"
        [ $status -eq 0 ] || status=$((100 + status))
        judge "surroundings" $program .
    done
done

# A pipeline killed at a random moment and made again gives the picture of one that was left alone; two at once, too.
cumulus() { make -s -C "$top/pipelines/cumulus" PICTURE=small BIN="$bin" OUT="$work/$1" render_flags='--resolution 24' "$work/$1/cumulus.png"; }
if cumulus alone > /dev/null 2> said; then
    for kill in $(seq $kills); do
        rm -rf killed
        moment=$(printf '0.%03d' $((RANDOM % 900)))
        setsid bash -c "$(declare -f cumulus); top='$top' bin='$bin' work='$work'; cumulus killed" > /dev/null 2>&1 &
        group=$!
        sleep $moment
        kill -KILL -- -$group 2> /dev/null
        wait $group 2> /dev/null
        cumulus killed > /dev/null 2> said
        cmp -s alone/cumulus.png killed/cumulus.png; note "pipeline killed and made again" $(($? == 0)) "after $moment s: $(head -n 1 said)"
    done
    rm -rf both
    cumulus both > /dev/null 2>&1 & first=$!
    cumulus both > /dev/null 2>&1
    wait $first
    cumulus both > /dev/null 2> said
    cmp -s alone/cumulus.png both/cumulus.png; note "two pipelines in one folder" $(($? == 0)) "$(head -n 1 said)"
else
    note "pipeline killed and made again" 0 "the pipeline itself fails: $(head -n 1 said)"
fi

bad=0
for row in "${order[@]}"; do
    printf 'faults: %s\tholds\t%d\t0\t%d\t%d\t\t%s\n' "$row" "${failed[$row]}" "${tried[$row]}" "${failed[$row]}" "${where[$row]//[$'\n\t']/ }"
    bad=$((bad + failed[$row]))
done
[ $bad = 0 ]
