"""Nominal values and printed tables of the paper."""

NOMINAL = {"Ms": 3899.0, "Fvs": 3949.17, "Ks": 1e9, "Mm": 362.58, "Fvm": 88.6, "Fsm": 146.0}
CUTOFF = 164.42
METHODS = {1: ("q2",), 2: ("q2", "ddq1"), 3: ("q2", "ddq1", "ddq2")}
PHYSICAL = ("Mm", "Fvm", "Ms", "Fvs", "Ks")
Printed = dict[str, tuple[float, float]]
"""Estimate and error in percent, by parameter."""
TABLE_2: Printed = {
    "Mm": (362.5831, 0.0008), "Fvm": (88.6088, 0.01),
    "Ms": (3899.0336, 0.0008), "Fvs": (3949.2115, 0.0008), "Ks": (1e9, 0.0008),
}  # fmt: skip
TABLE_3: Printed = {  # X3 is printed as 88.8679; its error and Table 4 give 88.8670
    "X1": (4.2672e-6, 0.1324), "X2": (3.9232e-6, 0.6560), "X3": (88.8670, 0.3014),
    "X4": (362.6042, 0.0065), "X5": (1.8275e-3, 0.9999), "X6": (1.4157e-3, 0.1437),
}  # fmt: skip
TABLE_4: Printed = {
    "Mm": (362.6038, 0.0065), "Fvm": (88.8670, 0.3014),
    "Ms": (3901.3761, 0.0609), "Fvs": (3920.2865, 0.7315), "Ks": (9.9923e8, 0.0760),
}  # fmt: skip
TABLE_5_INITIAL: Printed = {
    "Mm": (362.6263, 0.0127), "Fvm": (89.2246, 0.7049),
    "Ms": (3904.1615, 0.1323), "Fvs": (3975.4013, 0.6640), "Ks": (1e9, 0.0207),
}  # fmt: skip
TABLE_5: Printed = {
    "Mm": (362.6308, 0.0140), "Fvm": (89.4860, 1.0),
    "Ms": (3904.5438, 0.1421), "Fvs": (3980.1822, 0.7851), "Ks": (1e9, 0.0198),
}  # fmt: skip
TABLE_6_INITIAL: Printed = {
    "Mm": (362.5827, 0.0007), "Fvm": (88.6377, 0.0426),
    "Ms": (3904.6587, 0.1451), "Fvs": (3982.7667, 0.8505), "Ks": (1e9, 0.0196),
}  # fmt: skip
TABLE_6: Printed = {
    "Mm": (362.5826, 0.0007), "Fvm": (88.6436, 0.0492),
    "Ms": (3904.9112, 0.1516), "Fvs": (3988.6697, 1.0), "Ks": (1e9, 0.0180),
}  # fmt: skip
TABLE_7: Printed = {  # X6 is printed as 14158e-3
    "X1": (4.2559e-6, 0.1321), "X2": (3.9689e-6, 0.4996), "X3": (88.5999, 0.00008),
    "X4": (362.5834, 0.0008), "X5": (1.7862e-3, 1.2814), "X6": (1.4158e-3, 0.1518),
}  # fmt: skip
TABLE_8: Printed = {
    "Mm": (362.5831, 0.0008), "Fvm": (88.5999, 0.00008),
    "Ms": (4033.0249, 3.4374), "Fvs": (4099.1476, 3.7975), "Ks": (1.0328e9, 3.2814),
}  # fmt: skip
TABLE_9: Printed = {  # the error of X3 is printed as 00593; X5 and X6 are cut, not rounded
    "X1": (6.5465e-5, 1436.1802), "X2": (3.3820e-6, 14.36), "X3": (88.6525, 0.0593),
    "X4": (362.6873, 0.0295), "X5": (0.0069, 286.7954), "X6": (0.0220, 1462.4642),
}  # fmt: skip
TABLE_10: Printed = {  # Ks is printed as 7.9483e9; its error gives 7.9483e7
    "Mm": (362.6870, 0.0295), "Fvm": (88.6525, 0.0593),
    "Ms": (4840.7356, 24.1532), "Fvs": (268.8187, 93.1930), "Ks": (7.9483e7, 92.0516),
}  # fmt: skip
TABLE_11: Printed = {"M": (364.5966, 0.5562), "Fv": (88.0911, 0.5743), "Fs": (148.2109, 1.5143)}
LAST_DIGITS = {  # of minimal parameters as printed in Tables 3, 7 and 9
    3: (1e-10, 1e-10, 1e-4, 1e-4, 1e-7, 1e-7),
    7: (1e-10, 1e-10, 1e-4, 1e-4, 1e-7, 1e-7),
    9: (1e-9, 1e-10, 1e-4, 1e-4, 1e-4, 1e-4),
}  # fmt: skip
