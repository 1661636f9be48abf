"""Cuts recordings of real autopilots for the tests, and reads them with pymavlink: make.py PX4_SIMULATOR_STREAM FLIGHT.mcap NAME

The first file holds what PX4 sent to the simulator, byte by byte; the second is a recording of `touchdown fly`. Both outputs of
pymavlink stand beside the cut bytes, so that the tests need no Python.
"""

import csv
import os
import struct
import sys

os.environ["MAVLINK20"] = "1"
from mcap.reader import make_reader  # noqa: E402
from pymavlink.dialects.v20 import common as mav  # noqa: E402


def messages(data):
    parser = mav.MAVLink(None)
    parser.robust_parsing = True
    for k in range(len(data)):
        try:
            message = parser.parse_char(data[k : k + 1])
        except mav.MAVError:
            continue
        if message is not None and message.get_type() not in ("BAD_DATA",) and not message.get_type().startswith("UNKNOWN"):
            yield message


def cut(data, head, start, length):
    """Whole frames: those of the first `head` bytes, and of `length` bytes from `start` on."""
    at, out = 0, b""
    while at + 12 <= len(data):
        assert data[at] == 0xFD
        whole = 12 + data[at + 1] + (13 if data[at + 2] & 1 else 0)
        if at < head or start <= at < start + length:
            out += data[at : at + whole]
        at += whole
    return out


def bits(x):
    return struct.unpack("<I", struct.pack("<f", x))[0]


def main():
    stream, flight, name = sys.argv[1:]
    data = open(stream, "rb").read()
    kept = cut(data, 8000, int(len(data) * 0.78), 40000)
    open(f"{name}-simulator.bin", "wb").write(kept)
    with open(f"{name}-simulator.csv", "w", newline="") as f:
        out = csv.writer(f, lineterminator="\n")
        out.writerow(["time_usec", "motor_1", "motor_2", "motor_3", "motor_4"])
        for m in messages(kept):
            if m.get_type() == "HIL_ACTUATOR_CONTROLS":
                out.writerow([m.time_usec] + [bits(c) for c in m.controls[:4]])
    with open(flight, "rb") as f:
        received = b"".join(m.data for _, c, m in make_reader(f).iter_messages(topics=["/received"]))
    kept = cut(received, 30000, len(received) // 2, 50000)
    open(f"{name}-mavlink.bin", "wb").write(kept)
    with open(f"{name}-mavlink.csv", "w", newline="") as f:
        out = csv.writer(f, lineterminator="\n")
        out.writerow(["message", "system", "component", "attitude_w", "attitude_x", "attitude_y", "attitude_z"])
        for m in messages(kept):
            q = [bits(c) for c in (m.q1, m.q2, m.q3, m.q4)] if m.get_type() == "ATTITUDE_QUATERNION" else [""] * 4
            out.writerow([m.get_msgId(), m.get_srcSystem(), m.get_srcComponent()] + q)


main()
