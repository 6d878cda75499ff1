"""Recordings: what a run says while it runs, as an MCAP file of ROS 2 messages.

Writing
    `Recorder`: a `signals.Sink`; a context manager that leaves a valid file on every way out.
Reading
    `read_recording`: the file as arrays, a `Recording` of `JointTrack`, `DriveTrack` and `FrameTrack`.
Inside
    `cdr` (the byte layout of a message), `messages` (which message has which layout),
    `schemas` (the texts of the message definitions).

Topics, all stamped with simulated time:

==================  ==================================  ==========================================
topic               type                                content
==================  ==================================  ==========================================
/joint_states       sensor_msgs/msg/JointState          measured position, velocity, effort
/joint_reference    sensor_msgs/msg/JointState          reference position and velocity
/motor_current      std_msgs/msg/Float64MultiArray      armature currents (A), axis by axis
/motor_voltage      std_msgs/msg/Float64MultiArray      armature voltages (V), axis by axis
/tf                 tf2_msgs/msg/TFMessage              world to every frame
/tool_pose          geometry_msgs/msg/PoseStamped       world to the frame "tool"
/signals/<number>   std_msgs/msg/Bool                   a digital signal, each time it changes
/rosout             rcl_interfaces/msg/Log              events, with the program line
==================  ==================================  ==========================================
"""

from holonom.app.recording.reader import read_recording
from holonom.app.recording.recorder import Recorder
from holonom.app.recording.tracks import DriveTrack, FrameTrack, JointTrack, Recording

__all__ = ["DriveTrack", "FrameTrack", "JointTrack", "Recorder", "Recording", "read_recording"]
