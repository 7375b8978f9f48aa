/* stress_recovery.c - stress field of a body from its modal coordinates, s = S p, and criteria such as the signed von Mises stress.
 *
 * Sites are stored in tiles of JO_LANES, (k x rows x JO_LANES) each: a tile remains in the first-level cache for all instants, and its sites
 * share vector instructions. The six components are not stored; the criterion is evaluated directly.
 *
 * Numbers are doubles in every build: no function depends on a model.
 */
#include <math.h>

#include "jousto.h"

enum { CHUNK = 64 };   /* instants of one tile at a time */
#define NO_DEVIATOR 1e-150  /* sqrt(J2 / 3), unit of stress, below which the tensor is hydrostatic: its square must not underflow */

/* |sum| / difference of the extreme principal values below which their sum counts as 0, since in pure shear round-off would decide the
 * sign. Near two equal values the cubic equation below is accurate to half of the digits only, 1e-8. */
static const double SUM_ROUNDING = 1e-7;

typedef struct {
    const double *w;   /* (nt x rows) or 0 */
    int criterion;
    double scale;
} rule;

/* acc (rows x JO_LANES) = modes of a tile times p (k) */
static inline void product(const double *restrict S, int rows, int k, const double *restrict p, double acc[6][JO_LANES])
{
    for (int r = 0; r < rows; r++)
        for (int l = 0; l < JO_LANES; l++) acc[r][l] = 0.0;
    for (int j = 0; j < k; j++) {
        const double a = p[j];
        for (int r = 0; r < rows; r++)
            for (int l = 0; l < JO_LANES; l++) acc[r][l] += a * S[(j * rows + r) * JO_LANES + l];
    }
}

/* Principal values of a symmetric tensor, descending, and direction (x, y, z) of the separate one.
 *
 * With the mean m, the deviator D = S - m 1 and q = sqrt(J2 / 3) the roots are m + 2 q cos(theta + 2 pi i / 3),
 * cos(3 theta) = r = det D / (2 q^3). The root x = 2 cos(acos(|r|) / 3) of x^3 - 3 x = 2 |r| differs from the other two
 * by 1.7 or more: three steps of Newton's method give all digits. The other two, which may be close, are those of D in the plane
 * normal to its direction, without loss of digits. end: 1 if the separate value is the largest one, -1 if it is the smallest. */
typedef struct {
    double first[JO_LANES], second[JO_LANES], third[JO_LANES];
    double x[JO_LANES], y[JO_LANES], z[JO_LANES], end[JO_LANES];
} principals;

