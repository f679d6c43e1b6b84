"""The VAL 3 view of the process image: dio, aio, their links and states.  Source: val3 3.5."""
