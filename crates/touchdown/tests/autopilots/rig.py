"""The world, a real PX4 or ArduCopter in it, and a pilot at a ground station: what the flights of this folder share.

The world is `touchdown simulator`, in real time. Needs pymavlink.
"""

import json
import math
import os
import select
import signal
import socket
import subprocess
import time

os.environ["MAVLINK20"] = "1"
from pymavlink.dialects.v20 import ardupilotmega as mav  # noqa: E402

DECK = """seed = 1
[scenario.deck]
kind = "sines"
[[scenario.deck.tones]]
axis = "heave"
amplitude = 0.05
frequency_hz = 0.5
"""
STILL = """seed = 1
[scenario.deck]
kind = "still"
"""
# A busy machine delays answers before control; the limits in control are the defaults.
FLY = """link = "udpin:127.0.0.1:{port}"
[sensors]
imu_gap_s = 0.15
[rates]
least_share = 0.3
[limits]
round_trip_s = 0.2
[control]
controller = "observer"
"""
HEIGHT_M = 1.2  # of the hover above the start
PX4 = {
    "following": 6 << 16,
    "hold": (4 << 16) | (3 << 24),
    "take_off": (4 << 16) | (2 << 24),
    "names": {6 << 16: "OFFBOARD", (4 << 16) | (3 << 24): "Hold", 2 << 16: "Altitude", 3 << 16: "Position",
              (4 << 16) | (6 << 24): "Land", (4 << 16) | (2 << 24): "Takeoff", (4 << 16) | (5 << 24): "Return"},
    "truth": 115,
}
ARDUPILOT = {
    "following": 4,
    "hold": 5,
    "take_off": 4,
    "names": {4: "GUIDED", 5: "LOITER", 17: "BRAKE", 2: "ALT_HOLD", 9: "LAND", 0: "STABILIZE"},
    "truth": 108,
}


def free_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


def frames(data):
    """Message id, system, component and payload of the frames of a datagram."""
    at = 0
    while at + 12 <= len(data) and data[at] == 0xFD:
        length = data[at + 1]
        yield int.from_bytes(data[at + 7 : at + 10], "little"), data[at + 5], data[at + 6], data[at + 10 : at + 10 + length]
        at += 12 + length + (13 if data[at + 2] & 1 else 0)


class Udp:
    """A socket that answers to whoever sent last."""

    def __init__(self, port=0, peer=None):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 20)
        self.socket.bind(("127.0.0.1", port))
        self.socket.setblocking(False)
        self.peer = peer
        self.port = self.socket.getsockname()[1]

    def receive(self):
        try:
            data, self.peer = self.socket.recvfrom(65535)
            return data
        except OSError:
            return None

    def send(self, data):
        try:
            if self.peer:
                self.socket.sendto(data, self.peer)
        except OSError:
            pass


