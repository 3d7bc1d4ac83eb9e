"""The live stage: one HTML page that runs plants and controllers, as WebAssembly, in a browser."""
