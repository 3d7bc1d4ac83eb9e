"""The Python functions of this package: the commands call them, and `import maglev` offers them."""