class Rig:
    """World, autopilot and pilot; companions come and go."""

    def __init__(self, kind, program, touchdown, folder, deck=DECK, more=None, fly=FLY):
        self.kind, self.touchdown, self.folder, self.fly = kind, touchdown, folder, fly
        self.modes = PX4 if kind == "px4" else ARDUPILOT
        os.makedirs(folder, exist_ok=True)
        self.processes = []
        with open(f"{folder}/deck.toml", "w") as f:
            f.write(deck)
        self.mode = self.armed = self.range_m = self.truth = self.boot_us = self.up_m = self.estimated_up_m = None
        self.origin = self.rest_m = None
        self.companion = None
        self.cut = self.taken = False
        self.sent_heartbeat = self.sent_sticks = self.sent_target = self.asked = 0.0
        self.history, self.lines, self.notes = [], [], []
        self.setpoints = self.after_take_over = 0
        self.last_setpoint = None
        self.told_other = None
        self.instance = int(os.environ.get("PX4_INSTANCE", "0"))
        self.system = 1 + self.instance if kind == "px4" else 1
        parameters, start = self.parameters(program)
        parameters.update(more or {})
        self.link, self.pilot = (Udp(14540 + self.instance), Udp(14550)) if kind == "px4" else (Udp(), Udp())
        self.autopilot_command, self.autopilot_environment = [program] + start, None
        if kind == "px4":
            values = {f"PX4_PARAM_{k}": str(v) for k, v in parameters.items()}
            self.autopilot_environment = dict(os.environ, PX4_SYS_AUTOSTART="10016", **values)
        else:
            with open(f"{folder}/touchdown.parm", "w") as f:
                f.writelines(f"{k} {v}\n" for k, v in parameters.items())
            links = (self.link, self.pilot)
            self.autopilot_command += [f"--serial{k}=udpclient:127.0.0.1:{udp.port}" for k, udp in enumerate(links)]
        self.begin()
        self.mav = mav.MAVLink(None, srcSystem=255, srcComponent=190)
        self.parser = mav.MAVLink(None)
        self.parser.robust_parsing = True
        self.camera = mav.MAVLink(None, srcSystem=self.system, srcComponent=197)
        self.to_companion = Udp()

    def begin(self):
        """Starts the world, and the autopilot in it."""
        self.world = self.start(
            [self.touchdown, "simulator", self.kind, f"{self.folder}/deck.toml", "--speed", "1", "--out",
             f"{self.folder}/world", "--instance", str(self.instance)], "world"
        )
        time.sleep(1.0)
        self.autopilot = self.start(self.autopilot_command, "autopilot", self.autopilot_environment)

    def restart(self):
        """The autopilot restarts on the ground; the world, whose link it is, with it. The companion stays."""
        for process in (self.autopilot, self.world):
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
            self.processes.remove(process)
        self.remove_locks()
        self.mode = self.armed = self.range_m = self.truth = self.boot_us = None
        self.begin()

    def parameters(self, program):
        """What `touchdown simulator --autopilot` would set: asked from it, with a program that only writes that down."""
        probe = f"{self.folder}/probe"
        os.makedirs(f"{probe}/bin", exist_ok=True)
        os.makedirs(f"{probe}/etc", exist_ok=True)
        with open(f"{probe}/bin/autopilot", "w") as f:
            f.write(f"#!/bin/sh\nenv > {probe}/env; cat touchdown.parm > {probe}/parm 2>/dev/null; exit 1\n")
        os.chmod(f"{probe}/bin/autopilot", 0o755)
        with open(f"{self.folder}/fly.toml", "w") as f:
            f.write(self.fly.format(port=0))
        subprocess.run(
            [self.touchdown, "simulator", self.kind, f"{self.folder}/deck.toml", "--with", f"{self.folder}/fly.toml",
             "--autopilot", f"{probe}/bin/autopilot", "--out", f"{probe}/out"],
            capture_output=True,
        )
        if self.kind == "px4":
            lines = [line.strip().split("=", 1) for line in open(f"{probe}/env")]
            found = {k[10:]: v for k, v in lines if k.startswith("PX4_PARAM_")}
            etc = os.path.join(os.path.dirname(os.path.dirname(program)), "etc")
            return found, ["-i", str(self.instance), "-d", "-w", ".", etc]
        found = dict(line.split() for line in open(f"{probe}/parm"))
        # The altitude of the place where the world is.
        return found, ["--model", "JSON:127.0.0.1", "--wipe", "--home=47.397742,8.545594,0,90",
                       "--defaults=touchdown.parm", f"--rc-in-port={free_port()}"]

    def start(self, command, name, environment=None, **more):
        out = open(f"{self.folder}/{name}.log", "w")
        process = subprocess.Popen(
            command, cwd=self.folder, stdin=subprocess.DEVNULL, stdout=more.get("stdout", out), stderr=out,
            env=environment, start_new_session=True,
        )
        self.processes.append(process)
        return process

    def close(self):
        for process in reversed(self.processes):
            try:
                os.killpg(process.pid, signal.SIGKILL)
            except ProcessLookupError:
                pass
            process.wait()
        for udp in (self.link, self.pilot, self.to_companion):
            udp.socket.close()
        self.remove_locks()

    def remove_locks(self):
        for left in (f"/tmp/px4_lock-{self.instance}", f"/tmp/px4-sock-{self.instance}"):
            if self.kind == "px4" and os.path.exists(left):
                os.remove(left)

    # The wire.

    def step(self):
        """Passes on what has come, for a few milliseconds at most."""
        sockets = [self.link.socket, self.pilot.socket, self.to_companion.socket]
        ready, _, _ = select.select(sockets, [], [], 0.002)
        for udp in (self.link, self.pilot, self.to_companion):
            while udp.socket in ready and (data := udp.receive()) is not None:
                if udp is self.link:
                    self.from_autopilot(data)
                elif udp is self.pilot:
                    self.to_pilot(data)
                else:
                    self.from_companion(data)
        if self.companion and self.companion.stdout:
            while (text := self.read_line()) is not None:
                self.lines.append(text)
        now = time.monotonic()
        if now - self.sent_heartbeat > 1.0:
            self.sent_heartbeat = now
            self.send(mav.MAVLink_heartbeat_message(mav.MAV_TYPE_GCS, mav.MAV_AUTOPILOT_INVALID, 0, 0, 4, 3))
        if self.kind == "ardupilot" and now - self.sent_sticks > 0.2:
            self.sent_sticks = now
            self.send(mav.MAVLink_rc_channels_override_message(1, 1, 1500, 1500, 1500, 1500, 0, 0, 0, 0))
        if self.mode is not None and now - self.asked > 5.0:
            self.asked = now
            for message, hz in ((self.modes["truth"], 40), (132, 50), (0, 10), (436, 50), (32, 20)):
                self.command(mav.MAV_CMD_SET_MESSAGE_INTERVAL, message, 1e6 / hz)
        if self.companion and now - self.sent_target > 0.033:
            self.sent_target = now
            self.see()

    def read_line(self):
        ready, _, _ = select.select([self.companion.stdout], [], [], 0)
        if not ready:
            return None
        line = self.companion.stdout.readline()
        if not line:
            return None
        try:
            return json.loads(line)
        except ValueError:
            return None

    def from_autopilot(self, data):
        for identity, system, component, payload in frames(data):
            if identity == 0 and component == 1:
                self.reports(int.from_bytes(payload[:4], "little"), bool(payload[6] & 128))
                others = self.mode != self.modes["following"] and self.taken
                if others and not self.cut and self.told_other is None:
                    self.told_other = time.monotonic()
        if self.companion and not self.cut:
            self.to_companion.send(data)

    def from_companion(self, data):
        if self.cut:
            return
        for identity, *_ in frames(data):
            if identity == 82:
                self.setpoints += 1
                self.last_setpoint = time.monotonic()
                # A datagram that was under way when the report of the mode came does not count.
                if self.told_other is not None and self.last_setpoint - self.told_other > 0.03:
                    self.after_take_over += 1
        self.link.send(data)

    def to_pilot(self, data):
        for identity, system, component, payload in frames(data):
            # CURRENT_MODE, which pymavlink does not know.
            if identity == 436 and system == self.system and self.armed is not None:
                self.reports(int.from_bytes(payload[:4], "little"), self.armed)
        for message in self.parser.parse_buffer(data) or []:
            kind = message.get_type()
            if message.get_srcSystem() != self.system:
                continue
            if kind == "HEARTBEAT" and message.get_srcComponent() == 1:
                self.reports(message.custom_mode, bool(message.base_mode & 128))
            elif kind == "DISTANCE_SENSOR" and message.orientation == 25:
                self.range_m = message.current_distance / 100
                self.boot_us = message.time_boot_ms * 1000
            elif kind == "HIL_STATE_QUATERNION":
                self.boot_us = message.time_usec
                self.truth = (message.lat, message.lon, message.attitude_quaternion)
                self.up_m = message.alt / 1000
            elif kind == "SIM_STATE":
                lat, lon = message.lat_int or round(message.lat * 1e7), message.lon_int or round(message.lon * 1e7)
                self.truth = (lat, lon, (message.q1, message.q2, message.q3, message.q4))
                self.up_m = message.alt
            elif kind == "LOCAL_POSITION_NED":
                self.estimated_up_m = -message.z
            elif kind == "STATUSTEXT":
                self.notes.append(message.text)

    def reports(self, mode, armed):
        if (mode, armed) != (self.mode, self.armed):
            self.history.append((time.monotonic(), mode, armed))
        self.mode, self.armed = mode, armed

    def send(self, message):
        self.pilot.send(message.pack(self.mav))

    def command(self, command, *parameters):
        values = list(parameters) + [0] * (7 - len(parameters))
        self.send(mav.MAVLink_command_long_message(self.system, 1, command, 0, *values))

    def set_mode(self, mode):
        if self.kind == "px4":
            self.command(mav.MAV_CMD_DO_SET_MODE, 1, mode >> 16 & 0xFF, mode >> 24)
        else:
            self.command(mav.MAV_CMD_DO_SET_MODE, 1, mode)

    def place(self):
        """North and east of the start, m."""
        lat, lon, _ = self.truth
        north = (lat - self.origin[0]) * 1e-7 * 111_319.5
        return north, (lon - self.origin[1]) * 1e-7 * 111_319.5 * math.cos(lat * 1e-7 * math.pi / 180)

    def see(self):
        """The pad as a camera sees it: the place of the take-off, at the range."""
        if self.truth is None or self.range_m is None or self.origin is None:
            return
        north, east = self.place()
        w, x, y, z = self.truth[2]
        tilt = 1 - 2 * (x * x + y * y)
        v = (-north, -east, self.range_m * tilt)
        # From north-east-down to body axes: by the conjugate.
        tx, ty, tz = 2 * (-y * v[2] + z * v[1]), 2 * (-z * v[0] + x * v[2]), 2 * (-x * v[1] + y * v[0])
        body = (
            v[0] + w * tx - y * tz + z * ty,
            v[1] + w * ty - z * tx + x * tz,
            v[2] + w * tz - x * ty + y * tx,
        )
        message = mav.MAVLink_landing_target_message(
            self.boot_us if self.kind == "px4" else 0, 0, mav.MAV_FRAME_BODY_FRD, 0, 0, self.range_m, 0, 0, *body,
            q=(1, 0, 0, 0), type=2, position_valid=1,
        )
        self.to_companion.send(message.pack(self.camera))

    # The pilot.

    def until(self, condition, seconds, every=None):
        end, last = time.monotonic() + seconds, 0.0
        while time.monotonic() < end:
            self.step()
            if condition():
                return True
            if every and time.monotonic() - last > 1.0:
                last = time.monotonic()
                every()
        return False

    def stands(self):
        """Waits for the truth, and takes the place where the vehicle stands for that of the deck."""
        self.until(lambda: self.truth is not None and self.range_m is not None, 60) or self.fail("no truth")
        self.until(lambda: False, 2)
        self.origin, self.rest_m = self.truth[:2], self.range_m

    def take_off(self):
        self.stands()

        def ask():
            if self.mode != self.modes["take_off"]:
                self.set_mode(self.modes["take_off"])
            if not self.armed:
                self.command(mav.MAV_CMD_COMPONENT_ARM_DISARM, 1)
            elif self.kind == "ardupilot":
                self.command(mav.MAV_CMD_NAV_TAKEOFF, 0, 0, 0, 0, 0, 0, HEIGHT_M)

        self.until(lambda: self.range_m > 0.7 * HEIGHT_M, 120, ask) or self.fail("no take-off")
        self.until(lambda: self.mode == self.modes["hold"], 30, lambda: self.set_mode(self.modes["hold"]))
        self.until(lambda: False, 4)
        self.until(self.runs_in_real_time, 60) or self.fail("the world does not keep pace")

    def runs_in_real_time(self):
        """Whether the world has caught up with what it lost while the autopilot started."""
        wall, theirs = time.monotonic(), self.boot_us
        self.until(lambda: False, 1.0)
        return abs((self.boot_us - theirs) * 1e-6 / (time.monotonic() - wall) - 1) < 0.03

    def climb_back(self):
        """Above the deck again, in a mode that holds."""
        if not (self.armed and self.world.poll() is None):
            return False
        if self.kind == "px4":
            self.set_mode(self.modes["hold"])
            lat, lon = self.origin
            self.send(mav.MAVLink_command_int_message(
                self.system, 1, 0, mav.MAV_CMD_DO_REPOSITION, 0, 0, -1, 1, 0, float("nan"), lat, lon, self.ground_up_m() + HEIGHT_M))
        else:
            self.set_mode(self.modes["following"])
            self.until(lambda: self.mode == self.modes["following"], 3)
            self.send(mav.MAVLink_set_position_target_local_ned_message(
                0, 1, 1, mav.MAV_FRAME_LOCAL_NED, 0b110111111000, 0, 0, -HEIGHT_M, 0, 0, 0, 0, 0, 0, 0, 0))
        up = self.until(lambda: self.range_m > 0.85 * HEIGHT_M, 12)
        self.set_mode(self.modes["hold"])
        return up and self.until(lambda: self.mode == self.modes["hold"], 5, lambda: self.set_mode(self.modes["hold"]))

    def ground_up_m(self):
        return self.up_m - (self.range_m - self.rest_m)

    def fail(self, what):
        raise RuntimeError(f"{what}; {self.notes[-6:]}")

    def name(self, mode):
        return self.modes["names"].get(mode, str(mode))

    # The companion.

    def start_companion(self, name):
        port = free_port()
        with open(f"{self.folder}/fly.toml", "w") as f:
            f.write(self.fly.format(port=port))
        self.to_companion.peer = ("127.0.0.1", port)
        self.lines, self.cut, self.told_other, self.taken = [], False, None, False
        self.setpoints = self.after_take_over = 0
        self.last_setpoint = None
        self.companion = self.start(
            [self.touchdown, "--json", "fly", f"{self.folder}/fly.toml", "--out", f"{self.folder}/{name}.mcap"],
            f"fly-{name}", stdout=subprocess.PIPE,
        )

    def stop_companion(self):
        """Ctrl-C, and a kill if that does not help."""
        if self.companion.poll() is None:
            self.companion.send_signal(signal.SIGINT)
            if not self.until(lambda: self.companion.poll() is not None, 14):
                self.companion.kill()
        self.companion.wait()
        self.companion.stdout.close()
        self.companion = None

    def stage(self):
        return self.lines[-1].get("stage") if self.lines else None
