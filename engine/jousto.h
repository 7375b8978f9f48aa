/* jousto.h - public interface of the jousto engine (C99): simulation of flexible multibody systems.
 *
 * A const jo_model contains the sizes and constants of a model, a jo_data the state and the work space of one run.
 * A step allocates no memory, uses no global data and prints nothing; every function is re-entrant.
 *
 * Frames: no suffix = resolved in the world frame, _local = resolved in the body frame.
 * Units: SI. Symmetric 3x3 tensors are stored as xx yy zz yz xz xy.
 * Modal arrays are component-major, (c x np), np = n padded with zeros to a multiple of JO_PAD.
 *
 * The Python binding reads the lines between the marks BEGIN and END; these contain only
 * enums, structs with pointers and plain integers and doubles, and function declarations.
 */
#ifndef JOUSTO_H
#define JOUSTO_H

#if defined(JO_VECTOR)            /* number of machines of one structure, one in each lane of a vector */
typedef double jo_real __attribute__((vector_size(8 * JO_VECTOR)));
#elif defined(JO_COMPLEX)
#include <complex.h>
typedef double complex jo_real;  /* complex-step derivatives of all results */
#else
typedef double jo_real;
#endif

/* The kinds of force, one row ROW(name, numbers) each; the Python binding reads the rows as well. A row defines the number of the kind
 * (JO_FORCE_name) and the type of its data (jo_name_data), and enters jo_force_name, defined in force_name.c, into the table of
 * force_table.c.
 *
 * load: force (N) and torque (N m) at b, resolved in the world frame or in the frame of b, times signal
 * along: f = stiffness (reference - s) + damping (reference' - s') + preload signal(t) + spring(s) + damper(s'),
 *   reference = free + reference signal; |f| <= limit if limit > 0
 * bushing: [force, torque] on b, resolved in a, from [r_b - r_a, rotation vector]; matrices by rows
 * stop: f = -stiffness d (1 + loss s(d'/speed)), d: distance of s beyond lower or upper; see force_stop.c
 * modal_load: force and torque on the body frame, resolved in it, followed by (np) modal forces; times signal
 * user: result of jo_force.function; no data
 * plastic: elastic-plastic spring, see force_plastic.c; five states from jo_force.state on
 * gear_spring: f = -stiffness e - damping e' + spring(e) along s, -f / ratio along the other coordinate s_2 (of the shaft that turns
 *   `ratio` times as far), e = s - s_2 / ratio - free
 * pid: controller with integral part and filtered derivative, see force_pid.c; two states from jo_force.state on
 * contact: a sphere on b, centre in frame b, touches a shape of a, see force_contact.c and jo_shape_type; six states from jo_force.state on,
 *   nine with resistance to rolling and drilling, see contact_turn.c
 *   around > 0: a point of the rim of a cylinder with the radius `ring`, at the angle around - 1 from its lowest point
 *   axes > 0: the lowest point of an ellipsoid with these half axes
 *   followed by the rows of a table (extent) if `curve` is JO_CURVE_TABLE, see contact_curve.c
 * contact_pair: two convex polytopes, see force_contact_pair.c; 8 states for each of up to 8 points
 * contact_set: shapes whose pairs are not known; its numbers are followed by the rows of contact_rows.h, its force by those of its slots
 * contact_slot: contact of a pair that is near; set, number: forces of the set and of the slot; two states from jo_force.state on, then those
 *   of a contact, or of a contact_pair
 * contact_track: a wheel on a curve through markers, see force_contact_track.c; followed by its pieces (count); seven states from jo_force.state on
 * tyre: of a wheel b on a plane of a, see force_tyre.c and tyre_law.c; two states from jo_force.state on
 * rail: a wheel of b on a straight rail of a, see force_rail.c; followed by the numbers of its patches (count), see rail_patch.h
 * slider: a point on both sides of a track, see force_slider.c; followed by its pieces (count); three states from jo_force.state on
 * network: first-order states with forces along coordinates, see force_network.c; their states from jo_force.state on
 * memory: values of a network that are constant within a step, see force_memory.c; followed by their initial values and the registers of
 *   their next values (count each); period > 0: sampled at phase + k period
 * moving_load: force resolved in the world or the body frame; followed by s_k (count) and (count - 1) x (1 + modes) x 3 x 4
 *   coefficients of (s - s_k)^0..3 of the position and of each mode shape; at s = reference(t), times signal; 0 beyond the ends */
#define JO_CONTACT_LAW stiffness, exponent, damping, slowest, viscous, full, mu_static, mu_kinetic, shear, mass, duration, velocity, curve, extent, impedance[5]
#define JO_TOUCH_LAW resolve, restitution
#define JO_FORCES(ROW) \
    ROW(load, force[3], torque[3]) \
    ROW(along, stiffness, damping, free, preload, limit) \
    ROW(bushing, K[36], D[36], preload[6]) \
    ROW(stop, stiffness, lower, upper, loss, speed) \
    ROW(modal_load, force[3], torque[3]) \
    ROW(user, none) \
    ROW(moving_load, count, modes, force[3]) \
    ROW(contact, JO_CONTACT_LAW, JO_TOUCH_LAW, rolling, drilling, inertia, shape, size[3], centre[3], radius, ring, around, axes[3]) \
    ROW(contact_set, shapes, tips, surfaces, groups, excluded, slots, pairs, resolve) \
    ROW(contact_slot, set, number) \
    ROW(pid, proportional, integral, derivative, weight, filter, filter_share, tracking, tracking_share, lower, upper, start, speed) \
    ROW(plastic, stiffness, free, strength, kinematic, recovery, isotropic, saturation, rate) \
    ROW(gear_spring, stiffness, damping, ratio, free) \
    ROW(contact_pair, JO_CONTACT_LAW, JO_TOUCH_LAW) \
    ROW(contact_track, JO_CONTACT_LAW, JO_TOUCH_LAW, radius, count) \
    ROW(tyre, radius, stiffness, damping, relaxation[2], lead, slow, sink, resistance, law, mu, half_length, load, cx, cy, \
        longitudinal[9], lateral[13], aligning[14], peak[2]) \
    ROW(slider, stiffness, damping, play, hold, brake, mu, resistance, slow, count) \
    ROW(network, number, states, coordinates, signals, constants, values, instructions, pushes, slopes, memories, gravity, openings) \
    ROW(memory, network, first, count, period, phase, margin, jumps, jitter, seed) \
    ROW(delay, network, input, slope, time, points, given, initial, size) \
    ROW(rail, mu, damping, slow, count) \
    /* the last row */

/* Methods of integration, a row each: ROW(name, family, order, stages, coefficients), which the Python binding reads, too. A row makes
 * the number of the method, JO_METHOD_name; the file of its family makes a step of it, compiled for these coefficients:
 * runge_kutta: explicit, step_runge_kutta.c; a_ij (j < i) by rows, then b_i
 * rosenbrock: W-method with implicit modes, beams and springs along joint coordinates, step_rosenbrock.c; g, a_ij (j < i) by rows,
 *   g_ij (j < i) by rows, b_i. With order 2 its matrix contains the time derivative of the forces
 * generalized_alpha: implicit, step_generalized_alpha.c; its parameters are in jo_solver
 * dormand_prince: with error control, step_dormand_prince.c, which contains the tableau */
