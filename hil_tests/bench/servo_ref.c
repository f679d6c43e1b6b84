/* The bare servo step of drivers/emulator/servo/model.py in C: what the arithmetic itself costs.
 *
 *   servo_ref AXES CYCLES C0 .. C22
 *
 * AXES axes with the 23 constants of servo.constants() run CYCLES set values of 64 steps (62.5 us each) along
 * goal = 20 * 16384 * sin(0.004 * cycle); speed limit 100 pi rad/s, stiction 0.36 Nm, Coulomb friction 0.30 Nm.
 * No bus, no telegrams, no state machine.  Prints one JSON line with the CPU seconds and the last position of axis 1, which has to be
 * that of the Python model.
 *
 *   build: -lm
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { MAX_AXES = 64, CONSTANTS = 23, STEPS = 64 };
static const double modulus = 2147483647.0, inc_per_rad = 16384.0 / (2.0 * M_PI), smax = 100.0 * M_PI, fs = 0.36, fc = 0.30;
static double c[CONSTANTS];

struct servo {
    double th, w, tm, tr, it, wr, left, i2t, temp, rng, load, goal, rate;
};

static void plant(struct servo *s)
{
    double d = (s->tr - s->tm) * c[0], x = s->tm + d * c[1] - s->load, v;
    s->tm += d;
    if (s->w > 0.0) {
        v = s->w * c[2] + (x - fc) * c[3];
        if (v < 0.0) v = 0.0;
    } else if (s->w < 0.0) {
        v = s->w * c[2] + (x + fc) * c[3];
        if (v > 0.0) v = 0.0;
    } else if (x > fs) {
        v = (x - fc) * c[3];
    } else if (x < -fs) {
        v = (x + fc) * c[3];
    } else {
        return;
    }
    s->th += (s->w + v) * c[4];
    s->w = v;
}

static void slow(struct servo *s)
{
    double x = s->tm * c[12];
    x *= x;
    s->i2t += (x - s->i2t) * c[13];
    s->temp += (c[15] + c[16] * x - s->temp) * c[14];
    s->rng = fmod(s->rng * 16807.0, modulus);
    s->load = c[18] + (s->rng * (2.0 / modulus) - 1.0) * c[22];
    if (c[19] != 0.0) s->load += c[19] * sin(s->th * c[20] + c[21]);
}

static void position(struct servo *s)
{
    double e;
    s->left -= 1.0;
    e = (s->left > 0.0 ? s->goal - s->rate * s->left : s->goal) - floor(s->th * inc_per_rad);
    s->wr = c[8] * e;
    if (s->wr > smax) s->wr = smax;
    else if (s->wr < -smax) s->wr = -smax;
}

static void speed(struct servo *s)
{
    double e = s->wr - s->w, x = c[5] * e + s->it;
    if (x > c[7]) {
        s->tr = c[7];
        if (e < 0.0) s->it += c[6] * e;
    } else if (x < -c[7]) {
        s->tr = -c[7];
        if (e > 0.0) s->it += c[6] * e;
    } else {
        s->tr = x;
        s->it += c[6] * e;
    }
}

static void cycle(struct servo *s)
{
    for (int k = 1; k <= STEPS; k++) {
        plant(s);
        if (k % 16 == 0) slow(s);
        if (k % 4 == 0) position(s);
        if (k % 2 == 0) speed(s);
    }
}

int main(int argc, char **argv)
{
    static struct servo servo[MAX_AXES];
    int axes = argc > 2 ? atoi(argv[1]) : 0, cycles = argc > 2 ? atoi(argv[2]) : 0;
    struct timespec begin, end;
    if (argc != 3 + CONSTANTS || axes < 1 || axes > MAX_AXES) {
        fprintf(stderr, "usage: servo_ref AXES CYCLES and %d constants\n", CONSTANTS);
        return 2;
    }
    for (int n = 0; n < CONSTANTS; n++) c[n] = atof(argv[3 + n]);
    for (int a = 0; a < axes; a++) {
        servo[a] = (struct servo){.temp = c[15], .rng = 2.0, .load = c[18] + c[19] * sin(c[21])};
    }
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &begin);
    for (int k = 0; k < cycles; k++) {
        double goal = 20.0 * 16384.0 * sin(0.004 * k);
        for (int a = 0; a < axes; a++) {
            struct servo *s = &servo[a];
            double demand = s->left > 0.0 ? s->goal - s->rate * s->left : s->goal;
            cycle((s->goal = goal, s->rate = (goal - demand) / 16.0, s->left = 16.0, s));
        }
    }
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &end);
    printf("{\"cpu_s\": %.9f, \"position_rad\": %.17g}\n", (end.tv_sec - begin.tv_sec) + (end.tv_nsec - begin.tv_nsec) * 1e-9, servo[0].th);
    return 0;
}
