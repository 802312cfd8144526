"""What the displacement of a body is taken against, beside another body."""

from symid.axis.elements import GROUND, Body, Ground


def carrier_of(body: Body | Ground, other: Body | Ground) -> Body | Ground:
    """The sliding body that carries `other`, where that turns and `body` slides; else the ground.

    A nut moves along its screw by what it moves against the column that carries the screw, which feels the thrust.
    """
    if not isinstance(body, Body) or body.turns or not (isinstance(other, Body) and other.turns):
        return GROUND
    carrier: Body | Ground = other
    while isinstance(carrier, Body) and carrier.turns:
        carrier = carrier.on
    return carrier
