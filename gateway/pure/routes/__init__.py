"""Routes: values joined across command sources, images, blocks and contacts, with the reaction to a lost source.  Pure."""
