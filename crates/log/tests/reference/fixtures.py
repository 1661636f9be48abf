"""Writes small recordings with the tools that others use, and what those tools read back.

    python fixtures.py        (mcap 1.6.0, mcap-ros2-support 0.6.0, rosbags 0.11.9, pyarrow 26.0.1)

`fields.tsv` holds one line a field: file, topic, field, finite values, their sum.
"""

import json
import math
from decimal import Decimal
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer
from mcap_ros2.decoder import DecoderFactory
from mcap_ros2.writer import Writer as Ros2Writer
from rosbags.rosbag1 import Reader as BagReader
from rosbags.rosbag1 import Writer as BagWriter
from rosbags.typesys import Stores, get_typestore

HERE = Path(__file__).parent / "fixtures"
START = 1_700_000_000_000_000_000
COUNT = 60
RNG = np.random.default_rng(7)

LINE = "=" * 80
TIME = f"{LINE}\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
HEADER = f"{LINE}\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n"
VECTOR = f"{LINE}\nMSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n"
QUATERNION = f"{LINE}\nMSG: geometry_msgs/Quaternion\nfloat64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n"
IMU = (
    "# An inertial measurement unit.\nstd_msgs/Header header\ngeometry_msgs/Quaternion orientation\n"
    "float64[9] orientation_covariance # Row major\ngeometry_msgs/Vector3 linear_acceleration\n"
    + HEADER + TIME + QUATERNION + VECTOR
)
RANGE = (
    "uint8 ULTRASOUND=0\nuint8 INFRARED=1\nstd_msgs/Header header\nuint8 radiation_type\n"
    "float32 field_of_view\nfloat32 range\n" + HEADER + TIME
)
MOTORS = "uint64 timestamp\nfloat32[12] control\nbool ok\nint16[] any\nstring[] names\n"


