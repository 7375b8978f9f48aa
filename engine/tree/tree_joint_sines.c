/* tree_joint_sines.c - sines and cosines of the hinge angles of a tree, four at a time with AVX. */
#include "tree/tree_links.h"

#ifdef JO_PICK
#define JO_MAX_ANGLE 1e5    /* sum of four |angles|, rad, below which n < 2^20 in sines_of_four */

/* Sine and cosine of four angles x = n pi/2 + r, |r| <= pi/4: minimax polynomials (Remez) in z = r^2 with errors below 4e-18.
 * pi/2 is the sum of three parts; n times each of the first two is exact for n < 2^20. */
static void sines_of_four(const jo_real *x, jo_real *sine, jo_real *cosine)
{
    const double large = 6755399441055744.0;   /* 1.5 2^52: adding it rounds a 2/pi to an integer n, which is in the last bits of k */
    const jo_vec a = {x[0], x[1], x[2], x[3]}, k = a * 0.63661977236758134308 + large, n = k - large;
    const jo_vec r = ((a - n * 0x1.921fb544p+0) - n * 0x1.0b4611a6p-34) - n * 0x1.3198a2e037073p-69, z = r * r, w = 1.0 - 0.5 * z;
    const jo_vec p = -0.16666666666666632 + z * (0.008333333333322424 + z * (-0.00019841269829815996
        + z * (2.755731369491824e-06 + z * (-2.505075860776044e-08 + z * 1.5896825414238741e-10))));
    const jo_vec q = 0.0416666666666666 + z * (-0.0013888888888874138 + z * (2.48015872894917e-05
        + z * (-2.755731435518835e-07 + z * (2.087572367544001e-09 + z * -1.1359669330277768e-11))));
    /* s = sin r, c = cos r; odd n exchanges both, bit 1 of n and of n + 1 is the sign of sine and cosine */
    const jo_lane_places s = (jo_lane_places)(r + r * z * p), c = (jo_lane_places)(w + (((1.0 - w) - 0.5 * z) + z * z * q));
    const jo_lane_places whole = (jo_lane_places)k, odd = -(whole & 1);
    const jo_vec y = (jo_vec)(((c & odd) | (s & ~odd)) ^ ((whole & 2) << 62));
    const jo_vec u = (jo_vec)(((s & odd) | (c & ~odd)) ^ (((whole + 1) & 2) << 62));
    for (int i = 0; i < 4; i++) {
        sine[i] = y[i];
        cosine[i] = u[i];
    }
}

/* whether sines_of_four is accurate for the four angles */
static inline int is_moderate(const jo_real *x) { return fabs(x[0]) + fabs(x[1]) + fabs(x[2]) + fabs(x[3]) < JO_MAX_ANGLE; }
#endif

/* sine and cosine of all hinge angles; of larger angles by the C library */
void jo_tree_hinge_sines(const jo_model *m, jo_data *d)
{
    const int *hinge = d->tree.hinge, n = d->tree.nhinge;
    int i = 0;
#ifdef JO_PICK
    for (; i < n; i += 4) {
        jo_real x[4], sine[4], cosine[4];
        const int count = n - i < 4 ? n - i : 4;
        for (int j = 0; j < 4; j++) x[j] = d->x[m->link[hinge[j < count ? i + j : i]].x];
        sines_of_four(x, sine, cosine);
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
    for (; i < n; i++) {
        const jo_real x = d->x[m->link[hinge[i]].x];
        d->tree.link[hinge[i] + 1].sine = jo_sin(x);
        d->tree.link[hinge[i] + 1].cosine = jo_cos(x);
    }
}
