"""Fixtures that several test folders share: reference data, peer libraries, the Hypothesis profile."""

from __future__ import annotations

import os
import warnings
from pathlib import Path
from types import ModuleType

import pytest
from hypothesis import settings

ROOT = Path(__file__).resolve().parents[1]

settings.register_profile("holonom", deadline=None, print_blob=True, max_examples=50)
settings.load_profile("holonom")


@pytest.fixture(scope="session")
def root() -> Path:
    """Root of the repository."""
    return ROOT


@pytest.fixture(scope="session")
def data_folder() -> Path:
    """Folder with the published reference data: HOLONOM_DATA, or `shared/data` beside the repository."""
    folder = Path(os.environ.get("HOLONOM_DATA", ROOT.parent / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip(f"no reference data in {folder}; set HOLONOM_DATA to the folder that holds them")
    return folder.resolve()


@pytest.fixture(scope="session")
def pinocchio() -> ModuleType:
    """Pinocchio (package `pin`)."""
    return _peer("pinocchio")


@pytest.fixture(scope="session")
def eaik() -> ModuleType:
    """Closed-form inverse kinematics by subproblem decomposition, with its DH robots loaded."""
    _peer("eaik.IK_DH")
    return _peer("eaik")


@pytest.fixture(scope="session")
def roboticstoolbox() -> ModuleType:
    """Corke's robotics toolbox."""
    return _peer("roboticstoolbox")


def _peer(name: str) -> ModuleType:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # warnings of the peer's own imports are not our errors
        return pytest.importorskip(
            name, reason=f"peer {name} is not installed; pip install 'holonom[oracle]'", exc_type=ImportError
        )