def header(k, offset_ns=0):
    stamp = START + 4_000_000 * k - offset_ns
    return {"stamp": {"sec": stamp // 10**9, "nanosec": stamp % 10**9}, "frame_id": "base" * (k % 3)}


def flatten(value, name, tell, fixed=None):
    """Tells numbers as the reader under test names them."""
    if isinstance(value, (bool, int, float, np.number, np.bool_)):
        tell(name, float(value))
    elif isinstance(value, str):
        pass
    elif isinstance(value, (list, tuple, np.ndarray, bytes)):
        # Fixed lengths are told by the name of the field.
        any_length = name.split(".")[-1] in {"any", "names", "data", "dim"}
        scalar = len(value) == 0 or not hasattr(value[0], "__slots__") and not hasattr(value[0], "__dict__")
        for k, element in enumerate(value[: (16 if scalar else 8) if any_length else 64]):
            flatten(element, f"{name}[{k}]", tell)
        if any_length:
            tell(f"{name}.length", float(len(value)))
    elif isinstance(value, dict):
        for key, inner in value.items():
            flatten(inner, f"{name}.{key}" if name else key, tell)
    else:
        keys = getattr(value, "__slots__", None) or [k for k in vars(value)]
        for key in keys:
            if not key.startswith("_"):
                flatten(getattr(value, key), f"{name}.{key}" if name else key, tell)


def ros2(path):
    with open(path, "wb") as f:
        writer = Ros2Writer(f, chunk_size=4096, compression=CompressionType.ZSTD)
        imu = writer.register_msgdef("sensor_msgs/msg/Imu", IMU)
        distance = writer.register_msgdef("sensor_msgs/msg/Range", RANGE)
        motors = writer.register_msgdef("px4_msgs/msg/ActuatorMotors", MOTORS)
        for k in range(COUNT):
            # The recorder is late by up to 3 ms.
            log = START + 4_000_000 * k + int(RNG.integers(0, 3_000_000))
            q, a = RNG.normal(size=4), RNG.normal(size=3)
            writer.write_message("/imu/data", imu, {
                "header": header(k),
                "orientation": dict(zip("xyzw", q.tolist())),
                "orientation_covariance": RNG.normal(size=9).tolist(),
                "linear_acceleration": dict(zip("xyz", a.tolist())),
            }, log_time=log, publish_time=log, sequence=k)
            if k % 10 == 0:
                # A sensor whose clock counts from its start: of no use here.
                writer.write_message("/range", distance, {
                    "header": header(k, offset_ns=START - 5), "radiation_type": 1,
                    "field_of_view": 0.1, "range": float(RNG.normal()),
                }, log_time=log + 1, publish_time=log, sequence=k)
            if k % 2 == 0:
                control = RNG.uniform(size=12)
                control[4:] = math.nan
                writer.write_message("/fmu/out/actuator_motors", motors, {
                    "timestamp": 1_000_000 + 4000 * k, "control": control.tolist(), "ok": k % 4 == 0,
                    "any": [int(n) for n in RNG.integers(-99, 99, size=k % 20)],
                    "names": ["a", "bc"][: k % 3],
                }, log_time=log + 2, publish_time=log, sequence=k)
        writer.finish()


def read_mcap(path):
    with open(path, "rb") as f:
        reader = make_reader(f, decoder_factories=[DecoderFactory()])
        for schema, channel, message in reader.iter_messages(log_time_order=False):
            if channel.message_encoding == "json":
                yield channel.topic, json.loads(message.data)
            elif channel.message_encoding == "cdr":
                decoder = DecoderFactory().decoder_for(channel.message_encoding, schema)
                yield channel.topic, decoder(message.data)


def json_mcap(path):
    with open(path, "wb") as f:
        writer = Writer(f, chunk_size=2048, compression=CompressionType.LZ4)
        writer.start()
        schema = writer.register_schema("touchdown.Vehicle", "jsonschema", b'{"type": "object"}')
        channel = writer.register_channel("/vehicle", "json", schema)
        other = writer.register_channel("/note", "protobuf", 0)
        for k in range(COUNT):
            value = {
                "velocity_mps": {"x": float(RNG.normal()), "z": float(RNG.normal())},
                "throttle": RNG.uniform(size=4).tolist(),
                "landed": k > 50,
                "phase": "final",
            }
            if k > 30:
                value["height_m"] = float(RNG.normal())
            writer.add_message(channel, START + 10_000_000 * k, json.dumps(value).encode(), START, k)
            writer.add_message(other, START + 10_000_000 * k, b"\x01\x02", START, k)
        writer.finish()


def bag(path, compression):
    store = get_typestore(Stores.ROS1_NOETIC)
    path.unlink(missing_ok=True)
    writer = BagWriter(path)
    if compression:
        writer.set_compression(compression)
    with writer:
        imu = writer.add_connection("/imu", "sensor_msgs/msg/Imu", typestore=store)
        array = writer.add_connection("/array", "std_msgs/msg/Float64MultiArray", typestore=store)
        types = store.types
        vector, quaternion = types["geometry_msgs/msg/Vector3"], types["geometry_msgs/msg/Quaternion"]
        for k in range(COUNT):
            stamp = START + 5_000_000 * k
            head = types["std_msgs/msg/Header"](
                seq=k, stamp=types["builtin_interfaces/msg/Time"](sec=stamp // 10**9, nanosec=stamp % 10**9),
                frame_id="imu")
            message = types["sensor_msgs/msg/Imu"](
                header=head, orientation=quaternion(*RNG.normal(size=4)),
                orientation_covariance=RNG.normal(size=9), angular_velocity=vector(*RNG.normal(size=3)),
                angular_velocity_covariance=RNG.normal(size=9),
                linear_acceleration=vector(*RNG.normal(size=3)),
                linear_acceleration_covariance=RNG.normal(size=9))
            writer.write(imu, stamp + 1_000_000, store.serialize_ros1(message, imu.msgtype))
            if k % 3 == 0:
                layout = types["std_msgs/msg/MultiArrayLayout"](dim=[], data_offset=k)
                message = types["std_msgs/msg/Float64MultiArray"](layout=layout, data=RNG.normal(size=k % 5))
                writer.write(array, stamp, store.serialize_ros1(message, array.msgtype))


def read_bag(path):
    store = get_typestore(Stores.ROS1_NOETIC)
    with BagReader(path) as reader:
        for connection, _, data in reader.messages():
            yield connection.topic, store.deserialize_ros1(data, connection.msgtype)


def parquet(path):
    rows = 1000
    thrust = RNG.normal(size=rows)
    table = pa.table({
        "time_s": np.arange(rows) * 0.01,
        "thrust_n": pa.array(thrust, mask=np.arange(rows) % 7 == 0),
        "count": pa.array(np.arange(rows) % 200, pa.uint8()),
        "throttle": pa.array(RNG.uniform(size=rows), pa.float32()),
        "at": pa.array(START + np.arange(rows) * 10_000_000, pa.timestamp("ns")),
        "name": ["up", "down"] * (rows // 2),
        "pair": [[1.0, 2.0]] * rows,
    })
    pq.write_table(table, path, row_group_size=300, compression="zstd", write_page_checksum=True)
    for name in ["time_s", "thrust_n", "count", "throttle"]:
        values = table[name].to_numpy(zero_copy_only=False).astype(float)
        values = values[np.isfinite(values)]
        yield name, len(values), math.fsum(values)


def repacked(path, **how):
    """The first rows of `table.parquet`, packed in another way."""
    table = pq.read_table(HERE / "table.parquet").slice(0, 400)
    pq.write_table(table, path, row_group_size=200, write_page_checksum=True, **how)


def lines(file, messages):
    found = {}
    for topic, message in messages:
        flatten(message, "", lambda name, value: found.setdefault((topic, name), []).append(value))
    for (topic, name), values in found.items():
        # ROS 1 calls it so.
        if file.endswith(".bag"):
            name = name.replace("nanosec", "nsec")
        values = [v for v in values if math.isfinite(v)]
        yield f"{file}\t{topic}\t{name}\t{len(values)}\t{math.fsum(values)!r}\n"


HERE.mkdir(exist_ok=True)
ros2(HERE / "ros2.mcap")
json_mcap(HERE / "json.mcap")
for name, compression in [
    ("plain", None), ("bz2", BagWriter.CompressionFormat.BZ2), ("lz4", BagWriter.CompressionFormat.LZ4)
]:
    bag(HERE / f"{name}.bag", compression)
with open(Path(__file__).parent / "fields.tsv", "w") as out:
    for file in ["ros2.mcap", "json.mcap"]:
        out.writelines(lines(file, read_mcap(HERE / file)))
    for file in ["plain.bag", "bz2.bag", "lz4.bag"]:
        out.writelines(lines(file, read_bag(HERE / file)))
    for name, count, total in parquet(HERE / "table.parquet"):
        out.write(f"table.parquet\t\t{name}\t{count}\t{total!r}\n")
repacked(HERE / "snappy.parquet", compression="snappy")
# Pages of the second version: their levels are not packed. Those that packing does not shrink are plain.
repacked(HERE / "zstd_v2.parquet", compression="zstd", data_page_version="2.0", data_page_size=1000)
# What no reader takes.
REFUSED = HERE.parent / "refused"
REFUSED.mkdir(exist_ok=True)
repacked(REFUSED / "brotli.parquet", compression="brotli")
pq.write_table(pa.table({"time_s": pa.array([], pa.float64())}), REFUSED / "no_rows.parquet")
# Decimal fractions in 4, 8 and 16 bytes, as databases and spreadsheets write them.
numbers = [None if i % 7 == 0 else Decimal(i - 10) / 8 for i in range(20)]
decimals = {
    f"of_{digits}": pa.array(numbers, pa.decimal128(digits, 3)) for digits in [9, 18, 38]
}
pq.write_table(
    pa.table({"time_s": [0.1 * i for i in range(20)], **decimals}),
    HERE / "decimal.parquet",
    store_decimal_as_integer=True,
)
