"""An autopilot's side of the wire, played with pymavlink, with a small vehicle above a heaving deck.

It shares no code with the companion that it tests. The vehicle is a point mass: its attitude and the root of its thrust
follow the setpoints with a lag, and legs carry it 0.1 m above the deck. Axes inside: east, north, up.
"""

import argparse
import hashlib
import json
import math
import os
import random
import signal
import socket
import struct
import time
import tty

os.environ["MAVLINK20"] = "1"
from pymavlink.dialects.v20 import development as mav  # noqa: E402  # `common` has no CURRENT_MODE yet

MASS, G = 1.37, 9.81
ROOT = 7.4  # root of the thrust at full motor signal, √N
MOTOR_S, ATTITUDE_S = 0.05, 0.06
LEG_M, LEG_N_PER_M, LEG_NS_PER_M = 0.1, 4000.0, 90.0
SIGNALS = {"kill": signal.SIGKILL, "interrupt": signal.SIGINT, "terminate": signal.SIGTERM, "hang up": signal.SIGHUP}
BOOT_OFFSET_S = 37.25  # the autopilot started before the companion

PX4 = {
    "name": mav.MAV_AUTOPILOT_PX4,
    "offboard": 6 << 16,
    "pilot": 3 << 16,
    "hold": (4 << 16) | (3 << 24),
    "imu": 105,
    "parameters": {
        "THR_MDL_FAC": 0.3,
        "MPC_THR_HOVER": 0.42,
        "COM_OF_LOSS_T": 0.5,
        "COM_OBL_RC_ACT": 5,
        "EKF2_RNG_CTRL": 0,
        "MPC_LAND_SPEED": 0.7,
        "LNDMC_Z_VEL_MAX": 0.25,
        "MC_BAT_SCALE_EN": 0,
    },
}
ARDUPILOT = {
    "name": mav.MAV_AUTOPILOT_ARDUPILOTMEGA,
    "offboard": 4,
    "pilot": 5,
    "hold": 17,
    "imu": 26,
    "parameters": {
        "GUID_OPTIONS": 8,
        "GUID_TIMEOUT": 0.5,
        "MOT_THST_EXPO": 0.65,
        "MOT_THST_HOVER": 0.28,
        "MOT_SPIN_MIN": 0.15,
        "MOT_SPIN_MAX": 0.95,
        "PLND_ENABLED": 0,
        "ATC_ANGLE_BOOST": 1,
        "MOT_BAT_VOLT_MAX": 0,
    },
}


def rotate(q, v):
    w, x, y, z = q
    tx, ty, tz = 2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])
    return (
        v[0] + w * tx + y * tz - z * ty,
        v[1] + w * ty + z * tx - x * tz,
        v[2] + w * tz + x * ty - y * tx,
    )


def ned_rotate(q, frd):
    """East, north, up of a vector in forward-right-down, by the quaternion of MAVLink."""
    n, e, d = rotate(q, frd)
    return (e, n, -d)


def to_frd(q, enu):
    """Forward, right, down of a vector in east-north-up."""
    w, x, y, z = q
    return rotate((w, -x, -y, -z), (enu[1], enu[0], -enu[2]))


