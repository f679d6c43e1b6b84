"""Routes: values joined across command sources, images, blocks and contacts, with what happens when a source is lost.  Pure."""
