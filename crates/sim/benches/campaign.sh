#!/bin/sh
# Cold start, memory and a campaign of 10 000 landings in six degrees of freedom:
#
#   crates/sim/benches/campaign.sh [LANDINGS]
#
# Prints the least time of 20 starts from nothing to the end of the first landing, the peak memory of
# that process, and time, processor time and memory of a campaign (the paper's deck, sensors in fast
# mode, results on disk as Parquet, figures and report) on all cores. On a busy machine the processor
# time is the figure. Needs GNU time.
set -eu
landings=${1:-10000}
root=$(cd "$(dirname "$0")/../../.." && pwd)
target=${CARGO_TARGET_DIR:-$root/target}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

cd "$root"
cargo build --release --quiet -p touchdown-sim --example space_campaign
[ -n "${TOUCHDOWN:-}" ] || cargo build --release --quiet -p touchdown
touchdown=${TOUCHDOWN:-$target/release/touchdown}

for _ in 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20; do
    before=$(date +%s%N)
    /usr/bin/time -a -o "$work/first" -f '%U %S %M' \
        "$target/release/examples/space_campaign" paper 1 >/dev/null
    echo "$(($(date +%s%N) - before))" >>"$work/wall"
done
paste -d ' ' "$work/wall" "$work/first" | awk '
    NR == 1 || $1 < wall { wall = $1 }
    NR == 1 || $2 + $3 < cpu { cpu = $2 + $3 }
    $4 > memory { memory = $4 }
    END {
        printf "first landing: %.0f ms from start to end (processor time %.0f ms)", wall / 1e6, 1e3 * cpu
        printf ", peak memory %.1f MB\n", memory / 1024
    }'

cat >"$work/sweep.toml" <<END
trials = $landings

[[scenario.deck.tones]]
axis = "heave"
amplitude = 0.05
frequency_hz = 0.5

[scenario.deck]
kind = "sines"
END
/usr/bin/time -o "$work/all" -f '%e %U %S %M' \
    "$touchdown" --quiet campaign "$work/sweep.toml" --out "$work/out" >/dev/null
awk -v n="$landings" '{
    printf "%d landings, results on disk: %.1f s (processor time %.1f s)", n, $1, $2 + $3
    printf ", peak memory %.1f MB\n", $4 / 1024
}' "$work/all"
