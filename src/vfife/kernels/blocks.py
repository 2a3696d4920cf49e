"""Blocks of the state: every number a step reads or writes, with its entity, unit, role and meaning.

Each entity (a particle, an element, a joint ...) has a record of rows, one for each of its blocks: state,
memory (what only the next step needs), extremes since the last output, parameters, scratch. Where they lie in
the one array ``S`` is said in :mod:`~vfife.kernels.arrays`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

Role = Literal["state", "memory", "extreme", "parameter", "scratch"]

CONTACT_SLOTS = 8
FRICTION_SLOTS = 8
FRICTION_MEMORY = 3


@dataclass(frozen=True)
class Block:
    """One named quantity: what it is counted over, its unit, its role and its meaning."""

    name: str
    entity: str
    unit: str
    role: Role
    meaning: str
    width: int = 1

    @property
    def field(self) -> str:
        """Name within the entity's record."""
        return self.name.removeprefix(f"{self.entity}_")


def _blocks(role: Role, entity: str, table: str) -> list[Block]:
    """Blocks of a table with a line each, or for several that differ in their axis only: names | unit |
    meaning | width, if not 1.
    """
    rows = [[" ".join(cell.split()) for cell in line.split("|")] for line in table.strip().splitlines()]
    return [
        Block(name, entity, unit, role, meaning, int(width[0]) if width else 1)
        for names, unit, meaning, *width in rows
        for name in names.split()
    ]


