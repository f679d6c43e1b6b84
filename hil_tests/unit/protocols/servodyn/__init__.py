"""SERVODYN telegrams: layout, identifiers, DBC."""
