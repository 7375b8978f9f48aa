/* jousto.h - the public interface of the jousto engine (C99).
 *
 * A const jo_model holds sizes and constants, a jo_data the state and the workspace of one run.
 * A step allocates nothing, touches no globals and prints nothing; every function is re-entrant.
 *
 * Frames: no suffix = resolved in the world frame, _local = resolved in the body frame.
 * Units: SI. Symmetric 3x3 tensors are stored as xx yy zz yz xz xy.
 * Modal arrays are component-major, (c x np), np = n padded with zeros to a multiple of JO_PAD.
 *
 * The lines between the marks BEGIN and END are also read by the Python binding; they hold only
 * enums, structs with pointers and plain integers and doubles, and function declarations.
 */
#ifndef JOUSTO_H
#define JOUSTO_H

#if defined(JO_VECTOR)            /* how many machines of one structure lie side by side in the lanes of a vector */
typedef double jo_real __attribute__((vector_size(8 * JO_VECTOR)));
#elif defined(JO_COMPLEX)
#include <complex.h>
typedef double complex jo_real;  /* complex-step derivatives of anything the engine computes */
#else
typedef double jo_real;
#endif

/* The kinds of force: a row each, ROW(name, its numbers), read by the Python binding as well. A row makes the number of the kind,
 * JO_FORCE_name, and the type of its data, jo_name_data, and puts jo_force_name, which its file force_name.c defines, into the
 * table of force_table.c.
 *
 * load: at b; in the world or following b, times signal
 * along: f = stiffness (reference - s) + damping (reference' - s') + preload signal(t) + spring(s) + damper(s'),
 *   reference = free + its signal; limited to +-limit if limit > 0
 * bushing: [force, torque] on b, resolved in a, from [r_b - r_a, rotation vector]; matrices by rows
 * stop: f = -stiffness d (1 + loss s(d'/speed)) against d, how far s is beyond lower or upper; see force_stop.c
 * modal_load: on the body's frame, local, then (np) on its modes; times signal
 * user: calls its function, has no data
 * pid: a controller with an integral part and a filter, see force_pid.c; its two states from `state` on
 * moving_load: a force in the world or following the body; then s.. (count), then (count - 1) pieces (1 + modes) x 3 x 4:
 *   (s - s_k)^0..3 of the position and of each mode; at s = reference(t), times signal; nothing beyond the ends */
#define JO_FORCES(ROW) \
    ROW(load, force[3], torque[3]) \
    ROW(along, stiffness, damping, free, preload, limit) \
    ROW(bushing, K[36], D[36], preload[6]) \
    ROW(stop, stiffness, lower, upper, loss, speed) \
    ROW(modal_load, force[3], torque[3]) \
    ROW(user, none) \
    ROW(moving_load, count, modes, force[3]) \
    ROW(pid, proportional, integral, derivative, weight, filter, filter_share, tracking, tracking_share, lower, upper, start, speed) \
    /* the last row */

#define JO_FORCE_NUMBER(name, ...) JO_FORCE_##name,
#define JO_FORCE_DATA(name, ...) typedef struct { jo_real __VA_ARGS__; } jo_##name##_data;
typedef enum { JO_FORCES(JO_FORCE_NUMBER) } jo_force_type;
JO_FORCES(JO_FORCE_DATA)

/* BEGIN */
enum { JO_ABI = 16 };           /* raised whenever a struct or a meaning below changes */
enum { JO_PAD = 4 };           /* modal coordinates are padded to a multiple of this */
enum { JO_ROW_D = 24 };        /* rows of one block of jo_body.ED */
enum { JO_ROW_B = 12 };        /* rows of one block of jo_body.EB */
enum { JO_DENSE = 32 };        /* np up to which ED, EB are blocks of rows, above it triangles of tiles */
enum { JO_MAX_ROWS = 6 };      /* constraint rows of one joint */

/* numbers of a damage meter before its turning points, see jo_meter */
typedef enum { JO_METER_POINTS = 0, JO_METER_SAMPLES = 1, JO_METER_DROPPED = 2, JO_METER_DAMAGE = 3, JO_METER_ROUNDING = 4,
               JO_METER_CLOSED = 5, JO_METER_FORCED = 6, JO_METER_LARGEST_FORCED = 7, JO_METER_SHED = 8,
               JO_METER_SHED_DAMAGE = 9, JO_METER_TIME = 10, JO_METER_SMALLEST = 11, JO_METER_LARGEST = 12,
               JO_METER = 13 } jo_meter_place;
enum { JO_MAX_SIDES = 4 };     /* markers of one joint: two, or those of two coupled coordinates */

