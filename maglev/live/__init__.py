"""The live stage: one HTML page that flies plants and controllers, as WebAssembly, in a browser."""
