"""PX4 or ArduPilot under `touchdown simulator`, played with pymavlink: the simulator's protocol and MAVLink, one flight controller.

It is started by the command itself in place of the autopilot's program, with the autopilot's own arguments, and shares no code
with it. It flies by the true state that the simulator sends (PX4: HIL_STATE_QUATERNION; ArduPilot: the JSON line). Its clock is
the simulator's. Faults are chosen by the environment variable PEER_FAULT. Axes inside: north, east, down; forward, right, down.
"""

import json
import math
import os
import re
import socket
import struct
import sys
import time

os.environ["MAVLINK20"] = "1"
from pymavlink.dialects.v20 import common as mav  # noqa: E402

G = 9.81
FAULT = os.environ.get("PEER_FAULT", "none")
HOVER = 0.487  # motor signal of the simulated vehicle in hover
# Angular acceleration of a full differential signal about roll, pitch, yaw, rad/s2, of the simulated vehicle.
AUTHORITY = (480.0, 480.0, 27.0)
MIX = ((-1, 1, 1), (1, -1, 1), (1, 1, -1), (-1, -1, -1))  # motors 1 to 4: roll right, nose up, yaw right


def multiply(a, b):
    return (
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    )


def conjugate(q):
    return (q[0], -q[1], -q[2], -q[3])


def clamp(x, most):
    return max(-most, min(most, x))


class State:
    def __init__(self):
        self.t = 0.0
        self.position, self.velocity = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        self.q, self.rates, self.force = (1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, -G)
        self.range, self.range_at = None, None


class Controller:
    """Modes, attitude and rates; the same for both autopilots."""

    def __init__(self, px4):
        self.px4 = px4
        self.state = State()
        self.armed = False
        self.mode = 0
        self.home = None
        self.take_off_m = 1.0 if px4 else None
        self.setpoint, self.setpoint_at = None, -9.0
        self.touched_at = None
        self.guided = (6 << 16) if px4 else 4
        self.landing = ((4 << 16) | (6 << 24)) if px4 else 9

    def hold(self, height, climb=None):
        s = self.state
        accelerate = [clamp(1.2 * (self.home[k] - s.position[k]) - 1.8 * s.velocity[k], 2.5) for k in (0, 1)]
        if climb is None:
            lift = 4.0 * (s.position[2] - (self.home[2] - height)) + 3.5 * s.velocity[2]
        else:
            lift = 12.0 * (climb + s.velocity[2])
        yaw = self.yaw
        n, e = accelerate
        forward, right = math.cos(yaw) * n + math.sin(yaw) * e, -math.sin(yaw) * n + math.cos(yaw) * e
        half = (math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2))
        tilt = multiply((1.0, right / G / 2, 0.0, 0.0), (1.0, 0.0, -forward / G / 2, 0.0))
        length = math.sqrt(sum(c * c for c in tilt))
        q = multiply(half, tuple(c / length for c in tilt))
        return q, HOVER * (1 + clamp(lift, 5.0) / G * 0.8)

    def motors(self):
        s = self.state
        if not self.armed:
            return [0.0] * 4
        if self.mode == self.guided and (self.px4 or self.setpoint is not None):
            if s.t - self.setpoint_at > 0.5:
                self.mode = ((4 << 16) | (3 << 24)) if self.px4 else 17
                q, signal = self.hold(self.take_off_m)
            else:
                q, signal = self.setpoint
        elif self.mode == self.landing:
            q, signal = self.hold(0.0, climb=-0.3)
            if self.touched_at is None and s.range is not None and s.range < 0.115:
                self.touched_at = s.t
            if self.touched_at is not None:
                signal = 0.0
                self.armed = s.t - self.touched_at < 0.5
        elif self.take_off_m is None:
            return [0.05] * 4
        else:
            q, signal = self.hold(self.take_off_m)
        error = multiply(conjugate(s.q), q)
        sign = 1 if error[0] >= 0 else -1
        torque = []
        for k, gain, rate_gain in ((0, 6.0, 18.0), (1, 6.0, 18.0), (2, 2.0, 5.0)):
            rate = 2 * gain * sign * error[k + 1]
            torque.append(clamp(rate_gain * (rate - s.rates[k]) / AUTHORITY[k], 0.2))
        return [max(0.0, min(1.0, signal + sum(m * t for m, t in zip(mix, torque)))) for mix in MIX]

    def arm(self):
        s = self.state
        self.armed = True
        self.home = s.position
        w, x, y, z = s.q
        self.yaw = math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


