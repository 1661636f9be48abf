#!/bin/sh
# The field bench beside PySINDy, from nothing: a virtual environment with PySINDy from PyPI, and then `cargo bench`.
# Arguments are those of the bench, for example
#   crates/sindy/benches/field/run.sh --only "AR 0.5" --seeds 100..103
# Partial differential equations and implicit equations have programs of their own, in ../pde and ../implicit. Their rows follow
# where all problems are asked for, or one of
#   crates/sindy/benches/field/run.sh --only PDE
#   crates/sindy/benches/field/run.sh --only implicit
set -eu
export PYTHONDONTWRITEBYTECODE=1
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../../../.." && pwd)
target=${CARGO_TARGET_DIR:-$root/target}
work=$target/field
mkdir -p "$work"

# A virtual environment FOLDER with the packages of the files that follow.
environment() {
    folder=$1
    shift
    cat "$@" > "$folder.txt"
    if ! cmp -s "$folder.txt" "$folder/requirements.txt"; then
        rm -rf "$folder"
        python3 -m venv "$folder"
        "$folder/bin/pip" install --quiet --disable-pip-version-check --requirement "$folder.txt"
        cp "$folder.txt" "$folder/requirements.txt"
    fi
}

only= pde= implicit= before=
for argument in "$@"; do
    if [ "$before" = --only ]; then
        only=yes
        case $argument in
            PDE) pde=yes ;;
            implicit) implicit=yes ;;
        esac
    fi
    before=$argument
done
if [ -z "$only" ]; then pde=yes implicit=yes; fi

environment "$work/venv" "$here/../pysindy/requirements.txt"
cargo bench --manifest-path "$root/Cargo.toml" --package sindy --bench field -- --python "$work/venv/bin/python" "$@"
if [ -n "$pde$implicit" ]; then
    cargo build --manifest-path "$root/Cargo.toml" --release --package sindy-cli
fi
if [ -n "$pde" ]; then
    echo
    "$work/venv/bin/python" "$here/../pde/compare.py" "$target/release/sindy"
fi
if [ -n "$implicit" ]; then
    environment "$work/implicit-venv" "$here/../pysindy/requirements.txt" "$here/../implicit/requirements.txt"
    echo
    "$work/implicit-venv/bin/python" "$here/../implicit/compare.py" "$target/release/sindy"
fi