BLOCKS: tuple[Block, ...] = (
    *_blocks("state", "particle", """
        particle_x particle_y | m | position at step n
        particle_theta | rad | rotation at step n
        particle_u particle_v | m/s | velocity at step n + 1/2
        particle_w | rad/s | angular velocity at step n + 1/2
        particle_ax particle_ay | m/s^2 | acceleration at step n
        particle_aw | rad/s^2 | angular acceleration at step n"""),
    *_blocks("state", "frame", """
        frame_axial_force | N | axial force, tension positive, at step n
        frame_moment_1 | N m | internal moment at the first node at step n
        frame_moment_2 | N m | internal moment at the second node at step n
        reference_length | m | length at the start of the path unit"""),
    *_blocks("memory", "frame", """
        reference_inverse_length | 1/m | its inverse, or that of the length without forces where stiffness \
            counts on it
        reference_cosine reference_sine | 1 | direction at the start of the path unit
        reference_theta_1 | rad | rotation of the first node at the start of the path unit
        reference_theta_2 | rad | rotation of the second node at the start of the path unit"""),
    *_blocks("memory", "unit", """
        reference_axial_force | N | axial force at the start of the path unit
        reference_moment_1 | N m | moment at the first node at the start of the path unit
        reference_moment_2 | N m | moment at the second node at the start of the path unit"""),
    *_blocks("state", "contact", """
        contact_normal_force | N | normal force F_N at step n
        contact_friction_force | N | friction force F_T at step n, along t on the journal
        contact_penetration | m | signed penetration e - c at step n
        contact_slowness | s/m | inverse of the impact speed at the last onset, 0 in free flight
        contact_memory | unit of the law | what the friction law remembers: a bristle's deflection, \
            sliding velocities ... | 3
        contact_damping_power | W | power lost in normal damping at step n
        contact_friction_power | W | power lost in friction at step n
        contact_damping_work | J | energy lost in normal damping up to step n + 1/2
        contact_friction_work | J | energy lost in friction up to step n + 1/2
        contact_onsets | 1 | contacts that began
        contact_grazing | 1 | onsets slower than the floor of the impact speed
        contact_deep | 1 | onsets that landed deeper than the landing depth
        contact_deepest | m | deepest first landing
        contact_fastest | m/s | fastest impact
        contact_approach | m/s | sum of the approach speeds of all contacts that began
        contact_duration | s | time in contact, but for the first step of each"""),
    *_blocks("memory", "contact", """
        contact_regime | 1 | which smooth part of the friction law's curve held at step n"""),
    *_blocks("state", "wear", """
        wear_work | N m | normal force times sliding distance up to step n
        wear_x wear_y | N m | the same, each part along the direction from the bearing's centre to \
            the journal's in which it was done"""),
    *_blocks("state", "joint", """
        joint_fx joint_fy | N | force on the journal at step n
        joint_moment | N m | moment on the journal's body at step n"""),
    *_blocks("memory", "constraint", """
        constraint_force | N or N m | reaction along one constraint at step n
        constraint_before | N or N m | the same at step n - 1"""),
    *_blocks("state", "spring", """
        spring_fx spring_fy | N | force on the second body at step n
        spring_moment | N m | moment on the second body's pin at step n
        spring_energy | J | elastic energy at step n
        spring_damping_power | W | power lost in damping at step n
        spring_damping_work | J | energy lost in damping up to step n + 1/2"""),
    *_blocks("memory", "spring", """
        spring_resistance | N or N m | forces along its axes at step n | 3
        spring_regime | 1 | of a stop: the limit beyond which it was at step n, -1 or 1, else 0"""),
    *_blocks("state", "driven", """
        driven_torque | N m | torque of the driver at step n
        driven_fx driven_fy | N | force of the ground on the driven body at step n
        driven_power | W | power of the driver at step n
        driven_work | J | work of the driver up to step n + 1/2"""),
    *_blocks("state", "actuator", """
        actuator_force | N or N m | force or torque of a driver of anything else than a body on its pivot, \
            at step n
        actuator_power | W | its power at step n
        actuator_work | J | its work up to step n + 1/2"""),
    *_blocks("state", "body", """
        body_alpha | rad/s^2 | angular acceleration of a rigid body or of an elastic link's chord at \
            step n"""),
    *_blocks("state", "function", """
        function_value | unit of the table | value at step n
        function_rate | unit of the table / s | first derivative at step n
        function_acceleration | unit of the table / s^2 | second derivative at step n
        function_next | unit of the table | value at step n + 1
        function_kinks | 1 | kinks before step n"""),
    *_blocks("memory", "function", """
        function_passed | 1 | kinks that steps have passed"""),
    *_blocks("state", "system", """
        damping_power | W | power lost in mass-proportional damping at step n
        damping_work | J | energy lost in mass-proportional damping up to step n + 1/2
        external_power | W | power of time-dependent loads at step n
        external_work | J | work of time-dependent loads up to step n + 1/2
        iterations | 1 | iterations that a load factor took in a static analysis
        unbalanced | 1 | unbalanced force that is left there, over the largest force
        repeated | 1 | steps that were taken again in smaller ones"""),
    *_blocks("memory", "system", """
        event | 1 | whether something begins, ends or changes its regime in step n
        pivots | 1 | product of the pivots of constraints that close loops, over their diagonals, at step n
        pivots_before | 1 | the same at step n - 1
        passing | 1 | 1 where these tell that the mechanism passes a singular position, else 0"""),
    *_blocks("extreme", "contact", """
        contact_force_squared_max | N^2 | largest squared force of the contact since the last output
        contact_penetration_max | m | largest signed penetration since the last output"""),
    *_blocks("extreme", "guide", """
        guide_force_squared_max | N^2 | largest squared force of all corners of a block in its guide \
            together since the last output"""),
    *_blocks("extreme", "joint", """
        joint_force_squared_max | N^2 | largest squared joint force since the last output
        joint_moment_max | N m | largest absolute moment since the last output"""),
    *_blocks("extreme", "driven", """
        driven_force_squared_max | N^2 | largest squared ground force since the last output
        driven_torque_max | N m | largest absolute torque since the last output"""),
    *_blocks("extreme", "actuator", """
        actuator_force_max | N or N m | largest absolute force or torque since the last output"""),
    *_blocks("extreme", "body", """
        body_alpha_max | rad/s^2 | largest absolute angular acceleration since the last output"""),
    *_blocks("extreme", "spring", """
        spring_force_squared_max | N^2 | largest squared force since the last output"""),
    *_blocks("parameter", "particle", """
        particle_inverse_mass | 1/kg | 0 where the motion is prescribed
        particle_inverse_inertia | 1/(kg m^2) | 0 where the rotation is prescribed
        particle_load_x particle_load_y | N | constant load, weight included
        particle_load_m | N m | constant moment"""),
    *_blocks("parameter", "frame", """
        frame_axial_stiffness | N | E A
        frame_bending_stiffness | N m^2 | E I"""),
    *_blocks("parameter", "contact", """
        contact_bearing_x contact_bearing_y | m | bearing centre in its body's frame
        contact_journal_x contact_journal_y | m | journal centre in its body's frame
        contact_line_x contact_line_y | 1 | on a line: direction into its material, in the bearing's frame
        contact_size | m | distance of the centres where they begin to touch: c = R_B - R_J in a bearing \
            or slot, R_B + R_J outside, -R_J on a line
        contact_arm_bearing | m | arm of friction on the bearing, 0 with the friction moment off
        contact_arm_journal | m | arm of friction on the journal, 0 with the friction moment off
        contact_arm_overlap | 1 | share of the penetration by which the arms change
        contact_floor | m/s | least impact speed
        contact_landing | m | depth at which a first contact may land
        contact_slots | unit of the law | parameters of the contact law | 8
        contact_friction_slots | unit of the law | parameters of the friction law | 8"""),
    *_blocks("parameter", "harmonic", """
        harmonic_cosine | m | of a worn profile: depth that goes with the cosine of so many times the angle; \
            the mean depth in the first
        harmonic_sine | m | of a worn profile: depth that goes with its sine"""),
    *_blocks("parameter", "joint", """
        joint_bearing_x joint_bearing_y | m | pin in the bearing body's frame
        joint_journal_x joint_journal_y | m | pin in the journal body's frame
        joint_direction_x joint_direction_y | 1 | direction of a guide, in the bearing body's frame
        joint_offset | rad or m | angle, or travel, between the bodies at the start; length of a massless link
        joint_ratio | 1 | turns of the journal's body for one of the bearing's"""),
    *_blocks("parameter", "piece", """
        piece_x piece_y | m | begin of a piece of a path, in the frame of the bearing's body, from its pin
        piece_cosine piece_sine | 1 | direction there
        piece_curvature | 1/m | curvature, positive to the left
        piece_opens | 1 | 0 where the piece goes on before its begin, else 1
        piece_end_x piece_end_y | m | end of the piece
        piece_end_cosine piece_end_sine | 1 | direction there, 0 where the piece goes on beyond its end"""),
    *_blocks("parameter", "knot", """
        knot_begin | m | penetration from which a piece of a contact law's table counts
        knot_mean | N/m^k | mean of loading and unloading over the penetration from there: coefficients, \
            constant first | 4
        knot_half | N/m^k | half of what they are apart | 4"""),
    *_blocks("parameter", "spring", """
        spring_first_x spring_first_y | m | pin in the first body's frame
        spring_second_x spring_second_y | m | pin in the second body's frame
        spring_stiffness | N/m or N m/rad | along its axes | 3
        spring_damping | N s/m or N m s/rad | along its axes | 3
        spring_free | m or rad | free length, free angle, or lower limit of a stop
        spring_high | rad | upper limit of a stop"""),
    *_blocks("parameter", "driven", """
        driven_angle | rad | angle at t = 0 of a driver of constant speed
        driven_speed | rad/s | its speed
        driven_inertia | kg m^2 | inertia about the pivot
        driven_moment_x driven_moment_y | kg m | mass times centre of mass, in the body's frame from the pivot
        driven_weight_x driven_weight_y | N/kg | gravity"""),
    *_blocks("parameter", "load", """
        load_x load_y | m | point of attack in the particle's frame
        load_fx load_fy | 1 | force per unit of its function
        load_m | 1 | moment per unit of its function"""),
    *_blocks("parameter", "function", """
        function_first_x function_first_y | m | pin from which a travel counts, in its particle's frame
        function_second_x function_second_y | m | pin that travels, in its particle's frame
        function_along_x function_along_y | 1 | direction of the travel, in the first particle's frame
        function_gap | m | by how much the table's part for the way back lies before that for the way out"""),
    *_blocks("parameter", "system", """
        step | s | time step
        shift | 1 | steps, or a part of one, by which the run is ahead of its number of steps
        damping | 1/s | coefficient of mass-proportional damping
        size | m | longest arm of an ideal joint"""),
    *_blocks("scratch", "system", """
        share | 1 | share of the pivots that is added near a singular position"""),
    *_blocks("scratch", "particle", """
        fx fy | N | force so far at step n
        mz | N m | moment so far at step n"""),
    *_blocks("scratch", "bound", """
        c | 1 | cosine of the rotation at step n
        s | 1 | sine of the rotation at step n
        vu vv | m/s | velocity at step n
        vw | rad/s | angular velocity at step n
        step_x step_y | m | displacement from step n to n + 1
        step_turn | rad | rotation from step n to n + 1
        step_sine | 1 | its sine
        step_versine | 1 | 1 less its cosine
        change_x change_y | N | what a correction of the reactions adds to the force
        change_m | N m | what a correction of the reactions adds to the moment
        touches | 1 | contacts that are solved together and press on it
        rn | 1/kg | velocities per unit of a joint's normal force | 3
        rt | 1/kg | velocities per unit of a joint's friction force | 3"""),
    *_blocks("scratch", "contact", """
        nx ny | 1 | direction from bearing to journal centre, or into the line's material
        jn | m | lever of the normal force on the journal's body
        jt | m | lever of the friction force on the journal's body
        bn | m | lever of the normal force on the bearing's body
        bt | m | lever of the friction force on the bearing's body
        elastic | N | elastic part of the normal force
        damping_coefficient | N s/m | damping coefficient
        normal | N | normal force to start from
        friction | N | friction force to start from
        change | N | change of the normal force in a sweep
        film_radial | N | force of a film towards the bearing's centre, at rest
        film_across | N | its force along t on the journal, at rest
        film_damping | N s/m | damping of that by the velocity along t
        film_cross | N s/m | force along t by the rate along n, and the reverse"""),
    *_blocks("scratch", "wear", """
        wear_nx wear_ny | 1 | direction from the bearing's centre to the journal's
        wear_stretch | 1 | change of the penetration for one of the distance between worn surfaces
        wear_journal | m | depth of the journal's surface where the two meet"""),
    *_blocks("scratch", "constraint", """
        constraint_nx constraint_ny | 1 | direction of the constraint, 0 for an angle
        constraint_jb | m | lever on the bearing's body
        constraint_jk | m | lever on the journal's body
        constraint_jc | 1 | lever on the carrier of gears, the other way
        constraint_turn_x constraint_turn_y | 1 | change of the direction from step n to n + 1
        constraint_turn_b | m | change of the lever on the bearing's body
        constraint_turn_k | m | change of the lever on the journal's body
        constraint_turn_c | 1 | change of the lever on the carrier, which has none"""),
)  # fmt: skip

BY_NAME: Mapping[str, Block] = {block.name: block for block in BLOCKS}
