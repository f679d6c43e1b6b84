"""What `axisgate doctor` measures: echo of adapters, and how late this machine is."""