typedef enum { JO_OK = 0, JO_NOT_FINITE = 1, JO_SINGULAR_BODY = 2, JO_SINGULAR_JOINT = 3, JO_NO_MEMORY = 4,
               JO_CALLBACK_FAILED = 5,    /* error_index: force */
               JO_NO_CONVERGENCE = 6,     /* Newton's iteration of a step; error_index: body of the largest residual */
               JO_FRICTION_FAILED = 7,    /* no reaction agrees with its own friction; error_index: friction */
               JO_EVENT = 8,              /* the state stands at an event; error_index: event */
               JO_STEP_TOO_SMALL = 9,
               JO_ENDLESS = 10,           /* events without end within one step; error_index: event, or nevent + friction */
               JO_BENT = 11               /* a beam element is bent by half a turn; error_index: beam */
} jo_status;
typedef enum { JO_RK4 = 1, JO_ROS2 = 2, JO_ALPHA = 3, JO_DOPRI = 4 } jo_method;
typedef enum { JO_SIGNAL_CONSTANT = 0, JO_SIGNAL_HARMONIC = 1, JO_SIGNAL_TABLE = 2, JO_SIGNAL_STEP = 3,
               JO_SIGNAL_PIECES = 4, JO_SIGNAL_SUM = 5, JO_SIGNAL_PRODUCT = 6, JO_SIGNAL_INPUT = 7,
               JO_SIGNAL_SWITCHED = 8, JO_SIGNAL_SPEED = 9 } jo_signal_type;
typedef enum { JO_COORDINATE_AXES = 1,        /* (axis_a of a) . (axis_b of b) */
               JO_COORDINATE_ALONG = 2,       /* (axis_a of a) . (r_b - r_a), m */
               JO_COORDINATE_DISTANCE = 3,    /* |r_b - r_a|, m */
               JO_COORDINATE_ANGLE = 4        /* turn of b against a about z of a, rad, without jumps of 2 pi */
} jo_coordinate_type;
typedef enum { JO_SENSOR_POSITION = 1, JO_SENSOR_VELOCITY = 2, JO_SENSOR_ORIENTATION = 3, JO_SENSOR_ANGULAR_VELOCITY = 4,
               JO_SENSOR_MODAL = 5, JO_SENSOR_REACTION = 6, JO_SENSOR_STRESS = 7, JO_SENSOR_ACCELERATION = 8,
               JO_SENSOR_ANGULAR_ACCELERATION = 9, JO_SENSOR_COORDINATE = 10, JO_SENSOR_RATE = 11,
               JO_SENSOR_MULTIPLIER = 12, JO_SENSOR_ELEMENT = 13, JO_SENSOR_ENERGY = 14, JO_SENSOR_SIGNAL = 15,
               JO_SENSOR_VON_MISES = 16, JO_SENSOR_PRINCIPAL = 17, JO_SENSOR_FRICTION = 18, JO_SENSOR_DAMAGE = 19,
               JO_SENSOR_BRIDGE = 21, JO_SENSOR_SECTION = 22,
               JO_SENSOR_ACCELERATION_PARTS = 23,
               JO_SENSOR_DEFORMATION_MOMENTUM = 24 } jo_sensor_type;
typedef enum { JO_ENERGY_KINETIC = 0, JO_ENERGY_STRAIN = 1, JO_ENERGY_POTENTIAL = 2, JO_ENERGY_SPRINGS = 3,
               JO_ENERGY_DISSIPATED = 4, JO_ENERGY_FRICTION = 5, JO_ENERGY_WORK = 6 } jo_energy_kind;
typedef enum { JO_RESIDUE_HALF = 0, JO_RESIDUE_REPEAT = 1, JO_RESIDUE_IGNORE = 2 } jo_residue;
typedef enum { JO_MEAN_NONE = 0, JO_MEAN_LINE = 1, JO_MEAN_GERBER = 2, JO_MEAN_WALKER = 3, JO_MEAN_FKM = 4,
               JO_MEAN_WELD = 5, JO_MEAN_COMPRESSION = 6 } jo_mean;

/* Energy that a mechanism has, J: that of modes and beams is `strain`. */
typedef struct { jo_real kinetic, strain, potential, springs; } jo_energies;

/* Energy lost to damping and to friction and work done by forces and drives, J, or their rates, W. */
typedef struct { jo_real damping, friction, forces; } jo_work;

/* What a row of results says of the instant, between the multipliers and the sensors: energy, J; largest |C| and |Cq v|;
 * since the start evaluations, Newton iterations, steps and those tried again; length of the last step, s. */
typedef struct {
    jo_real kinetic, strain, potential, springs, dissipated, friction, work, position_residual, velocity_residual;
    jo_real evaluations, iterations, steps, rejected, step;
} jo_diagnostics;

/* How often something was done; singular: evaluations in a singular position. */
typedef struct { long long evaluations, iterations, factorisations, rejected, singular, steps; } jo_counts;

