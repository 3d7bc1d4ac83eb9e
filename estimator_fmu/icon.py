"""Icon of the estimators: estimates that approach the value that is sought."""

VALUES = [(34 + 18 * k, 150 - height, 10, height, "#3050c0")
          for k, height in enumerate((30, 96, 66, 84, 74, 80, 78, 78))]

ESTIMATOR_ICON = (*VALUES, (26, 70, 150, 3, "#c03030"), (22, 40, 4, 116, "#404850"), (22, 152, 158, 4, "#404850"))