#define JO_METHODS(ROW) \
    ROW(rk4, runge_kutta, 4, 4, 0.5, 0.0, 0.5, 0.0, 0.0, 1.0, 1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0) \
    ROW(ros2, rosenbrock, 2, 2, 1.0 - 0.70710678118654752440, 1.0, -2.0 * (1.0 - 0.70710678118654752440), 0.5, 0.5) \
    ROW(alpha, generalized_alpha, 2, 0, 0.0) \
    ROW(dopri, dormand_prince, 5, 0, 0.0) \
    ROW(ssprk3, runge_kutta, 3, 3, 1.0, 0.25, 0.25, 1.0 / 6.0, 1.0 / 6.0, 2.0 / 3.0) \
    ROW(ros3a, rosenbrock, 3, 4, 0.435866521508458999, \
        0.435866521508458999, 1.243893189483364390, -0.525959928729134891, 0.630412558152872662, 0.786580740199147478, -0.416993298352020141, \
        -0.435866521508458999, -1.243893189483364390, 0.808026667974905391, -0.630412558152872662, 0.421915908976862592, -0.227369872332448929, \
        0.0, 1.208496649176010070, -0.644363170684469070, 0.435866521508458999) \
    /* the last row */

#define JO_METHOD_NUMBER(name, ...) JO_METHOD_##name,
typedef enum { JO_METHOD_none, JO_METHODS(JO_METHOD_NUMBER) } jo_method;

#define JO_FORCE_NUMBER(name, ...) JO_FORCE_##name,
#define JO_FORCE_DATA(name, ...) typedef struct { jo_real __VA_ARGS__; } jo_##name##_data;
typedef enum { JO_FORCES(JO_FORCE_NUMBER) } jo_force_type;
JO_FORCES(JO_FORCE_DATA)

/* BEGIN */
enum { JO_ABI = 36 };           /* version of the structs and their meaning below */
enum { JO_PAD = 4 };           /* arrays over modal coordinates are padded with 0 to a multiple of JO_PAD */
enum { JO_ROW_D = 24 };        /* rows of one block of jo_body.ED */
enum { JO_ROW_B = 12 };        /* rows of one block of jo_body.EB */
enum { JO_DENSE = 32 };        /* largest np for which ED, EB are stored as blocks of rows; as triangles of tiles above */
enum { JO_MAX_ROWS = 6 };      /* constraint rows of one joint */

/* places in the memory of a damage meter before its turning points, see jo_meter */
typedef enum { JO_METER_POINTS = 0, JO_METER_SAMPLES = 1, JO_METER_DROPPED = 2, JO_METER_DAMAGE = 3, JO_METER_ROUNDING = 4,
               JO_METER_CLOSED = 5, JO_METER_FORCED = 6, JO_METER_LARGEST_FORCED = 7, JO_METER_SHED = 8,
               JO_METER_SHED_DAMAGE = 9, JO_METER_TIME = 10, JO_METER_SMALLEST = 11, JO_METER_LARGEST = 12,
               JO_METER = 13 } jo_meter_place;
enum { JO_MAX_SIDES = 4 };     /* markers of one joint: 2, or 4 for two coupled coordinates */

typedef enum { JO_OK = 0, JO_NOT_FINITE = 1, JO_SINGULAR_BODY = 2, JO_SINGULAR_JOINT = 3, JO_NO_MEMORY = 4,
               JO_CALLBACK_FAILED = 5,    /* error_index: force */
               JO_NO_CONVERGENCE = 6,     /* of Newton's method in a step; error_index: body of the largest increment */
               JO_FRICTION_FAILED = 7,    /* no solution of friction forces and reactions; error_index: friction */
               JO_EVENT = 8,              /* the run ended at an event; error_index: event */
               JO_STEP_TOO_SMALL = 9,
               JO_ENDLESS = 10,           /* too many events within one step; error_index: event, or nevent + friction */
               JO_BENT = 11,              /* rotation of about pi between the ends of a beam element; error_index: beam */
               JO_TOO_MANY_CONTACTS = 12, /* more pairs are near than there are slots; error_index: force of the set */
               JO_BEYOND_TABLE = 13,      /* an argument beyond a table whose ends end the run; error_index: force of the network */
               JO_DELAY_FULL = 14         /* an input jumps more often within a delay than it keeps points; error_index: force of the delay */
} jo_status;
typedef enum { JO_SIGNAL_CONSTANT = 0, JO_SIGNAL_HARMONIC = 1, JO_SIGNAL_TABLE = 2, JO_SIGNAL_STEP = 3,
               JO_SIGNAL_PIECES = 4, JO_SIGNAL_SUM = 5, JO_SIGNAL_PRODUCT = 6, JO_SIGNAL_INPUT = 7,
               JO_SIGNAL_SWITCHED = 8, JO_SIGNAL_SPEED = 9, JO_SIGNAL_NETWORK = 10,
               JO_SIGNAL_DELAY = 11 } jo_signal_type;
typedef enum { JO_COORDINATE_AXES = 1,        /* (axis_a of a) . (axis_b of b) */
               JO_COORDINATE_ALONG = 2,       /* (axis_a of a) . (r_b - r_a), m */
               JO_COORDINATE_DISTANCE = 3,    /* |r_b - r_a|, m */
               JO_COORDINATE_ANGLE = 4,       /* rotation of b relative to a about z of a, rad, counted beyond 2 pi */
               JO_COORDINATE_RIM = 5,         /* of a disc on a plane, see rolling_coordinate.c */
               JO_COORDINATE_ROLLED = 6,
               JO_COORDINATE_ACROSS = 7,
               JO_COORDINATE_RAIL_GAP = 8,    /* of a conical wheel on a rail, see rail_coordinate.c */
               JO_COORDINATE_RAIL_ROLLED = 9,
               JO_COORDINATE_RAIL_ACROSS = 10,
               JO_COORDINATE_ROPE = 11,       /* between two sheaves, see rope_coordinate.c */
               JO_COORDINATE_SLIP = 12        /* of a sphere on a plane along axis_a of a, see rolling_coordinate.c */
} jo_coordinate_type;
typedef enum { JO_SENSOR_POSITION = 1, JO_SENSOR_VELOCITY = 2, JO_SENSOR_ORIENTATION = 3, JO_SENSOR_ANGULAR_VELOCITY = 4,
               JO_SENSOR_MODAL = 5, JO_SENSOR_REACTION = 6, JO_SENSOR_STRESS = 7, JO_SENSOR_ACCELERATION = 8,
               JO_SENSOR_ANGULAR_ACCELERATION = 9, JO_SENSOR_COORDINATE = 10, JO_SENSOR_RATE = 11,
               JO_SENSOR_MULTIPLIER = 12, JO_SENSOR_ELEMENT = 13, JO_SENSOR_ENERGY = 14, JO_SENSOR_SIGNAL = 15,
               JO_SENSOR_VON_MISES = 16, JO_SENSOR_PRINCIPAL = 17, JO_SENSOR_FRICTION = 18, JO_SENSOR_DAMAGE = 19,
               JO_SENSOR_BRIDGE = 21, JO_SENSOR_SECTION = 22,
               JO_SENSOR_ACCELERATION_PARTS = 23,
               JO_SENSOR_DEFORMATION_MOMENTUM = 24,
               JO_SENSOR_FORCE_STATE = 25,
               JO_SENSOR_BODY_LOAD = 26, JO_SENSOR_MODAL_LOAD = 27,
               JO_SENSOR_CONTACT = 28 } jo_sensor_type;
