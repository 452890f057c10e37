"""The message types of a record, as ROS 2 defines them, and our own: what the schemas of an MCAP file are made of."""

from collections.abc import Iterator

_TEXTS = {
    "builtin_interfaces/Time": "int32 sec\nuint32 nanosec",
    "builtin_interfaces/Duration": "int32 sec\nuint32 nanosec",
    "std_msgs/Header": "builtin_interfaces/Time stamp\nstring frame_id",
    "std_msgs/ColorRGBA": "float32 r\nfloat32 g\nfloat32 b\nfloat32 a",
    "geometry_msgs/Vector3": "float64 x\nfloat64 y\nfloat64 z",
    "geometry_msgs/Point": "float64 x\nfloat64 y\nfloat64 z",
    "geometry_msgs/Quaternion": "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1",
    "geometry_msgs/Pose": "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation",
    "geometry_msgs/PoseStamped": "std_msgs/Header header\ngeometry_msgs/Pose pose",
    "geometry_msgs/PoseWithCovariance": "geometry_msgs/Pose pose\nfloat64[36] covariance",
    "geometry_msgs/Twist": "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular",
    "geometry_msgs/TwistStamped": "std_msgs/Header header\ngeometry_msgs/Twist twist",
    "geometry_msgs/TwistWithCovariance": "geometry_msgs/Twist twist\nfloat64[36] covariance",
    "geometry_msgs/Transform": "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation",
    "geometry_msgs/TransformStamped": (
        "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform"
    ),
    "tf2_msgs/TFMessage": "geometry_msgs/TransformStamped[] transforms",
    "nav_msgs/Odometry": (
        "std_msgs/Header header\nstring child_frame_id\n"
        "geometry_msgs/PoseWithCovariance pose\ngeometry_msgs/TwistWithCovariance twist"
    ),
    "nav_msgs/Path": "std_msgs/Header header\ngeometry_msgs/PoseStamped[] poses",
    "rcl_interfaces/Log": (
        "builtin_interfaces/Time stamp\nuint8 level\nstring name\nstring msg\nstring file\nstring function\nuint32 line"
    ),
    "sensor_msgs/CompressedImage": "std_msgs/Header header\nstring format\nuint8[] data",
    "visualization_msgs/UVCoordinate": "float32 u\nfloat32 v",
    "visualization_msgs/MeshFile": "string filename\nuint8[] data",
    "visualization_msgs/Marker": (
        "std_msgs/Header header\nstring ns\nint32 id\nint32 type\nint32 action\ngeometry_msgs/Pose pose\n"
        "geometry_msgs/Vector3 scale\nstd_msgs/ColorRGBA color\nbuiltin_interfaces/Duration lifetime\n"
        "bool frame_locked\ngeometry_msgs/Point[] points\nstd_msgs/ColorRGBA[] colors\nstring texture_resource\n"
        "sensor_msgs/CompressedImage texture\nvisualization_msgs/UVCoordinate[] uv_coordinates\nstring text\n"
        "string mesh_resource\nvisualization_msgs/MeshFile mesh_file\nbool mesh_use_embedded_materials"
    ),
    "visualization_msgs/MarkerArray": "visualization_msgs/Marker[] markers",
    "echelon_msgs/Metrics": (
        "std_msgs/Header header\nfloat64 tracking_error\nfloat64[] distance_error\nfloat64[] angle_error"
    ),
    "echelon_msgs/Link": (
        "std_msgs/Header header\nstring link\nfloat64 age\nuint64 sent\nuint64 delivered\nuint64 lost\nuint64 late\n"
        "uint64 corrupt\nfloat64 solve\nfloat64 gap\nfloat64 way_age\nbool way_over"
    ),
    "echelon_msgs/Fault": (
        "std_msgs/Header header\nstring link\nfloat64 latency\nfloat64 jitter\nfloat64 loss\nfloat64 burst\n"
        "float64 duplicate\nfloat64 reorder\nfloat64 rate\nfloat64 corrupt\nfloat64 cut"
    ),
    "echelon_msgs/Contacts": "std_msgs/Header header\nfloat64 clearance\nfloat64 gap",
    "echelon_msgs/Ticks": "uint64 first\nuint32 robots\nfloat64[] poses\nfloat64[] inputs",
    "echelon_msgs/Checks": "uint64 first\nuint32 robots\nuint32[] sums",
    "echelon_msgs/Excursion": (
        "std_msgs/Header header\nuint32 number\nuint32 robot\nfloat64 peak\nfloat64 peak_at\nfloat64 until\n"
        "float64 recovery\nstring cause\nfloat64 cause_at"
    ),
    "echelon_msgs/Order": "uint64 number\nuint64 tick\nstring kind\nstring value",
    "echelon_msgs/Wire": "string key\nuint8[] payload",
}
_LINE = "=" * 80


def schema(name: str) -> str:
    """The definition of a type such as "nav_msgs/Path", followed by those of every type that it is made of."""
    parts = [f"{_LINE}\nMSG: {part}\n{_TEXTS[part]}\n" for part in dict.fromkeys(_parts(name))]
    return "".join([f"{_TEXTS[name]}\n", *parts])


def _parts(name: str) -> Iterator[str]:
    for line in _TEXTS[name].splitlines():
        part = line.split()[0].split("[")[0]
        if "/" in part:
            yield part
            yield from _parts(part)


def full_name(name: str) -> str:
    """As MCAP has it: "nav_msgs/msg/Path"."""
    package, _, kind = name.partition("/")
    return f"{package}/msg/{kind}"
