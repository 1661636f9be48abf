"""A flight over a still deck from which thrust and ground effect can be identified, by a real PX4 or ArduCopter.

    sweep.py px4|ardupilot AUTOPILOT TOUCHDOWN FOLDER

The autopilot follows velocities, by which this program holds and sweeps the height: hovers, quick sines, slow ramps, and a
landing. `touchdown fly` only records. The folder has flight.mcap, the autopilot's own log, and world/truth-0.parquet.
"""

import glob
import math
import os
import shutil
import sys
import time

from rig import STILL, Rig, mav

# Heights above the standing height, m; times, s.
HOVERS = [(0.9, 4.0), (0.45, 4.0), (0.25, 5.0), (0.15, 5.0), (0.09, 5.0)]
SINES = [(0.19, 0.10, 0.4, 15.0), (0.17, 0.07, 0.8, 12.0), (0.16, 0.05, 1.2, 10.0)]
RAMPS = [(0.08, 0.5, 0.15), (0.08, 0.5, 0.3)]
LOGS = {
    # From the arming on, with all sensors and motors at full rate.
    "px4": {"SDLOG_BACKEND": 1, "SDLOG_MODE": 0, "SDLOG_PROFILE": 1 + 16},
    "ardupilot": {"LOG_BACKEND_TYPE": 1, "LOG_BITMASK": 65535 + (1 << 17) + (1 << 18), "LOG_FILE_RATEMAX": 0},
}


def profile():
    """Heights at every hundredth of a second."""
    heights = []
    for height, seconds in HOVERS:
        heights += [height] * int(seconds * 100)
    for middle, amplitude, hz, seconds in SINES:
        heights += [middle + amplitude * math.sin(2 * math.pi * hz * k / 100) for k in range(int(seconds * 100))]
    for low, high, speed in RAMPS:
        steps = int((high - low) / speed * 100)
        for _ in range(3):
            heights += [low + (high - low) * k / steps for k in range(steps)]
            heights += [high - (high - low) * k / steps for k in range(steps)]
    return heights + [0.9] * 200


def velocity(rig, up_mps):
    north, east = rig.place()
    limit = lambda v: max(-0.6, min(0.6, v))
    rig.send(mav.MAVLink_set_position_target_local_ned_message(
        0, rig.system, 1, mav.MAV_FRAME_LOCAL_NED, 0b110111000111, 0, 0, 0, limit(-north), limit(-east), -up_mps, 0, 0, 0, 0, 0))


def main():
    kind, program, touchdown, folder = sys.argv[1:]
    program, touchdown, folder = map(os.path.abspath, (program, touchdown, folder))
    rig = Rig(kind, program, touchdown, folder, STILL, LOGS[kind])
    try:
        rig.take_off()
        # Without a deck in view it never takes control.
        rig.see = lambda: None
        rig.start_companion("flight")
        following = rig.modes["following"]
        rig.until(lambda: False, 6, lambda: velocity(rig, 0.0))
        heights = profile()
        start = [None]

        def follow():
            now = time.monotonic()
            if start[0] is None:
                start[0] = now
            k = min(int((now - start[0]) * 100), len(heights) - 2)
            rate = (heights[min(k + 5, len(heights) - 1)] - heights[max(k - 5, 0)]) / 0.1
            rate = max(-1.0, min(1.0, rate))
            velocity(rig, rate + 1.5 * (heights[k] + rig.rest_m - rig.range_m))
            return False

        # The stream first, then the switch, which PX4 demands.
        rig.until(follow, 1.5)
        rig.until(lambda: follow() or rig.mode == following, 8, lambda: rig.set_mode(following)) or rig.fail("no switch")
        start[0] = None
        rig.until(follow, len(heights) / 100)
        rig.stop_companion()
        rig.set_mode(9 if kind == "ardupilot" else (4 << 16) | (6 << 24))
        rig.until(lambda: rig.world.poll() is not None, 25)
        rig.until(lambda: False, 2)
    finally:
        rig.close()
    logs = glob.glob(f"{folder}/log/**/*.ulg", recursive=True) + glob.glob(f"{folder}/logs/*.BIN")
    for log in sorted(logs)[-1:]:
        shutil.copy(log, f"{folder}/flight{os.path.splitext(log)[1]}")
    print(rig.notes[-4:], logs)


main()
