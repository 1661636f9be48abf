"""A long flight of one companion beside a real PX4 or ArduCopter, in real time.

    soak.py px4|ardupilot AUTOPILOT TOUCHDOWN FOLDER [MINUTES]

The companion is in control all the time: it holds above the heaving deck, because no window of the deck's motion is calm
enough for its settings. After MINUTES (60) its wait ends: it lands and disarms. A line of JSON a minute has the memory of
its process, the latency that it estimates, the jitter of its period so far, and its height above the deck; the last line
is its summary. Needs pymavlink.
"""

import json
import os
import sys
import time

from rig import FLY, Rig

# Pauses of a busy machine are no faults here: the flight shall go on for its whole time.
LIMITS = """[limits]
silent_s = 1.0
stale_s = 1.0
failsafe_s = 1.0
"""
WAIT = """
[control.lander]
patience_s = {patience_s}
[control.planning]
wait_s = {wait_s}
[control.planning.quiescence]
speed_mps = 0.001
"""
MORE = {"px4": {"COM_OF_LOSS_T": 1.0}, "ardupilot": {"GUID_TIMEOUT": 1.0}}


def memory_kib(process):
    """Resident memory."""
    with open(f"/proc/{process.pid}/status") as status:
        return next(int(line.split()[1]) for line in status if line.startswith("VmRSS"))


def minute(rig, number, heights):
    state = rig.lines[-1]
    jitter = state.get("jitter") or {}
    return {
        "minute": number, "stage": state["stage"], "phase": state["phase"], "memory_kib": memory_kib(rig.companion),
        "latency_s": state["latency_s"], "setpoints": state["setpoints"], "jitter_p999_ms": jitter.get("p999_ms"),
        "jitter_p99_ms": jitter.get("p99_ms"), "greatest_ms": jitter.get("greatest_ms"),
        "lowest_m": round(min(heights), 2), "highest_m": round(max(heights), 2),
        "load": os.getloadavg()[0],
        "recording_mib": round(os.path.getsize(f"{rig.folder}/soak.mcap") / 2**20, 1),
    }


def main():
    kind, program, touchdown, folder, *minutes = sys.argv[1:]
    program, touchdown, folder = map(os.path.abspath, (program, touchdown, folder))
    minutes = float(minutes[0]) if minutes else 60.0
    wait = WAIT.format(wait_s=60.0 * minutes, patience_s=60.0 * minutes + 120.0)
    rig = Rig(kind, program, touchdown, folder, more=MORE[kind], fly=FLY.replace("[limits]\n", LIMITS) + wait)
    try:
        rig.take_off()
        rig.start_companion("soak")
        rig.until(lambda: rig.stage() == "ready", 60) or rig.fail(f"not ready: {rig.lines[-1:]}")
        following = rig.modes["following"]
        rig.until(lambda: rig.mode == following, 8, lambda: rig.set_mode(following)) or rig.fail("no switch")
        begin, number, heights = time.monotonic(), 0, []
        while rig.companion.poll() is None and time.monotonic() - begin < 60.0 * minutes + 150.0:
            rig.step()
            heights.append(rig.range_m - rig.rest_m)
            del rig.lines[:-1]
            if time.monotonic() - begin >= 60.0 * number and rig.lines:
                print(json.dumps(minute(rig, number, heights)), flush=True)
                number, heights = number + 1, []
        rig.until(lambda: False, 1.0)
        print(json.dumps({"state": rig.lines[-1:], "says": rig.notes[-4:]}), flush=True)
        rig.stop_companion()
    finally:
        rig.close()


main()
