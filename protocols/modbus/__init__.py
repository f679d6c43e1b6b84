"""Modbus TCP, server side: framing (mbap), validation (validate), answers (answering) and their source (view).

Sources: MODBUS Application Protocol Specification V1.1b3 (below: V1.1b3) and MODBUS Messaging on TCP/IP Implementation Guide V1.0b
(below: TCP guide).  Broadcasting exists on serial lines only: on TCP unit 0 is this server itself and is answered (AX-012).
"""
