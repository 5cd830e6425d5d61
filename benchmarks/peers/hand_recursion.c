/*
 * A peer written by hand: the recursion an engineer would write for trees of hinged rigid bodies, without a
 * generator. It shares nothing with lamc.
 *
 *   planar  articulated elimination for parallel hinges, in absolute angles and world axes
 *   space   articulated-body algorithm (Featherstone 2008, ch. 7) in body-fixed axes, z along the body's hinge
 *
 * Both are O(n), allocate nothing, and take the model as data. Arrays hold one entry per body; a body's inner
 * neighbour (-1: the world) comes before it. q, u and du are in the order of the bodies.
 */
#include <math.h>
#include <string.h>

#define MAX_BODIES 128

/* ------------------------------------------------------------------------------------------- planar */

typedef struct {
    int inner;            /* body on the world's side, -1: world */
    double mass;          /* kg */
    double offset[2];     /* hinge from the inner body's hinge, inner body's axes, m */
    double moment[2];     /* mass times centre of mass from the hinge, body axes, kg m */
    double inertia;       /* about the hinge, kg m^2 */
    double stiffness, damping, preload; /* N m/rad, N m s/rad, N m */
} planar_body;

typedef struct {
    int n;
    double gravity[2]; /* m/s^2 */
    planar_body body[MAX_BODIES];
} planar_model;

void planar_acceleration(const planar_model *model, const double *q, const double *u, double *du)
{
    struct {
        double angle, rate, cosine, sine, ax, ay;
    } k[MAX_BODIES];
    struct {
        double A, bx, by, Cxx, Cxy, Cyy, N, px, py, torque, dx, dy;
    } e[MAX_BODIES];
    double spin_rate[MAX_BODIES], x[MAX_BODIES], y[MAX_BODIES];
    const int n = model->n;

    for (int i = 0; i < n; i++) {
        const planar_body *b = &model->body[i];
        const int p = b->inner;
        double angle = q[i], rate = u[i], dx = b->offset[0], dy = b->offset[1];
        double ax = -model->gravity[0], ay = -model->gravity[1];
        if (p >= 0) {
            angle += k[p].angle;
            rate += k[p].rate;
            dx = k[p].cosine * b->offset[0] - k[p].sine * b->offset[1];
            dy = k[p].sine * b->offset[0] + k[p].cosine * b->offset[1];
            const double w2 = k[p].rate * k[p].rate;
            ax = k[p].ax - w2 * dx;
            ay = k[p].ay - w2 * dy;
        }
        const double c = cos(angle), s = sin(angle);
        k[i].angle = angle;
        k[i].rate = rate;
        k[i].cosine = c;
        k[i].sine = s;
        k[i].ax = ax;
        k[i].ay = ay;
        const double hx = c * b->moment[0] - s * b->moment[1], hy = s * b->moment[0] + c * b->moment[1];
        const double w2 = rate * rate;
        e[i].A = b->inertia;
        e[i].bx = -hy;
        e[i].by = hx;
        e[i].Cxx = e[i].Cyy = b->mass;
        e[i].Cxy = 0.0;
        e[i].px = b->mass * ax - w2 * hx;
        e[i].py = b->mass * ay - w2 * hy;
        e[i].N = hx * ay - hy * ax;
        e[i].torque = b->preload - b->stiffness * q[i] - b->damping * u[i];
        e[i].dx = dx;
        e[i].dy = dy;
    }
    for (int i = n - 1; i >= 0; i--) {
        const int p = model->body[i].inner;
        e[i].A = 1.0 / e[i].A;
        e[i].N = e[i].torque - e[i].N;
        if (p < 0)
            continue;
        const double gx = e[i].bx * e[i].A, gy = e[i].by * e[i].A;
        const double Cxx = e[i].Cxx - gx * e[i].bx, Cxy = e[i].Cxy - gx * e[i].by, Cyy = e[i].Cyy - gy * e[i].by;
        const double px = e[i].px + gx * e[i].N, py = e[i].py + gy * e[i].N;
        const double dx = e[i].dx, dy = e[i].dy;
        const double fx = Cxy * dx - Cxx * dy, fy = Cyy * dx - Cxy * dy; /* C times the turned offset */
        e[p].A += dx * fy - dy * fx;
        e[p].bx += fx;
        e[p].by += fy;
        e[p].Cxx += Cxx;
        e[p].Cxy += Cxy;
        e[p].Cyy += Cyy;
        e[p].px += px;
        e[p].py += py;
        e[p].N += e[i].torque + dx * py - dy * px;
    }
    for (int i = 0; i < n; i++) {
        const int p = model->body[i].inner;
        if (p < 0) {
            x[i] = y[i] = 0.0;
            spin_rate[i] = du[i] = e[i].N * e[i].A;
        } else {
            x[i] = x[p] - spin_rate[p] * e[i].dy;
            y[i] = y[p] + spin_rate[p] * e[i].dx;
            spin_rate[i] = (e[i].N - e[i].bx * x[i] - e[i].by * y[i]) * e[i].A;
            du[i] = spin_rate[i] - spin_rate[p];
        }
    }
}