/* A rigid (n = 0) or modal body: displacement field u = u0 + Phi p in a floating frame. */
typedef struct {
    int n, np;              /* modal coordinates, and padded */
    int iq, iv;             /* offsets of [R e p] in q and of [R' w_local p'] in v */
    const jo_real *mass;    /* (1)       kg */
    const jo_real *S0;      /* (3)       first moment I2 */
    const jo_real *J0;      /* (6)       inertia tensor I7 about the frame origin */
    const jo_real *I3;      /* (3 x np)  int phi dm */
    const jo_real *B0;      /* (3 x np)  I4: int u0 x phi_j dm */
    const jo_real *D0;      /* (6 x np)  half the derivative of J with respect to p_j at p = 0 */
    /* np <= JO_DENSE: rows c np + j in blocks of JO_ROW_D or JO_ROW_B, each block (n x rows).
     * Else for every component c the tiles [k][j] of 4 x 4 with j-block >= k-block, k-block after k-block. */
    const jo_real *ED;      /* (6 np x n) d D_j / d p_k, symmetric in j, k */
    const jo_real *EB;      /* (3 np x n) int phi_k x phi_j dm, antisymmetric */
    const jo_real *K;       /* (np)      modal stiffness omega^2, rad^2/s^2 */
    const jo_real *D;       /* (np)      modal damping 2 zeta omega, 1/s */
    double alpha;           /*           damping of the momenta, 1/s: forces -alpha M v; bodies without modes only */
} jo_body;

/* A frame on a body: at a node with translation and rotation mode shapes, or rigid. */
typedef struct {
    int body;               /* -1: ground */
    int turns;              /* its orientation is needed at every evaluation, not only by sensors */
    const jo_real *u0;      /* (3)       undeformed position, local */
    const jo_real *A0;      /* (9)       undeformed orientation, local, row-major */
    const jo_real *Phi;     /* (3 x np)  translation mode shapes, 0 where rigid */
    const jo_real *Psi;     /* (3 x np)  rotation mode shapes, 0 where rigid or not needed */
    const jo_real *chi;     /* (6 n x np) second-order translation and rotation chi_jk, symmetric; 0 without stiffening */
} jo_marker;

/* A geometrically exact beam element between two bodies without modes, see beam.c. Matrices by rows. */
typedef struct {
    jo_real length;
    jo_real u_a[3], B_a[9], u_b[3], B_b[9];   /* ends and their frames (x along the beam) on the bodies */
    jo_real C[36];          /* section stiffness on [Gamma, kappa] */
    jo_real e0[6];          /* strains of the unstressed shape */
    jo_real beta;           /* damping of the stiffness, s */
    jo_real alpha;          /* damping of the consistent mass, 1/s (the bodies damp their own) */
    jo_real share;          /* of the consistent mass beyond the bodies' lumped one */
    jo_real mass, J[6];     /* mass and rotary inertia of the whole element in the frames of its ends */
    jo_real limit;          /* tension times this is compared with 1; 0: never */
    jo_real helical;        /* 1 if the axis is a screw line between the ends (beam_helix.c), 0 if it is their chord */
    jo_real polar;          /* Ip/A about the shear centre, m2: twist stretches the fibres (beam_fibre.c); 0: not */
} jo_beam_data;
typedef struct {
    int a, b;               /* bodies */
    const jo_beam_data *data;
} jo_beam;

/* A scalar function of two frames a, b. */
typedef struct {
    int type;               /* jo_coordinate_type */
    int a, b;               /* markers */
    int axis_a, axis_b;     /* AXES, ALONG */
    int turn;               /* ANGLE: its place among the counted turns, else -1 */
    int link;               /* whose joint coordinate it is, up to the sign; -1: of none */
} jo_coordinate;

/* One row: sum over i of factor_i coordinate_i - offset - signal(t) = 0; optional joints hold the offsets of jo_data_held(). */
typedef struct { jo_real offset, factor[2]; } jo_line_data;
typedef struct {
    int count;              /* 1 or 2 coordinates */
    int coordinate[2];
    int side[2];            /* side of the joint that is marker a of the coordinate; b is the next */
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
    int line;               /* first of its lines */
    int nrow, row;          /* rows, and offset in lam */
    int lock;               /* the rows exist only while jo_data_locked()[lock] is not 0; -1: always */
    int release;            /* the rows exist only until this event has happened; -1: always */
} jo_joint;

/* A tree of rigid bodies in joint coordinates, see tree.c: a link moves against the one before it, which may be the ground, in the
 * frame of a marker of that one's body. Its own frame is that of its inner marker; a hinge turns about z and a slide moves along it.
 * A joint of two motions has a link without a body for the first one: slide, then hinge of a cylindrical joint; of a universal joint
 * hinge about z, then about what was x. */
typedef enum { JO_LINK_FIXED = 0, JO_LINK_HINGE = 1, JO_LINK_SLIDE = 2, JO_LINK_BALL = 3, JO_LINK_FREE = 4,
               JO_LINK_BODY = 5     /* runs by the rows of its joints and carries rigid trees, see tree_on_flexible_bodies.c; all of them come first */
} jo_link_type;
typedef struct {
    int type;               /* jo_link_type; BALL: (4) quaternion, (3) angular velocity against the parent, local;
                             * FREE, BODY: [R e p] and [R' w_local p'] of the body */
    int parent;             /* a link before it; -1: ground */
    int body;               /* -1: none, its only child has the body of the joint */
    int outer;              /* marker on the body of the parent; -1: the frame of the parent, which has no body; ground: of FREE, BODY */
    int crossed;            /* outer -1: y, z, x of the parent are its x, y, z */
    int inner;              /* marker on its body; -1: none, or FREE, BODY */
    int joint;              /* whose reaction it bears; -1: none */
    int reversed;           /* its body has side 0 of the joint: the coordinates of the joint are the opposite of its own */
    int x, u;               /* first of its coordinates and of their rates */
    int drive, driven;      /* joint of one line that prescribes it, and its line; -1: none */
    int lock;               /* lock of the friction that may hold it; -1: none */
} jo_link;