/* operations of the programs of networks, see network_program.c */
typedef enum { JO_DO_add = 0, JO_DO_subtract = 1, JO_DO_multiply = 2, JO_DO_divide = 3, JO_DO_sqrt = 4, JO_DO_exp = 5, JO_DO_log = 6,
               JO_DO_sin = 7, JO_DO_cos = 8, JO_DO_atan = 9, JO_DO_tanh = 10, JO_DO_power = 11, JO_DO_minimum = 12, JO_DO_maximum = 13,
               JO_DO_select = 14, JO_DO_table = 15, JO_DO_table_x = 16, JO_DO_map = 17, JO_DO_map_x = 18, JO_DO_map_y = 19,
               JO_DO_edge = 20, JO_DO_edge_slope = 21 } jo_do;
typedef enum { JO_ENERGY_KINETIC = 0, JO_ENERGY_STRAIN = 1, JO_ENERGY_POTENTIAL = 2, JO_ENERGY_SPRINGS = 3,
               JO_ENERGY_DISSIPATED = 4, JO_ENERGY_FRICTION = 5, JO_ENERGY_WORK = 6 } jo_energy_kind;
typedef enum { JO_LOAD_JOINT = 0, JO_LOAD_APPLIED = 1, JO_LOAD_FRICTION = 2, JO_LOAD_GRAVITY = 3, JO_LOAD_INERTIA = 4,
               JO_LOAD_ELASTIC = 5, JO_LOAD_DAMPING = 6 } jo_load_kind;
typedef enum { JO_RESIDUE_HALF = 0, JO_RESIDUE_REPEAT = 1, JO_RESIDUE_IGNORE = 2 } jo_residue;
typedef enum { JO_MEAN_NONE = 0, JO_MEAN_LINE = 1, JO_MEAN_GERBER = 2, JO_MEAN_WALKER = 3, JO_MEAN_FKM = 4,
               JO_MEAN_WELD = 5, JO_MEAN_COMPRESSION = 6 } jo_mean;

/* Energies of a mechanism, J; strain: of modes and beams. */
typedef struct { jo_real kinetic, strain, potential, springs; } jo_energies;

/* Energy dissipated by damping and by friction, and work of forces and drives, J; or the rates of these, W. */
typedef struct { jo_real damping, friction, forces; } jo_work;

/* Part of a row of results between multipliers and sensors: energies, J; largest |C|, m, and |Cq v|, m/s; counts of evaluations, Newton
 * iterations, steps and rejected steps since the start; length of the last step, s. */
typedef struct {
    jo_real kinetic, strain, potential, springs, dissipated, friction, work, position_residual, velocity_residual;
    jo_real evaluations, iterations, steps, rejected, step;
} jo_diagnostics;

/* Counts since the start; singular: evaluations in a singular position; deferred: steps that left a change to the next step, see
 * JO_END_PASSES. */
typedef struct { long long evaluations, iterations, factorisations, rejected, singular, steps, deferred; } jo_counts;

/* A rigid (n = 0) or modal body: displacement field u = u0 + Phi p in a floating frame. */
typedef struct {
    int n, np;              /* number of modal coordinates, and padded number */
    int iq, iv;             /* offsets of [R e p] in q and of [R' w_local p'] in v */
    const jo_real *mass;    /* (1)       kg */
    const jo_real *S0;      /* (3)       first moment I2 */
    const jo_real *J0;      /* (6)       inertia tensor I7 about the frame origin */
    const jo_real *I3;      /* (3 x np)  int phi dm */
    const jo_real *B0;      /* (3 x np)  I4: int u0 x phi_j dm */
    const jo_real *D0;      /* (6 x np)  half the derivative of J with respect to p_j at p = 0 */
    /* Layout for np <= JO_DENSE: rows c np + j in blocks of JO_ROW_D or JO_ROW_B, each block (n x rows);
     * else for each component c the 4 x 4 tiles [k][j] with j-block >= k-block, ordered by k-block. */
    const jo_real *ED;      /* (6 np x n) d D_j / d p_k, symmetric in j, k */
    const jo_real *EB;      /* (3 np x n) int phi_k x phi_j dm, antisymmetric */
    const jo_real *K;       /* (np)      modal stiffness omega^2, rad^2/s^2 */
    const jo_real *D;       /* (np)      modal damping 2 zeta omega, 1/s */
    double alpha;           /*           mass-proportional damping, 1/s: forces -alpha M v; rigid bodies only */
} jo_body;

/* Frame on a body: at a node with translation and rotation mode shapes, or rigid. */
typedef struct {
    int body;               /* -1: ground */
    int turns;              /* whether every evaluation needs the orientation; otherwise only sensors need it */
    const jo_real *u0;      /* (3)       undeformed position, local */
    const jo_real *A0;      /* (9)       undeformed orientation, local, row-major */
    const jo_real *Phi;     /* (3 x np)  translation mode shapes; 0: rigid */
    const jo_real *Psi;     /* (3 x np)  rotation mode shapes; 0: rigid or not needed */
    const jo_real *chi;     /* (6 n x np) second-order translation and rotation chi_jk, symmetric; 0: no geometric stiffening */
} jo_marker;

/* Geometrically exact beam element between two rigid bodies, see beam.c. Matrices by rows. */
typedef struct {
    jo_real length;         /* m */
    jo_real u_a[3], B_a[9], u_b[3], B_b[9];   /* positions (m) and frames (x along the beam) of the ends on the bodies */
    jo_real C[36];          /* section stiffness for [Gamma, kappa], N, N m, N m2 */
    jo_real e0[6];          /* strains [Gamma, kappa] of the unstressed shape */
    jo_real beta;           /* stiffness-proportional damping, s */
    jo_real alpha;          /* mass-proportional damping of the consistent mass, 1/s; jo_body.alpha applies to the lumped mass */
    jo_real share;          /* share of (consistent - lumped mass) added to the lumped mass of the bodies */
    jo_real mass, J[6];     /* mass (kg) and rotary inertia (kg m2) of the element in the frames of its ends */
    jo_real limit;          /* inverse of the largest admissible tension, 1/N; 0: no limit */
    jo_real helical;        /* 1: the axis between the ends is a helix (beam_helix.c); 0: it is their chord */
    jo_real polar;          /* Ip/A about the shear centre, m2, for the Wagner effect (beam_fibre.c); 0: none */
} jo_beam_data;
typedef struct {
    int a, b;               /* bodies */
    const jo_beam_data *data;
} jo_beam;

