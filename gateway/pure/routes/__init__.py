"""Routes: values joined across doors, images, blocks and contacts, with what happens when a source is lost.  Pure."""