/* A joint, coupling or drive that no link of the tree is: its rows close loops, see tree_loop_closure.c. */
typedef struct {
    int joint;
    int group, row;         /* loops with a link in common, and its first row among theirs; loops of a group follow one another */
    int first, count;       /* range in reach[] */
} jo_loop;
typedef struct { int link, next; } jo_reach;   /* a link that bears sides of a loop, children first; reach of its parent, -1: ground */
typedef struct { int one, other; } jo_meet;    /* two reaches of one link, that of the loop first that comes first; or one twice */

/* Two joint sides on one body: their contribution to one block of S = Cq M^-1 Cq^T. */
typedef struct {
    int joint_k, side_k, joint_l, side_l;   /* elimination order of k >= that of l */
    int block;              /* block of S, or its transpose, that receives it */
} jo_pair;

/* A hub is a rigid body with many joints, whose rows would fill a dense S. Its six velocities in units of unit mass are
 * unknowns of the factorisation beside the multipliers, pseudo joints without a side behind the joints:
 * [D V; V^T -1] with S = D + V V^T, V = Cq L^-T of the rows on hubs and M = L L^T. */
typedef struct {
    int joint, side;        /* on a hub */
    int block, later;       /* that V goes to; whether the joint is eliminated after the hub */
} jo_pull;

/* Sparse block Cholesky S = L L^T: S_ij is block `block` (36 reals, leading dimension 6). */
typedef struct { int joint, first, count; } jo_column;   /* diagonal; range in below[] */
typedef struct { int block, joint; } jo_below;           /* L_ij below the diagonal of a column */
typedef struct { int target, left, right, left_rows, right_rows; } jo_update;   /* S_target -= L_left L_right^T */

/* Newton's matrix [M^ Cq^T; Cq 0] of the implicit methods by nodes: a body with the joints that carry it, or joints that
 * close a loop. Strides of blocks are rounded up to a multiple of JO_PAD. */
typedef struct {
    int body;               /* -1: joints only */
    int size, lead, at;     /* unknowns, those of the body, which come first, and the first one in the vector of unknowns */
    int diagonal;           /* first real of the diagonal block (size x size) */
    int first, count;       /* range in branch[] */
} jo_node;
/* blocks of a node with a later one, of which `width` leading unknowns count: lower (width x size), upper (size x width) */
typedef struct { int node, width, lower, upper; } jo_branch;
typedef struct { int target, stride, left, right; } jo_fill;   /* target -= lower of branch left, upper of branch right */
typedef struct { int node, local; } jo_place;   /* of a body or joint among the nodes */

/* Data of signals: CONSTANT and INPUT, HARMONIC, STEP, SPEED as here; TABLE: t.., f..;
 * PIECES: t.., then (count - 1) x (degree + 1) coefficients of (t - t_k)^0, ^1, ..; held outside */
typedef struct { jo_real value; } jo_constant_data;
typedef struct { jo_real offset, amplitude, omega, phase; } jo_harmonic_data;
typedef struct { jo_real time, before, after; } jo_step_data;
typedef struct { jo_real offset, speed; } jo_speed_data;
typedef struct {
    int type;               /* jo_signal_type */
    int count;              /* TABLE, PIECES: times; INPUT: its place among the inputs; SWITCHED: event */
    int degree;             /* PIECES: of the polynomials */
    int child[2];           /* SUM, PRODUCT: signals; SWITCHED: before and after the event */
    const jo_real *data;
} jo_signal;

/* y (6) = force and torque on b, resolved in a, from x (18) = [r_b - r_a (3), orientation of b (9, row-major),
 * velocity (3), angular velocity (3)] of b against a, resolved in a. Returns 0, or not 0 for an error. */
typedef int (*jo_callback)(double time, const double *x, double *y, void *user);

/* Where something pushes. */
typedef struct {
    int type;               /* jo_force_type: JO_FORCE_load, ... */
    int a, b;               /* markers, -1 where not used */
    int coordinate, body;   /* -1 where not used */
    int follow, active;     /* active: its power counts as work, nothing as stored or dissipated */
    int signal, reference, spring, damper;   /* signals, -1: none; spring and damper take s and s' instead of time */
    const jo_real *data;    /* of its kind; USER: none, it calls its function */
    jo_callback function;
    void *user;
    int release;            /* it acts only until this event has happened; -1: always */
    int state, states;      /* first of its states and how many, of kinds that have some; -1, 0: none */
} jo_force;