/* Scalar function of two frames a, b. */
typedef struct {
    int type;               /* jo_coordinate_type */
    int a, b;               /* markers */
    int axis_a, axis_b;     /* AXES, ALONG */
    int turn;               /* ANGLE: index among the counted angles, else -1 */
    int link;               /* link whose joint coordinate equals plus or minus this coordinate; -1: none */
    double radius;          /* RIM, ROLLED, ACROSS: of the disc; SLIP: of the sphere; RAIL: of the wheel; ROPE: of the sheave of a, m */
    double cone, head;      /* RAIL: increase of the radius along the axle; radius of the head of the rail; ROPE: head: of the sheave of b, m */
} jo_coordinate;

/* Constraint row: sum over i of factor_i coordinate_i - offset - signal(t) = 0; the offsets of optional joints are jo_data_held(). */
typedef struct { jo_real offset, factor[2]; } jo_line_data;
typedef struct {
    int count;              /* 1 or 2 coordinates */
    int coordinate[2];
    int side[2];            /* side of the joint that is marker a of the coordinate; b is the next side */
    int signal;             /* -1: none */
    const jo_line_data *data;
} jo_line;

/* Constraint rows. The first three, if coincident, are r_b - r_a = 0 between sides 0 and 1; then nperp rows
 * (axis perp_a of side 0) . (axis perp_b of side 1) = 0; then nline rows of jo_line. */
typedef struct {
    int nside;              /* 2 or 4 */
    int side[4];            /* markers */
    int coincident, nperp, nline;
    int perp_a[3], perp_b[3];
    int line;               /* index of its first line */
    int nrow, row;          /* rows, and offset in lam */
    int lock;               /* index in jo_data_locked(): the rows are active while it is not 0; -1: always */
    int release;            /* event that deactivates the rows; -1: none */
} jo_joint;

/* Tree of rigid bodies in joint coordinates, see tree.c. A link moves relative to its parent (a link or the ground), in the frame of the
 * outer marker on the body of the parent. The frame of the link is its inner marker; hinges rotate about z, slides move along z.
 * A joint with two degrees of freedom is two links, the first one without a body: slide and hinge of a cylindrical joint; hinge about z
 * and hinge about the former x of a universal joint. */
typedef enum { JO_LINK_FIXED = 0, JO_LINK_HINGE = 1, JO_LINK_SLIDE = 2, JO_LINK_BALL = 3, JO_LINK_FREE = 4,
               JO_LINK_BODY = 5     /* body in maximal coordinates that carries trees (tree_on_flexible_bodies.c); first links */
} jo_link_type;
typedef struct {
    int type;               /* jo_link_type; coordinates of BALL: (4) quaternion, (3) relative angular velocity, local;
                             * FREE, BODY: [R e p] and [R' w_local p'] of the body */
    int parent;             /* index of the parent, less than that of the link; -1: ground */
    int body;               /* -1: none; then the only child has the body of the joint */
    int outer;              /* marker on the body of the parent; -1: frame of a parent without a body; FREE, BODY: ground */
    int crossed;            /* for outer -1: x, y, z of the link are y, z, x of the parent */
    int inner;              /* marker on the body of the link; -1: none, or FREE, BODY */
    int joint;              /* joint that the link represents; -1: none */
    int reversed;           /* whether the body is on side 0 of the joint, so that joint coordinates have the opposite sign */
    int x, u;               /* index of its first coordinate and of its first rate */
    int drive, driven;      /* joint with one line that prescribes its motion, and that line; -1: none */
    int lock;               /* index in jo_data_locked() of the friction of the joint; -1: none */
} jo_link;

/* Joint, coupling or drive that is not a link of the tree: its rows close loops, see tree_loop_closure.c. */
typedef struct {
    int joint;
    int group, row;         /* group of loops with common links (consecutive), and first row within the group */
    int first, count;       /* range in reach[] */
} jo_loop;
/* link on the path from the sides of a loop to the root, children first; index of the reach of the parent, -1: ground */
typedef struct { int link, next; } jo_reach;
typedef struct { int one, other; } jo_meet;    /* two reaches (of loops one <= other) at the same link, or one reach twice */

/* Two joint sides on one body, which contribute to one block of S = Cq M^-1 Cq^T. */
typedef struct {
    int joint_k, side_k, joint_l, side_l;   /* elimination order of k >= that of l */
    int block;              /* block of S, or its transpose, that they contribute to */
} jo_pair;

/* A hub is a rigid body with many joints, whose rows would make S dense. Its six velocities, scaled to unit mass, are additional
 * unknowns of the factorisation (pseudo joints without sides, stored after the joints):
 * [D V; V^T -1] with S = D + V V^T, V = Cq L^-T of the rows on hubs and M = L L^T. */
typedef struct {
    int joint, side;        /* joint and side on a hub */
    int block, later;       /* block of V; whether the joint is eliminated after the hub */
} jo_pull;

/* Sparse block Cholesky S = L L^T: S_ij is block `block` (36 reals, leading dimension 6). */
typedef struct { int joint, first, count; } jo_column;   /* diagonal; range in below[] */
typedef struct { int block, joint; } jo_below;           /* L_ij below the diagonal of a column */
typedef struct { int target, left, right, left_rows, right_rows; } jo_update;   /* S_target -= L_left L_right^T */

/* Newton's matrix [M^ Cq^T; Cq 0] of the implicit methods by nodes: a body with the joints to its parent, or joints that
 * close a loop. Strides of blocks are rounded up to a multiple of JO_PAD. */
typedef struct {
    int body;               /* -1: joints only */
    int size, lead, at;     /* number of unknowns; number of those of the body, which come first; index of the first unknown */
    int diagonal;           /* offset of the diagonal block (size x size) in Newton's matrix */
    int first, count;       /* range in branch[] */
} jo_node;
/* blocks of a node and a later node, coupled by the first `width` unknowns of the latter: lower (width x size), upper (size x width) */
typedef struct { int node, width, lower, upper; } jo_branch;
typedef struct { int target, stride, left, right; } jo_fill;   /* block target -= lower of branch left times upper of branch right */
typedef struct { int node, local; } jo_place;   /* node of a body or joint, and index of its first unknown there */

/* Data of signals: of CONSTANT, INPUT, HARMONIC, STEP, SPEED the structs below; TABLE: t_k (count), f_k (count);
 * PIECES: t_k (count), (count - 1) x (degree + 1) coefficients of (t - t_k)^0, ^1, ..; constant beyond the ends */