/* -------------------------------------------------------------------------------------------- space */

typedef struct {
    int inner;
    double mass;        /* kg */
    double turn[9];     /* body axes at zero angle as columns, inner body's axes */
    double offset[3];   /* hinge from the inner body's hinge, inner body's axes, m */
    double moment[3];   /* mass times centre of mass from the hinge, body axes, kg m */
    double inertia[6];  /* about the hinge, body axes, xx yy zz xy xz yz, kg m^2 */
    double stiffness, damping, preload;
} space_body;

typedef struct {
    int n;
    double gravity[3]; /* m/s^2, world axes */
    space_body body[MAX_BODIES];
} space_model;

static inline void cross(const double *a, const double *b, double *c)
{
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

static inline void to_inner(const double *R, const double *v, double *w) /* w = R v */
{
    w[0] = R[0] * v[0] + R[1] * v[1] + R[2] * v[2];
    w[1] = R[3] * v[0] + R[4] * v[1] + R[5] * v[2];
    w[2] = R[6] * v[0] + R[7] * v[1] + R[8] * v[2];
}

static inline void to_outer(const double *R, const double *v, double *w) /* w = R' v */
{
    w[0] = R[0] * v[0] + R[3] * v[1] + R[6] * v[2];
    w[1] = R[1] * v[0] + R[4] * v[1] + R[7] * v[2];
    w[2] = R[2] * v[0] + R[5] * v[1] + R[8] * v[2];
}

static inline void symmetric(const double *S, const double *v, double *w) /* w = S v */
{
    w[0] = S[0] * v[0] + S[3] * v[1] + S[4] * v[2];
    w[1] = S[3] * v[0] + S[1] * v[1] + S[5] * v[2];
    w[2] = S[4] * v[0] + S[5] * v[1] + S[2] * v[2];
}

static inline void turn_matrix(const double *R, const double *B, double *W) /* W = R B R', 3 x 3 */
{
    double T[9];
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++)
            T[3 * r + c] = R[3 * r] * B[c] + R[3 * r + 1] * B[3 + c] + R[3 * r + 2] * B[6 + c];
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++)
            W[3 * r + c] = T[3 * r] * R[3 * c] + T[3 * r + 1] * R[3 * c + 1] + T[3 * r + 2] * R[3 * c + 2];
}

static inline void turn_symmetric(const double *R, const double *S, double *W)
{
    double T[9];
    for (int r = 0; r < 3; r++)
        symmetric(S, R + 3 * r, T + 3 * r); /* T = R S */
    W[0] = T[0] * R[0] + T[1] * R[1] + T[2] * R[2];
    W[1] = T[3] * R[3] + T[4] * R[4] + T[5] * R[5];
    W[2] = T[6] * R[6] + T[7] * R[7] + T[8] * R[8];
    W[3] = T[0] * R[3] + T[1] * R[4] + T[2] * R[5];
    W[4] = T[0] * R[6] + T[1] * R[7] + T[2] * R[8];
    W[5] = T[3] * R[6] + T[4] * R[7] + T[5] * R[8];
}

