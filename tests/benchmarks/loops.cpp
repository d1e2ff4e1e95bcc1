// The two loops over neighbours of sph/momentum.py, with artificial viscosity and without gradient correction, as a C++ compiler sees them.
// Gradient is the type in which kernel gradients are kept.  `times` repeats a loop inside one call.
#include <algorithm>
#include <cstdint>

template <class Gradient>
static void velocity_gradients(int64_t times, int64_t n, const uint32_t *start, const uint32_t *end, const uint32_t *neighbour,
                               const Gradient *gx, const Gradient *gy, const Gradient *inverse_norm, const double *vx, const double *vy,
                               double speed, double *gradient, double *viscous_x, double *viscous_y) {
    for (int64_t time = 0; time < times; time++)
        for (int64_t i = 0; i < n; i++) {
            const double vx_i = vx[i], vy_i = vy[i];
            double xx = 0, xy = 0, yx = 0, yy = 0, sum_x = 0, sum_y = 0;
            for (uint32_t k = start[i]; k < end[i]; k++) {
                const uint32_t j = neighbour[k];
                const double g_x = gx[k], g_y = gy[k];
                const double dvx = vx[j] - vx_i, dvy = vy[j] - vy_i;
                xx += dvx * g_x;
                xy += dvx * g_y;
                yx += dvy * g_x;
                yy += dvy * g_y;
                const double strength = std::min(dvx * g_x + dvy * g_y, 0.0) * inverse_norm[k];
                sum_x += strength * g_x;
                sum_y += strength * g_y;
            }
            gradient[i] = xx;
            gradient[n + i] = xy;
            gradient[2 * n + i] = yx;
            gradient[3 * n + i] = yy;
            viscous_x[i] = speed * sum_x;
            viscous_y[i] = speed * sum_y;
        }
}

template <class Gradient>
static void stress_accelerations(int64_t times, int64_t n, const uint32_t *start, const uint32_t *end, const uint32_t *neighbour,
                                 const Gradient *gx, const Gradient *gy, const double *total_x, const double *total_y, const double *sxx,
                                 const double *syy, const double *sxy, const double *viscous_x, const double *viscous_y, double *ax,
                                 double *ay) {
    for (int64_t time = 0; time < times; time++)
        for (int64_t i = 0; i < n; i++) {
            double sum_x = sxx[i] * total_x[i] + sxy[i] * total_y[i];
            double sum_y = sxy[i] * total_x[i] + syy[i] * total_y[i];
            for (uint32_t k = start[i]; k < end[i]; k++) {
                const uint32_t j = neighbour[k];
                const double g_x = gx[k], g_y = gy[k];
                sum_x += sxx[j] * g_x + sxy[j] * g_y;
                sum_y += sxy[j] * g_x + syy[j] * g_y;
            }
            ax[i] = sum_x + viscous_x[i];
            ay[i] = sum_y + viscous_y[i];
        }
}

#define FOR(Gradient, name)                                                                                                                \
    void velocity_gradients_##name(int64_t times, int64_t n, const uint32_t *start, const uint32_t *end, const uint32_t *neighbour,        \
                                   const Gradient *gx, const Gradient *gy, const Gradient *inverse_norm, const double *vx,                \
                                   const double *vy, double speed, double *gradient, double *viscous_x, double *viscous_y) {              \
        velocity_gradients(times, n, start, end, neighbour, gx, gy, inverse_norm, vx, vy, speed, gradient, viscous_x, viscous_y);          \
    }                                                                                                                                      \
    void stress_accelerations_##name(int64_t times, int64_t n, const uint32_t *start, const uint32_t *end, const uint32_t *neighbour,      \
                                     const Gradient *gx, const Gradient *gy, const double *total_x, const double *total_y,                \
                                     const double *sxx, const double *syy, const double *sxy, const double *viscous_x,                     \
                                     const double *viscous_y, double *ax, double *ay) {                                                    \
        stress_accelerations(times, n, start, end, neighbour, gx, gy, total_x, total_y, sxx, syy, sxy, viscous_x, viscous_y, ax, ay);      \
    }

extern "C" {
FOR(float, mixed)
FOR(double, double)
}
