/* Power and logarithm of the C library over many values: the baseline of vfife's own polynomials (laws.py). */
#include <math.h>

void many_powers(const double *x, double n, double *out, long count) {
    for (long k = 0; k < count; k++) out[k] = pow(x[k], n);
}

void many_logarithms(const double *x, double n, double *out, long count) {
    (void)n;
    for (long k = 0; k < count; k++) out[k] = log(x[k]);
}
