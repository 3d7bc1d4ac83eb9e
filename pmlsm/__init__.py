"""The iron-cored PMLSM as plant and controller both model it: geometry, gap functions, dq transform."""
