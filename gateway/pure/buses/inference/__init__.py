"""What a recording of a living drive bus tells about its layout: fields, what they are, how sure that is.  Pure."""
