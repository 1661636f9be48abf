"""Hours of landings one after another, by `touchdown campaign` over a real PX4 or ArduCopter: does memory grow, does V_L drift?

    landings.py px4|ardupilot AUTOPILOT TOUCHDOWN FOLDER [HOURS]

HOURS (8) are of simulated time, by the landings' own clocks; two instances fly side by side, as fast as the machine can. A
line of JSON a minute has the campaign's memory and how many landings there are. The last line compares the first half of the
landings with the second. Needs pyarrow.
"""

import glob
import json
import os
import signal
import statistics
import subprocess
import sys
import time

import pyarrow.parquet as parquet

SWEEP = """seed = 1
trials = {trials}
block = 8
autopilot = "{kind}"
[software_in_the_loop]
program = "{program}"
speed = 0.0
companion = "fly.toml"
[scenario.deck]
kind = "sines"
[[scenario.deck.tones]]
axis = "heave"
amplitude = 0.05
frequency_hz = 0.5
"""
LONGEST_S = 20.0  # least simulated time of a landing with its take-off: more trials than the hours need


def landings(folder):
    rows = []
    for file in sorted(glob.glob(f"{folder}/**/*.parquet", recursive=True)):
        try:
            rows += parquet.read_table(file).to_pylist()
        except OSError:
            pass  # Being written.
    return sorted((row for row in rows if "v_l_mps" in row), key=lambda row: row["trial"])


def half(rows):
    speeds = [row["v_l_mps"] for row in rows if row["outcome"] == "landed"]
    outcomes = [row["outcome"] for row in rows]
    return {
        "landings": len(rows), "outcomes": {o: outcomes.count(o) for o in sorted(set(outcomes))},
        "v_l_mean_mps": round(statistics.mean(speeds), 4), "v_l_sd_mps": round(statistics.stdev(speeds), 4),
        "v_l_greatest_mps": round(max(speeds), 3),
        "standard_error_mps": round(statistics.stdev(speeds) / len(speeds) ** 0.5, 4),
    }


def hours(rows):
    return sum(row["steps"] for row in rows) / 3.6e6


def memory_kib(process):
    with open(f"/proc/{process.pid}/status") as status:
        return next((int(line.split()[1]) for line in status if line.startswith("VmRSS")), 0)


def main():
    kind, program, touchdown, folder, *asked = sys.argv[1:]
    program, touchdown, folder = map(os.path.abspath, (program, touchdown, folder))
    asked = float(asked[0]) if asked else 8.0
    os.makedirs(folder, exist_ok=True)
    with open(f"{folder}/sweep.toml", "w") as f:
        f.write(SWEEP.format(trials=int(asked * 3600 / LONGEST_S), kind=kind, program=program))
    with open(f"{folder}/fly.toml", "w") as f:
        f.write(subprocess.run([touchdown, "settings", "fly"], capture_output=True, text=True, check=True).stdout)
    with open(f"{folder}/campaign.log", "w") as log:
        campaign = subprocess.Popen(
            [touchdown, "--quiet", "campaign", f"{folder}/sweep.toml", "--threads", "2", "--out", f"{folder}/out"],
            stdout=log, stderr=log, start_new_session=True,
            # Ctrl-C ends it even where this script was started with it ignored.
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
        )
    try:
        begin, flown = time.monotonic(), 0.0
        while campaign.poll() is None and flown < asked:
            time.sleep(60.0)
            rows = landings(f"{folder}/out")
            flown = hours(rows)
            if campaign.poll() is None:
                minute = round((time.monotonic() - begin) / 60)
                print(json.dumps({"minute": minute, "memory_kib": memory_kib(campaign), "landings": len(rows),
                                  "hours": round(flown, 2), "load": round(os.getloadavg()[0], 1)}), flush=True)
    finally:
        if campaign.poll() is None:
            campaign.send_signal(signal.SIGINT)
            campaign.wait()
    rows = landings(f"{folder}/out")
    middle = len(rows) // 2
    print(json.dumps({"hours": round(hours(rows), 2), "first": half(rows[:middle]), "second": half(rows[middle:])}))


main()
