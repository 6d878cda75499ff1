"""Recordings: what a run says while it runs, as an MCAP file of ROS 2 messages.

Writing
    `Recorder`: a `signals.Sink`; a context manager that leaves a valid file on every way out.
Reading
    `read_recording`: the file as arrays, a `Recording` of `JointTrack`, `DriveTrack`, `BaseTrack`, `ContactTrack`
    and `FrameTrack`.
Inside
    `cdr` (the byte layout of a message), `messages` (which message has which layout),
    `schemas` (the texts of the message definitions).

Topics, all stamped with simulated time, each there from its first message on:

==================  ==================================  ==========================================
topic               type                                content
==================  ==================================  ==========================================
/joint_states       sensor_msgs/msg/JointState          measured position, velocity, effort
/joint_reference    sensor_msgs/msg/JointState          reference position and velocity
/motor_current      std_msgs/msg/Float64MultiArray      armature currents (A), axis by axis
/motor_voltage      std_msgs/msg/Float64MultiArray      armature voltages (V), axis by axis
/tf                 tf2_msgs/msg/TFMessage              world to every frame
/tool_pose          geometry_msgs/msg/PoseStamped       world to the frame "tool"
/odom               nav_msgs/msg/Odometry               where a mobile base believes to be, and its twist
/base_reference     nav_msgs/msg/Odometry               where it should be
/imu                sensor_msgs/msg/Imu                 turning rate and acceleration on base_link
/wheel_force        std_msgs/msg/Float64MultiArray      driving force of each wheel (N)
/wheel_slip         std_msgs/msg/Float64MultiArray      rim speed over the ground (m/s)
/wheel_residual     std_msgs/msg/Float64MultiArray      rim speed that no twist explains (m/s)
/signals/<number>   std_msgs/msg/Bool                   a digital signal, each time it changes
/rosout             rcl_interfaces/msg/Log              events, with the program line
==================  ==================================  ==========================================
"""

from holonom.app.recording.reader import read_recording
from holonom.app.recording.recorder import Recorder
from holonom.app.recording.tracks import BaseTrack, ContactTrack, DriveTrack, FrameTrack, JointTrack, Recording

__all__ = [
    "BaseTrack",
    "ContactTrack",
    "DriveTrack",
    "FrameTrack",
    "JointTrack",
    "Recorder",
    "Recording",
    "read_recording",
]
