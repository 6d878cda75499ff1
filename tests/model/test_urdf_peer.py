"""Every robot that Pinocchio reads is read, and its links stand where Pinocchio puts them."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from shipped import shipped_robots

from holonom.errors import ModelError, ModelWarning
from holonom.mechanics.equations.kinematics import frames
from holonom.model import read_urdf

pytestmark = pytest.mark.oracle


def peer_of(pinocchio, file):
    """Pinocchio's model; None where it reads none, or nothing in it moves."""
    try:
        model = pinocchio.buildModelFromUrdf(str(file))
    except (RuntimeError, ValueError):
        return None
    return model if model.nq > 0 else None


def positions(model, q):
    """Of all joints, those that follow too, by name."""
    every = np.zeros(len(model.joints))
    every[list(model.independent)] = q
    for i, joint in enumerate(model.joints):
        if joint.mimic is not None:
            every[i] = joint.mimic.multiplier * every[joint.mimic.joint] + joint.mimic.offset
    return dict(zip((joint.name for joint in model.joints), every, strict=True))


def theirs(pinocchio, peer, at):
    """Pinocchio's q; continuous joints are (cos, sin), planar ones (x, y, cos, sin), floating ones stay."""
    q = pinocchio.neutral(peer)
    for name, joint in zip(list(peer.names)[1:], list(peer.joints)[1:], strict=True):
        if f"{name}.turn" in at:
            angle = at[f"{name}.turn"]
            q[joint.idx_q : joint.idx_q + 4] = at[f"{name}.x"], at[f"{name}.y"], np.cos(angle), np.sin(angle)
        elif joint.nq == 2:
            q[joint.idx_q : joint.idx_q + 2] = np.cos(at[name]), np.sin(at[name])
        elif joint.nq == 1:
            q[joint.idx_q] = at[name]
    return q


def pose_of(R, p):
    return np.block([[np.array(R), np.array(p)[:, None]], [np.zeros(3), 1.0]])


def compare(pinocchio, peer, model):
    own = [frame for frame in model.frames if peer.existFrame(frame.name, pinocchio.BODY)]
    assert own
    for seed in range(2):
        q = np.random.default_rng(seed).uniform(-1.0, 1.0, len(model.independent))
        data = peer.createData()
        pinocchio.framesForwardKinematics(peer, data, theirs(pinocchio, peer, positions(model, q)))
        placed = [
            np.block([[np.array(R), np.array(p)[:, None]], [np.zeros(3), 1.0]]) for R, p in frames(model, q.tolist())
        ]
        for frame in own:
            expected = data.oMf[peer.getFrameId(frame.name, pinocchio.BODY)].homogeneous
            got = placed[frame.joint + 1] @ np.array(frame.pose)
            np.testing.assert_allclose(got, expected, rtol=0.0, atol=1e-9, err_msg=frame.name)


def test_shipped_robots_stand_where_pinocchio_puts_them(pinocchio, data_folder):
    files = shipped_robots(data_folder)
    if not files:
        pytest.skip("no robot files: neither the data folder nor example-robot-data nor rtb-data is here")
    read = 0
    for file in files:
        peer = peer_of(pinocchio, file)
        if peer is None:
            continue
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ModelWarning)
            compare(pinocchio, peer, read_urdf(file))
        read += 1
    assert read >= 9


def test_what_pinocchio_makes_of_oddities(pinocchio):
    """Of each file that the strict check refuses: what Pinocchio reads is read, and stands where it puts it."""
    from test_urdf import BAD

    refused = {
        "axis", "ring apart", "closed chain", "carries itself", "bomb", "doctype", "all fixed", "fixed mimic", "xacro",
        "no joint", "only floating",
    }  # fmt: skip
    for case, (text, _, _) in BAD.items():
        try:
            peer = pinocchio.buildModelFromXML(text)
        except (RuntimeError, ValueError):
            continue
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ModelWarning)
            try:
                model = read_urdf(text)
            except ModelError:
                assert case in refused, case
                continue
        compare(pinocchio, peer, model)
