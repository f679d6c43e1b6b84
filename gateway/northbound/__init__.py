"""Values for higher-level systems: MQTT, OPC UA, Prometheus, journald.  Read only, a process of its own, off by default."""