static void principal(double s[6][JO_LANES], principals *restrict out)
{
    for (int l = 0; l < JO_LANES; l++) {
        const double s11 = s[0][l], s22 = s[1][l], s33 = s[2][l], s12 = s[3][l], s23 = s[4][l], s13 = s[5][l];
        const double m = (s11 + s22 + s33) / 3.0;
        const double d1 = s11 - m, d2 = s22 - m, d3 = s33 - m;
        const double J2 = 0.5 * (d1 * d1 + d2 * d2 + d3 * d3) + s12 * s12 + s23 * s23 + s13 * s13;
        const double q = sqrt(J2 / 3.0);
        const double inverse = q > NO_DEVIATOR ? 1.0 / q : 0.0;
        const double a = d1 * inverse, b = d2 * inverse, c = d3 * inverse;
        const double d = s12 * inverse, e = s23 * inverse, f = s13 * inverse;
        const double det = a * (b * c - e * e) - d * (d * c - e * f) + f * (d * e - b * f);
        const double half = 0.5 * fabs(det);
        const double r = half < 1.0 ? half : 1.0;
        double x = 1.7320508075688772 + 0.2679491924311228 * r;
        for (int i = 0; i < 3; i++) x -= (x * (x * x - 3.0) - 2.0 * r) / (3.0 * (x * x - 1.0));
        const double root = det < 0.0 ? -x : x;

        /* direction: largest cross product of two rows of D - root 1 */
        const double A = a - root, B = b - root, C = c - root;
        const double x0 = B * C - e * e, y0 = e * f - d * C, z0 = d * e - B * f;   /* rows 2 x 3 */
        const double x1 = y0, y1 = A * C - f * f, z1 = d * f - A * e;              /* rows 3 x 1 */
        const double x2 = z0, y2 = z1, z2 = A * B - d * d;                         /* rows 1 x 2 */
        const double n0 = x0 * x0 + y0 * y0 + z0 * z0, n1 = x1 * x1 + y1 * y1 + z1 * z1, n2 = x2 * x2 + y2 * y2 + z2 * z2;
        const int one = n1 > n0, two = n2 > (one ? n1 : n0);
        const double px = two ? x2 : one ? x1 : x0, py = two ? y2 : one ? y1 : y0, pz = two ? z2 : one ? z1 : z0;
        const double norm = two ? n2 : one ? n1 : n0;
        const double unit = norm > 0.0 ? 1.0 / sqrt(norm) : 0.0;
        const double nx = norm > 0.0 ? px * unit : 1.0, ny = py * unit, nz = pz * unit;
        /* u and t normal to the direction */
        const int flat = fabs(nx) > fabs(nz);
        const double ux0 = flat ? -ny : 0.0, uy0 = flat ? nx : -nz, uz0 = flat ? 0.0 : ny;
        const double length = 1.0 / sqrt(ux0 * ux0 + uy0 * uy0 + uz0 * uz0);
        const double ux = ux0 * length, uy = uy0 * length, uz = uz0 * length;
        const double tx = ny * uz - nz * uy, ty = nz * ux - nx * uz, tz = nx * uy - ny * ux;
        const double Dux = a * ux + d * uy + f * uz, Duy = d * ux + b * uy + e * uz, Duz = f * ux + e * uy + c * uz;
        const double Dtx = a * tx + d * ty + f * tz, Dty = d * tx + b * ty + e * tz, Dtz = f * tx + e * ty + c * tz;
        const double uu = ux * Dux + uy * Duy + uz * Duz, tt = tx * Dtx + ty * Dty + tz * Dtz;
        const double ut = ux * Dtx + uy * Dty + uz * Dtz;
        const double middle = 0.5 * (uu + tt), gap = 0.5 * (uu - tt);
        const double radius = sqrt(gap * gap + ut * ut);
        const double high = middle + radius, low = middle - radius;
        out->first[l] = m + q * (det < 0.0 ? high : root);
        out->second[l] = m + q * (det < 0.0 ? low : high);
        out->third[l] = m + q * (det < 0.0 ? root : low);
        out->x[l] = nx;
        out->y[l] = ny;
        out->z[l] = nz;
        out->end[l] = det < 0.0 ? -1.0 : 1.0;
    }
}

/* values (JO_LANES) of rows acc at instant t: their norm or a weighted sum */
static inline void judge_rows(const rule *c, int rows, long long t, double acc[6][JO_LANES], double *restrict out)
{
    if (c->criterion == JO_NORM) {
        for (int l = 0; l < JO_LANES; l++) out[l] = acc[0][l] * acc[0][l];
        for (int r = 1; r < rows; r++)
            for (int l = 0; l < JO_LANES; l++) out[l] += acc[r][l] * acc[r][l];
        for (int l = 0; l < JO_LANES; l++) out[l] = c->scale * sqrt(out[l]);
        return;
    }
    for (int l = 0; l < JO_LANES; l++) out[l] = 0.0;
    for (int r = 0; r < rows; r++) {
        const double w = c->w ? c->w[t * rows + r] : 1.0;
        for (int l = 0; l < JO_LANES; l++) out[l] += w * acc[r][l];
    }
    for (int l = 0; l < JO_LANES; l++) out[l] *= c->scale;
}

