/* bands.c - confidence bands of stress: exact for linear criteria; for others from differences along the roots of the covariance or, if the
 * criterion is too nonlinear, from samples. */
#include "bands.h"
#include <math.h>

enum { BATCH = 8 };     /* tensors per call of jo_recover, JO_LANES */
#define DETERMINED 1e-12    /* ratio of remaining variance and variance of a component below which earlier components determine it */

static int roots(const jo_plan *p) { return 6 + p->nerror + (p->scale > 0.0); }

long long jo_band_place(jo_band *b, const jo_plan *p, double *base)
{
    const long long ns = p->nspot, r = roots(p), most = 1 + 2 * r > p->npoint ? 1 + 2 * r : p->npoint;
    double **const all[9] = {&b->value, &b->low, &b->high, &b->spread, &b->root, &b->size, &b->tensors, &b->found, &b->columns};
    const long long counts[9] = {ns, ns, ns, ns, p->linear ? 0 : 36 * ns, ns, 6 * most, most, 6 * r};
    long long at = 0;
    for (int i = 0; i < 9; i++) {
        *all[i] = base ? base + at : 0;
        at += counts[i];
    }
    return at;
}

void jo_band_blind(jo_band *b, const jo_plan *p)
{
    for (int i = 0; i < p->nspot; i++) b->value[i] = b->low[i] = b->high[i] = NAN;
}

/* root (6 x 6, in rows): independent deviations of a covariance, which are its Cholesky columns. Columns of components that earlier
 * components determine to a millionth are 0. */
static void root_of(double A[6][6], double *root)
{
    for (int j = 0; j < 6; j++) {
        double rest = A[j][j];
        for (int l = 0; l < j; l++) rest -= root[6 * l + j] * root[6 * l + j];
        const double own = rest > DETERMINED * A[j][j] ? sqrt(rest) : 0.0;
        for (int i = 0; i < j; i++) root[6 * j + i] = 0.0;
        root[6 * j + j] = own;
        for (int i = j + 1; i < 6; i++) {
            double s = A[i][j];
            for (int l = 0; l < j; l++) s -= root[6 * l + i] * root[6 * l + j];
            root[6 * j + i] = own > 0.0 ? s / own : 0.0;
        }
    }
}

/* spread or roots of the stress covariance S cov S^T + missed at all hot spots */
void jo_band_spread(jo_band *b, const jo_plan *p, const double *cov)
{
    const int n = p->n;
    for (int i = 0; i < p->nspot; i++) {
        const double *S = p->S + (long long)i * (p->linear ? 1 : 6) * n;
        if (p->linear) {
            double variance = 0.0;
            for (int j = 0; j < n; j++) {
                double s = 0.0;
                for (int l = 0; l < n; l++) s += cov[j * n + l] * S[l];
                variance += S[j] * s;
            }
            variance += p->missed[i];
            b->spread[i] = sqrt(variance > 0.0 ? variance : 0.0);
            continue;
        }
        double A[6][6], square = 0.0;
        for (int r = 0; r < 6; r++)
            for (int c = 0; c <= r; c++) {
                double sum = 0.0;
                for (int j = 0; j < n; j++) {
                    double s = 0.0;
                    for (int l = 0; l < n; l++) s += cov[j * n + l] * S[c * n + l];
                    sum += S[r * n + j] * s;
                }
                A[r][c] = A[c][r] = sum + (r == c ? p->missed[6 * i + r] : 0.0);
            }
        root_of(A, b->root + 36 * i);
        for (int c = 0; c < 36; c++) square += b->root[36 * i + c] * b->root[36 * i + c];
        b->size[i] = square;
    }
}

/* out (count) = criterion of tensors (count x 6) */
static void judge(const jo_plan *p, const double *tensors, int count, double *out)
{
    static const double one = 1.0;
    const double a = 0.86602540378443864676, b = 1.7320508075688772935;
    double rows[6 * JO_LANES], found[JO_LANES];
    for (int first = 0; first < count; first += BATCH) {
        const int width = count - first < BATCH ? count - first : BATCH;
        for (int l = 0; l < BATCH; l++) {
            const double *s = tensors + 6 * (first + (l < width ? l : 0));
            if (p->mises) {             /* von Mises stress as the norm of five numbers */
                rows[l] = a * s[0] - a * s[1];
                rows[JO_LANES + l] = -0.5 * s[0] - 0.5 * s[1] + s[2];
                for (int c = 3; c < 6; c++) rows[(c - 1) * JO_LANES + l] = b * s[c];
            } else {
                for (int c = 0; c < 6; c++) rows[c * JO_LANES + l] = s[c];
            }
        }
        jo_recover(rows, BATCH, p->mises ? 5 : 6, 1, &one, 1, 0, p->criterion, p->criterion_scale, found, BATCH);
        for (int l = 0; l < width; l++) out[first + l] = found[l];
    }
}