/* Velocity in m/s, lengths in m, preload in N. */
typedef struct { jo_real mu_kinetic, mu_static, velocity, radius, bearing, collar, preload; } jo_friction_data;
/* Friction of a joint along one or two of its coordinates, pressed by the joint's own reaction on side 1, resolved in side 0:
 * N = preload + |F_xy| + |M_xy| / bearing. Revolute (an angle): N at the pin radius and |F_z| at the collar radius; prismatic (a
 * displacement along z): |M_z| / collar adds to N; cylindrical (displacement and angle): against the slip at the radius. Lengths
 * of 0 do not count. */
typedef struct {
    int joint, coordinate;
    int other;              /* second coordinate, -1: none */
    int law;                /* 0: regularised, 1: stick-slip */
    int lock;               /* stick-slip: joint whose rows hold the coordinates while they stick */
    const jo_friction_data *data;
} jo_friction;

/* A sensor value crosses a threshold. */
typedef struct {
    int output;             /* place in the sensor vector */
    int direction;          /* 1 rising, -1 falling, 0 both */
    int stop;               /* jo_run returns JO_EVENT */
    double threshold;
} jo_event;

typedef struct {
    int type;               /* jo_sensor_type */
    int object;             /* marker, body, joint, coordinate, force, signal, beam, or jo_energy_kind;
                             * SECTION: strains (6) and resultants (6) in the middle of the beam element, in its axes */
    int other, frame;       /* markers: of the observer, of the axes; -1: the world. ACCELERATION_PARTS (5 x 3: of the observer's frame,
                             * normal, tangential, Coriolis, relative): other -1 is the frame of the marker's own body. ELEMENT, SECTION: other is the first component;
                             * STRESS, BRIDGE: other is a signal of apparent strain, of change of temperature; -1: none */
    int offset, count;      /* place in the sensor vector */
    const jo_real *rows;    /* STRESS: (count x np), VON_MISES: (6 count x np), PRINCIPAL: (2 count x np), row-major;
                             * BRIDGE: (5 x np) relative resistance of four arms, then in the last row their drifts */
} jo_sensor;

/* A damage meter: rainflow count of one value as it comes (four-point rule) and Miner's sum.
 *
 * Damage of a cycle of amplitude s = |range| / 2: (s / amplitude)^slope / cycles, below the knee with the slope `below`
 * (infinite: none), none at all below `cut`. Before that s is corrected for the mean stress M of the cycle:
 * LINE: s / (1 - M / strength), M < 0 counts if `credit` (Goodman, Soderberg, Morrow); GERBER: s / (1 - (M / strength)^2), M > 0
 * WALKER: (M + s)^(1 - exponent) s^exponent (1/2: Smith, Watson, Topper); FKM: `sensitivity`
 * WELD: s / f(R) of the IIW, `relief` 0, 1, 2: high, medium, low residual stress; COMPRESSION counts by its `share`
 *
 * Memory (JO_METER + depth doubles): points on the stack, samples, samples dropped (not finite), damage of closed cycles
 * and what its sum lost to rounding, closed cycles, of these closed by force, their largest range, half cycles taken from
 * the front, their damage as full cycles, time of the last sample, smallest, largest sample, then the stack. All 0: new. */
typedef struct {
    int depth;              /* turning points that it remembers, at least 6 */
    int mean;               /* jo_mean */
    int residue;            /* jo_residue */
    int output;             /* in a model: place of the value in the sensor vector */
    int at;                 /* in a model: first double of its memory */
    double factor;          /* in a model: samples are values times it */
    double width;           /* samples are rounded to multiples of it; 0: not */
    double amplitude, cycles, slope, below, cut;   /* of the S-N curve; amplitudes in the unit of the samples */
    double strength, credit, exponent, sensitivity, relief, share;   /* of the mean stress correction, those that it has */
} jo_meter;

typedef struct {
    int nbody, nmarker, nactive, ncoordinate, njoint, nline, npair, ncolumn, nblock, nsignal, nforce, nfriction, nevent, nsensor;
    int nturn, nlock, ninput, nnode, nnewton;   /* nnewton: reals of Newton's matrix */
    int nmeter, nmemory;    /* damage meters and the doubles that they remember */
    int nbeam;
    int nstate;             /* first-order states of forces, x' = f(t, q, v, x) */
    int nbreak;             /* times at which a signal jumps or has a kink */
    int nq, nv, nrow, nout;
    int nlink, nx, nu;      /* joint coordinates and rates of a tree; 0: everything runs in q and v */
    int nloop, nreach, nmeet;
    int nhub, npull;        /* rigid bodies with many joints */
    int redundant;          /* 1: rows repeat one another, multipliers of least norm; 0: only in singular positions;
                             * -1: never, a singular position is an error */
    double size;            /* m, of the mechanism: measure of what is small */
    const jo_real *gravity; /* (3) m/s^2 */
    const jo_body *body;
    const jo_beam *beam;
    const jo_marker *marker;   /* the first nactive belong to joints and forces, the rest to sensors */
    const jo_coordinate *coordinate;
    const jo_joint *joint;     /* (njoint + nhub) */
    const jo_line *line;
    const jo_pair *pair;
    const jo_pull *pull;
    const jo_column *column;
    const jo_below *below;
    const jo_update *update;
    const int *update_first;   /* (ncolumn + 1) range of updates made by each column */
    const jo_node *node;       /* in elimination order */
    const jo_branch *branch;
    const jo_fill *fill;
    const int *fill_first;     /* (nnode + 1) range of fills made by each node */
    const jo_place *place;     /* (nbody + njoint) */
    const jo_signal *signal;
    const jo_force *force;
    const jo_friction *friction;
    const jo_event *event;
    const jo_sensor *sensor;
    const jo_meter *meter;  /* DAMAGE: object is the first of count / 2 meters, values damage and closed cycles of each */
    const jo_real *breaks;  /* (nbreak) s, ascending: adaptive steps end there */
    const jo_link *link;    /* parents first */
    const jo_loop *loop;
    const jo_reach *reach;
    const jo_meet *meet;
} jo_model;