class Mavlink:
    """The link to pilot and companion, in simulated time."""

    def __init__(self, controller, local, remote, system):
        self.c = controller
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", local))
        self.socket.setblocking(False)
        self.remote = ("127.0.0.1", remote)
        self.mav = mav.MAVLink(None, srcSystem=system, srcComponent=1)
        self.every, self.due = {1: 1.0}, {}
        px4 = controller.px4
        self.imu = 105 if px4 else 26
        self.parameters = {
            "THR_MDL_FAC": 0.0, "MPC_THR_HOVER": HOVER, "COM_OF_LOSS_T": 0.5, "COM_OBL_RC_ACT": 5, "EKF2_RNG_CTRL": 0,
            "MPC_LAND_SPEED": 0.7, "LNDMC_Z_VEL_MAX": 0.25, "MC_BAT_SCALE_EN": 0,
        } if px4 else {
            "GUID_OPTIONS": 8, "GUID_TIMEOUT": 0.5, "MOT_THST_EXPO": 0.0, "MOT_THST_HOVER": (HOVER - 0.05) / 0.95,
            "MOT_SPIN_MIN": 0.05, "MOT_SPIN_MAX": 1.0, "PLND_ENABLED": 0, "ATC_ANGLE_BOOST": 0, "MOT_BAT_VOLT_MAX": 0,
        }

    def send(self, message):
        self.socket.sendto(message.pack(self.mav), self.remote)

    def receive(self):
        while True:
            try:
                data, _ = self.socket.recvfrom(4096)
            except (BlockingIOError, ConnectionRefusedError):
                return
            for message in self.mav.parse_buffer(data) or []:
                self.take(message)

    def take(self, m):
        c, kind = self.c, m.get_type()
        if kind == "TIMESYNC" and m.tc1 == 0:
            self.send(self.mav.timesync_encode(int((c.state.t + 5) * 1e9), m.ts1))
        elif kind == "PARAM_REQUEST_READ" and m.param_id in self.parameters:
            value, what = self.parameters[m.param_id], mav.MAV_PARAM_TYPE_REAL32
            if c.px4 and isinstance(value, int):
                value, what = struct.unpack("<f", struct.pack("<i", value))[0], mav.MAV_PARAM_TYPE_INT32
            self.send(self.mav.param_value_encode(m.param_id.encode(), value, what, 9, 1))
        elif kind == "SET_ATTITUDE_TARGET":
            signal = m.thrust if c.px4 else 0.05 + 0.95 * m.thrust
            c.setpoint, c.setpoint_at = (tuple(m.q), signal), c.state.t
        elif kind == "COMMAND_LONG":
            self.command(m)

    def command(self, m):
        c = self.c
        if m.command == mav.MAV_CMD_SET_MESSAGE_INTERVAL:
            self.every[int(m.param1)] = m.param2 * 1e-6
        elif m.command == mav.MAV_CMD_DO_SET_MODE:
            main, sub = int(m.param2), int(m.param3)
            c.mode = (main << 16) | (sub << 24) if c.px4 else main
        elif m.command == mav.MAV_CMD_COMPONENT_ARM_DISARM:
            if m.param1 == 1 and not c.armed and c.state.t > 1.0:
                c.arm()
            elif m.param1 == 0 and m.param2 == 21196:
                c.armed = False
            self.due["heartbeat"] = 0.0
        elif m.command == mav.MAV_CMD_NAV_TAKEOFF and not c.px4:
            c.take_off_m = m.param7
        self.send(self.mav.command_ack_encode(m.command, 0))

    def is_due(self, key, period):
        now = self.c.state.t
        if now < self.due.get(key, 0.0):
            return False
        self.due[key] = max(self.due.get(key, 0.0) + period, now - period)
        return True

    def stream(self):
        c, s, out = self.c, self.c.state, self.mav
        boot = int((s.t + 5) * 1000)
        if c.px4 and c.armed and c.mode == ((4 << 16) | (2 << 24)) and c.home[2] - s.position[2] > 0.85:
            c.mode = (4 << 16) | (3 << 24)
        if self.is_due("heartbeat", 0.2):
            base = 1 | (128 if c.armed else 0)
            name = mav.MAV_AUTOPILOT_PX4 if c.px4 else mav.MAV_AUTOPILOT_ARDUPILOTMEGA
            self.send(out.heartbeat_encode(mav.MAV_TYPE_QUADROTOR, name, base, c.mode, 4))
        if 31 in self.every and self.is_due(31, self.every[31]):
            self.send(out.attitude_quaternion_encode(boot, *s.q, *s.rates))
        if self.imu in self.every and self.is_due(self.imu, self.every[self.imu]):
            if c.px4:
                self.send(out.highres_imu_encode(int((s.t + 5) * 1e6), *s.force, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 7))
            else:
                self.send(out.scaled_imu_encode(boot, *[int(round(f / 9.80665e-3)) for f in s.force], 0, 0, 0, 0, 0, 0))
        if 32 in self.every and self.is_due(32, self.every[32]):
            self.send(out.local_position_ned_encode(boot, *s.position, *s.velocity))
        if s.range_at is not None and 132 in self.every and self.is_due(132, self.every[132]):
            at = int((s.range_at + 5) * 1000)
            self.send(out.distance_sensor_encode(at, 2, 1200, round(s.range * 100), 0, 0, 25, 0))
        if self.is_due(1, 1.0):
            self.send(out.sys_status_encode(0, 0, 0, 0, 15000, -1, 80, 0, 0, 0, 0, 0, 0))


