"""What the tests of the application share."""

from __future__ import annotations

import functools
from collections.abc import Iterator
from typing import Any

import pytest

from holonom import vision


@pytest.fixture(autouse=True, scope="session")
def each_photograph_is_looked_at_once() -> Iterator[None]:
    """A photograph that many cells show is searched for coins once in this process, not once for each cell."""
    found: dict[Any, Any] = {}
    search = vision.find_coins

    @functools.wraps(search)
    def once(image: Any, *more: Any) -> Any:
        key = image.tobytes(), image.shape, more
        if key not in found:
            found[key] = search(image, *more)
        return found[key]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(vision, "find_coins", once)
        yield