typedef struct {
    int method;             /* jo_method */
    int projection;         /* positions and velocities are projected after every step */
    double step;            /* s; jo_follow: between rows */
    double alpha, beta;     /* Baumgarte: C'' + 2 alpha C' + beta^2 C = 0; 0 = off */
    double alpha_m, alpha_f, newmark_beta, newmark_gamma;   /* ALPHA */
    double tolerance;       /* ALPHA: Newton, relative, 0: always all iterations; DOPRI: relative error of a step */
    double absolute;        /* DOPRI: errors below it do not matter, m (m/s; rotations: over the size of the mechanism) */
    double largest;         /* DOPRI: largest step, s; 0: none */
    double first;           /* DOPRI: first step, s; 0: automatic */
    int iterations;         /* ALPHA: most iterations of a step; DOPRI: most steps between two rows */
    int modified;           /* ALPHA: keep the factors while they converge */
    int plain_inertia;      /* ALPHA: how inertia forces change with positions and velocities is left out of Newton's matrix */
} jo_solver;

typedef struct jo_data jo_data;

int jo_abi(void);
int jo_model_size(void);                         /* bytes of a jo_model, to compare with the caller's */
int jo_machines(void);                           /* machines side by side: numbers in a jo_real, and so in every array of them */
int jo_cpu_level(void);                          /* x86-64 level of this processor (1, 3 or 4); 0 elsewhere */
jo_data *jo_data_new(const jo_model *m);         /* 0 if there is no memory */
long long jo_data_bytes(const jo_model *m);      /* of a jo_data and all it points to but the model */
long long jo_data_room(const jo_model *m);       /* bytes that jo_data_place needs, at any address */
jo_data *jo_data_place(const jo_model *m, void *memory);   /* the same as jo_data_new in memory of the caller's, without jo_data_free */
void jo_data_gravity(const jo_model *m, jo_data *d);       /* the gravity of the model was changed */
void jo_data_free(jo_data *d);
jo_real *jo_data_q(jo_data *d);                  /* (nq) */
jo_real *jo_data_v(jo_data *d);                  /* (nv) */
jo_real *jo_data_a(jo_data *d);                  /* (nv) */
jo_real *jo_data_lam(jo_data *d);                /* (nrow) */
jo_real *jo_data_time(jo_data *d);               /* (1) s */
jo_work *jo_data_work(jo_data *d);
const jo_work *jo_data_power(const jo_data *d);  /* W, of the last evaluation of the accelerations */
jo_real *jo_data_input(jo_data *d);              /* (ninput) external inputs */
jo_real *jo_data_turn(jo_data *d);               /* (nturn) last accepted value of every unwrapped angle, rad */
int *jo_data_locked(jo_data *d);                 /* (nlock) optional joints that hold now */
int *jo_data_slip(jo_data *d);                   /* (nfriction) stick-slip: +-1 slips this way, 0 sticks or is not decided */
jo_real *jo_data_direction(jo_data *d);          /* (2 nfriction) direction of the slip along two coordinates */
jo_real *jo_data_held(jo_data *d);               /* (2 nlock) values of the coordinates that optional joints hold */
jo_real *jo_data_rub(jo_data *d);                /* (2 nfriction) friction along the coordinates, on b, N or N m */
double *jo_data_memory(jo_data *d);              /* (nmemory) of the damage meters */
double *jo_data_bent(jo_data *d);                /* (nbeam x 2) at the ends of steps so far: largest rotation between the ends
                                                  * of an element, rad, and largest tension over its limit */
int *jo_data_happened(jo_data *d);               /* (nevent) how often each event has happened */
const double *jo_data_log(const jo_data *d);     /* (logged x 3) of the last jo_run or jo_step: time, event and +1 rising
                                                  * or -1 falling, or nevent + friction and its slip from then on */
int jo_data_logged(const jo_data *d);
jo_real *jo_data_states(const jo_model *m, jo_data *d);    /* (nstate) of forces */
jo_real *jo_data_state_rates(const jo_model *m, jo_data *d);   /* (nstate) of the last evaluation */
jo_real *jo_data_joint(jo_data *d);              /* (nx + nu) joint coordinates and rates, as q and v have them after a call */
jo_counts *jo_data_counts(jo_data *d);
void jo_data_count_turns(const jo_model *m, jo_data *d);   /* angles of the present state are accepted */
int jo_data_error_index(const jo_data *d);       /* body or joint of the last error */

