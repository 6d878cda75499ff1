"""`holonom doctor`: what is installed and what is missing."""

from __future__ import annotations

from dataclasses import dataclass

from holonom.app.console.answer import Answer
from holonom.app.console.options import option
from holonom.registry import OWN, Method

__all__ = ["COMMAND", "Options", "run"]


@dataclass(frozen=True, kw_only=True)
class Options:
    """A look inside instead of the examination; one at most."""

    show_kernel: str | None = option(
        None, 'print generated code, such as "puma560.inverse_dynamics"', metavar="NAME", either="instead"
    )
    schema: bool = option(False, "print the JSON Schema of cell files", either="instead")
    empty_cache: bool = option(False, "remove all compiled kernels", either="instead")


def run(options: Options) -> Answer:
    """Examine; raises as `show_kernel` does."""
    from holonom.app.about import doctor

    if options.schema:
        return doctor.schema()
    if options.show_kernel is not None:
        return doctor.show_kernel(options.show_kernel)
    return doctor.empty_cache() if options.empty_cache else doctor.examine()


COMMAND = Method("say what is installed and what is missing", run, OWN, Options)