def misbehave(t, send_garbage, log):
    """What the fault does at a time; returns whether this answer is withheld."""
    if FAULT == "ends" and t > 3:
        print("the peer ends as a crashed autopilot does", flush=True)
        sys.exit(3)
    if FAULT == "garbage" and int(t * 250) % 50 == 0:
        send_garbage(bytes((7 * k + int(t * 1000)) % 256 for k in range(97)))
    if FAULT == "silent" and t > 3:
        time.sleep(60)
    if FAULT == "skips" and int(round(t * 1000)) == 3000 and "skipped" not in log:
        log["skipped"] = True
        return True
    return False


def px4(instance):
    controller = Controller(True)
    link = Mavlink(controller, 14580 + instance, 14540 + instance, instance + 1)
    stream = None
    while stream is None:
        try:
            stream = socket.create_connection(("127.0.0.1", 4560 + instance))
        except ConnectionRefusedError:
            time.sleep(0.01)
    stream.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    codec = mav.MAVLink(None, srcSystem=instance + 1, srcComponent=1)
    s, first, log = controller.state, None, {}
    while True:
        data = stream.recv(8192)
        if not data:
            return
        for m in codec.parse_buffer(data) or []:
            kind = m.get_type()
            if kind == "HIL_STATE_QUATERNION":
                north = math.radians(m.lat * 1e-7 - 47.397742) * 6371000
                east = math.radians(m.lon * 1e-7 - 8.545594) * 6371000 * math.cos(math.radians(47.397742))
                s.position, s.velocity = (north, east, 488 - m.alt * 1e-3), (m.vx / 100, m.vy / 100, m.vz / 100)
                s.q = tuple(m.attitude_quaternion)
            elif kind == "DISTANCE_SENSOR":
                s.range, s.range_at = m.current_distance / 100, s.t
            elif kind == "HIL_SENSOR":
                first = m.time_usec if first is None else first
                assert m.time_usec > 0 and m.id == 0 and m.fields_updated & 0x3F == 0x3F
                s.t = (m.time_usec - first) * 1e-6
                s.force, s.rates = (m.xacc, m.yacc, m.zacc), (m.xgyro, m.ygyro, m.zgyro)
                link.receive()
                link.stream()
                if misbehave(s.t, stream.sendall, log) or s.t < 0.05:
                    continue  # PX4 answers nothing while it starts.
                controls = controller.motors() + [0.0] * 12
                mode = 1 | (128 if controller.armed else 0)
                stream.sendall(codec.hil_actuator_controls_encode(m.time_usec, controls, mode, 1).pack(codec))


def ardupilot(simulator_port, mavlink_port):
    controller = Controller(False)
    link = Mavlink(controller, 0, mavlink_port, 1)
    sock = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    sock.settimeout(1.0)
    to = ("127.0.0.1", simulator_port)
    s, count, log = controller.state, 0, {}
    while True:
        pulses = [round(1000 + 1000 * signal) for signal in controller.motors()] + [0] * 12
        if not misbehave(s.t, lambda data: sock.sendto(data, to), log):
            sock.sendto(struct.pack("<HHI16H", 18458, 500, count, *pulses), to)
        try:
            data = sock.recv(4096)
        except socket.timeout:
            continue  # The same frame again, as ArduPilot does.
        assert data[:1] == b"\n" and data[-1:] == b"\n"
        assert re.search(rb'"position":\[', data), "no space before a bracket"
        state = json.loads(data)
        s.t = state["timestamp"]
        s.position, s.velocity = tuple(state["position"]), tuple(state["velocity"])
        s.q, s.rates = tuple(state["quaternion"]), tuple(state["imu"]["gyro"])
        s.force = tuple(state["imu"]["accel_body"])
        if "rng_1" in state:
            s.range, s.range_at = state["rng_1"], s.t
        count += 1
        link.receive()
        link.stream()


def main():
    arguments = sys.argv[1:]
    if "PEER_ALIVE" in os.environ:
        # Open until this process ends, however it ends.
        os.write(os.open(os.environ["PEER_ALIVE"], os.O_WRONLY), b"x")
    if "-i" in arguments:
        px4(int(arguments[arguments.index("-i") + 1]))
    else:
        options = dict(a[2:].split("=", 1) for a in arguments if a.startswith("--") and "=" in a)
        ardupilot(int(options["sim-port-out"]), int(options["serial0"].rsplit(":", 1)[1]))


if __name__ == "__main__":
    main()