int jo_accelerations(const jo_model *m, jo_data *d);          /* a, lam from time, q, v */
int jo_tree_accelerations(const jo_model *m, jo_data *d);     /* the same by the recursion of a tree, which the model has to have */
int jo_rates(const jo_model *m, jo_data *d, double alpha, double beta, jo_real *qdot);   /* the same with Baumgarte's terms; q' (nq) */
int jo_assemble(const jo_model *m, jo_data *d, int iterations, double tolerance);
int jo_step(const jo_model *m, jo_data *d, const jo_solver *s);
void jo_start_states(const jo_model *m, jo_data *d);      /* states of forces as they are where a run begins at q, v */
void jo_restart(jo_data *d);      /* the state was replaced: what methods and events remember of the last step is forgotten */
void jo_energy(const jo_model *m, jo_data *d, jo_energies *out);
void jo_residuals(const jo_model *m, jo_data *d, jo_real *out);   /* (2) largest |C|, m, and |Cq v|, m/s, rows times their metres */
/* (nrow) m of a unit of each row of C: 1 where it is a length, the size of the mechanism where it is an angle or a cosine */
void jo_row_metres(const jo_model *m, jo_real *out);
void jo_constraints(const jo_model *m, jo_data *d, jo_real *c, jo_real *cdot);   /* (nrow) each */
void jo_mass_matrix(const jo_model *m, jo_data *d, int body, jo_real *M);        /* (6+n)^2, local */
int jo_residual(const jo_model *m, jo_data *d, jo_real *r);     /* (nv) M a + Cq^T lam - Q at time, q, v, a, lam */
/* (nv + nrow)^2 [ca M + cv D + cq K, Cq^T; d(Cq v)], the last with the same weights, at time, q, v, a, lam */
int jo_newton_matrix(const jo_model *m, jo_data *d, double ca, double cv, double cq, jo_real *out);
/* (nnewton) the same as it lies in memory, in the blocks of jo_node and jo_branch */
int jo_newton_values(const jo_model *m, jo_data *d, double ca, double cv, double cq, jo_real *out);
void jo_sensors(const jo_model *m, jo_data *d, jo_real *out);     /* (nout), after jo_accelerations */

/* Advance nsteps; whenever the step count is a multiple of `every` write one row
 * [time q v lam jo_diagnostics sensors states turn locked slip held direction happened input memory
 * joint].
 * `count` holds the steps done before and is advanced, `written` the rows. At an event that stops the run a row more is
 * written there. Does fewer steps when the log of events is full. Returns a jo_status. */
int jo_run(const jo_model *m, jo_data *d, const jo_solver *s, long long nsteps, long long every,
           long long *count, int *written, jo_real *rows);
/* How steps keep time by the watch; s of it. */
typedef struct {
    double step, farthest;     /* between two steps; behind at most: further behind it returns */
    double ahead;              /* until the next step is due, below 0 if that was before: in and out */
    double latest, worst;      /* largest lateness and longest step so far */
    long long missed, done;    /* steps so far that ended after the next one was due; steps of the last call */
} jo_pace;
/* jo_run, at most nsteps, each of them when it is due. Counts in late (nedge + 1) the steps that began late by less than each
 * of the rising edges. Returns after a step in which something happened as well. */
int jo_paced(const jo_model *m, jo_data *d, const jo_solver *s, jo_pace *p, int nsteps, int nedge, const double *edge,
             long long *late, long long every, long long *count, int *written, jo_real *rows);
/* With error control (DOPRI): rows at start + k step, k = *count .. last, from steps of their own length. *count = 0 begins
 * at the present state, which is the first row; later calls go on where the one before stopped. Stops after `tries`
 * steps or `room` rows as well. */
int jo_follow(const jo_model *m, jo_data *d, const jo_solver *s, long long last, long long tries, int room,
              long long *count, int *written, jo_real *rows);
int jo_row(const jo_model *m, jo_data *d, jo_real *row);   /* one such row of the present state */
int jo_row_size(const jo_model *m);

/* Damage meters on their own; memory as said at jo_meter, in a block of n meters one after another. */
double jo_cycle_amplitude(const jo_meter *r, double from, double to);   /* corrected for its mean stress */
double jo_cycle_damage(const jo_meter *r, double from, double to);
void jo_meter_push(const jo_meter *r, double *memory, const double *x, long long count);
void jo_meter_block(const jo_meter *r, double *memory, const double *x, long long count, long long n);   /* x (count x n) */
/* the same and every closed cycle [from to] in `cycles`, room for count / 2; returns how many */
long long jo_meter_trace(const jo_meter *r, double *memory, const double *x, long long count, double *cycles);
/* damage with the residue counted by a jo_residue; scratch (JO_METER + 2 depth + 2) for REPEAT */
double jo_meter_damage(const jo_meter *r, const double *memory, int residue, double *scratch);
void jo_meter_damages(const jo_meter *r, const double *memory, long long n, int residue, double *scratch, double *out);
int jo_meter_valid(const jo_meter *r, const double *memory);   /* whether the memory may be that of such a meter */
/* Count a whole history: cycles (count / 2 x 2) [from to] and where (count / 2 x 2) they were, residue (count) and where
 * (count), its length; count samples, which must be finite. Returns the number of closed cycles. */
