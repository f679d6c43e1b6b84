"""BAPS2, the language of rho 3 programs (rho 3 releases, all parts)."""
