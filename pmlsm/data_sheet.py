"""Data sheets of the motor and of the two rigs (Tables 4.1 and 5.1, sections 4.1 and 5.1). SI units."""

# The motor, the same on both rigs.
SLOT_WIDTH = 12.7e-3         # b0, m
SLOT_PITCH = 19.05e-3        # t1, m
POLE_PITCH = 57.15e-3        # tau, m
MAGNET_HEIGHT = 5.0e-3       # hm, m
RECOIL_PERMEABILITY = 1.05   # mu_rec, assumed: the thesis gives no value
GRAVITY = 9.81               # G, m/s²

ENCODER_RESOLUTION = 10.0e-6   # m, sections 4.1.2 and 5.1.2

# 2-DOF rig: one motor, vertical axis v, horizontal axis h.
SAMPLE_TIME_2DOF = 0.5e-3      # s, 2 kHz, section 4.1.4
MASS_V = 4.350                 # kg
MASS_H = 1.594                 # kg
PEAK_CURRENT_2DOF = 9.0        # A, section 4.1.3
CONTINUOUS_CURRENT_2DOF = 7.0  # A

# 3-DOF rig: motor pair alpha drives x, pair beta drives z, both carry y.
MOTORS_IN_PAIR = 2.0           # with one current
MOTORS_3DOF = 4.0
SAMPLE_TIME_3DOF = 0.2e-3      # s, 5 kHz, section 5.1.4
MASS_Y = 6.9                   # kg
MASS_X = 10.6                  # kg
MASS_Z = 8.6                   # kg
PEAK_CURRENT_3DOF = 5.0        # A, section 5.1.3
CONTINUOUS_CURRENT_3DOF = 4.0  # A