/* values (JO_LANES) of tensors acc */
static void judge_tensors(const rule *c, double acc[6][JO_LANES], double *restrict out)
{
    principals of;

    if (c->criterion == JO_SIGNED_MISES) {
        /* sum of the largest and the smallest principal value: 2 m - d2, d2 the middle root of d^3 - J2 d - J3, which decreases
         * between its extremes at -+ sqrt(J2 / 3): the sign follows without the root. x = 2 m + tolerance; the two principal values
         * differ by 1 to 1.16 times the von Mises stress */
        for (int l = 0; l < JO_LANES; l++) {
            const double m = (acc[0][l] + acc[1][l] + acc[2][l]) / 3.0;
            const double d1 = acc[0][l] - m, d2 = acc[1][l] - m, d3 = acc[2][l] - m;
            const double d = acc[3][l], e = acc[4][l], f = acc[5][l];
            const double J2 = 0.5 * (d1 * d1 + d2 * d2 + d3 * d3) + d * d + e * e + f * f;
            const double J3 = d1 * (d2 * d3 - e * e) - d * (d * d3 - e * f) + f * (d * e - d2 * f);
            const double mises = sqrt(3.0 * J2);
            const double x = 2.0 * m + SUM_ROUNDING * mises;
            const int outside = x * x * 3.0 >= J2;
            const int positive = outside ? x >= 0.0 : x * x * x - J2 * x - J3 <= 0.0;
            out[l] = c->scale * (positive ? mises : -mises);
        }
        return;
    }
    principal(acc, &of);
    switch (c->criterion) {
    case JO_PRINCIPAL_1:
        for (int l = 0; l < JO_LANES; l++) out[l] = c->scale * of.first[l];
        break;
    case JO_PRINCIPAL_2:
        for (int l = 0; l < JO_LANES; l++) out[l] = c->scale * of.second[l];
        break;
    case JO_PRINCIPAL_3:
        for (int l = 0; l < JO_LANES; l++) out[l] = c->scale * of.third[l];
        break;
    case JO_SIGNED_PRINCIPAL:
        for (int l = 0; l < JO_LANES; l++) {
            const double zero = SUM_ROUNDING * (of.first[l] - of.third[l]);
            out[l] = c->scale * (of.first[l] + of.third[l] >= -zero ? of.first[l] : of.third[l]);
        }
        break;
    default:   /* JO_SHEAR */
        for (int l = 0; l < JO_LANES; l++) out[l] = c->scale * (of.first[l] - of.third[l]);
        break;
    }
}

/* values of one tile; callers pass `rows` as a constant, so that the compiler keeps the sums in registers */
static inline void instants(const double *S, int rows, int k, const double *p, long long t, int count, const rule *c,
                            double out[CHUNK][JO_LANES])
{
    double acc[6][JO_LANES];

    for (int i = 0; i < count; i++) {
        product(S, rows, k, p + (t + i) * k, acc);
        if (rows < 6 || c->criterion <= JO_WEIGHTED) judge_rows(c, rows, t + i, acc, out[i]);
        else judge_tensors(c, acc, out[i]);
    }
}

/* values of one tile at instants t .. t + count - 1 */
static void tile(const double *S, int rows, int k, const double *p, long long t, int count, const rule *c,
                 double out[CHUNK][JO_LANES])
{
    switch (rows) {
    case 1: instants(S, 1, k, p, t, count, c, out); break;
    case 2: instants(S, 2, k, p, t, count, c, out); break;
    case 3: instants(S, 3, k, p, t, count, c, out); break;
    case 4: instants(S, 4, k, p, t, count, c, out); break;
    case 5: instants(S, 5, k, p, t, count, c, out); break;
    default: instants(S, 6, k, p, t, count, c, out); break;
    }
}

static int lesser(long long a, long long b) { return (int)(a < b ? a : b); }

/* criterion at all sites and instants, tile by tile and CHUNK instants at a time */
void jo_recover(const double *S, long long ns, int rows, int k, const double *p, long long nt, const double *w,
                int criterion, double scale, double *out, long long stride)
{
    const rule c = { w, criterion, scale };
    const long long size = (long long)k * rows * JO_LANES;
    double values[CHUNK][JO_LANES];

    for (long long t = 0; t < nt; t += CHUNK) {
        const int count = lesser(CHUNK, nt - t);
        for (long long s = 0; s < ns; s += JO_LANES) {
            const int width = lesser(JO_LANES, ns - s);
            tile(S + s / JO_LANES * size, rows, k, p, t, count, &c, values);
            for (int i = 0; i < count; i++)
                for (int l = 0; l < width; l++) out[(t + i) * stride + s + l] = values[i][l];
        }
    }
}

