"""Description of the 2-DOF stage, from its file in `rigs`."""

import pmlsm.rig as rig

RIG = rig.Rig(
    name='2dof',
    title='2-DOF stage',
    text='levitated and driven by one iron-cored linear synchronous motor',
    axes=(
        rig.RigAxis(
            name='v',
            meaning='air gap',
            design=rig.AxisDesign(
                gains=(-1662.0, -65.0, -360360.0, -103350.0, -20332.0),
                pid=(-8.0, -12.0, 50.0),
                bandwidth=30.0),
            mass=4.35,
            start=0.02,
            stop=rig.Stop(lower=0.008, upper=0.028),
            bias=0.2,
            friction=rig.Friction(coulomb=2.0, presliding=0.0003, viscous=2.0)),
        rig.RigAxis(
            name='h',
            meaning='horizontal displacement',
            design=rig.AxisDesign(
                gains=(-1182.0, -55.0, -154440.0, -45128.0, -11924.0),
                pid=(-6.0, -16.0, 46.0),
                bandwidth=25.0),
            mass=1.594,
            start=0.0,
            stop=rig.Stop(lower=-0.07, upper=0.07),
            bias=0.1,
            friction=rig.Friction(coulomb=0.25, presliding=0.0003, viscous=1.0),
            ripple=rig.Ripple(period=0.01905)),
    ),
    motors=(
        rig.RigMotor(name='motor', drives='h', amplifier=rig.Amplifier(peak=9.0, continuous=7.0)),
    ),
    stage=rig.Constants(thrust={'h': 14.2}, attraction=791.0, coils=30.9, iron=0.12),
    model=rig.Constants(thrust={'h': 14.2}, attraction=796.99, coils=31.04, iron=0.07),
    estimator=rig.Estimator(
        guess=rig.Constants(thrust={'h': 7.1}, attraction=398.0, coils=15.5, iron=0.035),
        weight=rig.Constants(thrust={'h': 0.0001}, attraction=1e-06, coils=0.0001, iron=0.01)),
    design=rig.Design(current_limit=4.0, pid_current_limit=4.0),
    sample_time=0.0005,
    longest_step=0.00025,
    modulation=0.027,
    equation='(4.3)',
    experiment='2dof-setpoints',
    sources={
        'constants': 'those of the stage were identified on the vertical motion alone, those of the model all together',
        'law': '(4.12)',
        'linearisation': 'section 4.6.1',
        'sample_time': 'stated, section 4.1.4',
        'resolution': 'stated, section 4.1.2',
        'stage': 'stated, Table 4.2; assumed to be the true stage',
        'model': 'stated, Table 4.3',
        'axes.v.mass': 'stated, Table 4.1',
        'axes.h.mass': 'stated, Table 4.1',
        'axes.v.design.gains': 'stated, (4.17)',
        'axes.h.design.gains': 'stated, (4.17)',
        'axes.v.design.antiwindup_gain': 'none in the thesis',
        'axes.h.design.antiwindup_gain': 'none in the thesis',
        'axes.h.ripple.period': 'stated, Table 4.1',
        'axes.v.friction.coulomb': 'estimated: half of what was assumed, docs/estimation.md',
        'axes.h.friction.coulomb': 'estimated: half of what was assumed, docs/estimation.md',
        'motors.motor.amplifier': 'stated, section 4.1.3',
        'motors.motor.winding': 'estimated, docs/model.md',
        'design.current_limit': 'assumed, from the axes of Fig. 4.20',
        'design.pid_current_limit': 'assumed, as for the other controllers of this stage',
        'design.antiwindup': 'assumed: the thesis uses none on this stage',
        'estimator.guess': 'assumed: half of Table 4.3, so that it has to be left',
        'estimator.weight': 'assumed: small'})
