#!/bin/sh
# The accuracy table, from nothing: a virtual environment with PySINDy from PyPI, the command `sindy` built in
# release mode, the data, both programs on the same arrays. Arguments go to accuracy.py, for example
#   benches/accuracy/run.sh --only lorenz,dysts --jobs 2
set -eu
export PYTHONDONTWRITEBYTECODE=1
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../../../.." && pwd)
target=${CARGO_TARGET_DIR:-$root/target}
work=$target/accuracy
mkdir -p "$work"
if ! cmp -s "$here/requirements.txt" "$work/venv/requirements.txt"; then
    rm -rf "$work/venv"
    python3 -m venv "$work/venv"
    "$work/venv/bin/pip" install --quiet --requirement "$here/requirements.txt"
    cp "$here/requirements.txt" "$work/venv/requirements.txt"
fi
cargo build --quiet --release --manifest-path "$root/Cargo.toml" -p sindy-cli --target-dir "$target"
exec "$work/venv/bin/python" "$here/accuracy.py" --sindy "$target/release/sindy" --work "$work" "$@"