void space_acceleration(const space_model *model, const double *q, const double *u, double *du)
{
    /* Moments are taken about the body's hinge point: N = A alpha + B a + n, F = B' alpha + C a + f. */
    struct {
        double R[9], spin[3], bias_spin[3], bias[3], A[6], B[9], C[6], N[3], F[3], torque, residual, inverse;
        double g[3], h[3];
    } e[MAX_BODIES];
    double spin_rate[MAX_BODIES][3], acceleration[MAX_BODIES][3];
    const int n = model->n;

    for (int i = 0; i < n; i++) {
        const space_body *b = &model->body[i];
        const int p = b->inner;
        const double c = cos(q[i]), s = sin(q[i]);
        double *R = e[i].R, *w = e[i].spin;
        for (int r = 0; r < 9; r += 3) {
            R[r] = b->turn[r] * c + b->turn[r + 1] * s;
            R[r + 1] = b->turn[r + 1] * c - b->turn[r] * s;
            R[r + 2] = b->turn[r + 2];
        }
        if (p >= 0) {
            double arm[3], turning[3];
            to_outer(R, e[p].spin, w);
            cross(e[p].spin, b->offset, arm);
            cross(e[p].spin, arm, turning);
            to_outer(R, turning, e[i].bias);
        } else {
            memset(w, 0, 3 * sizeof *w);
            memset(e[i].bias, 0, sizeof e[i].bias);
        }
        e[i].bias_spin[0] = w[1] * u[i];
        e[i].bias_spin[1] = -w[0] * u[i];
        e[i].bias_spin[2] = 0.0;
        w[2] += u[i];
        double momentum[3], turning[3];
        symmetric(b->inertia, w, momentum);
        cross(w, momentum, e[i].N);
        cross(w, b->moment, turning);
        cross(w, turning, e[i].F);
        const double *h = b->moment;
        memcpy(e[i].A, b->inertia, sizeof e[i].A);
        const double B[9] = {0.0, -h[2], h[1], h[2], 0.0, -h[0], -h[1], h[0], 0.0};
        memcpy(e[i].B, B, sizeof B);
        e[i].C[0] = e[i].C[1] = e[i].C[2] = b->mass;
        e[i].C[3] = e[i].C[4] = e[i].C[5] = 0.0;
        e[i].torque = b->preload - b->stiffness * q[i] - b->damping * u[i];
    }
    for (int i = n - 1; i >= 0; i--) {
        const space_body *b = &model->body[i];
        const int p = b->inner;
        double *A = e[i].A, *B = e[i].B, *C = e[i].C, *N = e[i].N, *F = e[i].F;
        const double D = 1.0 / A[2], residual = e[i].torque - N[2];
        const double gx = A[4] * D, gy = A[5] * D;
        const double hx = B[6] * D, hy = B[7] * D, hz = B[8] * D;
        e[i].g[0] = gx;
        e[i].g[1] = gy;
        e[i].h[0] = hx;
        e[i].h[1] = hy;
        e[i].h[2] = hz;
        e[i].inverse = D;
        e[i].residual = residual;
        if (p < 0)
            continue;
        const double *cs = e[i].bias_spin, *ca = e[i].bias;
        const double a[6] = {A[0] - gx * A[4], A[1] - gy * A[5], 0.0, A[3] - gx * A[5], 0.0, 0.0};
        const double bb[9] = {B[0] - gx * B[6], B[1] - gx * B[7], B[2] - gx * B[8],
                              B[3] - gy * B[6], B[4] - gy * B[7], B[5] - gy * B[8], 0.0, 0.0, 0.0};
        const double cc[6] = {C[0] - hx * B[6], C[1] - hy * B[7], C[2] - hz * B[8],
                              C[3] - hx * B[7], C[4] - hx * B[8], C[5] - hy * B[8]};
        double Ca[3];
        symmetric(cc, ca, Ca);
        const double moment[3] = {
            N[0] + gx * residual + a[0] * cs[0] + a[3] * cs[1] + bb[0] * ca[0] + bb[1] * ca[1] + bb[2] * ca[2],
            N[1] + gy * residual + a[3] * cs[0] + a[1] * cs[1] + bb[3] * ca[0] + bb[4] * ca[1] + bb[5] * ca[2],
            e[i].torque};
        const double force[3] = {F[0] + hx * residual + bb[0] * cs[0] + bb[3] * cs[1] + Ca[0],
                                 F[1] + hy * residual + bb[1] * cs[0] + bb[4] * cs[1] + Ca[1],
                                 F[2] + hz * residual + bb[2] * cs[0] + bb[5] * cs[1] + Ca[2]};
        double Ap[6], Bp[9], Cp[6], Np[3], Fp[3], Nr[3];
        turn_symmetric(e[i].R, a, Ap);
        turn_matrix(e[i].R, bb, Bp);
        turn_symmetric(e[i].R, cc, Cp);
        to_inner(e[i].R, moment, Np);
        to_inner(e[i].R, force, Fp);
        /* Shift to the inner hinge: K = [d x]; B += K C, A += K B' + (B + K C) K' = K B' - B_new K. */
        const double *d = b->offset;
        const double Cf[9] = {Cp[0], Cp[3], Cp[4], Cp[3], Cp[1], Cp[5], Cp[4], Cp[5], Cp[2]};
        double Bn[9];
        for (int c = 0; c < 3; c++) {
            Bn[c] = Bp[c] + d[1] * Cf[6 + c] - d[2] * Cf[3 + c];
            Bn[3 + c] = Bp[3 + c] + d[2] * Cf[c] - d[0] * Cf[6 + c];
            Bn[6 + c] = Bp[6 + c] + d[0] * Cf[3 + c] - d[1] * Cf[c];
        }
        cross(d, Fp, Nr);
        /* (K B')_rc = (d x B_c.)_r with B_c. row c of B; (B_new K')_rc = (d x Bn_r.)_c. */
        e[p].A[0] += Ap[0] + d[1] * Bp[2] - d[2] * Bp[1] + d[1] * Bn[2] - d[2] * Bn[1];
        e[p].A[1] += Ap[1] + d[2] * Bp[3] - d[0] * Bp[5] + d[2] * Bn[3] - d[0] * Bn[5];
        e[p].A[2] += Ap[2] + d[0] * Bp[7] - d[1] * Bp[6] + d[0] * Bn[7] - d[1] * Bn[6];
        e[p].A[3] += Ap[3] + d[1] * Bp[5] - d[2] * Bp[4] + d[2] * Bn[0] - d[0] * Bn[2];
        e[p].A[4] += Ap[4] + d[1] * Bp[8] - d[2] * Bp[7] + d[0] * Bn[1] - d[1] * Bn[0];
        e[p].A[5] += Ap[5] + d[2] * Bp[6] - d[0] * Bp[8] + d[0] * Bn[4] - d[1] * Bn[3];
        for (int c = 0; c < 9; c++)
            e[p].B[c] += Bn[c];
        for (int c = 0; c < 6; c++)
            e[p].C[c] += Cp[c];
        for (int c = 0; c < 3; c++) {
            e[p].N[c] += Np[c] + Nr[c];
            e[p].F[c] += Fp[c];
        }
    }
    for (int i = 0; i < n; i++) {
        const space_body *b = &model->body[i];
        const int p = b->inner;
        double al[3] = {0.0, 0.0, 0.0}, base[3], a[3];
        if (p >= 0) {
            double arm[3];
            to_outer(e[i].R, spin_rate[p], al);
            cross(spin_rate[p], b->offset, arm);
            for (int c = 0; c < 3; c++)
                base[c] = acceleration[p][c] + arm[c];
        } else {
            for (int c = 0; c < 3; c++)
                base[c] = -model->gravity[c];
        }
        to_outer(e[i].R, base, a);
        for (int c = 0; c < 3; c++) {
            al[c] += e[i].bias_spin[c];
            a[c] += e[i].bias[c];
        }
        du[i] = e[i].residual * e[i].inverse - al[2] - e[i].g[0] * al[0] - e[i].g[1] * al[1] - e[i].h[0] * a[0] -
                e[i].h[1] * a[1] - e[i].h[2] * a[2];
        al[2] += du[i];
        memcpy(spin_rate[i], al, sizeof al);
        memcpy(acceleration[i], a, sizeof a);
    }
}

