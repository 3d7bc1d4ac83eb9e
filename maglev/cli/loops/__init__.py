"""Commands about loops: linear models, measured responses, regions of stability."""