class Vehicle:
    def __init__(self, kind, amplitude_m):
        self.kind, self.amplitude_m = kind, amplitude_m
        self.position, self.velocity = [0.15, -0.1, 1.1], [0.0, 0.0, 0.0]
        self.q = self.wanted_q = (1.0, 0.0, 0.0, 0.0)  # level, pointing north
        self.signal, self.root = 0.0, math.sqrt(MASS * G)
        self.force, self.count = [0.0, 0.0, 0.0], 0
        self.t = 0.0
        self.touch_mps, self.least_m = None, 9.0

    def deck(self):
        w = 2 * math.pi * 0.5
        return self.amplitude_m * math.sin(w * self.t), self.amplitude_m * w * math.cos(w * self.t)

    def height(self):
        return self.position[2] - self.deck()[0]

    def motors(self, setpoint):
        """The motors' signal of a thrust setpoint, as the firmware's own curve has it."""
        p = self.kind["parameters"]
        f, low, high = p.get("THR_MDL_FAC"), 0.0, 1.0
        if f is None:
            f, low, high = p["MOT_THST_EXPO"], p["MOT_SPIN_MIN"], p["MOT_SPIN_MAX"]
        if p.get("ATC_ANGLE_BOOST"):
            setpoint = min(1.0, setpoint / max(0.1, ned_rotate(self.wanted_q, (0.0, 0.0, -1.0))[2]))
        x = (f - 1 + math.sqrt((1 - f) ** 2 + 4 * f * setpoint)) / (2 * f)
        self.signal = low + x * (high - low)

    def hover(self):
        """The pilot holds the vehicle above the pad."""
        up = MASS * (G + 4 * (1.1 - self.position[2]) - 3 * self.velocity[2])
        self.signal = math.sqrt(max(up, 0.0)) / ROOT
        tilt = [
            max(-0.2, min(0.2, (1.0 * (-self.position[k]) - 1.5 * self.velocity[k]) / G)) for k in (0, 1)
        ]
        # Roll right pushes east, pitch down pushes north, for a vehicle that points north.
        norm = math.sqrt(1 + tilt[0] ** 2 / 4 + tilt[1] ** 2 / 4)
        self.wanted_q = (1 / norm, tilt[0] / 2 / norm, -tilt[1] / 2 / norm, 0.0)

    def step(self, dt, armed):
        share = dt / ATTITUDE_S
        sign = 1 if sum(a * b for a, b in zip(self.q, self.wanted_q)) >= 0 else -1
        q = [a + share * (sign * b - a) for a, b in zip(self.q, self.wanted_q)]
        length = math.sqrt(sum(c * c for c in q))
        self.q = tuple(c / length for c in q)
        self.root += dt / MOTOR_S * (ROOT * (self.signal if armed else 0.0) - self.root)
        thrust = ned_rotate(self.q, (0.0, 0.0, -self.root * self.root))
        force = list(thrust)
        heave, heave_mps = self.deck()
        gap = self.position[2] - heave - LEG_M
        closing = heave_mps - self.velocity[2]
        if gap < 0:
            if self.touch_mps is None:
                self.touch_mps = closing
            force[2] += max(0.0, -LEG_N_PER_M * gap + LEG_NS_PER_M * closing)
            for k in (0, 1):
                force[k] -= 30.0 * self.velocity[k]
        for k in range(3):
            self.velocity[k] += dt * (force[k] / MASS - (G if k == 2 else 0.0))
            self.position[k] += dt * self.velocity[k]
            self.force[k] += force[k] / MASS
        self.count += 1
        self.t += dt
        self.least_m = min(self.least_m, self.height())

    def specific_force(self):
        mean = [f / max(self.count, 1) for f in self.force]
        self.force, self.count = [0.0, 0.0, 0.0], 0
        return to_frd(self.q, mean)


