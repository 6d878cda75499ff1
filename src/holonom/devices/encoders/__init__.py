"""Encoders: from an angle to counts, and back to angle and speed (specification 03.3).

======================  ========================================================================
`incremental`           counts per turn, the 16-bit counter and the observer of the servos
`quadrature`            every edge of A, B and index, with faults; decoder; line receivers
`counters`              12 to 32 bits; what the index finds lost
`sincos`                1 Vpp signals, interpolation, Heydemann's correction
`homing`                potentiometer or switch, and index
`frames`                Gray code; SSI, EnDat-like, BiSS-C
`speeds`                M, T, M/T, PLL, observer
======================  ========================================================================
"""

__all__: list[str] = []