typedef struct { jo_real value; } jo_constant_data;
typedef struct { jo_real offset, amplitude, omega, phase; } jo_harmonic_data;
typedef struct { jo_real time, before, after; } jo_step_data;
typedef struct { jo_real offset, speed; } jo_speed_data;
typedef struct {
    int type;               /* jo_signal_type */
    int count;              /* TABLE, PIECES: number of times; INPUT: index of the input; SWITCHED: event; DELAY: force */
    int degree;             /* PIECES: degree of the polynomials */
    int child[2];           /* SUM, PRODUCT: signals; SWITCHED: before and after the event */
    const jo_real *data;
} jo_signal;

/* y (6) = force and torque on b, resolved in a, from x (18) = [r_b - r_a (3), orientation of b (9, row-major),
 * velocity (3), angular velocity (3)] of b against a, resolved in a. Returns 0, or not 0 for an error. */
typedef int (*jo_callback)(double time, const double *x, double *y, void *user);

/* Force element. */
typedef struct {
    int type;               /* jo_force_type: JO_FORCE_load, ... */
    int a, b;               /* markers, -1 where not used */
    int coordinate, body;   /* -1 where not used */
    int other;              /* second coordinate, -1: none */
    /* follow: force in the frame of b; active: the power of the force counts as work, not as stored or dissipated energy */
    int follow, active;
    int signal, reference, spring, damper;   /* signals, -1: none; arguments of spring and damper are s and s' instead of time */
    const jo_real *data;    /* numbers of its kind, see JO_FORCES */
    jo_callback function;
    void *user;
    int release;            /* event that deactivates the force; -1: none */
    int state, states;      /* index of its first state, and number of states; -1, 0: none */
} jo_force;

/* Coefficients of friction; velocity, m/s, at which the regularised law reaches mu_static; lengths, m; preload, N; plane 1: N is |F_z|, of a
 * disc on a plane. mass, kg: that in play at the point of a contact. */
typedef struct { jo_real mu_kinetic, mu_static, velocity, radius, bearing, collar, preload, plane, mass; } jo_friction_data;
/* Coulomb friction of a joint along one or two of its coordinates. Normal force from the reaction F, M on side 1, resolved in side 0:
 * N = preload + |F_xy| + |M_xy| / bearing. Revolute (an angle): N at the pin radius and |F_z| at the collar radius; prismatic (a
 * displacement along z): |M_z| / collar adds to N; cylindrical (displacement and angle): against the slip at the radius. A
 * length of 0 omits its term. Of a contact: N from its law, and `joint` is the lock. */
typedef struct {
    int joint, coordinate;
    int other;              /* second coordinate, -1: none */
    int law;                /* 0: regularised, 1: stick-slip */
    int lock;               /* stick-slip: joint whose rows lock the coordinates while the joint sticks */
    int contact;            /* force that is the contact, a sphere or a point on a plane; -1: of a joint */
    const jo_friction_data *data;
} jo_friction;

/* Row that holds a coordinate at times: a stop at the limit that it has reached, or a lock from one event to another, see switched_rows.c.
 * Their optional joints, of one line each, come first among the optional joints. */
typedef struct { jo_real lower, upper, restitution, slowest; } jo_limits_data;
typedef struct {
    int joint;              /* its optional joint */
    int begin, end;         /* events that lock and unlock it; begin -1: a stop */
    const jo_limits_data *data;
} jo_switched;

/* Event: a sensor value crosses a threshold. */
typedef struct {
    int output;             /* index in the sensor vector */
    int others;             /* bit k: output + 1 + k belongs to it too, and the size of all these is watched; 0: one value */
    int direction;          /* crossings that count: 1 rising, -1 falling, 0 both */
    int stop;               /* whether jo_run ends and returns JO_EVENT */
    double threshold;       /* unit of the sensor value */
} jo_event;

typedef struct {
    int type;               /* jo_sensor_type */
    int object;             /* marker, body, joint, coordinate, force, signal, beam, or jo_energy_kind;
                             * SECTION: strains (6) and resultants (6) in the middle of the beam element, in its axes */
    int other, frame;       /* marker of the observer, marker of the axes; -1: world. ACCELERATION_PARTS (5 x 3: of the observer's
                             * frame, normal, tangential, Coriolis, relative): other -1 is the frame of the marker's body.
                             * ELEMENT, SECTION: other is the index of the first component; STRESS, BRIDGE: other is the signal of the
                             * apparent strain or of the change of temperature, -1: none; BODY_LOAD, MODAL_LOAD: other is the
                             * jo_load_kind */
    int offset, count;      /* range in the sensor vector */
    const jo_real *rows;    /* STRESS: (count x np), VON_MISES: (6 count x np), PRINCIPAL: (2 count x np), row-major;
                             * BRIDGE: (5 x np) relative resistance of four arms; the last row has their drifts, 1/K;
                             * CONTACT: what is summed, see contact_sensor.c; object: the first force of a contact, or a set */
} jo_sensor;

/* Damage meter: rainflow count of a value, sample by sample (four-point rule), and Miner's sum.
 *
 * Damage of a cycle of amplitude s = |range| / 2: (s / amplitude)^slope / cycles, below the knee with the slope `below`
 * (infinite: no damage), 0 below `cut`. s is first corrected for the mean stress M of the cycle:
 * LINE: s / (1 - M / strength), M < 0 included if `credit` is set (Goodman, Soderberg, Morrow); GERBER: s / (1 - (M / strength)^2), M > 0
 * WALKER: (M + s)^(1 - exponent) s^exponent (1/2: Smith, Watson, Topper); FKM: `sensitivity`
 * WELD: s / f(R) of the IIW, `relief` 0, 1, 2: high, medium, low residual stress; COMPRESSION: the compressive part times `share`
 *
 * Memory (JO_METER + depth doubles): number of turning points, samples, dropped samples (not finite), damage of
 * closed cycles and rounding error of its sum, closed cycles, forced ones of these, largest range of the forced ones, half cycles
 * removed from the front, their damage as full cycles, time of the last sample, smallest and largest sample; then the turning points.
 * All 0: no samples. */
typedef struct {
    int depth;              /* largest number of stored turning points, at least 6 */
    int mean;               /* jo_mean */
    int residue;            /* jo_residue */
    int output;             /* in a model: index of the value in the sensor vector */
    int at;                 /* in a model: offset of its memory in jo_data_memory() */
    double factor;          /* in a model: sample / sensor value */
    double width;           /* class width to which samples are rounded; 0: not rounded */
    double amplitude, cycles, slope, below, cut;   /* S-N curve; amplitudes in the unit of the samples */
    double strength, credit, exponent, sensitivity, relief, share;   /* parameters of the mean stress correction */
} jo_meter;