long long jo_rainflow(const double *x, long long count, double *cycles, long long *where, double *residue,
                      long long *residue_where, long long *length);

/* Damage on planes (critical_planes.c) through a place: the worst of `turns` lines of shear in each plane, or of the normal stress.
 * Damage of a cycle of shear amplitude a and largest normal stress n in it:
 * FINDLEY: of the S-N curve at 2 (a + k n) / (k + sqrt(1 + k^2)); STRAIN: of ln(1 / N) over ln(a (1 + k n)), a table */
typedef enum { JO_PLANE_NORMAL = 0, JO_PLANE_FINDLEY = 1, JO_PLANE_STRAIN = 2 } jo_plane_kind;
typedef struct {
    int kind;               /* jo_plane_kind */
    int residue;            /* jo_residue */
    double k;
    double p;               /* damage grows at least with this power of the amplitude; 0: unknown */
    long long planes, turns, points;
    const double *rows;     /* (planes x 3 x 6) of stresses 11 22 33 12 23 13: normal stress, shear along two directions */
    const double *turn;     /* (turns x 2) cosine and sine of the lines */
    const double *table;    /* STRAIN: (points) from ln(a) = first on, each by step */
    double first, step;
} jo_planes;
/* s (nt x 6); scratch (6 nt + 4 + planes turns), order (planes turns); damage and place of the worst plane, the first of those that
 * are equal to 1e-9 */
void jo_plane_damage(const jo_planes *r, const jo_meter *curve, const double *s, long long nt, double *scratch,
                     long long *order, double *damage, long long *plane);

/* States of measured channels (channel_health.c); a value is not there or is, with its `cells` saying why, if not */
typedef enum { JO_VALUE_OK = 0, JO_VALUE_DROPOUT = 1, JO_VALUE_NAN = 2, JO_VALUE_SATURATED = 3, JO_VALUE_STUCK = 4,
               JO_VALUE_SPIKE = 5, JO_VALUE_BACK = 6 } jo_value;
/* rows of what is remembered of a channel: last value, last good one, usual step and samples in it, samples of the same value and
 * of those in which others changed, samples at a new level, good samples in a row */
typedef enum { JO_HEALTH_LAST = 0, JO_HEALTH_GOOD = 1, JO_HEALTH_USUAL = 2, JO_HEALTH_SEEN = 3, JO_HEALTH_SAME = 4,
               JO_HEALTH_MOVES = 5, JO_HEALTH_LEVEL = 6, JO_HEALTH_WELL = 7 } jo_health_row;
typedef struct {
    int empty, infinite;    /* numbers in `cells` of nothing there, and of an infinite value */
    double range, stuck, spike, back;   /* magnitude; samples; usual steps, 0: not; samples */
    double follow, warm, persist;       /* share of a step in the usual one; samples */
} jo_health;
/* x, states (count x n), cells too or NULL; memory: n of each jo_health_row; before (n) */
void jo_health_check(const jo_health *r, double *memory, const unsigned char *before, const double *x,
                     const unsigned char *cells, unsigned char *states, long long count, long long n);

/* Stress fields (stress_recovery.c), without a model: p (nt x k), S in tiles of JO_LANES sites, (k x rows x JO_LANES) each, the last
 * one filled up with zeros. */
enum { JO_LANES = 8 };
typedef enum { JO_NORM = 0,             /* scale |rows| */
               JO_WEIGHTED = 1,         /* scale w . rows, w (nt x rows), or their sum */
               JO_SIGNED_MISES = 2,     /* this and below of 6 rows, a tensor 11 22 33 12 23 13 */
               JO_PRINCIPAL_1 = 3, JO_PRINCIPAL_2 = 4, JO_PRINCIPAL_3 = 5,
               JO_SIGNED_PRINCIPAL = 6,
               JO_SHEAR = 7             /* scale (largest - smallest principal value) */
} jo_criterion;
/* out (nt x stride), of which ns columns are written */
void jo_recover(const double *S, long long ns, int rows, int k, const double *p, long long nt, const double *w,
                int criterion, double scale, double *out, long long stride);
/* low, high (ns) become smaller and larger where a value is; low_at, high_at (ns) its instant, counted from `first` */
void jo_recover_extremes(const double *S, long long ns, int rows, int k, const double *p, long long nt, const double *w,
                         int criterion, double scale, long long first, double *low, long long *low_at, double *high,
                         long long *high_at);
/* s (count x 6) -> values (count x 3), the largest first; directions (count x 3 x 3) in columns, or 0 */
void jo_principal(const double *s, long long count, double *values, double *directions);
/* END */

#endif
