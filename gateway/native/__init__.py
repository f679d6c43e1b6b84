"""The hot part of the cycle in C, behind its Python twins (AX-320); built by `python -m gateway.native.build`, never needed."""
