/* contact_track.h - a track through markers, the place of a wheel on it, and the forces of their contact. */
#ifndef JO_CONTACT_TRACK_H
#define JO_CONTACT_TRACK_H

#include "dual.h"
#include "force/contact_point.h"

/* a piece: markers, length, tangents and directions of the top in the frames of both markers */
typedef struct { jo_real marker[2], length, tangent[2][3], top[2][3]; } jo_track_piece;
static inline const jo_track_piece *jo_track_pieces(const jo_force *f) { return (const jo_track_piece *)((const jo_contact_track_data *)f->data + 1); }

/* a marker that moves: origin, rotation of its axes, velocity, angular velocity, world */
typedef struct { jo_dual3 r, turn, v, w; const jo_real *A; } jo_track_frame;

/* a piece with its ends in motion, and the tangents L t of both */
typedef struct { const jo_track_piece *piece; jo_track_frame end[2]; jo_dual3 tangent[2]; } jo_track_part;

/* shares of the origins and tangents, and their first and second derivatives with respect to the share x of the way */
typedef struct { jo_dual h[4], g[4], f[4]; } jo_track_shares;

/* place, directions [t, m, n], depth; lever of P from b and from r; velocity of b on the track at P, resolved in [t, m, n]; curvature, 1/m */
typedef struct {
    jo_dual x, depth;
    jo_track_shares s;
    jo_dual3 axis[3], lever, off, v;
    double curvature;
} jo_track_touch;

/* track_curve.c; m NULL: at rest */
jo_track_frame jo_track_frame_of(const jo_model *m, const jo_data *d, int marker);
jo_track_part jo_track_part_of(const jo_model *m, const jo_data *d, const jo_track_piece *piece);
void jo_track_set_tangents(jo_track_part *y);
int jo_track_find(const jo_model *m, const jo_data *d, const jo_track_piece *pieces, int count, const jo_track_frame *b, int guess, jo_dual *x);
jo_track_touch jo_track_touch_at(jo_real radius, const jo_track_part *p, const jo_track_frame *b, jo_real start);
/* y (3): of vectors v, w of the ends and of b, such as velocities, those of b less those of the track at P, resolved in [t, m, n] */
jo_dual3 jo_track_relative(const jo_track_touch *y, const jo_track_part *p, const jo_dual3 *v, const jo_dual3 *w);
/* forces and torques (world) on both ends and on b, for the force F (3), resolved in [t, m, n], changed by dF */
void jo_track_loads(const jo_track_touch *y, const jo_track_part *p, const jo_real *F, const jo_real *dF, jo_dual3 (*load)[2]);
/* to Newton's matrix: loads on both ends and on b, and their changes Y (rows: ends, b; columns: ends, b) */
void jo_track_add_elements(const jo_model *m, jo_data *d, const jo_track_part *p, int b, jo_dual3 (*load)[2], jo_real (*Y)[2][12][24]);

#endif
