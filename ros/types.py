"""Message types of ROS 2 as they appear in keys and tokens of rmw_zenoh: their names and their hashes."""

TWIST = "geometry_msgs/Twist"
TWIST_STAMPED = "geometry_msgs/TwistStamped"
ODOMETRY = "nav_msgs/Odometry"
POSE_STAMPED = "geometry_msgs/PoseStamped"
TF = "tf2_msgs/TFMessage"
PATH = "nav_msgs/Path"
MARKERS = "visualization_msgs/MarkerArray"
TURTLE_POSES = ("turtlesim/Pose", "turtlesim_msgs/Pose")
"""Of turtlesim, under its name until Jazzy and from Kilted on."""

COMMANDS = (TWIST, TWIST_STAMPED)
"""What a robot takes on cmd_vel."""
POSES = (POSE_STAMPED, ODOMETRY, TF, *TURTLE_POSES)
"""What says where a robot is; which is taken if a robot has several, in this order."""

HASHES = {
    TWIST: "RIHS01_9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a",
    TWIST_STAMPED: "RIHS01_5f0fcd4f81d5d06ad9b4c4c63e3ea51b82d6ae4d0558f1d475229b1121db6f64",
    ODOMETRY: "RIHS01_3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0",
    POSE_STAMPED: "RIHS01_10f3786d7d40fd2b54367835614bff85d4ad3b5dab62bf8bca0cc232d73b4cd8",
    TF: "RIHS01_e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087",
    PATH: "RIHS01_1957a5bb3cee5da65c4e52e52b65a93df227efce4c20f8458b36e73066ca334b",
    MARKERS: "RIHS01_86cb8800b6fb05b5eff1abd7a56f62a5641d3ae9a1c29e78e67e704f1d067dcf",
}
"""Of the types that we publish: the same from Iron to Lyrical."""
NO_HASH = "TypeHashNotSupported"
"""What Humble has instead."""


def distribution(type_hash: str) -> str:
    """Which distribution a node with this hash in its token is of."""
    return "Humble" if type_hash == NO_HASH else "Iron or newer"


def dds_name(kind: str) -> str:
    """Of a type such as "geometry_msgs/Twist": "geometry_msgs::msg::dds_::Twist_"."""
    package, _, name = kind.partition("/")
    return f"{package}::msg::dds_::{name}_"


def kind_of(name: str) -> str:
    """The type of a DDS name; the name as it is if it is none of a message."""
    package, middle, last = name.partition("::msg::dds_::")
    return f"{package}/{last.removesuffix('_')}" if middle else name