/* ------------------------------------------------------- Dormand-Prince 5(4) with first same as last */

typedef void (*acceleration_function)(const void *model, const double *q, const double *u, double *du);

static void planar_any(const void *model, const double *q, const double *u, double *du)
{
    planar_acceleration(model, q, u, du);
}

static void space_any(const void *model, const double *q, const double *u, double *du)
{
    space_acceleration(model, q, u, du);
}

static void slope(acceleration_function f, const void *model, int n, const double *y, double *k)
{
    memcpy(k, y + n, (size_t)n * sizeof *k);
    f(model, y, y + n, k + n);
}

/* From y at 0 to t_end, shape (2n,) in place. Steps taken, or -1 when the step underflows. */
static long integrate(acceleration_function f, const void *model, int n, double *y, double t_end, double rtol,
                      double atol)
{
    static const double a[7][6] = {
        {0},
        {1.0 / 5},
        {3.0 / 40, 9.0 / 40},
        {44.0 / 45, -56.0 / 15, 32.0 / 9},
        {19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729},
        {9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656},
        {35.0 / 384, 0.0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84}};
    static const double error[7] = {71.0 / 57600,      0.0,          -71.0 / 16695, 71.0 / 1920,
                                    -17253.0 / 339200, 22.0 / 525.0, -1.0 / 40};
    double k[7][2 * MAX_BODIES], z[2 * MAX_BODIES];
    const int size = 2 * n;
    double t = 0.0, h = 1e-3 * t_end;
    long steps = 0;
    slope(f, model, n, y, k[0]);
    while (t < t_end) {
        if (h < 1e-14 * t_end)
            return -1;
        const double step = t + h > t_end ? t_end - t : h;
        for (int s = 1; s < 7; s++) {
            for (int c = 0; c < size; c++) {
                double sum = 0.0;
                for (int j = 0; j < s; j++)
                    sum += a[s][j] * k[j][c];
                z[c] = y[c] + step * sum;
            }
            slope(f, model, n, z, k[s]);
        }
        double norm = 0.0;
        for (int c = 0; c < size; c++) {
            double sum = 0.0;
            for (int j = 0; j < 7; j++)
                sum += error[j] * k[j][c];
            const double scaled = step * sum / (atol + rtol * fmax(fabs(y[c]), fabs(z[c])));
            norm += scaled * scaled;
        }
        norm = sqrt(norm / size);
        if (norm <= 1.0) {
            t = step < h ? t_end : t + step;
            memcpy(y, z, (size_t)size * sizeof *y);
            memcpy(k[0], k[6], (size_t)size * sizeof *y);
            steps++;
        }
        const double factor = norm > 0.0 ? 0.9 * pow(norm, -0.2) : 5.0;
        h = step * (factor < 0.2 ? 0.2 : factor > 5.0 ? 5.0 : factor);
    }
    return steps;
}

long planar_run(const planar_model *model, double *y, double t_end, double rtol, double atol)
{
    return integrate(planar_any, model, model->n, y, t_end, rtol, atol);
}

long space_run(const space_model *model, double *y, double t_end, double rtol, double atol)
{
    return integrate(space_any, model, model->n, y, t_end, rtol, atol);
}

/* Row by row over states y (count, 2n) -> du (count, n). */
void planar_rows(const planar_model *model, long count, const double *y, double *du)
{
    const int n = model->n;
    for (long r = 0; r < count; r++)
        planar_acceleration(model, y + 2 * n * r, y + 2 * n * r + n, du + n * r);
}

void space_rows(const space_model *model, long count, const double *y, double *du)
{
    const int n = model->n;
    for (long r = 0; r < count; r++)
        space_acceleration(model, y + 2 * n * r, y + 2 * n * r + n, du + n * r);
}