/* extremes of the criterion over the instants at all sites, and their instants */
void jo_recover_extremes(const double *S, long long ns, int rows, int k, const double *p, long long nt, const double *w,
                         int criterion, double scale, long long first, double *low, long long *low_at, double *high,
                         long long *high_at)
{
    const rule c = { w, criterion, scale };
    const long long size = (long long)k * rows * JO_LANES;
    double values[CHUNK][JO_LANES];

    for (long long t = 0; t < nt; t += CHUNK) {
        const int count = lesser(CHUNK, nt - t);
        for (long long s = 0; s < ns; s += JO_LANES) {
            const int width = lesser(JO_LANES, ns - s);
            tile(S + s / JO_LANES * size, rows, k, p, t, count, &c, values);
            for (int l = 0; l < width; l++) {
                double least = low[s + l], most = high[s + l];
                int at = -1, up = -1;
                for (int i = 0; i < count; i++) {
                    const double x = values[i][l];
                    if (x < least) least = x, at = i;
                    if (x > most) most = x, up = i;
                }
                if (at >= 0) low[s + l] = least, low_at[s + l] = first + t + at;
                if (up >= 0) high[s + l] = most, high_at[s + l] = first + t + up;
            }
        }
    }
}

void jo_principal(const double *s, long long count, double *values, double *directions)
{
    double tensors[6][JO_LANES];
    principals of;

    for (long long i = 0; i < count; i++, s += 6) {
        double *value = values + 3 * i;
        const int l = (int)(i % JO_LANES);
        if (l == 0) {   /* next JO_LANES tensors; the last tensor fills the remaining lanes */
            const int more = lesser(JO_LANES, count - i);
            for (int j = 0; j < JO_LANES; j++)
                for (int r = 0; r < 6; r++) tensors[r][j] = s[6 * (j < more ? j : more - 1) + r];
            principal(tensors, &of);
        }
        value[0] = of.first[l];
        value[1] = of.second[l];
        value[2] = of.third[l];
        if (!directions) continue;
        /* separate value, and the directions of the other two in the plane normal to its direction */
        const int apart = of.end[l] > 0.0 ? 0 : 2;
        const double n[3] = { of.x[l], of.y[l], of.z[l] };
        const int flat = fabs(n[0]) > fabs(n[2]);
        double u[3] = { flat ? -n[1] : 0.0, flat ? n[0] : -n[2], flat ? 0.0 : n[1] };
        const double length = sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
        for (int j = 0; j < 3; j++) u[j] /= length;
        const double t[3] = { n[1] * u[2] - n[2] * u[1], n[2] * u[0] - n[0] * u[2], n[0] * u[1] - n[1] * u[0] };
        const double Su[3] = { s[0] * u[0] + s[3] * u[1] + s[5] * u[2], s[3] * u[0] + s[1] * u[1] + s[4] * u[2],
                               s[5] * u[0] + s[4] * u[1] + s[2] * u[2] };
        const double St[3] = { s[0] * t[0] + s[3] * t[1] + s[5] * t[2], s[3] * t[0] + s[1] * t[1] + s[4] * t[2],
                               s[5] * t[0] + s[4] * t[1] + s[2] * t[2] };
        const double uu = u[0] * Su[0] + u[1] * Su[1] + u[2] * Su[2], tt = t[0] * St[0] + t[1] * St[1] + t[2] * St[2];
        const double ut = u[0] * St[0] + u[1] * St[1] + u[2] * St[2];
        const double angle = 0.5 * atan2(2.0 * ut, uu - tt), cosine = cos(angle), sine = sin(angle);
        double *N = directions + 9 * i;   /* row-major; column j belongs to value j */
        for (int j = 0; j < 3; j++) {
            const double high = cosine * u[j] + sine * t[j], low = cosine * t[j] - sine * u[j];
            N[3 * j] = apart == 0 ? n[j] : high;
            N[3 * j + 1] = apart == 0 ? high : low;
            N[3 * j + 2] = apart == 0 ? low : n[j];
        }
    }
}
