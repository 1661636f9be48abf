#!/bin/sh
# The field bench beside PySINDy, from nothing: a virtual environment with PySINDy from PyPI, and then `cargo bench`.
# Arguments are those of the bench, for example
#   crates/sindy/benches/field/run.sh --only "AR 0.5" --seeds 100..103
set -eu
export PYTHONDONTWRITEBYTECODE=1
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../../../.." && pwd)
requirements=$here/../pysindy/requirements.txt
work=${CARGO_TARGET_DIR:-$root/target}/field
mkdir -p "$work"
if ! cmp -s "$requirements" "$work/venv/requirements.txt"; then
    rm -rf "$work/venv"
    python3 -m venv "$work/venv"
    "$work/venv/bin/pip" install --quiet --disable-pip-version-check --requirement "$requirements"
    cp "$requirements" "$work/venv/requirements.txt"
fi
exec cargo bench --manifest-path "$root/Cargo.toml" --package sindy --bench field -- \
    --python "$work/venv/bin/python" "$@"