/* Shell sort in place, gaps 57, 23, 10, 4, 1 (Ciura) */
static void sort(double *x, int count)
{
    for (int gap = 57; gap > 0; gap = gap == 57 ? 23 : gap == 23 ? 10 : gap == 10 ? 4 : gap == 4 ? 1 : 0)
        for (int i = gap; i < count; i++) {
            const double moving = x[i];
            int j = i;
            for (; j >= gap && x[j - gap] > moving; j -= gap) x[j] = x[j - gap];
            x[j] = moving;
        }
}

static double quantile(const double *sorted, int count, double share)
{
    const double at = share * (count - 1), lower = floor(at);
    const int i = (int)lower, j = i + 1 < count ? i + 1 : i;
    return sorted[i] + (sorted[j] - sorted[i]) * (at - lower);
}

/* band of a nonlinear criterion from the quantiles of samples of the distribution */
static void sample(jo_band *b, const jo_plan *p, const double *s, int count, int spot)
{
    for (int i = 0; i < p->npoint; i++)
        for (int c = 0; c < 6; c++) {
            double sum = s[c];
            for (int j = 0; j < count; j++) sum += p->points[(long long)i * count + j] * b->columns[6 * j + c];
            b->tensors[6 * i + c] = sum;
        }
    judge(p, b->tensors, p->npoint, b->found);
    sort(b->found, p->npoint);
    b->low[spot] = quantile(b->found, p->npoint, 0.5 - 0.5 * p->level);
    b->value[spot] = quantile(b->found, p->npoint, 0.5);
    b->high[spot] = quantile(b->found, p->npoint, 0.5 + 0.5 * p->level);
}

/* band of a nonlinear criterion at one hot spot: central differences along the roots, samples if the second differences are large */
static void bent(jo_band *b, const jo_plan *p, int spot, const double *q, const double *moved)
{
    const int n = p->n, count = roots(p), ne = p->nerror;
    const double *S = p->S + (long long)spot * 6 * n;
    double s[6], size = b->size[spot];
    for (int c = 0; c < 36; c++) b->columns[c] = b->root[36 * spot + c];
    for (int c = 0; c < 6; c++) {
        s[c] = 0.0;
        for (int j = 0; j < n; j++) s[c] += S[c * n + j] * q[j];
        for (int e = 0; e < ne; e++) {
            double sum = 0.0;
            for (int j = 0; j < n; j++) sum += S[c * n + j] * moved[j * ne + e];
            b->columns[6 * (6 + e) + c] = sum;
        }
        if (p->scale > 0.0) b->columns[6 * (count - 1) + c] = p->scale * s[c];
    }
    for (int i = 36; i < 6 * count; i++) size += b->columns[i] * b->columns[i];
    size = sqrt(size);
    for (int c = 0; c < 6; c++) {
        b->tensors[c] = s[c];
        for (int j = 0; j < count; j++) {
            b->tensors[6 * (1 + j) + c] = s[c] + b->columns[6 * j + c];
            b->tensors[6 * (1 + count + j) + c] = s[c] - b->columns[6 * j + c];
        }
    }
    judge(p, b->tensors, 1 + 2 * count, b->found);
    double slope = 0.0, both = 0.0;
    for (int j = 0; j < count; j++) {
        const double up = b->found[1 + j], down = b->found[1 + count + j];
        slope += (up - down) * (up - down);
        both += up + down;
    }
    const double spread = 0.5 * p->quantile * sqrt(slope), value = b->found[0];
    b->value[spot] = value;
    b->low[spot] = value - spread;
    b->high[spot] = value + spread;
    if (fabs(0.5 * both - count * value) > p->bent * size) sample(b, p, s, count, spot);
    if (p->floor > 0.0 && b->low[spot] < 0.0) b->low[spot] = 0.0;
}

/* value, low, high at all hot spots; linear: value +- quantile sqrt(variance) */
void jo_band_stress(jo_band *b, const jo_plan *p, const double *q, const double *moved)
{
    const int n = p->n, ne = p->nerror;
    for (int i = 0; i < p->nspot; i++) {
        if (!p->linear) {
            bent(b, p, i, q, moved);
            continue;
        }
        const double *S = p->S + (long long)i * n;
        double value = 0.0;
        for (int j = 0; j < n; j++) value += S[j] * q[j];
        double variance = b->spread[i] * b->spread[i] + p->scale * value * p->scale * value;
        for (int e = 0; e < ne; e++) {
            double s = 0.0;
            for (int j = 0; j < n; j++) s += S[j] * moved[j * ne + e];
            variance += s * s;
        }
        const double spread = p->quantile * sqrt(variance);
        b->value[i] = value;
        b->low[i] = value - spread;
        b->high[i] = value + spread;
    }
}
