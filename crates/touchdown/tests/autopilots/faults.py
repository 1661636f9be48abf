"""Faults of the link and the companion over a real PX4 or ArduCopter, above a heaving deck, in real time.

    faults.py px4|ardupilot AUTOPILOT TOUCHDOWN FOLDER [NAME=VALUE ...] [CASE ...]

AUTOPILOT is build/px4_sitl_default/bin/px4 or build/sitl/bin/arducopter, TOUCHDOWN the command. Four processes run: the
world (`touchdown simulator`), the autopilot, the companion (`touchdown fly`), and this one. It plays the pilot at a ground
station and the camera, and passes the companion's datagrams on, or drops them. Needs pymavlink. A case is
cut:SECONDS:PHASE, kill:PHASE, pilot:PHASE, reboot (of the autopilot, on the ground) or none; without one all are flown.
NAME=VALUE sets a parameter of the autopilot. A line of JSON is printed for each case.
"""

import json
import os
import sys
import time

from rig import Rig

PHASES = ("hold", "wait", "descend", "touchdown")
CASES = (
    ["none", "reboot"]
    + [f"cut:{s}:{p}" for p in PHASES for s in (0.3, 1, 3)]
    + [f"{what}:{p}" for what in ("kill", "pilot") for p in PHASES]
)
WATCH_S = 10.0


def fly(rig, case):
    what, *rest = case.split(":")
    rig.start_companion(case.replace(":", "-"))
    try:
        return flown(rig, case, what, rest, rest[-1] if rest else None)
    finally:
        rig.stop_companion()


def rebooted(kind, program, touchdown, folder, more):
    """The autopilot restarts below a companion that waits; then both land as if nothing had been."""
    rig = Rig(kind, program, touchdown, folder, more=more)
    try:
        rig.stands()
        rig.start_companion("reboot")
        rig.until(lambda: rig.stage() == "checked", 90) or rig.fail(f"not checked: {rig.lines[-1:]}")
        begin, seen = time.monotonic(), len(rig.lines)
        rig.restart()
        rig.until(lambda: "checking" in [line.get("stage") for line in rig.lines[seen:]], 60)
        again = rig.until(lambda: rig.stage() == "checked", 90)
        checked_s, setpoints = time.monotonic() - begin, rig.setpoints
        rig.take_off()
        rig.until(lambda: rig.stage() == "ready", 60) or rig.fail(f"not ready: {rig.lines[-1:]}")
        following = rig.modes["following"]
        rig.until(lambda: rig.mode == following, 8, lambda: rig.set_mode(following)) or rig.fail("no switch")
        rig.taken = True
        landed = rig.until(lambda: not rig.armed, 90)
        rig.until(lambda: False, 1.0)
        stages = [line.get("stage") for line in rig.lines]
        changes = [b for a, b in zip([None] + stages, stages) if a != b]
        return {"case": "reboot", "checked_again": again, "checked_after_s": round(checked_s, 1),
                "setpoints_until_then": setpoints, "stages": changes, "disarmed": landed, "says": rig.notes[-3:]}
    finally:
        if rig.companion:
            rig.stop_companion()
        rig.close()


def flown(rig, case, what, rest, phase):
    rig.until(lambda: rig.stage() == "ready", 30) or rig.fail(f"not ready: {rig.lines[-1:]}")
    following = rig.modes["following"]
    rig.until(lambda: rig.mode == following, 8, lambda: rig.set_mode(following)) or rig.fail("no switch")
    rig.taken = True
    reached = {
        "hold": lambda: rig.lines[-1].get("phase") == "hold",
        "wait": lambda: rig.lines[-1].get("phase") == "wait",
        "descend": lambda: rig.range_m < 0.45,
        "touchdown": lambda: rig.range_m <= rig.rest_m + 0.02,
        None: lambda: True,
    }[phase]
    if not rig.until(lambda: reached() or rig.mode != following, 100) or rig.mode != following:
        return {"case": case, "failed": "phase not reached", "state": rig.lines[-1:], "mode": rig.name(rig.mode)}
    begin = time.monotonic()
    rig.history = [(begin, rig.mode, rig.armed)]
    at_m, setpoints = rig.range_m, rig.setpoints
    lows, heights = [rig.range_m], []
    restored = None
    if what == "kill":
        rig.companion.kill()
    elif what == "pilot":
        rig.set_mode(rig.modes["hold"])
    elif what == "cut":
        rig.cut, restored = True, begin + float(rest[0])
    watch = 25.0 if what == "none" else WATCH_S
    ended = None
    while time.monotonic() - begin < watch and ended is None:
        rig.step()
        lows.append(rig.range_m)
        if time.monotonic() - begin >= len(heights):
            # Above the deck; above the sea, by the truth and by the autopilot's estimate.
            heights.append([round(h, 2) for h in (rig.range_m - rig.rest_m, rig.up_m, rig.estimated_up_m)])
        if restored and time.monotonic() > restored:
            rig.cut, restored = False, None
        if not rig.armed or rig.world.poll() is not None:
            ended = "disarmed" if not rig.armed else "world ended"
    rig.until(lambda: False, 0.5)
    last = rig.lines[-1] if rig.lines else {}
    ending = last.get("ending") or last.get("flight", {}).get("ending")
    return {
        "case": case, "ending": ending, "height_m": round(at_m - rig.rest_m, 2),
        "lowest_m": round(min(lows) - rig.rest_m, 2), "highest_m": round(max(lows) - rig.rest_m, 2),
        "now_m": round(rig.range_m - rig.rest_m, 2),
        "heights": heights,
        "modes": [(round(t - begin, 2), rig.name(m) + ("" if a else " disarmed")) for t, m, a in rig.history],
        "setpoints_until_s": round(rig.last_setpoint - begin, 2) if rig.setpoints > setpoints else 0.0,
        "setpoints_after_take_over": rig.after_take_over, "over": ended, "says": rig.notes[-3:],
    }


def main():
    kind, program, touchdown, folder, *cases = sys.argv[1:]
    more = dict(case.split("=") for case in cases if "=" in case)
    cases = [case for case in cases if "=" not in case]
    program, touchdown, folder = map(os.path.abspath, (program, touchdown, folder))
    rig, number = None, 0
    try:
        for case in cases or CASES:
            for _ in range(2):
                try:
                    if rig is None or case == "reboot":
                        number += 1
                    if case == "reboot":
                        if rig:
                            rig.close()
                            rig = None
                        print(json.dumps(rebooted(kind, program, touchdown, f"{folder}/{number}", more)), flush=True)
                        break
                    if rig is None:
                        rig = Rig(kind, program, touchdown, f"{folder}/{number}", more=more)
                        rig.take_off()
                    result = fly(rig, case)
                except RuntimeError as error:
                    result = {"case": case, "failed": str(error)}
                print(json.dumps(result), flush=True)
                if result.get("failed") or not rig.climb_back():
                    rig.close()
                    rig = None
                if not result.get("failed"):
                    break
    finally:
        if rig:
            rig.close()


main()