typedef struct {
    int nbody, nmarker, nactive, ncoordinate, njoint, nline, npair, ncolumn, nblock, nsignal, nforce, nfriction, nevent, nsensor;
    int nturn, nlock, ninput, nnode, nnewton;   /* nnewton: reals of Newton's matrix */
    int nmeter, nmemory;    /* number of damage meters and of doubles of their memory */
    int nbeam;
    int nstate;             /* first-order states of forces, x' = f(t, q, v, x) */
    int nyielding;          /* number of forces that yield, see jo_accept_yielding */
    int nswitched;          /* number of rows that are switched */
    int nbreak;             /* number of times at which a signal jumps or has a kink */
    int nq, nv, nrow, nout;
    int nlink, nx, nu;      /* links, joint coordinates and rates of trees; 0: maximal coordinates q, v only */
    int nloop, nreach, nmeet;
    int nhub, npull;        /* hubs, and joint sides on hubs */
    int redundant;          /* 1: redundant rows, multipliers of least norm; 0: redundant in singular positions only;
                             * -1: a singular position is an error */
    double size;            /* size of the mechanism, m: scale of tolerances */
    const jo_real *gravity; /* (3) m/s^2 */
    const jo_body *body;
    const jo_beam *beam;
    const jo_marker *marker;   /* the first nactive markers belong to joints and forces, the others to sensors */
    const jo_coordinate *coordinate;
    const jo_joint *joint;     /* (njoint + nhub) */
    const jo_line *line;
    const jo_pair *pair;
    const jo_pull *pull;
    const jo_column *column;
    const jo_below *below;
    const jo_update *update;
    const int *update_first;   /* (ncolumn + 1) range in update[] of each column */
    const jo_node *node;       /* in elimination order */
    const jo_branch *branch;
    const jo_fill *fill;
    const int *fill_first;     /* (nnode + 1) range in fill[] of each node */
    const jo_place *place;     /* (nbody + njoint) */
    const jo_signal *signal;
    const jo_force *force;
    const jo_friction *friction;
    const jo_switched *switched;
    const jo_event *event;
    const jo_sensor *sensor;
    const jo_meter *meter;  /* DAMAGE: object is the first of count / 2 meters, values damage and closed cycles of each */
    const jo_real *breaks;  /* (nbreak) times, s, ascending, at which adaptive steps end */
    const jo_link *link;    /* parents first */
    const jo_loop *loop;
    const jo_reach *reach;
    const jo_meet *meet;
} jo_model;

typedef struct {
    int method;             /* jo_method */
    int projection;         /* whether positions and velocities are projected onto the constraints after every step */
    double step;            /* step length, s; jo_follow: time between rows */
    double alpha, beta;     /* Baumgarte, 1/s: C'' + 2 alpha C' + beta^2 C = 0; 0: off */
    double alpha_m, alpha_f, newmark_beta, newmark_gamma;   /* alpha */
    double tolerance;       /* alpha: relative size of the last increment, 0: fixed number of iterations; dopri: relative error of a step */
    double error_share;     /* alpha: size of the last increment relative to the error of the step, where that is larger; 0: not used */
    double absolute;        /* dopri: absolute error of a step, m and m/s; of rotations: this / size of the mechanism */
    double largest;         /* dopri: largest step, s; 0: no limit */
    double first;           /* dopri: first step, s; 0: automatic */
    int iterations;         /* alpha: largest number of iterations of a step; dopri: of steps between two rows */
    int modified;           /* alpha: modified Newton method, which keeps factors while the iteration converges */
    int plain_inertia;      /* alpha: Newton's matrix without derivatives of inertia forces with respect to positions and velocities */
    int step_ends;          /* events and transitions of frictions take effect at the ends of steps, in bounded work; 0: located in time */
} jo_solver;

/* A row of JO_METHODS. */
enum { JO_MOST_STAGES = 4 };
typedef struct {
    int implicit;           /* of a Rosenbrock method, with g and g_ij */
    int order, stages;
    const double *coefficient;
} jo_tableau;

/* With step_ends: largest number of passes in which frictions start to slide or stick at the end of a step, and in which events cause others */
enum { JO_END_PASSES = 2 };

typedef struct jo_data jo_data;

int jo_abi(void);
int jo_model_size(void);                         /* size of a jo_model, bytes, for a check by the caller */
int jo_machines(void);                           /* number of machines computed at once: lanes of a jo_real */
int jo_cpu_level(void);                          /* x86-64 level of this processor (1, 3 or 4); 0 elsewhere */
const jo_tableau *jo_method_tableau(int method);   /* of a jo_method; no stages: its family has no tableau */
jo_data *jo_data_new(const jo_model *m);         /* NULL without memory */
long long jo_data_bytes(const jo_model *m);      /* size of a jo_data and all its arrays, bytes */
/* A point at which bodies touch or nearly do: force, and number among the points of this force; shape of a set that is touched, and the other
 * one, else -1; phase (0 apart, 1 sticks, 2 slips), code of the features of two polytopes (< 0: of a surface of
 * triangles); gap, m, < 0 in contact; place, m, and normal of
 * a, world; normal force N, N; friction force on b, N, world; rate of the depth, m/s; speed of approach, m/s, and time, s, of the last
 * touch; energy stored in the normal force and in the bristle, J; power that the normal force dissipates, and of friction, W; largest
 * pressure of a set whose law is that of Hertz, Pa, else 0 */
typedef struct {
    double force, number, shapes[2], phase, feature, gap, place[3], normal[3], N, friction[3], rate, speed, since, stored[2], power[2], pressure;
} jo_touch;
int jo_contact_report(const jo_model *m, jo_data *d, int most, jo_touch *out);   /* out (most), at the present state; their number */

/* A contact from its touch to its part: force; shapes of a set, as above; times of touch and part, s, NaN while it touches; speed of approach
 * and of parting, m/s; largest normal force, N, and depth, m; impulse of the normal force and of the size of the friction force, N s;
 * energy lost by the normal force and by friction, J; number of steps */
typedef struct { double force, shapes[2], touch, part, approach, rebound, largest, depth, impulse, rubbing, lost[2], steps; } jo_touched;
/* (count) those that have parted in the last jo_run, jo_step or jo_follow; dropped: for which there was no room, since the start */
const jo_touched *jo_data_touched(const jo_data *d, int *count, long long *dropped);
int jo_data_touching(const jo_model *m, const jo_data *d, jo_touched *out);   /* (nyielding) those that touch now; their number */
enum { JO_CONTACT_ENERGIES = 3 };
/* (JO_CONTACT_ENERGIES; none without contacts) energy stored in contacts at the last row, and what they have lost since the start by
 * their normal forces (restitution) and by friction, J */
jo_real *jo_data_contact_energy(jo_data *d);
enum { JO_DOUBT = 4, JO_MOST_DOUBTS = 16 };
/* steps so far in which a gap may have closed for a moment shorter than can be resolved. out (JO_MOST_DOUBTS x JO_DOUBT), the first of them:
 * time, s; force, -1: a pair of a set that was not searched; shape that is touched and tip of a pair in a slot, else -1 */
long long jo_data_unproven(const jo_data *d, double *out);
/* parts of steps in which no gap can have closed unseen: proven at once, after halvings of their length, up to an event; most halvings */
typedef struct { long long at_once, advanced, events, most; } jo_proof;
const jo_proof *jo_data_proof(const jo_data *d);
/* Openings of valves that pressures open, of all networks: out (2 x count), the largest change of each between stages of a method with networks
 * in its matrix, or between ends of steps of an implicit method, 1: from closed to open, and the time of the later one, s; counted anew then.
 * Returns their count. */
