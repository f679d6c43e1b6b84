"""Programs of the Reis ROBOTstar V: memory, reader, checker, interpreter, COPY, pallets, TRAFO_6D.  Source: robotstar 1, 2, 6, 7."""
