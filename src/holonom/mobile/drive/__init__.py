"""What drives a base (specification 06.2): couplings, idle patterns, envelopes, slip, failed motors."""

__all__: list[str] = []
