"""Arctangent within 0.85 ULP, of every number, and its integral within 4.5 ULP.

arctan x = arctan p + arctan((x − p)/(1 + p x)) for the nearest of p = 0, ½, 1, 1½, ∞, then x − x³ N(x²)/D(x²) on
±7/16. The integral is x² N(x²)/D(x²) to 0.8. Both rational functions interpolate at Chebyshev points.
"""

from pmlsm.logarithm import logarithm_one_plus

TINY_TANGENT = 7.450580596923828e-09   # 2^-27: an arctangent is its argument


def arctangent(x: float) -> float:
    """Angle (rad, −π/2 to π/2) with a tangent."""
    if -0.4375 < x < 0.4375:
        if -TINY_TANGENT < x < TINY_TANGENT:
            return x
        return x - correction(x)
    size = x if x > 0.0 else -x
    if size < 0.6875:
        t = (2.0 * size - 1.0) / (2.0 + size)
        angle = 0.4636476090008061 - ((correction(t) - 2.2698777452961687e-17) - t)
    elif size < 1.1875:
        t = (size - 1.0) / (size + 1.0)
        angle = 0.7853981633974483 - ((correction(t) - 3.061616997868383e-17) - t)
    elif size < 2.4375:
        t = (size - 1.5) / (1.0 + 1.5 * size)
        angle = 0.982793723247329 - ((correction(t) - 1.3903311031230998e-17) - t)
    else:
        t = -1.0 / size
        angle = 1.5707963267948966 - ((correction(t) - 6.123233995736766e-17) - t)
    return angle if x > 0.0 else -angle


def arctangent_integral(x: float) -> float:
    """∫ arctan from 0 to x, x arctan x − ln(1 + x²)/2: its terms cancel where x is small."""
    z = x * x
    if z > 0.64:
        return x * arctangent(x) - 0.5 * logarithm_one_plus(z)
    return z * ((0.5 + z * (1.1224664024446644 + z * (0.889629304971278 + z * (0.2968837339532207 + z * (
        0.03844158244541347 + z * 0.0013030294032398216))))) / (1.0 + z * (2.411599471555994 + z * (
            2.1145251885353384 + z * (0.8211293202692626 + z * (0.13667603609303453 + z * (
                0.007722615385431624 + z * 6.234433374196509e-05)))))))


def correction(x: float) -> float:
    """x − arctan x for |x| up to 7/16."""
    z = x * x
    return x * z * ((0.3333333333333333 + z * (0.5557388167461695 + z * (0.27359401142243295 + z * (
        0.03769324398969281 + z * 0.0001755769018725249)))) / (1.0 + z * (2.2672164502385006 + z * (
            1.7525404758401062 + z * (0.5262731577845076 + z * 0.04821339579780248)))))