int jo_data_openings(jo_data *d, double *out);
enum { JO_BRIEF = 3, JO_MOST_BRIEF = 16 };
/* touches so far of contacts with resolve "report" that last for less than 10 steps. out (JO_MOST_BRIEF x JO_BRIEF), the first of them: time,
 * s; first state of the contact; duration by the law without loss, s */
long long jo_data_brief(const jo_data *d, double *out);
long long jo_data_room(const jo_model *m);       /* memory that jo_data_place needs, bytes, at any address */
jo_data *jo_data_place(const jo_model *m, void *memory);   /* jo_data_new in memory of the caller; without jo_data_free */
void jo_data_gravity(const jo_model *m, jo_data *d);       /* to be called after a change of the gravity of the model */
void jo_data_free(jo_data *d);
jo_real *jo_data_q(jo_data *d);                  /* (nq) */
jo_real *jo_data_v(jo_data *d);                  /* (nv) */
jo_real *jo_data_a(jo_data *d);                  /* (nv) */
jo_real *jo_data_lam(jo_data *d);                /* (nrow) */
jo_real *jo_data_time(jo_data *d);               /* (1) s */
jo_work *jo_data_work(jo_data *d);
const jo_work *jo_data_power(const jo_data *d);  /* rates, W, at the last evaluation of the accelerations */
jo_real *jo_data_input(jo_data *d);              /* (ninput) external inputs */
jo_real *jo_data_turn(jo_data *d);               /* (nturn) last accepted value of each counted angle, rad */
int *jo_data_locked(jo_data *d);                 /* (nlock) whether each optional joint is active */
int *jo_data_slip(jo_data *d);                   /* (nfriction) stick-slip: direction of the slip, +1 or -1; 0: sticks or undetermined */
jo_real *jo_data_direction(jo_data *d);          /* (2 nfriction) direction of the slip along two coordinates */
jo_real *jo_data_held(jo_data *d);               /* (2 nlock) values at which optional joints hold their coordinates */
jo_real *jo_data_rub(jo_data *d);                /* (2 nfriction) friction force along each coordinate on b, N or N m */
double *jo_data_memory(jo_data *d);              /* (nmemory) memory of the damage meters */
double *jo_data_bent(jo_data *d);                /* (nbeam x 2) largest values at the ends of steps: rotation between the ends of
                                                  * an element, rad, and tension / limit */
int *jo_data_happened(jo_data *d);               /* (nevent) number of occurrences of each event */
const double *jo_data_log(const jo_data *d);     /* (logged x 3) log of the last jo_run or jo_step: time; event, +1 rising or -1
                                                  * falling; or nevent + friction, new direction of its slip */
int jo_data_logged(const jo_data *d);
jo_real *jo_data_states(const jo_model *m, jo_data *d);    /* (nstate) states of forces */
jo_real *jo_data_state_rates(const jo_model *m, jo_data *d);   /* (nstate) their rates at the last evaluation */
jo_real *jo_data_joint(jo_data *d);              /* (nx + nu) joint coordinates and rates, which agree with q and v after a call */
jo_counts *jo_data_counts(jo_data *d);
void jo_data_count_turns(const jo_model *m, jo_data *d);   /* counted angles at the present state */
int jo_data_error_index(const jo_data *d);       /* body, joint, force ... of the last error, see jo_status */

int jo_accelerations(const jo_model *m, jo_data *d);          /* a, lam from time, q, v */
int jo_tree_accelerations(const jo_model *m, jo_data *d);     /* the same in joint coordinates; requires nlink > 0 */
int jo_rates(const jo_model *m, jo_data *d, double alpha, double beta, jo_real *qdot);   /* the same with Baumgarte terms; qdot (nq): q' */
int jo_assemble(const jo_model *m, jo_data *d, int iterations, double tolerance);   /* q, v that satisfy the constraints; tolerance in m */
int jo_step(const jo_model *m, jo_data *d, const jo_solver *s);
void jo_start_states(const jo_model *m, jo_data *d);      /* initial states of forces at q, v */
void jo_yield(const jo_model *m, jo_data *d);   /* states of forces that yield, after a slow motion to the present q, v */
void jo_restart(jo_data *d);      /* to be called after a replacement of the state: resets the history of methods and events */
void jo_energy(const jo_model *m, jo_data *d, jo_energies *out);
void jo_residuals(const jo_model *m, jo_data *d, jo_real *out);   /* (2) largest |C|, m, and |Cq v|, m/s, rows times jo_row_metres */
/* (nrow) length, m, that corresponds to a residual of 1 in each row of C: 1 for lengths, the size of the mechanism for angles and
 * cosines */
void jo_row_metres(const jo_model *m, jo_real *out);
void jo_constraints(const jo_model *m, jo_data *d, jo_real *c, jo_real *cdot);   /* (nrow) each */
void jo_mass_matrix(const jo_model *m, jo_data *d, int body, jo_real *M);        /* (6+n)^2, local */
int jo_residual(const jo_model *m, jo_data *d, jo_real *r);     /* (nv) M a + Cq^T lam - Q at time, q, v, a, lam */
int jo_body_loads(const jo_model *m, jo_data *d, int body, jo_real *out);   /* (nforce + nfriction + njoint) x (6 + n): [force, moment about
                                                                             * the origin, modal forces] of each, local, at time, q, v, lam */
/* (nv + nrow)^2 [ca M + cv D + cq K, Cq^T; d(Cq v)], the last with the same weights, at time, q, v, a, lam */
int jo_newton_matrix(const jo_model *m, jo_data *d, double ca, double cv, double cq, jo_real *out);
/* (nnewton) the same matrix in the memory layout of Newton's matrix, by the blocks of jo_node and jo_branch */
int jo_newton_values(const jo_model *m, jo_data *d, double ca, double cv, double cq, jo_real *out);
void jo_sensors(const jo_model *m, jo_data *d, jo_real *out);     /* (nout), after jo_accelerations */

/* Carry out nsteps steps; write a row whenever the step count is a multiple of `every`:
 * [time q v lam jo_diagnostics sensors states turn locked slip held direction happened input memory
 * joint].
 * count: number of steps so far, updated; written: number of rows. An event that stops the run writes an additional row. Fewer
 * steps are carried out if the log of events is full. Returns a jo_status. */
int jo_run(const jo_model *m, jo_data *d, const jo_solver *s, long long nsteps, long long every,
           long long *count, int *written, jo_real *rows);
/* Real-time execution of steps; wall-clock times, s. */
typedef struct {
    double step, farthest;     /* period of the steps; largest lateness, above which jo_paced returns */
    double ahead;              /* time until the next step is due, < 0: lateness; input and output */
    double latest, worst;      /* largest lateness and longest execution of a step so far */
    long long missed, done;    /* number of steps that ended after the next step was due; number of steps of the last call */
} jo_pace;
/* jo_run in real time, at most nsteps steps. late (nedge + 1): histogram of the lateness of the steps with the ascending edges.
 * Returns early after a step with an event. */
