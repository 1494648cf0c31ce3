"""The check of finished gaits. It shares no code with the graph that makes them."""
