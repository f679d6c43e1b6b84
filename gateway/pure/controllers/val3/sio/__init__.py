"""VAL 3 sio: what a program sees of a serial line, a TCP client, a TCP server and a UDP socket.

Source: VAL 3 reference manual, version 8, section 3.7 (below: 3.7).  Pure: `core.SioCore` holds variables, connections, buffers and
waiting instructions; it orders connections from an adapter (gateway.links.serial.val3_channels) and is informed of the results, with
the time.
"""
