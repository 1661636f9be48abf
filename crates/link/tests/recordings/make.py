"""Cuts recordings of real autopilots for the tests. Needs pymavlink and mcap.

    touchdown simulator px4 deck.toml --with fly.toml --autopilot PX4 --speed 5 --out out
    make.py flight out/flight-0.mcap px4-1.17       a conversation with the companion, until shortly before the touch
    make.py mavlink out/flight-0.mcap px4-1.17      messages of the autopilot, and what pymavlink reads
    make.py simulator STREAM px4-1.17               what PX4 sent to the simulator, and what pymavlink reads

What pymavlink reads stands beside the cut bytes, so that the tests need no Python. Where the companion sends other bytes on
purpose, `TOUCHDOWN_RECORD=1 cargo test -p touchdown-link --test recordings` puts them into the conversations: no autopilot
is needed for that.
"""

import csv
import json
import os
import struct
import sys

os.environ["MAVLINK20"] = "1"
from mcap.reader import make_reader  # noqa: E402
from mcap.writer import CompressionType, Writer  # noqa: E402
from pymavlink.dialects.v20 import common as mav  # noqa: E402

# Range at which a conversation is cut, m: the vehicle stands at about 0.1 m, and how it judges the touch is not part of it.
BELOW_M = 0.3


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


def simulator(stream, name):
    data = open(stream, "rb").read()
    kept = cut(data, 8000, int(len(data) * 0.78), 40000)
    open(f"{name}-simulator.bin", "wb").write(kept)
    with open(f"{name}-simulator.csv", "w", newline="") as f:
        out = csv.writer(f, lineterminator="\n")
        out.writerow(["time_usec", "motor_1", "motor_2", "motor_3", "motor_4"])
        for m in messages(kept):
            if m.get_type() == "HIL_ACTUATOR_CONTROLS":
                out.writerow([m.time_usec] + [bits(c) for c in m.controls[:4]])


def mavlink(flight, name):
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


def flight(flight, name):
    """What came and went, without what it says, until the vehicle is below `BELOW_M`."""
    with open(flight, "rb") as f, open(f"{name}-flight.mcap", "wb") as g:
        reader = make_reader(f)
        writer = Writer(g, compression=CompressionType.NONE, use_chunking=False)
        writer.start()
        for record in reader.iter_metadata():
            writer.add_metadata(record.name, record.metadata)
        channels = {}
        topics = ["/received", "/tick", "/stop", "/sent", "/mavlink/distance"]
        for _, channel, m in reader.iter_messages(topics=topics, log_time_order=False):
            if channel.topic == "/mavlink/distance":
                if json.loads(m.data)["distance_m"] < BELOW_M:
                    break
                continue
            if channel.topic not in channels:
                channels[channel.topic] = writer.register_channel(channel.topic, "mavlink", 0)
            writer.add_message(channels[channel.topic], m.log_time, m.data, m.publish_time, m.sequence)
        writer.finish()


{"simulator": simulator, "mavlink": mavlink, "flight": flight}[sys.argv[1]](*sys.argv[2:])