class Wire:
    """Bytes over UDP, TCP or a pseudo terminal, and the faults of a link. The address is printed if the peer chose it."""

    def __init__(self, args):
        if args.link == "udp":
            self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            self.socket.connect(("127.0.0.1", args.port))
        elif args.link == "tcp":
            listener = socket.socket()
            listener.bind(("127.0.0.1", 0))
            listener.listen(1)
            print(json.dumps({"address": f"tcp:127.0.0.1:{listener.getsockname()[1]}"}), flush=True)
            self.socket, _ = listener.accept()
            self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        else:
            self.socket, (self.terminal, end) = None, os.openpty()
            tty.setraw(end)
            os.set_blocking(self.terminal, False)
            print(json.dumps({"address": f"serial:{os.ttyname(end)}:921600"}), flush=True)
        if self.socket is not None:
            self.socket.setblocking(False)
        self.random = random.Random(args.seed)
        self.mute, self.delay_s, self.damage, self.late, self.old = False, 0.0, False, [], []
        self.mav = mav.MAVLink(self, srcSystem=args.system, srcComponent=1)
        if args.passphrase:
            self.mav.signing.secret_key = hashlib.sha256(args.passphrase.encode()).digest()
            self.mav.signing.timestamp = int((time.time() - 1420070400) * 1e5)
            self.mav.signing.sign_outgoing = True

    def write(self, bytes_):
        bytes_ = bytes(bytes_)
        self.old = self.old[-99:] + [bytes_]
        if self.mute:
            return
        if self.damage and self.random.random() < 0.2:
            kind, spoiled = self.random.randrange(3), bytearray(bytes_)
            if kind == 0:
                spoiled[self.random.randrange(len(spoiled))] ^= 1 << self.random.randrange(8)
                bytes_ = bytes(spoiled)
            elif kind == 1:
                bytes_ = bytes(spoiled[: self.random.randrange(1, len(spoiled))])
            else:
                bytes_ += self.old[0]
        self.late.append((time.monotonic() + self.delay_s, bytes_))
        self.flush()

    def flush(self):
        while self.late and self.late[0][0] <= time.monotonic():
            _, bytes_ = self.late.pop(0)
            try:
                if self.socket is not None:
                    self.socket.send(bytes_)
                else:
                    os.write(self.terminal, bytes_)
            except OSError:
                pass

    def receive(self):
        self.flush()
        while True:
            try:
                bytes_ = self.socket.recv(4096) if self.socket is not None else os.read(self.terminal, 4096)
            except OSError:
                return
            if not bytes_:
                return
            if not self.mute:
                yield from self.mav.parse_buffer(bytes_) or []


