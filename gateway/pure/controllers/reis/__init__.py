"""The Reis ROBOTstar V view of the process image: 40 bytes each way, markers, analog values.  Source: robotstar 4, 5.8."""