int jo_paced(const jo_model *m, jo_data *d, const jo_solver *s, jo_pace *p, int nsteps, int nedge, const double *edge,
             long long *late, long long every, long long *count, int *written, jo_real *rows);
/* Error control (dopri): rows at start + k step, k = *count .. last, from steps of variable length. *count = 0 starts at the present
 * state, which is the first row; later calls continue. Returns after `tries` steps or `room` rows at the latest. */
int jo_follow(const jo_model *m, jo_data *d, const jo_solver *s, long long last, long long tries, int room,
              long long *count, int *written, jo_real *rows);
int jo_row(const jo_model *m, jo_data *d, jo_real *row);   /* row of the present state, as jo_run writes it */
int jo_row_size(const jo_model *m);

/* Damage meters without a model; memory as at jo_meter, of n meters consecutively. */
double jo_cycle_amplitude(const jo_meter *r, double from, double to);   /* amplitude corrected for the mean stress */
double jo_cycle_damage(const jo_meter *r, double from, double to);
void jo_meter_push(const jo_meter *r, double *memory, const double *x, long long count);
void jo_meter_block(const jo_meter *r, double *memory, const double *x, long long count, long long n);   /* x (count x n) */
/* the same, with the closed cycles [from to] in `cycles` (count / 2 x 2); returns their number */
long long jo_meter_trace(const jo_meter *r, double *memory, const double *x, long long count, double *cycles);
/* damage including the residue by the rule jo_residue; scratch (JO_METER + 2 depth + 2) for REPEAT */
double jo_meter_damage(const jo_meter *r, const double *memory, int residue, double *scratch);
void jo_meter_damages(const jo_meter *r, const double *memory, long long n, int residue, double *scratch, double *out);
int jo_meter_valid(const jo_meter *r, const double *memory);   /* whether the memory is consistent */
/* Rainflow count of a history of `count` finite samples: cycles (count / 2 x 2) [from to] and their indices where (count / 2 x 2),
 * residue (count) and its indices residue_where (count), its length. Returns the number of closed cycles. */
long long jo_rainflow(const double *x, long long count, double *cycles, long long *where, double *residue,
                      long long *residue_where, long long *length);

/* Damage on planes through a point (critical_planes.c): largest damage of `turns` shear directions in each plane, or by normal stress.
 * Damage of a cycle of shear amplitude a and largest normal stress n in it:
 * FINDLEY: S-N curve at 2 (a + k n) / (k + sqrt(1 + k^2)); STRAIN: table of ln(1 / N) over ln(a (1 + k n)) */
typedef enum { JO_PLANE_NORMAL = 0, JO_PLANE_FINDLEY = 1, JO_PLANE_STRAIN = 2 } jo_plane_kind;
typedef struct {
    int kind;               /* jo_plane_kind */
    int residue;            /* jo_residue */
    double k;
    double p;               /* smallest exponent with which damage grows with the amplitude; 0: unknown */
    long long planes, turns, points;
    const double *rows;     /* (planes x 3 x 6) rows for stresses 11 22 33 12 23 13: normal stress, shear along two directions */
    const double *turn;     /* (turns x 2) cosine and sine of the shear directions */
    const double *table;    /* STRAIN: (points) at ln(a) = first + i step */
    double first, step;
} jo_planes;
/* s (nt x 6); scratch (6 nt + 4 + planes turns), order (planes turns); damage and index of the plane with the largest damage, the
 * first one of planes that agree to 1e-9 */
void jo_plane_damage(const jo_planes *r, const jo_meter *curve, const double *s, long long nt, double *scratch,
                     long long *order, double *damage, long long *plane);

/* States of values of measured channels (channel_health.c) */
typedef enum { JO_VALUE_OK = 0, JO_VALUE_DROPOUT = 1, JO_VALUE_NAN = 2, JO_VALUE_SATURATED = 3, JO_VALUE_STUCK = 4,
               JO_VALUE_SPIKE = 5, JO_VALUE_BACK = 6 } jo_value;
/* rows of the memory of a channel: last value, last valid value, mean step and number of samples in it, consecutive samples of the same
 * value and those of them in which other channels changed, samples at a new level, consecutive valid samples */
typedef enum { JO_HEALTH_LAST = 0, JO_HEALTH_GOOD = 1, JO_HEALTH_USUAL = 2, JO_HEALTH_SEEN = 3, JO_HEALTH_SAME = 4,
               JO_HEALTH_MOVES = 5, JO_HEALTH_LEVEL = 6, JO_HEALTH_WELL = 7 } jo_health_row;
typedef struct {
    int empty, infinite;    /* codes in `cells` of a missing and of an infinite value */
    double range, stuck, spike, back;   /* largest magnitude; samples; step / mean step, 0: not checked; samples */
    double follow;          /* weight of a step in the mean step */
    double warm, persist;   /* samples before spikes are detected; samples after which a new level is valid */
} jo_health;
/* x, states (count x n); cells (count x n) or NULL; memory (jo_health_row x n); before (n): states of the last samples */
void jo_health_check(const jo_health *r, double *memory, const unsigned char *before, const double *x,
                     const unsigned char *cells, unsigned char *states, long long count, long long n);

/* Stress fields without a model (stress_recovery.c): p (nt x k), S in tiles of JO_LANES sites, (k x rows x JO_LANES) each, the last tile
 * padded with 0. */
enum { JO_LANES = 8 };
typedef enum { JO_NORM = 0,             /* scale |rows| */
               JO_WEIGHTED = 1,         /* scale w . rows, w (nt x rows); NULL: their sum */
               JO_SIGNED_MISES = 2,     /* this and the following criteria: 6 rows, a tensor 11 22 33 12 23 13 */
               JO_PRINCIPAL_1 = 3, JO_PRINCIPAL_2 = 4, JO_PRINCIPAL_3 = 5,
               JO_SIGNED_PRINCIPAL = 6,
               JO_SHEAR = 7             /* scale (largest - smallest principal value) */
} jo_criterion;
/* out (nt x stride), of which the first ns columns are written */
void jo_recover(const double *S, long long ns, int rows, int k, const double *p, long long nt, const double *w,
                int criterion, double scale, double *out, long long stride);
/* low, high (ns): minima and maxima, updated; low_at, high_at (ns): their instants, counted from `first` */
void jo_recover_extremes(const double *S, long long ns, int rows, int k, const double *p, long long nt, const double *w,
                         int criterion, double scale, long long first, double *low, long long *low_at, double *high,
                         long long *high_at);
/* unit normal from a to b (3) and signed distance, m, of two convex polytopes; data: numbers of both, as after the law of a contact_pair;
 * b is at r (3), turned by R (9) */
void jo_pair_distance(const jo_real *data, const jo_real *r, const jo_real *R, double *y);
/* principal values (count x 3), descending, of s (count x 6); directions (count x 3 x 3) in columns, or NULL */
void jo_principal(const double *s, long long count, double *values, double *directions);
/* END */

#endif
