#!/bin/sh
# Speed of touchdown-sim beside the published simulator peng_quad 0.5.6, in one run:
#
#   crates/sim/benches/peng_quad/run.sh
#
# Fetches the crate, takes its dynamics and its controllers (the visualisation needs a thousand
# further crates and is left out), builds both and prints steps per second of processor time.
# Nothing fetched is kept in the repository.
set -eu
cd "$(dirname "$0")"
version=0.5.6
sum=8c5545991a795de926ca196afdd349130139b8c4d498cd1931967cd08b8d5853
mkdir -p fetched
file="fetched/peng_quad-$version.crate"
[ -f "$file" ] || curl -fsSL -o "$file" "https://static.crates.io/crates/peng_quad/peng_quad-$version.crate"
echo "$sum  $file" | sha256sum -c - >/dev/null
tar xzf "$file" -C fetched
{
    echo 'use nalgebra::{Matrix3, Quaternion, Rotation3, UnitQuaternion, Vector3};'
    echo '#[derive(Debug)] pub enum SimulationError { NalgebraError(String) }'
    awk '
        /^pub struct (Quadrotor|PIDController)/ { on = 1 }
        /^pub struct Imu/ || /^pub enum PlannerType/ { on = 0 }
        on && !/^ *\/\/\// && !/^#\[/' "fetched/peng_quad-$version/src/lib.rs"
} >fetched/peng.rs
exec cargo run --release --quiet
