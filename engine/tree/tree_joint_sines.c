/* tree_joint_sines.c - sines and cosines of the hinge angles of a tree: with AVX of four hinges at a time, with lanes of one hinge in all
 * machines. */
#include "tree/tree_links.h"

#if defined(JO_PICK)
typedef jo_vec angles;
typedef jo_lane_places angle_bits;
#elif defined(JO_VECTOR)
typedef jo_real angles;
typedef jo_mask angle_bits;
#endif

#if defined(JO_PICK) || defined(JO_VECTOR)
#define JO_MAX_ANGLE 1e5    /* |angle|, with AVX sum of four, rad, below which n < 2^20 in sines_of */

/* Sine and cosine of angles a = n pi/2 + r, |r| <= pi/4: minimax polynomials (Remez) in z = r^2 with errors below 4e-18.
 * pi/2 is the sum of three parts; n times each of the first two is exact for n < 2^20. */
static inline void sines_of(angles a, angles *sine, angles *cosine)
{
    const double large = 6755399441055744.0;   /* 1.5 2^52: adding it rounds a 2/pi to an integer n, which is in the last bits of k */
    const angles k = a * 0.63661977236758134308 + large, n = k - large;
    const angles r = ((a - n * 0x1.921fb544p+0) - n * 0x1.0b4611a6p-34) - n * 0x1.3198a2e037073p-69, z = r * r, w = 1.0 - 0.5 * z;
    const angles p = -0.16666666666666632 + z * (0.008333333333322424 + z * (-0.00019841269829815996
        + z * (2.755731369491824e-06 + z * (-2.505075860776044e-08 + z * 1.5896825414238741e-10))));
    const angles q = 0.0416666666666666 + z * (-0.0013888888888874138 + z * (2.48015872894917e-05
        + z * (-2.755731435518835e-07 + z * (2.087572367544001e-09 + z * -1.1359669330277768e-11))));
    /* s = sin r, c = cos r; odd n exchanges both, bit 1 of n and of n + 1 is the sign of sine and cosine */
    const angle_bits s = (angle_bits)(r + r * z * p), c = (angle_bits)(w + (((1.0 - w) - 0.5 * z) + z * z * q));
    const angle_bits whole = (angle_bits)k, odd = -(whole & 1);
    *sine = (angles)(((c & odd) | (s & ~odd)) ^ ((whole & 2) << 62));
    *cosine = (angles)(((s & odd) | (c & ~odd)) ^ (((whole + 1) & 2) << 62));
}
#endif

#if defined(JO_PICK)
/* whether sines_of is accurate for the four angles */
static inline int is_moderate(const jo_real *x) { return fabs(x[0]) + fabs(x[1]) + fabs(x[2]) + fabs(x[3]) < JO_MAX_ANGLE; }

/* sines and cosines of hinges i .. i + 3, as far as there are */
static inline void four_hinges(const jo_model *m, jo_data *d, int i)
{
    const int *hinge = d->tree.hinge, left = d->tree.nhinge - i, count = left < 4 ? left : 4;
    jo_real x[4];
    for (int j = 0; j < 4; j++) x[j] = d->x[m->link[hinge[j < count ? i + j : i]].x];
    angles sine, cosine;
    sines_of((angles){x[0], x[1], x[2], x[3]}, &sine, &cosine);
    for (int j = 0; j < 4 && !is_moderate(x); j++) {
        sine[j] = jo_sin(x[j]);
        cosine[j] = jo_cos(x[j]);
    }
    for (int j = 0; j < count; j++) {
        jo_link_work *w = &d->tree.link[hinge[i + j] + 1];
        w->sine = sine[j];
        w->cosine = cosine[j];
    }
}
#endif

/* sine and cosine of all hinge angles; of larger angles by the C library */
void jo_tree_hinge_sines(const jo_model *m, jo_data *d)
{
    const int *hinge = d->tree.hinge, n = d->tree.nhinge;
    int i = 0;
#if defined(JO_PICK)
    for (; i < n; i += 4) four_hinges(m, d, i);
#endif
    for (; i < n; i++) {
        const jo_real x = d->x[m->link[hinge[i]].x];
        jo_link_work *w = &d->tree.link[hinge[i] + 1];
#if defined(JO_VECTOR)
        const jo_mask moderate = JO_LESS(jo_magnitude(x), jo_same(JO_MAX_ANGLE));
        sines_of(x, &w->sine, &w->cosine);
        if (jo_every(moderate)) continue;
        w->sine = jo_choose(moderate, w->sine, jo_sin(x));
        w->cosine = jo_choose(moderate, w->cosine, jo_cos(x));
#else
        w->sine = jo_sin(x);
        w->cosine = jo_cos(x);
#endif
    }
}
