#!/usr/bin/env bash
# The bench against PySINDy: makes a virtual environment, installs PySINDy from PyPI, makes the data, builds our side, runs
# both in one go and prints the table. Options are those of run.py (`--only CASE,...`, `--runs N`).
#
#   bash crates/sindy/benches/pysindy/run.sh
#
# BENCH_DIR is where environment and data go (500 MB; default: pysindy-bench in Cargo's target directory).
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
cd "$here"
target=$(cargo metadata --format-version 1 --no-deps | python3 -c 'import json, sys; print(json.load(sys.stdin)["target_directory"])')
dir=${BENCH_DIR:-$target/pysindy-bench}
mkdir -p "$dir"

if ! cmp -s requirements.txt "$dir/installed.txt"; then
  python3 -m venv "$dir/venv"
  "$dir/venv/bin/pip" install --quiet --disable-pip-version-check --requirement requirements.txt
  cp requirements.txt "$dir/installed.txt"
fi
export OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1 RAYON_NUM_THREADS=1
"$dir/venv/bin/python" data.py "$dir/data"
ours=$(cargo bench --package sindy --bench pysindy --no-run --message-format json |
  python3 -c 'import json, sys
for line in sys.stdin:
    message = json.loads(line)
    if message.get("executable") and message["target"]["name"] == "pysindy":
        print(message["executable"])')
exec "$dir/venv/bin/python" run.py --ours "$ours" --data "$dir/data" "$@"
