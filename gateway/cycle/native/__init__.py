"""The hot part of the cycle in C, behind its Python twins (AX-320); built by `python -m gateway.cycle.native.build`, never needed."""
