"""The body against which a displacement between a sliding and a turning body is measured."""

from symid.axis.elements import GROUND, Body, Ground


def carrier_of(body: Body | Ground, other: Body | Ground) -> Body | Ground:
    """The sliding body that carries `other`, where that turns and `body` slides; else the ground.

    The travel of a nut along its screw is its displacement against the column that carries the screw and feels the
    thrust.
    """
    if not isinstance(body, Body) or body.turns or not (isinstance(other, Body) and other.turns):
        return GROUND
    carrier: Body | Ground = other
    while isinstance(carrier, Body) and carrier.turns:
        carrier = carrier.on
    return carrier
