"""Elementary functions of +, −, ×, ÷ and √ alone: the same bits on every processor.

IEEE 754 rounds these operations in one way everywhere; sines and exponentials it leaves to libraries, which differ in
the last bit. Each module has its method, range and largest error; `tests/pmlsm/elementary` measures the errors.
"""
