"""The time-critical part of the cycle in C, equal to its Python twins (AX-320); built by `python -m
gateway.cycle.native.build`, optional.
"""