class Autopilot:
    def __init__(self, args):
        self.kind = PX4 if args.autopilot == "px4" else ARDUPILOT
        self.args = args
        self.wire = Wire(args)
        self.wire.mav.robust_parsing = True
        self.other = mav.MAVLink(self.wire, srcSystem=args.system, srcComponent=1)
        self.vehicle = Vehicle(self.kind, args.amplitude)
        self.random = random.Random(args.seed)
        self.mode, self.armed = self.kind["pilot"], True
        self.start = time.monotonic()
        self.due, self.every = {"heartbeat": 0.0, "target": 0.0, "ask": 0.0}, {}
        self.delayed, self.battery = [], 80
        p = self.kind["parameters"]
        self.parameters = dict(p)
        for change in args.parameter:
            name, value = change.split("=")
            self.parameters[name] = type(self.parameters[name])(float(value))
        self.first = dict(self.parameters)
        self.faulted_at, self.jump_s, self.yaw, self.force = None, 0.0, 0.0, 1.0
        self.thrust = p.get("MPC_THR_HOVER", p.get("MOT_THST_HOVER"))
        self.setpoint_at = -9.0
        self.said_pilot_at = None
        self.offboard_at = self.taken_at = None
        self.log = {
            "setpoints": 0, "setpoints_in_offboard": 0, "setpoints_after_take_over": 0, "setpoints_after_fault": 0, "mode_requests": 0,
            "answered": 0, "heartbeats": 0, "failsafe": False, "parameters_set": 0, "disarmed_s": None,
        }

    def now(self):
        return time.monotonic() - self.start + BOOT_OFFSET_S

    def stamp(self):
        """The autopilot's own clock, which a restart sets back."""
        return self.now() + self.jump_s

    def boot_ms(self, t=None):
        return int((self.stamp() if t is None else t) * 1000)

    # -- what comes

    def receive(self):
        for message in self.wire.receive():
            kind = message.get_type()
            if kind == "SET_ATTITUDE_TARGET":
                self.setpoint(message)
            elif kind == "HEARTBEAT":
                self.log["heartbeats"] += 1
            elif kind == "TIMESYNC":
                if message.tc1 == 0:
                    self.wire.mav.timesync_send(int(self.stamp() * 1e9), message.ts1)
                    if self.faulted_at is not None and self.args.fault == "second":
                        self.other.timesync_send(int((self.stamp() + 0.02) * 1e9), message.ts1)
                else:
                    self.log["answered"] += 1
            elif kind == "PARAM_REQUEST_READ":
                self.parameter(message.param_id)
            elif kind == "PARAM_SET":
                self.log["parameters_set"] += 1
                if message.param_id in self.parameters:
                    value = message.param_value
                    if message.param_type == mav.MAV_PARAM_TYPE_INT32 and self.kind is PX4:
                        value = struct.unpack("<i", struct.pack("<f", value))[0]
                    self.parameters[message.param_id] = value
                self.parameter(message.param_id)
            elif kind == "COMMAND_LONG":
                self.command(message)

    def setpoint(self, message):
        now = self.now()
        self.setpoint_at = now
        self.log["setpoints"] += 1
        if self.said_pilot_at is not None and now - self.said_pilot_at > 0.3:
            self.log["setpoints_after_take_over"] += 1
        assert message.type_mask == 7 and message.target_system == self.args.system
        assert abs(sum(c * c for c in message.q) - 1) < 1e-3
        if self.faulted_at is not None and now - self.faulted_at > 3.0:
            self.log["setpoints_after_fault"] += 1
        if self.mode == self.kind["offboard"] and not (self.faulted_at and self.args.fault == "reject"):
            self.log["setpoints_in_offboard"] += 1
            self.vehicle.wanted_q = tuple(message.q)
            self.vehicle.motors(message.thrust)
            self.thrust = message.thrust

    def parameter(self, name):
        value = self.parameters.get(name)
        if value is None:
            return
        kind = mav.MAV_PARAM_TYPE_REAL32
        if self.kind is PX4 and isinstance(value, int):
            value, kind = struct.unpack("<f", struct.pack("<i", value))[0], mav.MAV_PARAM_TYPE_INT32
        self.wire.mav.param_value_send(name.encode(), value, kind, 900, 1)

    def command(self, m):
        result = mav.MAV_RESULT_ACCEPTED
        if m.command == mav.MAV_CMD_SET_MESSAGE_INTERVAL and self.kind is PX4 and m.param1 == mav.MAVLINK_MSG_ID_HEARTBEAT:
            result = mav.MAV_RESULT_DENIED
        elif m.command == mav.MAV_CMD_SET_MESSAGE_INTERVAL:
            self.every[int(m.param1)] = m.param2 * 1e-6
            self.due.setdefault(int(m.param1), 0.0)
        elif m.command == mav.MAV_CMD_REQUEST_MESSAGE and m.param1 == 148:
            version = 0x011100FF if self.kind is PX4 else 0x040700FF
            self.wire.mav.autopilot_version_send(0, version, 0, 0, 0, [0] * 8, [0] * 8, [0] * 8, 0, 0, 0)
        elif m.command == mav.MAV_CMD_DO_SET_MODE:
            self.log["mode_requests"] += 1
            main, sub = int(m.param2), int(m.param3)
            self.mode = (main << 16) | (sub << 24) if self.kind is PX4 else main
        elif m.command == mav.MAV_CMD_COMPONENT_ARM_DISARM and m.param1 == 0 and m.param2 == 21196:
            if self.armed:
                self.armed = False
                self.log["disarmed_s"] = self.now()
                self.due["heartbeat"] = 0.0
        else:
            result = mav.MAV_RESULT_UNSUPPORTED
        self.wire.mav.command_ack_send(m.command, result)

    # -- what goes

    def send(self):
        now, out, v = self.now(), self.wire.mav, self.vehicle

        def is_due(key, period):
            if key not in self.due or now < self.due[key]:
                return False
            self.due[key] = max(self.due[key] + period, now - period)
            return True

        if is_due("heartbeat", self.every.get(0, 1.0)):
            base = mav.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
            base |= mav.MAV_MODE_FLAG_SAFETY_ARMED if self.armed else 0
            out.heartbeat_send(mav.MAV_TYPE_QUADROTOR, self.kind["name"], base, self.mode, 4)
            self.has_told_mode()
        if self.kind is PX4 and is_due(436, self.every.get(436, 1)):
            out.current_mode_send(0, self.mode, 0)
            self.has_told_mode()
        if is_due("ask", 0.5):
            out.timesync_send(0, int(self.stamp() * 1e9))
        if is_due(31, self.every.get(31, 1)):
            out.attitude_quaternion_send(self.boot_ms(), *self.turned(v.q), 0, 0, 0)
        if is_due(self.kind["imu"], self.every.get(self.kind["imu"], 1)):
            force = [f * self.force for f in v.specific_force()]
            if self.kind is PX4:
                out.highres_imu_send(int(self.stamp() * 1e6), *force, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 7)
            else:
                milli = [int(round(f / 9.80665e-3)) for f in force]
                out.scaled_imu_send(self.boot_ms(), *milli, 0, 0, 0, 0, 0, 0)
        if is_due(132, self.every.get(132, 1)):
            down = -ned_rotate(v.q, (0.0, 0.0, 1.0))[2]
            distance = v.height() / max(down, 0.5) + self.random.gauss(0, 0.003)
            out.distance_sensor_send(self.boot_ms(), 2, 1200, max(0, round(distance * 100)), 0, 0, 25, 0)
        if is_due(32, self.every.get(32, 1)):
            e, n, u = v.velocity
            noise = [self.random.gauss(0, 0.03) for _ in range(3)]
            x, y, z = v.position
            out.local_position_ned_send(self.boot_ms(), y, x, -z, n + noise[0], e + noise[1], noise[2] - u)
        if is_due(83, self.every.get(83, 1)):
            out.attitude_target_send(self.boot_ms(), 0, v.wanted_q, 0, 0, 0, self.thrust)
        if is_due(1, self.every.get(1, 1)):
            out.sys_status_send(0, 0, 0, 0, 15000, -1, self.battery, 0, 0, 0, 0, 0, 0)
        if is_due("target", 1 / 30):
            deck = (-v.position[0], -v.position[1], -v.height())
            seen = [c + self.random.gauss(0, 0.003) for c in to_frd(v.q, deck)]
            self.delayed.append((now + 0.03, int(self.stamp() * 1e6), seen))
        while self.delayed and self.delayed[0][0] <= now:
            _, stamp, seen = self.delayed.pop(0)
            out.landing_target_send(stamp, 0, mav.MAV_FRAME_BODY_FRD, 0, 0, 0, 0, 0, *seen, (1, 0, 0, 0), 0, 1)

    # -- the pilot, and the firmware's failsafe

    def has_told_mode(self):
        if self.taken_at is not None and self.said_pilot_at is None:
            self.said_pilot_at = self.now()

    def pilot(self):
        now = self.now()
        streams = self.log["setpoints"] > 100 and now - self.setpoint_at < 0.3
        if self.offboard_at is None and streams and self.args.pilot != "none":
            self.mode, self.offboard_at = self.kind["offboard"], now
        if self.args.pilot == "takes-over" and self.offboard_at is not None and self.taken_at is None:
            if now - self.offboard_at > 3.0:
                self.mode, self.taken_at = self.kind["pilot"], now
        if self.mode == self.kind["offboard"] and self.armed and now - self.setpoint_at > 0.5:
            self.mode, self.log["failsafe"] = self.kind["hold"], True

    # -- what goes wrong, two seconds after the switch

    def turned(self, q):
        """The attitude after a reset of the heading."""
        c, s = math.cos(0.5 * self.yaw), math.sin(0.5 * self.yaw)
        w, x, y, z = q
        return (c * w - s * z, c * x - s * y, c * y + s * x, c * z + s * w)

    def fault(self):
        if self.offboard_at is None or self.faulted_at is not None or self.now() - self.offboard_at < 2.0:
            return
        if self.args.fault is None:
            return
        self.faulted_at = self.now()
        if self.args.fault == "silent":
            self.wire.mute = True
        elif self.args.fault == "slow":
            self.wire.delay_s = 1.2
        elif self.args.fault == "damage":
            self.wire.damage = True
        elif self.args.fault == "restart":
            self.jump_s = -self.now()
        elif self.args.fault == "jump":
            self.jump_s = 0.5
        elif self.args.fault == "nan":
            self.force = math.nan
        elif self.args.fault == "absurd":
            self.force = 1e30
        elif self.args.fault == "yaw":
            self.yaw = 0.6
        elif self.args.fault == "battery":
            self.battery = 2
        elif self.args.fault == "reject":
            # A thrust that the companion does not ask for: the vehicle climbs, and a hover would look as if it followed.
            self.thrust *= 1.15
            self.vehicle.motors(self.thrust)
        elif self.args.fault in SIGNALS:
            os.kill(self.args.pid, SIGNALS[self.args.fault])

    def second(self):
        """Another autopilot with the same id, of the same kind."""
        if self.faulted_at is not None and self.args.fault == "second":
            for _ in range(2):
                self.other.attitude_quaternion_send(self.boot_ms(), 1, 0, 0, 0, 0, 0, 0)

    def run(self):
        simulated = self.now()
        # Longest time in which this process did nothing: a loaded machine that stops it shows nothing about the companion.
        stopped_s, turn = 0.0, self.now()
        while self.now() - BOOT_OFFSET_S < self.args.seconds:
            stopped_s, turn = max(stopped_s, self.now() - turn), self.now()
            self.receive()
            self.pilot()
            self.fault()
            self.second()
            while simulated < self.now():
                if self.mode != self.kind["offboard"]:
                    self.vehicle.hover()
                self.vehicle.step(0.001, self.armed)
                simulated += 0.001
            self.send()
            if self.log["disarmed_s"] is not None and self.now() - self.log["disarmed_s"] > 1.5:
                break
            if self.said_pilot_at is not None and self.now() - self.said_pilot_at > 3.0:
                break
            lasts = self.args.fault not in ("damage", "battery")
            if self.faulted_at is not None and lasts and self.now() - self.faulted_at > 5.0:
                break
            time.sleep(0.002)
        v = self.vehicle
        print(json.dumps({
            **self.log, "parameters_as_before": all(abs(v - self.first[k]) < 1e-6 for k, v in self.parameters.items()), "armed": self.armed, "height_m": v.height(), "touch_mps": v.touch_mps, "least_m": v.least_m,
            "stopped_s": stopped_s, "offset_m": math.hypot(v.position[0], v.position[1]), "in_offboard": self.mode == self.kind["offboard"],
        }))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--link", choices=["udp", "tcp", "pty"], default="udp")
    parser.add_argument("--port", type=int)
    parser.add_argument("--system", type=int, default=7)
    parser.add_argument("--passphrase")
    parser.add_argument("--parameter", action="append", default=[], help="NAME=VALUE at the start")
    parser.add_argument("--fault")
    parser.add_argument("--pid", type=int, help="of the companion, for the faults that are signals")
    parser.add_argument("--autopilot", choices=["px4", "ardupilot"], default="px4")
    parser.add_argument("--pilot", choices=["switches", "takes-over", "none"], default="switches")
    parser.add_argument("--amplitude", type=float, default=0.05)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--seed", type=int, default=1)
    Autopilot(parser.parse_args()).run()


if __name__ == "__main__":
    main()
