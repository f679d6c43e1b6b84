"""The pendant (PHG) of a ROBOTstar V."""
